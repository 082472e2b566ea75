"""Springs, point masses and gravity in any direction: the package against the second program."""

from __future__ import annotations

import numpy as np
import pytest

import jointplay as jp
from jointplay.mechanism.records import (
    Force,
    Harmonic,
    Link,
    Pin,
    PointMass,
    PrescribedTorque,
    SpeedProfile,
    Spring,
    Torque,
    TorsionSpring,
)
from tests.reference.test_multibody_package import FORCES, MOTION, agree, both, same_motion

SPRINGS = (
    Spring(
        name="long",
        **{"from": Pin(link="coupler", at=0.07)},
        to=Pin(link="ground", point=(0.1, -0.05)),
        stiffness=2000.0,
        damping=5.0,
        free_length=0.03,
    ),
    TorsionSpring(name="coil", **{"from": "rocker"}, to="coupler", stiffness=4.0, damping=0.02, angle=0.4),
    TorsionSpring(name="hinge", **{"from": "rocker"}, to="ground", stiffness=3.0, angle=1.0),
    TorsionSpring(name="start", **{"from": "crank"}, to="ground", stiffness=3.0, damping=0.1, angle=1.0),
)
WAVES = (Harmonic(order=1, cosine=8.0, sine=-3.0), Harmonic(order=3, sine=2.0))
LOADS = (
    Force(
        name="pull",
        on=Pin(link="coupler", at=0.1),
        direction=0.5,
        constant=4.0,
        harmonics=WAVES,
        frequency=90.0,
    ),
    Force(
        name="push",
        on=Pin(link="rocker", at=0.03),
        direction=1.2,
        fixed="link",
        harmonics=WAVES,
        angle="crank",
    ),
    Torque(name="twist", link="rocker", constant=0.2, harmonics=WAVES[1:], factor=0.3, angle="crank"),
)
DRIVES = (
    PrescribedTorque(
        link="crank", constant=1.5, harmonics=(Harmonic(order=2, cosine=2.0),), nominal_speed=60.0
    ),
    SpeedProfile(link="crank", start=20.0, end=90.0, time=0.05),
)


def loaded(mechanism):
    """The mechanism with springs, gravity to the side, and point masses on crank and rocker."""
    fields = {name: getattr(mechanism, name) for name in type(mechanism).model_fields}
    masses = {"crank": (PointMass(at=-0.02, mass=0.3),), "rocker": (PointMass(at=0.05, mass=0.2),)}
    links = tuple(Link(**dict(link) | {"masses": masses.get(link.name, ())}) for link in mechanism.links)
    springs = SPRINGS if mechanism.clearance_joints else (SPRINGS[0], SPRINGS[-1])
    return type(mechanism)(
        **fields | {"links": links, "springs": springs, "loads": LOADS, "gravity_direction": 0.4}
    )


@pytest.mark.parametrize(
    "changes", [pytest.param({"gear_ratio": 3.0}, marks=pytest.mark.long), {"speed": -60.0}], ids=str
)
def test_the_loaded_mechanism_without_play(changes):
    mechanism = loaded(jp.catalog.chunmei2002(clearance=0, **changes))
    found, states, solved, _ = both(mechanism, 0.3, 1 / 3, MOTION + FORCES)
    same_motion(found, states, solved, 1e-8)
    bare, *_ = both(jp.catalog.chunmei2002(clearance=0, **changes), 0.3, 1 / 3, MOTION + FORCES)
    assert np.abs(found.drive_torque - bare.drive_torque).max() > 0.01 * np.abs(bare.drive_torque).max()


@pytest.mark.long
def test_the_loaded_mechanism_with_play_at_b():
    mechanism = loaded(jp.catalog.chunmei2002(gear_ratio=3.0, friction=0.0))
    found, states, solved, events = both(mechanism, 0.0, 0.05, [*MOTION, *FORCES, "normal_force"])
    assert len(events) >= 1
    same_motion(found, states, solved, 1e-8)
    agree(found, "normal_force", [[x.touches[0][2]] for x in solved], 1e-8)
    assert found.event_time.values == pytest.approx([event.time for event in events], abs=1e-11)


@pytest.mark.long
@pytest.mark.parametrize("drive", DRIVES, ids=lambda drive: drive.kind)
@pytest.mark.parametrize("clearance", [0, 2.9e-5])
def test_drives(drive, clearance):
    mechanism = jp.catalog.chunmei2002(clearance=clearance, friction=0.0, drive=drive)
    found, states, solved, events = both(mechanism, 0.3, 0.2, MOTION + FORCES)
    same_motion(found, states, solved, 1e-8)
    assert bool(events) == bool(clearance)
    if drive.kind == "profile":
        agree(found, "drive_torque", [-x.reactions["drive"][2] for x in solved], 1e-8)
