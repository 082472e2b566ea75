"""A family of section maps over one parameter or two, for the pseudo-arclength method.

`map_derivative` gives the end of a section map, its DP, and its dP/dp, exact through every event. Of a test
system and of a linkage alike, in any parameter that a branch can have.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np

from jointplay.analysis.orbits import shooting
from jointplay.analysis.orbits.section_map import Image, SectionMap
from jointplay.analysis.orbits.shooting import Orbit, residual
from jointplay.solver.mechanism.directions import Directions, along, stacked


class Condition(Protocol):
    """Condition on the orbits of a curve in two parameters, besides closing.

    `sided`: whether it has a meaning on one side of the curve only.
    """

    sided: bool

    def value(self, trial: Trial, like: Point) -> float:
        """The number that is zero on the curve; NaN where it has no meaning. `like`: a point nearby."""

    def gradient(self, family: Family, trial: Trial, like: Point) -> np.ndarray:
        """Derivatives in the coordinates x/c and the fractions of the ranges; `trial` has directions."""

    def tests(self, one: Point) -> Mapping[str, Callable[[Point], float]]:
        """Functions that change sign where the curve meets another one, beyond a point."""

    def genuine(self, kind: str, point: Point) -> bool:
        """Whether the zero of such a function is a genuine point of its kind."""


@dataclass(frozen=True)
class Family:
    """Section maps over a parameter, or two.

    Parameters
    ----------
    maps : callable
        Section map at a value of the parameter (of two: at a pair), on the section asked for.
    low, high : float or ndarray, shape (2,)
        Range of the parameter, or of each.
    tolerance : float
        Of a residual, in units of the scales.
    condition : Condition, optional
        Of a curve in two parameters.
    """

    maps: Callable[[Any], SectionMap]
    low: float | np.ndarray
    high: float | np.ndarray
    tolerance: float
    condition: Condition | None = None

    def at(self, q: Any, like: SectionMap) -> SectionMap:
        """The map at a fraction q of the range, of the same section, turns and units as another.

        Units that went with the parameter, as those of speeds with a drive's, would bend the branch.
        """
        return replace(self.maps(self.parameter(q)), phase=like.phase, turns=like.turns, units=like.scale)

    def parameter(self, q: Any) -> Any:
        """The parameter at a fraction of its range."""
        return self.low + q * (self.high - self.low)

    def fraction(self, value: Any) -> Any:
        """The fraction of its range at which the parameter has a value."""
        return (value - self.low) / (self.high - self.low)

    @property
    def count(self) -> int:
        """Number of parameters."""
        return np.size(self.low)

    def place(self, z: np.ndarray) -> Any:
        """The fractions of ranges among unknowns z."""
        return z[-self.count :] if np.ndim(self.low) else z[-1]

    def placed(self, z: np.ndarray, like: Point) -> tuple[SectionMap, np.ndarray]:
        """The map and the state that unknowns z stand for, on the section of a point."""
        section = self.at(self.place(z), like.orbit.map)
        return section, section.state(z[: -self.count] * like.unit)

    def directions(self, q: Any, like: SectionMap) -> Directions:
        """Derivatives of the numbers behind the maps in each parameter, at fractions q of the ranges."""
        values = np.atleast_1d(np.asarray(self.parameter(q), dtype=float))

        def along(k: int) -> Directions:
            def maps(value: float) -> SectionMap:
                there = np.where(np.arange(len(values)) == k, value, values)
                return replace(self.maps(there if np.ndim(self.low) else value), phase=like.phase)

            return direction(maps, float(values[k]), precise=False)

        return stacked([along(k) for k in range(len(values))])

    def slopes(self, image: Image) -> np.ndarray:
        """Derivatives of an image in the coordinates and, a column each, in the fractions of the ranges."""
        return np.column_stack([image.derivative, image.along * (self.high - self.low)])

    def trial(self, z: np.ndarray, like: Point) -> Trial:
        """The residual at unknowns z."""
        section, state = self.placed(z, like)
        image = section.image(state)
        trial = Trial(z, section, state, image, residual(section, state, image) / like.unit)
        if self.condition is None or image.status:
            return trial
        return replace(trial, r=np.append(trial.r, self.condition.value(trial, like)))


@dataclass(frozen=True)
class Trial:
    """Unknowns, the map and the state that they stand for, its image, and the residual r(z).

    That is (Phi(x) - x)/c, and the condition's value where there is one. `directions` are those of the
    parameters, where the image has its derivatives in them.
    """

    z: np.ndarray
    section: SectionMap
    state: np.ndarray
    image: Image
    r: np.ndarray
    directions: Directions | None = None

    def size(self, unit: float) -> float:
        """The residual's largest component: of states in units of their scales."""
        free = len(self.section.free)
        with np.errstate(invalid="ignore"):
            size = np.max(np.abs(np.append(self.r[:free] * unit, self.r[free:])))
        return float(size) if np.isfinite(size) else np.inf


@dataclass(frozen=True)
class Point:
    """A point of a branch, or of a curve.

    Parameters
    ----------
    orbit : Orbit
        The periodic orbit, with the map that it is a fixed point of.
    q : float or ndarray, shape (2,)
        Fractions of the parameters' ranges.
    unit : float
        The constant c.
    tangent : ndarray
        Of the branch, of length 1: coordinates, then parameters.
    iterations : int
        Corrections by Newton's method.
    jacobian : ndarray, optional
        Derivatives of the residual with respect to the unknowns, there.
    directions : Directions, optional
        Of the parameters, there.
    """

    orbit: Orbit
    q: Any
    unit: float
    tangent: np.ndarray
    iterations: int = 0
    jacobian: np.ndarray | None = None
    directions: Directions | None = None

    @property
    def z(self) -> np.ndarray:
        """Coordinates on the section and parameters, scaled."""
        return np.append(self.orbit.map.unknowns(self.orbit.state) / self.unit, self.q)

    @property
    def multipliers(self) -> np.ndarray:
        """Floquet multipliers."""
        return shooting.multipliers(self.orbit.image.derivative)


def direction(
    maps: Callable[[float], SectionMap], value: float, key: str = "parameter", precise: bool = True
) -> Directions:
    """Derivatives of the numbers behind section maps in a parameter.

    Parameters
    ----------
    maps : callable
        Section map at a value of the parameter, all of one section.
    value : float
        Where.
    key : str
        Name of the parameter in messages.
    precise : bool
        As in `mechanism.directions.along`.
    """
    own = maps(value)
    return along(
        lambda at: maps(at).model, value, key, lambda model: replace(own, model=model).begin, precise
    )


def map_derivative(
    maps: Callable[[float], SectionMap],
    value: float,
    state: np.ndarray,
    like: SectionMap | None = None,
    key: str = "parameter",
) -> Image:
    """Image of a state on a section, with the derivative in the state, and in the parameter.

    Parameters
    ----------
    maps, value, key
        As in `direction`.
    state : ndarray
        On the section, which does not move with the parameter.
    like : SectionMap, optional
        Whose phase, turns and units are taken; the map's own if left out.

    Returns
    -------
    Image
        With ``derivative`` DP, ``along`` dP/dp (one column, units of the scales), ``times`` dT/dp.
    """
    own = maps(value)
    if like is not None:
        own = replace(own, phase=like.phase, turns=like.turns, units=like.scale)
    return own.image(state, directions=direction(lambda at: replace(maps(at), phase=own.phase), value, key))
