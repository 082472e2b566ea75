"""Friction by tanh: against Lagrange's equations, without sticking, and Coulomb's in the limit."""

from __future__ import annotations

import numpy as np
import pytest

from jointplay.solver.method.modes import STICKS
from tests.support.plain import plain, text

from .both import bent_pair, bent_state, point

SMOOTH = 3.0


@pytest.mark.parametrize("links", ["", "coupler"])
def test_accelerations_and_forces(links):
    system, model = bent_pair("B", links, smooth=SMOOTH)
    for seed in range(4):
        y = bent_state(system, seed)
        here = point(system, model, y, ["contact"])
        theirs = system.rate(y, {"B": "contact"})
        assert np.abs(here.rate() - theirs[:, None]).max() < 1e-11 * np.abs(theirs).max()
        _, _, v_t, F_n, F_t, creep = here.contacts()[0]
        assert F_t == pytest.approx(system.p.f * F_n * np.tanh(v_t / SMOOTH) + system.p.C_t * v_t, rel=1e-12)
        assert creep == pytest.approx(system.forces(y, {"B": "contact"})[2]["B"], rel=1e-9)


def test_nothing_sticks():
    _, model = bent_pair("B", "", smooth=SMOOTH)
    assert plain(model.structure).CONTACTS["B"] & STICKS == 0
    assert "variant == 2" not in text(model.structure)
    assert "variant == 2" in text(bent_pair("B", "")[1].structure)


@pytest.mark.parametrize("smooth", [1.0, 0.3, 0.1])
def test_coulomb_in_the_limit(smooth):
    """1 - tanh x lies between exp(-2x) and twice that."""
    _, sharp = bent_pair("B", "")
    system, model = bent_pair("B", "", smooth=smooth)
    for seed in range(6):
        y = bent_state(system, seed)
        _, _, v_t, F_n, smoothed, _ = point(system, model, y, ["contact"]).contacts()[0]
        mode = "slip+" if v_t > 0 else "slip-"
        coulomb = point(system, sharp, y, [mode]).contacts()[0, 4]
        least, rounding = system.p.f * abs(F_n) * np.exp(-2 * abs(v_t) / smooth), 1e-12 * abs(F_n)
        assert least - rounding <= abs(smoothed - coulomb) <= 2 * least + rounding
