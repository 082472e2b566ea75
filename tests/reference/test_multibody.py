"""The second program meets closed forms: rows of joints, swings, sliders, reactions."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.special import ellipk

from tests.support.multibody import GROUND, Body, Marker, Now, Play, Prismatic, Revolute, System
from tests.support.multibody_loads import (
    constant_speed,
    force,
    kelvin_voigt,
    spring,
    tanh_friction,
    torque,
    torsion,
)
from tests.support.multibody_run import assemble, follow, projected

R, L, E, OMEGA = 0.05, 0.12, 0.011, 200.0  # crank, rod, offset of the guide, speed
MASS, CENTRE, J = {"crank": 0.3, "rod": 0.21, "slider": 0.14}, {"crank": 0.02, "rod": 0.06}, 2.5e-4
PLAY = Play(
    1e-4, kelvin_voigt(1e7, 200.0), tanh_friction(0.1, 0.01), radius=0.01, half_length=0.02, half_height=0.01
)


def crank_slider(**changes) -> System:
    """Crank at a constant speed, rod, slider on a line at height E along +x."""
    bodies = [Body(name, MASS[name], J, CENTRE.get(name, 0.0)) for name in MASS]
    joints = [
        Revolute("O", Marker("crank"), Marker(GROUND)),
        Revolute("A", Marker("crank", (R, 0.0)), Marker("rod")),
        Revolute("B", Marker("rod", (L, 0.0)), Marker("slider")),
        Prismatic("G", Marker("slider"), Marker(GROUND, (0.0, E))),
    ]
    return System(bodies, joints, **{"drives": [constant_speed("crank", OMEGA, 0.4)]} | changes)


def pair(kind, play=None, loads=()) -> System:
    """Two free bodies with one joint between points off both of their lines."""
    p, q = Marker("one", (0.11, 0.03), 0.4), Marker("two", (0.07, -0.05), -0.3)
    return System(
        [Body("one", 1.2, 0.03, 0.02), Body("two", 0.7, 0.01)], [kind("P", p, q, play)], loads=loads
    )


def scattered(system, seed=0) -> np.ndarray:
    """Any state."""
    return np.random.default_rng(seed).standard_normal(2 * len(system.mass))


def along(system, y, h) -> Now:
    """The state after a time h of constant coordinate speeds."""
    n = len(y) // 2
    return Now(system, h, np.concatenate([y[:n] + h * y[n:], y[n:]]))


@pytest.mark.parametrize("kind", [Revolute, Prismatic])
def test_rows_are_derivatives_of_what_they_constrain(kind):
    system = pair(kind)
    y, h = scattered(system), 1e-4
    part, v = system.joints[0], y[6:]
    g, G, g_t, bias = part.rows(along(system, y, 0.0))
    after, before = (part.rows(along(system, y, x))[0] for x in (h, -h))
    assert (after - before) / (2 * h) == pytest.approx(G @ v + g_t, rel=1e-6)
    assert (after - 2 * g + before) / h**2 == pytest.approx(bias, rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("kind", [Revolute, Prismatic])
def test_speeds_of_touch_are_those_of_the_penetration_and_of_the_materials(kind):
    system = pair(kind, PLAY)
    y, h = scattered(system, 4), 1e-6
    now, (p, q) = along(system, y, 0.0), (system.joints[0].journal, system.joints[0].bearing)
    found = system.joints[0].touches(now)
    after, before = (system.joints[0].touches(along(system, y, x)) for x in (h, -h))
    for i, touch in enumerate(found):
        assert (after[i].u - before[i].u) / (2 * h) == pytest.approx(touch.v_n, rel=1e-7)
        assert touch.W_n @ now.v == pytest.approx(touch.v_n, rel=1e-12)
        assert touch.W_t @ now.v == pytest.approx(touch.v_t, rel=1e-12)
        if kind is Revolute:
            place = now.point(p)[0] + PLAY.radius * touch.normal
        else:
            side = 1 if i < 2 else -1
            turned = now.turn(p)[0]
            d, n = np.array([[math.cos(turned), math.sin(turned)], [-math.sin(turned), math.cos(turned)]])
            place = now.point(p)[0] + (0.02, -0.02)[i % 2] * d + side * 0.01 * n
            assert side * (place - now.point(q)[0]) @ touch.normal * side == pytest.approx(touch.u + 0.0101)
        speed = [now.v[k : k + 2] + now.v[k + 2] * _turned(place - now.q[k : k + 2]) for k in (0, 3)]
        assert (speed[0] - speed[1]) @ touch.tangent == pytest.approx(touch.v_t, rel=1e-12)


def _turned(r):
    return np.array([-r[1], r[0]])


@pytest.mark.parametrize("kind", [Revolute, Prismatic])
@pytest.mark.parametrize("play", [None, PLAY], ids=["ideal", "loose"])
def test_forces_inside_move_no_centre_and_change_no_moment_of_momentum(kind, play):
    """Momentum and moment of momentum of two bodies that only act on each other."""
    p, q = Marker("one", (0.2, 0.1), 0.1), Marker("two", (-0.3, 0.2))
    loads = [spring(p, q, 300.0, 0.1, 2.0), spring(q, p, 200.0), torsion(p, q, 5.0, 0.3, 0.2)]
    system = pair(kind, play, loads)
    y = scattered(system, 2)
    if play is None:  # journal and bearing at one point, moving with the joint
        y = projected(system, 0.0, np.concatenate([assemble(system, {"one": 0.3, "two": 0.4})[:6], y[6:]]))
    a = system.solve(0.0, y, [True] * len(system.touches(Now(system, 0.0, y)))).acceleration
    m = system.mass.reshape(2, 3)
    rate = m * a.reshape(2, 3)
    scale = np.abs(rate).max()
    assert rate[:, 1].sum() + 9.8 * m[:, 0].sum() == pytest.approx(0.0, abs=1e-12 * scale)
    x, w = y[:6].reshape(2, 3), -9.8 * m[:, 0]
    moment = rate[:, 2] + x[:, 0] * (rate[:, 1] - w) - x[:, 1] * rate[:, 0]
    assert rate[:, 0].sum() == pytest.approx(0.0, abs=1e-12 * scale)
    assert moment.sum() == pytest.approx(0.0, abs=1e-11 * scale)


@pytest.mark.parametrize("direction", [-math.pi / 2, 0.3])
def test_a_pendulum_swings_as_the_elliptic_integral_says(direction):
    """From 2 rad off gravity's direction: a quarter of its period, speed and pin force below."""
    m, s, inertia, g, swing = 0.7, 0.2, 0.01, 9.8, 2.0
    joint = Revolute("O", Marker("rod"), Marker(GROUND, (0.1, -0.2)))
    system = System([Body("rod", m, inertia, s)], [joint], gravity=g, direction=direction)
    y = assemble(system, {"rod": direction + swing}, held={"rod": (direction + swing, 0.0)})
    about_pin = inertia + m * s * s
    quarter = ellipk(math.sin(swing / 2) ** 2) / math.sqrt(m * g * s / about_pin)
    states, _, _ = follow(system, y, [quarter], rtol=1e-12)
    speed = -math.sqrt(2 * m * g * s * (1 - math.cos(swing)) / about_pin)
    assert states[0, 2] == pytest.approx(direction, abs=1e-11)
    assert states[0, 5] == pytest.approx(speed, rel=1e-11)
    pull = m * (g + s * speed**2) * np.array([math.cos(direction), math.sin(direction)])
    assert system.solve(0.0, states[0], []).reactions["O"][:2] == pytest.approx(pull, rel=1e-10, abs=1e-9)


@pytest.mark.nightly
def test_a_double_pendulum_on_springs_keeps_its_energy():
    ends = Marker("lower", (0.3, 0.0)), Marker(GROUND, (0.4, 0.1))
    loads = [
        spring(*ends, 40.0, 0.2),
        torsion(Marker("upper"), Marker("lower"), 0.5, 0.3),
        spring(*ends, 3.0),
    ]
    joints = [
        Revolute("O", Marker("upper"), Marker(GROUND)),
        Revolute("A", Marker("lower"), Marker("upper", (0.25, 0.0))),
    ]
    system = System([Body("upper", 0.4, 2e-3, 0.1), Body("lower", 0.3, 3e-3, 0.2)], joints, loads=loads)
    y = assemble(system, {"upper": 1.0, "lower": 2.0}, held={"upper": (1.0, 3.0), "lower": (2.0, -7.0)})
    states, _, _ = follow(system, y, [1.0], rtol=1e-12)
    assert np.abs(states[0] - y).max() > 1.0
    assert system.energy(1.0, states[0]) == pytest.approx(system.energy(0.0, y), rel=1e-11)


def test_springs_and_dampers_swing_as_their_closed_form():
    """A block on a guide, by spring and damper; beside it a wheel, by torsion spring and damper."""
    m, inertia, k, c, t = 0.8, 0.05, 90.0, 3.0, 0.7
    guide = Marker(GROUND, (0.2, 0.1), 0.6)
    d = np.array([math.cos(0.6), math.sin(0.6)])
    block, wheel = Marker("block"), Marker("wheel", (0.0, 0.0), 0.3)
    loads = [
        spring(block, Marker(GROUND, tuple(guide.at + 0.5 * d)), k, 0.2, c),
        torsion(
            Marker(GROUND, direction=1.0), wheel, 2.0, -0.4, 0.1
        ),  # free where the wheel's line is at 1.1
    ]
    joints = [Prismatic("G", block, guide), Revolute("O", wheel, Marker())]
    system = System([Body("block", m, 1.0), Body("wheel", 1.0, inertia)], joints, loads=loads, gravity=0.0)
    place = guide.at + 0.35 * d  # 0.05 beyond where the spring is free
    y = assemble(system, {"block": (*place, 0.6), "wheel": 1.2}, speeds={"wheel": 2.0})
    (state,), _, _ = follow(system, y, [t], rtol=1e-12)
    x, _ = _damped(c / m, k / m, 0.05, 0.0, t)
    turned, speed = _damped(0.1 / inertia, 2.0 / inertia, 0.1, 2.0, t)
    assert state[:2] == pytest.approx(guide.at + (0.3 + x) * d, rel=1e-11)
    assert state[[5, 11]] == pytest.approx([1.1 + turned, speed], rel=1e-10)


def _damped(twice, square, x, v, t):
    """Place and speed of ẍ + twice ẋ + square x = 0."""
    half = twice / 2
    w = math.sqrt(square - half**2)
    a, b, fall = x, (v + half * x) / w, math.exp(-half * t)
    c, s = math.cos(w * t), math.sin(w * t)
    return fall * (a * c + b * s), fall * ((b * w - half * a) * c - (a * w + half * b) * s)


def _slider_crank_motion(theta):
    """Closed form: rod angle and slider place by crank angle, with two derivatives."""
    sine = (E - R * math.sin(theta)) / L
    phi = math.asin(sine)
    d1 = -R * math.cos(theta) / (L * math.cos(phi))
    d2 = (R * math.sin(theta) / L + math.sin(phi) * d1**2) / math.cos(phi)
    x = R * math.cos(theta) + L * math.cos(phi)
    x1 = -R * math.sin(theta) - L * math.sin(phi) * d1
    x2 = -R * math.cos(theta) - L * (math.cos(phi) * d1**2 + math.sin(phi) * d2)
    return np.array([phi, d1, d2]), np.array([x, x1, x2])


def test_a_slider_crank_moves_and_takes_torque_as_its_closed_form():
    """Angles, speeds, accelerations; the drive's torque and the guide's force by virtual work and Newton."""
    system, end = crank_slider(gravity=9.8), 0.02
    y = assemble(system, {"crank": 0.4, "rod": 0.1, "slider": 0.0})
    state = follow(system, y, [end], rtol=1e-12)[0][0]
    theta, found = 0.4 + OMEGA * end, system.solve(end, state, [])
    (phi, d1, d2), (x, x1, x2) = _slider_crank_motion(theta)
    assert state[[2, 5, 6]] == pytest.approx([theta, phi, x], abs=1e-12)
    assert state[[7, 8]] == pytest.approx([E, 0.0], abs=1e-13)
    assert state[[11, 14, 15]] == pytest.approx([OMEGA, d1 * OMEGA, x1 * OMEGA], rel=1e-12)
    assert found.acceleration[[5, 6]] == pytest.approx([d2 * OMEGA**2, x2 * OMEGA**2], rel=1e-11)
    # centre of the rod, by the crank's angle
    s, m, up = CENTRE["rod"], MASS, np.array([0.0, 9.8])
    c1 = R * np.array([-math.sin(theta), math.cos(theta)]) + s * d1 * np.array(
        [-math.sin(phi), math.cos(phi)]
    )
    c2 = -R * np.array([math.cos(theta), math.sin(theta)]) + s * (
        d2 * np.array([-math.sin(phi), math.cos(phi)]) - d1**2 * np.array([math.cos(phi), math.sin(phi)])
    )
    work = m["rod"] * (c2 * OMEGA**2 + up) @ c1 + J * d1 * d2 * OMEGA**2 + m["slider"] * x1 * x2 * OMEGA**2
    work += m["crank"] * CENTRE["crank"] * 9.8 * math.cos(theta)
    assert -found.reactions["drive"][2] == pytest.approx(work, rel=1e-10)
    # force on the slider from the rod's turning about A: moment of the pin force about A
    push = m["slider"] * x2 * OMEGA**2  # on the slider, along the guide
    moment = J * d2 * OMEGA**2 + s * m["rod"] * np.array([-math.sin(phi), math.cos(phi)]) @ (
        c2 * OMEGA**2 + up
    )
    across = (moment - L * math.sin(phi) * push) / (L * math.cos(phi))  # on the rod at B, along y
    assert found.reactions["G"] == pytest.approx([0.0, -across - m["slider"] * 9.8, 0.0], rel=1e-9, abs=1e-8)
    assert found.reactions["B"][0] == pytest.approx(push, rel=1e-10)


def test_a_guide_that_turns_follows_the_crank_s_pin():
    """Quick return: a block on the crank's pin slides on a rocker pinned below the crank's centre."""
    r, below = 0.05, 0.12
    bodies = [Body("crank", 0.2, 1e-4), Body("block", 0.05, 1e-5), Body("rocker", 0.4, 2e-3, 0.1)]
    joints = [
        Revolute("O", Marker("crank"), Marker(GROUND, (0.0, below))),
        Revolute("A", Marker("block"), Marker("crank", (r, 0.0))),
        Prismatic("S", Marker("block"), Marker("rocker")),
        Revolute("C", Marker("rocker"), Marker(GROUND)),
    ]
    system = System(bodies, joints, [constant_speed("crank", 30.0, 0.2)])
    y = assemble(system, {"crank": 0.2, "block": 1.2, "rocker": 1.2})
    state, end = follow(system, y, [0.1], rtol=1e-12)[0][0], 3.2
    place = np.array([r * math.cos(end), below + r * math.sin(end)])
    speed = 30.0 * r * np.array([-math.sin(end), math.cos(end)])
    rate = (place[0] * speed[1] - place[1] * speed[0]) / (place @ place)
    seen = Now(system, 0.1, state).along(joints[2].journal, joints[2].bearing)
    assert state[[5, 8]] == pytest.approx([math.atan2(*place[::-1])] * 2, abs=1e-12)
    assert state[[14, 17]] == pytest.approx([rate] * 2, rel=1e-11)
    slide = math.hypot(*place), place @ speed / math.hypot(*place)
    assert (seen.slide, seen.slide_rate) == pytest.approx(slide, rel=1e-11)


def test_a_guide_takes_a_force_and_a_moment_at_the_slider():
    """A block that nobody turns, pushed off its point: the guide takes the push across, and its moment."""
    direction, push, torsional = 0.7, np.array([3.0, -5.0]), 0.2
    slider, guide = Marker("block", (0.1, 0.0), 0.2), Marker(GROUND, (1.0, 2.0), direction)
    loads = [force(Marker("block", (0.4, 0.3)), lambda now: push), torque("block", lambda now: torsional)]
    system = System([Body("block", 2.0, 0.1)], [Prismatic("S", slider, guide)], loads=loads, gravity=0.0)
    y = assemble(system, {"block": (1.2, 2.0, 0.5)})
    d, n = np.array([[math.cos(direction), math.sin(direction)], [-math.sin(direction), math.cos(direction)]])
    solved = system.solve(0.0, y, [])
    assert solved.acceleration[:2] == pytest.approx((push @ d) / 2.0 * d, rel=1e-13)
    e, m = (np.array([math.cos(0.5), math.sin(0.5)]), np.array([-math.sin(0.5), math.cos(0.5)]))
    arm = 0.4 * e + 0.3 * m
    moment = arm[0] * push[1] - arm[1] * push[0] + torsional - 0.1 * (e @ d * (n @ push) - e @ n * 0.0)
    assert solved.reactions["S"] == pytest.approx([*(push @ n) * n, moment], rel=1e-12)


def test_loops_that_cannot_close_are_refused():
    system = crank_slider()
    guide = system.joints[3]
    far = Prismatic("G", guide.journal, Marker(GROUND, (0.0, 1.0)))
    with pytest.raises(ValueError, match="the loops stay open"):
        assemble(System(system.bodies, [*system.joints[:3], far], system.drives), {"crank": 0.4, "rod": 1.5})
