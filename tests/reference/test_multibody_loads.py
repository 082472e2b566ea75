"""Springs, point masses and gravity in any direction: the package against the second program."""

from __future__ import annotations

import numpy as np
import pytest

import jointplay as jp
from jointplay.solver.mechanism.records import TorsionSpring
from tests.reference.test_multibody_package import FORCES, MOTION, agree, both, same_motion
from tests.support import driven_scenes
from tests.support.driven_scenes import LOADS, PROFILE, TORQUE, weighted
from tests.support.linkages import altered

SPRINGS = (
    *driven_scenes.SPRINGS,
    TorsionSpring(name="hinge", **{"from": "rocker"}, to="ground", stiffness=3.0, angle=1.0),
    TorsionSpring(name="start", **{"from": "crank"}, to="ground", stiffness=3.0, damping=0.1, angle=1.0),
)


def loaded(mechanism):
    """The mechanism with springs, gravity to the side, and point masses on crank and rocker."""
    springs = SPRINGS if mechanism.clearance_joints else (SPRINGS[0], SPRINGS[-1])
    return altered(weighted(mechanism), springs=springs, loads=LOADS, gravity_direction=0.4)


@pytest.mark.parametrize(
    "changes", [pytest.param({"gear_ratio": 3.0}, marks=pytest.mark.nightly), {"speed": -60.0}], ids=str
)
def test_the_loaded_mechanism_without_play(changes):
    mechanism = loaded(jp.catalog.chunmei2002(clearance=0, **changes))
    found, system, states, solved, _ = both(mechanism, 0.3, 1 / 3, MOTION + FORCES)
    same_motion(found, system, states, solved, 1e-8)
    bare, *_ = both(jp.catalog.chunmei2002(clearance=0, **changes), 0.3, 1 / 3, MOTION + FORCES)
    assert np.abs(found.drive_torque - bare.drive_torque).max() > 0.01 * np.abs(bare.drive_torque).max()


@pytest.mark.nightly
def test_the_loaded_mechanism_with_play_at_b():
    mechanism = loaded(jp.catalog.chunmei2002(gear_ratio=3.0, friction=0.0))
    found, system, states, solved, events = both(mechanism, 0.0, 0.05, [*MOTION, *FORCES, "normal_force"])
    assert len(events) >= 1
    same_motion(found, system, states, solved, 1e-8)
    agree(found.normal_force, [[x.touches[0][2]] for x in solved], 1e-8, "normal_force")
    assert found.event_time.values == pytest.approx([event.time for event in events], abs=1e-11)


@pytest.mark.nightly
@pytest.mark.parametrize("drive", [TORQUE, PROFILE], ids=lambda drive: drive.kind)
@pytest.mark.parametrize("clearance", [0, 2.9e-5])
def test_drives(drive, clearance):
    mechanism = jp.catalog.chunmei2002(clearance=clearance, friction=0.0, drive=drive)
    found, system, states, solved, events = both(mechanism, 0.3, 0.2, MOTION + FORCES)
    same_motion(found, system, states, solved, 1e-8)
    assert bool(events) == bool(clearance)
    if drive.kind == "profile":
        agree(found.drive_torque, [-x.reactions["drive"][2] for x in solved], 1e-8, "drive_torque")
