"""Sorting ends of motions into attractors.

Ends of the same period are the same if their section points are within a tolerance as sets: no point of one
farther than that from the nearest of the other (Hausdorff distance), in any coordinate. Ends without a period
are compared by histograms: each coordinate's range over all such ends is cut into eight, and an end belongs
to an attractor if its share of time in these overlaps by half or more, in every coordinate, with that of the
ends already found to belong; this is repeated until nothing changes. So coarse a comparison needs few points,
but does not separate attractors that only differ in detail.

Attractors are numbered by period, those without one last, then by their points: the numbers depend neither on
the order of the starts nor on the division of the work.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from jointplay.solver.motion.progress import tick

BINS = 8
SHARED = 0.5


@dataclass(frozen=True)
class Attractors:
    """Labels of ends (0: none), and of each attractor its period (0: none) and the index of one end."""

    labels: np.ndarray
    periods: np.ndarray
    shown_by: np.ndarray


def match(periods: np.ndarray, points: list[np.ndarray], tolerance: float) -> Attractors:
    """Sort ends into attractors.

    Parameters
    ----------
    periods : ndarray of int, shape (ends,)
        0: none.
    points : list of ndarray
        Section points of each end, shape (points, coordinates); of a periodic one, one period of them. No
        points: the motion failed and has no attractor.
    tolerance : float
        Largest distance of points that count as one.

    Returns
    -------
    Attractors
    """
    ended = np.array([len(each) > 0 for each in points], dtype=bool)
    groups: list[np.ndarray] = []
    for p in np.unique(periods[ended & (periods > 0)]):
        which = np.flatnonzero(ended & (periods == p))
        groups += [which[group] for group in by_distance(np.array([points[i] for i in which]), tolerance)]
    which = np.flatnonzero(ended & (periods == 0))
    groups += [which[group] for group in by_histograms([points[i] for i in which])]
    order = sorted(groups, key=lambda group: sort_key(periods[group[0]], points[group[0]], tolerance))
    labels = np.zeros(len(points), dtype=np.int32)
    for number, group in enumerate(order, start=1):
        labels[group] = number
    first = np.array([group[0] for group in order], dtype=int)
    return Attractors(labels, periods[first], first)


def sort_key(period: int, points: np.ndarray, tolerance: float) -> tuple:
    """Sort key of an attractor: by period, then by its points, lowest first, to the tolerance."""
    coarse = np.round(points / tolerance) if period else np.round(points.mean(axis=0, keepdims=True), 1)
    return not period, int(period), sorted(map(tuple, coarse.tolist()))


def by_distance(sets: np.ndarray, tolerance: float) -> list[np.ndarray]:
    """Groups of sets of points, shape (sets, points, coordinates), each within the tolerance of its first."""
    left, groups = np.arange(len(sets)), []
    while left.size:
        tick()
        apart = set_distance(sets[left], sets[left[0]])
        groups.append(left[apart <= tolerance])
        left = left[apart > tolerance]
    return groups


def set_distance(sets: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Hausdorff distances, by largest difference in a coordinate, of sets of points from another."""
    apart = np.abs(sets[:, :, None, :] - other[None, None, :, :]).max(axis=-1)
    return np.maximum(apart.min(axis=2).max(axis=1), apart.min(axis=1).max(axis=1))


def by_histograms(clouds: list[np.ndarray]) -> list[np.ndarray]:
    """Groups of clouds of points with similar histograms."""
    if not clouds:
        return []
    shares, left, groups = histograms(clouds), np.arange(len(clouds)), []
    while left.size:
        inside = np.zeros(len(left), dtype=bool)
        inside[0], before = True, 0
        while inside.sum() > before:
            tick()
            before, mean = inside.sum(), shares[left[inside]].mean(axis=0)
            overlap = np.minimum(shares[left], mean).sum(axis=-1).min(axis=-1)
            inside |= overlap >= SHARED
        groups.append(left[inside])
        left = left[~inside]
    return groups


def histograms(clouds: list[np.ndarray]) -> np.ndarray:
    """Fraction of each cloud's points in each bin of each coordinate, shape (clouds, coordinates, bins)."""
    low = np.min([cloud.min(axis=0) for cloud in clouds], axis=0)
    size = np.max([cloud.max(axis=0) for cloud in clouds], axis=0) - low
    size = np.where(size > 0, size, 1.0) / BINS
    result = np.zeros((len(clouds), len(low), BINS))
    for shares, cloud in zip(result, clouds, strict=True):
        for axis, cells in enumerate(np.minimum((cloud - low) / size, BINS - 0.5).astype(int).T):
            shares[axis] = np.bincount(cells, minlength=BINS) / len(cells)
    return result
