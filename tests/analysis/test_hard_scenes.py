"""Scenes far from ordinary use that once lost an event, or met one that is not there."""

from __future__ import annotations

import numpy as np
import pytest

from jointplay import catalog
from jointplay.analysis.evaluate import Quantities
from jointplay.analysis.quantities import EVENTS, STATUS
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.method.modes import STICK
from jointplay.solver.motion.trajectory import Request, follow, memory
from jointplay_lab.stress.scenes import draw

# structures of their own: a quarter of a minute each to compile
OWN = tuple(pytest.param(number, marks=pytest.mark.long) for number in (37, 1372, 4354))
# the cone's two zeros closer than a step sees: it stuck on, and pulled
DOUBLE_ROOT = (59, 108, 685, 944, 1192)
# the root of one guard found beyond that of another
OVERTAKEN = (109, 972, 1050)
# flight across a bearing much smaller than the penetration: the force turns faster than a step sees
ACROSS = (4019,)
# starts on the bearing, rounding in place of a gap, a force, a sliding speed or a cone (the last three)
ROUNDING = (52, 80, 84, 104, 116, 175, 292, 1266, 1900, 2589, *OWN)
# separations whose gap and force are zero together, the order of roundings deciding
TOGETHER = (18, 258, 393)
# a stick ends where its force does: the cone is zero within the rounding of both
CONES = (624, 1574, 1801)


def run(number, rtol):
    """Two turns of a model, 10 000 steps at most."""
    case = draw(catalog.chunmei2002(), number, 0)
    model = assemble(case.mechanism, case.initial)
    wanted = Request(2 * model.period, rtol, events=True, log_from=0.0, max_steps=10_000)
    return model, follow(model, wanted)


@pytest.mark.parametrize("number", [*DOUBLE_ROOT, *OVERTAKEN, *ACROSS])
def test_events_do_not_depend_on_the_tolerance(number):
    few = 60  # before small differences have grown
    kinds = [run(number, rtol)[1].events[:few, 1].tolist() for rtol in (1e-8, 1e-10)]
    assert kinds[0] == kinds[1]


@pytest.mark.parametrize("number", DOUBLE_ROOT)
def test_nothing_that_pulls_sticks(number):
    model, found = run(number, 1e-8)
    told = Quantities(model, found.events[:, 2:], found.start).variables(["mode", "normal_force"], "time")
    mode, force = told["mode"][1], told["normal_force"][1]
    assert STICK in mode
    assert force[mode == STICK].min() > -1e-6 * np.abs(force).max()


@pytest.mark.parametrize("number", ROUNDING)
def test_rounding_is_no_chatter(number):
    for rtol in (1e-8, 1e-10):
        assert STATUS[run(number, rtol)[1].status] in ("ok", "step_limit")


@pytest.mark.parametrize("number", TOGETHER)
def test_located_events_are_taken(number):
    """A guard that meets zero within its rounding is met: no step is halved for that until none is left."""
    for rtol in (1e-8, 1e-10):
        model, found = run(number, rtol)
        told = Quantities(model, found.events[:, 2:], found.start).variables(["normal_velocity"], "time")
        begin = found.events[:, 1] == EVENTS.index("contact")
        assert told["normal_velocity"][1][begin, 0].min() > 0.0
        assert found.counts["n_failed"] < 20


@pytest.mark.parametrize("number", CONES)
def test_cones_left_within_their_rounding_halve_no_steps(number):
    _, found = run(number, 1e-10)
    assert found.counts["n_failed"] < 0.025 * found.counts["n_steps"]


@pytest.mark.nightly  # its structure, elastic and without tension, is compiled for it alone
def test_contact_begins_at_the_bearing():
    """Bounces lower than the tolerance of a position: entered late, each of them gained energy."""
    model, found = run(4434, 1e-8)
    rows = found.events[found.events[:, 1] == EVENTS.index("contact"), 2:]
    depth = Quantities(model, rows, found.start).variables(["penetration"], "time")["penetration"][1]
    assert np.abs(depth).max() < 1e-14


def test_margins_of_sliding_speeds_follow_the_start():
    slow, fast = (
        assemble(catalog.chunmei2002(), {"crank_angle": 0.0, "crank_speed": speed}) for speed in (1.0, 3e5)
    )
    rests = [memory(model, Request(1.0, 1e-12))[2].speed_tolerance for model in (slow, fast)]
    assert rests[1] > 100 * rests[0]


def test_a_loose_tolerance_meets_every_flight_across_a_bearing():
    """A bearing of 0.2 um, the journal pressed in much further: flights of a millionth of a turn."""
    case = draw(catalog.chunmei2002(), 356, 0, ("rigid", "no_tension", "frictionless"))
    model = assemble(case.mechanism, case.initial)
    tight, *others = (
        follow(model, Request(2 * model.period, rtol, events=True, log_from=-1.0)).events
        for rtol in (1e-9, 1e-5, 1e-4)
    )
    assert len(tight) == 43
    assert all(loose[:, 1].tolist() == tight[:, 1].tolist() for loose in others)
    assert all(np.abs(loose[:, 2] - tight[:, 2]).max() < 1e-4 * model.period for loose in others)
