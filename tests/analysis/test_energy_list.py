"""What every joint with play owes: energy kept where nothing takes it, mirrored motion of a mirror image.

Four-bars with play at A, B, C and at both B and C are in `test_energy`, ideal loops in `test_loops`.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import jointplay as jp
from tests.mechanism.test_stretching import stretching

pytestmark = pytest.mark.nightly
SPRINGY = jp.Contact(stiffness=1e7, damping=0.0)
TURNS, SPEED = 5, 60.0


def springy(mechanism):
    """A mechanism without drive, friction and damping."""
    joints = [
        joint if joint.prismatic else jp.Joint(**dict(joint) | {"contact": SPRINGY, "friction": None})
        for joint in mechanism.joints
    ]
    return jp.Mechanism(**dict(mechanism) | {"joints": joints, "drive": None})


def stretched(clearance):
    """A slider-crank whose rod bends and stretches, softly."""
    rigid = jp.catalog.slider_crank(clearance=clearance, inertia_centre={"rod": 3e-4}, gravity=9.8)
    return stretching(rigid, "rod", {"modulus": 2e9})


SCENES = {
    "four-bar, O": lambda: jp.catalog.chunmei2002(clearance={"O": 1e-4}),
    "four-bar, three": lambda: jp.catalog.chunmei2002(clearance=dict.fromkeys("ABC", 1e-4)),
    **{
        f"slider-crank, {k}": lambda k=k: jp.catalog.slider_crank(clearance={k: 1e-4}, gravity=9.8)
        for k in "OAB"
    },
    "slider-crank, three": lambda: jp.catalog.slider_crank(clearance=dict.fromkeys("OAB", 1e-4), gravity=9.8),
    "stephenson, two": lambda: jp.catalog.stephenson(clearance={"B": 1e-4, "D": 1e-4}),
    "four-bar of Siconos, three": jp.catalog.siconos_four_bar,
    "stretching rod, B": lambda: stretched({"B": 1e-4}),
}


@pytest.mark.parametrize("name", SCENES)
def test_undriven_undamped_motion_keeps_its_energy(name):
    """Over five turns, relative to the largest kinetic energy."""
    words = ["energy", "kinetic_energy", "penetration", "angle"]
    run = {"initial": {"crank_angle": 0.3, "crank_speed": SPEED}, "rtol": 1e-11, "record": words}
    found = jp.simulate(springy(SCENES[name]()), duration=TURNS * math.tau / SPEED, **run)
    assert int(found.status) == 0
    assert (found.penetration.max("time") > 1e-7).all()  # every joint has been in contact
    assert found.sizes["event"] > 100
    drift = np.abs(found.energy - found.energy[0]).max() / found.kinetic_energy.max()
    assert float(drift) < 1e-9


def mirrored(mechanism):
    """The mirror image in the x axis, driven the other way."""

    def pin(one):
        point = {} if one.point is None else {"point": (one.point[0], -one.point[1])}
        return jp.Pin(**dict(one) | point | {"direction": -one.direction})

    joints = [
        jp.Joint(**dict(j) | {"journal": pin(j.journal), "bearing": pin(j.bearing)}) for j in mechanism.joints
    ]
    drive = jp.ConstantSpeed(link=mechanism.drive.link, speed=-mechanism.drive.speed)
    guess = {name: -angle for name, angle in mechanism.guess.items()}
    fields = {"joints": joints, "drive": drive, "guess": guess, "gravity": -mechanism.gravity}
    return jp.Mechanism(**dict(mechanism) | fields)


@pytest.mark.parametrize(
    "mechanism",
    [
        jp.catalog.slider_crank(clearance={"B": 1e-4}, offset=0.01, gravity=9.8),
        jp.catalog.stephenson(clearance={"B": 1e-4, "D": 1e-4}, speed=100.0),
    ],
    ids=lambda mechanism: mechanism.name,
)
def test_the_mirror_image_moves_as_the_mirror_image(mechanism):
    odd = ("angle", "journal_y", "tangential_velocity", "tangential_force", "drive_torque")
    words = [*odd, "journal_x", "normal_force", "mode"]
    found, image = (
        jp.simulate(m, turns=0.5, rtol=1e-11, record=words) for m in (mechanism, mirrored(mechanism))
    )
    assert found.sizes["event"] == image.sizes["event"] > 3
    for word in words[:-1]:
        off = image[word].values - (-1 if word in odd else 1) * found[word].values
        off = np.sin(off) if word == "angle" else off
        assert np.abs(off).max() < 1e-6 * float(np.abs(found[word]).max()), word
