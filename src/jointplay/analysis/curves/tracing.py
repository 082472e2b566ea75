"""Curves from the special points of a branch: where they start, both their halves, and which are the same.

Conditions that critical orbits fulfil, besides closing, on curves in two parameters.

fold                g = 0 of [[P - I, b], [c', 0]] (v, g) = (0, 1)      a multiplier +1
period doubling     g = 0 of [[P + I, b], [c', 0]] (v, g) = (0, 1)      a multiplier -1
symmetry breaking   the same, P of the half map (curves.grazing)
Neimark-Sacker      det B - 1, P V = V B on the plane V of a pair of multipliers

b and c are singular vectors of P -+ I at the point before, so that g is regular and of order 1. With (w, g)
from the transposed system, dg = -w' dP v, where dP along a coordinate or parameter k is column k of the
derivative of P, or of the map's derivative in k, along v: second derivatives commute, and one difference of
exact derivatives gives all coordinates and parameters.
References: Govaerts, Numerical Methods for Bifurcations of Dynamical Equilibria (2000), chapters 3 and 4;
Kuznetsov (2004), chapters 9 and 10. Validity: the orbit meets no event at grazing incidence.

Corners of curves of folds or doublings: tangent to a grazing, a curve turns there, or ends.

Beside a contact that begins multipliers change with the root of its depth d. On that side the curve keeps
a s = b sqrt(d), s along the grazing from where both meet: it nears the grazing with s^2, and its steps shrink
with s. The meeting is sought from the other side, where the map is smooth: along the grazing, as the point
with the critical multiplier. From there the curve goes on into that side.
Sticking that appears where the speed of sliding grazes zero lasts as long as that root, and takes a direction
away: multipliers jump, the other side has no critical one, and the curve ends. Along it the time of sticking
shrinks with s, which tells where.
Reference: di Bernardo et al., Piecewise-smooth Dynamical Systems (2008), chapters 7 and 8.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any

import numpy as np
from scipy.linalg import schur

from jointplay.analysis.curves.grazing import Coincidence, HalfMap, coincident, grazed, halved
from jointplay.analysis.orbits.arclength import first, solve
from jointplay.analysis.orbits.branch import Branch, Tracer, same_orbit_events
from jointplay.analysis.orbits.branch_points import Special, doubling, torus, unit
from jointplay.analysis.orbits.continuation import joined
from jointplay.analysis.orbits.family import Condition, Family, Point, Trial
from jointplay.analysis.orbits.section_map import (
    CONTACT,
    KIND,
    OF_GAPS,
    PLACE,
    SectionMap,
    changed_event,
    same_events,
)
from jointplay.analysis.orbits.shooting import Orbit, newton
from jointplay.solver.method.codes import Event

NEAR = 3e-3  # of a multiplier from a critical value, where two are so: double ones are uncertain by a root
DIFFERENCES = (3e-6, 1e-7, 1e-8)  # their lengths along a vector, in units of the states' scales
SHARES = {"resonance_1_1": 2.0, "resonance_1_2": -2.0, "resonance_1_3": -1.0, "resonance_1_4": 0.0}
REVERSED = 1e-3  # share of the parameters in a tangent at a cusp
REAL = 1e-6  # imaginary part below which a multiplier counts as real

AWAY = (1e-5, 1e-4, 1e-3, 1e-2)  # of the ranges, across the curve: where an orbit without the event is sought
AHEAD = 0.2  # of the ranges: how far ahead the meeting may be
POINTS = 6  # of the grazing's curve on the way there
SOON, BACK = 1e-2, 1e-4  # of the ranges: how far ahead sticking may end, and over what its rate is taken
MEETING = {"fold": "fold_grazing", "period_doubling": "doubling_grazing"}


@dataclass(frozen=True)
class Critical:
    """A multiplier at +1 or -1.

    Parameters
    ----------
    multiplier : float
        Which.
    half : bool
        Whether the map is that of half a turn and a reflection.
    """

    multiplier: float
    half: bool = False
    sided = False

    def value(self, trial: Trial, like: Point) -> float:
        """The bordered determinant."""
        return float(self._bordered(trial.image.derivative, like)[1][-1])

    def gradient(self, family: Family, trial: Trial, like: Point) -> np.ndarray:
        """Derivatives of the value in the coordinates x/c and the fractions of the ranges."""
        M, right = self._bordered(trial.image.derivative, like)
        left = np.linalg.solve(M.T, np.eye(len(M))[-1])
        return _scaled(-left[:-1] @ along(family, trial, right[:-1]), like)

    def _bordered(self, P: np.ndarray, like: Point) -> tuple[np.ndarray, np.ndarray]:
        """The bordered matrix, and (v, g)."""
        n, identity = len(P), np.eye(len(P))
        U, _, V = np.linalg.svd(like.orbit.image.derivative - self.multiplier * identity)
        M = np.zeros((n + 1, n + 1))
        M[:n, :n], M[:n, n], M[n, :n] = P - self.multiplier * identity, U[:, -1], V[-1]
        return M, np.linalg.solve(M, np.eye(n + 1)[-1])

    def tests(self, one: Point) -> Mapping[str, Callable[[Point], float]]:
        """Zeros at meetings with other curves, by their names."""
        pairs = torus if len(one.tangent) > 3 else lambda point: 1.0
        if self.multiplier < 0:
            other = "fold_symmetry_breaking" if self.half else "fold_doubling"
            return {other: unit, "resonance_1_2": pairs, "doubling_torus": pairs}
        before = one.tangent[-2:]
        return {
            "cusp": lambda point: float(point.tangent[-2:] @ before),
            "fold_doubling": doubling,
            "resonance_1_1": pairs,
            "fold_torus": pairs,
        }

    def genuine(self, kind: str, point: Point) -> bool:
        """Whether the zero of a test is a genuine point of its kind."""
        values = np.asarray(point.multipliers)
        if kind == "cusp":
            return bool(np.linalg.norm(point.tangent[-2:]) < REVERSED)
        if kind.endswith("torus"):
            pairs = values[values.imag > NEAR]
            return bool(np.any(np.abs(np.abs(pairs) - 1) < NEAR))
        if kind.startswith("resonance"):
            return int(np.sum(np.abs(values - self.multiplier) < NEAR)) > 1
        return bool(np.any(np.abs(values + self.multiplier) < NEAR))


@dataclass(frozen=True)
class Torus:
    """A pair of multipliers on the unit circle; beyond a strong resonance, a real pair with the product 1."""

    sided = False

    def value(self, trial: Trial, like: Point) -> float:
        """The product of a pair of multipliers, less 1."""
        return float(np.linalg.det(_plane(trial.image.derivative)[1]) - 1)

    def gradient(self, family: Family, trial: Trial, like: Point) -> np.ndarray:
        """Derivatives of the value in the coordinates x/c and the fractions of the ranges."""
        P = trial.image.derivative
        V, B = _plane(P)
        W = _plane(P.T)[0]
        dual = np.linalg.solve(W.T @ V, W.T)  # rows
        rows = np.stack(
            [dual @ along(family, trial, v) for v in V.T], 1
        )  # of dB: (row, column of B, unknown)
        adjugate = np.linalg.det(B) * np.linalg.inv(B)
        return _scaled(np.einsum("ij,jik->k", adjugate, rows), like)

    def trace(self, point: Point) -> float:
        """The sum of the pair: twice the cosine of its angle, and beyond that of a real one."""
        return float(np.trace(_plane(point.orbit.image.derivative)[1]))

    def tests(self, one: Point) -> Mapping[str, Callable[[Point], float]]:
        """Zeros at strong resonances and at meetings with other curves, by their names."""

        def share(double: float) -> Callable[[Point], float]:
            return lambda point: self.trace(point) - double

        others = {"fold_torus": unit, "doubling_torus": doubling} if len(one.tangent) > 4 else {}
        return {name: share(double) for name, double in SHARES.items()} | others

    def genuine(self, kind: str, point: Point) -> bool:
        """Whether the zero of a test is a genuine point of its kind."""
        if kind in SHARES:
            return True
        wanted = 1.0 if kind == "fold_torus" else -1.0
        values = np.asarray(point.multipliers)
        return bool(np.any((np.abs(values - wanted) < NEAR) & (np.abs(values.imag) < REAL)))


def _plane(P: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Basis of the plane of that pair of multipliers whose product is nearest to 1, and the map on it."""
    values = np.linalg.eigvals(P).astype(complex)
    pairs = [pair for pair in combinations(values, 2) if abs((pair[0] * pair[1]).imag) < 1e-9]
    chosen = min(pairs, key=lambda pair: abs(pair[0] * pair[1] - 1))
    apart = [abs(value - each) for value in values for each in chosen]
    near = 1e-6 * (1 + max(apart))

    def wanted(real: float, imaginary: float) -> bool:
        return min(abs(complex(real, imaginary) - each) for each in chosen) < near

    T, Z, _ = schur(P, sort=wanted)
    return Z[:, :2], T[:2, :2]


def along(family: Family, trial: Trial, vector: np.ndarray) -> np.ndarray:
    """Derivative of the map's derivatives along a vector of coordinates, in units of their scales.

    A central difference of motions with the same events, smaller where others are near; one-sided where no
    central one is found, NaN where none is. Columns: coordinates, then fractions of the ranges.
    """
    section, own = trial.section, family.slopes(trial.image)
    place, length = section.unknowns(trial.state), float(np.linalg.norm(vector))
    for size in DIFFERENCES:
        found = [(0.0, own)]
        for side in (-size / length, size / length):
            other = section.image(section.state(place + side * vector), directions=trial.directions)
            if not other.status and same_events(other.events, trial.image.events):
                found.append((side, family.slopes(other)))
        if len(found) == 3 or (len(found) == 2 and size == DIFFERENCES[-1]):
            found.sort(key=lambda each: each[0])
            return (found[-1][1] - found[0][1]) / (found[-1][0] - found[0][0])
    return np.full_like(own, np.nan)


def _scaled(row: np.ndarray, like: Point) -> np.ndarray:
    """Derivatives in coordinates and parameters, the first in units of the constant c."""
    row[:-2] *= like.unit
    return row


BIFURCATIONS = ("fold", "period_doubling", "neimark_sacker", "symmetry_breaking")


KINDS = (*BIFURCATIONS, "grazing")


FOLLOWED = (*KINDS, "coincidence")  # which begins as a grazing does


FROM = {"branch_point": "symmetry_breaking"}  # by the special point that it starts from, where not its own


CONDITIONS: dict[str, Condition] = {
    "fold": Critical(1.0),
    "period_doubling": Critical(-1.0),
    "neimark_sacker": Torus(),
    "symmetry_breaking": Critical(-1.0, half=True),
}


SAME = 1e-3  # of the ranges: so near another curve of its kind a start lies on it


ROUNDED = 1e-6  # of the sum of a double pair of multipliers


ALIKE = 1e-2  # difference of largest multipliers up to which two orbits there are the same


@dataclass(frozen=True)
class Curve:
    """A curve: its kind, its points as a branch has them, and the family that they are of."""

    kind: str
    branch: Branch
    family: Family

    @property
    def event(self) -> tuple[int, int]:
        """Contact and kind of the event that begins at a grazing; (-1, -1) of other curves."""
        return getattr(self.family.condition, "event", (-1, -1))


@dataclass
class Curves:
    """The curves that start from special points.

    Parameters
    ----------
    family : Family
        Of maps over two parameters, without a condition.
    step : float
        Longest step.
    max_points : int
        Points of a curve, at most.
    visit : callable
        Called with each point.
    onward : collection of int
        Kinds of the events whose grazings are followed too where other curves meet them.
    """

    family: Family
    step: float
    max_points: int
    visit: Callable[[Point], None]
    onward: Collection[int] = ()

    def traced(self, starts: Sequence[Begin]) -> Iterator[Curve]:
        """The curve of each start that is not passed already; then the curves of grazings on them."""
        found: list[Curve] = []
        waiting = list(starts)
        for start in waiting:  # which grows
            family, begin, trouble = self._begun(start)
            kind = "coincidence" if isinstance(family.condition, Coincidence) else start.kind
            branch = Branch([begin], [], (trouble, trouble))
            if any(_passes(each, Curve(kind, branch, family)) for each in found):
                continue
            found.append(
                Curve(kind, branch if trouble else _cut(kind, self._both_ways(family, begin, start)), family)
            )
            yield found[-1]
            if "interrupted" in found[-1].branch.ends:
                return
            if self.onward and start.kind != "grazing":
                met = starts_of([found[-1].branch], ["grazing"], lambda q: q)
                waiting += [each for each in met if each.event[1] in self.onward]

    def _begun(self, begin: Begin) -> tuple[Family, Point, str]:
        """The family of a kind of curve, its first point, and why there is no other, if there is none."""
        kind, orbit, q = begin.kind, begin.orbit, begin.q
        family, start = replace(self.family, condition=CONDITIONS.get(kind)), orbit
        point = Point(orbit, q, 1.0, np.zeros(len(orbit.map.free) + 2))
        half = halved(orbit, family.tolerance) if kind in ("symmetry_breaking", "grazing") else None
        if half is not None:  # of a symmetric orbit two guards graze at once
            start, family = half, replace(family, maps=_reflected(family.maps, half.map))
        elif kind == "symmetry_breaking":
            return family, point, "not_symmetric"
        if kind == "grazing":
            nearly = [each(start, begin.event) for each in (grazed, coincident)]
            if not any(nearly):
                return family, point, "not_converged"
            condition = min(filter(None, nearly), key=lambda each: each[0])[1]
            family = replace(family, condition=condition)
        guess = first(family, start, q, np.array([0.0, 1.0]))
        found = solve(family, guess, guess.z, guess.tangent)
        return (family, point, "not_converged") if found is None else (family, found, "")

    def _both_ways(self, family: Family, begin: Point, start: Begin) -> Branch:
        def ahead(last: Point) -> tuple[Special, Point | None] | None:
            return corner(family, start, last, self._begun, self._follow)

        more = {"corner": ahead} if start.kind in MEETING else {}
        back = self._follow(family, replace(begin, tangent=-begin.tangent), self.max_points // 2, **more)
        if back.ends[1] in ("interrupted", "closed"):
            return back.reversed()
        forth = self._follow(family, begin, self.max_points - len(back.points) + 1, **more)
        left = self.max_points + 1 - len(back.points) - len(forth.points)
        if left and back.ends[1] == "max_points":  # what this half has not used
            rest = self._follow(family, back.points[-1], left + 1, **more)
            points, specials = back.points + rest.points[1:], back.specials + rest.specials
            back = Branch(points, specials, (back.ends[0], rest.ends[1]))
        return joined(back, forth)

    def _follow(self, family: Family, start: Point, most: int, **more: Any) -> Branch:
        doubled = start.orbit.map.turns % 2 == 0
        return Tracer(family, self.step, max(most, 2), self.visit, doubled, **more).follow(start)


def starts_of(
    branches: Sequence[Branch], kinds: Sequence[str], where: Callable[[Any], np.ndarray]
) -> list[Begin]:
    """The special points of branches where curves of some kinds start, grazings last."""
    found = []
    for branch in branches:
        for special in branch.specials:
            kind = FROM.get(special.kind, special.kind)
            point = _before(branch, special) if kind == "grazing" else special.point
            q = special.q if kind != "grazing" else point.q
            if kind in kinds:
                found.append(Begin(kind, whole(point.orbit), where(q), special.event))
    return sorted(found, key=lambda each: each.kind == "grazing")


def _before(branch: Branch, special: Special) -> Point:
    """Point next to a grazing that has fewer events."""
    at = next(i for i, point in enumerate(branch.points) if point is special.point)
    neighbours = [branch.points[i] for i in (at - 1, at + 1) if 0 <= i < len(branch.points)]
    others = [point for point in neighbours if not same_orbit_events(point, special.point)]
    return min([special.point, *others], key=lambda point: len(point.orbit.image.events))


def _reflected(maps: Callable, half: SectionMap) -> Callable:
    """The half maps that belong to section maps."""

    def of(value: tuple[float, float]) -> HalfMap:
        whole = maps(value)
        return replace(half, model=whole.model, max_steps=whole.max_steps)

    return of


def _passes(curve: Curve, other: Curve) -> bool:
    """Whether a curve passes through the first point of another of its kind."""
    if (curve.kind, curve.event) != (other.kind, other.event):
        return False
    point = other.branch.points[0]
    q = np.array([each.q for each in curve.branch.points])
    chords, away = np.diff(q, axis=0), point.q - q[:-1]
    lengths = np.maximum(np.sum(chords**2, axis=1), 1e-300)
    shares = np.clip(np.sum(chords * away, axis=1) / lengths, 0.0, 1.0)
    distances = np.linalg.norm(away - shares[:, None] * chords, axis=1)
    if not len(distances) or distances.min() > SAME:
        return False
    near = curve.branch.points[int(np.argmin(distances))].multipliers
    return bool(abs(np.prod(near) - np.prod(point.multipliers)) < ALIKE * (1 + abs(np.prod(near))))


def _cut(kind: str, branch: Branch) -> Branch:
    """A torus's curve between the strong resonances beyond which its multipliers are real."""
    if kind != "neimark_sacker":
        return branch
    paired = [abs(CONDITIONS[kind].trace(point)) <= 2 + ROUNDED for point in branch.points]
    here = paired.index(True)
    low = max((i + 1 for i in range(here) if not paired[i]), default=here)
    high = next((i for i in range(here, len(paired)) if not paired[i]), len(paired))
    kept = branch.points[low:high]
    ends = "resonance" if low else branch.ends[0], "resonance" if high < len(paired) else branch.ends[1]
    specials = [special for special in branch.specials if any(special.point is point for point in kept)]
    return Branch(kept, specials, ends)


def whole(orbit: Orbit) -> Orbit:
    """The orbit as a fixed point of a section map, also where it is one of a half map."""
    return orbit.map.whole(orbit) if isinstance(orbit.map, HalfMap) else orbit


@dataclass(frozen=True)
class Begin:
    """Beginning of a curve: its kind, an orbit, the fractions of both ranges, and the event at a grazing."""

    kind: str
    orbit: Orbit
    q: np.ndarray
    event: tuple[int, int] = (-1, -1)


def corner(
    family: Family,
    begin: Begin,
    last: Point,
    begun: Callable[[Begin], tuple[Family, Point, str]],
    follow: Callable[[Family, Point, int], Branch],
) -> tuple[Special, Point | None] | None:
    """The meeting with a grazing ahead of a point, as a special point of its curve, and where that goes on.

    None in place of the latter where the curve ends there.

    Parameters
    ----------
    family : Family
        Of the curve.
    begin : Begin
        Its start.
    last : Point
        Where its steps have become short.
    begun : callable
        The family and the first point of a curve, and what is wrong, by its start.
    follow : callable
        A curve's branch from a point on, of some points.
    """
    if (end := _unstuck(family, last)) is not None:
        return end, None
    for orbit, q, event in _across(family, last):
        grazing, first, trouble = begun(replace(begin, kind="grazing", orbit=orbit, q=q, event=event))
        if trouble:
            continue
        if first.tangent[-2:] @ last.tangent[-2:] < 0:
            first = replace(first, tangent=-first.tangent)
        for met in follow(grazing, first, POINTS).specials:
            if met.kind != MEETING[begin.kind] or np.linalg.norm(met.q - last.q) > AHEAD:
                continue
            _, onward, trouble = begun(replace(begin, orbit=met.point.orbit, q=met.q))
            if trouble:
                continue
            scales = np.append(np.full(len(last.tangent) - 2, onward.unit / met.point.unit), np.ones(2))
            if met.point.jacobian[-1] @ (scales * onward.tangent) < 0:  # the margin grows from there on
                onward = replace(onward, tangent=-onward.tangent)
            return replace(met, kind="grazing", event=event), onward
    return None


def _across(family: Family, last: Point) -> Iterator[tuple[Orbit, np.ndarray, tuple[int, int]]]:
    """Orbits near a curve that lack an event of a gap, the nearest first; their places, and the event."""
    along = last.tangent[-2:] / np.linalg.norm(last.tangent[-2:])
    events = last.orbit.image.events
    for away in AWAY:
        for side in (-away, away):
            q = last.q + side * along[::-1] * (1, -1)
            orbit = newton(family.at(q, last.orbit.map), last.orbit.state, family.tolerance)
            if orbit.status or len(orbit.image.events) >= len(events):
                continue
            event = changed_event(orbit.image.events, events)
            if event[1] in OF_GAPS:
                yield orbit, q, event
                return


def _unstuck(family: Family, last: Point) -> Special | None:
    """The point, soon after one of a curve, at which a piece of sticking has shrunk to nothing."""
    before = solve(family, last, last.z - BACK * last.tangent, last.tangent)
    if before is None or not same_orbit_events(before, last):
        return None
    (contacts, now), (_, then) = (_sticking(each.orbit.image.events) for each in (last, before))
    with np.errstate(divide="ignore", invalid="ignore"):
        ahead = now / (then - now)
    soon = np.flatnonzero((ahead > 0) & (BACK * ahead < SOON))
    if not len(soon):
        return None
    first = soon[np.argmin(ahead[soon])]
    along, event = ahead[first] * (last.q - before.q), (contacts[first], Event.STICK_ONSET)
    return Special("grazing", last, last.q + along, float(np.linalg.norm(along)), event)


def _sticking(events: np.ndarray) -> tuple[list[int], np.ndarray]:
    """Contact and share of the orbit of each piece of sticking that ends in slip."""
    found = []
    for contact in {int(row[CONTACT]) for row in events}:
        own = events[events[:, CONTACT] == contact]
        for one, other in zip(own, np.roll(own, -1, axis=0), strict=True):
            if (one[KIND], other[KIND]) == (Event.STICK_ONSET, Event.SLIP_ONSET):
                found.append((contact, (other[PLACE] - one[PLACE]) % 1.0))
    return [contact for contact, _ in found], np.array([share for _, share in found])
