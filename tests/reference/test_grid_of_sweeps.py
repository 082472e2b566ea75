"""Sweeps with an exponent over every law of contact and of friction, at bearings and at guides."""

from __future__ import annotations

import numpy as np
import pytest

import jointplay as jp
from jointplay.solver.equations.laws import LAWS
from jointplay.solver.method.codes import Status
from tests.support.laws_grid import FRICTION, GUIDED, PAIRS, ROUND, mechanism

pytestmark = pytest.mark.nightly
VALUES = {"four_bar": (2.0e-4, 2.9e-4, 4.0e-4), "guide": (0.8e-4, 1.0e-4, 1.3e-4)}  # m, of clearance
HOW = {"turns": 1, "transient": 0, "lyapunov_turns": 2, "exponents": 1, "rtol": 1e-7}
HOW |= {"direction": "reset", "ensemble": False, "n_jobs": 1}
CELLS = [(scene, *pair, False) for scene, pairs in (("four_bar", PAIRS), ("guide", GUIDED)) for pair in pairs]
CELLS += [("four_bar", *PAIRS[i], True) for i in (1, 3, 4, 7)]  # beside an elastic link
CELLS += [("guide", *PAIRS[i], True) for i in (0, 2)]
TOGETHER = ("guide", "restitution")  # two corners land at once: a motion beside it has other impacts


def test_every_law_is_in_the_grid():
    """At either kind of joint, those of cylinders at bearings alone."""
    for scene, lacking in (("four_bar", ()), ("guide", ROUND)):
        assert {normal for kind, normal, *_ in CELLS if kind == scene} == {*LAWS} - {*lacking}
        assert {rub for kind, _, rub, _ in CELLS if kind == scene} == {*FRICTION}


@pytest.mark.parametrize(("scene", "normal", "friction", "elastic"), CELLS)
def test_a_sweep_gives_the_exponents_of_its_cells(scene, normal, friction, elastic):
    made, values = mechanism(scene, normal, friction, elastic), VALUES[scene]
    key = "joints.G.clearance" if scene == "guide" else "clearance"
    swept = jp.bifurcation(made, over={key: values}, **HOW)
    if (scene, normal) == TOGETHER:
        assert (swept.cell_status == Status.NO_DERIVATIVE).all()
        return
    assert (swept.cell_status == 0).all()
    found = swept.lyapunov_exponent.squeeze().values
    assert not np.isnan(found).any()
    assert len({*found.tolist()}) == 3  # the parameter is one
    for value, exponent in zip(values, found, strict=True):
        alone = jp.bifurcation(made, over={key: [value]}, **HOW)
        assert float(alone.lyapunov_exponent.squeeze()) == pytest.approx(exponent, rel=1e-9)
