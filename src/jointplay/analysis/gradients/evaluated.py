"""Quantities of a motion over some turns, with their derivatives in all directions at once.

The motion is followed with tangents that the directions drive (method.tangents.tangent), stopping where
quantities are looked at. With F the rate of the state and t' the derivative of the time at which that is,

    end                 dq = q_x (y + F t') + q_t t' + q_p
    largest, smallest   the same with t' = 0 within a piece; at an event t' = -(h_x y + h_p) / (h_t + h_x F)
    work                dW = the tangents' own, + P t'
    time                t' of the end: by the crank's angle -y_c / F_c, by a phase that of the period

and where impacts take energy, the joints' work is what the others leave over of the change of energy.

A largest value lies within a smooth piece, on one side of an event, or at an end. To find it, the motion is
followed again, sampled closer about the largest value so far: motions are the same each time,
samples do not change steps. Within a piece the place is the top of a polynomial through many samples of a
more exact run, since the derivative of a largest value is exact only there.

At a point, derivatives are taken by the complex step: a quantity's program (codegen.outputs) is arithmetic,
and run on x + i eps dx it gives value + i eps derivative, without a difference's cancellation. Reference:
Squire and Trapp, SIAM Review 40 (1998) 110-112.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from jointplay.analysis.evaluate import Quantities
from jointplay.analysis.gradients.selection import Quantity
from jointplay.analysis.orbits.orbit_events import BEGINS, KIND, PLACE, approach_speeds
from jointplay.analysis.quantities import WORK
from jointplay.analysis.tangents import TIGHT, Bundle
from jointplay.solver.codegen import cache, outputs
from jointplay.solver.equations.structure import powers
from jointplay.solver.mechanism.directions import Directions
from jointplay.solver.mechanism.model import Model
from jointplay.solver.method.codes import Event, Mode
from jointplay.solver.motion.guard_tolerances import clearances_squared
from jointplay.solver.motion.trajectory import Records, Request, follow

ENERGIES = ("kinetic_energy", "potential_energy")
LOOSER = 0.1  # tolerance of the tangents' iteration, in those of a step
ASIDE, ROOM = 1e-9, 10.0  # of the period, and tolerances: so far from an event a run stops on both sides
SAMPLES, CLOSER, ROUNDS = 4096, 33, 2  # of a turn; about the largest; how often
DEGREE, SHARPER, LEAST = 6, 1e-2, 1e-13  # of the polynomial; tolerance of its run in that of the motion's
ASTRAY = 1e-2  # relative difference of a largest value between the two runs
STEP = 1e-40  # of the complex step


@dataclass(frozen=True)
class Run:
    """A motion from the model's start, over a time that may depend on the parameters.

    Parameters
    ----------
    model : Model
        At its start; with powers where works are wanted, without a section.
    directions : Directions
        With the start's derivatives.
    end : float
        Time at which it ends, s.
    turns : float
        How many that are.
    place : int or None
        Index of the state that is the same at the end, whatever the time; None where time is as `directions`
        say.
    rtol : float
        Relative tolerance of a step.
    limit : int
        Attempted steps after which a run stops.
    """

    model: Model
    directions: Directions
    end: float
    turns: float
    place: int | None
    rtol: float
    limit: int

    def quantities(self, wanted: list[Quantity]) -> tuple[np.ndarray, np.ndarray, float]:
        """Values, derivatives (quantities, directions), and the nearest approach of an event to grazing.

        Raises
        ------
        ArithmeticError
            With the status, if the motion did not get to its end.
        """
        stops = [(self._peak(each), each) for each in wanted if each.how in ("largest", "smallest")]
        bundle, found, events = self._bundle(), {}, {}
        begin, opened = bundle.recorded, self._opened()
        for at, each in sorted(stops, key=lambda stop: stop[0].time):
            if at.where != "end":
                found[each] = self._at(bundle, at, each.key, events)
        self._advance(bundle, self.end)
        found |= self._at_end(bundle, begin, [each for each in wanted if each not in found])
        both = [found[each] for each in wanted]
        slopes = np.array([d for _, d in both]).reshape(len(wanted), len(self.directions))
        slopes[:, opened] = np.nan
        return np.array([v for v, _ in both]), slopes, bundle.grazing

    def _opened(self) -> np.ndarray:
        """Whether neighbours along each direction start off a wall on which the body starts at rest."""
        bundle = self._bundle()
        self._advance(bundle, 0.0)
        return bundle.opened()

    def _bundle(self) -> Bundle:
        none = np.zeros((0, len(self.model.state)))
        request = Request(self.end, self.rtol, max_steps=self.limit)
        tolerance = max(TIGHT, LOOSER * self.rtol)
        return Bundle(self.model, request, none, tolerance, directions=self.directions)

    def _advance(self, bundle: Bundle, until: float) -> None:
        if status := bundle.advance(until):
            raise ArithmeticError(status)

    def _peak(self, wanted: Quantity) -> Peak:
        sign = 1.0 if wanted.how == "largest" else -1.0
        return peak(self.model, wanted.key, sign, self.end, self.turns, self.rtol, self.limit)

    def _at(self, bundle: Bundle, at: Peak, key: str, events: dict) -> tuple[float, np.ndarray]:
        """Value and derivatives of a quantity at an extreme value; `events` keeps both sides of events."""
        if at.where in ("within", "start"):
            self._advance(bundle, at.time)
            return at.value, self._here(bundle.recorded, key, bundle.vectors, np.zeros(len(self.directions)))[
                1
            ]
        if at.time not in events:
            events[at.time] = self._sides(bundle, at.time)
        y, row, rate, times = events[at.time][at.where]
        return at.value, self._here(row, key, y + np.outer(times, rate), times)[1]

    def _sides(self, bundle: Bundle, time: float) -> dict[str, tuple]:
        """Tangents, row and rate of the state on both sides of an event, and derivatives of its time.

        The run with tangents meets it at the same time to within the tolerance: each side is continued to
        there from two places, by a line.
        """
        aside, sides = max(ASIDE, ROOM * self.rtol) * self.model.period, {}
        for side, places in (("before", (-2, -1)), ("after", (2, 1))):
            looked = {}
            for place in sorted(places):
                self._advance(bundle, min(max(time + place * aside, bundle.time), self.end))
                looked[place] = bundle.vectors, bundle.recorded, bundle.rate()
            far, near = (looked[place] for place in places)
            sides[side] = tuple(2 * b - a for a, b in zip(far, near, strict=True))
        y, _, rate = sides["before"]
        n_x, h = len(rate), bundle.tangents.gradient
        times = -(y @ h[1 : 1 + n_x] + h[1 + n_x :]) / (h[0] + h[1 : 1 + n_x] @ bundle.tangents.before)
        return {side: (*found, times) for side, found in sides.items()}

    def _here(self, row: np.ndarray, key: str, dx: np.ndarray, dt: np.ndarray) -> tuple[float, np.ndarray]:
        value = float(values(self.model, row[None, :], key)[0])
        return value, derivatives(self.model, row, key, dx, dt, self.directions)

    def _at_end(self, bundle: Bundle, begin: np.ndarray, wanted: list[Quantity]) -> dict[Quantity, tuple]:
        rate, y = bundle.rate(), bundle.vectors
        times = self.turns * self.directions.periods
        if self.place is not None:
            times = -y[:, self.place] / rate[self.place]
        dx, row, found = y + np.outer(times, rate), bundle.recorded, {}
        names = powers(self.model.structure)[: len(bundle.motion.work)]
        works = dict(zip(names, zip(bundle.motion.work, _works(bundle, times).T, strict=True), strict=True))
        if self.model.links and self.model.walls and works:  # impacts are no power's integral
            ends = (row, dx, times), (begin, self.directions.starts, 0 * times)
            works["joints"] = works["joints"][0], self._by_balance(works, *ends)
        for each in wanted:
            if each.how == "time":
                found[each] = self.end, times
            elif each.how == "work":
                found[each] = works[each.key]
            else:
                found[each] = self._here(row, each.key, dx, times)
        return found

    def _by_balance(self, works: dict[str, tuple], after: tuple, before: tuple) -> np.ndarray:
        """Derivatives of the joints' work: the remainder of the energy balance."""
        slope = sum(WORK[word][1] * rates for word, (_, rates) in works.items() if word != "joints")
        for sign, (row, dx, dt) in ((-1, after), (1, before)):
            slope = slope + sign * sum(self._here(row, key, dx, dt)[1] for key in ENERGIES)
        return slope


def _works(bundle: Bundle, times: np.ndarray) -> np.ndarray:
    if not len(bundle.motion.work):
        return np.zeros((len(times), 0))
    return bundle.works + np.outer(times, bundle.powers())


def nearness(run: Run) -> tuple[float, float, float]:
    """Slowest beginning of a contact, time between events of two contacts, gap left in flight.

    The smallest over the fastest, the period, and the clearance (of a test system 1); infinite where there
    are none. Events that can change places without a difference do not count.
    """
    model = run.model
    request = Request(run.end, run.rtol, events=True, misses=True, log_from=0.0, max_steps=run.limit)
    records = follow(model, request)
    events, misses = records.events, records.misses
    order = events[np.argsort(events[:, 2], kind="stable")]
    free = _exchangeable(model, order)
    apart = np.diff(order[:, 2])[(np.diff(order[:, 0]) != 0) & ~(free[1:] & free[:-1])]
    units = np.array(model.clearances or np.ones(len(model.joints) + len(model.resets)))
    soft = len(model.structure.soft_joints if model.links else model.joints)
    centred = np.isfinite(clearances_squared(model, soft))
    units[:soft] *= np.where(centred, 2 * units[:soft], 1.0)  # r^2 - e^2 is watched
    shares = np.abs(misses[:, 1]) / units[misses[:, 0].astype(int)]
    speeds = approach_speeds(model, np.insert(events, PLACE, 0.0, axis=1))[np.isin(events[:, KIND], BEGINS)]
    slowest = float(np.min(speeds / np.max(speeds, initial=0.0), initial=np.inf))
    nearest, closest = (float(np.min(each, initial=np.inf)) for each in (apart / model.period, shares))
    return slowest, nearest, closest


def _exchangeable(model: Model, events: np.ndarray) -> np.ndarray:
    """Whether each event is that of a gap alone, at which a force begins or ends that adds to the others.

    Two of these have one saltation matrix in either order: that of both is I plus both jumps of the rate, as
    a gap does not depend on speeds, and no force on what another contact does unless something sticks.
    """
    from jointplay.solver.method.modes import PULLS

    if not model.links:
        return np.zeros(len(events), dtype=bool)
    flags = np.array([*cache.structure_module(model.structure).CONTACTS.values()], dtype=int)
    pulls = np.append(flags & PULLS > 0, np.zeros(len(model.walls), dtype=bool))[events[:, 0].astype(int)]
    modes = events[:, 3 + len(model.state) :][:, : len(flags)]
    gap = np.isin(events[:, KIND], (Event.CONTACT, Event.SEPARATION))
    return pulls & gap & ~np.any(modes == Mode.STICK, axis=1)


class Peak(NamedTuple):
    """Time of an extreme value, its place (``within`` a piece, ``before`` an event, …), and its size."""

    time: float
    where: str
    value: float


def peak(model: Model, key: str, sign: float, end: float, turns: float, rtol: float, limit: int) -> Peak:
    """The largest value of sign times a quantity from time 0 to `end`.

    Raises
    ------
    ArithmeticError
        With the status, if the motion did not get there.
    """
    times = np.linspace(0.0, end, max(int(turns * SAMPLES), CLOSER))
    for _ in range(ROUNDS):
        records = _followed(model, end, rtol, times, limit)
        rows = np.concatenate([records.steps[:, 2:], records.samples])
        rows = rows[np.argsort(rows[:, 0], kind="stable")]
        found = sign * values(model, rows, key)
        top = int(np.nanargmax(found))
        at = float(rows[top, 0])
        low = rows[rows[:, 0] < at, 0].max(initial=0.0)
        high = rows[rows[:, 0] > at, 0].min(initial=end)
        times = np.unique(np.append(np.linspace(low, high, CLOSER), at))
    if np.any(records.events[:, 2] == at):
        sides = sign * values(model, records.steps[records.steps[:, 2] == at, 2:], key)
        first, last = np.abs(sides[[0, -1]] - found[top])
        return Peak(at, "before" if first <= last else "after", sign * float(found[top]))
    if at in (0.0, end):
        return Peak(at, "start" if at == 0.0 else "end", sign * float(found[top]))
    samples = _followed(model, end, max(SHARPER * rtol, LEAST), times, limit).samples
    place, most = _top(samples[:, 0], sign * values(model, samples, key), at)
    if abs(most - found[top]) > ASTRAY * abs(found[top]):  # another motion: this one depends on the tolerance
        place, most = at, found[top]
    return Peak(place, "within", sign * most)


def _followed(model: Model, end: float, rtol: float, times: np.ndarray, limit: int) -> Records:
    fields = {"steps": True, "events": True, "log_from": 0.0, "max_steps": limit}
    records = follow(model, Request(end, rtol, at=times, **fields))
    if records.status:
        raise ArithmeticError(records.status)
    return records


def _top(times: np.ndarray, found: np.ndarray, guess: float) -> tuple[float, float]:
    """Time and size of the largest value of the polynomial through the samples; the guess's if outside."""
    middle, half = (times[0] + times[-1]) / 2, (times[-1] - times[0]) / 2
    fit = np.polynomial.Polynomial.fit(times, found, DEGREE)
    roots = fit.deriv().roots()
    inside = np.real(roots[(abs(roots.imag) < 1e-6 * half) & (abs(roots.real - middle) <= half)])
    place = float(max(inside, key=fit, default=guess))
    return place, float(fit(place))


def values(model: Model, rows: np.ndarray, key: str) -> np.ndarray:
    """A quantity at rows (time, positions, speeds, modes)."""
    quantities = Quantities(model, rows, rows[0])
    found = outputs.evaluate(quantities.module, [key], quantities.given(rows))[key]
    return np.broadcast_to(found, len(rows))


def derivatives(
    model: Model, row: np.ndarray, key: str, dx: np.ndarray, dt: np.ndarray, directions: Directions
) -> np.ndarray:
    """Derivatives of a quantity at a row, as the state moves by dx (directions, states) and time by dt."""
    quantities = Quantities(model, row[None, :], row)
    module, given = quantities.module, dict(quantities.given(row[None, :]))
    for name, moves in zip(module.STATE, np.column_stack([dt, dx]).T, strict=True):
        given[name] = given[name] + 1j * STEP * moves
    for j, (names, rates) in enumerate(zip(directions.names, directions.rates_of, strict=True)):
        unit = 1j * STEP * (np.arange(len(dx)) == j)
        given |= {name: given[name] + unit * rate for name, rate in zip(names, rates, strict=True)}
    found = outputs.evaluate(module, [key], given | {"atan2": _atan2, "copysign": _copysign})[key]
    return np.broadcast_to(np.imag(found) / STEP, len(dx))


def _atan2(y: np.ndarray, x: np.ndarray) -> np.ndarray:
    a, b = np.real(x), np.real(y)
    return np.arctan2(b, a) + 1j * (a * np.imag(y) - b * np.imag(x)) / (a * a + b * b)


def _copysign(size: float, of: np.ndarray) -> np.ndarray:
    return np.copysign(size, np.real(of))
