"""Errors of the fractions of starts, and the uncertainty exponent of the boundary of basins.

Fractions: binomial, with Wilson's interval (E. B. Wilson, J. Am. Stat. Assoc. 22 (1927) 209-212), as if the
nodes were drawn at random; those of a regular grid scatter less.

Uncertainty exponent: the fraction f of starts whose label differs from that of another start at the distance
e goes as f ~ e^a; the boundary's dimension in the plane is D = 2 - a (C. Grebogi, S. W. McDonald, E. Ott and
J. A. Yorke, Phys. Lett. A 99 (1983) 415-418): a = 1 for a smooth boundary, less for a fractal one. Pairs are
of nodes along each axis of the grid, and of points drawn at random with partners at smaller distances. The
first nodes of the grid's pairs are the same at all distances, so that the plane's edge favours none of them.
ln f is fitted over ln e with weights from binomial errors, one slope for all, an intercept for each kind of
pair; the slope's error is widened by the scatter about the line where that is larger. Units: e in lengths of
the plane's axes. Pairs of which one start has no label do not count.
"""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass

import numpy as np

from jointplay.analysis.labels import Out

PAIRS = ("first_axis", "second_axis", "random")
EDGE = 8  # axis over the largest distance of a grid's pairs
DIRECTIONS = 2  # of a plane
NORMAL_95 = 1.959963984540054
EVEN = 1e-6  # relative difference of steps up to which an axis is even


def interval_outs(dims: str | tuple[str, ...]) -> dict[str, Out]:
    """Declarations of the ends of a fraction's interval, along these dimensions."""
    ends = {"fraction_low": "lower", "fraction_high": "upper"}
    return {name: Out(dims, f"{end} end of the 95 % interval of the fraction") for name, end in ends.items()}


def wilson(count: np.ndarray, total: int, z: float = NORMAL_95) -> tuple[np.ndarray, np.ndarray]:
    """Ends of Wilson's interval of a binomial fraction; z: its half-width in standard deviations."""
    if not total:
        return np.full(np.shape(count), np.nan), np.full(np.shape(count), np.nan)
    p = np.asarray(count) / total
    middle = (p + z**2 / (2 * total)) / (1 + z**2 / total)
    half = z / (1 + z**2 / total) * np.sqrt(p * (1 - p) / total + z**2 / (4 * total**2))
    return middle - half, middle + half


@dataclass(frozen=True)
class Pairs:
    """Count of the pairs of one kind at one distance, and of the pairs whose labels differ."""

    kind: int
    distance: float
    count: int
    differing: int

    @property
    def fraction(self) -> float:
        """Fraction of the pairs whose labels differ; NaN without pairs."""
        return self.differing / self.count if self.count else math.nan

    @property
    def error(self) -> float:
        """Standard error of the fraction."""
        return math.sqrt(self.fraction * (1 - self.fraction) / self.count) if self.count else math.nan


def fractions(count: np.ndarray, started: int) -> dict[str, np.ndarray]:
    """Fractions of the starts, with the ends of their 95 % intervals."""
    low, high = wilson(count, started)
    share = count / started if started else np.full(len(count), np.nan)
    return {"fraction": share, "fraction_low": low, "fraction_high": high}


def count_pairs(kind: int, distance: float, one: np.ndarray, other: np.ndarray) -> Pairs:
    """Count pairs of labels, without pairs that have a 0."""
    both = (one > 0) & (other > 0)
    return Pairs(kind, float(distance), int(both.sum()), int(np.sum((one != other) & both)))


def grid_pairs(labels: np.ndarray, even: tuple[bool, bool] = (True, True)) -> list[Pairs]:
    """Count pairs of nodes of a grid, along each axis whose steps are even, at 1, 2, 4, ... steps."""
    rows = []
    for axis in range(DIRECTIONS):
        field = labels if axis == 0 else labels.T
        count, farthest = len(field), len(field) // EDGE
        offsets = [2**i for i in range(farthest.bit_length()) if even[axis]]
        edge = offsets[-1] if offsets else 0
        first = field[edge : count - edge]
        for k in offsets:
            ahead, behind = field[edge + k : count - edge + k], field[edge - k : count - edge - k]
            pairs = np.concatenate([first, first]), np.concatenate([ahead, behind])
            rows.append(count_pairs(axis, k / (count - 1), *pairs))
    return rows


def is_even(values: np.ndarray) -> bool:
    """Whether the steps of an axis are the same."""
    steps = np.diff(values)
    return bool(np.ptp(steps) <= EVEN * abs(steps.mean()))


def uncertainty_exponent(rows: list[Pairs]) -> tuple[float, float]:
    """Uncertainty exponent and its standard error; NaN where fewer than two distances can be used."""
    used = [row for row in rows if 0 < row.differing < row.count]
    counts = Counter(row.kind for row in used)
    used = [row for row in used if counts[row.kind] > 1]
    kinds = sorted(kind for kind in counts if counts[kind] > 1)
    if not used:
        return math.nan, math.nan
    columns = [[math.log(row.distance)] + [float(row.kind == kind) for kind in kinds] for row in used]
    design, values = np.array(columns), np.log([row.fraction for row in used])
    weight = np.array([row.fraction / row.error for row in used])
    inverse = np.linalg.inv((design * weight[:, None] ** 2).T @ design)
    fit = inverse @ (design.T @ (weight**2 * values))
    freedom = len(used) - len(fit)
    scatter = np.sum((weight * (values - design @ fit)) ** 2) / freedom if freedom else 1.0
    return float(fit[0]), float(math.sqrt(inverse[0, 0] * max(1.0, scatter)))
