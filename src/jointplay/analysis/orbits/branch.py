"""A branch of periodic orbits, step by step: predict, correct, look what has changed, choose the next step.

Within a piece of a branch orbits have the same events. Where these change (an event appears or vanishes:
grazing) the place is enclosed by bisection, and the branch goes on at the other side if it can; where it
cannot, it ends there. Test functions are compared within a piece only.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from jointplay.analysis.looks import Late, Stopped
from jointplay.analysis.orbits.arclength import Family, Point, solve
from jointplay.analysis.orbits.branch_points import Special, between
from jointplay.analysis.orbits.image import Image
from jointplay.analysis.orbits.orbit_events import changed, free_phase, word
from jointplay.analysis.orbits.orbit_search import NEAR

ENDS = ("range", "max_points", "grazing", "not_converged", "closed", "joined", "origin", "interrupted")
FIRST = 0.25  # of the longest step
SHORTEST = 1e-9
BOLD, SHY = 1.4, 0.6  # factors of the step after easy and hard corrections
EASY, HARD = 4, 7  # corrections, down to rounding
ASTRAY = 0.5  # of a step: farther from its prediction a point may be another branch's
TURN, SMALL = 0.8, 1e-4  # cosine of the turn in a step; steps so small that any turn is believed
ENCLOSED = 1e-9  # bracket of a grazing
NEARLY = 1e-6  # of the arc: so closely a grazing should be enclosed from one side
GAP = 1e-3  # on the arc: so far beyond a grazing the branch must go on, to be the same
LOOKED = (1e-8, 1e-6, 1e-4)  # how far beyond a failure events are looked at


@dataclass
class Branch:
    """Points in turn, special ones among them, and why both ends are ends."""

    points: list[Point] = field(default_factory=list)
    specials: list[Special] = field(default_factory=list)
    ends: tuple[str, str] = ("origin", "not_converged")
    parent: int = -1

    def reversed(self) -> Branch:
        """The same branch from its other end."""
        return replace(self, points=self.points[::-1], specials=self.specials[::-1], ends=self.ends[::-1])


class Tracer:
    """Follows a branch from a point, in the sense of its tangent.

    Parameters
    ----------
    family : Family
        Of maps.
    step : float
        Longest step.
    room : callable
        Told of each point; False: no more are wanted.
    halves : bool
        Whether the orbit was born doubled: where both halves become one, the branch has joined its parent.
    """

    def __init__(self, family: Family, step: float, room: Callable[[Point], bool], halves: bool = False):
        self.family, self.step, self.room, self.halves = family, step, room, halves
        self.points: list[Point] = []
        self.specials: list[Special] = []
        self.full = False

    def follow(self, start: Point) -> Branch:
        """Follow the branch to its end; the start is its first point."""
        length, end = FIRST * self.step, None
        try:
            self._take(start)
            last = self._settled(start)
            while end is None:
                last, length, end = self._advance(last, length)
        except (Stopped, Late):
            end = "interrupted"
        return Branch(self.points, self.specials, ("origin", end))

    def _take(self, point: Point) -> None:
        self.points.append(point)
        self.full |= not self.room(point)

    def _settled(self, point: Point) -> Point:
        """The point on a section that no event is near to."""
        section = point.orbit.map
        where, near = free_phase(point.orbit.image.events, section.turns)
        return point if section.plane or near >= NEAR else shifted(self.family, point, math.tau * where)

    def _advance(self, last: Point, length: float) -> tuple[Point, float, str | None]:
        """One attempt: the point to go on from, the next step's length, and the end if it is one."""
        if self.full:
            return last, length, "max_points"
        new = self._try(last, length, ASTRAY * length)
        if new is None:
            return (last, length / 2, None) if length > 2 * SHORTEST else (last, length, self._lost(last))
        if not 0.0 <= new.q <= 1.0:
            new, end = self._edge(last, new), "range"
            if new is None:
                return last, length / 2, None if length > 2 * SHORTEST else "range"
        else:
            end = self._finished(last, new, length)
        if end == "joined":
            return last, length, end
        if not same_events(last, new):
            return self._graze(last, new, length)
        self._between(last, new)
        self._take(new)
        factor = BOLD if new.iterations <= EASY else SHY if new.iterations >= HARD else 1.0
        return self._settled(new), min(self.step, factor * length), end

    def _try(self, last: Point, length: float, room: float, kinks: bool = False) -> Point | None:
        """The point a step on, if it is found and believed: less than `room` from its prediction."""
        guess = last.z + length * last.tangent
        new = solve(self.family, last, guess, last.tangent)
        if new is None or np.linalg.norm(new.z - guess) > room:
            return None
        return new if kinks or length < SMALL or new.tangent @ last.tangent > TURN else None

    def _edge(self, last: Point, new: Point) -> Point | None:
        """The point at the edge of the range, which the step has passed."""
        edge = float(np.clip(new.q, 0.0, 1.0))
        if last.q == edge:
            return last
        guess = last.z + (edge - last.q) / (new.q - last.q) * (new.z - last.z)
        normal = np.append(np.zeros(len(guess) - 1), math.copysign(1.0, new.q - last.q))
        guess[-1] = edge
        return solve(self.family, last, guess, normal)

    def _finished(self, last: Point, new: Point, length: float) -> str | None:
        start = self.points[0]
        alike = start.orbit.map.phase == new.orbit.map.phase and len(self.points) > 8
        if alike and np.linalg.norm(new.z - start.z) < length and new.tangent @ start.tangent > TURN:
            return "closed"
        return "joined" if self.halves and halves(last) @ halves(new) < 0 else None

    def _between(self, last: Point, new: Point) -> None:
        for special in between(self.family, last, new):
            self._take(special.point)
            self.specials.append(special)

    def _graze(self, last: Point, new: Point, length: float) -> tuple[Point, float, str | None]:
        """Enclose a change of events within a step, and go on beyond it."""
        low, high, before, beyond = 0.0, length, last, new
        while high - low > ENCLOSED:
            middle = (low + high) / 2
            found = self._try(last, middle, ASTRAY * length, kinks=True)
            if found is not None and same_events(last, found):
                low, before = middle, found
                continue
            high = middle
            if found is not None:
                beyond = found
        if apart(before, beyond) > NEARLY:  # Newton's method was led astray by the kink: from the other side
            beyond = self._back(beyond, before)
        self._between(last, before)
        self._mark(before, beyond.orbit.image, abs(beyond.q - before.q))
        if apart(before, beyond) > GAP:
            return before, length, "grazing"
        self._take(beyond)
        return self._settled(beyond), max(FIRST * length, SMALL * self.step), None

    def _back(self, beyond: Point, before: Point) -> Point:
        """The point with the events of `beyond` that is nearest to `before`."""
        low, high, chord, nearest = 0.0, 1.0, before.z - beyond.z, beyond
        size = np.linalg.norm(chord)
        while (high - low) * size > ENCLOSED:
            middle = (low + high) / 2
            found = solve(self.family, beyond, beyond.z + middle * chord, -chord / size)
            if found is not None and same_events(beyond, found):
                low, nearest = middle, found
            else:
                high = middle
        return nearest

    def _mark(self, point: Point, after: Image, gap: float) -> None:
        """Note a grazing at a point, with the event that is not the same after it."""
        event = changed(point.orbit.image.events, after.events)
        if point is not self.points[-1]:
            self._take(point)
        self.specials.append(Special("grazing", point, point.q, gap, event))

    def _lost(self, last: Point) -> str:
        """Why a branch ends where no step is short enough."""
        after = ahead(self.family, last)
        if after is None:
            return "not_converged"
        self._mark(last, after, SHORTEST)
        return "grazing"


def apart(one: Point, other: Point) -> float:
    """Distance of two points on the same section."""
    return float(np.linalg.norm(one.z - other.z))


def same_events(one: Point, other: Point) -> bool:
    """Whether two orbits have the same events, in whichever order."""
    return word(one.orbit.image.events) == word(other.orbit.image.events)


def ahead(family: Family, point: Point) -> Image | None:
    """Of motions a little beyond a point, along its tangent, the first that has other events."""
    section = point.orbit.map
    for distance in LOOKED:
        z = point.z + distance * point.tangent
        beyond = family.at(z[-1], section)
        image = beyond.image(beyond.state(z[:-1] * point.unit), False)
        if not image.status and word(image.events) != word(point.orbit.image.events):
            return image
    return None


def halves(point: Point) -> np.ndarray:
    """How far apart the two halves of an orbit are, on the section."""
    section, state = point.orbit.map, point.orbit.state
    return section.differ(section.image(state, False, section.turns // 2).state, state)


def shifted(family: Family, point: Point, angle: float) -> Point:
    """The point on the section `angle` rad onwards; itself where that cannot be reached."""
    z = point.z + SMALL * point.tangent
    section = point.orbit.map
    there, here = section.moved(point.orbit.state, angle)
    neighbour = family.at(z[-1], section)
    beside = neighbour.moved(neighbour.state(z[:-1] * point.unit), angle)[1]
    if here.status or beside.status:
        return point
    like = replace(point, orbit=replace(point.orbit, map=there, state=here.state))
    along = np.append(there.differ(beside.state, here.state) / point.unit, z[-1] - point.q)
    along /= np.linalg.norm(along)
    found = solve(family, like, like.z, along)
    return point if found is None else found
