"""The map of a section to itself by whole turns, with its derivative.

A linkage is cut at an angle of its crank, whose time of passage differs between neighbours; a forced system
at a phase of its forcing; any other system by a level of one of its states. With the flow's derivative M
over the turn's own time (through every event by its saltation matrix, method.tangents.tangent), the rate F of
the state at the end and the coordinate c that is fixed on the section,

    P = (I - F e_c^T / F_c) M,   its row and column c left out;

of a forced system P = M. A start at another phase begins at that phase's time.

With directions in which parameters change (analysis.gradients) the flow's derivative Y in them gives

    dP/dp = (I - F e_c^T / F_c) Y,  dT/dp = -Y_c / F_c;      of a forced system dP/dp = Y + F dT/dp,

at a fixed start on the section; Y = -F dt/dp where a run that begins at another time t begins.

Reference: Parker and Chua, Practical Numerical Algorithms for Chaotic Systems (1989), chapters 2 and 5.
Validity: the section must be crossed, not touched (F_c != 0), and away from events that jump.

Events of a periodic orbit, the speed of approach to each, and the closest approach to others.

An event is about to vanish where its approach speed goes to 0, and another about to appear where the
distance of an open contact (or of a closed one from opening) has a minimum that goes to 0: grazing.
Rows of events are those of `section_map.Image`: contact, kind, place in the orbit, time, state, modes.
"""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass, replace
from functools import cached_property
from types import SimpleNamespace

import numpy as np

from jointplay.analysis import rules
from jointplay.analysis.contacts import approach
from jointplay.analysis.evaluate import resolved
from jointplay.analysis.quantities import STATUS
from jointplay.analysis.starts import crank_place, state_names
from jointplay.analysis.tangents import Bundle, scales
from jointplay.solver.mechanism.directions import Directions
from jointplay.solver.mechanism.model import Model
from jointplay.solver.mechanism.records import Plane, Section
from jointplay.solver.method.codes import Event, Row
from jointplay.solver.motion.trajectory import Request

LONGEST = 400  # nominal periods in which a system that nothing drives must come back to a plane
AT_REST = 1e-6  # of a state's scale: an equilibrium moves less in a return, at its rate of passage
FAILED = STATUS.index("not_converged")

OF_GAPS = (Event.IMPACT, Event.CONTACT, Event.SEPARATION, Event.REOPENING)  # causes before effects
BEGINS = (Event.CONTACT, Event.IMPACT)
CONTACT, KIND, PLACE, TIME = range(4)


@dataclass(frozen=True)
class SectionMap:
    """Whole turns of a model, as a map of a section to itself.

    Parameters
    ----------
    model : Model
        Assembled with the section's quantity.
    turns : int
        Of the crank, periods of the forcing, or crossings of the plane.
    phase : float
        Crank angle or phase of the forcing, rad; or the plane's level.
    place : int, optional
        Index of the coordinate that is fixed on the section; None where time is (forcing, prescribed crank).
    direction : int
        Sense of turning, or of crossing.
    plane : bool
        Whether `phase` is a level of a state, and not an angle that increases by whole turns.
    rtol : float
        Relative tolerance of a step.
    max_steps : int, optional
        Attempted steps after which a run stops.
    units : ndarray, optional
        Sizes of the states, as `scale`; the model's own if left out.
    """

    model: Model
    turns: int
    phase: float
    place: int | None
    direction: int = 1
    plane: bool = False
    rtol: float = 1e-11
    max_steps: int | None = None
    units: np.ndarray | None = None

    @cached_property
    def scale(self) -> np.ndarray:
        """Size of each state: a radian or the longest link, the nominal speed."""
        return scales(self.model) if self.units is None else self.units

    @cached_property
    def free(self) -> np.ndarray:
        """Indices of the coordinates that are not fixed on the section."""
        return np.array([i for i in range(len(self.model.state)) if i != self.place])

    @property
    def begin(self) -> float:
        """Time at which a run on the section begins, s: of a forcing, that of the phase."""
        model = self.model
        if self.place is not None or not model.crank_speed:  # nothing tells the time
            return 0.0
        return ((self.phase - model.crank_angle) / model.crank_speed) % model.period

    def unknowns(self, state: np.ndarray) -> np.ndarray:
        """The free coordinates in units of their scales."""
        return state[self.free] / self.scale[self.free]

    def state(self, unknowns: np.ndarray) -> np.ndarray:
        """The state on the section that has these free coordinates."""
        state = np.zeros(len(self.model.state))
        state[self.free] = unknowns * self.scale[self.free]
        if self.place is not None:
            state[self.place] = self.phase
        return state

    def image(
        self,
        state: np.ndarray,
        derivative: bool = True,
        turns: int | None = None,
        directions: Directions | None = None,
    ) -> Image:
        """Image of a state on the section, with the derivative or without; over the map's turns or others.

        With `directions` (`mechanism.directions.along`, whose `begin` is `SectionMap.begin` of that value's
        map) also the derivatives in parameters.
        """
        turns = self.turns if turns is None else turns
        image = self._followed(state, 0.0, turns, derivative, directions)
        return image if image.status else replace(image, state=self._wrapped(image.state, state))

    def moved(self, state: np.ndarray, ahead: float) -> tuple[SectionMap, Image]:
        """The map of the section `ahead` rad on (0 to 2 pi), and the image of a state followed to there."""
        image = self._followed(state, ahead, 0, False)
        other = replace(self, phase=self.phase + self.direction * ahead)
        other, state = other.within_a_turn(image.state)
        return other, replace(image, state=state)

    def within_a_turn(self, state: np.ndarray) -> tuple[SectionMap, np.ndarray]:
        """The same section and state with the phase brought back to the first turn."""
        phase = self.phase % math.tau
        if self.place is not None:
            state = state.copy()
            state[self.place] = phase
        return replace(self, phase=phase), state

    def differ(self, one: np.ndarray, other: np.ndarray) -> np.ndarray:
        """Difference of two states on the section: free coordinates, angles to whole turns, in scales."""
        return self.unknowns(self._wrapped(one, other) - other)

    def _wrapped(self, state: np.ndarray, near: np.ndarray) -> np.ndarray:
        """State with angles brought to within half a turn of another's."""
        state = state.copy()
        turning = np.flatnonzero(self.model.fold)
        state[turning] -= math.tau * np.round((state[turning] - near[turning]) / math.tau)
        if self.place is not None:
            state[self.place] = self.phase
        return state

    def _followed(
        self,
        state: np.ndarray,
        ahead: float,
        turns: int,
        derivative: bool,
        directions: Directions | None = None,
    ) -> Image:
        """Follow a state to the section `ahead` rad and whole turns on."""
        lost, end = np.full_like(state, np.nan), self.begin + (turns + ahead / math.tau) * self.model.period
        if self.place is not None:
            passages, events, status = self._crossings(state, ahead, turns)
            if status:
                return Image(status, lost)
            end = float(passages[-1, 0])
            if not derivative and directions is None and not self.plane:
                events = self._placed(events[events[:, 2] <= end], end - self.begin)
                return Image(0, passages[-1, 1 : 1 + len(state)], end - self.begin, None, events)
        frame = np.eye(len(state)) if derivative else np.zeros((0, len(state)))
        request = self.request(end, events=True, log_from=0.0)
        bundle, rows, status = self.run(state, request, frame, directions)
        if status:
            return Image(status, lost)
        span, reached, rate = end - self.begin, bundle.state, bundle.rate()
        if self.place is not None:  # the passage, to rounding
            if abs(rate[self.place]) * span < AT_REST * self.scale[self.place]:
                return Image(FAILED, lost)
            late = (reached[self.place] - self._target(ahead, turns)) / rate[self.place]
            reached, span = reached - late * rate, span - late
        events = self._placed(rows[rows[:, 0] == Row.EVENT, 1:], span)
        M, n_x = bundle.vectors.T, len(frame)
        P = self._projected(M[:, :n_x], rate) if derivative else None
        image = Image(0, reached, span, P, events, bundle.grazing)
        if directions is None:
            return image
        along, times = self._along(M[:, n_x:], rate, directions, turns + ahead / math.tau)
        return replace(image, along=along, times=times)

    def _along(
        self, Y: np.ndarray, rate: np.ndarray, directions: Directions, turns: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives of the image and of its duration in parameters."""
        if self.place is not None:
            times = ends = -Y[self.place] / rate[self.place]
        else:
            times = turns * directions.periods
            ends = times + directions.begins
        return (Y + np.outer(rate, ends))[self.free] / self.scale[self.free, None], times

    def _target(self, ahead: float, turns: int) -> float:
        return self.phase if self.plane else self.phase + self.direction * (ahead + turns * math.tau)

    def _placed(self, events: np.ndarray, span: float) -> np.ndarray:
        """Events with their places in a span, from 0 to 1, ahead of their times."""
        return np.insert(events, 2, (events[:, 2] - self.begin) / span, axis=1)

    def _crossings(
        self, state: np.ndarray, ahead: float, turns: int, sharp: bool = False
    ) -> tuple[np.ndarray, np.ndarray, int]:
        """Rows (time, state, modes) of the passages of the section `ahead` rad on, each turn's; events."""
        level, period, count = self.phase, 0.0, turns
        if not self.plane:
            first = 0 if ahead else 1
            level, period, count = self._target(ahead, first), math.tau, turns - first + 1
        longest = (LONGEST if self.plane else rules.SLACK) * (turns + 1) * self.model.period
        fields = {"level": level, "period": period, "direction": self.direction, "stop_after": count}
        request = self.request(longest, rates=sharp, events=True, log_from=0.0, **fields)
        _, rows, status = self.run(state, request, np.zeros((0, len(state))))
        coarse, crossings = rows[rows[:, 0] == Row.COARSE, 1:], rows[rows[:, 0] == Row.SECTION, 3:]
        crossings = resolved(self.model, self.rtol, coarse, crossings)[0][:count]
        # fewer of them: it never came back
        return crossings, rows[rows[:, 0] == Row.EVENT, 1:], status or FAILED * (len(crossings) < count)

    def passages(self, state: np.ndarray, sharp: bool = False) -> tuple[np.ndarray, int]:
        """Rows (time, state, modes) at the ends of the turns that begin on the section, and the status.

        `sharp`: states whose accelerations are resolved (analysis.evaluate).
        """
        if self.place is not None:
            return self._crossings(state, 0.0, self.turns, sharp)[::2]
        times = self.begin + np.arange(1, self.turns + 1) * self.model.period
        return self.sampled(state, times, sharp)

    def sampled(self, state: np.ndarray, times: np.ndarray, sharp: bool) -> tuple[np.ndarray, int]:
        """Rows at some times, and the status; sharp as in `passages`."""
        request = self.request(float(times[-1]), at=times, rates=sharp)
        bundle, rows, status = self.run(state, request, np.zeros((0, len(state))))
        (samples,) = resolved(
            self.model, self.rtol, rows[rows[:, 0] == Row.COARSE, 1:], bundle.motion.samples
        )
        return samples, status

    def request(self, end: float, **fields) -> Request:
        """Request for a run with the map's tolerance and limit of steps."""
        return Request(end, self.rtol, max_steps=rules.steps(self.max_steps), **fields)

    def run(
        self,
        state: np.ndarray,
        request: Request,
        frame: np.ndarray,
        directions: Directions | None = None,
        until: float = math.inf,
    ) -> tuple[Bundle, np.ndarray, int]:
        """Follow a state from the section on: the run at its end, the rows of its log, and its status.

        The start is the section's: that of the directions is of no account. `until`: a time before the end
        at which the run stops, to go on by `Bundle.advance`.
        """
        from jointplay.solver.method.memory import LOGGED

        model, driven = replace(self.model, state=state), directions
        if directions is not None:
            driven = replace(directions, starts=np.zeros_like(directions.starts))
        bundle = Bundle(model, request, frame, held=True, directions=driven)
        motion, parts, status = bundle.motion, [], bundle.full
        motion.s[0] = self.begin
        if directions is not None and np.any(directions.begins):
            bundle.advance(self.begin)  # no step: the modes of the start
            bundle.shift(-directions.begins)
        while status == bundle.full:
            status = bundle.advance(until)
            parts.append(motion.log[: motion.count[LOGGED]].copy())
            motion.count[LOGGED] = 0
        return bundle, np.concatenate(parts), status

    def _projected(self, M: np.ndarray, rate: np.ndarray) -> np.ndarray:
        if self.place is not None:
            M = M - np.outer(rate, M[self.place]) / rate[self.place]
        M = M * (np.arange(len(M)) < len(M) - len(self.model.modes))  # nothing near has other modes
        scale = self.scale[self.free]
        return M[np.ix_(self.free, self.free)] * scale / scale[:, None]


def section_map(
    model: Model, section: Section, turns: int, rtol: float = 1e-11, max_steps: int | None = None
) -> SectionMap:
    """The map of a model's section over some turns; of a plane its quantity is a state of a test system."""
    if isinstance(section, Plane):
        sense = 1 if section.direction == "up" else -1
        place = state_names(model).index(section.quantity)
        return SectionMap(model, turns, section.value, place, sense, True, rtol, max_steps)
    phase = section.angle % math.tau
    return SectionMap(model, turns, phase, crank_place(model), model.forward, False, rtol, max_steps)


@dataclass(frozen=True)
class Image:
    """Result of applying a section map to a state.

    Parameters
    ----------
    status : int
        Index into `STATUS`; all else is meaningless unless it is 0.
    state : ndarray
        State at the end, angles brought back by whole turns to near the start's.
    time : float
        Duration, s.
    derivative : ndarray
        Of the free coordinates with respect to themselves, in units of their scales.
    events : ndarray
        Rows: contact, kind, time since the start over the duration, time, positions, speeds, modes.
    grazing : float
        Smallest approach speed of a guard at an event, relative to the terms that it is a sum of.
    along : ndarray
        Derivatives of the free coordinates, in units of their scales, in parameters: a column each.
    times : ndarray
        Derivatives of the duration in these.
    """

    status: int
    state: np.ndarray
    time: float = math.nan
    derivative: np.ndarray | None = None
    events: np.ndarray | None = None
    grazing: float = math.inf
    along: np.ndarray | None = None
    times: np.ndarray | None = None


def _counts(events: np.ndarray) -> Counter:
    """Number of events of each contact and kind."""
    return Counter((int(row[CONTACT]), int(row[KIND])) for row in events)


def same_events(one: np.ndarray, other: np.ndarray) -> bool:
    """Whether two orbits have the same events, in whichever order."""
    return _counts(one) == _counts(other)


def changed_event(one: np.ndarray, other: np.ndarray) -> tuple[int, int]:
    """Contact and kind of an event of which one orbit has more than the other; (-1, -1) if there is none.

    Of two that appear together, which are the nearest to each other, the first.
    """
    first, second = _counts(one), _counts(other)
    differing = (first - second) + (second - first)
    rank = {kind: i for i, kind in enumerate(OF_GAPS)}
    event = min(differing, key=lambda pair: (rank.get(pair[1], len(rank)), pair), default=(-1, -1))
    rows = one if len(one) > len(other) else other
    of_contact = [(event[0], int(kind)) in differing for kind in rows[:, KIND]] if len(rows) else []
    near = rows[np.array(of_contact, dtype=bool) & (rows[:, CONTACT] == event[0])]
    if len(near) < 2 or sum(differing.values()) < 2:
        return event
    near = near[np.argsort(near[:, PLACE])]
    apart = np.mod(np.roll(near[:, PLACE], -1) - near[:, PLACE], 1.0)
    return event[0], int(near[np.argmin(apart), KIND])


def gaps(model: Model, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Gaps (negative: penetration, m) and closing speeds (m/s) at rows of time, state, modes."""
    return approach(model, SimpleNamespace(start=rows[0] if len(rows) else np.zeros(0)), rows)


def approach_speeds(model: Model, events: np.ndarray) -> np.ndarray:
    """Speed at which the gap changes at each event, m/s; NaN at events that no gap makes, as jumps are."""
    if not len(events):
        return np.zeros(0)
    _, rates = gaps(model, events[:, TIME:])
    speeds = np.abs(rates[np.arange(len(events)), events[:, CONTACT].astype(int)])
    closes = np.isin(events[:, KIND], OF_GAPS) & np.isin(events[:, CONTACT], model.gaps)
    return np.where(closes, speeds, np.nan)


def smallest_impact_speed(model: Model, events: np.ndarray) -> float:
    """Smallest speed with which contact begins, m/s; NaN where none does."""
    speeds = approach_speeds(model, events[np.isin(events[:, KIND], BEGINS)])
    return float(np.nanmin(speeds)) if np.isfinite(speeds).any() else np.nan


def closest_approach(values: np.ndarray, events: np.ndarray) -> float:
    """Smallest local minimum of the distance from touching or from opening, m; NaN if there is none.

    Parameters
    ----------
    values : ndarray, shape (samples, contacts)
        Gaps over a whole period in even steps. Minima are those of the parabola through three samples.
    events : ndarray
        Of the orbit: at an event of a contact its gap has no minimum.
    """
    size, count = np.abs(values), len(values)
    before, after = np.roll(size, 1, axis=0), np.roll(size, -1, axis=0)
    minimal = (size <= before) & (size < after)
    for row in events:
        at = int(row[PLACE] * count)
        minimal[np.arange(at - 1, at + 3) % count, int(row[CONTACT])] = False
    if not minimal.any():
        return np.nan
    lowest, _ = vertex(before[minimal], size[minimal], after[minimal])
    return float(max(0.0, lowest.min()))


def vertex(before: np.ndarray, here: np.ndarray, after: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Extremum of the parabola through three samples, and its distance after the middle one, in samples."""
    slope, bend = (after - before) / 2, before - 2 * here + after
    return here - slope**2 / (2 * bend), -slope / bend


def free_phase(events: np.ndarray, turns: int) -> tuple[float, float]:
    """Place in a turn (0 to 1 from the section) farthest from events, and the nearest event's distance."""
    places = np.sort(np.mod(events[:, PLACE] * turns, 1.0)) if len(events) else np.zeros(0)
    if not len(places):
        return 0.0, 1.0
    nearest = float(min(places[0], 1.0 - places[-1]))
    widths = np.diff(np.append(places, places[0] + 1.0))
    widest = int(np.argmax(widths))
    return float((places[widest] + widths[widest] / 2) % 1.0), nearest
