"""Whether a driven link can go where its drive takes it: the angles at which its mechanism does not close."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

from jointplay.display.errors import Problem
from jointplay.solver.mechanism.loops import ideal
from jointplay.solver.mechanism.loops.four_bar import find_four_bar
from jointplay.solver.mechanism.records import Mechanism


def cannot_turn(mechanism: Mechanism, angle: float, travel: float) -> Iterator[Problem]:
    """Yield the problem of a crank that is to be driven where the mechanism cannot close.

    Parameters
    ----------
    mechanism : Mechanism
        Whose drive imposes a speed.
    angle : float
        Where the crank starts, rad.
    travel : float
        How far it goes on, rad.
    """
    arcs = _open(mechanism)
    if any(_meets(arc, angle, travel) for arc in arcs):
        yield _stuck(mechanism, arcs)


def doubts(mechanism: Mechanism) -> Iterator[Problem]:
    """Yield the doubt whether a crank that a motor drives is meant to rock: it cannot turn round."""
    if getattr(mechanism.drive, "kind", "") == "motor" and (arcs := _open(mechanism)):
        yield _stuck(mechanism, arcs)


def _meets(arc: tuple[float, float], angle: float, travel: float) -> bool:
    begin, end = sorted((angle, angle + travel))
    ahead = (arc[0] - begin) % math.tau  # from where the way begins to where the arc does
    return begin + ahead < end or ahead > math.tau - (arc[1] - arc[0])


def _stuck(mechanism: Mechanism, arcs: tuple[tuple[float, float], ...]) -> Problem:
    loop, crank = find_four_bar(mechanism.joints, mechanism.crank), mechanism.crank
    lengths = loop.lengths if loop else {link.name: link.length for link in mechanism.links}
    spans = (
        f"from {a:.4g} to {b:.4g} rad ({math.degrees(a):.4g} to {math.degrees(b):.4g} deg)" for a, b in arcs
    )
    closed = f"the loop does not close at angles of {crank} {' and '.join(spans)}"
    accepted = f"lengths (m) with which {crank} can go where it is driven are accepted: {closed}"
    return Problem("mechanism.links", lengths, accepted)


def _open(mechanism: Mechanism) -> tuple[tuple[float, float], ...]:
    """From where to where the driven link finds the mechanism open, rad."""
    if loop := find_four_bar(mechanism.joints, mechanism.crank):
        return loop.open_arcs(sum(joint.clearance for joint in mechanism.joints))
    parts = (
        *((link.name, link.length) for link in mechanism.links),
        *((each.kind, each.journal, each.bearing, each.clearance) for each in mechanism.joints),
        *sorted(mechanism.guess.items()),
        mechanism.crank,
    )
    return _led_round(_Geometry(mechanism, parts))


@dataclass(frozen=True)
class _Geometry:
    """A mechanism, equal to another with the same links and joints: whether it closes hangs on no more."""

    mechanism: Mechanism = field(compare=False)
    parts: tuple[Any, ...]


@lru_cache(maxsize=256)
def _led_round(given: _Geometry) -> tuple[tuple[float, float], ...]:
    return ideal.open_arcs(given.mechanism)
