"""Shares, means and quantiles of samples with intervals that hold, and what they hang on.

*Share of an event*: Wilson's interval of its count, of pseudo-random samples and wherever fewer than `RARE`
samples of either kind fall to each scrambling; else Student's interval of the means of independent scrambled
Sobol' points. What is undecided counts as neither: the lower end is of the samples that are sure, the upper
end of all that may be. *Means*: Student's interval over scramblings, or over samples. *Quantiles*: between
order statistics, by the binomial distribution.

*Sobol' shares* of the variance of an output f, from rows A and B of factors and A with one factor of B:

    first order   S_i = E[f_B (f_ABi - f_A)] / V,      total   T_i = E[(f_A - f_ABi)^2] / (2 V)

with percentiles of the rows drawn anew. Rows with an output that is not known are left out. *One spread
narrowed*: the same samples, weighed by the ratio of densities; several at once by the product.
References: E. B. Wilson, J. Am. Stat. Assoc. 22 (1927) 209; A. B. Owen, SIAM J. Numer. Anal. 34 (1997) 1884;
A. Saltelli et al., Comput. Phys. Commun. 181 (2010) 259 (first order); M. J. W. Jansen, Comput. Phys. Commun.
117 (1999) 35 (total); D. C. Hesterberg, Technometrics 37 (1995) 185 (ratio of weighted means).
Validity: factors are independent; weighed samples stand for `effective` ones, and none where these are few.

The edge of an event within the spreads, and the share of the event from runs beside it alone.

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

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import chain, combinations, pairwise

import numpy as np
from scipy import stats

from jointplay.analysis.states.basin_uncertainty import NORMAL_95, wilson
from jointplay.analysis.tolerances.outcomes import NO, YES
from jointplay.analysis.tolerances.spreads import REPLICATES, Design

LEVEL = 0.95
RARE = 5  # samples of a kind in each scrambling, below which their means are far from normal
BOOTSTRAPS = 1000
FEW = 30  # samples that weighed ones have to stand for
MOST_SUBSETS = 12  # spreads of which all sets are looked at
QUANTILES = (0.05, 0.5, 0.95, 0.99)
Interval = tuple[float, float, float]  # value, and ends

REACH, SCAN, INNER = 4.0, 33, 7  # normal scores that are looked at, values, and values in a bracket
RESOLUTION = 0.02  # of an edge, in normal scores
ARM, NEAR, STEPS = 1.5, 1.0, 9  # star points; about an edge, at most so far to either side, so many values
APART = 0.4  # of the distance of two edges
BAND, WIDEST, WIDER = 0.1, 1.0, 1.25  # half-width: least, largest, over the farthest contradiction
POPULATION = 2**18  # points that shares beyond the band are of
FOUND = ("located", "no_edge", "unclear", "undecided")
LOCATED, NO_EDGE, UNCLEAR, OPEN = range(4)
Look = Callable[[np.ndarray], np.ndarray]  # outcomes of an event at normal scores, shape (n, factors)


def share(outcome: np.ndarray, replicated: bool) -> Interval:
    """Share of the samples with an event among the decided ones, and its interval, of all."""
    yes, no = outcome == YES, outcome == NO
    decided = int(np.sum(yes | no))
    value = float(np.sum(yes) / decided) if decided else math.nan
    low, high = _share_interval(yes, replicated)[0], _share_interval(~no, replicated)[1]
    return value, low, high


def _share_interval(there: np.ndarray, replicated: bool) -> tuple[float, float]:
    count, total = int(there.sum()), len(there)
    if replicated and min(count, total - count) >= RARE * REPLICATES:
        _, low, high = mean(there.astype(float), replicated)
        return max(low, 0.0), min(high, 1.0)
    low, high = wilson(np.array(count), total)
    return float(low) if count else 0.0, float(high) if count < total else 1.0


def mean(values: np.ndarray, replicated: bool) -> Interval:
    """Mean of the known values, and its interval."""
    groups = [values[i::REPLICATES] for i in range(REPLICATES)] if replicated else list(values[:, None])
    known = [each[np.isfinite(each)] for each in groups]
    means, sizes = (np.array([f(each) for each in known if len(each)]) for f in (np.mean, len))
    if len(means) < 2:
        return (float(means[0]) if len(means) else math.nan), math.nan, math.nan
    value = float(np.average(means, weights=sizes))
    half = float(stats.t.ppf((1 + LEVEL) / 2, len(means) - 1) * np.std(means, ddof=1) / math.sqrt(len(means)))
    return value, value - half, value + half


def quantile(values: np.ndarray, q: float) -> Interval:
    """Quantile of the known values, and order statistics about it; NaN where there are too few."""
    known = np.sort(values[np.isfinite(values)])
    if not len(known):
        return math.nan, math.nan, math.nan
    low, high = (int(each) for each in stats.binom.ppf([(1 - LEVEL) / 2, (1 + LEVEL) / 2], len(known), q))
    ends = [known[low - 1] if low > 0 else math.nan, known[high] if high < len(known) else math.nan]
    return float(np.quantile(known, q)), *map(float, ends)


def sobol(f_a: np.ndarray, f_b: np.ndarray, f_ab: np.ndarray, seed: int) -> np.ndarray:
    """Sobol' shares of an output, with the ends of their intervals.

    Parameters
    ----------
    f_a, f_b : ndarray, shape (n,)
        Outputs of both sets of rows.
    f_ab : ndarray, shape (factors, n)
        Of the first ones with one factor of the second.
    seed : int
        Of the rows that are drawn anew.

    Returns
    -------
    ndarray, shape (2, 3, factors)
        First order and total; value, lower and upper end. NaN where nothing varies.
    """
    known = np.isfinite(f_a) & np.isfinite(f_b) & np.isfinite(f_ab).all(axis=0)
    f_a, f_b, f_ab = f_a[known], f_b[known], f_ab[:, known]
    if len(f_a) < 2 or not np.ptp([f_a, f_b]) > 0:
        return np.full((2, 3, len(f_ab)), np.nan)
    rows = np.random.default_rng(seed).integers(len(f_a), size=(BOOTSTRAPS, len(f_a)))
    drawn = np.stack([_sobol(f_a[i], f_b[i], f_ab[:, i]) for i in rows])
    low, high = np.nanquantile(drawn, [(1 - LEVEL) / 2, (1 + LEVEL) / 2], axis=0)
    return np.stack([_sobol(f_a, f_b, f_ab), low, high], axis=1)


def _sobol(f_a: np.ndarray, f_b: np.ndarray, f_ab: np.ndarray) -> np.ndarray:
    """First order and total shares, shape (2, factors)."""
    both = np.concatenate([f_a, f_b])
    variance = both.var()
    if not variance > 0:
        return np.full((2, len(f_ab)), np.nan)
    first = np.mean((f_b - both.mean()) * (f_ab - f_a), axis=1)
    return np.stack([first, np.mean((f_a - f_ab) ** 2, axis=1) / 2]) / variance


def weighed(outcome: np.ndarray, weights: np.ndarray) -> Interval:
    """Share of an event among decided samples that are weighed, and its interval.

    The interval is Wilson's with the number of unweighed samples that the weighed ones are as good as.
    """
    decided = (outcome == YES) | (outcome == NO)
    w, there = weights[decided], (outcome == YES)[decided]
    if not w.sum() > 0 or (effective := w.sum() ** 2 / np.sum(w**2)) < FEW:
        return math.nan, math.nan, math.nan
    value = float(np.average(there, weights=w))
    low, high = (float(end) for end in wilson(np.array(value * effective), effective))
    return value, low, high


def cheapest(
    outcome: np.ndarray, ratios: np.ndarray, prices: Sequence[float], wanted: float
) -> tuple[np.ndarray, Interval]:
    """The cheapest set of spreads to narrow so that at least a share of the samples has an event.

    Parameters
    ----------
    outcome : ndarray, shape (n,)
        Of `OUTCOMES`.
    ratios : ndarray, shape (n, parameters)
        Of densities, where each spread is narrowed.
    prices : sequence of float
        Of narrowing each; NaN where it cannot be.
    wanted : float
        Share.

    Returns
    -------
    ndarray of bool, shape (parameters,), and (float, float, float)
        Which are narrowed, and the share then, with its interval; NaN where no set is found.
    """
    able = [i for i, price in enumerate(prices) if math.isfinite(price)]
    sets = chain.from_iterable(combinations(able, size) for size in range(len(able) + 1))
    for chosen in sorted(sets, key=lambda each: (sum(prices[i] for i in each), len(each))):
        found = weighed(outcome, np.prod(ratios[:, list(chosen)], axis=1))
        if found[0] >= wanted:
            return np.isin(np.arange(len(prices)), chosen), found
    return np.zeros(len(prices), dtype=bool), (math.nan, math.nan, math.nan)


def most_exceptions(count: int, total: int) -> float:
    """Upper end of the 95 % interval of a share (Clopper and Pearson, one side)."""
    return float(stats.beta.ppf(LEVEL, count + 1, total - count)) if total > count else 1.0


def in_band(there: np.ndarray, below: float, within: float) -> Interval:
    """Share of all from what is sure beyond a band, the band's share, and samples in it."""
    if not len(there):
        return below, below, below + within
    low, high = wilson(np.array(int(there.sum())), len(there), NORMAL_95)
    return tuple(below + within * float(each) for each in (np.mean(there), low, high))


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
    outcomes = np.array([seen[b] for _, b in brackets])
    zeros = np.zeros((len(ends), factors))
    places, count = _halved(look, zeros, factor, ends, outcomes)
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
    after = codes == outcomes[own, None]
    single = np.all(np.diff(after.astype(int), axis=1) >= 0, axis=1) & ~after[:, 0] & after[:, -1]
    if not np.all(single & np.all(codes <= YES, axis=1)):
        return UNCLEAR, None, count
    first = after.argmax(axis=1)
    rows = np.arange(len(stars))
    ends = np.stack([steps[rows, first - 1], steps[rows, first]], axis=1)
    far, more = _halved(look, base, factor, ends, outcomes[own])
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
    look: Look, base: np.ndarray, factor: int, ends: np.ndarray, outcomes: np.ndarray
) -> tuple[np.ndarray, int]:
    """Places between ends at which the outcome becomes that of `outcomes`, and the number of runs."""
    count, rows = 0, np.arange(len(ends))
    while np.max(np.diff(ends)) > RESOLUTION:
        inner = np.linspace(ends[:, 0], ends[:, 1], INNER + 2, axis=1)
        codes = look(_along(base, factor, inner[:, 1:-1])).reshape(len(ends), INNER)
        count += codes.size
        after = np.hstack([codes == outcomes[:, None], np.ones((len(ends), 1), dtype=bool)])
        first = after.argmax(axis=1)  # what is undecided lies before the edge
        ends = np.stack([inner[rows, first], inner[rows, first + 1]], axis=1)
    return ends.mean(axis=1), count


@dataclass(frozen=True)
class EdgeShare:
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
) -> EdgeShare | None:
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
    return EdgeShare(interval, half, most_exceptions(0, int(np.sum(far & decided))), len(codes))
