"""The bending reference agrees with the rigid one, the printed energy, mechanics' laws and a slow beam."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

from .beams import Beam, Line
from .bodies import LINKS, Bodies, Parameters, closure
from .flexible import RATE_UNIT, UNIT, Flexible
from .flexible_scenes import SCENES
from .flexible_twin import build, follow, loop, sample
from .textbook import textbook

TRUTH = json.loads(Path(__file__).with_name("flexible_truth.json").read_text())
SOFT = dict.fromkeys(LINKS, Beam(xi=0.05, modulus=2.1e8))  # so that bending has its share in every balance
COUPLER = Line(Beam(), Parameters().l1, Parameters().m1)


def scattered(system, seed):
    """A state with every joint displaced by a millimetre, links bent by a tenth of that, all moving."""
    random, size = np.random.default_rng(seed), np.repeat([1e-4 / UNIT, 1.0 / RATE_UNIT], system.n)
    size[: system.rigid], size[system.n : system.n + system.rigid] = 1e-3, 5.0
    return system.start() + size * random.standard_normal(2 * system.n)


def printed(line, mass, first, J, m, g):
    """Sides of Lagrange's equations for T_j and gravity as MODEL.md prints them, as a function of numbers."""
    n = line.size
    x, u, a = (sp.symbols(f"{letter}:{3 + n}") for letter in "xua")
    q, rate = sp.Matrix(x[3:]), sp.Matrix(u[3:])
    M, _, S, I = (sp.Matrix(part) for part in textbook(line, mass))
    along = u[0] * sp.cos(x[2]) + u[1] * sp.sin(x[2])
    across = u[1] * sp.cos(x[2]) - u[0] * sp.sin(x[2])
    sigma, w = S.dot(q), u[2]
    T = m * (u[0] ** 2 + u[1] ** 2) / 2 + first * w * across + J * w**2 / 2
    T += (
        across * S.dot(rate)
        + w * I.dot(rate)
        + rate.dot(M * rate) / 2
        - w * along * sigma
        + w**2 * q.dot(M * q) / 2
    )
    V = g * (m * x[1] + first * sp.sin(x[2]) + sp.cos(x[2]) * sigma)
    momentum = sp.Matrix([sp.diff(T, v) for v in u])
    change = momentum.jacobian(u) * sp.Matrix(a) + momentum.jacobian(x) * sp.Matrix(u)
    return sp.lambdify([x, u, a], change - sp.Matrix([sp.diff(T - V, v) for v in x]))


def test_link_equations_follow_from_the_printed_energy():
    p = Parameters()
    system, random = Flexible(p, {"B": p.e}, SOFT), np.random.default_rng(5)
    lagrange = printed(COUPLER, p.m1, p.m1 * p.l1 / 2, p.J_A, p.m1, p.gravity)
    x, u, a = random.standard_normal((3, 7)) * [1, 1, 1, 0.02, 0.003, 0.02, 0.02]
    x[3:], u[2] = 0.1 * x[3:], 10.0
    mass, load = system.link_inertia(1, (math.cos(x[2]), math.sin(x[2])), u[2], x[3:], u[3:])
    expected = np.ravel(lagrange(x, u, a))
    assert mass @ a - load == pytest.approx(expected, abs=1e-12 * np.abs(expected).max())


def test_paper_order_keeps_only_what_the_paper_prints():
    """(9)-(12): S q'' on the origin along n, I q'' on the angle, and the inertial load on the beam."""
    p, random = Parameters(), np.random.default_rng(6)
    system = Flexible(p, {"B": p.e}, SOFT, order="paper")
    angle, w, q, rate = 0.7, 11.0, 1e-3 * random.standard_normal(4), random.standard_normal(4)
    A, turn, bend = np.array([3.0, -40.0]), 55.0, random.standard_normal(4)
    mass, load = system.link_inertia(1, (math.cos(angle), math.sin(angle)), w, q, rate)
    e, n = np.array([math.cos(angle), math.sin(angle)]), np.array([-math.sin(angle), math.cos(angle)])
    M, _, S, I = textbook(COUPLER, p.m1)
    s = p.l1 / 2
    force = p.m1 * (A + s * turn * n - s * w**2 * e + [0.0, p.gravity]) + S @ bend * n
    moment = p.J_A * turn + p.m1 * s * (A @ n + p.gravity * e[0]) + I @ bend
    inner = S * (A @ n + p.gravity * e[0]) + I * turn + M @ bend
    found = mass @ np.concatenate([A, [turn], bend]) - load
    assert found == pytest.approx(np.concatenate([force, [moment], inner]), rel=1e-12)


@pytest.mark.parametrize("drive", ["motor", "speed"])
@pytest.mark.parametrize("mode", ["free", "slip-", "stick"])
@pytest.mark.parametrize("joints", ["B", "AC", "OABC"])
def test_without_beams_it_is_the_rigid_reference(joints, mode, drive):
    p, play = Parameters(i=3.0, f=0.1, C_t=2.0, drive=drive), dict.fromkeys(joints, 2.9e-4)
    rigid, modes = Bodies(p, play), dict.fromkeys(joints, mode)
    random = np.random.default_rng(1)
    y = rigid.start() + np.repeat([1e-3, 5.0], rigid.n) * random.standard_normal(2 * rigid.n)
    mine, other = Flexible(p, play).rate(y, modes), rigid.rate(y, modes)
    assert np.max(np.abs(mine - other)) < 1e-10 * np.max(np.abs(other))
    assert Flexible(p, play).energy(y) == pytest.approx(rigid.energy(y), rel=1e-12)


def slope(function, y, direction, step=1e-7):
    """Derivative of a function of the state along a direction, by differences of fourth order."""
    d = step * direction
    near, far = (
        np.subtract(function(y + d), function(y - d)),
        np.subtract(function(y + 2 * d), function(y - 2 * d)),
    )
    return (8 * near - far) / (12 * step)


def power(system, y, modes):
    """Power of drive, contact damping, friction and structural damping, W."""
    p, total = system.p, 0.0
    w, held = float(y[system.n]), system.forces(y, modes)[1]
    total += {"motor": (p.a - p.b * w) * w, "speed": -w * held.get("drive", [0.0])[0], "none": 0.0}[p.drive]
    for joint, mode in modes.items():
        if mode != "free":
            c = system.contact(joint, y)
            tangential = held[joint][0] if mode == "stick" else system.friction(c, mode)
            total -= p.C_n * c.v_n**2 + tangential * c.v_t
    return total - sum(rate @ system.lines[k].damping @ rate for k, (_, rate) in system.bend(y).items())


def touching(joints, drive, beams=SOFT):
    """A system of three bending links and a state in which its joints touch."""
    p = Parameters(i=3.0, f=0.3, C_t=2.0, drive=drive)
    system = Flexible(p, dict.fromkeys(joints, 1e-7), beams)
    return system, scattered(system, 3)


@pytest.mark.parametrize("drive", ["motor", "speed"])
@pytest.mark.parametrize("mode", ["slip+", "slip-", "stick"])
@pytest.mark.parametrize("joints", ["O", "A", "B", "C", "BC", "OABC"])
def test_energy_changes_by_the_powers(joints, mode, drive):
    """End slopes take part in friction and in the slip speed, or this fails."""
    system, y = touching(joints, drive)
    modes = dict.fromkeys(joints, mode)
    assert all(system.contact(joint, y).u > 0 for joint in joints)
    if mode == "stick":  # v_t is whatever the scattered state has: its power belongs to the held force
        assert system.forces(y, modes)[2] == pytest.approx(dict.fromkeys(joints, 0.0), abs=1e-4)
    expected = power(system, y, modes)
    assert slope(system.energy, y, system.rate(y, modes), 1e-9) == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("mode", ["slip+", "stick"])
@pytest.mark.parametrize("joints", ["O", "A", "B", "C", "OABC"])
def test_slip_acceleration_is_the_rate_of_the_slip_speed(joints, mode):
    limp = dict.fromkeys(LINKS, Beam(xi=0.05, modulus=2.1e4))  # bending is slow, so that differences see all
    system, y = touching(joints, "none", limp)
    modes = dict.fromkeys(joints, mode)
    direction, slips = system.rate(y, modes), system.forces(y, modes)[2]
    for joint in joints:
        found = slope(lambda state, joint=joint: system.contact(joint, state).v_t, y, direction)
        assert found == pytest.approx(slips[joint], abs=1e-3), joint


def momentum(system, y):
    """Linear momentum and angular momentum about the origin, particle by particle."""
    e, w, P, V = system.motion(y)
    bent, total = system.bend(y), np.zeros(3)
    for link in range(3):
        (c, s), (m, first, J) = e[link], system.remainder[link]
        n, lever = np.array([-s, c]), np.array([c, s])
        P_, V_ = np.array(P[link]), np.array(V[link])
        total[:2] += m * V_ + first * w[link] * n
        total[2] += np.cross([*P_, 0], [*(m * V_ + first * w[link] * n), 0])[2]
        total[2] += first * np.cross([*lever, 0], [*V_, 0])[2] + J * w[link]
        if link in system.lines:
            line, (q, rate) = system.lines[link], bent[link]
            y_, t_ = line.shape @ q, line.shape @ rate
            place = P_ + np.outer(line.x, lever) + np.outer(y_, n)
            speed = V_ + np.outer(line.x * w[link] + t_, n) - np.outer(y_ * w[link], lever)
            total[:2] += line.weight @ speed
            total[2] += line.weight @ (place[:, 0] * speed[:, 1] - place[:, 1] * speed[:, 0])
    return total


@pytest.mark.parametrize("joints", ["", "B", "A", "AB"])
def test_momentum_changes_by_the_ground_s_reactions(joints):
    """Weight, drive torque and the forces at O and C make the whole change of momentum."""
    p = Parameters(i=3.0, f=0.1)
    system = Flexible(p, dict.fromkeys(joints, 1e-7), SOFT)
    y = scattered(system, 4)
    if not joints:
        angles, speeds = loop(p, 0.4, p.w0)
        y[:3], y[system.n : system.n + 3] = angles, speeds
    modes = dict.fromkeys(joints, "slip+")
    held = system.forces(y, modes)[1]
    found = slope(lambda state: momentum(system, state), y, system.rate(y, modes), 1e-9)
    force = -held["O"] - held["C"]  # the stored force is on the bearing, here the ground
    weight = [-m * p.gravity for m in system.mass]
    assert found[:2] == pytest.approx(np.add(force, (0.0, sum(weight))), abs=1e-5 * np.abs(force).max())
    e, _, P, _ = system.motion(y)
    torque = p.a - p.b * y[system.n] - held["C"][1] * p.l4
    torque += sum(g * (P[k][0] + system.centre[k] * e[k][0]) for k, g in enumerate(weight))
    for k, (q, _) in system.bend(y).items():
        torque += p.gravity * e[k][1] * (system.lines[k].weight @ system.lines[k].shape @ q)
    assert found[2] == pytest.approx(torque, abs=1e-5 * np.abs(force).max() * p.l4)


def test_loop_is_closed_and_moves_as_it_should():
    p = Parameters(i=3.0)
    for angle in np.linspace(0, 2 * math.pi, 9):
        angles, speeds = loop(p, angle, 2.0)
        ahead, behind = (np.array(loop(p, angle + s, 2.0)[0]) for s in (1e-6, -1e-6))
        end = p.l3 * np.exp(1j * angle) + p.l1 * np.exp(1j * angles[1]) - p.l4 - p.l2 * np.exp(1j * angles[2])
        assert abs(end) < 1e-15
        assert speeds == pytest.approx(list((ahead - behind) / 1e-6), rel=1e-8)
    assert loop(p, 0.0, p.w0)[0] == pytest.approx(closure(p)[0])
    assert loop(p, 0.0, p.w0)[1] == pytest.approx(closure(p)[1])


def loads(p, angle):
    """Even part, and growth to the far end, of gravity and rigid inertia across the coupler, N/m."""
    (_, coupler, _), _ = loop(p, angle, p.w0)
    ahead, behind = (loop(p, angle + s, p.w0)[1][1] for s in (1e-5, -1e-5))
    across = p.l3 * p.w0**2 * math.sin(coupler - angle)  # of A's acceleration, to the crank's centre
    turning = (ahead - behind) / 2e-5 * p.w0
    return -p.m1 / p.l1 * np.array([p.gravity * math.cos(coupler) + across, p.l1 * turning])


def test_slow_motion_is_a_series_of_static_deflections():
    """Closed forms for even and growing load; modes of damping 1 lag behind by 2/omega."""
    stored, p = TRUTH["ideal_coupler_slowly"], SCENES["ideal_coupler_slowly"].parameters
    line = Line(Beam(xi=1.0), p.l1, p.m1)
    gauss = line.weight * p.l1 / p.m1
    unit = np.stack([gauss @ line.shape, (gauss * line.x / p.l1) @ line.shape], 1)
    lag = line.middle @ np.linalg.solve(line.stiffness, line.damping @ np.linalg.solve(line.stiffness, unit))
    for (angle, _, _), (_, deflection, _) in zip(stored["angle"], stored["deflection"], strict=True):
        static = loads(p, angle) @ [5 / 384, 5 / 768] * p.l1**4 / line.bending
        change = (loads(p, angle + 1e-4) - loads(p, angle - 1e-4)) / 2e-4 * p.w0
        assert deflection == pytest.approx(static - lag @ change, abs=1e-6 * abs(static))
        assert deflection != pytest.approx(static, abs=1e-5 * abs(static))


def test_undamped_motion_keeps_its_energy():
    scene, stored = SCENES["conservative"], TRUTH["conservative"]
    system = build(scene)
    assert len(stored["events"]) > 3
    assert stored["energy"] == pytest.approx([system.energy(system.start())] * 4, rel=1e-10)


@pytest.mark.parametrize(
    "name",
    ["ideal_rigid", *(pytest.param(n, marks=pytest.mark.nightly) for n in ("ideal_coupler", "B_coupler"))],
)
def test_stored_motion_is_found_again(name):
    stored, w0 = TRUTH[name], SCENES[name].parameters.w0
    scene = replace(SCENES[name], turns=SCENES[name].turns[:3])
    motion = follow(scene, rtol=1e-11)
    rows = [sample(motion, t, y) for t, y in zip(scene.times, motion.states, strict=True)]
    for row, angle, speed, deflection in zip(
        rows, stored["angle"], stored["angular_velocity"], stored["deflection"], strict=False
    ):
        assert row["angle"] == pytest.approx(angle, rel=0, abs=1e-11)
        assert row["angular_velocity"] == pytest.approx(speed, rel=0, abs=1e-9 * w0)
        assert row["deflection"] == pytest.approx(deflection, rel=1e-9)
    kinds = [[event.joint, event.kind] for event in motion.events]
    assert kinds == [event[1:3] for event in stored["events"] if event[0] <= scene.times[-1]]
