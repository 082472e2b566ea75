"""Curves from the special points of a branch: where they start, both their halves, and which are the same.

On a curve of coincidence two events are at one time: slip reverses where contact begins or ends, and is gone
in flight. With s the speed of sliding and h the guard of the contact's beginning or end, at time t: g = s(t),
over its own size. With M the tangents up to t, dg = (grad s - s'/h' grad h) M dx + (ds - s'/h' dh)/dp dp.
Points lie SHORT of the curve, on that side on which slip does not reverse: there the orbit's events are the
same ones. Assumptions: the state does not jump at the event (a contact with a force). Validity: contact
begins or ends with a speed, h' is not 0. Reference: di Bernardo et al., Piecewise-smooth Dynamical Systems
(2008), chapter 8.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from jointplay.analysis.curves.conditions import Critical, Torus
from jointplay.analysis.curves.corners import MEETING, Begin, corner
from jointplay.analysis.curves.grazing import EARLIER, SHORT, Meeting, grazed, slopes, spacing
from jointplay.analysis.curves.half_map import HalfMap, halved
from jointplay.analysis.curves.margins import OF_SLIDING, PLACES, SLIDE, Guards
from jointplay.analysis.orbits.arclength import first, solve
from jointplay.analysis.orbits.branch import Branch, Tracer
from jointplay.analysis.orbits.branch_points import Special
from jointplay.analysis.orbits.continuation import joined
from jointplay.analysis.orbits.family import Condition, Family, Point, Trial
from jointplay.analysis.orbits.neighbours import same_orbit_events
from jointplay.analysis.orbits.orbit_events import CONTACT, KIND, OF_GAPS, PLACE, TIME
from jointplay.analysis.orbits.section_map import SectionMap
from jointplay.analysis.orbits.shooting import Orbit
from jointplay.solver.mechanism.model import Model
from jointplay.solver.method.codes import Mode

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
SIDES = {Mode.SLIP_POSITIVE: 1.0, Mode.SLIP_NEGATIVE: -1.0}


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


@dataclass(frozen=True)
class Coincidence(Meeting):
    """A slip reversal at the beginning or the end of its contact.

    Parameters
    ----------
    contact : int
        Whose.
    kind : int
        Of the event that goes on beyond the curve.
    size : float
        Largest speed of sliding, by which it is divided; with the sign that it has in contact.
    event : tuple of int
        Contact and kind of the event that vanishes.
    """

    contact: int
    kind: int
    size: float
    event: tuple[int, int]
    sided = False

    def value(self, trial: Trial, like: Point) -> float:
        """The sliding speed at the event over its size, less `SHORT`; NaN where the event is missing."""
        row = self._row(trial.section.model, trial.image.events, like)
        if row is None:
            return np.nan
        return float(sliding(trial.section.model, row[None], self.contact)[0, 0]) / self.size - SHORT

    def gradient(self, family: Family, trial: Trial, like: Point) -> np.ndarray:
        """Its derivatives in the coordinates x/c and the fractions of the ranges."""
        row = self._row(trial.section.model, trial.image.events, like)
        found = None
        if row is not None:
            found = slopes(family, trial, like, row[0], partial(sliding, contact=self.contact))
        if found is None:
            return np.full(len(trial.section.free) + family.count, np.nan)
        values, rows, rates = found
        with np.errstate(divide="ignore", invalid="ignore"):
            fires = 1 + int(np.nanargmin(np.abs(values[1:] / rates[1:])))
            return (rows[0] - rates[0] / rates[fires] * rows[fires]) / self.size

    def _row(self, model: Model, events: np.ndarray, like: Point) -> np.ndarray | None:
        """Time, state and modes of the event that is the same as that of a point of the curve."""
        own, others = (
            rows[(rows[:, CONTACT] == self.contact) & (rows[:, KIND] == self.kind)]
            for rows in (like.orbit.image.events, events)
        )
        if not len(own) or len(own) != len(others):
            return None
        slips = sliding(model, own[:, TIME:], self.contact)[:, 0]
        apart = np.abs(others[:, PLACE] - own[np.argmin(np.abs(slips)), PLACE])
        return others[np.argmin(np.minimum(apart, 1 - apart)), TIME:]


def sliding(model: Model, rows: np.ndarray, contact: int) -> np.ndarray:
    """Speed of sliding, gap and force of a contact as if it touched, at rows of time, state, modes."""
    touching = rows.copy()
    touching[:, 1 + len(model.state) + contact] = Mode.SLIP_POSITIVE
    first = PLACES * contact
    return Guards(model).values(touching)[:, [first + SLIDE, first, first + 1]]


def coincident(orbit: Orbit, event: tuple[int, int]) -> tuple[float, Coincidence] | None:
    """The beginning or end of a contact with the slowest sliding, and that speed over its largest.

    None if slip has no part in the event that vanishes, or is not followed there.
    """
    (contact, kind), section, model = event, orbit.map, orbit.map.model
    events, guards = orbit.image.events, Guards(model)
    own = events[(events[:, CONTACT] == contact) & np.isin(events[:, KIND], OF_GAPS)]
    if kind not in OF_SLIDING or contact >= guards.contacts or not len(own):
        return None
    speeds = np.abs(sliding(model, own[:, TIME:], contact)[:, 0])
    row = own[int(np.argmin(speeds))]
    beside = EARLIER * spacing(section, orbit.image) * np.array([-1.0, 1.0])
    rows, status = section.sampled(orbit.state, row[TIME] + beside, False)
    modes = rows[:, 1 + len(model.state) + contact].astype(int)
    sides = [SIDES[mode] for mode in modes if mode in SIDES]
    near = guards.nearest(section, orbit.state, orbit.image.time, events)
    if status or near is None or not sides:
        return None
    size = float(near[2][PLACES * contact + SLIDE])
    return float(speeds.min() / size), Coincidence(contact, int(row[KIND]), sides[0] * size, event)
