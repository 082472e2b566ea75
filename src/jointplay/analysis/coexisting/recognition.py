"""Recognising by section points where starts end; from afar, as far as others show that this is right.

A start has reached a periodic motion where it runs along that, point by point over two periods, within the
tolerance and coming no farther. It is bound for it where it does so within `AFAR` tolerances, and along no
other. It is bound for a motion without a period where its last points lie among those of starts that have
stayed there, as near to these as they lie to each other in all but one case in a hundred.

No theorem says that what is bound for a motion arrives. So that is tried on starts that are followed until
they have arrived: a motion is recognised from afar if for `ENOUGH` of them at least that would have been
right, and for none wrong. With n starts tried, drawn independently, less than 3/n of those to come are
mistaken, at 95 % (the rule of three).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from jointplay.analysis.period import REPEATS
from jointplay.analysis.states.ends import STRICTER
from jointplay.analysis.states.matching import SHARED, histograms

AFAR = 10  # tolerances within which a start that comes nearer is bound for a periodic motion
AMONG, NEAR = 8, 0.99  # last points that lie among others; of whose distances so large a share is no larger
ENOUGH = 16
TAIL = 48  # section points by which a motion is recognised


@dataclass
class Lasting:
    """A motion that lasts: period (0: none), states at the section, their features, turns it was watched."""

    period: int
    states: np.ndarray
    points: np.ndarray
    watched: int = 0
    cloud: Cloud | None = None


class Cloud:
    """Section points of runs that show one motion without a period, shape (runs, turns, coordinates)."""

    def __init__(self, runs: np.ndarray):
        from scipy.spatial import cKDTree

        halves = [np.concatenate(runs[i::2]) for i in range(2)]
        self.tree = cKDTree(halves[0])
        self.near = float(np.quantile(self._apart(halves[1]), NEAR))

    def _apart(self, points: np.ndarray) -> np.ndarray:
        return self.tree.query(points, p=np.inf)[0]

    def holds(self, points: np.ndarray) -> np.ndarray:
        """Whether the last points of runs, shape (runs, turns, coordinates), lie among the cloud's points."""
        if points.shape[1] < AMONG:
            return np.zeros(len(points), dtype=bool)
        last = points[:, -AMONG:].reshape(-1, points.shape[-1])
        return (self._apart(last).reshape(-1, AMONG) <= self.near).all(axis=1)


def along(points: np.ndarray, motion: Lasting, within: float, steady: float) -> np.ndarray:
    """Whether runs go along a periodic motion, within a distance and coming no farther, or staying `steady`.

    Parameters
    ----------
    points : ndarray, shape (runs, turns, coordinates)
        Last section points of each.
    motion : Lasting
        Any; along one without a period nothing goes.
    within, steady : float
        Distances of section points.
    """
    count = max(2 * motion.period, REPEATS)
    if not motion.period or count > points.shape[1]:
        return np.zeros(len(points), dtype=bool)
    nearest = np.abs(motion.points - points[:, -1:]).max(axis=-1).argmin(axis=1)
    order = (nearest[:, None] + 1 + np.arange(-count, 0)) % motion.period
    apart = np.abs(points[:, -count:] - motion.points[order]).max(axis=-1)
    first, second = apart[:, : count // 2].max(axis=1), apart[:, count // 2 :].max(axis=1)
    return (np.maximum(first, second) <= within) & (second <= np.maximum(first, steady))


def alike(one: np.ndarray, other: np.ndarray) -> bool:
    """Whether two sets of points spend half of their time in the same eighths of each coordinate, or more."""
    first, second = histograms([one, other])
    return bool(np.minimum(first, second).sum(axis=-1).min() >= SHARED)


@dataclass
class FromAfar:
    """Motions that are recognised from afar, as starts that were followed have shown it right.

    Parameters
    ----------
    known : sequence of Lasting
        The motions, each named by its place.
    tolerance : float
        Distance of section points that count as one.
    """

    known: Sequence[Lasting]
    tolerance: float
    right: Counter[int] = field(default_factory=Counter)
    wrong: set[int] = field(default_factory=set)

    def bound(self, points: np.ndarray) -> np.ndarray:
        """For which motion each run is bound, shape (runs,); -1: for none, or for one of several."""
        found = np.zeros((1 + len(self.known), len(points)), dtype=bool)
        for row, motion in zip(found, self.known, strict=False):
            near = motion.cloud.holds(points) if motion.cloud else False
            row |= near | along(points, motion, AFAR * self.tolerance, self.tolerance / STRICTER)
        return np.where(found.sum(axis=0) == 1, found.argmax(axis=0), -1)

    def learn(self, paths: Sequence[Sequence[np.ndarray]], labels: Sequence[int]) -> None:
        """Learn from the ends of runs whether motions recognised along their paths were right."""
        left, looks = [*zip(paths, labels, strict=True)], 0
        while left := [(path, label) for path, label in left if len(path) > looks]:
            looks += 1
            bound = self.bound(np.array([np.concatenate(path[:looks])[-TAIL:] for path, _ in left]))
            for (_, label), found in zip(left, bound.tolist(), strict=True):
                self.right[found] += found == label
                self.wrong |= {found} - {label}
            left = [each for each, found in zip(left, bound, strict=True) if found < 0]

    def recognised(self, points: np.ndarray) -> np.ndarray:
        """As `bound`, where that is to be relied on."""
        found = self.bound(points)
        good = [n for n, right in self.right.items() if right >= ENOUGH and n not in self.wrong]
        return np.where(np.isin(found, good), found, -1)
