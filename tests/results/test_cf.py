"""Stored results against the CF conventions, by the IOOS compliance checker."""

import re
from pathlib import Path

import pytest

import jointplay as jp
from jointplay.kinds import KINDS
from jointplay.study.results import provenance
from jointplay.study.results.store import write_result
from tests.fuzz.calls import CALLS, PAIR

pytestmark = pytest.mark.peer
runner = pytest.importorskip("compliance_checker.runner", reason="needs compliance-checker: the extra cf")

# It subtracts neighbouring values of every coordinate, also of texts: an error of its own.
OWN_FAULT = "check_coordinate_variables_strict_monotonicity"
# CF 4.4 leaves standard_name open; the checker asks every dimension called `time` for it (its issue 1245).
NO_DATE = "Coordinate variable 'time' should have standard_name='time', found: 'None'"
# With the name, CF 4.4.1 asks for units since a date, and readers would show a motion's seconds as dates.
DATED = (
    "time must be in a valid units format <unit> since <epoch> not s",
    "time does not have correct time units",
)
PAPER = Path(__file__).parents[2] / "results" / "paper"
MADE = {  # more of some kinds than a call that is right
    "response": {"mechanism": PAIR, "initial": (0.0, 0.5), "turns": 3, "section": jp.ContactSection()},
    "periodic_orbit": {"mechanism": PAIR, "transient": 50},
    "lyapunov": {"mechanism": PAIR, "turns": 40, "transient": 10},
    "spectrum": {"mechanism": PAIR, "turns": 16, "quantity": "y"},
    "benchmark": {"mechanism": jp.catalog.ivp_crank(), "rtol": 1e-6},
    "stress": {"scenes": 1, "variants": ["rigid"], "turns": 1},
}
STORED = ("fig03a", "fig12c", "claims", "readings", "scheme_comparison")
SLOW = ("assess", "tipping")
COMPUTED = [
    pytest.param(kind, marks=[pytest.mark.nightly] * (kind in SLOW)) for kind in KINDS if kind not in STORED
]


def failed(path):
    """What the checker finds wrong by CF 1.11, and newer ones that it knows; each message once."""
    runner.CheckSuite.load_all_available_checkers()
    suite = runner.CheckSuite()
    known = [name for name in suite.checkers if re.fullmatch(r"cf:1\.(1[1-9]|[2-9]\d)", name)]
    assert "cf:1.11" in known
    found, wrong = suite.run_all(suite.load_dataset(str(path)), known, skip_checks=[OWN_FAULT]), set()
    for results, errors in found.values():
        assert not errors
        assert len(results) > 10
        whole = [each for each in results if each.value is not True and each.value[0] != each.value[1]]
        wrong |= {message for each in whole for message in each.msgs}
    return wrong


def stored(dataset, path):
    return write_result(
        provenance.attach(dataset.assign_attrs(title="of a test"), {"name": "test"}, ""), path
    )


def made(kind):
    function = KINDS[kind].function
    return function(**MADE.get(kind, CALLS[function.__name__]))


def kept(dataset, path):
    assert failed(stored(dataset, path / "result.nc")) <= {NO_DATE}


@pytest.mark.nightly
@pytest.mark.parametrize("kind", COMPUTED)
def test_a_result_of_each_kind_keeps_to_the_conventions(kind, tmp_path):
    kept(made(kind), tmp_path)


@pytest.mark.parametrize("name", STORED)
def test_a_stored_result_keeps_to_the_conventions(name, tmp_path):
    kept(jp.open(PAPER / f"{name}.nc"), tmp_path)


def test_a_motions_time_has_no_standard_name_since_that_is_kept_for_dates(tmp_path):
    named = made("response")
    named["time"].attrs["standard_name"] = "time"
    assert failed(stored(named, tmp_path / "result.nc")) >= {*DATED}


def test_what_does_not_keep_to_them_is_found(tmp_path):
    wrong = made("response")
    wrong["event_time"].attrs["units"] = "seconds and more"
    del wrong.attrs["Conventions"]
    found = failed(stored(wrong, tmp_path / "result.nc"))
    assert any("Conventions" in each for each in found)
    assert any("seconds and more" in each for each in found)
