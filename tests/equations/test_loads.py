"""Loads and drives: exact integrals, virtual work, energy; a profile against the torque that it takes."""

from __future__ import annotations

import numpy as np
import pytest

from jointplay.display.errors import InputError
from jointplay.solver.codegen import outputs
from jointplay.solver.equations.structure import powers
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.parts.courses import series
from jointplay.solver.mechanism.parts.drive import (
    ConstantSpeed,
    PrescribedTorque,
    Servo,
    SpeedCycle,
    SpeedProfile,
)
from jointplay.solver.mechanism.parts.loads import Force, Torque
from tests.reference.four_bar import Parameters
from tests.support.linkages import mechanism
from tests.support.motion import at, double, follow, forces, pendulum, seen
from tests.support.plain import Point, plain

J = 0.1
TIMES = np.linspace(0.0, 1.0, 6)


def test_harmonics_of_time_on_a_free_link_integrate_exactly():
    nu, terms = 7.0, [{"order": 1, "cosine": 2.0}, {"order": 3, "sine": 1.5}]
    load = Torque(name="shake", link="arm", constant=0.3, harmonics=terms, frequency=nu, factor=2.0)
    free = pendulum(loads=(load,))
    _, states, _ = follow(free, at(free, [0.0], [0.0]), TIMES)
    by_cosine = 2.0 / nu**2 * (1 - np.cos(nu * TIMES))
    by_sine = 1.5 / (3 * nu) * (TIMES - np.sin(3 * nu * TIMES) / (3 * nu))
    exact = 2.0 / J * (0.15 * TIMES**2 + by_cosine + by_sine)
    assert states[:, 0] == pytest.approx(exact, abs=1e-10)


def test_a_torque_over_the_angle_does_its_integral_as_work():
    terms = [{"order": 1, "sine": -1.0}, {"order": 5, "cosine": 2.0, "sine": 0.7}]
    drive = PrescribedTorque(link="arm", constant=0.8, harmonics=terms, nominal_speed=6.0)
    turned = pendulum(drive=drive)
    model, states, work = follow(turned, at(turned, [0.4], [6.0]), TIMES)

    def integral(x):
        return 0.8 * x + np.cos(x) + 2.0 / 5 * np.sin(5 * x) - 0.7 / 5 * np.cos(5 * x)

    done = integral(states[:, 0]) - integral(0.4)
    assert J * (states[:, 1] ** 2 - 36.0) / 2 == pytest.approx(done, abs=1e-10)
    assert dict(zip(powers(model.structure), work.T, strict=True))["drive"] == pytest.approx(done, abs=1e-10)
    x = states[-1, 0]
    torque = 0.8 - np.sin(x) + 2.0 * np.cos(5 * x) + 0.7 * np.sin(5 * x)
    assert seen(model, states[-1])["drive_torque"] == pytest.approx(torque, rel=1e-12)


def tip(angles):
    """Place of the second link at 0.3 m."""
    return 0.4 * np.array([np.cos(angles[0]), np.sin(angles[0])]) + 0.3 * np.array(
        [np.cos(angles[1]), np.sin(angles[1])]
    )


@pytest.mark.parametrize("fixed", ["ground", "link"])
def test_a_force_does_virtual_work(fixed):
    """Q = F.dP/dq by central differences."""
    force = Force(name="push", on={"link": "hand", "at": 0.3}, direction=0.6, fixed=fixed, constant=11.0)
    pushed, angles = double(loads=(force,)), np.array([0.3, -0.7])
    model = assemble(pushed, at(pushed, angles, [0.0, 0.0]))
    direction = 0.6 + (angles[1] if fixed == "link" else 0.0)
    F = 11.0 * np.array([np.cos(direction), np.sin(direction)])
    Q, h = forces(model, model.state), 1e-6
    slopes = [F @ (tip(angles + h * unit) - tip(angles - h * unit)) / (2 * h) for unit in np.eye(2)]
    assert pytest.approx(slopes, rel=1e-8) == Q


def test_the_balance_of_energy_closes_and_pins_feel_the_load():
    loads = (
        Force(name="push", on={"link": "hand", "at": 0.3}, direction=0.6, constant=5.0),
        Force(
            name="turning",
            on={"link": "hand", "at": 0.1},
            direction=-1.0,
            fixed="link",
            harmonics=[{"order": 2, "cosine": 9.0}],
            angle="arm",
        ),
        Torque(name="shake", link="arm", harmonics=[{"order": 1, "sine": 3.0}], frequency=20.0),
    )
    pushed = double(gravity=9.8, loads=loads)
    model, states, work = follow(pushed, at(pushed, [0.3, -0.4], [1.0, 4.0]), TIMES)
    found = [seen(model, state, t) for state, t in zip(states, TIMES, strict=True)]
    energy = np.array([each["kinetic_energy"] + each["potential_energy"] for each in found])
    done = dict(zip(powers(model.structure), work.T, strict=True))["loads"]
    assert np.ptp(done) > 1.0
    assert energy - energy[0] == pytest.approx(done, abs=1e-9 * np.ptp(done))
    one = found[3]
    angle, bent = one["angle:arm"], one["angle:hand"] - 1.0
    x = 5.0 * np.cos(0.6) + 9.0 * np.cos(2 * angle) * np.cos(bent)
    y = 5.0 * np.sin(0.6) + 9.0 * np.cos(2 * angle) * np.sin(bent) - 1.5 * 9.8
    e, w, a = one["angle:hand"], one["angular_velocity:hand"], one["angular_acceleration:hand"]
    E, W, A = angle, one["angular_velocity:arm"], one["angular_acceleration:arm"]
    ax = -0.4 * (A * np.sin(E) + W**2 * np.cos(E)) - 0.15 * (a * np.sin(e) + w**2 * np.cos(e))
    ay = 0.4 * (A * np.cos(E) - W**2 * np.sin(E)) + 0.15 * (a * np.cos(e) - w**2 * np.sin(e))
    # the journal is on the hand: what it does to the bearing is what it feels less what it takes to move it
    assert one["reaction_x:A"] == pytest.approx(x - 1.5 * ax, abs=1e-10)
    assert one["reaction_y:A"] == pytest.approx(y - 1.5 * ay, abs=1e-10)


# Tables


def test_a_table_of_a_sine_is_that_sine():
    places = 2 * np.pi * np.arange(48) / 48
    found = series(tuple(2.0 + 3.0 * np.cos(places) - np.sin(2 * places) + 0.02 * np.cos(3 * places)), 1e-3)
    assert found.mean == pytest.approx(2.0)
    assert [n for n, _, _ in found.harmonics] == [1, 2, 3]
    assert np.ravel([row[1:] for row in found.harmonics]) == pytest.approx([3.0, 0.0, 0.0, -1.0, 0.02, 0.0])
    assert found.error < 1e-3


@pytest.mark.parametrize("count", [7, 8])
def test_a_table_of_few_values_is_passed_exactly(count):
    random = np.random.default_rng(count)
    table = tuple(random.standard_normal(count))
    found = series(table, 1e-9)
    places = 2 * np.pi * np.arange(count) / count
    terms = (a * np.cos(n * places) + b * np.sin(n * places) for n, a, b in found.harmonics)
    assert sum(terms, np.full(count, found.mean)) == pytest.approx(table, abs=1e-12)
    assert found.error > 1e-9


# A profile of speed


def test_a_profile_reaches_its_speed():
    profile = SpeedProfile(link="arm", start=2.0, end=-7.0, time=0.6)
    turned = pendulum(drive=profile)
    model, states, _ = follow(turned, at(turned, [0.5], [2.0]), np.array([0.0, 0.15, 0.3, 0.6, 1.0]))
    x = 0.25
    quarter = 35 * x**4 - 84 * x**5 + 70 * x**6 - 20 * x**7
    assert states[:, 1] == pytest.approx([2.0, 2.0 - 9.0 * quarter, -2.5, -7.0, -7.0], abs=1e-9)
    assert states[3:, 0] == pytest.approx([0.5 - 2.5 * 0.6, 0.5 - 2.5 * 0.6 - 7.0 * 0.4], abs=1e-9)
    assert seen(model, states[-1], 1.0)["angular_acceleration:arm"] == 0.0
    assert model.period == pytest.approx(2 * np.pi / 7.0)


def four_bar(joints, **changes):
    p = Parameters(i=3.0, drive="none", f=0.2)
    return mechanism(p, dict.fromkeys(joints, 2.9e-5)).replace(**changes)


SCENES = [
    ("B", ["stick"]),
    ("B", ["slip-"]),
    pytest.param("OA", ["stick", "slip+"], marks=pytest.mark.nightly),
    ("", []),
]


@pytest.mark.long
@pytest.mark.parametrize(("joints", "modes"), SCENES)
def test_a_profile_moves_all_as_the_torque_that_it_takes(joints, modes):
    """The same state under that torque as a load: every acceleration is the same."""
    profile = SpeedProfile(link="crank", start=10.0, end=90.0, time=0.2)
    model = assemble(four_bar(joints, drive=profile), {"crank_angle": 0.7, "crank_speed": 10.0})
    n_q, random, t = len(model.turning), np.random.default_rng(1), 0.07
    state = model.state + np.repeat([1e-4, 1.0], n_q) * random.standard_normal(2 * n_q)
    ours = Point(plain(model.structure), model.numbers, state, modes, t=t)
    rates = ours.rate()[:, 0]
    x = t / 0.2
    imposed = 140 * 80.0 / 0.2 * (x * (1 - x)) ** 3
    assert np.abs(rates / imposed - 1.0).min() < 1e-12
    torque = touched(model, state, modes, t)["drive_torque"]
    load = Torque(name="same", link="crank", constant=torque)
    other = assemble(four_bar(joints, loads=(load,)), {"crank_angle": 0.7, "crank_speed": 10.0})
    theirs = Point(plain(other.structure), other.numbers, state, modes).rate()[:, 0]
    assert rates == pytest.approx(theirs, abs=1e-9 * np.abs(theirs).max())


def touched(model, state, modes, t):
    functions = plain(model.structure)
    given = dict(zip(functions.STATE, [t, *state], strict=True))
    given |= dict(zip(functions.PARAMETERS, model.numbers, strict=True))
    for name, mode in zip(model.joints, modes, strict=True):
        given |= {f"touch_{name}": 1.0, f"stick_{name}": float(mode == "stick")}
        given |= {f"slip_{name}": {"slip+": 1.0, "slip-": -1.0}.get(mode, 0.0)}
    return {k: float(v) for k, v in outputs.evaluate(functions, ["drive_torque"], given).items()}


def test_a_profile_that_changes_nothing_is_a_constant_speed():
    held = assemble(four_bar("", drive=SpeedProfile(link="crank", start=40.0, end=40.0, time=0.2)))
    other = assemble(four_bar("", drive=ConstantSpeed(link="crank", speed=40.0)))
    one, same = seen(held, held.state, 0.1), seen(other, other.state, 0.1)
    for word in ("drive_torque", "reaction_x:B", "reaction_y:O", "angular_acceleration:rocker"):
        assert one[word] == pytest.approx(same[word], rel=1e-11)


# A cycle of speed

HARMONICS = [{"order": 1, "cosine": 6.0}, {"order": 3, "cosine": -2.0, "sine": 4.0}]
CYCLE = SpeedCycle(link="crank", constant=40.0, harmonics=HARMONICS, frequency=30.0)


def speed_of(cycle, t):
    """Angle turned, speed and acceleration of a cycle at a time, by its harmonics."""
    each = [(h.order * cycle.frequency, h.cosine, h.sine) for h in cycle.harmonics]
    turned = cycle.constant * t + sum((a * np.sin(w * t) + b * (1 - np.cos(w * t))) / w for w, a, b in each)
    speed = cycle.constant + sum(a * np.cos(w * t) + b * np.sin(w * t) for w, a, b in each)
    return turned, speed, sum(w * (b * np.cos(w * t) - a * np.sin(w * t)) for w, a, b in each)


def test_a_cycle_has_the_speed_that_was_asked_for():
    turned = pendulum(drive=CYCLE.model_copy(update={"link": "arm"}))
    times = np.array([0.0, 0.05, 0.11, 0.3])
    model, states, _ = follow(turned, at(turned, [0.5], [CYCLE.start_speed]), times)
    for t, state in zip(times, states, strict=True):
        angle, speed, acceleration = speed_of(CYCLE, t)
        assert state == pytest.approx([0.5 + angle, speed], abs=1e-9)
        assert seen(model, state, t)["angular_acceleration:arm"] == pytest.approx(acceleration, rel=1e-12)
    assert model.period == pytest.approx(2 * np.pi / 40.0)


def test_a_table_of_speeds_is_the_series_through_it():
    phase = 2 * np.pi * np.arange(24) / 24
    table = tuple(float(speed_of(CYCLE, p / CYCLE.frequency)[1]) for p in phase)
    tabled = SpeedCycle(link="crank", table=table, tolerance=1e-2, frequency=30.0)
    assert tabled.nominal_speed == pytest.approx(40.0)
    assert tabled.start_speed == pytest.approx(CYCLE.start_speed, abs=1e-2 * np.ptp(table))


@pytest.mark.parametrize(("joints", "modes"), SCENES)
def test_a_cycle_moves_all_as_the_torque_that_it_takes(joints, modes):
    start = {"crank_angle": 0.7, "crank_speed": CYCLE.start_speed}
    model = assemble(four_bar(joints, drive=CYCLE), start)
    n_q, random, t = len(model.turning), np.random.default_rng(1), 0.07
    state = model.state + np.repeat([1e-4, 1.0], n_q) * random.standard_normal(2 * n_q)
    rates = Point(plain(model.structure), model.numbers, state, modes, t=t).rate()[:, 0]
    assert np.abs(rates / speed_of(CYCLE, t)[2] - 1.0).min() < 1e-12
    load = Torque(name="same", link="crank", constant=touched(model, state, modes, t)["drive_torque"])
    other = assemble(four_bar(joints, loads=(load,)), start)
    theirs = Point(plain(other.structure), other.numbers, state, modes).rate()[:, 0]
    assert rates == pytest.approx(theirs, abs=1e-9 * np.abs(theirs).max())


@pytest.mark.parametrize(
    ("wrong", "key"),
    [
        ({"constant": 3.0}, "table"),
        ({"harmonics": HARMONICS}, "constant"),
        ({"table": [1.0, 2.0]}, "table"),
        ({"constant": 3.0, "harmonics": HARMONICS, "frequency": 0.0}, "frequency"),
    ],
)
def test_a_cycle_that_is_none_is_refused(wrong, key):
    with pytest.raises(InputError, match=rf"drive\.{key}"):
        SpeedCycle(link="crank", **({"frequency": 30.0} | wrong))


# A servo

GAINS = {"link": "arm", "stiffness": 8.0, "damping": 0.3, "nominal_speed": 6.0}
SWING = [{"order": 2, "cosine": 0.2, "sine": -0.1}]
FOLLOWING = Servo(**GAINS, speed=6.0, constant=0.4, harmonics=SWING, frequency=7.0)


def wanted(t):
    """Angle, speed and acceleration that the servo wants."""
    nu, c, s = 14.0, np.cos(14.0 * t), np.sin(14.0 * t)
    angle = 6.0 * t + 0.4 + 0.2 * c - 0.1 * s
    return angle, 6.0 - nu * (0.2 * s + 0.1 * c), -(nu**2) * (0.2 * c - 0.1 * s)


def test_what_a_servo_lacks_decays_as_an_oscillator():
    """J x'' + K_d x' + K_p x = -J phi'': free oscillation beside a forced one of the course's frequency."""
    pulled = pendulum(drive=FOLLOWING)
    model, states, work = follow(pulled, at(pulled, [1.0], [2.0]), TIMES)
    forced = -J * -(14.0**2) * (0.2 + 0.1j) / (8.0 - J * 14.0**2 + 0.3 * 14.0j)  # of exp(14 i t), real part
    x0, v0 = 1.0 - wanted(0.0)[0] - forced.real, 2.0 - wanted(0.0)[1] - (14.0j * forced).real
    damped, own = 0.3 / (2 * J), np.sqrt(8.0 / J - (0.3 / (2 * J)) ** 2)
    free = np.exp(-damped * TIMES) * (
        x0 * np.cos(own * TIMES) + (v0 + damped * x0) / own * np.sin(own * TIMES)
    )
    exact = wanted(TIMES)[0] + free + (forced * np.exp(14.0j * TIMES)).real
    assert states[:, 0] == pytest.approx(exact, abs=1e-9)
    gained = J * (states[:, 1] ** 2 - 4.0) / 2
    assert dict(zip(powers(model.structure), work.T, strict=True))["drive"] == pytest.approx(gained, abs=1e-9)
    angle, speed, _ = wanted(TIMES[-1])
    torque = 8.0 * (angle - states[-1, 0]) + 0.3 * (speed - states[-1, 1])
    assert seen(model, states[-1], TIMES[-1])["drive_torque"] == pytest.approx(torque, rel=1e-12)


def test_a_servo_that_is_fed_what_is_needed_lacks_nothing():
    """Inertia times wanted acceleration, and as much again as a load of sin and time takes away."""
    load = Torque(name="drag", link="arm", constant=-0.7)
    text = {"J": "0.1", "inertia": "J*wanted_acceleration + tanh(0*angular_velocity)"}
    fed = FOLLOWING.model_copy(
        update={"where": text, "feedforward": "inertia + 0.7*(sin(angle)**2 + cos(angle)**2)"}
    )
    _, states, _ = follow(
        held := pendulum(drive=fed, loads=(load,)), at(held, [wanted(0.0)[0]], [wanted(0.0)[1]]), TIMES
    )
    assert fed.start_speed == pytest.approx(wanted(0.0)[1])
    assert states[:, 0] == pytest.approx(wanted(TIMES)[0], abs=1e-9)


@pytest.mark.parametrize(
    ("wrong", "key"),
    [
        ({"stiffness": 0.0}, "stiffness"),
        ({"damping": -1.0}, "damping"),
        ({"nominal_speed": 0.0}, "nominal_speed"),
        ({"harmonics": SWING}, "frequency"),
        ({"frequency": 3.0}, "frequency"),
        ({"feedforward": "sin(angel)"}, "feedforward"),
        ({"feedforward": "2*abs(angle)"}, "feedforward"),
        ({"where": {"a": "b", "b": "1"}, "feedforward": "a"}, "where.a"),
        ({"where": {"angle": "1"}, "feedforward": "angle"}, "where.angle"),
        ({"where": {"a": "1 +"}, "feedforward": "a"}, "where.a"),
    ],
)
def test_a_servo_that_is_none_is_refused(wrong, key):
    with pytest.raises(InputError, match=rf"drive\.{key}"):
        Servo(**(GAINS | {"speed": 6.0} | wrong))


def test_a_servos_numbers_can_be_swept():
    text = {"where": {"a": "2*angle"}, "feedforward": "a"}
    made = pendulum(drive=Servo(**GAINS, **text, speed=6.0))
    swept = [made.varied({"drive.stiffness": value}).drive for value in (5.0, 5.0, 7.0)]
    assert [drive.stiffness for drive in swept] == [5.0, 5.0, 7.0]
    assert swept[0] == swept[1] != swept[2]
