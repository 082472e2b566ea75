"""Springs with dampers between links, or between a link and the ground."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import BeforeValidator, Field, create_model, model_validator

from jointplay.display.errors import refuse
from jointplay.display.units import measure
from jointplay.solver.mechanism.base import Angle, Name, NonNegative, PartName, Record, measured, named
from jointplay.solver.mechanism.parts.joints import Pin

_LINK = named("link name, or 'ground'")
# `from` is the key of study files, and no name that Python's syntax takes
_Points = create_model("_Points", __base__=Record, **{"from": (Pin, ...), "to": (Pin, ...)})
_Links = create_model("_Links", __base__=Record, **{"from": (Name, _LINK), "to": (Name, _LINK)})


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

    @model_validator(mode="after")
    def _two_links(self) -> Self:
        return _apart(self)

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

    @model_validator(mode="after")
    def _two_links(self) -> Self:
        return _apart(self)

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


def _apart(spring: Any) -> Any:
    first, second = spring.links
    if first == second:
        key = "to" if spring.twists else "to.link"
        raise refuse(second, "a link other than that of the other end is accepted", key)
    return spring


def kind_of(default: str) -> BeforeValidator:
    """Let a table that names no `kind` be of the usual one."""
    return BeforeValidator(
        lambda given: {"kind": default} | given if isinstance(given, dict) and "kind" not in given else given
    )


AnySpring = Annotated[Spring | TorsionSpring, Field(discriminator="kind"), kind_of("extension")]
