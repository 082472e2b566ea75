"""What the derivative of coming to rest takes each wall to do, and which impacts take a dimension."""

from types import SimpleNamespace

import numpy as np
import pytest

from jointplay.solver.method import memory
from jointplay.solver.method.tangents import saltation
from jointplay.solver.method.walls.impacts import IMPOSSIBLE, PUSHES, SEPARATES, SLIPS_DOWN, SLIPS_UP, STICKS

WALLS = 5  # two of one guide to which the body sticks, one along which it slips each way, a smooth one
GUIDES, SPEEDS, ROUGH = (0, 0, 1, 2, 3), (0.0, 0.01, 2.0, -3.0, 1.0), (True, True, True, True, False)
OPTIONS = SimpleNamespace(speed_tolerance=0.1)


@pytest.mark.parametrize("stale", [SEPARATES, PUSHES, SLIPS_UP, SLIPS_DOWN, STICKS])
def test_each_wall_does_as_the_body_slides_there_whatever_was_chosen_before(monkeypatch, stale):
    motion = memory.trajectory(np.zeros(7), np.zeros(0), 3, 0, 0, WALLS, WALLS)
    motion.group[:] = GUIDES
    q, contact = np.zeros(memory.STATE + len(motion.s)), np.zeros(6 * 2 * WALLS)
    q[memory.CHOICE : memory.CHOICE + WALLS], contact[6 * WALLS + 2 :: 6] = stale, SPEEDS
    work = SimpleNamespace(impact=q, contact=contact, predicted=np.zeros(len(motion.s)))

    def gather(functions, j, work, motion, share):
        q[memory.MEMBERS], q[memory.WALL : memory.WALL + WALLS] = WALLS, np.arange(WALLS)
        return WALLS

    def choose(q, members, share):
        chosen.append(q[memory.CHOICE : memory.CHOICE + members].tolist())
        return IMPOSSIBLE

    chosen = []
    fakes = {"gather": gather, "choose": choose, "rough": lambda motion, j: ROUGH[j]}
    for name, each in (fakes | dict.fromkeys(("contact_numbers", "prepare"), lambda *_: None)).items():
        monkeypatch.setattr(saltation, name, each)
    functions, tangents = SimpleNamespace(contacts=None), SimpleNamespace(state=motion.s.copy())
    assert not saltation.landing_map(functions, None, work, motion, OPTIONS, tangents, 0, True)
    assert chosen == [[STICKS, PUSHES, SLIPS_UP, SLIPS_DOWN, PUSHES]]


@pytest.mark.parametrize("at", range(memory.MOST))
@pytest.mark.parametrize(
    ("choice", "target", "taken"),
    [
        (SEPARATES, 0.0, False),
        (PUSHES, 0.2, False),
        (SLIPS_UP, 0.2, False),
        (PUSHES, 0.0, True),
        (SLIPS_DOWN, 0.0, True),
        (STICKS, 0.2, True),
    ],
)
def test_an_impact_takes_a_dimension_where_a_wall_goes_on_to_push_or_a_body_sticks(at, choice, target, taken):
    q = np.zeros(memory.STATE + 7)
    q[memory.MEMBERS], q[memory.CHOICE : memory.CHOICE + memory.MOST] = memory.MOST, SEPARATES
    q[memory.CHOICE + at], q[memory.TARGET + at] = choice, target
    assert saltation.loses(SimpleNamespace(impact=q)) == taken
