"""A crank of imposed speed that turns at one value of a sweep and cannot turn at another."""

import numpy as np
import pytest

import jointplay as jp
from jointplay.analysis.quantities import STATUS
from jointplay.study.results.outcome import explain

PIVOT = "joints.C.bearing.point[0]"
DRIVE = {"kind": "speed", "link": "crank", "speed": 20.0}


def rocking(**more):
    """A four-bar of 30, 181 and 117.5 mm, whose crank turns where its pivot is at most 268.5 mm away."""
    return jp.catalog.chunmei2002(drive=DRIVE, **more)


@pytest.mark.parametrize("clearance", [0.0, 2.9e-5])
@pytest.mark.parametrize("ensemble", [False, True])
def test_a_cell_of_a_diagram_whose_crank_cannot_turn_is_refused_with_the_angles(clearance, ensemble):
    how = {"direction": "reset", "turns": 4, "transient": 0, "ensemble": ensemble and clearance > 0}
    found = jp.bifurcation(rocking(clearance=clearance), over={PIVOT: [0.2, 0.29]}, **how)
    assert [STATUS[code] for code in found.cell_status.values.ravel()] == ["ok", "bad_parameters"]
    assert "does not close at angles of crank from" in str(found.trouble.values[1, 0])
    assert "does not close at angles of crank from" in explain(found)


def test_a_slider_crank_whose_rod_becomes_too_short_is_refused_in_its_cell():
    found = jp.bifurcation(
        jp.catalog.slider_crank(clearance=0.0),
        over={"links.rod.length + joints.B.journal.at": [0.045, 0.12]},
        direction="reset",
        turns=4,
        transient=0,
    )
    assert [STATUS[code] for code in found.cell_status.values.ravel()] == ["bad_parameters", "ok"]


def test_samples_whose_crank_cannot_turn_fail_and_say_why():
    spread = {PIVOT: {"uniform": [0.26, 0.28]}}
    how = {"samples": 8, "turns": 4, "transient": 0, "events": [], "of": ["turn_period"], "n_jobs": 1}
    found = jp.tolerances(rocking(clearance=0.0), spreads=spread, **how)
    value = found["value"].values.ravel()
    stuck = value > 0.181 + 0.1175 - 0.03
    assert 0 < stuck.sum() < 8
    assert np.all((found.sample_status.values == STATUS.index("bad_parameters")) == stuck)
    assert "does not close at angles of crank from" in explain(found)
