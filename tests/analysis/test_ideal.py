"""The mechanism without play: one freedom, forces at every pin, and what a mechanism with play approaches."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

import jointplay as jp
from jointplay.solver.mechanism.loops.ideal import ideal_state
from tests.support.linkages import bending, jointed

LINKS = ["crank", "coupler", "rocker"]
MOTION = ["angle", "angular_velocity", "angular_acceleration"]
FORCES = ["reaction_x", "reaction_y", "reaction", "drive_torque"]
SPEED = 83.8


def ideal(elastic=("coupler",), **changes):
    """The table's mechanism without play."""
    drive = {} if "speed" in changes else {"gear_ratio": 3.0}
    return jp.catalog.chunmei2002(clearance=0, elastic=elastic, **drive | changes)


def of(found, word, link):
    """Values of a word for one link, or pin."""
    return found[word].sel({"link" if link in LINKS else "pin": link}).values


@pytest.mark.parametrize("changes", [{}, {"speed": SPEED}, {"speed": -SPEED, "branch": "lower"}], ids=str)
@pytest.mark.parametrize("elastic", [(), ("coupler",)], ids=str)
def test_the_loop_is_closed_at_every_sample(elastic, changes):
    mechanism = ideal(elastic, **changes)
    found = jp.simulate(mechanism, turns=1, record=MOTION, samples_per_turn=60, initial={"crank_angle": 0.4})
    for i, angle in enumerate(of(found, "angle", "crank")):
        angles, speeds, _ = ideal_state(mechanism, angle, of(found, "angular_velocity", "crank")[i])
        for link in LINKS[1:]:
            assert of(found, "angle", link)[i] == pytest.approx(angles[link], abs=1e-13)
            assert of(found, "angular_velocity", link)[i] == pytest.approx(speeds[link], rel=1e-12)


def test_one_freedom_and_no_joint_with_play():
    found = jp.simulate(ideal(()), turns=0.1)
    assert list(found.pin.values) == ["O", "A", "B", "C"]
    assert "joint" not in found.dims
    assert not {"mode", "normal_force", "journal_x", "deflection"} & {*found}
    assert found.n_events == 0
    with pytest.raises(jp.InputError, match="a joint has clearance"):
        jp.simulate(ideal(()), turns=0.1, record=["normal_force"])


def test_a_constant_speed_is_one():
    found = jp.simulate(ideal(speed=SPEED), turns=2, record=MOTION)
    assert np.all(of(found, "angular_velocity", "crank") == SPEED)
    assert of(found, "angle", "crank") == pytest.approx(SPEED * found.time.values, abs=1e-12)
    assert np.all(of(found, "angular_acceleration", "crank") == 0.0)


def test_a_rigid_mechanism_gives_back_in_a_turn_what_it_takes():
    """Torque at constant speed: no work in a turn; the motor's: its line."""
    found = jp.simulate(ideal((), speed=SPEED), turns=1, record=[*MOTION, *FORCES], samples_per_turn=360)
    torque = found.drive_torque.values[:-1]
    assert abs(torque.mean()) < 1e-11 * np.abs(torque).max()
    mechanism = ideal(())
    found = jp.simulate(mechanism, turns=1, record=[*MOTION, *FORCES])
    line = mechanism.drive.stall_torque - mechanism.drive.slope * of(found, "angular_velocity", "crank")
    assert found.drive_torque.values == pytest.approx(line, rel=1e-12)


@pytest.mark.parametrize("changes", [{}, {"speed": SPEED}], ids=str)
def test_forces_at_the_pins_move_crank_and_rocker(changes):
    """Newton and Euler for the two rigid links, from their recorded motion; the coupler bends."""
    mechanism = ideal(**changes)
    found = jp.simulate(mechanism, turns=1, rtol=1e-10, record=[*MOTION, *FORCES])
    on_bearing = {k: np.array([of(found, f"reaction_{axis}", k) for axis in "xy"]) for k in "OABC"}
    journal = {"O": "crank", "A": "crank", "B": "coupler", "C": "rocker"}
    for link, ends in (("crank", "OA"), ("rocker", "CB")):
        part, angle = mechanism.link(link), of(found, "angle", link)
        w, turning = of(found, "angular_velocity", link), of(found, "angular_acceleration", link)
        e, n = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
        near, far = (on_bearing[k] * (-1 if journal[k] == link else 1) for k in ends)
        weight = np.array([[0.0], [-part.mass * 9.8]])
        momentum = part.mass * part.centre * (turning * n - w**2 * e)
        scale = np.abs(far).max()
        assert np.abs(near + far + weight - momentum).max() < 1e-10 * scale
        moment = part.length * np.sum(far * n, axis=0) + part.centre * np.sum(weight * n, axis=0)
        if link == "crank":
            moment = moment + found.drive_torque.values
        moments = np.abs(moment).max() + np.abs(found.drive_torque.values).max() * (link == "crank")
        assert np.abs(moment - part.inertia * turning).max() < 1e-9 * max(moments, scale * part.length)
    size = np.hypot(*on_bearing["A"])
    assert of(found, "reaction", "A") == pytest.approx(size, rel=1e-12)


def test_the_mirror_image_bends_the_other_way():
    upper = ideal(speed=SPEED)
    lower = upper.replace(speed=-SPEED, gravity=-upper.gravity, branch="lower")
    words = [*MOTION, *FORCES, "deflection"]
    found, image = (jp.simulate(m, turns=1, rtol=1e-11, record=words) for m in (upper, lower))
    signs = {"angle": -1, "angular_acceleration": -1, "deflection": -1, "reaction_x": 1, "reaction_y": -1}
    for word, sign in signs.items():
        scale = float(np.abs(found[word]).max())
        off = (image[word] - sign * found[word]).values
        off = np.sin(off) if word == "angle" else off
        assert np.abs(off).max() < 1e-8 * scale, word
    assert float(np.abs(found.deflection).max()) > 1e-6


E_VALUES = (4e-6, 2e-6, 1e-6)
STIFF = 7.15e9  # N/m: penetrations, 1e-8 m, are small against the clearances
QUARTER, WINDOW = 1000, 80


def with_play(e):
    """The mechanism with little play at B, contacts stiff and damped, hardly any friction."""
    loose = jp.catalog.chunmei2002(
        clearance=e, gear_ratio=3.0, friction=1e-9, elastic=("coupler",), damping_ratio=0.05
    )
    contact = jp.Contact(stiffness=STIFF, damping=math.sqrt(0.05 * STIFF))
    return jointed(loose, contact=contact)


def run(mechanism):
    """Angles, deflection and the force at A, averaged over the contact's ringing, once the start is past."""
    words = ["angle", "deflection", "reaction_x", "reaction_y"]
    found = jp.simulate(mechanism, turns=1, rtol=1e-9, record=words, samples_per_turn=4 * QUARTER)
    late = found.isel(time=slice(QUARTER, None))
    force = [
        np.convolve(of(late, f"reaction_{axis}", "A"), np.ones(WINDOW) / WINDOW, "valid") for axis in "xy"
    ]
    return late.angle.values, of(late, "deflection", "coupler"), np.array(force)


@pytest.mark.nightly
def test_play_that_vanishes_leaves_the_ideal_mechanism():
    """Angles are off by the order of e; deflection and force, which first impacts shake, fall at least so."""
    exact, off = run(with_play(1e-6).replace(clearance=0)), []
    for e in E_VALUES:
        pairs = zip(run(with_play(e)), exact, strict=True)
        off.append([np.abs(loose - firm).max() / np.abs(firm).max() for loose, firm in pairs])
    for wider, narrower in itertools.pairwise(off):
        angle, deflection, force = np.array(wider) / narrower
        assert angle == pytest.approx(2.0, abs=0.05)
        assert deflection > 1.9
        assert force > 1.9
    assert off[-1][0] < 1e-5
    assert off[-1][1] < 0.03
    assert off[-1][2] < 3e-3


def test_a_link_s_own_bending_does_not_move_the_others():
    """Deflections move no joint; at constant speed they change the forces alone."""
    rigid, bent = (
        jp.simulate(ideal(k, speed=SPEED), turns=1, record=[*MOTION, *FORCES]) for k in ((), ("coupler",))
    )
    assert np.abs(rigid.angle - bent.angle).max() < 1e-11
    assert 1e-3 < float(np.abs(rigid.reaction - bent.reaction).max() / rigid.reaction.max()) < 0.5


def test_at_rest_bending_changes_no_force():
    rigid = ideal((), speed=1e-9)
    still = bending(rigid, {"coupler": jp.Beam(damping_ratio=1.0)})
    found, firm = (
        jp.simulate(m, duration=1.0, record=FORCES, at=[1.0], initial={"crank_angle": 1.0})
        for m in (still, rigid)
    )
    for word in FORCES:
        assert found[word].values == pytest.approx(firm[word].values, rel=1e-5)
