"""Stored results against the CF conventions, by the IOOS compliance checker."""

from functools import partial
from pathlib import Path

import pytest

import jointplay as jp
from jointplay.results import provenance
from jointplay.results.store import write_result

runner = pytest.importorskip("compliance_checker.runner", reason="needs compliance-checker: the extra cf")

# It subtracts neighbouring values of every coordinate, also of texts: an error of its own.
OWN_FAULT = "check_coordinate_variables_strict_monotonicity"
# CF 3.3 leaves standard_name open; the table's `time` is a date since an epoch, which a model's time is not.
NO_DATE = "Coordinate variable 'time' should have standard_name='time', found: 'None'"
PAPER = Path(__file__).parents[2] / "results" / "paper"
START = {"mechanism": jp.catalog.impact_pair(3.6, 0.8), "initial": (0.0, 0.5)}
MADE = {
    "response": lambda: jp.simulate(turns=3, section=jp.ContactSection(), **START),
    "section": lambda: jp.poincare(turns=3, **START),
    "orbit": lambda: jp.periodic_orbit(transient=50, **START),
    "diagram": lambda: jp.bifurcation(over={"gap": [3.5, 3.6]}, turns=4, transient=4, n_jobs=1, **START),
    "exponents": lambda: jp.lyapunov(turns=40, transient=10, **START),
    "spectrum": lambda: jp.spectrum(turns=16, quantity="y", **START),
    **{
        name: partial(jp.open, PAPER / f"{name}.nc")
        for name in ("fig03a", "fig12c", "claims", "readings", "scheme_comparison")
    },
}


def failed(path):
    """What the checker finds wrong, each message once."""
    runner.CheckSuite.load_all_available_checkers()
    suite = runner.CheckSuite()
    results, errors = suite.run_all(suite.load_dataset(str(path)), ["cf:1.11"], skip_checks=[OWN_FAULT])[
        "cf:1.11"
    ]
    assert not errors
    assert len(results) > 10
    whole = [each for each in results if each.value is not True and each.value[0] != each.value[1]]
    return {message for each in whole for message in each.msgs}


def stored(dataset, path):
    return write_result(
        provenance.attach(dataset.assign_attrs(title="of a test"), {"name": "test"}, ""), path
    )


@pytest.mark.parametrize("kind", MADE)
def test_a_result_keeps_to_the_conventions(kind, tmp_path):
    dataset = MADE[kind]()
    timed = "time" in dataset.indexes
    assert failed(stored(dataset, tmp_path / "result.nc")) == ({NO_DATE} if timed else set())


def test_what_does_not_keep_to_them_is_found(tmp_path):
    wrong = MADE["response"]()
    wrong["event_time"].attrs["units"] = "seconds and more"
    del wrong.attrs["Conventions"]
    found = failed(stored(wrong, tmp_path / "result.nc"))
    assert any("Conventions" in each for each in found)
    assert any("seconds and more" in each for each in found)
