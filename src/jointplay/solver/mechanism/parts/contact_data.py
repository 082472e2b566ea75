"""Contact data of a pin in its bush: stiffness, damping and friction from materials, sizes and finish.

Under a force F over the bush's length L the pin's centre comes nearer by u. With w = F/L, the radii R and
R + e, c = (1 - nu²)/(pi E) of pin (j) and bush (b), and pi E* = 1/(c_j + c_b):

    hertz   a line contact of half width a, a² = 4 w R (R + e) (c_j + c_b)/e; the pin is pressed as far as to
            its centre, the bush as deep as its wall t (Johnson 1985, Contact Mechanics, section 5.6):
            u = w c_j (2 ln(4 R/a) - 1) + w c_b (2 ln(2 t/a) - nu_b/(1 - nu_b)).
            Valid for narrow contacts: taken here up to a = R/2, 30 degrees to either side, and a = t/2.
    johnson, dubowsky_freudenstein, liu
            as in `equations.cylinders`, with their assumptions: the first two for narrow contacts, taken
            here up to a quarter of the depth where they turn back; Liu's for those that conform, at any load.

Persson's (1964) exact solution of conforming contact gives its angle and pressure. The approach of the
centres, which counts here, it leaves to the surroundings of the hole, so that it is none of these methods.

In series with each are the pin's bending and shear, held at both ends of the bush under an even load, with a
mean deflection F L³/(120 E I) + F L/(12 k G A), k = 0.9; and the flattening of roughness, its pressure as
exp(-u/u_0), u_0 = 0.4 of the root mean square of heights (Persson 2007, Phys. Rev. Lett. 99, 125502): a
stiffness F/u_0 whatever the area. From approach and tangent at one load follow the exponent n = u/F dF/du and
K = F/u^n.

Damping is Hunt and Crossley's, F = K u^n (1 + chi v): chi = d/v, with the d that gives the coefficient of
restitution e exactly at the speed v, the root of d (1 + e) = ln((1 + d)/(1 - d e)), whatever K, n and mass.

`contact_stiffness` is Hertz's (1882) of balls: F = K u^(3/2), K = 4/3 E* sqrt(R), 1/R = 1/R_1 + 1/R_2, the
radius of a hollow ball being negative. Valid where the contact is small beside both radii. Units: SI.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

from pydantic import Field

from jointplay.display.errors import Problem, refuse
from jointplay.display.number_text import plain
from jointplay.solver.equations import cylinders
from jointplay.solver.equations.laws import LAWS
from jointplay.solver.mechanism.base import NonNegative, Number, Positive, Record, is_number, measured, unit
from jointplay.solver.mechanism.parts.materials import AnyMaterial, Material
from jointplay.solver.mechanism.signature import checked

Pair = float | tuple[float, float]
Method = Annotated[Literal["hertz", "johnson", "dubowsky_freudenstein", "liu"], Field()]
Lubrication = Annotated[Literal["greased", "dry"], Field()]
ROUGHNESS, SPEED = 4e-7, 0.1  # m; m/s
USUAL_PRESSURE = 5e6  # Pa, over the projected area 2 R L: of bushes in machines
NARROW, DEEP = 0.5, 0.25  # formulas of narrow contacts end there: of R, t; of the depth where they turn back
BORNE = 0.02  # of the softer modulus: no material bears a larger pressure, but rubber
BEYOND = 1.5  # to either side, of a stiffness: what no method has, as edges, a loose bush, the boss around it
_SHEAR = 0.9  # share of a round section that bears shear
_HEIGHTS = 1.25 * math.sqrt(2)  # root mean square of two rough surfaces over the Ra of each
_Restitution = Annotated[Number, Field(ge=0.05, le=1)]


class PinInBush(Record):
    """A pin in its bush, as a drawing has them.

    Parameters
    ----------
    pin, bush : Material
        What they are made of: a name of the table, as ``"steel"``, or a table of its own numbers.
    length : float
        Length of the bush, m.
    wall : float, optional
        Thickness of the bush's wall, m; the pin's radius if left out.
    roughness : float
        Mean roughness Ra of either surface, m.
    load : float, optional
        Force at which its law is as stiff as the contact, N; that of 5 MPa over the pin's diameter and the
        bush's length if left out.
    method : {'hertz', 'johnson', 'dubowsky_freudenstein', 'liu'}, optional
        How it is computed; Hertz's where it holds at that load, else Liu's, if left out.
    restitution : float, optional
        Coefficient of restitution, 0.05 to 1, at a blow of `speed`; the softer material's if left out.
    speed : float
        Speed of a blow, m/s.
    lubrication : {'greased', 'dry'}
        Of which the coefficient of friction is.
    """

    root: ClassVar[str | None] = ""
    pin: AnyMaterial
    bush: AnyMaterial
    length: Positive = measured("length of the bush", "m")
    wall: Positive | None = measured("thickness of the bush's wall", "m", None)
    roughness: NonNegative = measured("roughness Ra", "m", ROUGHNESS)
    load: Positive | None = measured("load", "N", None)
    method: Method | None = None
    restitution: _Restitution | None = measured("coefficient of restitution", "1", None)
    speed: Positive = measured("speed of a blow", "m/s", SPEED)
    lubrication: Lubrication = "greased"

    @property
    def softer(self) -> Material:
        """The softer of the two materials, of which friction and restitution are."""
        return min(self.bush, self.pin, key=lambda material: material.modulus)

    @property
    def friction(self) -> Estimate:
        """Coefficient of friction."""
        known, lubrication = self.softer.known, self.lubrication
        source = f"{self.softer.name}, {lubrication}: {known.sources}"
        return Estimate(*getattr(known, lubrication), "1", source)


class Estimate(NamedTuple):
    """A number with its spread and where it comes from.

    Parameters
    ----------
    value, low, high : float
        Usual value, and between what it may lie.
    units : str
        Its units.
    source : str
        Where it comes from.
    """

    value: float
    low: float
    high: float
    units: str
    source: str

    def __str__(self) -> str:
        units = "" if self.units == "1" else f" {self.units}"
        value, low, high = (plain(each, 4) for each in self[:3])
        return f"{value}{units} ({low} to {high}), {self.source}"


class _Pressed(NamedTuple):
    """A pin pressed into its bush: approach u, m, d ln F/d ln u, half width, m, and whether this holds."""

    approach: float
    exponent: float
    half_width: float
    holds: bool


@dataclass(frozen=True)
class ContactData:
    """Contact data of a pin in its bush, from materials, sizes and finish.

    Parameters
    ----------
    parts : PinInBush
        The two.
    radius, clearance : float
        Radius of the pin, and how much larger the bush's is, m.
    """

    parts: PinInBush
    radius: float
    clearance: float

    @property
    def load(self) -> float:
        """Force at which stiffness and exponent are taken, N."""
        return self.parts.load or USUAL_PRESSURE * 2 * self.radius * self.parts.length

    @cached_property
    def method(self) -> Method:
        """How the elastic approach is computed."""
        return self.parts.method or ("hertz" if self._pressed("hertz").holds else "liu")

    @cached_property
    def approach(self) -> float:
        """How much nearer to the bush the pin's centre is under the load, m."""
        return self._approach(self.method)

    @property
    def half_angle(self) -> float:
        """Angle of the contact to either side, rad."""
        return math.asin(min(1.0, self._pressed(self.method).half_width / self.radius))

    @property
    def pressure(self) -> float:
        """Largest pressure under the load, of an elliptical distribution over the contact, Pa."""
        return 2 * self.load / (math.pi * self.parts.length * self._pressed(self.method).half_width)

    @property
    def crushed(self) -> str:
        """Remark on a load that no material bears; empty of others."""
        softer, mean = self.parts.softer, USUAL_PRESSURE / 1e6
        if self.pressure <= BORNE * softer.modulus:
            return ""
        share = f"{plain(self.pressure / softer.modulus, 3)} times the modulus of {softer.name}"
        beyond = f"that is a pressure of {share}, far beyond elastic contact, which the formulas assume"
        return f"{beyond}; bushes of machines bear some {mean:g} MPa"

    @property
    def methods(self) -> dict[str, float]:
        """Force over approach by each method that holds at the load, N/m."""
        names = [name for name in _METHODS if self._pressed(name).holds]
        return {name: self.load / self._approach(name) for name in names}

    @cached_property
    def secant(self) -> Estimate:
        """Force over approach under the load, N/m; between all methods that hold, with moduli and roughness.

        A factor `BEYOND` to either side stands for what none of them has.
        """
        low, high = (
            self.load / extreme(self._approach(name, side, rough) for name in {*self.methods, self.method})
            for side, rough, extreme in ((1, 2.0, max), (2, 0.0, min))
        )
        source = f"{self.method} at {self.load:.4g} N"
        return Estimate(self.load / self.approach, low / BEYOND, high * BEYOND, "N/m", source)

    @cached_property
    def exponent(self) -> Estimate:
        """Exponent n of the power law that has approach and tangent of the contact at the load."""
        elastic = [self._exponent(name) for name in {*self.methods, self.method}]
        return Estimate(self._exponent(self.method), min(elastic), max(elastic), "1", self.secant.source)

    @property
    def stiffness(self) -> Estimate:
        """K of that power law, N/m^n; its spread is that of the force at the same approach."""
        n, each = self.exponent.value, self.secant
        K = self.load / self.approach**n
        return Estimate(K, K * each.low / each.value, K * each.high / each.value, f"N/m^{n:.4g}", each.source)

    @property
    def restitution(self) -> Estimate:
        """Coefficient of restitution at the speed of a blow."""
        given, softer, speed = self.parts.restitution, self.parts.softer, f"at {self.parts.speed:g} m/s"
        if given:
            return Estimate(given, max(0.05, given - 0.2), min(1.0, given + 0.2), "1", f"given, {speed}")
        return Estimate(*softer.known.restitution, "1", f"{softer.name}, {speed}: estimate")

    @property
    def dissipation(self) -> Estimate:
        """χ of Hunt and Crossley's law, s/m, that gives this restitution at that speed."""
        e, speed = self.restitution, self.parts.speed
        usual, low, high = (damping_factor(each) / speed for each in (e.value, e.high, e.low))
        return Estimate(usual, low, high, "s/m", f"restitution {e.value:g}, {e.source}")

    @property
    def friction(self) -> Estimate:
        """Coefficient of friction."""
        return self.parts.friction

    def numbers(self, law: str, given: Mapping[str, Any]) -> dict[str, float]:
        """Numbers that a law of contact has beside those that are given, as far as they follow."""
        own = LAWS[law].numbers
        n = given.get("exponent", self.exponent.value) if "exponent" in own else 1.0
        values = {"stiffness": self.load / self.approach**n, "exponent": n, "length": self.parts.length}
        values |= {"dissipation": self.dissipation.value, "restitution": self.restitution.value}
        for side, material in (("journal", self.parts.pin), ("bearing", self.parts.bush)):
            values |= {f"{side}_modulus": material.modulus, f"{side}_poisson_ratio": material.poisson_ratio}
        return {name: value for name, value in values.items() if name in own}

    def check(self) -> None:
        """Refuse a method that does not hold at the load."""
        if not self._pressed(self.method).holds:
            wide = math.degrees(self.half_angle)
            text = f"with {self.load:.4g} N the contact is {wide:.0f} degrees wide to either side, too wide"
            held = " or ".join(map(repr, self.methods))
            raise refuse(self.method, f"method = {held} is accepted, or a smaller load: {text}", "method")

    def __str__(self) -> str:
        names = ("stiffness", "exponent", "secant", "restitution", "dissipation", "friction")
        lines = [f"{name:<12}{getattr(self, name)}" for name in names]
        wide, most = math.degrees(self.half_angle), plain(self.pressure / 1e6, 3)
        others = ", ".join(f"{name} {plain(value, 3)}" for name, value in self.methods.items())
        lines += [f"contact     {wide:.3g} degrees to either side, {most} MPa", f"N/m by      {others}"]
        return "\n".join([*lines, *([f"load        {self.crushed}"] if self.crushed else [])])

    def _moduli(self, side: int) -> tuple[float, float]:
        return self.parts.pin.moduli[side], self.parts.bush.moduli[side]

    def _pressed(self, method: str, side: int = 0) -> _Pressed:
        """Elastic approach by one method, with usual (0), low (1) or high (2) moduli."""
        return _METHODS[method](self, *self._moduli(side))

    def _approach(self, method: str, side: int = 0, rough: float = 1.0) -> float:
        return self._pressed(method, side).approach + self._bent(side) + rough * self._flattened

    def _exponent(self, method: str) -> float:
        """d ln F/d ln u of the contact and of the compliance in series with it."""
        u, n, *_ = self._pressed(method)
        linear = self._bent(0) + self._flattened
        return (u + linear) / (u / n + linear)

    def _bent(self, side: int) -> float:
        E, L, R = self._moduli(side)[0], self.parts.length, self.radius
        bending = L**3 / (120 * E * math.pi * R**4 / 4)
        shear = L * (1 + self.parts.pin.poisson_ratio) / (6 * _SHEAR * E * math.pi * R**2)
        return self.load * (bending + shear)

    @property
    def _flattened(self) -> float:
        return 0.4 * _HEIGHTS * self.parts.roughness


def _hertz(data: ContactData, E_j: float, E_b: float) -> _Pressed:
    parts, R, e = data.parts, data.radius, data.clearance
    nu_j, nu_b = parts.pin.poisson_ratio, parts.bush.poisson_ratio
    w, wall = data.load / parts.length, parts.wall or R
    c_j, c_b = (1 - nu_j**2) / (math.pi * E_j), (1 - nu_b**2) / (math.pi * E_b)
    a = 2 * math.sqrt(w * R * (R + e) / e * (c_j + c_b))
    u = w * c_j * (2 * math.log(4 * R / a) - 1) + w * c_b * (2 * math.log(2 * wall / a) - nu_b / (1 - nu_b))
    return _Pressed(u, u / (u - w * (c_j + c_b)), a, a <= NARROW * min(R, wall) and u > w * (c_j + c_b))


def _cylindrical(form: Any) -> Any:
    def pressed(data: ContactData, E_j: float, E_b: float) -> _Pressed:
        parts, R, e, F = data.parts, data.radius, data.clearance, data.load
        E = cylinders.modulus(E_j, parts.pin.poisson_ratio, E_b, parts.bush.poisson_ratio)
        S, depth = form(parts.length, E, R, e)
        if form is cylinders.liu:
            u = _conforming(F, S, e)
            return _Pressed(u, 1 + e / (2 * (e + u)), R * math.sqrt(1 - (e / (e + u)) ** 2), True)
        turns = math.log(S * math.e * depth / F)
        half_width = 2 * math.sqrt(F * R * (R + e) / (S * e))
        holds = turns > 1 and F * turns / S <= DEEP * depth
        return _Pressed(F * turns / S, turns / (turns - 1) if turns > 1 else math.nan, half_width, holds)

    return pressed


_METHODS = {"hertz": _hertz} | {
    name: _cylindrical(getattr(cylinders, name)) for name in ("johnson", "dubowsky_freudenstein", "liu")
}


def _conforming(F: float, S: float, e: float) -> float:
    """Approach u at which Liu's force is F: the root of u³ = 8 (F/S)² (e + u)."""
    from scipy.optimize import brentq

    p = 8 * (F / S) ** 2
    most = math.sqrt(p) + (p * e) ** (1 / 3)
    return brentq(lambda u: u**3 - p * (e + u), 0.0, most, xtol=1e-18, rtol=1e-14)


@lru_cache(maxsize=256)
def damping_factor(restitution: float) -> float:
    """Factor d with which F = K u^n (1 + d v/v_0) gives this restitution, 0.05 to 1, exactly."""
    from scipy.optimize import brentq

    e = restitution
    if e >= 1:
        return 0.0
    near = 3 * (1 - e**2) / (2 * (1 + e**3))  # the root to first order of 1 - e
    ends = near / 4, (1 - 1e-15) / e
    return brentq(lambda d: d * (1 + e) - math.log((1 + d) / (1 - d * e)), *ends, rtol=1e-14)


def _no_radius(radius: float, clearance: float) -> Iterator[Problem]:
    """Yield a problem where a bearing's radius is given as its clearance."""
    if clearance >= radius:
        text = f"a clearance less than the radius, {radius:g} m, is accepted: the difference of the two radii"
        meant = f"; of a bearing of {clearance:g} m it is {clearance - radius:.6g}" * (clearance > radius)
        yield Problem("clearance", clearance, text + meant)


@checked(_no_radius)
def contact_data(
    radius: Annotated[Positive, unit("radius", "m")],
    clearance: Annotated[Positive, unit("radial clearance", "m")],
    *,
    pin: AnyMaterial,
    bush: AnyMaterial,
    length: Annotated[Positive, unit("length of the bush", "m")],
    wall: Annotated[Positive, unit("thickness of the bush's wall", "m")] | None = None,
    roughness: Annotated[NonNegative, unit("roughness Ra", "m")] = ROUGHNESS,
    load: Annotated[Positive, unit("load", "N")] | None = None,
    method: Method | None = None,
    restitution: Annotated[_Restitution, unit("coefficient of restitution", "1")] | None = None,
    speed: Annotated[Positive, unit("speed of a blow", "m/s")] = SPEED,
    lubrication: Lubrication = "greased",
) -> ContactData:
    """Give stiffness, damping and friction of a pin in its bush, each with its spread and its source.

    Parameters
    ----------
    radius : float
        Radius of the pin, m.
    clearance : float
        How much larger the bush's radius is, m.
    pin, bush, length, wall, roughness, load, method, restitution, speed, lubrication
        As in `PinInBush`, and as in a joint's ``contact``.

    Returns
    -------
    ContactData
        With ``stiffness``, ``exponent``, ``secant``, ``restitution``, ``dissipation`` and ``friction``, each
        a value between low and high; printed, a table of them.

    Raises
    ------
    InputError
        Listing what makes no sense, and a method that does not hold at the load.
    """
    sizes = {"length": length, "wall": wall, "roughness": roughness, "load": load, "method": method}
    blow = {"restitution": restitution, "speed": speed, "lubrication": lubrication}
    found = ContactData(PinInBush(pin=pin, bush=bush, **sizes, **blow), radius, clearance)
    found.check()
    return found


def _pair(given: Any) -> tuple[Any, ...]:
    """One number for each body."""
    return tuple(given) if isinstance(given, tuple | list) else (given, given)


def _pairs_fit(modulus: Any, poisson_ratio: Any) -> Iterator[Problem]:
    """Yield a problem where there are not two moduli, or not two ratios, that a material can have."""
    fits = {
        "modulus": (modulus, lambda E: E > 0, "greater than 0 Pa"),
        "poisson_ratio": (poisson_ratio, lambda nu: -1 < nu <= 0.5, "above -1, up to 0.5"),
    }
    for name, (given, fit, accepted) in fits.items():
        pair = _pair(given)
        if len(pair) != 2 or not all(is_number(each) and fit(each) for each in pair):
            yield Problem(name, given, f"a number {accepted}, or a pair of them, is accepted")


@checked(_pairs_fit, _no_radius)
def contact_stiffness(
    radius: Annotated[Positive, unit("radius", "m")],
    clearance: Annotated[Positive, unit("clearance", "m")],
    modulus: Pair = 2.07e11,
    poisson_ratio: Pair = 0.3,
) -> float:
    """Give Hertz's stiffness of a ball in a hollow ball; a pin in a bush is a cylinder: see `contact_data`.

    Parameters
    ----------
    radius : float
        Radius of the ball, m.
    clearance : float
        How much larger the hollow ball's radius is, m; less than the radius.
    modulus : float or pair of float
        Young's modulus, of both or of each, Pa; that of steel if left out.
    poisson_ratio : float or pair of float
        Poisson's ratio, of both or of each.

    Returns
    -------
    float
        K, N/m^1.5: the ``stiffness`` of ``hertz`` and of the laws with the same exponent.

    Raises
    ------
    InputError
        Listing what makes no sense.
    """
    materials = zip(_pair(modulus), _pair(poisson_ratio), strict=True)
    compliance = sum((1 - nu**2) / E for E, nu in materials)
    return 4 / (3 * compliance) * math.sqrt(radius * (radius + clearance) / clearance)
