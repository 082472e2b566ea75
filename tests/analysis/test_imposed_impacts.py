"""Impacts of rigid bearings where a drive imposes a speed that varies: it holds, and answers by work."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pytest

import jointplay as jp
from jointplay.analysis.quantities import EVENTS
from jointplay.solver.mechanism.catalog.presets import four_bar_pins
from jointplay.solver.mechanism.parts.courses import Harmonic
from jointplay.solver.mechanism.records import ConstantSpeed, SpeedCycle, SpeedProfile
from tests.support.driven_scenes import pinned
from tests.support.linkages import altered, jointed
from tests.support.multibody_records import from_mechanism

LENGTHS = {"crank": 0.04, "coupler": 0.12, "rocker": 0.08}
BALANCE = ["energy_residual", "drive_work", "joint_work", "energy"]
FAST = SpeedProfile(link="crank", start=30.0, end=40.0, time=0.2)
SLOW = SpeedProfile(link="crank", start=30.0, end=40.0, time=2.0)
STEADY = ConstantSpeed(link="crank", speed=35.0)
CYCLE = SpeedCycle(
    link="crank", constant=30.0, harmonics=(Harmonic(order=1, cosine=-2.0, sine=6.0),), frequency=25.0
)


def four_bar(drive, restitution=0.8, friction=0.0, mass=1.0, gravity=9.8, play_at="B", **bearing):
    """A four-bar of bars of equal mass, with play in one pin under restitution or what `bearing` says."""
    links = [
        jp.Link(name=name, length=l, mass=mass, centre=l / 2, inertia=mass * l * l / 3)
        for name, l in LENGTHS.items()
    ]
    law = jp.Contact(law="restitution", parameters={"restitution": restitution})
    rough = jp.Friction(coefficient=friction) if friction else None
    play = {"clearance": 1e-4, "radius": 0.01, "contact": law, "friction": rough} | bearing
    ends = four_bar_pins(0.04, 0.12, 0.08, 0.12)
    joints = [
        jp.Joint(name=name, journal=j, bearing=b, **(play if name == play_at else {}))
        for name, (j, b) in ends.items()
    ]
    return jp.Mechanism(links=links, joints=joints, drive=drive, gravity=gravity)


def imposed(drive, t):
    """The speed that a drive imposes, rad/s."""
    if drive.kind == "speed":
        return np.full(len(t), drive.speed)
    if drive.kind == "cycle":
        terms = (
            h.cosine * np.cos(h.order * drive.frequency * t) + h.sine * np.sin(h.order * drive.frequency * t)
            for h in drive.harmonics
        )
        return drive.constant + sum(terms)
    x = np.minimum(t / drive.time, 1.0)
    return drive.start + (drive.end - drive.start) * x**4 * (35 - 84 * x + 70 * x**2 - 20 * x**3)


def holds(found, drive):
    """Whether the crank has the imposed speed to rounding, and the balance closes."""
    speeds = found.angular_velocity.sel(link="crank").values
    assert found.status == 0
    assert np.abs(speeds - imposed(drive, found.time.values)).max() < 1e-12 * np.abs(speeds).max()
    assert np.abs(found.energy_residual).max() < 1e-8 * np.abs(found.energy).max()


@pytest.mark.parametrize(
    ("drive", "mass", "restitution", "least"),
    [(FAST, 1.0, 0.8, 100), (SLOW, 50.0, 0.8, 1000), (FAST, 1.0, 0.0, 6)],
)
def test_an_imposed_speed_holds_through_impacts_and_rest(drive, mass, restitution, least):
    """Of a smooth bearing, light and heavy, with rebounds and without."""
    mechanism = four_bar(drive, restitution, mass=mass)
    found = jp.simulate(mechanism, duration=drive.time, record=["angular_velocity", *BALANCE])
    assert found.sizes["event"] >= least
    holds(found, drive)


@pytest.mark.parametrize(
    ("drive", "pin", "friction"),
    [
        (STEADY, "A", 0.0),
        pytest.param(STEADY, "A", 0.2, marks=pytest.mark.nightly),
        pytest.param(CYCLE, "O", 0.0, marks=pytest.mark.nightly),
    ],
)
def test_impacts_at_the_driven_links_own_pins_are_work_of_the_drive_too(drive, pin, friction):
    """No unknown speed moves the driven link there, but the drive's speed is in the gap's rate."""
    found = jp.simulate(
        four_bar(drive, 0.6, friction, play_at=pin), duration=0.2, record=["angular_velocity", *BALANCE]
    )
    assert found.sizes["event"] > 10
    holds(found, drive)
    at = lambda gravity: four_bar(drive, 0.0, friction, gravity=gravity, play_at=pin)  # noqa: E731
    slope = jp.gradient(at(9.8), of=["work:drive", "time"], by=["gravity"], turns=1, rtol=1e-11)
    ends = [
        jp.simulate(at(g), duration=float(slope.value[1]), rtol=1e-12, record=BALANCE).drive_work.values[-1]
        for g in (9.8001, 9.7999)
    ]
    assert float(slope.derivative[0, 0]) == pytest.approx((ends[0] - ends[1]) / 2e-4, rel=1e-5)


@pytest.mark.parametrize("friction", [0.0, pytest.param(0.2, marks=pytest.mark.nightly)])
@pytest.mark.parametrize("drive", [FAST, pytest.param(CYCLE, marks=pytest.mark.nightly)])
def test_impacts_are_those_of_rigid_bodies_one_of_which_is_held(drive, friction):
    """Impulses N p and T q of bodies in full coordinates whose crank is held; its row has the drive's.

    Newton's and Coulomb's laws hold of them.
    """
    mechanism = four_bar(drive, 0.6, friction)
    words = ["angle", "angular_velocity", *BALANCE]
    found = jp.simulate(mechanism, duration=0.2, rtol=1e-10, steps=True, record=words)
    holds(found, drive)
    soft = four_bar(ConstantSpeed(link="crank", speed=30.0), contact=jp.Contact(stiffness=1.0, damping=0.0))
    system, times, worked = from_mechanism(soft), found.time.values, 0
    hits = found.event_time.values[found.event_kind.values == EVENTS.index("impact")][:12]
    for hit in hits:
        before, after = np.flatnonzero(times == hit)[[0, -1]]
        angles, speeds = found.angle.values[before], found.angular_velocity.values[[before, after]]
        now = system.solve(hit, in_full(angles, speeds[0]), [False]).now
        G, touch = system.constraints(now, system.ideal)[1], system.touches(now)[0][1]
        n, m = now.n, len(G)
        matrix = np.block([[np.diag(system.mass), G.T], [G, np.zeros((m, m))]])
        ways = np.zeros((n + m, 2))
        ways[:n, 0], ways[:n, 1] = -touch.W_n, -touch.W_t
        answers = np.linalg.solve(
            matrix, ways
        )  # of unit impulses; the last row is the drive's, on the ground
        jump = speeds[1] - speeds[0]
        (p, q), missed = np.linalg.lstsq(answers[2:n:3], jump, rcond=None)[:2]
        assert np.sqrt(missed.sum()) < 1e-7 * np.abs(jump).max()
        v_n, v_t = (W @ (now.v + answers[:n] @ (p, q)) for W in (touch.W_n, touch.W_t))
        assert v_n == pytest.approx(-0.6 * touch.v_n, rel=1e-6)
        assert abs(q) <= friction * p * (1 + 1e-6) + 1e-9 * p
        assert abs(v_t) < 1e-6 or q == pytest.approx(friction * p * np.sign(v_t), abs=1e-6 * p)
        work = -imposed(drive, hit) * (answers[-1] @ (p, q))
        taken = found.drive_work.values[after] - found.drive_work.values[before]
        assert taken == pytest.approx(work, rel=1e-6, abs=1e-12)
        worked += abs(work) > 1e-7
    assert worked >= 4


def in_full(angles, speeds):
    """Mass centres and angles of the three bars, and their speeds."""
    origins = {"crank": (0j, 0j), "rocker": (0.12 + 0j, 0j)}
    place, moving = [], []
    for (name, length), angle, speed in zip(LENGTHS.items(), angles, speeds, strict=True):
        along, (origin, moves) = length * np.exp(1j * angle), origins[name]
        if name == "crank":
            origins["coupler"] = origin + along, moves + 1j * speed * along
        centre, rate = origin + along / 2, moves + 1j * speed * along / 2
        place += [centre.real, centre.imag, angle]
        moving += [rate.real, rate.imag, speed]
    return np.array(place + moving)


KICKED = """
from dataclasses import replace
from jointplay.solver.equations import write
own = write.system
write.system = lambda structure: replace(own(structure), imposed={})
from tests.analysis.test_imposed_impacts import FAST, four_bar, jp
found = jp.simulate(four_bar(FAST), duration=0.01, record=["energy_residual"])
print(float(abs(found.energy_residual).max()))
"""  # an impact meets the crank as if nothing held it


@pytest.mark.long
def test_a_kick_of_the_driven_link_is_seen_in_the_balance(tmp_path):
    """The drive's work is that of its torque and impulses, and not what closes the balance."""
    given = {"NUMBA_DISABLE_JIT": "1", "JOINTPLAY_CACHE": str(tmp_path)}
    said = subprocess.run(
        [sys.executable, "-c", KICKED], env=os.environ | given, capture_output=True, text=True, check=True
    )
    assert float(said.stdout) > 1e-4


@pytest.mark.nightly
@pytest.mark.parametrize("friction", [0.0, 0.2])
def test_corners_of_a_guide_that_land_together_leave_the_speed_as_it_is(friction):
    plain = jp.catalog.slider_crank(clearance={"G": 2e-4}, gravity=9.8)
    law = jp.Contact(law="restitution", parameters={"restitution": 0.5})
    rubs = jp.Friction(coefficient=friction) if friction else None
    mechanism = jointed(altered(plain, drive=FAST), loose=True, contact=law, friction=rubs)
    found = jp.simulate(mechanism, duration=0.2, record=["angular_velocity", *BALANCE])
    assert (np.diff(found.event_time) == 0).sum() > 10
    holds(found, FAST)


def test_two_bearings_in_which_journals_rest_at_once_hold_them():
    found = jp.simulate(pinned(0.5, 0.0, 30.0, {"B": 1e-4, "C": 2e-4}), duration=0.02, record=BALANCE)
    assert [EVENTS[kind] for kind in found.event_kind.values].count("rest") == 3
    assert found.sizes["event"] < 60
    assert np.abs(found.energy_residual).max() < 1e-10 * np.abs(found.energy).max()


def light_block(restitution):
    """A quick return whose block has rigid corners in its guide, which moves."""
    plain = jp.catalog.quick_return(clearance={"S": 1e-4}, speed=20.0)
    law = jp.Contact(law="restitution", parameters={"restitution": restitution})
    return jointed(plain, loose=True, contact=law, friction=None)


@pytest.mark.nightly
def test_of_a_block_that_lies_flat_nothing_is_left_to_grow():
    """Its first rest takes the only direction: what rounding leaves of it is no exponent."""
    found = jp.lyapunov(light_block(0.0), transient=2, turns=4)
    assert float(found.section_exponent_per_turn[0]) == -np.inf


@pytest.mark.long
def test_two_corners_that_rest_on_a_guide_that_moves_are_put_back_together():
    """Taken in turn, next to nothing of what is left goes at a time: the block is light."""
    found = jp.simulate(light_block(0.6), turns=1, rtol=1e-10, record=BALANCE)
    resting = found.event_kind.values == EVENTS.index("rest")
    assert len(set(found.event_joint.values[resting])) > 1
    assert np.abs(found.energy_residual).max() < 1e-9 * np.abs(found.energy).max()
