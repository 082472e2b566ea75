"""Scenes that are not the four-bar with Kelvin and Voigt's contact: other laws in it, and other mechanisms.

`LAWS` changes the contact of a drawn four-bar; `PRESETS` draws a mechanism of the catalog anew: its masses,
contacts, drive, gravity's direction, crank angle, and what it carries.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from jointplay.lab.stress import ranges
from jointplay.mechanism import presets, six_bars
from jointplay.mechanism.drive import SpeedProfile
from jointplay.mechanism.joints import Contact, Friction, Joint
from jointplay.mechanism.loads import Force
from jointplay.mechanism.records import MAIN_JOINT, Mechanism
from jointplay.mechanism.springs import Spring

RESTITUTION, SPEED, MASS, EXPONENT = (0.05, 0.95), (1.0, 300.0), (0.1, 10.0), 1.5
FORCE, SPRING = (0.1, 1e3), (1.0, 1e5)  # N, N/m
Random = np.random.Generator


def _power_law(random: Random, joint: Joint, law: str) -> dict[str, Any]:
    """A law with a power of u, as stiff as the drawn contact at a depth of a tenth of the clearance."""
    K = joint.contact.stiffness / (0.1 * joint.clearance) ** (EXPONENT - 1)
    given = {"restitution": ranges.even(random, RESTITUTION)}
    if law == "hunt_crossley":
        given = {"dissipation": ranges.logarithmic(random, (1e-3, 1e1))}
    f = joint.friction.coefficient if joint.friction else 0.0
    rubbing = {"law": "brown_mcphee", "coefficient": f, "static_coefficient": 1.2 * f, "velocity": 0.01}
    contact = Contact(law=law, stiffness=K, parameters=given)
    return {"contact": contact, "friction": Friction(**rubbing) if f > 0 else None}


def _impacts(random: Random, joint: Joint, law: str) -> dict[str, Any]:
    r = ranges.even(random, RESTITUTION)
    rubs = Friction(coefficient=joint.friction.coefficient) if joint.friction else None
    return {"contact": Contact(law=law, parameters={"restitution": r}), "friction": rubs}


LAWS: dict[str, Callable[[Random, Joint, str], dict[str, Any]]] = {
    "hunt_crossley": _power_law,
    "flores": _power_law,
    "restitution": _impacts,
}


def with_law(random: Random, mechanism: Mechanism, law: str) -> Mechanism:
    """The mechanism with another law at its main joint."""
    changed = LAWS[law](random, mechanism.joint(MAIN_JOINT), law)
    joints = [
        Joint(**dict(joint) | changed) if joint.name == MAIN_JOINT else joint for joint in mechanism.joints
    ]
    return Mechanism(**dict(mechanism) | {"joints": joints})


def _plain(random: Random, made: Mechanism) -> dict[str, Any]:
    return {}


def _run_up(random: Random, made: Mechanism) -> dict[str, Any]:
    """A drive that runs up, or down, over half a turn."""
    speed = made.drive.speed
    end = speed * ranges.logarithmic(random, (0.3, 3.0))
    return {"drive": SpeedProfile(link="crank", start=speed, end=end, time=math.pi / speed)}


def _loaded(random: Random, made: Mechanism) -> dict[str, Any]:
    """A spring on the arm, and a force on the ram over the crank's angle."""
    ends = {
        "from": {"link": "arm", "at": made.link("arm").length},
        "to": {"link": "ground", "point": (0.3, 0.0)},
    }
    stiffness = ranges.logarithmic(random, SPRING)
    spring = Spring(name="return", stiffness=stiffness, damping=1e-3 * stiffness, free_length=0.2, **ends)
    size = ranges.logarithmic(random, FORCE)
    harmonics = [{"order": 2, "cosine": size, "sine": -size / 2}]
    load = Force(name="cut", on={"link": "ram"}, direction=math.pi, angle="crank", harmonics=harmonics)
    return {"springs": (spring,), "loads": (load,)}


PRESETS: dict[str, tuple[Callable[..., Mechanism], str, Callable[[Random, Mechanism], dict[str, Any]]]] = {
    "slider_crank": (presets.slider_crank, "B", _plain),
    "guide": (presets.slider_crank, "G", _plain),
    "stephenson": (six_bars.stephenson, "BD", _run_up),
    "quick_return": (presets.quick_return, "E", _loaded),
}


def preset(random: Random, name: str) -> tuple[Mechanism, dict[str, Any]]:
    """Draw a mechanism of the catalog, and where its crank begins."""
    make, loose, carried = PRESETS[name]
    clearance = ranges.logarithmic(random, (ranges.CLEARANCE[0], 1e-3))
    contact = {"stiffness": ranges.logarithmic(random, ranges.STIFFNESS), "damping": ranges.damping(random)}
    friction = ranges.even(random, ranges.FRICTION)
    made = make(
        clearance=dict.fromkeys(loose, clearance), speed=ranges.logarithmic(random, SPEED), gravity=9.8
    )
    heavier = ranges.logarithmic(random, MASS)
    links = [
        {"name": k.name, "length": k.length, "centre": k.centre}
        | {"mass": k.mass * heavier, "inertia": k.inertia * heavier}
        for k in made.links
    ]
    held = {"contact": Contact(**contact), "friction": Friction(coefficient=friction)}
    joints = [
        joint if joint.prismatic and joint.ideal else Joint(**dict(joint) | held) for joint in made.joints
    ]
    down = float(random.uniform(-math.pi, math.pi))
    fields = {"links": links, "joints": joints, "gravity_direction": down} | carried(random, made)
    begin = float(random.uniform(-math.pi, math.pi))
    return Mechanism(**dict(made) | fields), {"crank_angle": begin}
