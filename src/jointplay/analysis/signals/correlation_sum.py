"""Correlation sum of a set of points, and the dimension that it grows with.

C(r) is the share of pairs of points closer than r, pairs closer in time than Theiler's window left out; where
C(r) ~ r^D, D is the correlation dimension. Pairs are counted by SciPy's trees. References: P. Grassberger and
I. Procaccia, Physica D 9 (1983) 189-208; J. Theiler, Phys. Rev. A 34 (1986) 2427-2432.

D is the slope of ln C over ln r where C lies in a stated range. Its error is the larger of two: the spread of
the slopes over quarters of that range, for sets that do not scale evenly or bend it at their edges; and the
standard error from quarters of the series, for the chance of these points. Pairs grow with the square of the
points, so the latter is up to twice too large.

Validity: N points tell dimensions up to some 2 log10 N (J.-P. Eckmann and D. Ruelle, Physica D 56 (1992)
185-187), and only if the range lies well below the size of the set and above its noise. A set with edges
comes out low: a uniform square, whose C is π r² - (8/3) r³ + r⁴/2, by 0.09 at C = 0.03.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from jointplay.solver.motion.progress import ticked

FLOOR, PER_DECADE = 1e-3, 32  # radii: from this share of the set's size on, so many a decade
BLOCK = 512  # points whose neighbours are counted between two looks
PARTS = 4  # of the range, and of the series
LEAST = 3  # radii that make a slope


class Slope(NamedTuple):
    """Dimension, its spread over parts of the range, its standard error, radii at the ends of the range."""

    dimension: float
    spread: float
    standard_error: float
    radii: tuple[float, float]

    @property
    def error(self) -> float:
        """The larger of spread and standard error, as far as they are known."""
        return float(np.fmax(self.spread, self.standard_error))


NOTHING = Slope(math.nan, math.nan, math.nan, (math.nan, math.nan))


def radii(points: np.ndarray) -> np.ndarray:
    """Radii in even ratios, up to the largest extent of the set in a coordinate."""
    size = float(np.ptp(points, axis=0).max())
    return size * np.geomspace(FLOOR, 1, round(-PER_DECADE * math.log10(FLOOR)) + 1)


def correlation_sum(points: np.ndarray, at: np.ndarray, window: int) -> np.ndarray:
    """Share of pairs no farther apart than each radius.

    Parameters
    ----------
    points : ndarray, shape (points, coordinates)
        In the order of time.
    at : ndarray
        Radii, ascending.
    window : int
        Pairs fewer than so many points apart in time are left out; 1 leaves out none.
    """
    from scipy.spatial import cKDTree

    tree, count = cKDTree(points), len(points)
    blocks = (tree.indices[i : i + BLOCK] for i in range(0, count, BLOCK))  # of points near each other
    close = sum(cKDTree(points[block]).count_neighbors(tree, at) for block in ticked(blocks))
    close -= count  # each pair twice, and each point with itself
    total = count * (count - 1)
    for lag in ticked(range(1, window)):
        apart = np.linalg.norm(points[lag:] - points[:-lag], axis=1)
        close -= 2 * np.searchsorted(np.sort(apart), at, side="right")
        total -= 2 * (count - lag)
    return close / total


def fit(
    points: np.ndarray, at: np.ndarray, sums: np.ndarray, shares: tuple[float, float], window: int
) -> Slope:
    """Slope of the correlation sum `sums` at the radii `at` where it lies between two shares of the pairs.

    Points that lie in so few places that even the smallest radius holds more than the greater share have
    dimension 0; where too few radii fall into the range, there is none (NaN).
    """
    if sums[0] >= shares[1]:
        return Slope(0.0, 0.0, 0.0, (float(at[0]), float(at[-1])))
    inside = (sums >= shares[0]) & (sums <= shares[1])
    if inside.sum() < PARTS * LEAST:
        return NOTHING
    used, of_them = at[inside], sums[inside]
    quarters = np.array_split(np.arange(len(used)), PARTS)
    spread = np.std([_slope(used[part], of_them[part]) for part in quarters], ddof=1)
    parts = np.array_split(points, PARTS)
    of_parts = [_slope(used, correlation_sum(part, used, window)) for part in parts]
    error = np.std(of_parts, ddof=1) / math.sqrt(PARTS)
    return Slope(_slope(used, of_them), float(spread), float(error), (float(used[0]), float(used[-1])))


def _slope(at: np.ndarray, sums: np.ndarray) -> float:
    there = sums > 0
    if there.sum() < 2:
        return math.nan
    return float(np.polyfit(np.log(at[there]), np.log(sums[there]), 1)[0])
