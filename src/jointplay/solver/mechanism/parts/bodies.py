"""Bodies of links by their shape and material: mass, mass centre, moment of inertia, section.

Closed forms of homogeneous bodies with a length l between their pins, which reach past each pin by o. With
l' = l + 2 o, k the radius of gyration about the centre, I the second moment of area, both in the plane,

    bar, w in the plane, t across it      k² = (l'² + w²)/12             I = t w³/12
    rod, of diameter d                    k² = l'²/12 + d²/16            I = pi d⁴/64
    tube, d outside, d_i inside           k² = l'²/12 + (d² + d_i²)/16   I = pi (d⁴ - d_i⁴)/64

and a plate is a rectangle l by w with two half discs of radius r = w/2 about its pins: its area is
l w + pi r², and k² times it l w (l² + w²)/12 + pi r² (r²/2 + l²/4 + 4 r l/(3 pi)). Mass centres are halfway.
Holes for pins are left out, and so are bosses, fillets and what else a drawing has. Units: SI.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple, Self

from pydantic import field_validator, model_validator

from jointplay.display.errors import NOTHING, InputError, Problem, refuse
from jointplay.solver.mechanism.base import NonNegative, Positive, Record, measured
from jointplay.solver.mechanism.parts.materials import AnyMaterial

EXAMPLE = "shape = { bar = { width = '20 mm', thickness = '6 mm' }, material = 'steel' }"
PAST = "length past each pin"


class Measures(NamedTuple):
    """Measures of a body between two pins, in SI units.

    Parameters
    ----------
    area, second_moment : float
        Of its section, m² and m⁴.
    volume : float
        Whole, m³.
    gyration : float
        Square of the radius of gyration about its centre, m².
    """

    area: float
    second_moment: float
    volume: float
    gyration: float


class Bar(Record):
    """A bar of rectangular section.

    Parameters
    ----------
    width : float
        Width in the plane of motion, m.
    thickness : float
        Thickness across the plane of motion, m.
    overhang : float
        How far it reaches past each pin, m.
    """

    width: Positive = measured("width", "m")
    thickness: Positive = measured("thickness", "m")
    overhang: NonNegative = measured(PAST, "m", 0.0)

    def measures(self, length: float) -> Measures:
        """Its measures, with so much between its pins, m."""
        w, t, whole = self.width, self.thickness, length + 2 * self.overhang
        return Measures(w * t, t * w**3 / 12, w * t * whole, (whole**2 + w**2) / 12)


class Rod(Record):
    """A round rod.

    Parameters
    ----------
    diameter : float
        Diameter, m.
    overhang : float
        How far it reaches past each pin, m.
    """

    diameter: Positive = measured("diameter", "m")
    overhang: NonNegative = measured(PAST, "m", 0.0)

    def measures(self, length: float) -> Measures:
        """Its measures, with so much between its pins, m."""
        return _round(self.diameter, 0.0, length + 2 * self.overhang)


class Tube(Record):
    """A round tube.

    Parameters
    ----------
    diameter : float
        Outer diameter, m.
    wall : float
        Thickness of its wall, m.
    overhang : float
        How far it reaches past each pin, m.
    """

    diameter: Positive = measured("outer diameter", "m")
    wall: Positive = measured("thickness of the wall", "m")
    overhang: NonNegative = measured(PAST, "m", 0.0)

    @field_validator("wall")
    @classmethod
    def _hollow(cls, wall: float, info: Any) -> float:
        if not wall < info.data.get("diameter", math.inf) / 2:
            raise refuse(
                wall, f"a wall less than half the diameter, {info.data['diameter'] / 2:g} m, is accepted"
            )
        return wall

    def measures(self, length: float) -> Measures:
        """Its measures, with so much between its pins, m."""
        return _round(self.diameter, self.diameter - 2 * self.wall, length + 2 * self.overhang)


class Plate(Record):
    """A plate with two pins, whose ends are round about them.

    Parameters
    ----------
    width : float
        Width in the plane of motion, m, twice the radius of its ends.
    thickness : float
        Thickness across the plane of motion, m.
    """

    width: Positive = measured("width", "m")
    thickness: Positive = measured("thickness", "m")

    def measures(self, length: float) -> Measures:
        """Its measures, with so much between its pins, m."""
        w, t, r, l = self.width, self.thickness, self.width / 2, length
        plan, ends = l * w + math.pi * r**2, r**2 / 2 + l**2 / 4 + 4 * r * l / (3 * math.pi)
        polar = l * w * (l**2 + w**2) / 12 + math.pi * r**2 * ends
        return Measures(w * t, t * w**3 / 12, plan * t, polar / plan)


def _round(d: float, inside: float, whole: float) -> Measures:
    area = math.pi * (d**2 - inside**2) / 4
    second = math.pi * (d**4 - inside**4) / 64
    return Measures(area, second, area * whole, whole**2 / 12 + (d**2 + inside**2) / 16)


class Shape(Record):
    """What a link looks like: one of four bodies, and its material. Holes are left out.

    Parameters
    ----------
    bar : Bar, optional
        A rectangular bar.
    rod : Rod, optional
        A round rod.
    tube : Tube, optional
        A round tube.
    plate : Plate, optional
        A plate, its ends round about its pins.
    material : Material
        A material of the table by its name, as ``"steel"``, or a table of its own numbers.
    """

    bar: Bar | None = None
    rod: Rod | None = None
    tube: Tube | None = None
    plate: Plate | None = None
    material: AnyMaterial

    @model_validator(mode="after")
    def _one_body(self) -> Self:
        given = [name for name in _BODIES if getattr(self, name)]
        if len(given) != 1:
            accepted = f"one of {', '.join(_BODIES)} is accepted, as {EXAMPLE}"
            raise InputError([Problem("", given or NOTHING, accepted)])
        return self

    @property
    def description(self) -> str:
        """Material and body in a few words."""
        body = next(name for name in _BODIES if getattr(self, name))
        return f"{self.material.name} {body}, its holes left out"

    @property
    def across(self) -> tuple[str, float]:
        """Its size in the plane across its line, through which pins pass: key, and value in m."""
        name = next(name for name in _BODIES if getattr(self, name))
        size = "diameter" if name in ("rod", "tube") else "width"
        return f"{name}.{size}", getattr(getattr(self, name), size)

    def numbers(self, length: float) -> dict[str, float]:
        """Mass, mass centre and moment of inertia about it of a link of this length, by its keys.

        Parameters
        ----------
        length : float
            Distance between its pins, m.
        """
        body = self._measures(length)
        mass = self.material.density * body.volume
        return {"mass": mass, "centre": length / 2, "inertia_centre": mass * body.gyration}

    def beam(self, length: float) -> dict[str, float]:
        """Elasticity and section of such a link, by the keys of its beam."""
        body, own = self._measures(length), self.material
        section = {"area": body.area, "second_moment": body.second_moment}
        return {"modulus": own.modulus, "density": own.density} | section

    def _measures(self, length: float) -> Measures:
        body = self.bar or self.rod or self.tube or self.plate
        return body.measures(length)


_BODIES = ("bar", "rod", "tube", "plate")
