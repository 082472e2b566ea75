"""The bodies of the four-bar: another derivation, the printed energy, mechanics' laws, stored motions."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

from tests.support.multibody import Body, Now, System

from .four_bar import LINKS, Beam, FourBar, Parameters, by_name, loop, scattered
from .motion import follow
from .scenes import BENT, SCENES
from .test_beams import textbook

HERE = Path(__file__).parent
TRUTH, BENT_TRUTH = (json.loads((HERE / f"{name}.json").read_text()) for name in ("truth", "flexible_truth"))
SOFT, LIMP = Beam(xi=0.05, modulus=2.1e8), Beam(xi=0.05, modulus=2.1e4)  # bending has its share; is slow
SIZES = 1e-3, 5.0, 3e-5, 0.3  # of a scattered state: bending a tenth of a millimetre


def flexible(p, joints, e=1e-7, beam=SOFT):
    """The four-bar with three bending links and play at joints."""
    rows = {name: beam.row(*p.links[name][:2]) for name in LINKS}
    return FourBar(p, dict.fromkeys(joints, e), rows)


@pytest.mark.peer
@pytest.mark.parametrize("drive", ["motor", "speed", "none"])
@pytest.mark.parametrize("mode", ["free", "slip+", "slip-", "stick"])
@pytest.mark.parametrize("joints", ["O", "A", "B", "C", "BC", "AC", "OABC"])
def test_free_bodies_and_virtual_work_agree(joints, mode, drive):
    hy = pytest.importorskip("heyoka")
    from .taylor import Series

    parameters = Parameters(i=3.0, f=0.1, C_t=2.0, drive=drive)
    system, modes = FourBar(parameters, dict.fromkeys(joints, 2.9e-4)), dict.fromkeys(joints, mode)
    series = Series(system, real=np.float64)
    accelerations, held = series.equations(modes)
    function = hy.cfunc([*accelerations, *held.values()], series.q + series.v, compact_mode=True)
    sign = np.full(function.nparams, -1.0 if mode == "slip-" else 1.0)
    y = scattered(system, seed=3)
    other = function(y, pars=sign) if len(sign) else function(y)
    sticking = [F_t for *_, F_t in system.at_modes(y, modes).touches] if mode == "stick" else []
    mine = np.array([*system.rate(y, modes)[system.half :], *sticking])
    assert np.max(np.abs(mine - other)) < 1e-10 * np.max(np.abs(mine))


def test_free_coordinates_and_all_of_them_say_the_same():
    system = flexible(Parameters(), "BC")
    y = scattered(system, 1, SIZES)
    assert system.reduced(system.full(y)) == pytest.approx(y, rel=1e-12, abs=1e-15)


def body(order):
    """The coupler alone, bending."""
    p = Parameters()
    length, mass, inertia = p.links["coupler"]
    row = SOFT.row(length, mass, order)
    alone = Body("coupler", mass, inertia - mass * length**2 / 4, length / 2, row)
    return System([alone], [], gravity=p.gravity), row, mass, inertia


def inertial(order, x, u, a):
    """Forces on origin, frame angle and nodal coordinates that the coupler's motion takes."""
    system, row, *_ = body(order)
    s, (c, d), w = row.length / 2, (math.cos(x[2]), math.sin(x[2])), u[2]
    e, n = np.array([c, d]), np.array([-d, c])
    q, v, at = np.array(x), np.array(u), np.array(a)
    q[:2], v[:2], at[:2] = q[:2] + s * e, v[:2] + s * w * n, at[:2] + s * (a[2] * n - w**2 * e)
    M, Q = system.inertia(Now(system, 0.0, np.r_[q, v]))
    Q[3:] += row.stiffness @ q[3:] + row.damping @ v[3:]
    found = M @ at - Q
    found[2] += s * n @ found[:2]
    return found


def printed(row, mass, J, g):
    """Sides of Lagrange's equations for T_j and gravity as MODEL.md prints them, as a function of numbers."""
    first, n = mass * row.length / 2, row.size
    x, u, a = (sp.symbols(f"{letter}:{3 + n}") for letter in "xua")
    q, rate = sp.Matrix(x[3:]), sp.Matrix(u[3:])
    M, _, S, I = (sp.Matrix(part) for part in textbook(SOFT, row.length, mass))
    along = u[0] * sp.cos(x[2]) + u[1] * sp.sin(x[2])
    across = u[1] * sp.cos(x[2]) - u[0] * sp.sin(x[2])
    sigma, w = S.dot(q), u[2]
    T = mass * (u[0] ** 2 + u[1] ** 2) / 2 + first * w * across + J * w**2 / 2
    T += (
        across * S.dot(rate)
        + w * I.dot(rate)
        + rate.dot(M * rate) / 2
        - w * along * sigma
        + w**2 * q.dot(M * q) / 2
    )
    V = g * (mass * x[1] + first * sp.sin(x[2]) + sp.cos(x[2]) * sigma)
    momentum = sp.Matrix([sp.diff(T, v) for v in u])
    change = momentum.jacobian(u) * sp.Matrix(a) + momentum.jacobian(x) * sp.Matrix(u)
    return sp.lambdify([x, u, a], change - sp.Matrix([sp.diff(T - V, v) for v in x]))


def test_link_equations_follow_from_the_printed_energy():
    system, row, mass, J = body("consistent")
    random = np.random.default_rng(5)
    x, u, a = random.standard_normal((3, 7)) * [1, 1, 1, 0.02, 0.003, 0.02, 0.02]
    x[3:], u[2] = 0.1 * x[3:], 10.0
    expected = np.ravel(printed(row, mass, J, system.gravity)(x, u, a))
    found = inertial("consistent", x, u, a)
    assert found == pytest.approx(expected, abs=1e-12 * np.abs(expected).max())


def test_paper_order_keeps_only_what_the_paper_prints():
    """(9)-(12): S q'' on the origin along n, I q'' on the angle, and the inertial load on the beam."""
    p, random = Parameters(), np.random.default_rng(6)
    angle, w, q, rate = 0.7, 11.0, 1e-3 * random.standard_normal(4), random.standard_normal(4)
    A, turn, bend = np.array([3.0, -40.0]), 55.0, random.standard_normal(4)
    found = inertial("paper", [0.1, 0.2, angle, *q], [0.3, 0.4, w, *rate], [*A, turn, *bend])
    e, n = np.array([math.cos(angle), math.sin(angle)]), np.array([-math.sin(angle), math.cos(angle)])
    M, _, S, I = textbook(SOFT, p.l1, p.m1)
    s = p.l1 / 2
    force = p.m1 * (A + s * turn * n - s * w**2 * e + [0.0, p.gravity]) + S @ bend * n
    moment = p.J_A * turn + p.m1 * s * (A @ n + p.gravity * e[0]) + I @ bend
    inner = S * (A @ n + p.gravity * e[0]) + I * turn + M @ bend
    assert found == pytest.approx(np.concatenate([force, [moment], inner]), rel=1e-12)


def slope(function, y, direction, step=1e-7):
    """Derivative of a function of the state along a direction, by differences of fourth order."""
    d = step * direction
    near, far = (np.subtract(function(y + k * d), function(y - k * d)) for k in (1, 2))
    return (8 * near - far) / (12 * step)


def power(system, y, modes):
    """Power of drive, contact damping, friction and structural damping, W."""
    p, solved = system.p, system.at_modes(y, modes)
    w, now = y[system.half], solved.now
    given = {"motor": (p.a - p.b * w) * w, "speed": -w * solved.reactions.get("drive", [0, 0, 0])[2]}
    lost = sum(p.C_n * touch.v_n**2 + F_t * touch.v_t for _, touch, _, F_t in solved.touches)
    bending = sum(now.v[own] @ row.damping @ now.v[own] for row, own in system.beams.values())
    return given.get(p.drive, 0.0) - lost - bending


@pytest.mark.parametrize("drive", ["motor", "speed"])
@pytest.mark.parametrize("mode", ["slip+", "slip-", "stick"])
@pytest.mark.parametrize("joints", ["O", "A", "B", "C", "BC", "OABC"])
def test_energy_changes_by_the_powers(joints, mode, drive):
    """End slopes take part in friction and in the slip speed, or this fails."""
    system, modes = (
        flexible(Parameters(i=3.0, f=0.3, C_t=2.0, drive=drive), joints),
        dict.fromkeys(joints, mode),
    )
    y = scattered(system, 3, SIZES)
    assert all(system.touch(joint, y).u > 0 for joint in joints)
    if mode == "stick":  # v_t is whatever the scattered state has: its power belongs to the held force
        slips = by_name(system.at_modes(y, modes))[1]
        assert slips == pytest.approx(dict.fromkeys(joints, 0.0), abs=1e-4)

    def energy(state):
        return system.energy(0.0, system.full(state), [True] * len(joints))

    expected = power(system, y, modes)
    assert slope(energy, y, system.rate(y, modes), 1e-9) == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("mode", ["slip+", "stick"])
@pytest.mark.parametrize("joints", ["O", "A", "B", "C", "OABC"])
def test_slip_acceleration_is_the_rate_of_the_slip_speed(joints, mode):
    system = flexible(Parameters(i=3.0, f=0.3, C_t=2.0, drive="none"), joints, beam=LIMP)
    y, modes = scattered(system, 3, SIZES), dict.fromkeys(joints, mode)
    direction, slips = system.rate(y, modes), by_name(system.at_modes(y, modes))[1]
    for joint in joints:
        found = slope(lambda state, joint=joint: system.touch(joint, state).v_t, y, direction)
        assert found == pytest.approx(slips[joint], abs=1e-3), joint


def momentum(system, y):
    """Linear momentum and angular momentum about the origin, particle by particle."""
    now, total = Now(system, 0.0, system.full(y)), np.zeros(3)

    def add(mass, places, speeds):
        total[:2] += mass @ speeds
        total[2] += mass @ (places[:, 0] * speeds[:, 1] - places[:, 1] * speeds[:, 0])

    for one in system.bodies:
        i = system.at[one.name]
        c, s, w = math.cos(now.q[i + 2]), math.sin(now.q[i + 2]), now.v[i + 2]
        e, n, centre, speed = np.array([c, s]), np.array([-s, c]), now.q[i : i + 2], now.v[i : i + 2]
        add(np.array([one.mass]), centre[None], speed[None])
        total[2] += one.inertia * w
        row, own = system.beams[one.name]
        for sign, q, v in ((1.0, now.q[own], now.v[own]), (-1.0, np.zeros(row.size), np.zeros(row.size))):
            x, up, rate = row.x - one.centre, row.across @ q, row.across @ v
            places = centre + np.outer(x, e) + np.outer(up, n)
            add(sign * row.weight, places, speed + np.outer(x * w + rate, n) - np.outer(up * w, e))
    return total


@pytest.mark.parametrize("joints", ["", "B", "A", "AB"])
def test_momentum_changes_by_the_ground_s_reactions(joints):
    """Weight, drive torque and the forces at O and C make the whole change of momentum."""
    p = Parameters(i=3.0, f=0.1)
    system, modes = flexible(p, joints), dict.fromkeys(joints, "slip+")
    y = scattered(system, 4, SIZES)
    solved = system.at_modes(y, modes)
    held, now = {name: force[:2] for name, force in solved.reactions.items()}, solved.now
    found = slope(lambda state: momentum(system, state), y, system.rate(y, modes), 1e-9)
    force = -held["O"] - held["C"]  # the stored force is on the bearing, here the ground
    weights = {one.name: -one.mass * p.gravity for one in system.bodies}
    total = np.add(force, (0.0, sum(weights.values())))
    assert found[:2] == pytest.approx(total, abs=1e-5 * np.abs(force).max())
    torque = p.a - p.b * y[system.half] - held["C"][1] * p.l4
    for name, (row, own) in system.beams.items():
        i = system.at[name]
        torque += weights[name] * now.q[i]
        torque += p.gravity * math.sin(now.q[i + 2]) * (row.weight @ row.across @ now.q[own])
    assert found[2] == pytest.approx(torque, abs=1e-5 * np.abs(force).max() * p.l4)


def test_loop_is_closed_and_moves_as_it_should():
    p = Parameters(i=3.0)
    for angle in np.linspace(0, 2 * math.pi, 9):
        angles, speeds = loop(p, angle, 2.0)
        ahead, behind = (np.array(loop(p, angle + s, 2.0)[0]) for s in (1e-6, -1e-6))
        end = p.l3 * np.exp(1j * angle) + p.l1 * np.exp(1j * angles[1]) - p.l4 - p.l2 * np.exp(1j * angles[2])
        assert abs(end) < 1e-15
        assert speeds == pytest.approx(list((ahead - behind) / 1e-6), rel=1e-8)


def loads(p, angle):
    """Even part, and growth to the far end, of gravity and rigid inertia across the coupler, N/m."""
    (_, coupler, _), _ = loop(p, angle, p.w0)
    ahead, behind = (loop(p, angle + s, p.w0)[1][1] for s in (1e-5, -1e-5))
    across = p.l3 * p.w0**2 * math.sin(coupler - angle)  # of A's acceleration, to the crank's centre
    turning = (ahead - behind) / 2e-5 * p.w0
    return -p.m1 / p.l1 * np.array([p.gravity * math.cos(coupler) + across, p.l1 * turning])


def test_slow_motion_is_a_series_of_static_deflections():
    """Closed forms for even and growing load; modes of damping 1 lag behind by 2/omega."""
    stored, p = BENT_TRUTH["ideal_coupler_slowly"], BENT["ideal_coupler_slowly"].parameters
    beam = Beam(xi=1.0)
    row, stiffness = beam.row(p.l1, p.m1), beam.stiffness(p.l1, p.m1)[0]
    gauss = row.weight * p.l1 / p.m1
    unit = np.stack([gauss @ row.across, (gauss * row.x / p.l1) @ row.across], 1)
    lag = row.middle @ np.linalg.solve(row.stiffness, row.damping @ np.linalg.solve(row.stiffness, unit))
    for (angle, _, _), (_, deflection, _) in zip(stored["angle"], stored["deflection"], strict=True):
        static = loads(p, angle) @ [5 / 384, 5 / 768] * p.l1**4 / stiffness
        change = (loads(p, angle + 1e-4) - loads(p, angle - 1e-4)) / 2e-4 * p.w0
        assert deflection == pytest.approx(static - lag @ change, abs=1e-6 * abs(static))
        assert deflection != pytest.approx(static, abs=1e-5 * abs(static))


def test_undamped_rigid_motion_keeps_its_energy():
    scene = replace(SCENES["conservative_at_BC"], turns=(0.03,))
    system, motion = scene.system, follow(scene, rtol=1e-11)
    (state,) = motion.states
    assert len(motion.events) > 3
    before = system.energy(0.0, system.full(system.start()))
    assert system.energy(state.t, state.y, state.modes) == pytest.approx(before, rel=1e-10)


def test_undamped_bending_keeps_its_energy():
    stored, system = BENT_TRUTH["conservative"], BENT["conservative"].system
    assert len(stored["events"]) > 3
    assert stored["energy"] == pytest.approx([system.energy(0.0, system.full(system.start()))] * 4, rel=1e-10)


@pytest.mark.nightly
@pytest.mark.parametrize("name", ["B", "B_sticking", "damped_at_BC"])
def test_stored_truth_is_found_again(name):
    scene, stored = SCENES[name], TRUTH[name]
    motion = follow(scene, rtol=1e-11)
    angles, speeds = (half[:3] for half in np.split(motion.end, 2))
    assert motion.kinds == [row[1:3] for row in stored["events"]]
    assert angles == pytest.approx([*stored["angles"].values()], rel=0, abs=1e-11)
    assert speeds == pytest.approx([*stored["speeds"].values()], rel=0, abs=1e-11 * scene.parameters.w0)


@pytest.mark.parametrize(
    "name",
    ["ideal_rigid", *(pytest.param(n, marks=pytest.mark.nightly) for n in ("ideal_coupler", "B_coupler"))],
)
def test_stored_motion_is_found_again(name):
    stored, w0 = BENT_TRUTH[name], BENT[name].parameters.w0
    scene = replace(BENT[name], turns=BENT[name].turns[:3])
    motion = follow(scene, rtol=1e-11)
    for row, angle, speed, deflection in zip(
        motion.samples(), stored["angle"], stored["angular_velocity"], stored["deflection"], strict=False
    ):
        assert row["angle"] == pytest.approx(angle, rel=0, abs=1e-11)
        assert row["angular_velocity"] == pytest.approx(speed, rel=0, abs=1e-9 * w0)
        assert row["deflection"] == pytest.approx(deflection, rel=1e-9)
    assert motion.kinds == [event[1:3] for event in stored["events"] if event[0] <= scene.times[-1]]
