"""Values of a parameter at which the motion of a linkage changes, from its present value outward.

A periodic motion is followed as an orbit (`branch_walk`): where the orbit first loses or keeps contact, and
where it loses its stability or ends, a change is enclosed on the orbit itself. Beyond an end the motion that
follows is looked at, and if its period is another one, those at `PROBES` places of the share over which a
change has to last: one that soon has the same period ends a window. Else the first and the last of them are
settled. A motion of the same period is followed on: a jump to it is no change. If not, as many as `BEYOND`
motions on the rest of the way, each from the last orbit, say what there is, and where a trait
(`settled`) first differs between two of them the step is halved.

A motion without a period is carried from value to value in longer steps. Chaos has to be lasting; where it is
not, the edge lies farther back. Chaos is full of periodic windows, most of them narrower than any step. A
change of a chaotic motion is an edge only if it lasts over a share of the parameter, from where it begins;
and where chaos ends so, whatever else has changed is one, too. Else it is a window, whose two ends are
enclosed once, whatever else changes in it. Chaos has no orbit to follow: brackets stand. A motion without a
period may lose contact now and then: that edge is `irregular`, where it was first seen in the turns followed.

A change that is taken back within a share of the parameter is a window there too, and no edge.

Validity: what begins and ends between two values is not seen, and a motion that coexists with the one
followed is another one.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from jointplay.analysis.assessment.branch_walk import SHORTEST, Branch, Place, Walk, kind_of
from jointplay.analysis.assessment.settled import (
    CHANGES,
    LASTING,
    Remembering,
    Settled,
    Unsettled,
    followed,
    lasting,
    log_distance,
    settled,
)
from jointplay.analysis.exponents.frame_growth import followed_together
from jointplay.analysis.orbits.branch_points import KINDS as SPECIAL
from jointplay.analysis.sweeps.attractor import Plan
from jointplay.display.errors import InputError
from jointplay.solver.mechanism.parameters import Parameter
from jointplay.solver.mechanism.records import Mechanism
from jointplay.solver.method.codes import Status
from jointplay.solver.motion.eligibility import batch
from jointplay.solver.motion.progress import OutOfTime, stands

SIDES = {"below": -1, "above": 1}
SENSES = {"below": "downward", "above": "upward"}
HOW = ("not_met", "bracketed", *SPECIAL, "irregular")
CARRIED = 0.3  # of the transient and of an exponent's turns, for a motion that begins from its neighbour's
PINPRICK, WIDENED, HALVED = 1e-5, 4.0, 4  # first relative distance to a window's end; factor; halvings then
NOT_MET = (math.nan,) * 5 + (HOW.index("not_met"),)
PROBES = 4  # distances, at least, over the share that a change has to last
CHAOTIC = 5  # steps at once where the present motion is chaotic; its edges are enclosed to half a step
BEYOND = 40  # motions beyond the end of the orbit, at most
SURE = ("period_doubling", "neimark_sacker")  # ends of an orbit behind which none of its period is near
ENDED = "ended"  # an orbit that is not found farther on, which says nothing of what follows
BRANCHES = 12  # orbits of one period that are followed, one after another

Spot = tuple[float, Settled]
BranchEnd = tuple[Spot, float, float, str]  # last motion, up to where it is sure, where it has ended, how


@dataclass(frozen=True)
class Search:
    """Settings of a search: its reach, as a factor; `step`, `accuracy` and `lasting` are relative."""

    reach: float
    step: float
    accuracy: float
    lasting: float = 0.01

    def values(self, begin: float, sense: int) -> np.ndarray:
        """Values after the first, in even steps of the logarithm."""
        count = math.ceil(math.log(self.reach) / math.log1p(self.step))
        return np.geomspace(begin, begin * self.reach**sense, count + 1)[1:]


class Looked(NamedTuple):
    """A value looked at: the traits of its motion, its period, and its state at crank angle 0."""

    value: float
    traits: dict[str, bool]
    period: int
    state: np.ndarray


class Stretch(NamedTuple):
    """A change that is taken back before it has lasted: its two ends, its period, the place beyond."""

    low: float
    high: float
    period: int
    back: Spot


@dataclass
class Carried:
    """The settled motion along one parameter."""

    mechanism: Mechanism
    key: str
    how: Plan
    known: dict[tuple[float, Settled], Settled] = field(default_factory=dict)
    lasts: dict[tuple[Settled, tuple[int, ...]], Settled] = field(default_factory=dict)
    stretches: dict[tuple[Settled, str], Stretch | None] = field(default_factory=dict)

    @property
    def carried(self) -> Plan:
        """Settings of motions that begin near the one they settle to."""
        turns = max(round(CARRIED * self.how.lyapunov_turns), 1)
        return replace(self.how, transient=round(CARRIED * self.how.transient), lyapunov_turns=turns)

    def at(self, value: float, before: Settled) -> Settled:
        """The motion at a value, from the end of another one."""
        at = float(value), before  # edges of several traits in one step begin with the same motions
        if at not in self.known:
            self.known[at] = settled(self.made(at[0]), before.end, self.carried, before.period)
        return self.known[at]

    def lasting(self, place: Spot, waits: tuple[int, ...] = LASTING) -> Spot:
        """A place with the motion that its own is after some waits, or in the end."""
        key = place[1], waits
        if key not in self.lasts:
            self.lasts[key] = lasting(place[1], self.how, waits)
        return place[0], self.lasts[key]

    def chaotic(self, value: float, before: Settled) -> Spot:
        """The motion at a value, from the end of another one, with chaos that has not died out soon."""
        return self.lasting((value, self.at(value, before)), LASTING[:1])

    def patient(self, values: Iterable[float], before: Settled) -> Iterator[Spot]:
        """The motions at values one after another, each from the end of the one before."""
        for value in map(float, values):
            before = self.at(value, before)
            yield value, before

    def begun(self, last: Spot, place: Spot, within: float) -> Spot | None:
        """A place of lasting chaos between two without, `within` a relative distance of the second one."""
        step = place[0] - last[0]
        parts = min(within * abs(place[0] / step), 1.0) * np.arange(PROBES, 0, -1) / PROBES
        places = self.patient(place[0] - parts * step, last[1])
        ends = (self.lasting(each) for each in places if not each[1].period)
        return next((each for each in ends if each[1].traits["chaos"]), None)

    def soon(self, values: list[float], before: Settled) -> list[Spot]:
        """The motion at the first value, and at the next one at which it soon has the period of before.

        Each from the end of the one before it. Empty where none soon has it: then it may need longer.
        """
        spots, motion = list[Spot](), before
        with suppress(Unsettled):
            for value in values:
                motion = followed(self.made(value), motion.end, self.carried)
                spots.append((value, motion))
                if motion.period == before.period:
                    return [spots[0], spots[-1]] if len(spots) > 1 else spots
        return []

    def made(self, value: float) -> Mechanism:
        """The mechanism with that value."""
        return self.mechanism.varied({self.key: value})

    def stretch(self, last: Spot, place: Spot, name: str, share: float) -> Stretch | None:
        """The stretch about a place in which a trait is not as at the one before; None where it lasts.

        That is over a `share` of the parameter from where it begins, which is beyond the one before.
        """
        key = place[1], name
        if key not in self.stretches:
            self.stretches[key] = self._stretch(last, place, name, share)
        return self.stretches[key]

    def _stretch(self, last: Spot, place: Spot, name: str, share: float) -> Stretch | None:
        sense = 1 if abs(place[0]) > abs(last[0]) else -1
        long, since = math.log1p(share), log_distance(place[0], last[0])
        back = self._end(place, name, sense, share)
        begin = back and self._end(place, name, -sense, min(share, math.expm1(since)))
        if not back or (not begin and since > long):
            return None
        start = begin[0] if begin else last[0]
        if log_distance(back[0], start) > long:
            return None
        return Stretch(*sorted((start, back[0]), key=abs), place[1].period, back[1])

    def _end(self, place: Spot, name: str, sense: int, share: float) -> tuple[float, Spot] | None:
        """End of a trait from a place on: the value, and the place met there; None if not within a share."""
        inner = outer = place
        for distance in _distances(share):
            inner, outer = outer, self.chaotic(place[0] * (1 + distance) ** sense, outer[1])
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


def _distances(share: float) -> np.ndarray:
    """Relative distances up to a share: from a pinprick on, then evenly."""
    even = share * np.arange(1, PROBES + 1) / PROBES
    count = max(math.ceil(math.log(even[0] / PINPRICK, WIDENED)), 0)
    return np.append(PINPRICK * WIDENED ** np.arange(count), even)


@dataclass
class Side:
    """Findings on one side of the present value of a parameter.

    Parameters
    ----------
    here : Settled
        The present motion.
    found : dict
        By change: edge, error, low and high, the first return, and index into `HOW`.
    looked : list of Looked
        Values looked at, outward.
    windows : dict
        Changes that were taken back too soon, by the value at which each was met: two ends, and a period.
    limit : float
        The last value looked at.
    lasting : float
        Share of the parameter over which a change has to last: else it is a window.
    begin, reach : float
        The present value, and how far the search goes, as a factor.
    name : str
        Words for the parameter and the way.
    """

    here: Settled
    limit: float
    lasting: float = 0.0
    begin: float = 1.0
    reach: float = 2.0
    name: str = ""
    found: dict[str, tuple[float, ...]] = field(default_factory=lambda: dict.fromkeys(CHANGES, NOT_MET))
    looked: list[Looked] = field(default_factory=list)
    windows: dict[float, tuple[float, float, int]] = field(default_factory=dict)

    def changed(self, traits: dict[str, bool]) -> list[str]:
        """Changes that are met where a motion has such traits, for the first time."""
        return [n for n in CHANGES if not self.found[n][-1] and traits[n] != self.here.traits[n]]

    def unsure(self, motion: Settled) -> bool:
        """Whether a motion may be the first chaotic one: it has no period, and is asked for longer."""
        return not (motion.period or self.here.traits["chaos"] or self.found["chaos"][-1])

    def returned(self, traits: dict[str, bool], period: int) -> list[str]:
        """Changes behind which a trait is as at present for the first time again."""
        missed = (n for n, found in self.found.items() if found[-1] and math.isnan(found[-2]))
        return [n for n in missed if self.like_here(n, traits, period)]

    def like_here(self, name: str, traits: dict[str, bool], period: int) -> bool:
        """Whether a trait is as at present, for certain.

        What has no period may be chaotic, and lose contact, even where that was not seen.
        """
        unknown = name != "doubling" and not (period or traits[name])
        return traits[name] == self.here.traits[name] and not unknown

    def lasts(self, begin: float, end: float) -> bool:
        """Whether a change has lasted from one value to another."""
        return log_distance(end, begin) > math.log1p(self.lasting)

    def orbit_at(self, place: Place) -> None:
        """Note an orbit of the present period."""
        traits = self.here.traits | {"contact_loss": place.lost}
        self.at(Looked(place.value, traits, self.here.period, place.at_start()))

    def motion_at(self, spot: Spot) -> None:
        """Note the motion at a value."""
        self.at(Looked(spot[0], spot[1].traits, spot[1].period, spot[1].end.state))

    def at(self, place: Looked) -> None:
        """Note a value looked at, and which traits are as at present there for the first time again."""
        value, traits, period, _ = place
        self.limit = value
        done = log_distance(value, self.begin) / math.log(self.reach)
        stands(done, f"{self.name}: {value / self.begin:.2f} of present")
        self.looked.append(place)
        for name in self.returned(traits, period):
            edge, how = self.found[name][0], self.found[name][-1]
            if self.lasts(edge, value):
                self.found[name] = (*self.found[name][:-2], value, how)
                continue
            low, high = sorted((abs(edge), abs(value)))
            inside = [each.period for each in self.looked[:-1] if low <= abs(each.value) <= high]
            self.windows[edge] = (*sorted((edge, value)), inside[-1] if inside else self.here.period)
            self.found[name] = NOT_MET

    def change(self, name: str, one: float, other: float, how: str) -> None:
        """Note a change between two values."""
        low, high = sorted((one, other))
        self.found[name] = ((low + high) / 2, (high - low) / 2, low, high, math.nan, HOW.index(how))


def edges(
    here: Settled, key: str, side: str, search: Search, how: Plan, known: Mapping[str, Any] | None = None
) -> dict[str, Any]:
    """Find the first change of each kind on one side of the present value of a parameter.

    Returns
    -------
    dict
        ``status``; ``limit``, the last value looked at; ``looked``, the values, and over these ``periods``
        (0: none), ``states`` at crank angle 0 and, over `CHANGES` too, ``traits``; over `CHANGES`: ``edge``
        (NaN: not met), its ``error``, ``low`` and ``high``, motions that differ and the edge between them,
        ``back``, where it is first as at present again (NaN: not met), and ``how``, an index into `HOW`.
        ``windows``: low and high end, and period, of each change that was taken back within the share
        `lasting`. Where the time ended before: status ``not_run``, what was found so far, and all motions
        settled so far as ``known``, with which another call goes on.
    """
    given = Parameter(here.mechanism, key)
    begin, sense, name = float(given.value), SIDES[side], f"{given.noun}, {SENSES[side]}"
    how = Remembering(**vars(how), known=dict(known or {}))
    carried = Carried(here.mechanism, key, how)
    found, status, trouble = Side(here, begin, search.lasting, begin, search.reach, name), 0, ""
    try:
        if here.orbit is None:
            coarse = {"step": CHAOTIC * search.step, "accuracy": max(search.accuracy, search.step / 2)}
            _carried_along(found, carried, replace(search, **coarse), sense)  # finer, windows are no help
        else:
            _along_orbits(found, carried, search, sense)
    except OutOfTime:
        status = int(Status.NOT_RUN)
    except Unsettled as error:
        status, trouble = error.status, Status(error.status).meaning
    except InputError as error:
        status, trouble = int(Status.BAD_PARAMETERS), str(error)
    columns = np.array([found.found[name] for name in CHANGES]).T
    ended = {"status": status, "trouble": trouble, "limit": found.limit, "windows": [*found.windows.values()]}
    ended |= {"known": how.known} if status == Status.NOT_RUN else {}
    ended["looked"] = np.array([each.value for each in found.looked])
    ended["traits"] = np.array([[e.traits[name] for name in CHANGES] for e in found.looked], dtype=bool)
    ended["periods"] = np.array([each.period for each in found.looked], dtype=int)
    ended["states"] = np.array([each.state for each in found.looked])
    return ended | dict(zip(("edge", "error", "low", "high", "back", "how"), columns, strict=True))


def _along_orbits(side: Side, carried: Carried, search: Search, sense: int) -> None:
    """Follow the present orbit, and those of its period behind its ends; then motions beyond them."""
    here, begin, limit = side.here, side.limit, math.log(search.reach)
    branch = Branch(here.mechanism, carried.key, here.period, carried.how.max_steps)
    place = branch.first(begin, here.orbit)
    if place is None or not place.stable:  # it is not found once more: its motion is carried
        _carried_along(side, carried, search, sense)
        return
    for _ in range(BRANCHES):
        walk = Walk(branch, [place], sense, limit - log_distance(place.value, begin), search.step)
        if (end := _along_branch(side, walk)) is None:
            return
        inner, outer, kind = end
        if kind in SURE and side.changed(here.traits | {"doubling": True}):
            side.change("doubling", inner.value, outer, kind)  # however long the next motion takes to settle
        last = inner.value, replace(here, end=here.end._replace(state=inner.at_start(), journals=None))
        held = _held(side, inner.value, sense) if kind == ENDED else inner.value
        first = _behind(side, carried, search, (last, held, outer, kind), sense)
        place = branch.first(first[0], first[1].end.state) if first[1].period == here.period else None
        if place is None or not place.stable:
            break
    _beyond(side, carried, search, first, sense, limit - log_distance(first[0], begin))


def _held(side: Side, end: float, sense: int) -> float:
    """Value up to which an orbit has surely not ended: its tolerance moves its end.

    Where it is stable over less than that, the middle since the last window.
    """
    far = log_distance(end, side.begin)
    ends = (log_distance(each, side.begin) for window in side.windows.values() for each in window[:2])
    since = max((each for each in ends if each <= far), default=0.0)
    return side.begin * math.exp(sense * max(far - SHORTEST, (since + far) / 2))


def _behind(side: Side, carried: Carried, search: Search, end: BranchEnd, sense: int) -> Spot:
    """The motion behind the end of an orbit: of its period, or one that stands as long as a change has to."""
    last, held, outer, kind = end
    values = [outer * (1 + search.accuracy) ** sense]
    shares = search.lasting * np.arange(1, PROBES + 1) / PROBES
    values += [float(last[0] * (1 + share) ** sense) for share in shares if share > search.accuracy]
    values = [at for at in values if log_distance(at, side.begin) <= math.log(search.reach)] or [outer]
    soon = carried.soon(values, last[1])
    for spot in soon or carried.patient([values[0], values[-1]][: len(values)], last[1]):
        spot = carried.lasting(spot) if not soon and side.unsure(spot[1]) else spot
        for name in side.changed(spot[1].traits):
            if last is not end[0]:
                _halved(side, carried, name, last, spot, search)
            else:
                met = outer if name == "doubling" and kind != ENDED else spot[0]
                side.change(name, held, met, "bracketed" if kind == ENDED else kind)
        side.motion_at(spot)
        last = spot
        if spot[1].period == side.here.period:
            break
    return last


def _along_branch(side: Side, walk: Walk) -> tuple[Place, float, str] | None:
    """Follow an orbit: the last stable place, the value at which it has ended, and how; None at the limit.

    Where it is stable again within the share that a change has to last, its end is that of a window.
    """
    here, before, left = side.here, walk.places[0], None
    while (place := walk.onward()) is not None:
        if not place.stable:
            if left is None:
                inner, outer = walk.enclosed(lambda middle: not middle.stable)
                left = inner, outer.value, kind_of(inner, outer)
            if side.lasts(left[1], place.value):
                return left
            continue
        if left is None and place.lost != before.lost:
            inner, outer = walk.enclosed(lambda middle, lost=place.lost: middle.lost == lost)
            if side.changed(here.traits | {"contact_loss": outer.lost}):
                side.change("contact_loss", inner.value, outer.value, "grazing")
            side.orbit_at(outer)
        if left is not None:
            end = walk.enclosed(lambda middle: middle.stable)[1].value
            if side.lasts(left[1], end):
                return left
            if side.changed(here.traits | {"contact_loss": place.lost}):
                side.change("contact_loss", left[1], end, "bracketed")
            side.windows[left[1]] = *sorted((left[1], end), key=abs), 2 * here.period
        side.orbit_at(place)
        before, left = place, None
    return left or (None if walk.ended is None else (before, walk.ended, ENDED))


def _beyond(side: Side, carried: Carried, search: Search, first: Spot, sense: int, rest: float) -> None:
    """Settle motions on the rest of the way, a length of the logarithm, behind the end of the orbit."""
    count = min(BEYOND, math.ceil(rest / search.step)) if rest > 0 else 0
    values = [float(v) for v in first[0] * np.exp(sense * np.linspace(0.0, rest, count + 1)[1:])]
    plan = replace(carried.carried, batched=True)
    calls = [partial(_tried, carried.made(value), first[1].end, plan) for value in values]
    last, spots = first, [*zip(values, batch(calls, followed_together), strict=True)]
    for number, (value, motion) in enumerate(spots):
        if isinstance(motion, Unsettled):
            raise motion
        spot = value, motion
        spot = carried.lasting(spot, LASTING[:1]) if side.unsure(motion) else spot
        within = [each for at, each in spots[number + 1 :] if abs(at / last[0]) ** sense < 1 + search.lasting]
        for name in side.changed(spot[1].traits):
            if any(isinstance(m, Settled) and side.like_here(name, m.traits, m.period) for m in within):
                side.change(name, last[0], value, "bracketed")  # a window
            else:
                _halved(side, carried, name, last, spot, search)
        side.motion_at(spot)
        last = spot


def _tried(mechanism: Mechanism, start: Any, how: Plan) -> Settled | Unsettled:
    """The motion that is settled to, or why there is none."""
    try:
        return settled(mechanism, start, how)
    except Unsettled as error:
        return error


def _carried_along(side: Side, carried: Carried, search: Search, sense: int) -> None:
    """Carry a motion without a period from value to value."""
    here, begin = side.here, side.limit
    trail: list[Spot] = [(begin, here)]
    carried.lasts[here, LASTING], values = here, search.values(begin, sense)
    while len(values) and not all(each[-1] for each in side.found.values()):
        spot = carried.chaotic(float(values[0]), trail[-1][1])
        if side.changed(spot[1].traits) or side.returned(spot[1].traits, spot[1].period):
            spot = carried.lasting(spot)
        last = spot
        for name in side.changed(spot[1].traits):
            window = _window(carried, name, trail[-1], spot, here, search)
            window = window or _halved(side, carried, name, *_neighbours(carried, name, trail, spot), search)
            if window:
                last = window.back
                if not spot[1].traits["chaos"]:
                    side.windows[spot[0]] = window[:3]
                    break
        side.motion_at(spot)
        trail.append(last)
        values = values[1:]
        values = values[np.abs(values / begin - 1) > abs(last[0] / begin - 1)]  # beyond a window


def _neighbours(carried: Carried, name: str, trail: list[Spot], first: Spot) -> tuple[Spot, Spot]:
    """The last spot of a trail whose lasting motion differs from that of the next one, and the next one."""
    for last in map(carried.lasting, reversed(trail)):
        if last[1].traits[name] != first[1].traits[name]:
            break
        first = last
    return last, first


def _window(
    carried: Carried, name: str, last: Spot, place: Spot, here: Settled, search: Search
) -> Stretch | None:
    """The window in chaos around a place; other changes in it without chaos are part of it."""
    if here.period or last[1].period:
        return None
    return carried.stretch(last, place, name if place[1].traits["chaos"] else "chaos", search.lasting)


def _halved(
    side: Side, carried: Carried, name: str, last: Spot, first: Spot, search: Search
) -> Stretch | None:
    """Halve the distance of two motions that differ in a trait, and note the change, or return its window.

    Chaos in between is followed for less long, if that of the two found in the end is lasting.
    """
    for waits in (LASTING[:1], LASTING):
        inner, outer = carried.lasting(last, waits), carried.lasting(first, waits)
        if inner[1].traits[name] == outer[1].traits[name]:
            return None
        halving = Halving(side.here, carried, search, name, waits, inner, inner, outer)
        if window := halving.window():
            return window
        if halving.lasting:
            break
    if begun := halving.begun():
        return _halved(side, carried, name, halving.before, begun, search)
    inner, outer = halving.inner, halving.outer
    irregular = name == "contact_loss" and not outer[1].period
    side.change(name, inner[0], outer[0], "irregular" if irregular else "bracketed")
    return None


@dataclass
class Halving:
    """Halving of the distance of two places whose motions differ in a trait.

    Parameters
    ----------
    here : Settled
        The present motion.
    carried : Carried
        The motion along the parameter.
    search : Search
        Its `accuracy` is where halving ends.
    name : str
        The trait.
    waits : tuple of int
        How long chaos is followed.
    before, inner, outer : tuple of (float, Settled)
        The last two places found with one answer, and the first with the other one.
    """

    here: Settled
    carried: Carried
    search: Search
    name: str
    waits: tuple[int, ...]
    before: Spot
    inner: Spot
    outer: Spot

    def window(self) -> Stretch | None:
        """Enclose the change; or give the window around the outer end, where it is one.

        The outer end is reached from the inner one again: a longer step may have gone over to a motion that
        coexists. Then the change lies farther out.
        """
        beyond = [self.outer]
        while beyond:
            self.outer = beyond.pop()
            if window := self._narrowed(beyond):
                return window
            near = self._motion(self.outer[0]) if beyond else self.outer
            if not self._alike(near):
                self.outer = near
                break
            self.before, self.inner = self.inner, near
        return None

    def _narrowed(self, beyond: list[Spot]) -> Stretch | None:
        """Halve to the accuracy, with outer ends put `beyond`; or give the window around the outer one.

        A window in what lies before the edge is passed over.
        """
        while abs(self.outer[0] - self.inner[0]) > self.search.accuracy * abs(self.outer[0]):
            value = (self.outer[0] + self.inner[0]) / 2
            middle = self._motion(value)
            if self._alike(middle):
                self.before, self.inner = self.inner, middle
                continue
            window = _window(self.carried, self.name, self.inner, middle, self.here, self.search)
            if window and abs(window.low) <= abs(self.outer[0]) <= abs(window.high):
                return window
            if window and abs(window.back[0] - value) < abs(self.outer[0] - value):
                self.inner = window.back
            else:
                beyond.append(self.outer)
                self.outer = middle
        return None

    def _motion(self, value: float) -> Spot:
        """The motion at a value, from that of the inner place."""
        return self.carried.lasting((value, self.carried.at(value, self.inner[1])), self.waits)

    def _alike(self, place: Spot) -> bool:
        """Whether a place has the answer of the inner one."""
        return place[1].traits[self.name] == self.inner[1].traits[self.name]

    @property
    def lasting(self) -> bool:
        """Whether both answers stay as they are where chaos is followed to its end."""
        ends = self.inner, self.outer
        return all(
            self.carried.lasting(each)[1].traits[self.name] == each[1].traits[self.name] for each in ends
        )

    def begun(self) -> Spot | None:
        """A place of lasting chaos before the inner one: chaos begins there, and has a window in it.

        Where chaos in between is too short to be seen from the first place, it seems to begin farther out.
        """
        begins = self.name == "chaos" and self.outer[1].traits[self.name] and self.before is not self.inner
        return self.carried.begun(self.before, self.inner, self.search.accuracy) if begins else None
