"""Studies of exponents, 0-1 test, spectrum and dimension: what a file says reaches the function."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from jointplay.analysis.quantities import STATUS
from jointplay.kinds import KINDS
from jointplay.study import run
from jointplay.study.file import Loaded, load, validate
from jointplay.study.toml_text import override, parse
from tests.support.wrong import problems_of

STUDIES = sorted((Path(__file__).parents[2] / "studies" / "chaos").glob("*_12[abc].toml"))
OWN = {  # what only this kind has
    "lyapunov": {
        "exponents": 2,
        "turns": 4,
        "twin_turns": 3,
        "saltation": False,
        "error": 0.5,
        "transient": 1,
    },
    "covariant": {"exponents": 2, "turns": 4, "transient": 1, "settling": 2},
    "chaos_test": {"quantity": "v", "turns": 120, "every": 1, "frequencies": 7, "seed": 3, "tolerance": 1e-3},
    "spectrum": {"quantity": "v", "turns": 8, "samples_per_turn": 32, "segments": 3, "window": "boxcar"},
    "dimension": {"quantities": ["v", "y"], "turns": 150, "window": 4, "shares": [1e-3, 1e-1]},
}


def study(kind, **changes):
    return {"kind": kind, "name": "x", "mechanism": {"catalog": "duffing"}, "analysis": OWN[kind] | changes}


def problems(table):
    """Keys of the problems."""
    return problems_of(validate, table).keys()


@pytest.mark.parametrize("kind", OWN)
def test_every_keyword_reaches_the_function(kind):
    table = study(kind, initial=[0.3, 0.2])
    record = validate(table)
    keywords = record.keywords()
    for key, value in OWN[kind].items():
        assert keywords[key] == (tuple(value) if isinstance(value, list) else value)
    assert keywords["initial"] == (0.3, 0.2)


@pytest.mark.parametrize("kind", OWN)
def test_a_study_runs(kind):
    found = run.run(Loaded(validate(study(kind)), "text"))
    assert found.attrs["kind"] == kind
    assert found.attrs["study"] == "x"
    assert STATUS[int(found.status)] == "ok"


def test_what_is_asked_for_is_done():
    found = run.run(Loaded(validate(study("chaos_test")), ""))
    assert (found.sizes["test_frequency"], found.sizes["turn"]) == (7, 120)
    assert np.isfinite(found.chaos_indicator).all()
    exponents = run.run(Loaded(validate(study("lyapunov", exponents="all")), ""))
    assert exponents.sizes["exponent"] == 2
    assert np.isfinite(exponents.growth)


@pytest.mark.parametrize(
    ("kind", "changes", "keys"),
    [
        ("lyapunov", {"exponents": 3}, {"analysis.exponents"}),
        ("lyapunov", {"exponents": "some"}, {"analysis.exponents"}),
        ("covariant", {"exponents": 3}, {"analysis.exponents"}),
        ("covariant", {"settling": 0}, {"analysis.settling"}),
        ("lyapunov", {"twin_turns": -1, "error": 0.0}, {"analysis.twin_turns", "analysis.error"}),
        ("lyapunov", {"duration": 1.0}, {"analysis.turns"}),
        ("lyapunov", {"record": ["y"], "section": {}}, {"analysis.record", "analysis.section"}),
        ("chaos_test", {"quantity": "w", "initial": [1.0]}, {"analysis.quantity", "analysis.initial"}),
        ("chaos_test", {"duration": 1.0, "tolerance": 1.0}, {"analysis.duration", "analysis.tolerance"}),
        ("spectrum", {"window": "haan", "quantity": "w"}, {"analysis.window", "analysis.quantity"}),
        (
            "dimension",
            {"quantities": ["w"], "shares": [0.1, 0.01]},
            {"analysis.quantities[0]", "analysis.shares"},
        ),
    ],
)
def test_every_mistake_is_told_with_its_place(kind, changes, keys):
    assert problems(study(kind, **changes)) == keys


@pytest.mark.parametrize("kind", OWN)
def test_a_figure_of_another_kind_is_refused(kind):
    other = next(name for name in OWN if name != kind)
    assert problems(study(kind) | {"figure": {"kind": other}}) == {"figure.kind"}
    assert validate(study(kind) | {"figure": {"kind": kind}}).figure == {"kind": kind}


def test_length_in_words():
    assert "chaos_test, 120 section points\n" in validate(study("chaos_test")).summary()
    assert "4 turns after 1 dropped turn\n" in validate(study("lyapunov")).summary()


@pytest.mark.parametrize("path", STUDIES, ids=lambda path: path.stem)
def test_shipped_studies_are_of_the_paper_s_panels(path):
    record = load(path).record
    clearance, ratio = {"a": (2.9e-5, 15.0), "b": (2.9e-5, 3.0), "c": (2.9e-4, 3.0)}[path.stem[-1]]
    assert record.kind in OWN
    assert record.kind in KINDS
    assert record.mechanism.joint("B").clearance == clearance
    assert record.mechanism.drive.gear_ratio == ratio
    if record.kind == "lyapunov":
        assert record.analysis.exponents == "all"
        assert record.analysis.twin_turns


def test_a_shipped_study_runs_when_it_is_shorter():
    text = next(path for path in STUDIES if path.stem == "exponents_12c").read_text()
    short = override(parse(text), ["analysis.turns=5", "analysis.transient=2", "analysis.twin_turns=3"])
    found = run.run(Loaded(validate({"name": "short"} | short), text))
    assert found.sizes["exponent"] == 6
    assert np.isfinite(found.growth)
