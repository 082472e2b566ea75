"""Parts of the catalog's linkages: types of their keywords, pins, bars, joints."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Annotated

from jointplay.solver.mechanism import base
from jointplay.solver.mechanism.base import GROUND, NonNegative, Number, Positive, unit
from jointplay.solver.mechanism.changes import Clearance
from jointplay.solver.mechanism.parts.beam import Link
from jointplay.solver.mechanism.parts.drive import ConstantSpeed
from jointplay.solver.mechanism.parts.joints import Contact, Friction, Joint, Pin
from jointplay.solver.mechanism.records import Mechanism

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
