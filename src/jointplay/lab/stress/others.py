"""Scenes that are not the four-bar with Kelvin and Voigt's contact: other laws in it, and other mechanisms.

`LAWS` changes the contact and the friction of a drawn four-bar, each variant within one structure, so that a
series compiles few; `PRESETS` draws a mechanism of the catalog anew: its masses, contacts, drive, gravity's
direction, crank angle, and what it carries.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from jointplay.equations.friction import FRICTIONS
from jointplay.equations.laws import FACTORS
from jointplay.lab.stress import ranges
from jointplay.mechanism import presets, six_bars
from jointplay.mechanism.drive import SpeedCycle, SpeedProfile
from jointplay.mechanism.joints import Contact, Friction, Joint
from jointplay.mechanism.loads import Force, Torque
from jointplay.mechanism.records import MAIN_JOINT, Mechanism
from jointplay.mechanism.springs import Spring, TorsionSpring

RESTITUTION, SPEED, MASS, EXPONENT = (0.05, 0.95), (1.0, 300.0), (0.1, 10.0), 1.5
FORCE, SPRING, TWIST = (0.1, 1e3), (1.0, 1e5), (1e-2, 1e2)  # N, N/m, N m and N m/rad
WIDTH = (5e-3, 5e-2)  # of bearings, m
SLIDING = {"velocity": 0.01, "full_velocity": 0.03, "stribeck_velocity": 0.1}  # m/s
SLIDING |= {"bristle_stiffness": 1e5, "bristle_damping": 0.1}
Random = np.random.Generator


def _drawn(random: Random, joint: Joint) -> Contact:
    return joint.contact


def _power_law(random: Random, joint: Joint, law: str, **given: float) -> Contact:
    """A law with a power of u, as stiff as the drawn contact at a depth of a tenth of the clearance."""
    K = joint.contact.stiffness / (0.1 * joint.clearance) ** (EXPONENT - 1)
    return Contact(law=law, stiffness=K, parameters=given)


def _hertz(random: Random, joint: Joint) -> Contact:
    return _power_law(random, joint, "hertz")


def _hunt_crossley(random: Random, joint: Joint) -> Contact:
    return _power_law(random, joint, "hunt_crossley", dissipation=ranges.logarithmic(random, (1e-3, 1e1)))


def _of_restitution(random: Random, joint: Joint) -> Contact:
    """One of the laws that remember the speed of impact."""
    law = str(random.choice([*FACTORS]))
    return _power_law(random, joint, law, restitution=ranges.even(random, RESTITUTION))


def _cylinders(random: Random, joint: Joint, laws: tuple[str, ...]) -> Contact:
    given = {"length": ranges.logarithmic(random, WIDTH), "restitution": ranges.even(random, RESTITUTION)}
    given["bearing_modulus"] = ranges.logarithmic(random, ranges.MODULUS)
    return Contact(law=str(random.choice(laws)), parameters=given)


def _impacts(random: Random, joint: Joint) -> Contact:
    return Contact(law="restitution", parameters={"restitution": ranges.even(random, RESTITUTION)})


def _rubbing(joint: Joint, law: str) -> Friction | None:
    """A law of friction with the drawn coefficient."""
    f = joint.friction.coefficient if joint.friction else 0.0
    numbers = SLIDING | {"static_coefficient": 1.2 * f}
    own = {name: numbers[name] for name in FRICTIONS[law].numbers if name in numbers}
    return Friction(law=law, coefficient=f, **own) if f > 0 else None


LAWS: dict[str, tuple[Callable[[Random, Joint], Contact], str]] = {
    "hertz": (_hertz, "stribeck"),
    "hunt_crossley": (_hunt_crossley, "andersson"),
    "of_restitution": (_of_restitution, "brown_mcphee"),
    "cylinders": (partial(_cylinders, laws=("johnson", "dubowsky_freudenstein")), "tanh"),
    "liu": (partial(_cylinders, laws=("liu",)), "lugre"),
    "restitution": (_impacts, "coulomb"),
    **{friction: (_drawn, friction) for friction in ("ramp", "ambrosio", "threlfall")},
}
SHALLOW = ("cylinders", "liu", "restitution")  # variants in which nothing starts deep


def with_law(random: Random, mechanism: Mechanism, variant: str) -> Mechanism:
    """The mechanism with other laws at its main joint."""
    (contact, friction), joint = LAWS[variant], mechanism.joint(MAIN_JOINT)
    changed = {"contact": contact(random, joint), "friction": _rubbing(joint, friction)}
    joints = [
        Joint(**dict(joint) | changed) if joint.name == MAIN_JOINT else joint for joint in mechanism.joints
    ]
    return Mechanism(**dict(mechanism) | {"joints": joints})


def _plain(random: Random, made: Mechanism) -> dict[str, Any]:
    return {}


def _shaken(random: Random, made: Mechanism) -> dict[str, Any]:
    """A torsion spring between crank and rod, and a torque on the rod over time."""
    stiffness, size = (ranges.logarithmic(random, TWIST) for _ in range(2))
    ends = {"from": "crank", "to": "rod"}
    spring = TorsionSpring(name="twist", stiffness=stiffness, damping=1e-4 * stiffness, **ends)
    rate = made.drive.speed * ranges.logarithmic(random, (0.3, 3.0))
    load = Torque(name="shake", link="rod", frequency=rate, harmonics=[{"order": 1, "cosine": size}])
    return {"springs": (spring,), "loads": (load,)}


def _uneven(random: Random, made: Mechanism) -> dict[str, Any]:
    """A drive whose speed swings once a turn."""
    speed, swing = made.drive.speed, ranges.even(random, (0.05, 0.8))
    harmonics = [{"order": 1, "sine": swing * speed}]
    return {"drive": SpeedCycle(link="crank", frequency=speed, constant=speed, harmonics=harmonics)}


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
    "slider_crank": (presets.slider_crank, "B", _shaken),
    "guide": (presets.slider_crank, "G", _uneven),
    "moving_guide": (presets.quick_return, "S", _plain),
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
