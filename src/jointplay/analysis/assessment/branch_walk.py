"""The periodic orbit of a linkage along one parameter, from its present value outward, to where it ends.

At each value the orbit is found by Newton's method on the section map from a straight line through the two
before it. Steps are even in the logarithm: long where the orbit is strongly stable and its contacts stay far
from opening, short where a multiplier nears the unit circle, and where contact is lost or nearly so: there
events appear and vanish in narrow succession. How near opening is, its `margin` says: the least normal force
over the largest one of the same joint, the smallest of all joints. An orbit off the line is of the branch
if the first step of Newton's method all but ended there. One that is strongly stable, and whose residual on
the line is small, takes one step and is not run through again: the step errs by its square.

Contact is lost where the orbit first has a separation; the orbit ends where a multiplier leaves the unit
circle (through -1: its period doubles; through +1: a fold or a branch point; a pair: a torus) or where no
orbit continues it. Both are enclosed by halving, each time with the orbit itself. Multipliers near the unit
circle are taken at a sharper tolerance: long steps do not resolve the tangents of a motion that is quiet.
References: Kuznetsov, Elements of Applied Bifurcation Theory (2004), chapter 10; Deuflhard, Newton Methods
(2011), chapter 5.
Validity: what appears and vanishes between two steps is not seen.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from jointplay.analysis.assessment.settled import log_distance
from jointplay.analysis.evaluate import Quantities
from jointplay.analysis.orbits import shooting
from jointplay.analysis.orbits.branch_points import REAL
from jointplay.analysis.orbits.section_map import (
    KIND,
    OF_GAPS,
    SectionMap,
    free_phase,
    same_events,
    section_map,
)
from jointplay.analysis.orbits.shooting import Orbit, at_phase, newton, sooner
from jointplay.analysis.starts import placed
from jointplay.solver.mechanism.records import ONCE_A_TURN, Mechanism
from jointplay.solver.method.codes import Mode

RTOL, SHARP = 1e-9, 1e-10  # of an orbit; of one that is nearly unstable
TOLERANCE = 1e-8  # of an orbit's residual, in units of the states' scales
SOONER = 1e-6  # likewise, of a residual after a part of an orbit's turns: it is of the branch of that period
QUICK = (TOLERANCE, 8, TOLERANCE, 0.25)  # of Newton's method near an orbit: what takes more is none of it
SAMPLES = 512  # of a turn, for the margin
LONGEST, LONG, FINEST = 8, 2, 32  # short steps at once; and parts of one, where stability is about to end
SHORTEST = 1e-4  # below which an orbit that is not found has ended
FAR, NEAR = 0.2, 0.03  # margins above which steps are the longest, and below which they are short
FALL = 0.5  # share of the margin that a step may take away
STRONG, WEAK = 0.7, 0.9  # largest multipliers likewise; above the latter the sharper tolerance
RISE = 0.5  # share of its distance from 1 by which the largest multiplier may come nearer in a step
OFFSET = 0.5  # of the step to the place expected: how far an orbit may lie from it
ALIKE = 0.01  # clearances that it may in any case, and more where both are strongly stable and keep contact
UNSEEN = 5e-6  # residual of a strongly stable orbit, in units of the scales: the step from there is the last
NEARBY = 0.1  # of the residual, left by the first step of Newton's method: no other orbit is as near
NEAREST = 0.005  # of a turn: an event so near the section moves it
CRITICAL = 0.02  # of a multiplier's size, on both sides of where it passes 1
ENCLOSED = 1e-6  # relative width of the values that enclose a change


@dataclass(frozen=True, eq=False)
class Place:
    """A periodic orbit at a value of the parameter.

    Parameters
    ----------
    value : float
        Of the parameter.
    orbit : Orbit
        With the derivative of its image, and the events.
    multipliers : ndarray
        The largest first.
    margin : float
        Least normal force over the largest one, of the joint where that is smallest; 0 where contact is lost.
    """

    value: float
    orbit: Orbit
    multipliers: np.ndarray
    margin: float

    @cached_property
    def lost(self) -> bool:
        """Whether contact is lost in the orbit."""
        return loses_contact(self.orbit)

    @property
    def radius(self) -> float:
        """Largest modulus of a multiplier."""
        return float(abs(self.multipliers[0]))

    @property
    def stable(self) -> bool:
        """Whether all multipliers lie within the unit circle."""
        return self.radius < 1

    @property
    def sure(self) -> bool:
        """Whether Newton's method came so straight to an orbit so stable that its last step need no look."""
        return self.radius < STRONG and not self.orbit.contraction > NEARBY

    def at_start(self) -> np.ndarray:
        """The orbit's state at crank angle 0."""
        return at_phase(self.orbit, 0.0)[0]


def loses_contact(orbit: Orbit) -> bool:
    """Whether contact is lost at any joint in an orbit, or is never there."""
    events, model = orbit.image.events, orbit.map.model
    if np.isin(events[:, KIND], OF_GAPS).any():
        return True
    rows, status = orbit.map.sampled(orbit.state, orbit.map.begin + np.array([orbit.image.time]), False)
    return bool(status or (Quantities(model, rows, rows[0]).modes <= Mode.RELEASED).any())


def margin_of(orbit: Orbit) -> float:
    """Least normal force over the largest one, of the joint where that is smallest."""
    section, times = orbit.map, np.linspace(0.0, orbit.image.time, SAMPLES * orbit.map.turns + 1)[1:]
    rows, status = section.sampled(orbit.state, section.begin + times, False)
    if status:
        return 0.0
    found = Quantities(section.model, rows, rows[0]).variables(("normal_force",), "time")
    if "normal_force" not in found:  # of rigid bearings
        return 0.0
    forces = found["normal_force"][1]
    return float(np.min(forces.min(axis=0) / forces.max(axis=0)))


@dataclass
class Branch:
    """Periodic orbits of a mechanism over a parameter, on a section of the first one's.

    Parameters
    ----------
    mechanism : Mechanism
        At the present value.
    key : str
        The parameter.
    turns : int
        In which orbits close.
    max_steps : int, optional
        Attempted steps after which a run stops.
    """

    mechanism: Mechanism
    key: str
    turns: int
    max_steps: int | None = None

    def map(self, value: float, rtol: float) -> SectionMap:
        """The section map at a value."""
        there = self.mechanism.varied({self.key: value})
        return section_map(placed(there, None, ONCE_A_TURN), ONCE_A_TURN, self.turns, rtol, self.max_steps)

    def at(
        self, value: float, like: SectionMap, state: np.ndarray, sharp: bool, unseen: float = 0.0
    ) -> Place | None:
        """The orbit near a state on the section of another one; None if there is none."""
        section = replace(self.map(value, SHARP if sharp else RTOL), phase=like.phase)
        orbit = newton(section, state, *QUICK, unseen)
        return None if orbit.status or sooner(orbit, SOONER) else self.place(value, orbit)

    def first(self, value: float, state: np.ndarray) -> Place | None:
        """The orbit near a state at crank angle 0, on a section of its own; None if there is none."""
        return self.at(value, self.map(value, RTOL), state, sharp=True)

    def place(self, value: float, orbit: Orbit) -> Place:
        """An orbit at a value, on a section away from its events."""
        middle, nearest = free_phase(orbit.image.events, self.turns)
        if nearest < NEAREST:
            section, image = orbit.map.moved(orbit.state, math.tau * middle)
            moved = orbit if image.status else newton(section, image.state, *QUICK)
            orbit = orbit if moved.status else moved
        multipliers = shooting.multipliers(orbit.image.derivative)
        if abs(multipliers[0]) > WEAK and orbit.map.rtol > SHARP:
            sharper = newton(replace(orbit.map, rtol=SHARP), orbit.state, *QUICK)
            orbit = orbit if sharper.status else sharper
            multipliers = shooting.multipliers(orbit.image.derivative)
        return Place(value, orbit, multipliers, 0.0 if loses_contact(orbit) else margin_of(orbit))


@dataclass
class Walk:
    """The way along a branch on one side.

    Parameters
    ----------
    branch : Branch
        What is followed.
    places : list of Place
        From the present value outward.
    sense : int
        1 towards larger sizes of the parameter, -1 towards smaller ones.
    limit : float
        Distance of the last value from the first, in the logarithm.
    short : float
        Shortest of the regular steps, likewise.
    """

    branch: Branch
    places: list[Place]
    sense: int
    limit: float
    short: float
    step: float = 0.0

    def value(self, distance: float) -> float:
        """Value of the parameter at a distance from the first place, in the logarithm."""
        return self.places[0].value * math.exp(self.sense * distance)

    def distance(self, value: float) -> float:
        """Distance of a value from the first place's, in the logarithm."""
        return log_distance(value, self.places[0].value)

    def longest(self, place: Place, before: Place | None) -> float:
        """Longest step from a place on, by its margin, its stability, and how fast both change."""
        if before is None:
            return self.short
        since = max(log_distance(place.value, before.value), SHORTEST)
        fall, rise = (before.margin - place.margin) / since, (place.radius - before.radius) / since
        long, longest = LONG * self.short, LONGEST * self.short
        if place.margin < NEAR:
            step = self.short
        else:
            step = longest if place.margin > FAR and fall * longest < FALL * place.margin else long
        if rise * step > RISE * abs(1 - place.radius):
            step = max(RISE * abs(1 - place.radius) / rise, self.short / FINEST)
        return step

    def onward(self) -> Place | None:
        """The next place; None where no orbit is found behind the last one, or at the limit."""
        last, since = self.places[-1], self.distance(self.places[-1].value)
        regular = self.longest(last, self.places[-2] if len(self.places) > 1 else None)
        self.step = min(self.step or regular, regular)
        while since < self.limit * (1 - 1e-12):
            distance = min(since + self.step, self.limit)
            found = self.orbit_at(self.value(distance), last)
            if found is None and self.step <= SHORTEST:
                return None
            if found is None:
                self.step = max(self.step / 4, SHORTEST)
            elif distance - since > 1.01 * (shorter := self.longest(found, last)):  # what lies before it?
                self.step = max(shorter, self.step / 4)
            else:
                self.places.append(found)
                self.step *= 2
                return found
        return None

    @property
    def ended(self) -> float | None:
        """The value next to the last place where no orbit is found; None where the limit was reached."""
        since = self.distance(self.places[-1].value)
        return self.value(since + SHORTEST) if since < self.limit * (1 - 1e-12) else None

    def orbit_at(self, value: float, last: Place) -> Place | None:
        """The orbit of the branch at a value, found from the last two; None if it is not near there."""
        section = last.orbit.map
        guess, moved = expected(value, last, self.places[-2] if len(self.places) > 1 else None)
        rough, links, joints = last.radius < STRONG, self.branch.mechanism.links, self.branch.mechanism.joints
        turned = max(joint.clearance for joint in joints) / max(link.length for link in links)  # rad
        for unseen in (UNSEEN, 0.0) if rough else (0.0,):
            found = self.branch.at(value, section, guess, not rough, unseen)
            if found is None or found.orbit.map.phase != section.phase:
                return found
            offset = np.linalg.norm(_positions(section, section.differ(found.orbit.state, guess)))
            quiet = rough and last.margin > 0 and found.margin > 0
            allowed = max(OFFSET * moved, ALIKE * turned)
            near = quiet or found.orbit.contraction < NEARBY or offset <= allowed
            if near and found.sure if unseen else (near or self.step <= SHORTEST):
                return found
        return None

    def enclosed(self, test: Callable[[Place], bool]) -> tuple[Place, Place]:
        """Two places close together, between the last two: the test holds of the second one only."""
        inner, outer = self.places[-2:]
        while abs(outer.value / inner.value - 1) > ENCLOSED:
            value = self.value((self.distance(inner.value) + self.distance(outer.value)) / 2)
            near, far = sorted((inner, outer), key=lambda place: place.radius)
            guess, rough = expected(value, near, far)[0], far.radius < STRONG
            middle = self.branch.at(value, near.orbit.map, guess, False, UNSEEN) if rough else None
            if middle is None or not middle.sure:
                middle = self.branch.at(value, near.orbit.map, guess, near.radius > STRONG)
            if middle is None:
                break
            inner, outer = (inner, middle) if test(middle) else (middle, outer)
        return inner, outer


def expected(value: float, last: Place, other: Place | None) -> tuple[np.ndarray, float]:
    """State at a value on a line through two places, and how far that is from the last, rad or m."""
    state, section = last.orbit.state, last.orbit.map
    if other is None or other.orbit.map.phase != section.phase:
        return state, math.inf
    share = math.log(value / last.value) / math.log(last.value / other.value)
    change = share * section.differ(state, other.orbit.state)
    moved = float(np.linalg.norm(_positions(section, change)))
    return section.state(section.unknowns(state) + change), moved


def _positions(section: SectionMap, unknowns: np.ndarray) -> np.ndarray:
    """Positions among the free coordinates of a section."""
    return unknowns[section.free < len(section.model.turning)]


def kind_of(inner: Place, outer: Place) -> str:
    """How stability is lost between two places: by a multiplier that passes 1 in size, or by a grazing."""
    if not (inner.radius > 1 - CRITICAL and outer.radius < 1 + CRITICAL):
        return "bracketed" if same_events(inner.orbit.image.events, outer.orbit.image.events) else "grazing"
    largest = outer.multipliers[0]
    if abs(largest.imag) > REAL * abs(largest):
        return "neimark_sacker"
    return "period_doubling" if largest.real < 0 else "fold"
