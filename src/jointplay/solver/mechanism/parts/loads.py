"""Loads: forces at points of links, and torques on links, that vary with time or with an angle.

Springs with dampers between links, or between a link and the ground.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, ClassVar, Literal

from pydantic import AfterValidator, BeforeValidator, Field, create_model, model_validator

from jointplay.display.errors import refuse
from jointplay.display.number_text import measure
from jointplay.solver.equations import structure
from jointplay.solver.mechanism.base import (
    Angle,
    Name,
    NonNegative,
    Number,
    PartName,
    Positive,
    Record,
    Turn,
    measured,
    named,
)
from jointplay.solver.mechanism.parts.courses import Course
from jointplay.solver.mechanism.parts.joints import Pin, on_a_link

_LINK = named("link name, or 'ground'")
# `from` is the key of study files, and no name that Python's syntax takes
_Points = create_model("_Points", __base__=Record, **{"from": (Pin, ...), "to": (Pin, ...)})
_Links = create_model("_Links", __base__=Record, **{"from": (Name, _LINK), "to": (Name, _LINK)})


class _Load(Course):
    """Common base of loads: a name, and the time or angle with which the load varies."""

    root: ClassVar[str | None] = "load"
    phases: ClassVar[tuple[str, ...]] = ("frequency", "angle")
    name: PartName = named("load name")
    frequency: Positive | None = measured("angular frequency", "rad/s", None)
    angle: Name | None = named("link name", None)

    @property
    def timed(self) -> bool:
        """Whether it varies with time."""
        return self.frequency is not None

    @property
    def numbers(self) -> dict[str, float]:
        """Parameters of the equations by word, without a name."""
        return {"nu": self.frequency or 0.0}

    def structure(self, name: str, span: structure.Span | None) -> structure.Load:
        """Its structure in the equations."""
        course = self.course(name, self.timed, self.angle or "")
        return structure.Load(course, self.link, span, self.turning)

    @property
    def _phase(self) -> str:
        over = {"time": self.timed, f"the angle of {self.angle}": self.angle is not None}
        words = "".join(f" over {what}" for what, present in over.items() if present)
        return words + (f" at {measure(self.frequency, 'rad/s')}" if self.timed else "")


class Force(_Load):
    """A force at a point of a link.

    Parameters
    ----------
    name : str
        Name.
    on : Pin
        Link and place at which it acts.
    direction : float
        Its direction, rad anticlockwise from x, or from the link's line.
    fixed : {'ground', 'link'}
        What the direction is fixed in.
    constant, harmonics, table, tolerance, factor
        Its size over its phase φ, N: see `Course`.
    frequency : float, optional
        φ = frequency × time, rad/s, where it varies with time.
    angle : str, optional
        φ = the angle of the link of this name, where it varies with that.
    """

    units: ClassVar[str] = "N"
    constant: Number = measured("constant part", "N", 0.0)
    twists: ClassVar[bool] = False
    kind: Literal["force"] = "force"
    on: Annotated[Pin, AfterValidator(on_a_link)]
    direction: Turn = measured("direction", "rad")
    fixed: Literal["ground", "link"] = "ground"

    @property
    def pins(self) -> dict[str, Pin]:
        """Pins at which it acts, by key."""
        return {"on": self.on}

    @property
    def link(self) -> str:
        """Name of the link that it acts on."""
        return self.on.link

    @property
    def turning(self) -> bool:
        """Whether its direction turns with the link."""
        return self.fixed == "link"

    @property
    def numbers(self) -> dict[str, float]:
        """Parameters of the equations by word, without a name."""
        return super().numbers | {"dx": math.cos(self.direction), "dy": math.sin(self.direction)}

    @property
    def description(self) -> str:
        """The force's link, place and values in a few words."""
        place = f"{measure(self.on.at, 'm')} from" if self.on.at else "at"
        towards = f"{measure(self.direction, 'rad')} from {'its line' if self.turning else '+x'}"
        where = f"force on {self.link}, {place} its origin, towards {towards}"
        return f"{where}, {self.course_description}{self._phase}"


class Torque(_Load):
    """A torque on a link.

    Parameters
    ----------
    name : str
        Name.
    link : str
        Name of the link that it turns.
    constant, harmonics, table, tolerance, factor
        Its size over its phase φ, N m: see `Course`.
    frequency : float, optional
        φ = frequency × time, rad/s, where it varies with time.
    angle : str, optional
        φ = the angle of the link of this name, where it varies with that.
    """

    constant: Number = measured("constant part", "N m", 0.0)
    twists: ClassVar[bool] = True
    turning: ClassVar[bool] = False
    pins: ClassVar[dict[str, Any]] = {}
    kind: Literal["torque"] = "torque"
    link: Name = named("link name")

    @property
    def description(self) -> str:
        """The torque's link and values in a few words."""
        return f"torque on {self.link}, {self.course_description}{self._phase}"


AnyLoad = Annotated[Force | Torque, Field(discriminator="kind")]


def _apart(spring: Any) -> Any:
    first, second = spring.links
    if first == second:
        key = "to" if spring.twists else "to.link"
        raise refuse(second, "a link other than that of the other end is accepted", key)
    return spring


class Spring(_Points):
    """A straight spring with a damper between two points: F = k (L − L₀) + c L', pulling them together.

    Where the two points meet their line has no direction, and the force is 0.

    Parameters
    ----------
    name : str
        Name.
    from, to : Pin
        Its ends, on two links or on a link and the ground. In Python ``Spring(**{"from": …}, to=…)``.
    stiffness : float
        k, N/m.
    damping : float
        c, N s/m.
    free_length : float
        L₀, m.
    """

    root: ClassVar[str | None] = "spring"
    twists: ClassVar[bool] = False
    kind: Literal["extension"] = "extension"
    name: PartName = named("spring name")
    stiffness: NonNegative = measured("spring stiffness", "N/m")
    damping: NonNegative = measured("damping", "N s/m", 0.0)
    free_length: NonNegative = measured("free length", "m")

    _two_links = model_validator(mode="after")(_apart)

    @property
    def pins(self) -> dict[str, Pin]:
        """Its ends by key."""
        return {"from": getattr(self, "from"), "to": self.to}

    @property
    def links(self) -> tuple[str, str]:
        """Names of the links at its ends."""
        first, second = (pin.link for pin in self.pins.values())
        return first, second

    @property
    def rest(self) -> float:
        """Free length, m."""
        return self.free_length

    @property
    def description(self) -> str:
        """Ends and numbers in a few words."""
        damper = f", {measure(self.damping, 'N s/m')}" if self.damping else ""
        ends, length = " to ".join(self.links), measure(self.free_length, "m")
        return f"{ends}, {measure(self.stiffness, 'N/m')}{damper}, free length {length}"


class TorsionSpring(_Links):
    """A torsion spring with a damper between two links: M = k (φ − φ₀) + c φ', φ the angle between them.

    Turns are counted from the angles at the start, which those of links that follow the crank are within half
    a turn of 0.

    Parameters
    ----------
    name : str
        Name.
    from, to : str
        Names of two links, or of a link and ``ground``; φ is the angle of `from` less that of `to`. In Python
        ``TorsionSpring(**{"from": …}, to=…)``.
    stiffness : float
        k, N m/rad.
    damping : float
        c, N m s/rad.
    angle : float
        φ₀ at which it is free, rad.
    """

    root: ClassVar[str | None] = "spring"
    twists: ClassVar[bool] = True
    pins: ClassVar[dict[str, Pin]] = {}
    kind: Literal["torsion"] = "torsion"
    name: PartName = named("spring name")
    stiffness: NonNegative = measured("spring stiffness", "N m/rad")
    damping: NonNegative = measured("damping", "N m s/rad", 0.0)
    angle: Angle = measured("free angle", "rad", 0.0)

    _two_links = model_validator(mode="after")(_apart)

    @property
    def links(self) -> tuple[str, str]:
        """Names of the links at its ends."""
        return getattr(self, "from"), self.to

    @property
    def rest(self) -> float:
        """Free angle, rad."""
        return self.angle

    @property
    def description(self) -> str:
        """Ends and numbers in a few words."""
        damper = f", {measure(self.damping, 'N m s/rad')}" if self.damping else ""
        ends, angle = " against ".join(self.links), measure(self.angle, "rad")
        return f"torsion, {ends}, {measure(self.stiffness, 'N m/rad')}{damper}, free at {angle}"


def kind_of(default: str) -> BeforeValidator:
    """Let a table that names no `kind` be of the usual one."""
    return BeforeValidator(
        lambda given: {"kind": default} | given if isinstance(given, dict) and "kind" not in given else given
    )


AnySpring = Annotated[Spring | TorsionSpring, Field(discriminator="kind"), kind_of("extension")]
