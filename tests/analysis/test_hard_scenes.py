"""Scenes far from ordinary use that once lost an event, or met one that is not there."""

from __future__ import annotations

import numpy as np
import pytest

from jointplay import catalog
from jointplay.analysis.quantities import Quantities
from jointplay.analysis.run import Request, follow
from jointplay.analysis.stress.scenes import draw
from jointplay.analysis.words import STATUS
from jointplay.mechanism.assemble import assemble
from jointplay.numerics.modes import STICK

# the cone's two zeros closer than a step sees: it stuck on, and pulled
DOUBLE_ROOT = (59, 108, 685, 944, 1192)
# the root of one guard found beyond that of another
OVERTAKEN = (109, 972, 1050)
# starts on the bush, rounding in place of a gap, a force or a sliding speed
ROUNDING = (37, 52, 80, 84, 104, 116, 175, 292)


def run(number, rtol):
    """Two turns of a scene, 10 000 steps at most."""
    case = draw(catalog.chunmei2002(), number, 0)
    scene = assemble(case.mechanism, case.initial)
    wanted = Request(2 * scene.period, rtol, events=True, log_from=0.0, max_steps=10_000)
    return scene, follow(scene, wanted)


@pytest.mark.parametrize("number", [*DOUBLE_ROOT, *OVERTAKEN])
def test_events_do_not_depend_on_the_tolerance(number):
    few = 60  # before small differences have grown
    kinds = [run(number, rtol)[1].events[:few, 1].tolist() for rtol in (1e-8, 1e-10)]
    assert kinds[0] == kinds[1]


@pytest.mark.parametrize("number", DOUBLE_ROOT)
def test_nothing_that_pulls_sticks(number):
    scene, found = run(number, 1e-8)
    told = Quantities(scene, found.events[:, 2:], found.start).variables(["mode", "normal_force"], "time")
    mode, force = told["mode"][1], told["normal_force"][1]
    assert STICK in mode
    assert force[mode == STICK].min() > -1e-6 * np.abs(force).max()


@pytest.mark.parametrize("number", ROUNDING)
def test_rounding_is_no_chatter(number):
    for rtol in (1e-8, 1e-10):
        assert STATUS[run(number, rtol)[1].status] in ("ok", "step_limit")
