"""Friction at rigid faces: impacts, slip, sticking of a block in a guide; closed forms, a second method."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from numba import njit

import jointplay as jp
from jointplay.analysis.evaluate import Quantities
from jointplay.analysis.quantities import EVENTS
from jointplay.solver.codegen import cache
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.parameters import Parameter
from jointplay.solver.motion import trajectory
from tests.analysis.test_flat_landing import MASS, PLAY, STILL, block
from tests.method.test_tangent import differences, scaled
from tests.support import driven
from tests.support.linkages import jointed

F, R, G = 0.3, 0.5, 9.81
A, B, INERTIA = 0.02, 0.01, 2e-4  # half sizes, and inertia about the mass centre
WORDS = ["normal_force", "tangential_force", "tangential_velocity", "mode", "penetration"]
WORDS += ["energy_residual", "joint_work"]
SLIPS, STICKS = (2, 3), 4


def rough(slope=0.0, friction=F, restitution=R):
    """The block of `block`, its faces rigid and rough."""
    plain = block(slope)
    law = jp.Contact(law="restitution", parameters={"restitution": restitution})
    return jointed(plain, contact=law, friction=jp.Friction(coefficient=friction))


def placed(mechanism, **state):
    """The model, started at these positions and speeds."""
    model = assemble(mechanism, STILL, powers=True)
    names = cache.structure_module(model.structure).STATE[1:]
    return replace(model, state=np.array([state.get(name, 0.0) for name in names]))


def run(model, duration, count=11, rtol=1e-10):
    """States at even times, events as (kind, corner, time), quantities."""
    at = np.linspace(0.0, duration, count)
    request = trajectory.Request(duration, rtol, events=True, log_from=0.0, at=at)
    found = trajectory.follow(model, request)
    assert found.status == 0
    words = Quantities(model, found.samples, found.start).variables(WORDS, "time")
    events = [(EVENTS[int(kind)], int(corner), time) for corner, kind, time in found.events[:, :3]]
    return found.samples[:, 1:7], events, {name: each[1] for name, each in words.items()}


@pytest.mark.long
@pytest.mark.parametrize(("slope", "sense"), [(0.1, 1), (-0.1, 1), (-0.1, -1)])
def test_a_block_slides_to_rest(slope, sense):
    """When it stops, where, and what it is held with; loads and friction add up at once."""
    stop = 0.01 / (G * (F * math.cos(slope) - sense * math.sin(slope)))
    states, events, found = run(placed(rough(slope), y_0=-PLAY, vx_0=0.01 * sense), 2 * stop)
    onset = [time for kind, _, time in events if kind == "stick_onset"]
    assert onset == pytest.approx([stop], rel=1e-5)
    assert states[-1, 1] == pytest.approx(sense * 0.005 * stop, rel=1e-5)
    assert np.abs(states[-1, 3:]).max() < 1e-12
    load, friction = found["normal_force"].sum(1), found["tangential_force"].sum(1)
    assert load[1:] == pytest.approx(MASS * G * math.cos(slope), rel=1e-12)
    assert friction[1:5] == pytest.approx(sense * F * load[1:5], rel=1e-12)
    assert friction[6:] == pytest.approx(MASS * G * math.sin(slope), rel=1e-9)
    shares = found["tangential_force"][1:, 2:] / found["normal_force"][1:, 2:]
    assert shares[:, 0] == pytest.approx(shares[:, 1], rel=1e-12)
    assert set(found["mode"][1:5, 2:].ravel()) == {SLIPS[sense < 0]}
    assert set(found["mode"][6:, 2:].ravel()) == {STICKS}
    assert np.abs(found["energy_residual"]).max() < 1e-12


@pytest.mark.nightly
@pytest.mark.parametrize("rtol", [1e-4, 1e-8])
def test_what_the_last_rebounds_lose_is_in_the_balance(rtol):
    """All that a fall has gained, though rebounds within the tolerance are not followed one by one."""
    _, events, found = run(placed(rough(), vy_0=-0.3), 0.1, rtol=rtol)
    assert {which for kind, which, _ in events if kind == "rest"} == {2, 3}
    assert np.abs(found["energy_residual"]).max() < 1e-15
    assert found["joint_work"][-1] == pytest.approx(MASS * (0.3**2 / 2 + G * PLAY), rel=1e-13)


@pytest.mark.long
@pytest.mark.parametrize("rtol", [1e-4, 1e-8])
@pytest.mark.parametrize("sense", [1, -1])
def test_rebounds_that_are_left_out_rub(rtol, sense):
    """Friction takes f times all that the face has pushed, which is what weight and the throw ask for."""
    up, slide, duration = 0.03, 0.2, 0.03
    model = placed(rough(), y_0=-PLAY, vx_0=sense * slide, vy_0=up)
    states, events, found = run(model, duration, rtol=rtol)
    assert {which for kind, which, _ in events if kind == "rest"} == {2, 3}
    wanted = slide - F * (G * duration - up)
    assert states[-1, 4] == pytest.approx(sense * wanted, abs=1e-2 * rtol)
    assert np.abs(states[-1, [3, 5]]).max() < 1e-12
    assert np.abs(found["energy_residual"]).max() < 1e-15


@pytest.mark.long
def test_a_steep_block_does_not_stop():
    states, events, found = run(placed(rough(0.5), y_0=-PLAY), 0.01)
    pull = G * (math.sin(0.5) - F * math.cos(0.5))
    assert states[-1, 4] == pytest.approx(0.01 * pull, rel=1e-5)
    assert set(found["mode"][1:, 2:].ravel()) == {SLIPS[0]}
    assert "stick_onset" not in {kind for kind, _, _ in events}


@pytest.mark.long
@pytest.mark.parametrize("speed", [0.2, -0.2, 0.1, -0.1])
def test_a_block_lands_flat_and_obliquely(speed):
    """Two corners at once: f (1 + r) |v_n|, some 0.15 m/s, is the most that friction takes of its slide."""
    states, events, _ = run(placed(rough(), vx_0=speed, vy_0=-1 / 3), 0.0012)
    assert [(kind, which) for kind, which, _ in events] == [("impact", 2), ("impact", 3)]
    time = events[0][2]
    v_n = 1 / 3 + G * time
    wanted = math.copysign(max(abs(speed) - F * (1 + R) * v_n, 0.0), speed)
    assert states[-1, 4] == pytest.approx(wanted, abs=1e-12)
    assert states[-1, 5] == pytest.approx(R * v_n - G * (0.0012 - time), rel=1e-9)
    assert abs(states[-1, 3]) < 1e-9


@njit
def shape(theta, front, side):
    """A corner from the mass centre, and its rows of gap rate and sliding speed over (w, vx, vy)."""
    x = front * A * math.cos(theta) - side * B * math.sin(theta)
    y = front * A * math.sin(theta) + side * B * math.cos(theta)
    return y, np.array([[-side * x, 0.0, -side], [-y, 1.0, 0.0]])


INVERSE = np.diag([1 / INERTIA, 1 / MASS, 1 / MASS])


@pytest.mark.long
@pytest.mark.parametrize(("slide", "mode"), [(0.5, 1), (-0.5, -1), (0.05, 0)])
def test_one_corner_hits(slide, mode):
    """Its impulses from two equations by hand: slip one way or the other, or no sliding after."""
    start = {"theta_block": 0.002, "y_0": -3e-5, "vx_0": slide, "vy_0": -0.3}
    states, events, _ = run(placed(rough(), **start), 0.00013)
    assert [(kind, which) for kind, which, _ in events] == [("impact", 3)]
    time = events[0][2]
    before = np.array([0.0, slide, -0.3 - G * time])
    (n, t), push = shape(0.002, -1, -1)[1], INVERSE
    along = (n - mode * F * t) if mode else None
    if mode:
        change = push @ along * (-(1 + R) * (n @ before) / (n @ push @ along))
    else:
        rows = np.array([n, t])
        wanted = np.array([-(1 + R) * (n @ before), -(t @ before)])
        change = push @ rows.T @ np.linalg.solve(rows @ push @ rows.T, wanted)
    after = before + change - np.array([0.0, 0.0, G * (0.00013 - time)])
    assert states[-1, 3:] == pytest.approx(after, abs=1e-10)


@njit
def stepped(state, duration, h, friction, restitution):
    """Moreau's time stepping of the block: midpoint gaps, impulses by projection, no event."""
    q, v, W = state[:3].copy(), state[3:].copy(), np.zeros((8, 3))
    for _ in range(round(duration / h)):
        q += 0.5 * h * v
        free, n = v + h * np.array([0.0, 0.0, -G]), 0
        for side in (1, -1):
            for front in (1, -1):
                height, rows = shape(q[0], front, side)
                if B + PLAY - side * (q[2] + height) <= 0.0:
                    W[n : n + 2] = rows
                    n += 2
        near = np.ascontiguousarray(W[:n])
        matrix, after, before, p = near @ INVERSE @ near.T, near @ free, near @ v, np.zeros(n)
        for _ in range(200 if n else 0):
            for i in range(0, n, 2):
                rate = after[i] + matrix[i] @ p + restitution * min(before[i], 0.0)
                p[i] = max(p[i] - rate / matrix[i, i], 0.0)
                slide = after[i + 1] + matrix[i + 1] @ p
                most = friction * p[i]
                p[i + 1] = min(max(p[i + 1] - slide / matrix[i + 1, i + 1], -most), most)
        v = free + INVERSE @ near.T @ p
        q += 0.5 * h * v
    return np.concatenate((q, v))


FALLING = {"theta_block": 0.002, "y_0": -3e-5, "w_block": 0.1, "vx_0": 0.08, "vy_0": -0.1}


@pytest.mark.nightly
@pytest.mark.parametrize(("restitution", "duration"), [(0.0, 0.02), (0.5, 0.006)])
def test_time_stepping_moves_alike(restitution, duration):
    """Impacts, slip, sticking, landing: Moreau's scheme comes nearer as its step shrinks."""
    model = placed(rough(restitution=restitution), **FALLING)
    states, events, _ = run(model, duration)
    kinds = {kind for kind, _, _ in events}
    assert kinds >= ({"impact", "rest", "stick_onset"} if not restitution else {"impact"})
    scale, errors = np.array([1e-3, 1e-3, 1e-4, 1.0, 0.2, 0.1]), []
    for h in (1e-6, 2.5e-7):
        twin = stepped(model.state, duration, h, F, restitution)
        errors.append(float(np.abs((twin - states[-1]) / scale).max()))
    assert errors[1] < 2e-3
    assert errors[1] < 0.6 * errors[0] or errors[1] < 1e-4


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("start", "restitution", "duration", "kinds"),
    [
        (FALLING | {"vx_0": 0.5}, 0.5, 0.002, {"impact"}),  # slips
        (FALLING | {"vx_0": 0.02}, 0.5, 0.002, {"impact"}),  # is stopped
        (FALLING, 0.0, 0.003, {"impact", "rest"}),  # stays, and slides on one corner
        (FALLING, 0.0, 0.009, {"impact", "rest"}),  # then lands on the other, and slides on two
        (FALLING, 0.0, 0.018, {"impact", "rest", "stick_onset"}),
    ],
)
def test_tangents_are_those_of_neighbours(start, restitution, duration, kinds):
    model = placed(rough(restitution=restitution), **start)
    exact, apart = scaled(model, duration), []
    for size in (1e-9, 1e-8, 1e-7, 1e-6)[: 4 if restitution else 2]:
        found, events, same = differences(model, duration, size, exact)
        if same:
            assert {EVENTS[kind] for _, kind in events} == kinds
            apart.append(np.abs(found - exact).max() / np.abs(exact).max())
    assert min(apart) < 1e-6


@pytest.mark.nightly
@pytest.mark.parametrize(("slope", "friction"), [(0.6, F), (0.1, 2.0)])
def test_derivatives_in_numbers_are_those_of_neighbours(slope, friction):
    """Through two impacts at a corner each: slipping, or stopped, where friction does not count."""
    block, start = rough(slope, friction), STILL | {"angle": {"block": 0.002}}
    keys = [
        *("gravity_direction", "links.block.mass", "links.block.inertia_centre"),
        *("joints.G.clearance", "joints.G.half_length", "joints.G.half_height"),
        *("joints.G.contact.parameters.restitution", "joints.G.friction.coefficient"),
    ]
    values, model = {key: Parameter(block, key).value for key in keys}, assemble(block, start)
    exact = dict(zip(keys, driven.by_tangents(block, values, 0.006, start), strict=True))
    assert [EVENTS[int(kind)] for _, kind in driven.end(model, 0.006)[1]] == ["impact", "impact"]
    if friction == 2.0:
        assert np.all(exact.pop(keys[-1]) == 0.0)
    for key, row in exact.items():
        tried = [driven.by_differences(block, key, values[key], 0.006, h, start) for h in (1e-6, 1e-5, 1e-4)]
        assert min(driven.distance(row, one, model) for one in tried if one is not None) < 1e-6, key
