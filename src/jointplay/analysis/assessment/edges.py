"""Values of a parameter at which the motion of a linkage changes, from its present value outward.

The settled motion is followed from value to value, each from the end of the one before, in even steps of the
logarithm. Where a trait (`settled`) first differs from the present motion's, the step is halved until the two
motions that differ are `accuracy` apart: they enclose the edge. Loss of contact and loss of
period 1 are then located on the periodic orbit itself, by `continuation` across that bracket: the grazing at
which a separation appears, the multiplier through -1, the fold. Chaos has no such point; its bracket stands.

Validity: what begins and ends between two steps is not seen, and a motion that coexists with the one followed
is another one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from jointplay.analysis.assessment.settled import CHANGES, ONCE_A_TURN, Settled, Unsettled, settled
from jointplay.analysis.orbits.branch_points import KINDS as SPECIAL
from jointplay.analysis.orbits.continuation import continuation
from jointplay.analysis.orbits.orbit_events import OF_GAPS
from jointplay.analysis.orbits.orbit_request import present
from jointplay.analysis.sweeps.attractor import Plan
from jointplay.analysis.vary import changed
from jointplay.errors import InputError
from jointplay.mechanism.records import Mechanism
from jointplay.numerics.codes import Status

SIDES = {"below": -1, "above": 1}
HOW = ("not_met", "bracketed", *SPECIAL)
CARRIED = 0.3  # of the transient, for a motion that begins from its neighbour's
WIDER = 5.0  # brackets beyond each end in which a branch is searched: motions settle slowly beside an edge
RTOL, STEP, POINTS = 1e-10, 0.1, 100  # of the branch
LEAVES = {"contact_loss": ("grazing",), "doubling": tuple(kind for kind in SPECIAL if kind != "grazing")}


@dataclass(frozen=True)
class Search:
    """How far, as a factor, and how closely; `step` and `accuracy` are relative."""

    reach: float
    step: float
    accuracy: float

    def values(self, begin: float, way: int) -> np.ndarray:
        """Values after the first, in even steps of the logarithm."""
        count = math.ceil(math.log(self.reach) / math.log1p(self.step))
        return np.geomspace(begin, begin * self.reach**way, count + 1)[1:]


@dataclass
class Walk:
    """The settled motion along one parameter."""

    mechanism: Mechanism
    key: str
    how: Plan

    @property
    def carried(self) -> Plan:
        """Settings of motions that begin beside the one they settle to."""
        return replace(self.how, transient=round(CARRIED * self.how.transient))

    def at(self, value: float, before: Settled) -> Settled:
        """The motion at a value, from the end of another one."""
        here = changed(self.mechanism, {self.key: float(value)})
        return settled(here, before.end, self.carried, before.period)


def edges(mechanism: Mechanism, key: str, side: str, start: Any, search: Search, how: Plan) -> dict[str, Any]:
    """Find the first change of each kind on one side of the present value of a parameter.

    Returns
    -------
    dict
        ``status``; ``limit``, the last value looked at; and over `CHANGES`: ``edge`` (NaN: not met), its
        ``error``, ``low`` and ``high``, settled motions that differ and the edge between them, and ``how``,
        an index into `HOW`.
    """
    walk, begin = Walk(mechanism, key, how), float(present(mechanism, key))
    found = {name: (math.nan,) * 4 + (HOW.index("not_met"),) for name in CHANGES}
    limit, status, trouble = begin, 0, ""
    try:
        here = at = settled(mechanism, start, how)
        for value in search.values(begin, SIDES[side]):
            before, last = at, limit
            at, limit = walk.at(value, before), float(value)
            new = [name for name in CHANGES if not found[name][-1] and at.traits[name] != here.traits[name]]
            for name in new:
                found[name] = _located(walk, name, (last, before), (limit, at), search.accuracy)
            if all(each[-1] for each in found.values()):
                break
    except Unsettled as error:
        status, trouble = error.status, Status(error.status).meaning
    except InputError as error:
        status, trouble = int(Status.BAD_PARAMETERS), str(error)
    columns = np.array([found[name] for name in CHANGES]).T
    names = ("edge", "error", "low", "high", "how")
    return {"status": status, "trouble": trouble, "limit": limit} | dict(zip(names, columns, strict=True))


Place = tuple[float, Settled]


def _located(walk: Walk, name: str, last: Place, first: Place, accuracy: float) -> tuple[float, ...]:
    """Edge, error, bracket and index into `HOW` of a change between two values."""
    last, first = _bracket(walk, name, last, first, accuracy)
    low, high = sorted((last[0], first[0]))
    for place in (last, first):  # chaos has no orbit to follow; else that side's which has one
        if name in LEAVES and place[1].period == 1:
            if special := _special(walk, name, place, (low, high)):
                edge, error, kind = special
                return edge, error, min(low, edge), max(high, edge), HOW.index(kind)
            break
    return (low + high) / 2, (high - low) / 2, low, high, HOW.index("bracketed")


def _bracket(walk: Walk, name: str, last: Place, first: Place, accuracy: float) -> tuple[Place, Place]:
    """Halve the distance of two motions that differ in a trait, followed from the first one."""
    while abs(first[0] - last[0]) > accuracy * abs(first[0]):
        value = (first[0] + last[0]) / 2
        middle = value, walk.at(value, last[1])
        if middle[1].traits[name] == last[1].traits[name]:
            last = middle
        else:
            first = middle
    return last, first


def _special(
    walk: Walk, name: str, place: Place, bracket: tuple[float, float]
) -> tuple[float, float, str] | None:
    """Value, accuracy and kind of the special point of the orbit near a bracket that is such a change."""
    value, motion = place
    wide = WIDER * (bracket[1] - bracket[0])
    branch = continuation(
        motion.mechanism,
        ONCE_A_TURN,
        parameter=walk.key,
        range=(bracket[0] - wide, bracket[1] + wide),
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
    if not fits.any():
        return None
    places = branch["special_parameter"].values
    distance = np.where(fits, np.abs(places - sum(bracket) / 2), np.inf)
    i = int(np.argmin(distance))
    return float(places[i]), float(branch["special_accuracy"].values[i]), kinds[i]
