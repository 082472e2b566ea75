"""Pseudo-arclength continuation of fixed points of a section map in one parameter.

Unknowns z = (x/c, q): the section's coordinates in units of their scales over a constant c, and the
parameter as a fraction of its range. From a point with unit tangent t the next one solves

    Phi(x, p) - x = 0,   t . (z - z0) = s

by Newton's method from z0 + s t (Keller 1977). c is such that at the start a step is divided evenly between
orbit and parameter. The derivative with respect to the parameter is a central difference of the map; it only
sets steps, so that its error moves no point. A section with an event near it is moved on (orbit_search).
References: Allgower and Georg, Introduction to Numerical Continuation Methods (2003), chapters 2, 6 and 7.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from operator import itemgetter

import numpy as np

from jointplay.analysis.orbits import floquet
from jointplay.analysis.orbits.orbit_events import same_events
from jointplay.analysis.orbits.section_map import Image, SectionMap
from jointplay.analysis.orbits.shooting import Orbit, residual

DIFFERENCE = 3e-5  # of the range: half the distance of a central difference
FINEST = 1e-8  # of the range: the smallest difference
CORRECTIONS = 8  # at most
PATIENCE = 3  # corrections after which the residual must shrink
GAIN = 0.3  # factor by which a correction below the tolerance must reduce the residual
ROUNDING = 1e-14
KEPT = 1e-9  # singular values below it, relative to the largest, are not divided by


@dataclass(frozen=True)
class Family:
    """Section maps over a parameter.

    Parameters
    ----------
    maps : callable
        Section map at a value of the parameter, on the section asked for.
    low, high : float
        Range of the parameter.
    tolerance : float
        Of a residual, in units of the scales.
    """

    maps: Callable[[float], SectionMap]
    low: float
    high: float
    tolerance: float

    def at(self, q: float, like: SectionMap) -> SectionMap:
        """The map at a fraction q of the range, of the same section, turns and units as another.

        Units that went with the parameter, as those of speeds with a drive's, would bend the branch.
        """
        return replace(self.maps(self.parameter(q)), phase=like.phase, turns=like.turns, units=like.scale)

    def parameter(self, q: float) -> float:
        """The parameter at a fraction of its range."""
        return self.low + q * (self.high - self.low)

    def fraction(self, value: float) -> float:
        """The fraction of its range at which the parameter has a value."""
        return (value - self.low) / (self.high - self.low)


@dataclass(frozen=True)
class Point:
    """A point of a branch.

    Parameters
    ----------
    orbit : Orbit
        The periodic orbit, with the map that it is a fixed point of.
    q : float
        Fraction of the parameter's range.
    unit : float
        The constant c.
    tangent : ndarray
        Of the branch, of length 1: coordinates, then the parameter.
    iterations : int
        Corrections by Newton's method.
    """

    orbit: Orbit
    q: float
    unit: float
    tangent: np.ndarray
    iterations: int = 0

    @property
    def z(self) -> np.ndarray:
        """Coordinates on the section and parameter, scaled."""
        return np.append(self.orbit.map.unknowns(self.orbit.state) / self.unit, self.q)

    @property
    def multipliers(self) -> np.ndarray:
        """Floquet multipliers."""
        return floquet.multipliers(self.orbit.image.derivative)


def solve(family: Family, like: Point, guess: np.ndarray, normal: np.ndarray) -> Point | None:
    """Point of the branch on the plane through `guess` with this normal; None if Newton's method fails.

    Parameters
    ----------
    family : Family
        Of maps.
    like : Point
        Point whose section, turns and unit are used.
    guess, normal : ndarray
        Scaled, as `Point.z`.
    """
    z, size, count = np.array(guess), np.inf, 0
    while count <= CORRECTIONS:
        section = family.at(z[-1], like.orbit.map)
        state = section.state(z[:-1] * like.unit)
        image = section.image(state)
        r = residual(section, state, image)
        before, size = size, float(np.max(np.abs(r)))
        if not np.isfinite(size) or (count > PATIENCE and size > max(before, family.tolerance)):
            return None
        done = size < ROUNDING or (
            size <= family.tolerance and (size > GAIN * before or count == CORRECTIONS)
        )
        if done or count == 0:  # between these, the first column is accurate enough
            slope = _slope(family, section, state, image, z[-1]) / like.unit
        A = np.column_stack([image.derivative - np.eye(len(r)), slope])
        if done:
            orbit = Orbit(0, section, state, image, size, count)
            return Point(orbit, float(z[-1]), like.unit, _tangent(A, normal), count)
        if not np.all(np.isfinite(A)):
            return None
        rows = np.vstack([A, normal])
        left = np.append(-r / like.unit, normal @ (guess - z))
        z = z + np.linalg.lstsq(rows, left, rcond=KEPT)[0]
        count += 1
    return None


def _slope(
    family: Family, section: SectionMap, state: np.ndarray, image: Image, q: float, size: float = DIFFERENCE
) -> np.ndarray:
    """Derivative of the map with respect to the fraction of the parameter's range.

    A difference of motions with the same events: beside a grazing one-sided, or smaller. Beyond its range the
    parameter may have no meaning. NaN where runs failed.
    """
    low, high = (max(q - size, 0.0), min(q + size, 1.0)) if 0 <= q <= 1 else (q - size, q + size)
    images = [(q, image)]
    for side in (low, high):
        other = family.at(side, section).image(state, False) if side != q else image
        if not other.status and same_events(other.events, image.events):
            images.append((side, other))
    (first, one), (last, other) = min(images, key=itemgetter(0)), max(images, key=itemgetter(0))
    if first < last:
        return section.differ(other.state, one.state) / (last - first)
    if size > FINEST:
        return _slope(family, section, state, image, q, size / 100)
    return np.full_like(state[section.free], np.nan)


def _tangent(A: np.ndarray, along: np.ndarray) -> np.ndarray:
    """Unit null vector of A, with the sense of `along`; `along` itself where A is not finite."""
    if not np.all(np.isfinite(A)):
        return along / np.linalg.norm(along)
    null = np.linalg.svd(A)[2][-1]
    return null if null @ along >= 0 else -null


def first(family: Family, orbit: Orbit, q: float, upward: bool = True) -> Point:
    """Point of a branch at an orbit, with the constant that divides steps evenly."""
    slope = _slope(family, orbit.map, orbit.state, orbit.image, q)
    P = orbit.image.derivative
    sense = np.append(np.zeros(len(P)), 1.0 if upward else -1.0)
    if not np.all(np.isfinite(slope)):
        return Point(orbit, q, 1.0, sense)
    along = _tangent(np.column_stack([P - np.eye(len(P)), slope]), sense)
    size = np.linalg.norm(along[:-1])
    unit = float(np.clip(size / max(abs(along[-1]), 1e-12), 1e-6, 1e6)) if size > 0 else 1.0
    tangent = np.append(along[:-1] / unit, along[-1])
    return Point(orbit, q, unit, tangent / np.linalg.norm(tangent))
