"""Scenes that are not the four-bar with Kelvin and Voigt's contact: other laws in it, and other mechanisms.

`ROWS` says of each such variant which laws of contact and friction its scenes have; laws that share compiled
code stand together. `PRESETS` draws a mechanism of the catalog anew: its masses, drive, gravity's direction,
crank angle, and what it carries.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

import numpy as np

from jointplay.solver.equations.friction import FRICTIONS
from jointplay.solver.equations.laws import FACTORS
from jointplay.solver.equations.laws import LAWS as NORMAL
from jointplay.solver.mechanism.catalog import presets, published
from jointplay.solver.mechanism.parts.beam import Link
from jointplay.solver.mechanism.parts.drive import PrescribedTorque, SpeedCycle, SpeedProfile
from jointplay.solver.mechanism.parts.joints import Contact, Friction, Joint
from jointplay.solver.mechanism.parts.loads import Force, Spring, Torque, TorsionSpring
from jointplay.solver.mechanism.records import Mechanism
from jointplay_lab.stress import ranges

Random = np.random.Generator
Carried = dict[str, Any]

EXPONENT, CYLINDERS = 1.5, ("johnson", "dubowsky_freudenstein")
KELVIN_VOIGT, RIGID = (("kelvin_voigt",), "coulomb"), (("restitution",), "coulomb")
ROWS: dict[str, list[tuple[Iterable[str], str]]] = {
    "laws": [
        *((("kelvin_voigt",), friction) for friction in ("ramp", "ambrosio", "threlfall")),
        *((("hertz",), "stribeck"), (("hunt_crossley",), "andersson"), (FACTORS, "brown_mcphee")),
        *((CYLINDERS, "tanh"), (("liu",), "lugre")),
    ],
    "restitution": [RIGID],
    "elastic_laws": [(("hertz",), "lugre"), (FACTORS, "andersson"), (CYLINDERS, "stribeck"), RIGID],
    "slider_crank": [KELVIN_VOIGT, (FACTORS, "lugre"), (("liu",), "stribeck"), RIGID],
    "guide": [KELVIN_VOIGT, (("hertz",), "andersson"), (FACTORS, "tanh"), RIGID],
    "moving_guide": [KELVIN_VOIGT, (("hunt_crossley",), "threlfall"), RIGID],
    "stretching_rod": [KELVIN_VOIGT],
    "stephenson": [KELVIN_VOIGT, (FACTORS, "ambrosio"), (CYLINDERS, "ramp")],
    "watt": [(("kelvin_voigt",), "stribeck"), (("hertz",), "coulomb"), RIGID],
    "quick_return": [KELVIN_VOIGT, (("hunt_crossley",), "lugre"), (("liu",), "tanh")],
    "three_clearances": [KELVIN_VOIGT, (FACTORS, "brown_mcphee"), RIGID],
}
_NAMED = [row for rows in ROWS.values() for row in rows]
if further := {*NORMAL} - {law for laws, _ in _NAMED for law in laws}:
    ROWS["laws"].append((sorted(further), "tanh"))
ROWS["laws"] += [(("kelvin_voigt",), rubs) for rubs in sorted({*FRICTIONS} - {rubs for _, rubs in _NAMED})]


def pairs(variant: str) -> list[tuple[str, str] | None]:
    """Laws of contact and friction that scenes of a variant may have; None: the mechanism's own."""
    return [(law, friction) for laws, friction in ROWS.get(variant, []) for law in laws] or [None]


def with_laws(random: Random, mechanism: Mechanism, laws: tuple[str, str]) -> Mechanism:
    """The mechanism with these laws of contact and friction at all joints with clearance."""
    joints = []
    for joint in mechanism.joints:
        if not joint.ideal:
            changed = {"contact": _contact(random, joint, laws[0]), "friction": _rubs(random, joint, laws[1])}
            joint = Joint(**dict(joint) | changed)
        joints.append(joint)
    return Mechanism(**dict(mechanism) | {"joints": joints})


def shallow(law: str) -> bool:
    """Whether nothing starts deep: in rigid bearings, and where a law of metals may end at a depth."""
    return NORMAL[law].rigid or "length" in NORMAL[law].numbers


def _contact(random: Random, joint: Joint, law: str) -> Contact:
    """Draw a law's numbers; one with a power of u is as stiff as that drawn at a tenth of the clearance."""
    if law == joint.contact.law:
        return joint.contact
    numbers = NORMAL[law].numbers
    given = {name: each.trial for name, each in numbers.items() if each.usual is None}
    given |= {name: draw(random) for name, draw in ranges.OF_LAWS.items() if name in numbers}
    size = {"stiffness": joint.contact.stiffness / secant(joint), "damping": joint.contact.damping}
    own = {name: x for name, x in size.items() if given.pop(name, None) is not None}
    return Contact(law=law, parameters=given, **own)


def secant(joint: Joint) -> float:
    """Stiffness at a tenth of the clearance over the K of a law with a power."""
    return (0.1 * joint.clearance) ** (EXPONENT - 1)


def _rubs(random: Random, joint: Joint, law: str) -> Friction:
    """Draw a law of friction with the drawn coefficient, or the least one: no friction is compiled anew."""
    f = max(joint.friction.coefficient if joint.friction else 0.0, ranges.LEAST_FRICTION)
    numbers = FRICTIONS[law].trial | {name: draw(random) for name, draw in ranges.OF_FRICTION.items()}
    numbers |= {"static_coefficient": f * numbers["static_coefficient"]}
    numbers |= {"full_velocity": numbers["velocity"] * numbers["full_velocity"]}
    own = {name: numbers[name] for name in FRICTIONS[law].numbers}
    return Friction(law=law, coefficient=f, **own)


def _plain(random: Random, made: Mechanism, speed: float) -> Carried:
    return {}


def _shaken(random: Random, made: Mechanism, speed: float) -> Carried:
    """A torsion spring between crank and rod, and a torque on the rod over time."""
    stiffness, size = (ranges.logarithmic(random, ranges.TWIST) for _ in range(2))
    ends = {"from": "crank", "to": "rod"}
    spring = TorsionSpring(name="twist", stiffness=stiffness, damping=1e-4 * stiffness, **ends)
    rate = speed * ranges.logarithmic(random, (0.3, 3.0))
    load = Torque(name="shake", link="rod", frequency=rate, harmonics=[{"order": 1, "cosine": size}])
    return {"springs": (spring,), "loads": (load,)}


def _uneven(random: Random, made: Mechanism, speed: float) -> Carried:
    """A drive whose speed swings once a turn."""
    harmonics = [{"order": 1, "sine": ranges.even(random, (0.05, 0.8)) * speed}]
    return {"drive": SpeedCycle(link="crank", frequency=speed, constant=speed, harmonics=harmonics)}


def _run_up(random: Random, made: Mechanism, speed: float) -> Carried:
    """A drive that runs up, or down, over half a turn."""
    end = speed * ranges.logarithmic(random, (0.3, 3.0))
    return {"drive": SpeedProfile(link="crank", start=speed, end=end, time=math.pi / speed)}


def _turned(random: Random, made: Mechanism, speed: float) -> Carried:
    """A torque on the crank that varies with its angle, in the place of a speed."""
    size, share = ranges.logarithmic(random, ranges.TWIST), ranges.even(random, (0.0, 2.0))
    harmonics = [{"order": 1, "cosine": share * size}]
    torque = PrescribedTorque(link="crank", constant=size, harmonics=harmonics, nominal_speed=speed)
    return {"drive": torque}


def _pushed(random: Random, made: Mechanism, speed: float) -> Carried:
    """A force on the ram given as a table over time."""
    table = ranges.logarithmic(random, ranges.PUSH) * np.array([0.0, 0.6, 1.0, 0.7, 0.1, -0.5, -0.8, -0.6])
    load = Force(name="push", on={"link": "ram"}, direction=0.0, frequency=speed, table=table.tolist())
    return {"loads": (load,)}


def _loaded(random: Random, made: Mechanism, speed: float) -> Carried:
    """A spring on the arm, and a force on the ram over the crank's angle."""
    ends = {
        "from": {"link": "arm", "at": made.link("arm").length},
        "to": {"link": "ground", "point": (0.3, 0.0)},
    }
    stiffness = ranges.logarithmic(random, ranges.SPRING)
    spring = Spring(name="return", stiffness=stiffness, damping=1e-3 * stiffness, free_length=0.2, **ends)
    size = ranges.logarithmic(random, ranges.PUSH)
    harmonics = [{"order": 2, "cosine": size, "sine": -size / 2}]
    load = Force(name="cut", on={"link": "ram"}, direction=math.pi, angle="crank", harmonics=harmonics)
    return {"springs": (spring,), "loads": (load,)}


# Of each: the catalog's function, its joints with clearance, and what it carries; without a drive, released
PRESETS: dict[str, tuple[Callable[..., Mechanism], str, Callable[[Random, Mechanism, float], Carried]]] = {
    "slider_crank": (presets.slider_crank, "B", _shaken),
    "guide": (presets.slider_crank, "G", _uneven),
    "moving_guide": (presets.quick_return, "S", _pushed),
    "stretching_rod": (published.ivp_crank, "B", _plain),
    "stephenson": (presets.stephenson, "BD", _run_up),
    "watt": (presets.watt, "E", _turned),
    "quick_return": (presets.quick_return, "E", _loaded),
    "three_clearances": (partial(published.siconos_four_bar, restitution=None, drive=None), "ABC", _plain),
}


def preset(random: Random, name: str, laws: tuple[str, str]) -> tuple[Mechanism, dict[str, Any]]:
    """Draw a mechanism of the catalog, and its crank's starting angle, and speed where nothing drives it."""
    make, loose, carried = PRESETS[name]
    clearance = ranges.logarithmic(random, (ranges.CLEARANCE[0], 1e-3))
    contact = {"stiffness": ranges.logarithmic(random, ranges.STIFFNESS), "damping": ranges.damping(random)}
    friction = ranges.even(random, ranges.FRICTION)
    speed = ranges.logarithmic(random, ranges.TURNING)
    heavier = ranges.logarithmic(random, ranges.MASS)
    made = make(clearance=dict.fromkeys(loose, clearance), gravity=9.8)
    links = [dict(k) | _sized(random, k, heavier) for k in made.links]
    held = {"friction": Friction(coefficient=friction)}
    joints = [
        joint
        if joint.prismatic and joint.ideal
        else Joint(**dict(joint) | held | {"contact": dict(joint.contact) | contact})
        for joint in made.joints
    ]
    down, begin = (float(random.uniform(-math.pi, math.pi)) for _ in range(2))
    fields = {"links": links, "joints": joints, "gravity_direction": down} | carried(random, made, speed)
    start = {"crank_angle": begin}
    if made.drive is None:
        start |= {"crank_speed": speed}
    elif "drive" not in fields:
        fields |= {"drive": dict(made.drive) | {"speed": speed}}
    return with_laws(random, Mechanism(**dict(made) | fields), laws), start


def _sized(random: Random, link: Link, heavier: float) -> dict[str, Any]:
    """Mass and inertia of a link, a counterweight behind the crank's pivot, stiffness of an elastic link."""
    size = {"mass": link.mass * heavier, "inertia": link.inertia * heavier}
    if link.name == "crank":
        at, mass = -ranges.even(random, (0.1, 1.0)) * link.length, ranges.even(random, (0.01, 1.0))
        size |= {"masses": ({"at": at, "mass": mass * size["mass"]},)}
    if link.elastic:
        drawn = {"modulus": ranges.logarithmic(random, ranges.MODULUS), "area": None, "second_moment": None}
        drawn |= {"damping_ratio": ranges.even(random, ranges.DAMPING_RATIO)}
        size |= {"beam": dict(link.beam) | drawn}
    return size
