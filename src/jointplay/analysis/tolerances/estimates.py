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
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import chain, combinations

import numpy as np
from scipy import stats

from jointplay.analysis.states.basin_uncertainty import NORMAL_95, wilson
from jointplay.analysis.tolerances.outcomes import NO, YES
from jointplay.analysis.tolerances.spreads import REPLICATES

LEVEL = 0.95
RARE = 5  # samples of a kind in each scrambling, below which their means are far from normal
BOOTSTRAPS = 1000
FEW = 30  # samples that weighed ones have to stand for
MOST_SUBSETS = 12  # spreads of which all sets are looked at
QUANTILES = (0.05, 0.5, 0.95, 0.99)
Interval = tuple[float, float, float]  # value, and ends


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
