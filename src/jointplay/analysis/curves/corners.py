"""Corners of curves of folds or doublings: tangent to a grazing, a curve turns there, or ends.

Beside a contact that begins multipliers change with the root of its depth d. On that side the curve keeps
a s = b sqrt(d), s along the grazing from where both meet: it nears the grazing with s^2, and its steps shrink
with s. The meeting is sought from the other side, where the map is smooth: along the grazing, as the point
with the critical multiplier. From there the curve goes on into that side.
Sticking that appears where the speed of sliding grazes zero lasts as long as that root, and takes a direction
away: multipliers jump, the other side has no critical one, and the curve ends. Along it the time of sticking
shrinks with s, which tells where.
Reference: di Bernardo et al., Piecewise-smooth Dynamical Systems (2008), chapters 7 and 8.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from jointplay.analysis.orbits.arclength import solve
from jointplay.analysis.orbits.branch import Branch
from jointplay.analysis.orbits.branch_points import Special
from jointplay.analysis.orbits.family import Family, Point
from jointplay.analysis.orbits.neighbours import same_orbit_events
from jointplay.analysis.orbits.orbit_events import CONTACT, KIND, OF_GAPS, PLACE, changed_event
from jointplay.analysis.orbits.shooting import Orbit, newton
from jointplay.solver.method.codes import Event

AWAY = (1e-5, 1e-4, 1e-3, 1e-2)  # of the ranges, across the curve: where an orbit without the event is sought
NEAR = 0.2  # of the ranges: how far ahead the meeting may be
POINTS = 6  # of the grazing's curve on the way there
SOON, BACK = 1e-2, 1e-4  # of the ranges: how far ahead sticking may end, and over what its rate is taken
MEETING = {"fold": "fold_grazing", "period_doubling": "doubling_grazing"}


@dataclass(frozen=True)
class Begin:
    """Beginning of a curve: its kind, an orbit, the fractions of both ranges, and the event at a grazing."""

    kind: str
    orbit: Orbit
    q: np.ndarray
    event: tuple[int, int] = (-1, -1)


def corner(
    family: Family,
    begin: Begin,
    last: Point,
    begun: Callable[[Begin], tuple[Family, Point, str]],
    follow: Callable[[Family, Point, int], Branch],
) -> tuple[Special, Point | None] | None:
    """The meeting with a grazing ahead of a point, as a special point of its curve, and where that goes on.

    None in place of the latter where the curve ends there.

    Parameters
    ----------
    family : Family
        Of the curve.
    begin : Begin
        Its start.
    last : Point
        Where its steps have become short.
    begun : callable
        The family and the first point of a curve, and what is wrong, by its start.
    follow : callable
        A curve's branch from a point on, of some points.
    """
    if (end := _unstuck(family, last)) is not None:
        return end, None
    for orbit, q, event in _across(family, last):
        grazing, first, trouble = begun(replace(begin, kind="grazing", orbit=orbit, q=q, event=event))
        if trouble:
            continue
        if first.tangent[-2:] @ last.tangent[-2:] < 0:
            first = replace(first, tangent=-first.tangent)
        for met in follow(grazing, first, POINTS).specials:
            if met.kind != MEETING[begin.kind] or np.linalg.norm(met.q - last.q) > NEAR:
                continue
            _, onward, trouble = begun(replace(begin, orbit=met.point.orbit, q=met.q))
            if trouble:
                continue
            scales = np.append(np.full(len(last.tangent) - 2, onward.unit / met.point.unit), np.ones(2))
            if met.point.jacobian[-1] @ (scales * onward.tangent) < 0:  # the margin grows from there on
                onward = replace(onward, tangent=-onward.tangent)
            return replace(met, kind="grazing", event=event), onward
    return None


def _across(family: Family, last: Point) -> Iterator[tuple[Orbit, np.ndarray, tuple[int, int]]]:
    """Orbits near a curve that lack an event of a gap, the nearest first; their places, and the event."""
    along = last.tangent[-2:] / np.linalg.norm(last.tangent[-2:])
    events = last.orbit.image.events
    for away in AWAY:
        for side in (-away, away):
            q = last.q + side * along[::-1] * (1, -1)
            orbit = newton(family.at(q, last.orbit.map), last.orbit.state, family.tolerance)
            if orbit.status or len(orbit.image.events) >= len(events):
                continue
            event = changed_event(orbit.image.events, events)
            if event[1] in OF_GAPS:
                yield orbit, q, event
                return


def _unstuck(family: Family, last: Point) -> Special | None:
    """The point, soon after one of a curve, at which a piece of sticking has shrunk to nothing."""
    before = solve(family, last, last.z - BACK * last.tangent, last.tangent)
    if before is None or not same_orbit_events(before, last):
        return None
    (contacts, now), (_, then) = (_sticking(each.orbit.image.events) for each in (last, before))
    with np.errstate(divide="ignore", invalid="ignore"):
        ahead = now / (then - now)
    soon = np.flatnonzero((ahead > 0) & (BACK * ahead < SOON))
    if not len(soon):
        return None
    first = soon[np.argmin(ahead[soon])]
    along, event = ahead[first] * (last.q - before.q), (contacts[first], Event.STICK_ONSET)
    return Special("grazing", last, last.q + along, float(np.linalg.norm(along)), event)


def _sticking(events: np.ndarray) -> tuple[list[int], np.ndarray]:
    """Contact and share of the orbit of each piece of sticking that ends in slip."""
    found = []
    for contact in {int(row[CONTACT]) for row in events}:
        own = events[events[:, CONTACT] == contact]
        for one, other in zip(own, np.roll(own, -1, axis=0), strict=True):
            if (one[KIND], other[KIND]) == (Event.STICK_ONSET, Event.SLIP_ONSET):
                found.append((contact, (other[PLACE] - one[PLACE]) % 1.0))
    return [contact for contact, _ in found], np.array([share for _, share in found])
