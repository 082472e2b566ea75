"""Links, rigid or elastic, with point masses, and the modes in which an elastic link bends.

Source: the deflection y(x, t) = Σ φ_i(x) η_i(t) of a uniform Euler–Bernoulli beam pinned at both ends, in
mass-normalised modes: ∫ρA φ_i φ_j dx = δ_ij and ∫EI φ_i″ φ_j″ dx = ω_i² δ_ij. They are those of
a beam of unit length, mass and stiffness, scaled: ω_i by √(EI/ρAl⁴), φ_i by 1/√(ρAl). Sine shapes are exact:
φ_i = √2 sin(iπx) with ω_i = (iπ)². Hermite shapes are the eigenvectors of K_f and M_f of equal cubic elements
whose end deflections are removed, so n elements have 2n modes (Chunmei et al. (2002), equations (10) to (12),
with n = 2). Assumptions: small deflections, slender links, uniform section. Units: SI.

Bodies of links by their shape and material: mass, mass centre, moment of inertia, section.

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
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import Annotated, Any, Literal, NamedTuple, Self

import numpy as np
from pydantic import Field, ValidationInfo, field_validator, model_validator

from jointplay.display.errors import NOTHING, InputError, Problem, raise_any, refuse
from jointplay.display.number_text import measure, plain
from jointplay.solver.mechanism.base import (
    GROUND,
    LONG,
    Few,
    Flag,
    Length,
    Name,
    NonNegative,
    PartName,
    Place,
    Positive,
    Record,
    in_millimetres,
    measured,
    named,
)
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
        """Measures of the body, with so much between its pins, m."""
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
        """Measures of the body, with so much between its pins, m."""
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
        """Measures of the body, with so much between its pins, m."""
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
        """Measures of the body, with so much between its pins, m."""
        w, t, r, l = self.width, self.thickness, self.width / 2, length
        plan, ends = l * w + math.pi * r**2, r**2 / 2 + l**2 / 4 + 4 * r * l / (3 * math.pi)
        polar = l * w * (l**2 + w**2) / 12 + math.pi * r**2 * ends
        return Measures(w * t, t * w**3 / 12, plan * t, polar / plan)


def _round(d: float, inside: float, whole: float) -> Measures:
    area = math.pi * (d**2 - inside**2) / 4
    second = math.pi * (d**4 - inside**4) / 64
    return Measures(area, second, area * whole, whole**2 / 12 + (d**2 + inside**2) / 16)


class Shape(Record):
    """The body of a link: one of four, and its material. Holes are left out.

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
        return f"{self.material.name} {self._body[0]}, its holes left out"

    @property
    def across(self) -> tuple[str, float]:
        """Size in the plane across the line, through which pins pass: key, and value in m."""
        name, body = self._body
        size = "diameter" if name in ("rod", "tube") else "width"
        return f"{name}.{size}", getattr(body, size)

    def numbers(self, length: float) -> dict[str, float]:
        """Mass, mass centre and moment of inertia about it of a link of this length, by its keys.

        Parameters
        ----------
        length : float
            Distance between its pins, m.
        """
        body = self._body[1].measures(length)
        mass = self.material.density * body.volume
        return {"mass": mass, "centre": length / 2, "inertia_centre": mass * body.gyration}

    def beam(self, length: float) -> dict[str, float]:
        """Elasticity and section of such a link, by the keys of its beam."""
        body, own = self._body[1].measures(length), self.material
        section = {"area": body.area, "second_moment": body.second_moment}
        return {"modulus": own.modulus, "density": own.density} | section

    @property
    def _body(self) -> tuple[str, Bar | Rod | Tube | Plate]:
        return next((name, body) for name in _BODIES if (body := getattr(self, name)))


_BODIES = ("bar", "rod", "tube", "plate")
# what a shape gives: of a link, and of its beam
_OF_BODIES = ("mass", "centre", "inertia", "inertia_centre")
_OF_SECTIONS = ("modulus", "density", "section", "area", "second_moment")


_MARGIN = 1e-9  # of a pivot of the mass matrix: below this share of its whole it is rounding


MOST_ELEMENTS = 20


_STRETCHED = 8 / 9  # of a beam's mass that its two modes along move as one


_SINES = 4  # as many modes as the paper's two elements have


_SOME_ELEMENTS = f"a whole number of elements from 1 to {MOST_ELEMENTS}, each longer than 0,"


_SOME_DAMPING = "a damping ratio from 0 to 1 (critical: beyond it no mode swings)"


_SOME_MODES = f"a whole number of modes from 1 to {2 * MOST_ELEMENTS}"


_OR_A_SHAPE = f"or a shape, of which it follows: {EXAMPLE}"


_BETWEEN_ENDS = "a fraction of the length greater than 0 and less than 1 (the pinned ends do not deflect)"


_Modes = Annotated[int, Field(strict=True, ge=1, le=2 * MOST_ELEMENTS)]


Elements = Annotated[int, Field(strict=True, ge=1, le=MOST_ELEMENTS)]


DampingRatio = Annotated[NonNegative, Field(le=1)]


elements_field = partial(measured, "number of elements", "1", accepts=_SOME_ELEMENTS)


damping_field = partial(measured, "damping ratio", "1", 0.0, accepts=_SOME_DAMPING)


Array = np.ndarray


class PointMass(Record):
    """A mass at a point of a link's line, such as a counterweight.

    Parameters
    ----------
    at : float
        Distance from the link's origin along the link, m; negative behind the origin.
    mass : float
        Mass, kg.
    name : str, optional
        By which a sweep finds it: ``links.crank.masses.counterweight.mass``.
    """

    at: Place = measured("distance along the link", "m")
    mass: Positive = measured("mass", "kg")
    name: Name | None = None


class Beam(Record):
    """Beam of an elastic link: uniform, Euler–Bernoulli, both of its ends on the link's line.

    Valid for deflections that are small against the length, of links that are long against their thickness:
    shear and rotary inertia of the section are left out, and stretching, unless it is asked for.

    Parameters
    ----------
    shapes : {'hermite', 'sine'}
        Cubic finite elements, or the exact modes of a pinned beam.
    elements : int, optional
        Number of elements of equal length, 1 to 20; 2 if left out, and none with sine shapes.
    modes : int, optional
        How many of the lowest modes to keep; all 2 × elements, or 4 sine modes, if left out.
    modulus : float
        Young's modulus E, Pa.
    density : float
        ρ, kg/m³.
    section : {'round', 'square'}
        Solid section, for a second moment that is left out.
    area : float, optional
        Area of the section A, m²; mass/(ρ × length) of the link if left out. A link whose mass is not all
        in its beam, but in bosses or pins too, has a smaller one.
    second_moment : float, optional
        Second moment of area, m⁴; A²/4π of a round and A²/12 of a square section if left out.
    damping_ratio : float
        Structural damping ξ of every mode, 0 to 1, dimensionless.
    gauge : float
        Where the deflection is recorded, as a fraction of the length between 0 and 1.
    axial : bool
        Whether the link stretches too, in two quadratic shapes:
        a joint at its far end moves along with it.
    """

    shapes: Literal["hermite", "sine"] = "hermite"
    elements: Elements | None = elements_field(None, validate_default=True)
    modes: _Modes | None = measured("number of modes", "1", None, accepts=_SOME_MODES)
    modulus: Positive = measured("Young's modulus", "Pa", 2.1e11)
    density: Positive = measured("density", "kg/m³", 7800.0)
    section: Literal["round", "square"] = "round"
    area: Positive | None = measured("area of the section", "m²", None)
    second_moment: Positive | None = measured("second moment of area", "m⁴", None)
    damping_ratio: DampingRatio = damping_field()
    gauge: Annotated[Positive, Field(lt=1)] = measured("gauge", "1", 0.5, accepts=_BETWEEN_ENDS)
    axial: Flag = False

    @field_validator("elements")
    @classmethod
    def _of_hermite_shapes(cls, elements: int | None, info: ValidationInfo) -> int | None:
        sine = info.data.get("shapes") == "sine"
        if sine and elements is not None:
            raise refuse(elements, "elements are accepted with shapes = 'hermite'; sine shapes take modes")
        return 2 if elements is None and not sine else elements

    @field_validator("modes")
    @classmethod
    def _that_the_elements_hold(cls, modes: int | None, info: ValidationInfo) -> int | None:
        elements = info.data.get("elements")
        if None not in (modes, elements) and modes > 2 * elements:
            raise refuse(modes, f"at most {2 * elements} modes, two an element, are accepted")
        return modes

    def _stated(self, changed: Mapping[str, Any] = {}) -> dict[str, Any]:
        """Fields that were given: a link's shape tells the others."""
        return {key: value for key, value in self if key in self.model_fields_set}

    @property
    def size(self) -> int:
        """Number of modes kept."""
        return self.modes or (2 * self.elements if self.elements else _SINES)


class Link(Record):
    """A link: a line with an origin, its pin at distance 0; rigid, or bending between its two ends.

    Parameters
    ----------
    name : str
        Name, other than ``ground``, which is the frame.
    length : float
        Length from the origin to the far end, m.
    shape : Shape, optional
        What it looks like, of what, without its holes: mass, inertia, and modulus, density, area and second
        moment of its beam then follow where they are not given beside it.
    mass : float
        Mass, kg; needed without a shape.
    centre : float, optional
        Distance of the mass centre from the origin along the link, m; half the length if left out.
    inertia_centre : float, optional
        Moment of inertia about the mass centre, kg m²; this or ``inertia`` is needed without a shape.
    inertia : float, optional
        Moment of inertia about the origin, kg m², greater than mass × centre²; this or ``inertia_centre``.
    masses : tuple of PointMass
        Point masses that the link carries beside its own mass; `total` is the link with them.
    elastic : bool
        Whether the link bends. Its pins then sit at its ends, 0 and length.
    beam : Beam
        How it bends; unused while the link is rigid.
    """

    name: PartName = named("link name")
    length: Length = measured("length", "m")
    shape: Shape | None = None
    mass: Positive = measured("mass", "kg", None, validate_default=True)
    centre: Place = measured("distance of the mass centre", "m", None, validate_default=True)
    inertia_centre: Positive | None = measured("moment of inertia about the mass centre", "kg m²", None)
    inertia: Positive | None = measured(
        "moment of inertia about the link's origin", "kg m²", None, validate_default=True
    )
    masses: Few[PointMass] = ()
    elastic: Flag = False
    beam: Annotated[Beam, Field(validate_default=True)] = Beam()

    @field_validator("name")
    @classmethod
    def _not_the_ground(cls, name: str) -> str:
        if name == GROUND:
            raise refuse(name, "a name other than 'ground' is accepted: that one is the fixed frame")
        return name

    @field_validator("mass", mode="before")
    @classmethod
    def _of_the_shape(cls, mass: Any, info: ValidationInfo) -> Any:
        if mass is not None or not {"length", "shape"} <= info.data.keys():
            return 1.0 if mass is None else mass  # what is wrong with length or shape is a problem of its own
        if info.data["shape"] is None:
            raise refuse(NOTHING, f"a mass greater than 0 kg is accepted, {_OR_A_SHAPE}")
        return info.data["shape"].numbers(info.data["length"])["mass"]

    @field_validator("centre", mode="before")
    @classmethod
    def _halfway(cls, centre: Any, info: ValidationInfo) -> Any:
        return info.data.get("length", 0.0) / 2 if centre is None else centre

    @field_validator("beam")
    @classmethod
    def _of_its_section(cls, beam: Beam, info: ValidationInfo) -> Beam:
        if not info.data.get("shape") or "length" not in info.data:
            return beam
        given = info.data["shape"].beam(info.data["length"])
        return beam.model_copy(update={key: x for key, x in given.items() if beam._stated().get(key) is None})

    @field_validator("inertia")
    @classmethod
    def _positive_definite(cls, inertia: float | None, info: ValidationInfo) -> float | None:
        if inertia is None and "shape" not in info.data:
            return inertia
        if inertia is None and info.data["shape"] and info.data.get("inertia_centre", 0.0) is None:
            return _about_origin(info.data)
        if (inertia is None) == (info.data.get("inertia_centre", 0.0) is None):
            one = "a moment of inertia greater than 0 kg m² is accepted, one of the two"
            both = "inertia (about the link's origin) and inertia_centre (about its mass centre)"
            shape = f", {_OR_A_SHAPE}" if inertia is None else ""
            raise refuse(NOTHING if inertia is None else inertia, f"{one}, {both}{shape}")
        if inertia is None or not {"length", "mass", "centre"} <= info.data.keys():
            return inertia  # one of them is invalid, which is a problem of its own
        least = info.data["mass"] * info.data["centre"] * info.data["centre"]
        if inertia <= least:
            limit = f"greater than mass × centre² = {least:.6g} kg m²"
            about = "one about the mass centre is given as inertia_centre"
            about += in_millimetres(info.data["length"]) if info.data["length"] > LONG else ""
            raise refuse(inertia, f"a moment of inertia about the link's origin {limit} is accepted; {about}")
        return inertia

    @model_validator(mode="after")
    def _bends_as_a_beam_can(self) -> Self:
        raise_any(bending_problems(self) if self.elastic else ())
        return self

    def _stated(self, changed: Mapping[str, Any] = {}) -> dict[str, Any]:
        """Fields but for those that the shape gives, which follow it anew; in place of numbers, all."""
        own, stated = dict(self), self.beam._stated()
        if changed.get("shape", self.shape) is None:
            return own
        if self.shape is None:
            beam = Beam(**{key: x for key, x in stated.items() if key not in _OF_SECTIONS})
            return {key: x for key, x in own.items() if key not in _OF_BODIES} | {"beam": beam}
        numbers = self.shape.numbers(self.length) | {"inertia": _about_origin(own)}
        section = self.shape.beam(self.length)
        beam = Beam(**{key: x for key, x in stated.items() if section.get(key) != x})
        return {key: x for key, x in own.items() if numbers.get(key) != x} | {"beam": beam}

    @property
    def total(self) -> Link:
        """The same link with its point masses in its own mass, centre and inertia about the origin."""
        if self.inertia is not None and not self.masses:
            return self
        own = self.inertia
        if self.inertia_centre is not None:
            own = self.inertia_centre + self.mass * self.centre**2
        total = self.mass + sum(point.mass for point in self.masses)
        moment = self.mass * self.centre + sum(point.mass * point.at for point in self.masses)
        inertia = own + sum(point.mass * point.at**2 for point in self.masses)
        sums = {"mass": total, "centre": moment / total, "inertia": inertia}
        beam = self.beam.model_copy(update={"area": float(area(self))})  # what bends is the link's own mass
        return self.model_copy(update=sums | {"inertia_centre": None, "masses": (), "beam": beam})

    @property
    def description(self) -> str:
        """Length, mass, inertia and elasticity in a few words."""
        whole, points = self.total, f", {len(self.masses)} point masses in it" if self.masses else ""
        shape = f" ({self.shape.description})" if self.shape else ""
        mass, inertia = measure(whole.mass, "kg", 6), measure(whole.inertia, "kg m²", 6)
        rigid = f"{measure(self.length, 'm', 6)}, {mass}{points}, {inertia}{shape}"
        if not self.elastic:
            return rigid
        shapes = f"{self.beam.elements} elements" if self.beam.elements else "sine shapes"
        shapes += ", stretching" if self.beam.axial else ""
        damping = f"damping ratio {plain(self.beam.damping_ratio)}"
        return f"{rigid}, elastic: {shapes}, {self.beam.size} modes, {damping}"


def _about_origin(link: Mapping[str, Any]) -> float:
    """Moment of inertia about its origin that a shape gives to a link of this mass and mass centre."""
    if not {"length", "mass", "centre"} <= link.keys():
        return math.inf  # one of them is invalid, which is a problem of its own
    numbers = link["shape"].numbers(link["length"])
    return link["mass"] * (numbers["inertia_centre"] / numbers["mass"] + link["centre"] ** 2)


def modal(link: Link) -> Modes:
    """Give the modes of a link, bending or not, as its beam describes them."""
    beam, length, mass = link.beam, link.length, np.float64(line_density(link) * link.length)
    modes = (beam.size, beam.gauge)
    unit = hermites(beam.elements, *modes) if beam.elements else sines(*modes)
    weight = np.sqrt(mass)
    return Modes(
        frequency=unit.frequency * np.sqrt(stiffness(link) / (mass * length * length * length)),
        force=unit.force * weight,
        moment=unit.moment * (weight * length),
        second=unit.second * (weight * length**2),
        slope_start=unit.slope_start / (weight * length),
        slope_end=unit.slope_end / (weight * length),
        gauge=unit.gauge / weight,
    )


def area(link: Link) -> float:
    """Give the area A of a link's section, m²: its beam's, or that of a uniform bar of the link's mass."""
    return link.beam.area or np.float64(link.mass) / (link.beam.density * link.length)


def line_density(link: Link) -> float:
    """Give the mass of a link's beam per length ρA, kg/m."""
    return link.beam.density * area(link)


def stiffness(link: Link) -> float:
    """Give the bending stiffness E I of a link's beam, N m²."""
    share = 4 * math.pi if link.beam.section == "round" else 12.0
    return link.beam.modulus * (link.beam.second_moment or area(link) * area(link) / share)


def bending_problems(link: Link) -> list[Problem]:
    """List the problems that make the equations of an elastic link singular; keys are relative to the link.

    The total mass matrix is positive definite where [[m − S·S, m s − S·I], [m s − S·I, J − I·I]] is.
    """
    ends = (0.0, link.length)
    if wrong := [(i, point.at) for i, point in enumerate(link.masses) if point.at not in ends]:
        text = f"0 or {link.length:g} m is accepted: between its ends a mass on an elastic link would bend it"
        return [Problem(f"masses[{i}].at", at, text) for i, at in wrong]
    link = link.total
    with np.errstate(all="ignore"):
        modes = modal(link)
    if not all(0 < frequency < math.inf for frequency in modes.frequency):
        given = {name: getattr(link.beam, name) for name in ("modulus", "density", "area", "second_moment")}
        return [Problem("beam", given, "numbers that give finite frequencies other than 0 are accepted")]
    beam_mass = float(modes.force @ modes.force)
    moved = max(beam_mass, _STRETCHED * line_density(link) * link.length * link.beam.axial)
    if not link.mass - moved > _MARGIN * link.mass:
        most = area(link) * link.mass / moved
        weights = f"{line_density(link) * link.length:.6g} kg, the whole link {link.mass:g} kg"
        text = f"an area less than {most:.6g} m² is accepted: this beam weighs {weights}"
        return [Problem("beam.area", area(link), text)]
    cross = link.mass * link.centre - float(modes.force @ modes.moment)
    least = float(modes.moment @ modes.moment) + cross * cross / (link.mass - beam_mass)
    if not link.inertia - least > _MARGIN * link.inertia:
        limit = f"greater than {least:.6g} kg m² is accepted with this beam, mass and mass centre"
        reason = "else the mass matrix is not positive definite"
        text = f"a moment of inertia about the link's origin {limit}, {reason}"
        return [Problem("inertia", link.inertia, text)]
    return []


@dataclass(frozen=True)
class Modes:
    """Coefficients of the modes φ_i of a beam in the equations of motion; arrays of shape (n,).

    Parameters
    ----------
    frequency : numpy.ndarray
        ω_i, rad/s, rising.
    force : numpy.ndarray
        S_i = ∫ρA φ_i dx, √kg.
    moment, second : numpy.ndarray
        I_i = ∫ρA x φ_i dx, √kg m; ∫ρA x² φ_i dx, √kg m².
    slope_start, slope_end : numpy.ndarray
        φ_i′ at the link's origin and far end, 1/(√kg m); positive at the origin.
    gauge : numpy.ndarray
        φ_i where the deflection is recorded, 1/√kg.
    """

    frequency: Array
    force: Array
    moment: Array
    second: Array
    slope_start: Array
    slope_end: Array
    gauge: Array


def sines(count: int, gauge: float) -> Modes:
    """Sine modes of the beam of unit length, mass and stiffness."""
    i = np.arange(1, count + 1)
    wave, sign = i * math.pi, (-1.0) ** i
    root = math.sqrt(2)
    return Modes(
        frequency=wave**2,
        force=root * (1 - sign) / wave,
        moment=-root * sign / wave,
        second=root * (2 * (sign - 1) / wave**2 - sign) / wave,
        slope_start=root * wave,
        slope_end=root * wave * sign,
        gauge=root * np.sin(wave * gauge),
    )


def hermites(elements: int, count: int, gauge: float) -> Modes:
    """Modes of cubic elements of the beam of unit length, mass and stiffness."""
    squares, shapes, *moments = _solved(elements)
    e = min(int(gauge * elements), elements - 1)
    deflection = _cubics(gauge * elements - e, 1 / elements) @ shapes[2 * e : 2 * e + 4]
    modes = (np.sqrt(squares), *moments, shapes[1], shapes[-1], deflection)
    return Modes(*(values[:count] for values in modes))


@lru_cache(maxsize=32)
def _solved(elements: int) -> tuple[Array, ...]:
    """Solve K_f v = ω² M_f v: squares of the frequencies, coordinates of all modes as columns, moments."""
    from scipy.linalg import eigh  # takes long to import, and rigid mechanisms go without

    mass, bending, *moments = _assembled(elements)
    inner = np.delete(np.arange(2 * elements + 2), [0, 2 * elements])
    squares, vectors = eigh(bending[np.ix_(inner, inner)], mass[np.ix_(inner, inner)])
    shapes = np.zeros((2 * elements + 2, 2 * elements))
    shapes[inner] = vectors * np.sign(vectors[0])
    return squares, shapes, *(moment @ shapes for moment in moments)


def _cubics(s: float, h: float) -> Array:
    """Give the four Hermite cubics of an element of length h at the fraction s of it.

    Their coordinates are deflection and slope at its start, then at its end.
    """
    return np.array(
        [1 - 3 * s**2 + 2 * s**3, h * (s - 2 * s**2 + s**3), 3 * s**2 - 2 * s**3, h * (s**3 - s**2)]
    )


def _assembled(elements: int) -> tuple[Array, ...]:
    """Assemble M_f, K_f, ∫N dx, ∫x N dx and ∫x² N dx of equal elements, both end deflections kept.

    Coordinates are deflection and slope at each node in turn: shapes (2n + 2, 2n + 2) and (2n + 2,).
    """
    h, size = 1 / elements, 2 * elements + 2
    unit = np.array([1, h, 1, h])
    scale = np.outer(unit, unit)
    even = np.array([1 / 2, 1 / 12, 1 / 2, -1 / 12]) * unit * h
    rising = np.array([3 / 20, 1 / 30, 7 / 20, -1 / 20]) * unit * h * h
    squared = np.array([1 / 15, 1 / 60, 4 / 15, -1 / 30]) * unit * h**3
    mass, bending = np.zeros((size, size)), np.zeros((size, size))
    force, moment, second = np.zeros(size), np.zeros(size), np.zeros(size)
    for e in range(elements):
        at = slice(2 * e, 2 * e + 4)
        mass[at, at] += _MASS * scale * h
        bending[at, at] += _BENDING * scale / h**3
        force[at] += even
        moment[at] += e * h * even + rising
        second[at] += (e * h) ** 2 * even + 2 * e * h * rising + squared
    return mass, bending, force, moment, second


_MASS = np.array([[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]]) / 420


_BENDING = np.array([[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]], dtype=float)
