"""Friction by tanh: against free bodies, without sticking, and Coulomb's in the limit."""

from __future__ import annotations

import numpy as np
import pytest

from jointplay.solver.method.modes import STICKS
from tests.support.plain import plain, text

from ..reference.four_bar import by_name, scattered
from .both import accelerations, pair, point

SMOOTH = 3.0


@pytest.mark.parametrize("links", ["", "coupler"])
def test_accelerations_and_forces(links):
    system, model = pair("B", links, smooth=SMOOTH, C_t=1.5)
    for seed in range(4):
        y = scattered(system, seed)
        here, theirs = point(system, model, y, ["contact"]), accelerations(system, y, {"B": "closed"})
        assert np.abs(here.rate() - theirs[:, None]).max() < 1e-11 * np.abs(theirs).max()
        _, _, v_t, F_n, F_t, creep = here.contacts()[0]
        assert F_t == pytest.approx(system.p.f * F_n * np.tanh(v_t / SMOOTH) + system.p.C_t * v_t, rel=1e-12)
        assert creep == pytest.approx(by_name(system.at_modes(y, {"B": "closed"}))[1]["B"], rel=1e-9)


def test_nothing_sticks():
    _, model = pair("B", smooth=SMOOTH)
    assert plain(model.structure).CONTACTS["B"] & STICKS == 0
    assert "variant == 2" not in text(model.structure)
    assert "variant == 2" in text(pair("B")[1].structure)


@pytest.mark.parametrize("smooth", [1.0, 0.3, 0.1])
def test_coulomb_in_the_limit(smooth):
    """1 - tanh x lies between exp(-2x) and twice that."""
    _, sharp = pair("B", C_t=1.5)
    system, model = pair("B", smooth=smooth, C_t=1.5)
    for seed in range(6):
        y = scattered(system, seed)
        _, _, v_t, F_n, smoothed, _ = point(system, model, y, ["contact"]).contacts()[0]
        mode = "slip+" if v_t > 0 else "slip-"
        coulomb = point(system, sharp, y, [mode]).contacts()[0, 4]
        least, rounding = system.p.f * abs(F_n) * np.exp(-2 * abs(v_t) / smooth), 1e-12 * abs(F_n)
        assert least - rounding <= abs(smoothed - coulomb) <= 2 * least + rounding
