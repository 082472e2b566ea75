"""Linkages to start from: slider-crank, quick-return, and the six-bars of Watt and Stephenson.

Their numbers are examples, no publication's: every one is a keyword. All joints carry the same contact data,
so that any of them can be given clearance. A six-bar is a four-bar that drives a dyad. First come parts that
other entries of the catalog are made of, too: types of their keywords, pins, bars, joints.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Annotated, Any

from jointplay.display.errors import raise_any, unknown
from jointplay.display.number_text import typed
from jointplay.solver.mechanism import base
from jointplay.solver.mechanism.base import (
    GROUND,
    LONGEST,
    Name,
    NonNegative,
    Number,
    Place,
    Positive,
    accepts,
    unit,
)
from jointplay.solver.mechanism.changes import Clearance
from jointplay.solver.mechanism.parts.beam import Link
from jointplay.solver.mechanism.parts.drive import ConstantSpeed
from jointplay.solver.mechanism.parts.joints import Contact, Friction, Joint, Pin
from jointplay.solver.mechanism.records import Mechanism
from jointplay.solver.mechanism.signature import preset

Length = Annotated[base.Length, unit("length", "m")]
Play = Annotated[Clearance, unit("radial clearance", "m")]
Offset = Annotated[Number, unit("offset", "m")]
Density = Annotated[Positive, unit("mass of a metre", "kg/m")]
Radius = Annotated[Positive, unit("journal radius", "m")]
HalfSize = Annotated[Positive, unit("half size of a slider", "m")]
Stiffness = Annotated[Positive, unit("contact stiffness", "N/m")]
Damping = Annotated[NonNegative, unit("contact damping", "N s/m")]
Coefficient = Annotated[NonNegative, unit("friction coefficient", "1")]
Speed = Annotated[Number, unit("speed", "rad/s")]
Gravity = Annotated[Number, unit("gravity", "m/s²")]
_POSITIVE = "a table of numbers greater than 0 by link"
_PLACES = f"a table of numbers from -{typed(LONGEST)} to {typed(LONGEST)} by link"
_Masses = Annotated[dict[Name, Positive], accepts(_POSITIVE, units="kg")]
_Inertias = Annotated[dict[Name, Positive], accepts(_POSITIVE, units="kg m²")]
_Centres = Annotated[dict[Name, Place], accepts(_PLACES, units="m")]
_Numbers = dict[str, float]
MASS = {"crank": 0.3, "rod": 0.21, "slider": 0.14}
INERTIA = {"crank": 1e-5, "rod": 2.5e-4, "slider": 1e-5}


def joined(pins: Mapping[str, tuple[Pin, Pin]], guides: Iterable[str], **laws: float) -> tuple[Joint, ...]:
    """Joints from journal and bearing, revolute ones and guides, all with contact data.

    Guides that have no `half_length` and `half_height` stay ideal.
    """
    contact = Contact(stiffness=laws["stiffness"], damping=laws["damping"])
    friction = Friction(coefficient=laws["friction"]) if laws["friction"] else None
    kinds = {
        False: {"radius": laws["radius"]},
        True: {"kind": "prismatic"} | {k: laws.get(k) for k in ("half_length", "half_height")},
    }
    return tuple(
        Joint(name=k, journal=one, bearing=two, contact=contact, friction=friction, **kinds[k in guides])
        for k, (one, two) in pins.items()
    )


def bars(lengths: Mapping[str, float], density: float) -> tuple[Link, ...]:
    """Uniform bars."""
    rows = ((name, length, density * length) for name, length in lengths.items())
    return tuple(Link(name=n, length=l, mass=m, inertia=m * l**2 / 3) for n, l, m in rows)


def fixed(x: float, y: float) -> Pin:
    """A point of the ground."""
    return Pin(link=GROUND, point=(x, y))


def on(link: str, at: float = 0.0) -> Pin:
    """A point of a link."""
    return Pin(link=link, at=at)


def four_bar_pins(crank: float, coupler: float, rocker: float, ground: float) -> dict[str, tuple[Pin, Pin]]:
    """Journal and bearing of the joints O, A, B, C of a four-bar, by its lengths, m."""
    return {
        "O": (on("crank"), fixed(0.0, 0.0)),
        "A": (on("crank", crank), on("coupler")),
        "B": (on("coupler", coupler), on("rocker", rocker)),
        "C": (on("rocker"), fixed(ground, 0.0)),
    }


def example(
    name: str,
    links: tuple[Link, ...],
    pins: Mapping[str, tuple[Pin, Pin]],
    guides: str,
    speed: float,
    gravity: float,
    guess: Mapping[str, float],
) -> Mechanism:
    """A linkage of these parts whose crank turns at a constant speed."""
    laws = {"radius": 0.01, "stiffness": 1e7, "damping": 200.0, "friction": 0.05}
    joints = joined(pins, guides, half_length=0.02, half_height=0.01, **laws)
    drive = ConstantSpeed(link="crank", speed=speed)
    return Mechanism(name=name, links=links, joints=joints, drive=drive, gravity=gravity, guess=dict(guess))


def _by_link(tables: Mapping[str, tuple[Mapping[str, float] | None, _Numbers]]) -> list[_Numbers]:
    """Numbers by link: the given ones, others as usual."""
    raise_any(
        unknown(f"{key}.{name}", given[name], name, usual, "link")
        for key, (given, usual) in tables.items()
        for name in given or {}
        if name not in usual
    )
    return [usual | dict(given or {}) for given, usual in tables.values()]


@preset()
def slider_crank(
    crank: Length = 0.05,
    rod: Length = 0.12,
    offset: Offset = 0.0,
    mass: _Masses | None = None,
    inertia_centre: _Inertias | None = None,
    centre: _Centres | None = None,
    clearance: Play = {"B": 1e-4},  # noqa: B006  read only
    radius: Radius = 0.01,
    stiffness: Stiffness = 1e7,
    damping: Damping = 200.0,
    friction: Coefficient = 0.05,
    half_length: HalfSize = 0.02,
    half_height: HalfSize = 0.01,
    speed: Speed = 200.0,
    gravity: Gravity = 0.0,
    **changes: Any,
) -> Mechanism:
    """Give a slider-crank: crank O–A about the origin, rod A–B, slider at B on a guide G along +x.

    The rod carries the journal of B, the slider its bearing. At crank angle 0 the rod points along +x.

    Parameters
    ----------
    crank, rod : float
        Lengths, m.
    offset : float
        Height of the guide over the crank's pivot, m.
    mass, inertia_centre, centre : dict of str to float
        By link: mass, kg (0.3, 0.21, 0.14); moment of inertia about the mass centre, kg m² (1e-5, 2.5e-4,
        1e-5); distance of the mass centre from O, A and B, m (halfway, and at B).
    clearance : float or dict of str to float
        Radial clearance, m: a number is joint B's; 0 or unnamed: ideal.
    radius, stiffness, damping, friction : float
        Of every joint: a revolute one's journal radius, m; Kelvin and Voigt's law, N/m and N s/m; Coulomb's
        coefficient.
    half_length, half_height : float
        Of the slider about B, where G has clearance, m.
    speed : float
        Constant speed of the crank, rad/s.
    gravity : float
        Along −y, m/s².
    **changes
        As in `Mechanism.replace`.
    """
    lengths = {"crank": crank, "rod": rod, "slider": 2 * radius}
    halfway = {"crank": crank / 2, "rod": rod / 2, "slider": 0.0}
    tables = {"mass": (mass, MASS), "inertia_centre": (inertia_centre, INERTIA), "centre": (centre, halfway)}
    m, I, s = _by_link(tables)
    links = tuple(
        Link(name=k, length=lengths[k], mass=m[k], centre=s[k], inertia=I[k] + m[k] * s[k] ** 2)
        for k in lengths
    )
    pins = {
        "O": (on("crank"), fixed(0.0, 0.0)),
        "A": (on("crank", crank), on("rod")),
        "B": (on("rod", rod), on("slider")),
        "G": (on("slider"), fixed(0.0, offset)),
    }
    laws = {"radius": radius, "stiffness": stiffness, "damping": damping, "friction": friction}
    laws |= {"half_length": half_length, "half_height": half_height}
    guess = {"crank": 0.0, "rod": math.asin(max(-1.0, min(1.0, offset / rod)))}
    drive = ConstantSpeed(link="crank", speed=speed)
    made = Mechanism(
        name="slider_crank",
        links=links,
        joints=joined(pins, "G", **laws),
        drive=drive,
        gravity=gravity,
        guess=guess,
    )
    return made.changed({"clearance": clearance} | changes)


@preset()
def quick_return(
    crank: Length = 0.05,
    arm: Length = 0.25,
    rod: Length = 0.1,
    pivot: Length = 0.12,
    height: Length = 0.12,
    density: Density = 1.0,
    block: Annotated[Positive, unit("mass", "kg")] = 0.05,
    ram: Annotated[Positive, unit("mass", "kg")] = 0.2,
    speed: Speed = 20.0,
    gravity: Gravity = 9.8,
    **changes: Any,
) -> Mechanism:
    """Give a quick-return (crank shaper): a block on the crank's pin slides along an arm that moves a ram.

    Links crank O–A, block at A, arm C–D, rod D–E, ram at E. S is the block's guide on the arm, G the ram's,
    along +x on the ground; C lies below O.

    Parameters
    ----------
    crank, arm, rod : float
        Distances O–A, C–D, D–E, m.
    pivot : float
        Distance of C below O, m; more than the crank.
    height : float
        Height of the ram's guide above O, m.
    density : float
        Mass of a metre of the uniform links, kg/m.
    block, ram : float
        Masses, kg.
    speed : float
        Constant speed of the crank, rad/s.
    gravity : float
        Along −y, m/s².
    **changes
        As in `Mechanism.replace`.
    """
    rods = bars({"crank": crank, "arm": arm, "rod": rod}, density)
    small = [
        Link(name=k, length=crank / 2, mass=m, centre=0.0, inertia=m * crank**2 / 12)
        for k, m in (("block", block), ("ram", ram))
    ]
    pins = {
        "O": (on("crank"), fixed(0.0, 0.0)),
        "A": (on("crank", crank), on("block")),
        "S": (on("block"), on("arm")),
        "C": (on("arm"), fixed(0.0, -pivot)),
        "D": (on("arm", arm), on("rod")),
        "E": (on("rod", rod), on("ram")),
        "G": (on("ram"), fixed(0.0, height)),
    }
    guess = {"crank": 0.0, "arm": math.atan2(pivot, crank), "rod": 0.0}
    return example("quick_return", (*rods, *small), pins, "SG", speed, gravity, guess).replace(**changes)


@preset()
def watt(
    crank: Length = 0.04,
    coupler: Length = 0.12,
    rocker: Length = 0.1,
    arm: Length = 0.15,
    rod: Length = 0.18,
    output: Length = 0.12,
    ground: Length = 0.13,
    pivot: Length = 0.28,
    density: Density = 1.0,
    speed: Speed = 50.0,
    gravity: Gravity = 9.8,
    **changes: Any,
) -> Mechanism:
    """Give a Watt six-bar: the rocker of the four-bar O A B C, longer than C–B, drives another, C D E F.

    Links crank O–A, coupler A–B, rocker C–B–D, rod D–E, output F–E; O, C and F on the ground along +x.

    Parameters
    ----------
    crank, coupler, rocker, rod, output : float
        Distances O–A, A–B, C–B, D–E, F–E, m.
    arm : float
        Distance C–D on the rocker, m; at least C–B.
    ground, pivot : float
        Distances O–C and O–F, m.
    density : float
        Mass of a metre of the uniform links, kg/m.
    speed : float
        Constant speed of the crank, rad/s.
    gravity : float
        Along −y, m/s².
    **changes
        As in `Mechanism.replace`.
    """
    lengths = {"crank": crank, "coupler": coupler, "rocker": arm, "rod": rod, "output": output}
    pins = four_bar_pins(crank, coupler, rocker, ground) | _dyad("rocker", arm, rod, output, pivot)
    guess = {"coupler": 0.95, "rocker": 1.8, "rod": -0.15, "output": 1.6}
    return example("watt", bars(lengths, density), pins, "", speed, gravity, guess).replace(**changes)


@preset()
def stephenson(
    crank: Length = 0.04,
    coupler: Length = 0.12,
    arm: Length = 0.17,
    rocker: Length = 0.1,
    rod: Length = 0.14,
    output: Length = 0.12,
    ground: Length = 0.13,
    pivot: Length = 0.2,
    density: Density = 1.0,
    speed: Speed = 50.0,
    gravity: Gravity = 9.8,
    **changes: Any,
) -> Mechanism:
    """Give a Stephenson six-bar: the coupler of the four-bar O A B C, longer than A–B, drives D–E and F–E.

    Links crank O–A, coupler A–B–D, rocker C–B, rod D–E, output F–E; O, C and F on the ground along +x.

    Parameters
    ----------
    crank, coupler, rocker, rod, output : float
        Distances O–A, A–B, C–B, D–E, F–E, m.
    arm : float
        Distance A–D on the coupler, m; at least A–B.
    ground, pivot : float
        Distances O–C and O–F, m.
    density : float
        Mass of a metre of the uniform links, kg/m.
    speed : float
        Constant speed of the crank, rad/s.
    gravity : float
        Along −y, m/s².
    **changes
        As in `Mechanism.replace`.
    """
    lengths = {"crank": crank, "coupler": arm, "rocker": rocker, "rod": rod, "output": output}
    pins = four_bar_pins(crank, coupler, rocker, ground) | _dyad("coupler", arm, rod, output, pivot)
    guess = {"coupler": 0.9, "rocker": 1.9, "rod": -0.5, "output": 0.8}
    return example("stephenson", bars(lengths, density), pins, "", speed, gravity, guess).replace(**changes)


def _dyad(link: str, at: float, rod: float, output: float, pivot: float) -> dict[str, tuple[Pin, Pin]]:
    return {
        "D": (on(link, at), on("rod")),
        "E": (on("rod", rod), on("output", output)),
        "F": (on("output"), fixed(pivot, 0.0)),
    }
