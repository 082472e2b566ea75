"""Loads: forces at points of links, and torques on links, that vary with time or with an angle."""

from __future__ import annotations

import math
from typing import Annotated, Any, ClassVar, Literal

from pydantic import AfterValidator, Field

from jointplay.display.units import measure
from jointplay.solver.equations import structure
from jointplay.solver.mechanism.base import Name, Number, PartName, Positive, Turn, measured, named
from jointplay.solver.mechanism.parts.courses import Course
from jointplay.solver.mechanism.parts.joints import Pin, on_a_link


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
        place, direction = measure(self.on.at, "m"), measure(self.direction, "rad")
        where = f"force on {self.link}, {place} from its origin, at {direction} to the {self.fixed}"
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
