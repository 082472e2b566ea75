"""The condition of grazing: somewhere on an orbit a guard comes just short of firing.

With m(t) the margin of that guard along the orbit, m = 0 and m' = 0 there: g = min m, over its own size. With
M the tangents up to the minimum, dg = grad m M dx + dm/dp dp, since m' = 0. A curve is followed on that side
on which the guard does not fire: there the map is smooth up to the curve, also where an impact beyond it has
a square-root singularity. Its points lie SHORT of the curve; iterates that pass it are drawn back.
References: Nordmark, J. Sound Vib. 145 (1991) 279-297; di Bernardo et al., Piecewise-smooth Dynamical Systems
(2008), chapter 6.

The condition of coincidence: slip reverses where its contact begins or ends.

On a curve of coincidence two events are at one time: slip reverses where contact begins or ends, and is gone
in flight. With s the speed of sliding and h the guard of the contact's beginning or end, at time t: g = s(t),
over its own size. With M the tangents up to t, dg = (grad s - s'/h' grad h) M dx + (ds - s'/h' dh)/dp dp.
Points lie SHORT of the curve, on that side on which slip does not reverse: there the orbit's events are the
same ones. Assumptions: the state does not jump at the event (a contact with a force). Validity: contact
begins or ends with a speed, h' is not 0. Reference: di Bernardo et al., Piecewise-smooth Dynamical Systems
(2008), chapter 8.

Guards along a motion, as the flow watches them, and their margins before they fire.

The margin of a guard is the number that reaches zero where it fires: a gap in flight, the force or the
penetration in contact, the speed of sliding, the distance from the friction cone. It is evaluated by the
structure's own compiled functions on recorded states.

The half map of a symmetric periodic orbit: half its turns, and the reflection that brings it back.

Where x(t + T/2) = S x(t) with signs S, the orbit is a fixed point of Q = S phi_{T/2}, and its section map is
Q^2. Symmetry is lost where Q has a multiplier -1; that of the section map is then +1, and its fixed points
branch, so that only Q makes a regular problem of it. Validity: an odd number of periods of a forcing, and
equations that S leaves as they are half a period later; both are seen from the orbit, which is Q's fixed
point only then.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, fields, replace
from functools import partial
from itertools import pairwise

import numpy as np
from numpy.polynomial import Polynomial

from jointplay.analysis.orbits.branch_points import doubling, unit
from jointplay.analysis.orbits.family import Family, Point, Trial
from jointplay.analysis.orbits.section_map import (
    CONTACT,
    KIND,
    OF_GAPS,
    PLACE,
    TIME,
    Image,
    SectionMap,
    vertex,
)
from jointplay.analysis.orbits.shooting import Orbit, newton
from jointplay.analysis.tangents import Bundle
from jointplay.solver.codegen import cache
from jointplay.solver.mechanism.directions import Directions
from jointplay.solver.mechanism.model import Model
from jointplay.solver.method.codes import Event, Mode
from jointplay.solver.motion.trajectory import Request, memory

SHORT = 1e-10  # of the margin's size
NEAR = 3e-3  # of a multiplier from +1 or -1 where a curve of folds or doublings is met
EARLIER = 1e-4  # of the time between samples: a run to the minimum itself may fire the guard by rounding
PART = 1e-7  # of the scales, small beside a clearance: differences of a margin
SAMPLES = 720  # a turn
STAGES = (0.5, 1 / 32)  # spacings of the five samples, in those, through which an extremum is interpolated
FIVE = np.arange(-2.0, 3.0)
SLIDE, PLACES = 2, 4  # of a contact's guards
SIDES = {Mode.SLIP_POSITIVE: 1.0, Mode.SLIP_NEGATIVE: -1.0}
OF_SLIDING = (Event.SLIP_REVERSAL, Event.STICK_ONSET, Event.SLIP_ONSET)

SAME = 1e-2  # of the scales: beside a loss of symmetry, an orbit is known to a root of its residual


class Meeting:
    """Meetings of a curve on which an event vanishes with curves of folds and doublings."""

    def tests(self, one: Point) -> Mapping[str, Callable[[Point], float]]:
        """Zeros where the orbit that grazes also folds or doubles."""
        return {"fold_grazing": unit, "doubling_grazing": doubling}

    def genuine(self, kind: str, point: Point) -> bool:
        """Whether the zero of a test is a genuine point of its kind."""
        wanted = 1.0 if kind == "fold_grazing" else -1.0
        return bool(np.any(np.abs(np.asarray(point.multipliers) - wanted) < NEAR))


@dataclass(frozen=True)
class Grazing(Meeting):
    """A guard that nearly fires.

    Parameters
    ----------
    guard : int
        Its number.
    size : float
        Of its margin, by which it is divided.
    event : tuple of int
        Contact and kind of the event that begins beyond the curve.
    """

    guard: int
    size: float
    event: tuple[int, int] = (-1, -1)
    sided = True

    def value(self, trial: Trial, like: Point) -> float:
        """The least margin over its size, less `SHORT`; NaN where the guard fires once more, or less."""
        found = self._least(trial, like)
        return np.nan if found is None else found[0] / self.size - SHORT

    def gradient(self, family: Family, trial: Trial, like: Point) -> np.ndarray:
        """Derivatives of the value in the coordinates x/c and the fractions of the ranges."""
        found = self._least(trial, like)
        if found is not None:
            found = slopes(family, trial, like, found[1], self._margin)
        if found is None:
            return np.full(len(trial.section.free) + family.count, np.nan)
        return found[1][0] / self.size

    def _margin(self, model: Model, rows: np.ndarray) -> np.ndarray:
        return Guards(model).margins(rows)[:, [self.guard]]

    def _least(self, trial: Trial, like: Point) -> tuple[float, float] | None:
        guards, image = Guards(trial.section.model), trial.image
        before = guards.count(self.guard, like.orbit.image.events)
        if image.status or guards.count(self.guard, image.events) != before:
            return None
        found = guards.nearest(trial.section, trial.state, image.time, image.events)
        if found is None or not np.isfinite(found[0][self.guard]):
            return None
        near, apart = found[1][self.guard], spacing(trial.section, image)
        return guards.minimum(trial.section, trial.state, self.guard, near, apart, image.time)


def spacing(section: SectionMap, image: Image) -> float:
    """Time between the samples of an orbit, s."""
    return image.time / (SAMPLES * section.turns)


def slopes(
    family: Family, trial: Trial, like: Point, time: float, of: Callable[[Model, np.ndarray], np.ndarray]
) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """Numbers of a state at a time of an orbit, their derivatives, their rates; None if it fails.

    `of`: the numbers, by a model and rows of time, state, modes. Derivatives are rows: in the coordinates x/c
    and the fractions of the ranges. Extrapolated from two times just before.
    """
    later, section = EARLIER * spacing(trial.section, trial.image), trial.section
    run = trial.state, section.request(time - later), np.eye(len(trial.state)), trial.directions
    bundle, _, status = section.run(*run, until=time - 2 * later)
    if status:
        return None
    far = _slopes(family, trial, like, bundle, later, of)
    if bundle.advance():
        return None
    near = _slopes(family, trial, like, bundle, later, of)
    return tuple(2 * one - other for one, other in zip(near, far, strict=True))


def _slopes(family: Family, trial: Trial, like: Point, bundle: Bundle, later: float, of: Callable):
    section, state, directions = trial.section, trial.state, trial.directions
    here = np.concatenate([[bundle.time], bundle.state, bundle.motion.modes])
    steps = np.zeros((2 * len(state), len(here)))
    for i, part in enumerate(PART * section.scale):
        steps[2 * i, 1 + i], steps[2 * i + 1, 1 + i] = part, -part
    values = of(section.model, here + steps)
    gradients = (values[::2] - values[1::2]).T / (2 * PART * section.scale)
    rows = gradients @ bundle.vectors.T
    own = [
        np.diff([of(moved, here[None])[0] for moved in sides], axis=0)[0] / (2 * PART * size)
        for sides, size in zip(_varied_models(section.model, directions), directions.units, strict=True)
    ]
    ahead = later * np.concatenate([[1.0], bundle.rate(), 0.0 * bundle.motion.modes])
    after, ago = of(section.model, np.stack([here + ahead, here - ahead]))
    coordinates = like.unit * (rows[:, : len(state)] * section.scale)[:, section.free]
    ranges = (rows[:, len(state) :] + np.transpose(own)) * (family.high - family.low)
    return of(section.model, here[None])[0], np.hstack([coordinates, ranges]), (after - ago) / (2 * later)


def _varied_models(model: Model, directions: Directions) -> Iterator[tuple[Model, Model]]:
    """The model with its numbers a little before and after, in each direction."""
    places = {name: i for i, name in enumerate(cache.structure_module(model.structure).PARAMETERS)}
    for names, rates, size in zip(directions.names, directions.rates_of, directions.units, strict=True):
        change = np.zeros(len(model.numbers))
        change[[places[name] for name in names]] = PART * size * rates
        yield replace(model, numbers=model.numbers - change), replace(model, numbers=model.numbers + change)


def grazed(orbit: Orbit, event: tuple[int, int]) -> tuple[float, Grazing] | None:
    """The guard of an event's contact that nearly fires on an orbit, and its margin over its size.

    None where none comes near. On half a symmetric orbit it may be the mirror image's.
    """
    section, guards = orbit.map, Guards(orbit.map.model)
    found = guards.nearest(section, orbit.state, orbit.image.time, orbit.image.events)
    if found is None:
        return None
    least, _, sizes = found
    fits = (guards.owner(g) == event[0] or isinstance(section, HalfMap) for g in range(len(least)))
    owned = [g for g, fit in enumerate(fits) if fit and event[1] in guards.kinds(g) and np.isfinite(least[g])]
    if not owned:
        return None
    guard = min(owned, key=lambda g: least[g] / sizes[g])
    return float(least[guard] / sizes[guard]), Grazing(guard, float(sizes[guard]), event)


@dataclass
class Guards:
    """The guards of a model.

    Parameters
    ----------
    model : Model
        Whose.
    """

    model: Model
    contacts: int = field(init=False)

    def __post_init__(self):
        self._module = cache.structure_module(self.model.structure)
        self._work, self._motion, self._options = memory(self.model, Request(1.0))
        self.contacts = len(self._motion.flags)

    def margins(self, rows: np.ndarray) -> np.ndarray:
        """Margins at rows of time, state, modes; shape (rows, guards); NaN where a guard is not watched."""
        from jointplay.solver.method.events import side_of

        motion, found = self._motion, self.values(rows)
        for modes, own in self._stretches(rows):
            found[own] *= [side_of(g, modes, motion.flags) or np.nan for g in range(len(motion.fired))]
        return found

    def values(self, rows: np.ndarray) -> np.ndarray:
        """The guards' numbers with their signs, as the modes of each row give them; shape (rows, guards)."""
        from jointplay.solver.method.modes import mask, variant_of

        work, motion, options = self._work, self._motion, self._options
        width, last = 1 + len(self.model.state), 8 * (options.guards + np.arange(len(motion.fired))) + 7
        found = np.empty((len(rows), len(motion.fired)))
        for modes, own in self._stretches(rows):
            variant = variant_of(modes)
            mask(modes, motion.m)
            work.w[:] = 0.0  # the increments; and guards that are not watched in these modes
            for row, numbers in zip(rows[own], found[own], strict=True):
                motion.s[:width] = row[:width]
                self._module.trig(motion.s, motion.p)
                self._module.rate(variant, work.w, motion.s, motion.p, motion.m)
                numbers[:] = work.w[last]
        return found

    def _stretches(self, rows: np.ndarray) -> Iterator[tuple[np.ndarray, slice]]:
        """Contact modes, and the rows one after another that have them."""
        first = 1 + len(self.model.state)
        modes = rows[:, first : first + len(self._motion.modes)].astype(self._motion.modes.dtype)
        changes = 1 + np.flatnonzero(np.any(modes[1:] != modes[:-1], axis=1))
        for begin, end in pairwise((0, *changes, len(rows))):
            yield modes[begin], slice(begin, end)

    def owner(self, guard: int) -> int:
        """Number of the contact, or wall, of a guard, as in rows of events."""
        if guard < PLACES * self.contacts:
            return guard // PLACES
        walls = len(self._motion.modes) - self.contacts
        return self.contacts + (guard - PLACES * self.contacts) % walls

    def kinds(self, guard: int) -> tuple[int, ...]:
        """Kinds of the events that a guard makes."""
        gaps = (PLACES - 1) * self.contacts + len(self._motion.modes)  # and after them the friction of walls
        sliding = guard % PLACES >= SLIDE if guard < PLACES * self.contacts else guard >= gaps
        return OF_SLIDING if sliding else OF_GAPS

    def count(self, guard: int, events: np.ndarray) -> int:
        """Number of an orbit's events that are of a guard's contact and kinds."""
        own = events[events[:, CONTACT] == self.owner(guard), KIND]
        return int(np.isin(own, self.kinds(guard)).sum())

    def nearest(self, section: SectionMap, state: np.ndarray, duration: float, events: np.ndarray):
        """Local minimum of each guard's margin that is nearest to zero, its time, and the margin's size.

        Minima are those of the parabola through three samples: by the samples alone a farther one may win.
        """
        count = section.turns * SAMPLES
        times = section.begin + np.arange(count) / count * duration
        rows, status = section.sampled(state, times, False)
        if status:
            return None
        margins = self.margins(rows)
        before, after = np.roll(margins, 1, axis=0), np.roll(margins, -1, axis=0)
        with np.errstate(invalid="ignore"):
            minimal = (margins <= before) & (margins < after)
            sizes = np.nanmax(np.abs(margins), axis=0, initial=0.0, where=np.isfinite(margins))
        for row in events:
            at = int((row[TIME] - section.begin) / duration * count)
            contact, kind = int(row[CONTACT]), int(row[KIND])
            own = [self.owner(g) == contact and kind in self.kinds(g) for g in range(len(sizes))]
            minimal[np.ix_(np.arange(at - 1, at + 3) % count, np.flatnonzero(own))] = False
        least, shift = np.full_like(margins, np.inf), np.zeros_like(margins)
        least[minimal], shift[minimal] = vertex(before[minimal], margins[minimal], after[minimal])
        where, own = np.argmin(np.abs(least), axis=0), np.arange(len(sizes))
        return np.abs(least[where, own]), times[where] + shift[where, own] * duration / count, sizes

    def minimum(
        self, section: SectionMap, state: np.ndarray, guard: int, near: float, spacing: float, turn: float
    ) -> tuple[float, float] | None:
        """Local minimum of a guard's margin, and its time, from a time near it; None where there is none.

        The quartic through five samples, the second time through closer ones.
        """
        time, value = near, np.nan
        for share in STAGES:
            step = share * spacing
            time += turn if time - 2 * step < section.begin else 0.0
            rows, status = section.sampled(state, time + step * FIVE, False)
            margins = self.margins(rows)[:, guard] if not status else np.full(5, np.nan)
            if not np.all(np.isfinite(margins)):
                return None
            quartic = Polynomial(np.linalg.solve(np.vander(FIVE, increasing=True), margins))
            roots = quartic.deriv().roots()
            inside = roots[(np.abs(roots.imag) < 1e-6) & (np.abs(roots.real) <= 2.5)].real
            if not len(inside):
                return None
            best = inside[np.argmin(quartic(inside))]
            time, value = time + step * best, float(quartic(best))
        return value, time


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
        """Derivatives of the value in the coordinates x/c and the fractions of the ranges."""
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
    offsets = EARLIER * spacing(section, orbit.image) * np.array([-1.0, 1.0])
    rows, status = section.sampled(orbit.state, row[TIME] + offsets, False)
    modes = rows[:, 1 + len(model.state) + contact].astype(int)
    sides = [SIDES[mode] for mode in modes if mode in SIDES]
    near = guards.nearest(section, orbit.state, orbit.image.time, events)
    if status or near is None or not sides:
        return None
    size = float(near[2][PLACES * contact + SLIDE])
    return float(speeds.min() / size), Coincidence(contact, int(row[KIND]), sides[0] * size, event)


@dataclass(frozen=True)
class HalfMap(SectionMap):
    """Half the turns of a section map, and a reflection.

    Parameters
    ----------
    signs : ndarray of float
        +1 or -1 for each state.
    """

    signs: np.ndarray | None = None

    def image(
        self,
        state: np.ndarray,
        derivative: bool = True,
        turns: int | None = None,
        directions: Directions | None = None,
    ) -> Image:
        """Image of a state under the half map, with the events of the whole orbit."""
        image = self._followed(state, math.pi, self.turns // 2, derivative, directions)
        if image.status:
            return image
        signs = self.signs[self.free, None]
        P = signs * image.derivative if derivative else None
        along = signs * image.along if directions is not None else None
        places = image.events[:, PLACE] / 2
        events = np.concatenate([image.events, image.events])
        events[:, PLACE] = np.concatenate([places, places + 0.5])
        reached = self._wrapped(self.signs * image.state, state)
        return replace(image, state=reached, derivative=P, along=along, events=events)

    def whole(self, orbit: Orbit) -> Orbit:
        """The orbit of the section map that a fixed point of this one is."""
        section = SectionMap(**{each.name: getattr(self, each.name) for each in fields(SectionMap)})
        return replace(orbit, map=section, image=section.image(orbit.state))


def halved(orbit: Orbit, tolerance: float) -> Orbit | None:
    """A symmetric orbit as a fixed point of its half map; None if it is not symmetric."""
    section = orbit.map
    if section.place is not None or section.turns % 2 == 0:
        return None
    half = section._followed(orbit.state, math.pi, section.turns // 2, False)
    if half.status:
        return None
    signs = np.where(np.abs(half.state + orbit.state) < np.abs(half.state - orbit.state), -1.0, 1.0)
    given = {each.name: getattr(section, each.name) for each in fields(SectionMap)}
    found = newton(HalfMap(**given, signs=signs), orbit.state, tolerance)
    same = np.max(np.abs(section.differ(found.state, orbit.state))) < SAME if not found.status else False
    return found if same else None
