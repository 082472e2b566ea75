"""Curves from the special points of a branch: where they start, both their halves, and which are the same."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from jointplay.analysis.curves.coincidence import Coincidence, coincident
from jointplay.analysis.curves.conditions import Critical, Torus
from jointplay.analysis.curves.corners import MEETING, Begin, corner
from jointplay.analysis.curves.grazing import grazed
from jointplay.analysis.curves.half_map import HalfMap, halved
from jointplay.analysis.orbits.arclength import first, solve
from jointplay.analysis.orbits.branch import Branch, Tracer
from jointplay.analysis.orbits.branch_points import Special
from jointplay.analysis.orbits.continuation import joined
from jointplay.analysis.orbits.family import Condition, Family, Point
from jointplay.analysis.orbits.neighbours import same_orbit_events
from jointplay.analysis.orbits.section_map import SectionMap
from jointplay.analysis.orbits.shooting import Orbit

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
    beside = [branch.points[i] for i in (at - 1, at + 1) if 0 <= i < len(branch.points)]
    others = [point for point in beside if not same_orbit_events(point, special.point)]
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
