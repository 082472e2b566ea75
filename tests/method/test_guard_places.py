"""Places of guards, in the order of method.memory: what a rough wall does is noted at its own."""

from types import SimpleNamespace

import numpy as np
import pytest

from jointplay.solver.method import events, memory
from jointplay.solver.method.modes import FREE, RESTING, SLIP_NEGATIVE, SLIP_ONSET, SLIP_POSITIVE, STICK
from jointplay.solver.method.walls import walls

SOFT, RIGID = 2, 4
GUARDS = [(f"contact {j}", kind) for j in range(SOFT) for kind in ("gap", "force", "slide", "cone")]
GUARDS += [(f"wall {j}", kind) for kind in ("push", "rub") for j in range(RIGID)]
OPTIONS = SimpleNamespace(speed_tolerance=0.25, gap_rounding=0.5)


def run(group=range(RIGID)):
    """A run of soft contacts and rough rigid walls, in guides of these numbers; all of them are free."""
    motion = memory.trajectory(np.zeros(7), np.zeros(0), 3, 0, SOFT, RIGID, RIGID)
    motion.group[:] = group
    assert len(motion.fired) == len(GUARDS)
    return motion


def noted(values):
    return {GUARDS[at]: value for at, value in enumerate(values) if value}


def rows(numbers):
    """What is looked at: rows of contacts and walls, then those of the walls' friction, with these forces."""
    out = np.zeros(6 * (SOFT + 2 * RIGID))
    out[6 * (SOFT + RIGID) + 4 :: 6] = numbers
    return lambda variant, s, p, m, found: np.copyto(found, out)


@pytest.mark.parametrize("wall", range(RIGID))
def test_a_wall_to_which_a_body_no_longer_sticks(wall):
    motion, forces = run(), np.full(RIGID, -1.0)
    motion.modes[SOFT:], forces[wall] = STICK, 3.0
    functions, work = (
        SimpleNamespace(contacts=rows(forces)),
        SimpleNamespace(contact=np.zeros(6 * (SOFT + 2 * RIGID))),
    )
    assert walls.rub(functions, wall, work, motion, OPTIONS) == SLIP_ONSET
    assert [*np.flatnonzero(motion.modes == SLIP_POSITIVE)] == [SOFT + wall]
    assert noted(motion.fired) == {(f"wall {wall}", "rub"): 2}
    assert noted(motion.margin) == {(f"wall {wall}", "rub"): OPTIONS.speed_tolerance}


def test_corners_of_one_guide_slip_as_one():
    """The sign of all they are held with decides; what is free, or of another guide, is let alone."""
    motion, forces = run((0, 0, 0, 1)), (1.0, -3.0, 50.0, 50.0)
    motion.modes[SOFT:] = STICK, STICK, FREE, STICK
    functions, work = (
        SimpleNamespace(contacts=rows(forces)),
        SimpleNamespace(contact=np.zeros(6 * (SOFT + 2 * RIGID))),
    )
    walls.rub(functions, 0, work, motion, OPTIONS)
    assert [*motion.modes[SOFT:]] == [SLIP_NEGATIVE, SLIP_NEGATIVE, FREE, STICK]
    assert set(noted(motion.fired)) == set(noted(motion.margin)) == {("wall 0", "rub"), ("wall 1", "rub")}


@pytest.mark.parametrize("wall", range(RIGID))
@pytest.mark.parametrize(
    ("mode", "side"), [(SLIP_POSITIVE, 1), (SLIP_NEGATIVE, -1), (STICK, 1), (RESTING, 0)]
)
def test_the_side_on_which_friction_is_watched_is_that_of_its_wall(wall, mode, side):
    motion = run()
    motion.modes[SOFT + wall] = mode
    sides = [events.side_of(g, motion.modes, motion.flags) for g in range(len(GUARDS))]
    assert {name: each for name, each in zip(GUARDS, sides, strict=True) if name[1] == "rub"} == {
        (f"wall {j}", "rub"): side if j == wall else 0 for j in range(RIGID)
    }


@pytest.mark.parametrize("wall", range(RIGID))
def test_the_margin_of_a_cone_goes_by_the_push_of_its_wall(wall):
    """The rounding of (f N)^2 - T^2 is that of N^2, as a share."""
    motion, row, lane = run(), 3, 5
    motion.cone[:], motion.modes[SOFT + wall] = np.arange(1.0, 1 + SOFT + RIGID), STICK
    w = np.random.default_rng(wall).standard_normal(8 * (row + len(GUARDS)))
    events.set_cone_margins(w, row, lane, motion)
    push = w[8 * (row + GUARDS.index((f"wall {wall}", "push"))) + lane]
    assert noted(motion.margin) == {(f"wall {wall}", "rub"): pytest.approx((1 + SOFT + wall) * push**2)}


@pytest.mark.parametrize("wall", range(RIGID))
def test_a_body_thrown_off_a_wall_is_watched_for_the_gap_there(wall):
    motion, work = run(), SimpleNamespace(contact=np.zeros(6 * (SOFT + 2 * RIGID)))
    motion.modes[SOFT:] = RESTING
    work.contact[6 * (SOFT + wall) + 2] = 2 * OPTIONS.speed_tolerance
    walls.throw_off(work, motion, OPTIONS)
    assert [*np.flatnonzero(motion.modes[SOFT:] == FREE)] == [wall]
    assert noted(motion.fired) == {(f"wall {wall}", "push"): 1}
    assert noted(motion.margin) == {(f"wall {wall}", "push"): OPTIONS.gap_rounding}
