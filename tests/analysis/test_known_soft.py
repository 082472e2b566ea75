"""Elastic walls against exact motions, linear between events: the soft impact pair and the gear pair."""

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.linalg import expm

import jointplay as jp
from jointplay import catalog
from jointplay.analysis.quantities import EVENTS, MODES
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.motion.trajectory import Request, follow

from .exact_maps import TAU, Walls, distinct

SOFT = [(0.4, 400.0, 4.0), (3.6, 1e4, 10.0), (0.4, 1e6, 100.0), (1.0, 5.0, 3.0)]
GEAR = {"mean_load": 0.1, "amplitude": 0.2, "damping": 0.05}
OK = 0


def compare(system, walls, start, duration, rtol=1e-12):
    """Events and states of a response and of the exact motion: largest differences."""
    at = np.linspace(0, duration, 201)
    events, states = walls.run(*start, duration, at)
    found = jp.simulate(system, duration=duration, initial=start, rtol=rtol, at=at)
    assert int(found.status) == OK
    assert [EVENTS[k] for k in found.event_kind.values] == [kind for _, _, kind in events]
    assert found.event_joint.values.tolist() == [wall for _, wall, _ in events]
    times = np.abs(found.event_time.values - [t for t, _, _ in events])
    return len(events), times.max(), np.abs(found.state_value.values - states).max()


@pytest.mark.parametrize("tension", [True, False])
@pytest.mark.parametrize("numbers", SOFT)
def test_soft_impact_pair(numbers, tension):
    gap, stiffness, damping = numbers
    system = catalog.soft_impact_pair(*numbers, tension=tension)
    walls = Walls(gap / 2, stiffness, damping, tension, sin=1.0)
    count, time, state = compare(system, walls, (0.05, 0.7), 12.0)
    assert count >= 4
    assert time < 1e-10
    assert state < 1e-10 * math.sqrt(stiffness)  # in contact, speed turns by sqrt(K) v in a unit of time


@pytest.mark.parametrize("frequency", [0.8, 1.0, 1.6])
def test_gear_pair(frequency):
    system = catalog.gear_backlash(frequency=frequency, **GEAR)
    force = {"cos": 0.2 * frequency**2, "mean": 0.1, "drag": 0.1}
    walls = Walls(1.0, 1.0, 0.0, W=frequency, **force)
    count, time, state = compare(system, walls, (0.5, 0.0), 60.0)
    assert count > 10
    assert time < 1e-10
    assert state < 1e-10


def test_one_passage_through_a_wall():
    """The speed out of a wall that pulls, against the damped oscillation with its forcing."""
    gap, K, C, speed = 0.4, 2500.0, 10.0, 1.5
    A = np.array(
        [[0, 1, 0, 0, 0], [-K, -C, 0, 1, 0], [0, 0, 0, -1, 0], [0, 0, 1, 0, 0], [0] * 5]
    )  # u, v, cos, sin
    found = jp.simulate(
        catalog.soft_impact_pair(gap, K, C), duration=1.0, initial=(0.0, speed), steps=True, rtol=1e-13
    )
    (t_in, t_out), time = found.event_time.values[:2], found.time.values
    v = found.state_value.sel(state="v").values
    entered, left = (v[np.flatnonzero(time == t)[0]] for t in (t_in, t_out))
    u, v_out, *_ = expm(A * (t_out - t_in)) @ (0.0, entered, math.cos(t_in), math.sin(t_in), 1.0)
    assert u == pytest.approx(0.0, abs=1e-13)
    assert left == pytest.approx(v_out, abs=1e-11)
    ratio = C / (2 * math.sqrt(K))
    restitution = math.exp(-math.pi * ratio / math.sqrt(1 - ratio**2))
    assert -left / entered == pytest.approx(restitution, abs=0.02)  # the forcing acts on it for 0.06


@pytest.mark.parametrize("ratio", [0.02, 0.1, 0.3])
def test_restitution_of_a_stiff_wall(ratio):
    """The stiffer the wall, the less the forcing acts: v'/v = exp(-pi zeta/sqrt(1 - zeta^2)) + O(K^-1/2)."""
    errors = []
    for K in (1e6, 1e8):
        system = catalog.soft_impact_pair(0.4, K, 2 * ratio * math.sqrt(K))
        found = jp.simulate(system, duration=0.3, initial=(0.0, 1.5), steps=True, rtol=1e-13)
        time, v = found.time.values, found.state_value.sel(state="v").values
        entered, left = (v[np.flatnonzero(time == t)[0]] for t in found.event_time.values[:2])
        errors.append(-left / entered - math.exp(-math.pi * ratio / math.sqrt(1 - ratio**2)))
    assert abs(errors[1]) < 1e-4
    assert 7 < errors[0] / errors[1] < 14


def follow_modes(numbers, start, duration, tension):
    """Rows (time, y, v) of the integrator's points, with the modes of both walls as words."""
    model = assemble(catalog.soft_impact_pair(*numbers, tension=tension), start)
    rows = follow(model, Request(duration, 1e-10, steps=True, log_from=0.0)).steps[:, 2:]
    return rows[:, :3], [[MODES[int(m)] for m in row] for row in rows[:, 3:]]


@pytest.mark.parametrize("numbers", SOFT)
def test_a_wall_that_does_not_pull(numbers):
    gap, K, C = numbers
    rows, modes = follow_modes(numbers, (0.05, 0.7), 12.0, tension=False)
    words = {mode for pair in modes for mode in pair}
    assert words == {"free", "released", "contact"}
    for (_, y, v), pair in zip(rows, modes, strict=True):
        for side, mode in zip((1, -1), pair, strict=True):
            u = side * y - gap / 2
            force = K * u + C * side * v
            scale = 1e-9 * (1 + K * gap + C)
            if mode == "contact":
                assert force > -scale
            else:
                assert (u < 1e-9) if mode == "free" else (force < scale and u > -1e-9)


RECLOSED = [  # stiffness, damping, gap, speed at the start
    (8.405059041898818, 0.7520687450617368, 0.3734559636161078, 0.0076059003890591725),
    (16.704495340980998, 3.1372316524115087, 0.8123854490049311, -0.9319088354444491),
    (62.16349619886098, 6.608311147081067, 0.3804314982853635, 0.7160216276424132),
    (59.78146033849933, 7.247481504402139, 0.4448123705129471, 0.5326680160059158),
]


@pytest.mark.parametrize(("K", "C", "gap", "speed"), RECLOSED)
def test_contact_before_the_gap_reopens(K, C, gap, speed):
    walls = Walls(gap / 2, K, C, False, sin=1.0)
    system = catalog.soft_impact_pair(gap, K, C, tension=False)
    kinds = [kind for _, _, kind in walls.run(0.0, speed, 20.0)[0]]
    assert ("separation", "contact") in pairwise(kinds)
    _, time, state = compare(system, walls, (0.0, speed), 20.0)
    assert time < 1e-9
    assert state < 1e-9


def test_without_damping_a_wall_never_pulls():
    """With c = 0 the force ends where the gap opens: both kinds of wall move the mass alike."""
    ends = []
    for tension in (True, False):
        system = catalog.soft_impact_pair(0.4, 1e3, 0.0, tension=tension)
        found = jp.simulate(system, duration=10.0, initial=(0.0, 0.7), at=np.linspace(0, 10, 41), rtol=1e-12)
        assert int(found.status) == OK
        ends.append(found.state_value.values)
    assert ends[0] == pytest.approx(ends[1], abs=1e-9)


@pytest.mark.parametrize(("frequency", "points"), [(0.8, 2), (1.0, 4), (1.6, None)])
def test_periods_of_the_gear_pair(frequency, points):
    system = catalog.gear_backlash(frequency=frequency, **GEAR)
    section = jp.poincare(system, turns=48, transient=400)
    assert int(section.status) == OK
    assert section.time.values == pytest.approx(np.arange(401, 449) * TAU / frequency, rel=1e-12)
    assert distinct(section) == points if points else distinct(section) > 40
