"""The smallest knock that throws a motion into another: searched over phases and directions, then confirmed.

At every section point of the motion, at even phases of a turn and in even directions, knocks of growing size
are tried. Where the first of them ends in another motion than one came from, the size is halved in; the
smallest is improved by turning direction and phase a little. Then shares of it are tried, from half to 1.2.
Where a smaller one tips, the search goes on below that. It is confirmed: at 0.99 of the size the motion
returns, at 1.01 it does not. Where boundaries are fractal that may fail however small the knock: both happen
in bands. What is known then is the largest size up to which every one tried there returned, where each share
leads, how many of even sizes up to 1.2 of it tip, and the smallest beginning of a band of these that is
confirmed. Validity: islands of another basin narrower than the steps of size, phase and direction are not
seen, so that the true smallest knock may be smaller.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import NamedTuple

import numpy as np

from jointplay.analysis.coexisting.knocks import Knock
from jointplay.analysis.coexisting.lasting import FAILED, NO_START, Motions
from jointplay.analysis.orbits.section_map import SectionMap
from jointplay.solver.mechanism.model import Model

BEST, HALVINGS, ROUNDS = 6, 12, 5  # candidates halved in, how often; improvements of the best
NEARER = 0.98  # of the size, that a neighbour must beat
SHARES = (0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.98, 0.99, 1.0, 1.01, 1.02, 1.05, 1.1, 1.2)
BELOW, AT, ABOVE = (SHARES.index(share) for share in (0.99, 1.0, 1.01))
LARGER = np.linspace(1.0, SHARES[-1], 41)  # shares tried of a knock that is not confirmed
DESCENTS = 4  # how often the search goes on below an island of smaller sizes


class Place(NamedTuple):
    """Place of a knock: its section point, the phase ahead of that and the direction, rad."""

    point: int
    phase: float
    direction: float


@dataclass
class Knocked:
    """A motion that is knocked, and where that leads.

    Parameters
    ----------
    motions : Motions
        Those that are known.
    own : int
        Number of the motion that is knocked.
    points : ndarray
        Its states at the section.
    section : SectionMap or None
        Of one turn; None where nothing turns, and knocks are at section points alone.
    knock : Knock
        Its kind.
    """

    motions: Motions
    own: int
    points: np.ndarray
    section: SectionMap | None
    knock: Knock

    def start(self, place: Place, size: float) -> Model | None:
        """The motion after a knock, where it next comes to the section; None where there is no such knock."""
        base, state = self.motions.base, self.points[place.point]
        if self.section is None or not place.phase:
            return self.knock.applied(replace(base, state=state), place.direction, size)
        section, image = self.section.moved(state, place.phase)
        here = replace(base, state=image.state, crank_angle=section.phase)
        after = None if image.status else self.knock.applied(here, place.direction, size)
        if after is None:
            return None
        back, image = section.moved(after.state, math.tau - place.phase)
        if image.status:
            return None
        state = image.state.copy()
        if back.place is not None:
            state[back.place] = base.crank_angle
        return replace(base, state=state)

    def ends(self, tried: Sequence[tuple[Place, float]]) -> np.ndarray:
        """Numbers of the motions to which knocks lead."""
        return self.motions.sort([self.start(*each) for each in tried])

    def tips(self, tried: Sequence[tuple[Place, float]]) -> np.ndarray:
        """Whether knocks lead to another motion, or to one that does not settle."""
        return self.tipped(self.ends(tried))

    def tipped(self, labels: np.ndarray) -> np.ndarray:
        """Whether the numbers are of other motions, or of one that does not settle."""
        return (labels != self.own) & (labels != FAILED) & (labels != NO_START)

    def within(self, places: Sequence[Place], sizes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """First of rising sizes that tips at each place, and the size before; infinite where none does."""
        table = self.tips([*product(places, sizes.tolist())]).reshape(len(places), len(sizes))
        first = np.where(table.any(axis=1), table.argmax(axis=1), len(sizes))
        return np.append(0.0, sizes)[first], np.append(sizes, np.inf)[first]

    def halved(self, places: Sequence[Place], low: np.ndarray, high: np.ndarray):
        """Closer bounds of the sizes at which knocks begin to tip."""
        for _ in range(HALVINGS):
            middle = (low + high) / 2
            over = self.tips([*zip(places, middle.tolist(), strict=True)])
            low, high = np.where(over, low, middle), np.where(over, middle, high)
        return low, high


@dataclass(frozen=True)
class Smallest:
    """A knock that just tips: where, sizes below and above in units, and where `SHARES` of it lead.

    Every size up to `safe` that was tried there returned. `confirmed` is the smallest that is, or NaN. Where
    it is not this one, a `share` tips of the sizes up to 1.2 times it; else that is NaN.
    """

    place: Place
    low: float
    high: float
    ends: tuple[int, ...]
    safe: float
    confirmed: float
    share: float


def smallest(knocked: Knocked, phases: int, directions: int, sizes: np.ndarray) -> Smallest | None:
    """The smallest knock of a kind that tips a motion; None if none of the sizes does."""
    phases = 1 if knocked.section is None else phases
    ways = directions if knocked.knock.plane else 2
    turns = [math.tau * k / phases for k in range(phases)]
    aims = [math.tau * k / ways for k in range(ways)]
    places = [Place(*each) for each in product(range(len(knocked.points)), turns, aims)]
    low, high = knocked.within(places, sizes)
    order = [n for n in np.argsort(high, kind="stable")[:BEST] if np.isfinite(high[n])]
    if not order:
        return None
    some = [places[n] for n in order]
    low, high = knocked.halved(some, low[order], high[order])
    n = int(np.argmin(high))
    best = some[n], float(low[n]), float(high[n])
    steps = math.tau / phases / 2 if phases > 1 else 0.0, math.tau / ways / 2 if knocked.knock.plane else 0.0
    for _ in range(ROUNDS):
        best, steps = _improved(knocked, best, steps)
    return _checked(knocked, *best)


def _checked(knocked: Knocked, place: Place, low: float, high: float) -> Smallest:
    """Try shares of a knock, and go on below it where a smaller one tips."""
    shares = np.array(SHARES)
    for descent in range(DESCENTS + 1):
        ends = knocked.ends([(place, size) for size in shares * high])
        over = knocked.tipped(ends)
        first = int(over.argmax())
        if descent == DESCENTS or not over.any() or first >= AT:
            break
        below = shares[first - 1] * high if first else 0.0
        some_low, some_high = knocked.halved([place], np.array([below]), np.array([shares[first] * high]))
        low, high = float(some_low[0]), float(some_high[0])
    safe = low if first >= AT or not over.any() else shares[first - 1] * high if first else 0.0
    settled = ends[BELOW] == knocked.own and over[ABOVE] and ends[ABOVE] >= 0
    confirmed, share = (high, math.nan) if settled else _larger(knocked, place, high)
    return Smallest(place, low, high, tuple(ends.tolist()), float(safe), confirmed, share)


def _larger(knocked: Knocked, place: Place, size: float) -> tuple[float, float]:
    """The smallest larger knock that is confirmed, or NaN; and the share of knocks up to 1.2 that tips."""
    sizes = size * LARGER
    over = knocked.tips([(place, each) for each in sizes])
    begin = np.flatnonzero(~over[:-1] & over[1:])
    share = float(over.mean())
    if not begin.size:
        return math.nan, share
    _, edges = knocked.halved([place] * len(begin), sizes[begin], sizes[begin + 1])
    ends = knocked.ends([(place, share * edge) for edge in edges for share in (SHARES[BELOW], SHARES[ABOVE])])
    below, above = ends.reshape(-1, 2).T
    good = (below == knocked.own) & knocked.tipped(above) & (above >= 0)
    return (float(edges[good].min()) if good.any() else math.nan), share


def _improved(knocked: Knocked, best: tuple[Place, float, float], steps: tuple[float, float]):
    """A neighbouring phase or direction in which a smaller knock tips; else the same, with half the steps."""
    place, _, high = best
    moves = [(s * steps[0], 0.0) for s in (-1, 1) if steps[0]] + [
        (0.0, s * steps[1]) for s in (-1, 1) if steps[1]
    ]
    others = [Place(place.point, (place.phase + a) % math.tau, place.direction + b) for a, b in moves]
    if others:
        low, above = knocked.within(others, NEARER * high * np.linspace(1 / 3, 1.0, 3))
        n = int(np.argmin(above))
        if np.isfinite(above[n]):
            low, above = knocked.halved([others[n]], low[[n]], above[[n]])
            return (others[n], float(low[0]), float(above[0])), steps
    return best, (steps[0] / 2, steps[1] / 2)
