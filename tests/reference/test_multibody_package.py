"""The package's motions against the second program's: states, forces, reactions, events, from records."""

from __future__ import annotations

import numpy as np
import pytest

import jointplay as jp
from tests.support.linkages import bending, jointed
from tests.support.multibody_records import from_mechanism, started
from tests.support.multibody_run import closed, follow

MOTION = ["angle", "angular_velocity", "angular_acceleration"]
FORCES = ["reaction_x", "reaction_y", "drive_torque"]
TOUCH = ["penetration", "normal_velocity", "tangential_velocity", "normal_force", "tangential_force"]
KINDS = {  # the second program's events in the package's words, by whether a force may pull
    True: {"contact": "contact", "separation": "separation"},
    False: {"contact": "contact", "release": "separation", "separation": "reopening", "reload": "contact"},
}
GENTLE = jp.Friction(law="tanh", coefficient=0.01, velocity=0.05, viscous=0.1)
SMOOTH = jp.Friction(law="tanh", coefficient=0.2, velocity=0.05, viscous=3.0)


def both(mechanism, crank_angle, turns, record):
    """A run of the package, the second program, and its states, solutions and events at the same times."""
    how = {"turns": turns, "rtol": 1e-11, "record": record, "samples_per_turn": round(24 / turns)}
    found = jp.simulate(mechanism, initial={"crank_angle": crank_angle}, **how)
    system, y = started(mechanism, crank_angle)
    times = found.time.values
    states, modes, events = follow(system, y, times, rtol=1e-13)
    rows = zip(times, states, modes, strict=True)
    return found, system, states, [system.solve(t, state, closed(mode)) for t, state, mode in rows], events


def agree(values, mine, tolerance, what, first=0):
    """The package's values are mine to a share of the largest, from a sample on."""
    values, mine = np.asarray(values)[first:], np.asarray(mine)[first:]
    assert np.abs(values - mine).max() <= tolerance * np.abs(values).max(), what


def same_motion(found, system, states, solved, tolerance):
    """Angles, speeds, accelerations of every link, and the forces at ideal joints."""
    for name, i in system.at.items():
        there = i + 2, system.n + i + 2
        columns = *(states[:, k] for k in there), [x.acceleration[i + 2] for x in solved]
        for word, mine in zip(MOTION, columns, strict=True):
            values = found[word].sel(link=name).values
            if np.abs(values).max() > 1e-9:
                agree(values, mine, tolerance, (word, name))
            else:
                assert np.abs(mine).max() < 1e-7
    for word, axis in (("reaction_x", 0), ("reaction_y", 1)):
        mine = [[x.reactions[pin][axis] for pin in found.pin.values] for x in solved]
        agree(found[word].values, mine, tolerance, word)


@pytest.mark.nightly
@pytest.mark.parametrize("changes", [{"gear_ratio": 3.0}, {"speed": -60.0, "branch": "lower"}], ids=str)
def test_the_mechanism_without_play(changes):
    """A third of a turn: motion, forces at all four joints, and the torque."""
    mechanism = jp.catalog.chunmei2002(clearance=0, **changes)
    found, system, states, solved, _ = both(mechanism, 0.3, 1 / 3, MOTION + FORCES)
    same_motion(
        found, system, states, solved, 1e-8
    )  # the steep line of the motor makes accelerations of errors in speed
    line = mechanism.drive
    if line.kind == "motor":
        torque = [line.stall_torque - line.slope * x.now.v[2] for x in solved]
    else:
        torque = [-x.reactions["drive"][2] for x in solved]
    agree(found.drive_torque, torque, 1e-8, "drive_torque")


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("tension", "smooth", "last"),
    [(True, None, "contact"), (False, GENTLE, "separation"), (False, SMOOTH, "reload")],
)
def test_the_mechanism_with_play_at_b(tension, smooth, last):
    """Through the first contacts, whose normal force may pull or not."""
    mechanism = jointed(jp.catalog.chunmei2002(gear_ratio=3.0, tension=tension), friction=smooth)
    found, system, states, solved, events = both(mechanism, 0.0, 0.05, [*MOTION, *FORCES, *TOUCH])
    assert last in [event.kind for event in events[2:]]
    same_motion(found, system, states, solved, 1e-8)
    touches = [x.touches[0] for x in solved]
    mine = [[x.u, x.v_n, x.v_t, F_n, F_t] for _, x, F_n, F_t in touches]
    for word, values in zip(TOUCH, np.transpose(mine), strict=True):
        agree(found[word], values[:, None], 1e-8, word)
    assert found.event_time.values == pytest.approx([event.time for event in events], abs=1e-11)
    words = np.array(found.event_kind.flag_meanings.split())[found.event_kind.values]
    assert list(words) == [KINDS[tension][event.kind] for event in events]


@pytest.mark.nightly
def test_the_mechanism_with_play_at_every_joint_and_friction():
    """The crank too is held by contacts alone, and turned by a motor."""
    plain = jp.catalog.chunmei2002(clearance=dict.fromkeys("OABC", 2.9e-5), gear_ratio=3.0)
    mechanism = jointed(plain, friction=SMOOTH)
    found, _, states, solved, events = both(mechanism, 0.0, 0.04, [*MOTION, *TOUCH])
    for word, mine in zip(MOTION[:2], (states[:, 2:9:3], states[:, 11::3]), strict=True):
        agree(found[word], mine, 1e-9, word)
    mine = [[[x.u, x.v_n, x.v_t, F_n, F_t] for _, x, F_n, F_t in row.touches] for row in solved]
    for word, values in zip(TOUCH, np.moveaxis(np.array(mine), 2, 0), strict=True):
        agree(
            found[word], values, 1e-7, word, first=1
        )  # journals start in the middle of bearings: no direction
    assert np.abs(found.tangential_force).max() > 1.0
    assert {*found.event_joint.values} == {0, 1, 2, 3}
    assert found.event_time.values == pytest.approx([event.time for event in events], abs=1e-10)
    assert list(found.event_joint.values) == [event.touch for event in events]


TABLE = jp.PrescribedTorque(link="crank", table=(0.0, 1.0, 0.5, -0.5), tolerance=1.0, nominal_speed=60.0)


def at_rest(mechanism):
    """The bodies of a mechanism, solved once."""
    system = from_mechanism(mechanism)
    return system.solve(0.0, np.zeros(2 * system.n), [False])


class Wider(jp.Mechanism):
    """A mechanism with a field that the second program does not know."""

    further: tuple = ()


def test_what_the_bodies_cannot_do_is_refused():
    plain = jp.catalog.chunmei2002(friction=0.0)
    fields = {name: getattr(plain, name) for name in type(plain).model_fields}
    wrong = {
        "fewer modes than elements": bending(plain, {"coupler": jp.Beam(modes=2)}),
        "a table is not known": plain.replace(drive=TABLE),
        "further of Wider": Wider(**fields, further=(1.0,)),
    }
    for words, mechanism in wrong.items():
        with pytest.raises(ValueError, match=words):
            at_rest(mechanism)
    assert len(from_mechanism(Wider(**fields)).bodies) == 3
