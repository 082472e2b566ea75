"""Tracing a branch of periodic orbits: predict, correct, detect changes, choose the next step.

Within a piece of a branch orbits have the same events. Where these change (an event appears or vanishes:
grazing) the point is enclosed by bisection, and the branch goes on beyond it if it can; else it ends there.
Test functions are compared within a piece only.

Neighbours of a point of a branch: orbits with other events, the same orbit on another section.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from jointplay.analysis.orbits.arclength import solve
from jointplay.analysis.orbits.branch_points import Special, between
from jointplay.analysis.orbits.family import Family, Point
from jointplay.analysis.orbits.section_map import Image, changed_event, same_events
from jointplay.analysis.orbits.shooting import shift_from_events
from jointplay.solver.motion.progress import Aborted, Stopped

WHY = {  # a branch, or a curve, ends
    "range": "end of the range",
    "max_points": "the limit on the number of points",
    "grazing": "an event appears or vanishes there, and no orbit was found next to it beyond",
    "not_converged": "no orbit was found beyond, however short the step",
    "closed": "the branch is closed",
    "joined": "its orbit has become one of half the period",
    "origin": "where it begins",
    "interrupted": "interrupted",
    "resonance": "its pair of multipliers becomes real there",
    "not_symmetric": "the orbit has no symmetry to be lost",
}
ENDS = tuple(WHY)
FIRST = 0.25  # of the longest step
SHORTEST = 1e-9
LONGER, SHORTER = 1.4, 0.6  # factors of the step after easy and hard corrections
EASY, HARD = 4, 7  # corrections, down to rounding
CLOSE, FAR = 0.01, 0.1  # of a step: the prediction's error, where corrections keep to a side in stages
DEVIATION = 0.5  # of a step: farther from its prediction a point may be on another branch
TURN = 0.8  # least cosine of the turn in a step, unless that is SMALL
ENCLOSED = 1e-9  # bracket of a grazing
NEARLY = 1e-6  # of the arc: a wider bracket of a grazing is narrowed from its other side
GAP = 1e-3, 2e-2  # on the arc: beyond a wider gap at a grazing a branch, or a curve, is another one
STALLED = 1e-2  # of the longest step: where a shorter one fails, an orbit beyond a grazing is looked for
NARROWED = 0.3  # in a step, both halves of an orbit of a curve may come so much nearer to each other
KNOWN = 1e3  # of its residual by which they differ at least: where by less, little is known of the curve
SOONER = 0.1  # factor of the length of steps at which a corner is sought once more
LEAPS = (8.0, 64.0, 512.0)  # at so many times its length

PROBES = (1e-8, 1e-6, 1e-4)  # distances beyond a failure at which events are compared
SMALL = 1e-4  # steps so small that any turn is accepted


@dataclass
class Branch:
    """Points in order, the special ones among them, and the reasons of both ends."""

    points: list[Point] = field(default_factory=list)
    specials: list[Special] = field(default_factory=list)
    ends: tuple[str, str] = ("origin", "not_converged")
    parent: int = -1

    def reversed(self) -> Branch:
        """The same branch from its other end, with tangents that point from there."""
        turned = {id(each): replace(each, tangent=-each.tangent) for each in self.points[::-1]}
        specials = [replace(each, point=turned[id(each.point)]) for each in self.specials[::-1]]
        return replace(self, points=[*turned.values()], specials=specials, ends=self.ends[::-1])


class Tracer:
    """Traces a branch from a point, in the sense of its tangent.

    Parameters
    ----------
    family : Family
        Of maps.
    step : float
        Longest step.
    max_points : int
        Points at which it ends.
    visit : callable
        Called with each point.
    doubled : bool
        Whether the orbit may be one of twice a period: where both its halves become one, the branch joins
        those of the period. A curve is followed close to there.
    corner : callable, optional
        Of a curve: the grazing ahead of a point beside which steps become short, and where the curve goes on,
        if it does.
    """

    def __init__(
        self,
        family: Family,
        step: float,
        max_points: int,
        visit: Callable,
        doubled: bool = False,
        corner: Callable[[Point], tuple[Special, Point | None] | None] = lambda last: None,
    ):
        self.family, self.step, self.max_points = family, step, max_points
        self.visit, self.doubled, self.corner = visit, doubled, corner
        self.sought = STALLED * step  # length of steps from which on a corner is sought
        self.bend: np.ndarray | float = 0.0  # half the derivative of the tangent of a curve, along it
        self.points: list[Point] = []
        self.specials: list[Special] = []

    def follow(self, start: Point) -> Branch:
        """Follow the branch to its end; the start is its first point."""
        length, end = FIRST * self.step, None
        try:
            self._take(start)
            last = self._away_from_events(start)
            while end is None:
                last, length, end = self._advance(last, length)
        except (Stopped, Aborted):
            end = "interrupted"
        return Branch(self.points, self.specials, ("origin", end))

    def _take(self, point: Point) -> None:
        self.points.append(point)
        self.visit(point)

    def _away_from_events(self, point: Point) -> Point:
        """The point on a section away from events."""
        ahead = shift_from_events(point.orbit.map, point.orbit.image.events)
        if not ahead:
            return point
        self.bend = 0.0  # in coordinates of another section
        return shifted(self.family, point, ahead)

    def _advance(self, last: Point, length: float) -> tuple[Point, float, str | None]:
        """One attempt: the point to go on from, the next step's length, and the end if it is one."""
        if len(self.points) >= self.max_points:
            return last, length, "max_points"
        new = self._try(last, length, DEVIATION * length)
        if new is None and length <= STALLED * self.step and (beyond := self._leap(last, length)) is not None:
            return self._go_on(last, *beyond)
        if new is None and length <= self.sought:
            self.sought = SOONER * length
            if (met := self.corner(last)) is not None:
                return self._turn(*met)
        if new is None:
            return (last, length / 2, None) if length > 2 * SHORTEST else (last, length, self._failure(last))
        if len(outside(new.q)):
            new, end = self._edge(last, new), "range"
            if new is None:
                return last, length / 2, None if length > 2 * SHORTEST else "range"
        else:
            end = self._finished(last, new, length)
        if end == "joined":
            near = self.family.condition is None or length <= STALLED * self.step
            return (last, length, end) if near else (last, length / 2, None)
        if not same_orbit_events(last, new):
            return self._graze(last, new, length)
        self._between(last, new)
        self._take(new)
        factor = self._factor(last, new, length)
        if self.family.condition is not None:
            self.bend = (new.tangent - last.tangent) / (2 * length)
        return self._away_from_events(new), min(self.step, factor * length), end

    def _predicted(self, last: Point, length: float) -> np.ndarray:
        return last.z + length * last.tangent + length**2 * self.bend

    def _factor(self, last: Point, new: Point, length: float) -> float:
        """Factor by which the step after this one may be longer, or has to be shorter.

        Beside a grazing corrections leave a share of the condition each, to keep its side: their number says
        nothing of the step.
        """
        if getattr(self.family.condition, "sided", False):
            off = np.linalg.norm(new.z - self._predicted(last, length))
            return LONGER if off < CLOSE * length else SHORTER if off > FAR * length else 1.0
        return LONGER if new.iterations <= EASY else SHORTER if new.iterations >= HARD else 1.0

    def _try(self, last: Point, length: float, deviation: float, kinks: bool = False) -> Point | None:
        """The point a step on; None if it is not found within a `deviation` of its prediction."""
        guess = self._predicted(last, length)
        new = solve(self.family, last, guess, last.tangent)
        if new is None or np.linalg.norm(new.z - guess) > deviation:
            return None
        return new if kinks or length < SMALL or new.tangent @ last.tangent > TURN else None

    def _edge(self, last: Point, new: Point) -> Point | None:
        """The point at the end of the range that the step has passed."""
        passed = outside(new.q) + len(last.z) - self.family.count
        edges = np.clip(new.z[passed], 0.0, 1.0)
        shares = (edges - last.z[passed]) / (new.z - last.z)[passed]
        first = int(np.argmin(shares))
        if shares[first] <= 0.0:
            return last
        guess, normal, at = last.z + shares[first] * (new.z - last.z), np.zeros_like(last.z), passed[first]
        guess[at], normal[at] = edges[first], math.copysign(1.0, new.z[at] - last.z[at])
        return solve(self.family, last, guess, normal)

    def _finished(self, last: Point, new: Point, length: float) -> str | None:
        """Why the branch ends with a step: it is closed or has joined its parent; None if it goes on."""
        start = self.points[0]
        comparable = start.orbit.map.phase == new.orbit.map.phase and len(self.points) > 8
        if comparable and np.linalg.norm(new.z - start.z) < length and new.tangent @ start.tangent > TURN:
            return "closed"
        if not self.doubled:
            return None
        one, other, least = half_shift(last), half_shift(new), 0.0
        if self.family.condition is not None:
            least = max(NARROWED * one @ one, KNOWN * new.orbit.residual * np.linalg.norm(one))
        return "joined" if one @ other < least else None

    def _between(self, last: Point, new: Point) -> None:
        for special in between(self.family, last, new):
            self._take(special.point)
            self.specials.append(special)

    def _graze(self, last: Point, new: Point, length: float) -> tuple[Point, float, str | None]:
        """Enclose a change of events within a step, and go on beyond it."""
        fewer = len(new.orbit.image.events) < len(last.orbit.image.events)
        if fewer and (met := self.corner(last)) is not None:
            return self._turn(*met)
        low, high, before, beyond = 0.0, length, last, new
        while high - low > ENCLOSED:
            middle = (low + high) / 2
            point = self._try(last, middle, DEVIATION * length, kinks=True)
            if point is not None and same_orbit_events(last, point):
                low, before = middle, point
                continue
            high, beyond = middle, beyond if point is None else point
        width, narrowed = distance(before, beyond), False
        if width > NEARLY:  # Newton's method failed at the kink: enclose from the other side
            (beyond, width, _), narrowed = self._back(beyond, before), True
        self._between(last, before)
        if distance(before, beyond) > GAP[self.family.condition is not None]:
            gap = float(np.max(np.abs(beyond.q - before.q)))
            self._note_grazing(before, beyond.orbit.image, before.q, gap)
            return before, length, "grazing"
        return self._go_on(before, beyond, width, narrowed)

    def _leap(self, last: Point, length: float) -> tuple[Point, float] | None:
        """The nearest point beyond a grazing that short steps do not reach, and the width that encloses it.

        Beside it multipliers may change with the root of the distance on one side, and smoothly on the other.
        """
        for h in (factor * length for factor in LEAPS if factor * length <= self.step):
            point = self._try(last, h, DEVIATION * h, kinks=True)
            if point is None or same_orbit_events(last, point) or len(outside(point.q)):
                continue
            nearest, width, after = self._back(point, last)
            if after is not None and same_events(after.events, last.orbit.image.events):
                return nearest, width
        return None

    def _go_on(
        self, before: Point, beyond: Point, width: float, narrowed: bool = True
    ) -> tuple[Point, float, str | None]:
        """Note a grazing and go on beyond it; `narrowed`: it is known from that side."""
        self._note_grazing(before, beyond.orbit.image, beyond.q if narrowed else before.q, width)
        self._take(beyond)
        self.bend = 0.0
        return self._away_from_events(beyond), max(FIRST * self.step / 4, SMALL * self.step), None

    def _turn(self, met: Special, onward: Point | None) -> tuple[Point, float, str | None]:
        """Note a corner at a grazing, and go on from it, or end there."""
        self.specials.append(met)
        if onward is None:
            return met.point, 0.0, "grazing"
        self._take(met.point)
        self._take(onward)
        self.bend = 0.0
        return self._away_from_events(onward), FIRST * self.step / 4, None

    def _back(self, beyond: Point, before: Point) -> tuple[Point, float, Image | None]:
        """The point with the events of `beyond` that is nearest to `before`.

        Also how closely it is enclosed, and the image with other events on that side, if there is one near.
        """
        low, high, chord, nearest = 0.0, 1.0, before.z - beyond.z, beyond
        size = np.linalg.norm(chord)
        while (high - low) * size > ENCLOSED:
            middle = (low + high) / 2
            point = solve(self.family, beyond, beyond.z + middle * chord, -chord / size)
            if point is not None and same_orbit_events(beyond, point):
                low, nearest = middle, point
            else:
                high = middle
        after = image_beyond(self.family, replace(nearest, tangent=chord / size))
        return (nearest, after[1], after[0]) if after else (nearest, distance(nearest, before), None)

    def _note_grazing(self, point: Point, after: Image, q: Any, width: float) -> None:
        """Note a grazing after a point, with the event that appears or vanishes there."""
        event = changed_event(point.orbit.image.events, after.events)
        if point is not self.points[-1]:
            self._take(point)
        self.specials.append(Special("grazing", point, q, width, event))

    def _failure(self, last: Point) -> str:
        """Why a branch ends where no step is short enough."""
        after = image_beyond(self.family, last)
        if after is None:
            return "not_converged"
        self._note_grazing(last, after[0], last.q, after[1])
        return "grazing"


def outside(q: Any) -> np.ndarray:
    """Indices of the parameters that are beyond their ranges."""
    q = np.atleast_1d(q)
    return np.flatnonzero((q < 0.0) | (q > 1.0))


def distance(one: Point, other: Point) -> float:
    """Distance of two points on the same section."""
    return float(np.linalg.norm(one.z - other.z))


def same_orbit_events(one: Point, other: Point) -> bool:
    """Whether the orbits of two points have the same events."""
    return same_events(one.orbit.image.events, other.orbit.image.events)


def image_beyond(family: Family, point: Point) -> tuple[Image, float] | None:
    """The first image with other events of motions a little beyond a point, along its tangent; distance."""
    for distance in PROBES:
        map_there, state = family.placed(point.z + distance * point.tangent, point)
        image = map_there.image(state, False)
        if not image.status and not same_events(image.events, point.orbit.image.events):
            return image, distance
    return None


def half_shift(point: Point) -> np.ndarray:
    """Difference of an orbit's states on the section half its turns apart."""
    section, state = point.orbit.map, point.orbit.state
    return section.differ(section.image(state, False, section.turns // 2).state, state)


def shifted(family: Family, point: Point, angle: float) -> Point:
    """The point on the section `angle` rad on; the same point where that fails."""
    z = point.z + SMALL * point.tangent
    section = point.orbit.map
    there, here = section.moved(point.orbit.state, angle)
    neighbour, state = family.placed(z, point)
    neighbour_there = neighbour.moved(state, angle)[1]
    if here.status or neighbour_there.status:
        return point
    like = replace(point, orbit=replace(point.orbit, map=there, state=here.state), directions=None)
    along = np.append(there.differ(neighbour_there.state, here.state) / point.unit, family.place(z) - point.q)
    along /= np.linalg.norm(along)
    return solve(family, like, like.z, along) or point
