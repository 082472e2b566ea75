"""Special points of a branch of periodic orbits: folds, branch points, period doublings, tori; switching.

Between two points of a smooth piece of a branch a test function that changes sign is followed to its zero on
the branch itself (Brent's method on the arc):

fold                the tangent's component along the parameter
branch point        det(P - I) over that component: a symmetry is lost, or branches cross
period doubling     det(P + I)
Neimark-Sacker      prod_{i<j} (mu_i mu_j - 1), if the critical pair is not real

From a period doubling the doubled orbit leaves along the eigenvector of -1; from a branch point the other
branch along that of +1. Reference: Kuznetsov (2004), chapters 5 and 10; Keller (1977) for switching.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any

import numpy as np

from jointplay.analysis.orbits import shooting
from jointplay.analysis.orbits.arclength import solve
from jointplay.analysis.orbits.family import Family, Point
from jointplay.analysis.orbits.section_map import same_events

KINDS = ("fold", "branch_point", "period_doubling", "neimark_sacker", "grazing")
ZERO = 1e-3  # tolerance of a critical multiplier, or of the tangent at a fold
REAL = 1e-6  # imaginary part below which a pair counts as real
PRECISE = 1e-11  # of the arc; the parameter is then found by interpolation
SHARES = (0.3, 0.1, 0.03, 0.01, 0.003, 0.001)  # of the longest step, tried as the first step on a new branch

Test = Callable[[Point], float]


def unit(point: Point) -> float:
    """Zero where a multiplier is +1: det(P - I)."""
    return float(np.prod(point.multipliers - 1).real)


def doubling(point: Point) -> float:
    """Zero where a multiplier is -1: det(P + I)."""
    return float(np.prod(point.multipliers + 1).real)


def torus(point: Point) -> float:
    """Zero where the product of two multipliers is 1."""
    return float(np.prod([a * b - 1 for a, b in combinations(point.multipliers, 2)]).real)


TESTS: dict[str, Test] = {
    "fold": lambda point: float(point.tangent[-1]),
    "branch_point": lambda point: unit(point) / float(point.tangent[-1]),
    "period_doubling": doubling,
    "neimark_sacker": torus,
}


@dataclass(frozen=True)
class Special:
    """A point at which a branch changes.

    Parameters
    ----------
    kind : str
        One of `KINDS`.
    point : Point
        On the branch, there or next to it.
    q : float
        Where it is, as a fraction of the parameter's range, or two of them.
    width : float
        How closely that is enclosed, or how far the point is from it.
    event : tuple of int
        At a grazing: contact and kind of the event that appears or vanishes.
    """

    kind: str
    point: Point
    q: Any
    width: float
    event: tuple[int, int] = (-1, -1)

    @property
    def multiplier(self) -> complex:
        """The critical multiplier; NaN at a grazing."""
        if self.kind == "grazing":
            return complex(np.nan, np.nan)
        return shooting.critical(self.point.multipliers, self.kind)


def between(family: Family, one: Point, other: Point) -> list[Special]:
    """The special points between two neighbours of a smooth piece, in order."""
    specials, own = [], family.condition
    for kind, test in (TESTS if own is None else own.tests(one)).items():
        if len(one.tangent) < 3 and kind == "neimark_sacker":
            continue
        ends = test(one), test(other)
        if np.all(np.isfinite(ends)) and ends[0] * ends[1] < 0:
            special = _located(family, one, other, kind, test, ends)
            specials += [special] if special is not None else []
    along = other.z - one.z
    return sorted(specials, key=lambda special: float((special.point.z - one.z) @ along))


def _located(family: Family, one: Point, other: Point, kind: str, test: Test, ends) -> Special | None:
    """The zero of a test function; None if it jumps there, or a pair is real."""
    from scipy.optimize import brentq  # takes long to import, and orbits alone go without

    if kind == "branch_point":  # beside one the tangent is ill-conditioned; multipliers are not
        units = [unit(point) for point in (one, other)]
        if units[0] * units[1] < 0:
            test, ends = unit, units
    near = [(ends[0], one, one.tangent), (ends[1], other, other.tangent)]

    def value(place: float) -> float:
        if place in (0.0, 1.0):
            return ends[int(place)]
        guess, along = _arc(one, other, place)
        point = solve(family, one, guess, along)
        if point is None:
            raise ArithmeticError
        near.append((test(point), point, along))
        return near[-1][0]

    try:
        brentq(value, 0.0, 1.0, xtol=PRECISE, rtol=PRECISE, maxiter=60)
    except (ArithmeticError, RuntimeError):
        return None
    near.sort(key=lambda each: abs(each[0]))
    _, point, along = near[0]
    if not (family.condition.genuine if family.condition else _genuine)(kind, point):
        return None
    if kind == "fold":  # where the parameter has an extremum there is nothing to interpolate
        return Special(kind, point, point.q, abs(near[1][1].q - point.q))
    q, other_q = _root(near[0], near[1]), _root(near[0], near[-1] if len(near) < 3 else near[2])
    if kind == "branch_point" or family.condition is not None:  # two directions, or nearly
        point = replace(point, tangent=along)
    return Special(kind, point, q, float(np.max(np.abs(other_q - q))))


def _root(one: tuple, other: tuple) -> Any:
    """Parameter of a test function's zero, by interpolation: near a branch point arcs are uncertain."""
    (a, p, _), (b, r, _) = one, other
    return p.q if a == b else p.q - a * (r.q - p.q) / (b - a)


def _genuine(kind: str, point: Point) -> bool:
    """Whether a zero of a test function is of its kind, and neither a jump nor that of another kind."""
    multiplier = shooting.critical(point.multipliers, kind)
    if kind == "neimark_sacker":
        return abs(multiplier.imag) > REAL and abs(abs(multiplier) - 1) < ZERO
    if kind == "fold":
        return abs(point.tangent[-1]) < ZERO
    return abs(multiplier - (-1 if kind == "period_doubling" else 1)) < ZERO


def _arc(one: Point, other: Point, place: float) -> tuple[np.ndarray, np.ndarray]:
    """Position and direction on the cubic through two points with their tangents."""
    chord = other.z - one.z
    length, x = np.linalg.norm(chord), place
    a, b = length * one.tangent - chord, chord - length * other.tangent
    guess = one.z + x * chord + x * (1 - x) * ((1 - x) * a + x * b)
    along = chord + (1 - 2 * x) * ((1 - x) * a + x * b) + x * (1 - x) * (b - a)
    return guess, along / np.linalg.norm(along)


def doubled(point: Point) -> Point:
    """The same orbit over twice its turns."""
    section = replace(point.orbit.map, turns=2 * point.orbit.map.turns)
    image = section.image(point.orbit.state)
    return replace(point, orbit=replace(point.orbit, map=section, image=image))


def departures(family: Family, special: Special, step: float) -> Iterator[tuple[Point, Point]]:
    """Origin on, and first point of, each branch that leaves a special point.

    From a period doubling one branch leaves, from a branch point two; `step` is the longest step.
    """
    origin = special.point
    P = origin.orbit.image.derivative
    if special.kind == "period_doubling":
        sides, away = (1,), np.append(shooting.direction(P, -1.0), 0.0)
        origin = doubled(origin)
    else:
        sides, away = (1, -1), np.append(shooting.direction(P, 1.0), 0.0)
        away -= (away @ origin.tangent) * origin.tangent
        away /= np.linalg.norm(away)
    for side in sides:
        for share in SHARES:
            point = solve(family, origin, origin.z + side * share * step * away, side * away)
            if point is not None and _near(origin, point, share * step):
                yield replace(origin, tangent=side * away), point
                break


def _near(origin: Point, point: Point, step: float) -> bool:
    """Whether the first point of a branch is within three steps of its origin, with the same events."""
    near = np.linalg.norm(point.z - origin.z) < 3 * step
    return bool(near and same_events(point.orbit.image.events, origin.orbit.image.events))
