"""Values of a parameter at which the motion of a linkage changes, from its present value outward.

The settled motion is followed from value to value, each from the end of the one before, in even steps of the
logarithm. One of the neighbour's period is taken as soon as a few turns repeat. Where they do not yet, it is
followed to its end, and more values beside it are looked at: the slower a motion settles, the nearer it is to
the end of its stability, and so a window narrower than a step is met. What has not settled to the neighbour's
period in the end has it nevertheless where the periodic orbit, found from the neighbour, is stable. In chaos,
and beyond the end of period 1, steps are longer; in chaos each motion has to last for some hundred turns.

Where a trait (`settled`) first differs, the step is halved until the two motions that differ are `accuracy`
apart: they enclose the edge. Chaos beside it has to be lasting; where it is not, the edge lies farther back.
Chaos is full of periodic windows, most of them narrower than any step. A change of a chaotic motion is an
edge only if it lasts over a share of the parameter, from where it begins; and where chaos ends so, whatever
else has changed is one, too. Else it is a window, whose two ends are enclosed.
Loss of contact and loss of period 1 are then located on the periodic orbit itself, by `continuation` across
that bracket: the grazing at which a separation appears, the multiplier through -1, the fold. A fold counts
where the motion that is carried over it has another period: there it jumps. Chaos has no such point: brackets
stand. A motion without a period may lose contact now and then: that edge is `irregular`, where it was first
seen in the turns followed. As long as the walk goes on beyond an edge, it looks for the trait's return.

Validity: what begins and ends between two steps is not seen, and a motion that coexists with the one followed
is another one.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from jointplay.analysis.assessment.settled import (
    CHANGES,
    LASTING,
    ONCE_A_TURN,
    Settled,
    Unsettled,
    followed,
    lasting,
    settled,
)
from jointplay.analysis.orbits.branch_points import KINDS as SPECIAL
from jointplay.analysis.orbits.continuation import continuation
from jointplay.analysis.orbits.orbit_dataset import STABILITY
from jointplay.analysis.orbits.orbit_events import OF_GAPS
from jointplay.analysis.orbits.periodic_orbit import periodic_orbit
from jointplay.analysis.period import REPEATS
from jointplay.analysis.sweeps.attractor import Plan
from jointplay.display.errors import InputError
from jointplay.solver.mechanism.parameters import Parameter
from jointplay.solver.mechanism.records import Mechanism
from jointplay.solver.method.codes import Status

if TYPE_CHECKING:
    import xarray as xr

SIDES = {"below": -1, "above": 1}
HOW = ("not_met", "bracketed", *SPECIAL, "irregular")
CARRIED = 0.3  # of the transient and of an exponent's turns, for a motion that begins from its neighbour's
QUICK, REPEATED = 0.25, 8  # of the transient; turns that then repeat, at least, of a motion that settles fast
LONG = 2  # steps at once where the motion that is left has lost period 1 already
PINPRICK, WIDENED, HALVED = 1e-5, 4.0, 4  # first relative distance to a window's end; factor; halvings then
PROBES = 4  # distances, at least, over the share that a change of a chaotic motion has to last
CHAOTIC = 10  # steps at once where the present motion is chaotic; its edges are enclosed to one step
NARROW = 4  # values in a step beside which a motion settles slowly
WIDER = 5.0  # brackets beyond each end in which a branch is searched: motions settle slowly beside an edge
BEYOND = 0.1  # likewise where the orbit is stable, and what ends that lies between
RTOL, STEP, POINTS = 1e-10, 0.2, 24  # of the branch: there may be dozens of grazings on it, and each costs
Place = tuple[float, Settled]
LEAVES = {"contact_loss": ("grazing",), "doubling": tuple(kind for kind in SPECIAL if kind != "grazing")}


@dataclass(frozen=True)
class Search:
    """Settings of a search: its reach, as a factor; `step`, `accuracy` and `lasting` are relative."""

    reach: float
    step: float
    accuracy: float
    lasting: float = 0.01

    def of(self, motion: Settled) -> Search:
        """The search that a motion calls for: no finer in chaos than its windows make sense of."""
        if motion.period:
            return self
        return replace(self, step=CHAOTIC * self.step, accuracy=max(self.accuracy, self.step))

    def values(self, begin: float, way: int) -> np.ndarray:
        """Values after the first, in even steps of the logarithm."""
        count = math.ceil(math.log(self.reach) / math.log1p(self.step))
        return np.geomspace(begin, begin * self.reach**way, count + 1)[1:]


class Stretch(NamedTuple):
    """A change that is taken back before it has lasted: its two ends, its period, the place beyond."""

    low: float
    high: float
    period: int
    back: Place


@dataclass
class Walk:
    """The settled motion along one parameter."""

    mechanism: Mechanism
    key: str
    how: Plan
    known: dict[tuple[float, Settled], Settled] = field(default_factory=dict)
    lasts: dict[Settled, Settled] = field(default_factory=dict)
    stretches: dict[tuple[Settled, str], Stretch | None] = field(default_factory=dict)

    @property
    def quick(self) -> Plan:
        """Settings of motions that are to settle fast."""
        return replace(self.how, transient=round(QUICK * self.how.transient), turns=REPEATED)

    @property
    def carried(self) -> Plan:
        """Settings of motions that begin near the one they settle to."""
        turns = max(round(CARRIED * self.how.lyapunov_turns), 1)
        return replace(self.how, transient=round(CARRIED * self.how.transient), lyapunov_turns=turns)

    def at(self, value: float, before: Settled) -> Settled:
        """The motion at a value, from the end of another one."""
        at = float(value), before  # edges of several traits in one step begin with the same motions
        if at not in self.known:
            here = self.mechanism.varied({self.key: at[0]})
            found = followed(here, before.end, self.quick) if _brief(before) else None
            if found is None or found.traits != before.traits or found.period != before.period:
                found = settled(here, before.end, self.carried, before.period)
                if _brief(before) and found.period != before.period:
                    found = self._kept(here, before) or found
                found = replace(found, slow=True)
            self.known[at] = found
        return self.known[at]

    def lasting(self, place: Place) -> Place:
        """A place with the motion that its own is in the end."""
        if place[1] not in self.lasts:
            self.lasts[place[1]] = lasting(place[1], self.how)
        return place[0], self.lasts[place[1]]

    def chaotic(self, value: float, before: Settled) -> Place:
        """The motion at a value, from the end of another one, with chaos that has not died out soon."""
        motion = self.at(value, before)
        return value, motion if motion.period else lasting(motion, self.how, LASTING[:1])

    def stretch(self, last: Place, place: Place, name: str, share: float) -> Stretch | None:
        """The stretch about a place in which a trait is not as at the one before; None where it lasts.

        That is over a `share` of the parameter from where it begins, which is beyond the one before.
        """
        asked = place[1], name
        if asked not in self.stretches:
            self.stretches[asked] = self._stretch(last, place, name, share)
        return self.stretches[asked]

    def _stretch(self, last: Place, place: Place, name: str, share: float) -> Stretch | None:
        way = 1 if abs(place[0]) > abs(last[0]) else -1
        long, since = math.log1p(share), abs(math.log(place[0] / last[0]))
        back = self._end(place, name, way, share)
        begin = back and self._end(place, name, -way, min(share, math.expm1(since)))
        if not back or (not begin and since > long):
            return None
        start = begin[0] if begin else last[0]
        if abs(math.log(back[0] / start)) > long:
            return None
        return Stretch(*sorted((start, back[0]), key=abs), place[1].period, back[1])

    def _end(self, place: Place, name: str, way: int, share: float) -> tuple[float, Place] | None:
        """End of a trait from a place on: the value, and the place met there; None if not within a share."""
        inner = outer = place
        for distance in _distances(share):
            inner, outer = outer, self.chaotic(place[0] * (1 + distance) ** way, outer[1])
            if outer[1].traits[name] != place[1].traits[name]:
                break
        else:
            return None
        met = outer
        for _ in range(HALVED):
            middle = self.chaotic((inner[0] + outer[0]) / 2, inner[1])
            same = middle[1].traits[name] == place[1].traits[name]
            inner, outer = (middle, outer) if same else (inner, middle)
        return (inner[0] + outer[0]) / 2, met

    def _kept(self, here: Mechanism, before: Settled) -> Settled | None:
        """The motion of the same period if its orbit is stable yet: it may take thousands of turns."""
        orbit = self.orbit(here, before)
        if int(orbit["stable"]) != 1:
            return None
        motion = followed(here, before.end._replace(state=orbit["orbit_state"].values), self.quick)
        return motion if motion.period == before.period else None

    def orbit(self, here: Mechanism, near: Settled) -> xr.Dataset:
        """The periodic orbit found from where a motion ended, as of `periodic_orbit`."""
        start, limit = tuple(map(float, near.end.state)), self.how.max_steps
        given = {"period": near.period, "initial": start, "transient": 0, "rtol": RTOL, "max_steps": limit}
        return periodic_orbit(here, ONCE_A_TURN, **given)

    def towards(self, value: float, last: Place) -> Iterator[Place]:
        """The motion at a value; before it others on the way, where one of the two settles slowly."""
        at = self.at(value, last[1])
        if _brief(last[1]) and (at.slow or last[1].slow):
            for between in np.geomspace(last[0], value, NARROW + 1)[1:-1]:
                last = float(between), self.at(between, last[1])
                yield last
            at = self.at(value, last[1])
        yield value, at


def _distances(share: float) -> np.ndarray:
    """Relative distances up to a share: from a pinprick on, then evenly."""
    even = share * np.arange(1, PROBES + 1) / PROBES
    count = max(math.ceil(math.log(even[0] / PINPRICK, WIDENED)), 0)
    return np.append(PINPRICK * WIDENED ** np.arange(count), even)


def _brief(motion: Settled) -> bool:
    """Whether a motion's period is short enough to be seen in few turns."""
    return 0 < motion.period <= REPEATED // REPEATS


def edges(mechanism: Mechanism, key: str, side: str, start: Any, search: Search, how: Plan) -> dict[str, Any]:
    """Find the first change of each kind on one side of the present value of a parameter.

    Returns
    -------
    dict
        ``status``; ``limit``, the last value looked at; ``looked``, their number; and over `CHANGES`:
        ``edge`` (NaN: not met), its ``error``, ``low`` and ``high``, settled motions that differ and the edge
        between them, ``back``, where it is first as at present again (NaN: not met), and ``how``, an index
        into `HOW`. ``windows``: low and high end, and period, of each window in chaos that was met.
    """
    walk, begin = Walk(mechanism, key, how), float(Parameter(mechanism, key).value)
    found = {name: (math.nan,) * 5 + (HOW.index("not_met"),) for name in CHANGES}
    limit, looked, status, trouble, windows = begin, 0, 0, "", {}
    try:
        here = lasting(settled(mechanism, start, how), how)
        trail, search = [(begin, here)], search.of(here)
        walk.lasts[here] = here
        values = search.values(begin, SIDES[side])
        while len(values) and not all(each[-1] for each in found.values()):
            for place in walk.towards(float(values[0]), trail[-1]):
                if not here.period:
                    place = place[0], lasting(place[1], how, LASTING[:1])
                if any(_changed(found[name], place, here, name) for name in CHANGES):
                    place = walk.lasting(place)
                limit, looked, last = place[0], looked + 1, place
                for name in CHANGES:
                    if not _changed(found[name], place, here, name):
                        continue
                    if found[name][-1]:
                        found[name] = (*found[name][:-2], place[0], found[name][-1])
                    elif window := _window(walk, name, trail[-1], place, here, search):
                        last = window.back
                        windows |= {} if place[1].traits["chaos"] else {limit: window[:3]}
                    else:
                        found[name] = _located(walk, name, trail, place, here, search)
                trail.append(last)
            steps = LONG if found["doubling"][-1] and here.period else 1
            values = values[min(steps, max(len(values) - 1, 1)) :]  # the last one is looked at in any case
            values = values[np.abs(values / begin - 1) > abs(last[0] / begin - 1)]  # beyond a window
    except Unsettled as error:
        status, trouble = error.status, Status(error.status).meaning
    except InputError as error:
        status, trouble = int(Status.BAD_PARAMETERS), str(error)
    columns = np.array([found[name] for name in CHANGES]).T
    names = ("edge", "error", "low", "high", "back", "how")
    ended = {"status": status, "trouble": trouble, "limit": limit, "looked": looked}
    ended["windows"] = list(windows.values())
    return ended | dict(zip(names, columns, strict=True))


def _changed(found: tuple[float, ...], place: Place, here: Settled, name: str) -> bool:
    """Whether a place is the first beyond a change, or the first beyond its return."""
    same = place[1].traits[name] == here.traits[name]
    return math.isnan(found[-2]) and same == bool(found[-1])


def _window(
    walk: Walk, name: str, last: Place, place: Place, here: Settled, search: Search
) -> Stretch | None:
    """The window in chaos around a place; other changes in it without chaos are part of it."""
    if here.period or last[1].period:
        return None
    return walk.stretch(last, place, name if place[1].traits["chaos"] else "chaos", search.lasting)


def _located(
    walk: Walk, name: str, trail: list[Place], first: Place, here: Settled, search: Search
) -> tuple[float, ...]:
    """Edge, error, bracket, no return yet and index into `HOW` of a change at the end of a trail."""
    for last in map(walk.lasting, reversed(trail)):  # the first one differs from what lies beyond the change
        if last[1].traits[name] != first[1].traits[name]:
            break
        first = last
    last, first = _bracket(walk, name, last, first, here, search)
    accuracy = search.accuracy
    low, high = sorted((last[0], first[0]))
    for place, other in ((last, first), (first, last)):  # chaos has no orbit to follow; else that side's
        if name in LEAVES and place[1].period == 1:
            if special := _special(walk, name, place, other, accuracy):
                edge, error, kind = special
                return edge, error, min(low, edge), max(high, edge), math.nan, HOW.index(kind)
            break
    how = "irregular" if name == "contact_loss" and not first[1].period else "bracketed"
    return (low + high) / 2, (high - low) / 2, low, high, math.nan, HOW.index(how)


def _bracket(
    walk: Walk, name: str, last: Place, first: Place, here: Settled, search: Search
) -> tuple[Place, Place]:
    """Halve the distance of two motions that differ in a trait, followed from the first one."""
    while abs(first[0] - last[0]) > search.accuracy * abs(first[0]):
        value = (first[0] + last[0]) / 2
        middle = walk.lasting((value, walk.at(value, last[1])))
        same = middle[1].traits[name] == last[1].traits[name]
        window = None if same else _window(walk, name, last, middle, here, search)
        if same:
            last = middle
        elif window and abs(window.back[0] - value) < abs(first[0] - value):  # before the edge
            last = window.back
        else:
            first = middle
    return last, first


def _special(
    walk: Walk, name: str, place: Place, other: Place, accuracy: float
) -> tuple[float, float, str] | None:
    """Value, accuracy and kind of the special point of a place's orbit at which it changes to the other.

    Stability is lost between the two; or behind the place, where it is lost there already and slow to show.
    """
    value, motion = place
    low, high = sorted((value, other[0]))
    stable = name == "doubling" and STABILITY[int(walk.orbit(motion.mechanism, motion)["stable"])]
    wide = (BEYOND if stable == "stable" else WIDER) * (high - low)
    branch = continuation(
        motion.mechanism,
        ONCE_A_TURN,
        parameter=walk.key,
        range=(low - wide, high + wide),
        start=value,
        initial=tuple(map(float, motion.end.state)),
        transient=0,
        step=STEP,
        max_points=POINTS,
        branch_switching=False,
        rtol=RTOL,
        record=(),
        max_steps=walk.how.max_steps,
    )
    kinds = [SPECIAL[code] for code in branch["special_kind"].values]
    of_gaps = np.isin(branch["special_event_kind"].values, OF_GAPS) | (np.array(kinds) != "grazing")
    fits = np.isin(kinds, LEAVES[name]) & of_gaps
    places, way = branch["special_parameter"].values, math.copysign(1.0, other[0] - value)
    begin = (low + high) / 2
    if name == "doubling":
        begin, ahead = value, way * (places - value)
        between = (ahead >= 0) & (ahead <= high - low)
        fits &= {"stable": between, "unstable": ahead <= 0}.get(stable, True)
    for i in sorted(np.flatnonzero(fits), key=lambda i: abs(places[i] - begin)):
        edge = float(places[i])
        if kinds[i] != "fold" or walk.at(edge + way * accuracy * abs(edge), motion).period != 1:
            return edge, float(branch["special_accuracy"].values[i]), kinds[i]
    return None
