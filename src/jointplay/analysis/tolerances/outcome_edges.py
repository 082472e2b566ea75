"""The edge of an event within the spreads, and the share of the event from runs beside it alone.

Along the normal score of one parameter, all others at their medians, `SCAN` values are looked at, and what is
between two that differ is halved to `RESOLUTION`. So is the same edge with every other score at both sides of
0, `ARM` away: an edge is the surface

    z_e = E(z) = E_0 + sum_j (a_j z_j + b_j z_j^2),

and on which side of the edges a sample lies says what happens to it. Within a band about the edges, which no
sample that contradicts them is beyond, runs are drawn at random: the share is that of the samples beyond the
band on the event's side, and the band's share times that of the event among the runs (stratified sampling).
Beyond the band the edges are believed; the samples say how many exceptions they can have missed, and by how
much what is undecided there widens the interval.
References: W. G. Cochran, Sampling Techniques (1977), chapter 5; C. J. Clopper and E. S. Pearson, Biometrika
26 (1934) 404.
Validity: edges that are nearer to each other than a step of the scan are missed, and found as exceptions.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from jointplay.analysis.tolerances.estimates import Interval, in_band, most_exceptions
from jointplay.analysis.tolerances.outcomes import NO, YES
from jointplay.analysis.tolerances.spreads import Design

REACH, SCAN, INNER = 4.0, 33, 7  # normal scores that are looked at, values, and values in a bracket
RESOLUTION = 0.02  # of an edge, in normal scores
ARM, NEAR, STEPS = 1.5, 1.0, 9  # star points; about an edge, at most so far to either side, so many values
APART = 0.4  # of the distance of two edges
BAND, WIDEST, WIDER = 0.1, 1.0, 1.25  # half-width: least, largest, over the farthest contradiction
POPULATION = 2**18  # points that shares beyond the band are of
FOUND = ("located", "no_edge", "unclear", "undecided")
LOCATED, NO_EDGE, UNCLEAR, OPEN = range(4)
Look = Callable[[np.ndarray], np.ndarray]  # outcomes of an event at normal scores, shape (n, factors)


@dataclass(frozen=True)
class Edges:
    """Edges of an event along one factor.

    Parameters
    ----------
    factor : int
        Along whose score.
    first : bool
        Whether the event is there below the lowest edge.
    places : ndarray, shape (edges,)
        Scores, others at 0.
    slopes, bends : ndarray, shape (edges, factors)
        Coefficients of the other scores; 0 of the own.
    """

    factor: int
    first: bool
    places: np.ndarray
    slopes: np.ndarray
    bends: np.ndarray

    def surfaces(self, scores: np.ndarray) -> np.ndarray:
        """Where each edge lies along the factor, by the other scores, shape (n, edges)."""
        return self.places + scores @ self.slopes.T + scores**2 @ self.bends.T

    def off(self, scores: np.ndarray) -> np.ndarray:
        """How far scores lie above each edge, shape (n, edges)."""
        return scores[:, self.factor, None] - self.surfaces(scores)

    def expected(self, scores: np.ndarray) -> np.ndarray:
        """Whether the event is there, by the edges."""
        return (np.sum(self.off(scores) > 0, axis=1) % 2 == 1) != self.first

    def distance(self, scores: np.ndarray) -> np.ndarray:
        """Distance to the nearest edge."""
        return np.abs(self.off(scores)).min(axis=1)


def located(look: Look, factors: int, factor: int) -> tuple[int, Edges | None, int]:
    """The edges along a factor; `FOUND`, the edges, and the number of runs."""
    line = np.zeros((SCAN, factors))
    line[:, factor] = np.linspace(-REACH, REACH, SCAN)
    seen = look(line)
    sides = np.flatnonzero((seen == NO) | (seen == YES))
    brackets = [(a, b) for a, b in pairwise(sides) if seen[a] != seen[b]]
    if not brackets:
        return NO_EDGE if len(sides) == SCAN else OPEN, None, SCAN
    ends = np.array([[line[a, factor], line[b, factor]] for a, b in brackets])
    ways = np.array([seen[b] for _, b in brackets])
    zeros = np.zeros((len(ends), factors))
    places, count = _halved(look, zeros, factor, ends, ways)
    count += SCAN
    slopes, bends = np.zeros((2, len(places), factors))
    others = [j for j in range(factors) if j != factor]
    stars = np.array([(k, j, side) for k in range(len(places)) for j in others for side in (-ARM, ARM)])
    if not len(stars):
        return LOCATED, Edges(factor, bool(seen[sides[0]] == YES), places, slopes, bends), count
    own = stars[:, 0].astype(int)
    base = np.zeros((len(stars), factors))
    base[np.arange(len(stars)), stars[:, 1].astype(int)] = stars[:, 2]
    near = np.minimum(NEAR, APART * np.min(np.diff(places), initial=np.inf))  # no other edge is so near
    steps = places[own, None] + near * np.linspace(-1.0, 1.0, STEPS)
    codes = look(_along(base, factor, steps)).reshape(steps.shape)
    count += steps.size
    after = codes == ways[own, None]
    single = np.all(np.diff(after.astype(int), axis=1) >= 0, axis=1) & ~after[:, 0] & after[:, -1]
    if not np.all(single & np.all(codes <= YES, axis=1)):
        return UNCLEAR, None, count
    first = after.argmax(axis=1)
    rows = np.arange(len(stars))
    ends = np.stack([steps[rows, first - 1], steps[rows, first]], axis=1)
    far, more = _halved(look, base, factor, ends, ways[own])
    for k in range(len(places)):
        for j in others:
            low, high = (far[(own == k) & (stars[:, 1] == j) & (stars[:, 2] == s)][0] for s in (-ARM, ARM))
            slopes[k, j], bends[k, j] = (high - low) / (2 * ARM), ((high + low) / 2 - places[k]) / ARM**2
    return LOCATED, Edges(factor, bool(seen[sides[0]] == YES), places, slopes, bends), count + more


def _along(base: np.ndarray, factor: int, places: np.ndarray) -> np.ndarray:
    """Scores as each base has them, with each of its places along the factor."""
    scores = np.repeat(base, places.shape[1], axis=0)
    scores[:, factor] = places.ravel()
    return scores


def _halved(
    look: Look, base: np.ndarray, factor: int, ends: np.ndarray, ways: np.ndarray
) -> tuple[np.ndarray, int]:
    """Places between ends at which the outcome becomes that of its way, and the number of runs."""
    count, rows = 0, np.arange(len(ends))
    while np.max(np.diff(ends)) > RESOLUTION:
        inner = np.linspace(ends[:, 0], ends[:, 1], INNER + 2, axis=1)
        codes = look(_along(base, factor, inner[:, 1:-1])).reshape(len(ends), INNER)
        count += codes.size
        after = np.hstack([codes == ways[:, None], np.ones((len(ends), 1), dtype=bool)])
        first = after.argmax(axis=1)  # what is undecided lies before the edge
        ends = np.stack([inner[rows, first], inner[rows, first + 1]], axis=1)
    return ends.mean(axis=1), count


@dataclass(frozen=True)
class Beside:
    """Share of an event by its edges.

    Parameters
    ----------
    share : (float, float, float)
        With its interval.
    half_width : float
        Of the band, in normal scores.
    exceptions : float
        Largest share of samples beyond the band that the edges can have wrong, with 95 %.
    runs : int
        In the band.
    """

    share: Interval
    half_width: float
    exceptions: float
    runs: int


def by_edges(
    edges: Edges, design: Design, scores: np.ndarray, outcome: np.ndarray, look: Look, runs: int
) -> Beside | None:
    """The share of an event by its edges, samples and further runs; None where samples contradict the edges.

    Parameters
    ----------
    edges : Edges
        Of the event.
    design : Design
        Of the samples.
    scores, outcome : ndarray, shape (n, factors) and (n,)
        Of the samples.
    look : callable
        Gives outcomes.
    runs : int
        Number of runs in the band.
    """
    decided = (outcome == YES) | (outcome == NO)
    wrong = edges.expected(scores) != (outcome == YES)
    away = edges.distance(scores)
    half = max(BAND, WIDER * float(away[wrong & decided].max(initial=0.0)))
    if half > WIDEST:
        return None
    far = away > half
    unknown = float(np.mean(far & ~decided))
    width = len(design.factors)
    every = Design(design.spreads, design.together, design.correlation, seed=design.seed + 1)
    points = every.scores(every.drawn(POPULATION)[:, :width])
    inside = edges.distance(points) <= half
    sure = float(np.mean(edges.expected(points) & ~inside))
    there = np.flatnonzero(inside)
    chosen = np.random.default_rng([design.seed, 1]).choice(there, min(runs, len(there)), replace=False)
    codes = look(points[np.sort(chosen)]) if len(chosen) else np.empty(0, dtype=int)
    share = float(np.mean(inside))
    known = codes[(codes == YES) | (codes == NO)]
    value = in_band(known == YES, sure, share)[0]
    low, high = in_band(codes == YES, sure, share)[1], in_band(codes != NO, sure, share)[2]
    interval = value, max(low - unknown, 0.0), min(high + unknown, 1.0)
    return Beside(interval, half, most_exceptions(0, int(np.sum(far & decided))), len(codes))
