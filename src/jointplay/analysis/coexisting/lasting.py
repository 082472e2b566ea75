"""The motions that last at one value of a parameter: starts followed until it is known where they end.

A start is followed in short stretches, until its section points show that it has reached a known motion or,
as far as others have shown that this can be told, is bound for one; after 48 turns, also where they spend
their time as a known motion without a period does. What has reached none in the transient's turns is observed
as in `analysis.states.ends`: it has a period, or none within the patience.

A motion without a period lasts, as far as one can tell, if none that was like it ended elsewhere while it was
looked at: the section points of each are compared, by shares of time (`analysis.states.ends`), with those
of motions that had no period at first and then settled. If some left, chaos was a transient, and what is
still in it is unsettled. What lasts is believed for as many turns as were looked at: with none lost in N
turns, less than 3/N leave in a turn, at 95 % (the rule of three).

Recognition by section points, from afar as far as others show that this is right: a start has reached a
periodic motion where it runs along that, point by point over two periods, within the tolerance and coming no
farther. It is bound for it where it does so within `AFAR` tolerances, and along no other. It is bound for a
motion without a period where its last points lie among those of starts that have stayed there, as near to
these as they lie to each other in all but one case in a hundred.

No theorem says that what is bound for a motion arrives. So that is tried on starts that are followed until
they have arrived: a motion is recognised from afar if for `ENOUGH` of them at least that would have been
right, and for none wrong. With n starts tried, drawn independently, less than 3/n of those to come are
mistaken, at 95 % (the rule of three).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from jointplay.analysis.period import REPEATS
from jointplay.analysis.states.ends import (
    POINTS,
    SHARED,
    STRICTER,
    Observation,
    by_histograms,
    features,
    histograms,
    section_states,
    set_distance,
    settled_period,
)
from jointplay.solver.mechanism.model import Model
from jointplay.solver.motion.progress import tick

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
        """Motion that each run is bound for, shape (runs,); -1: none, or one of several."""
        found = np.zeros((1 + len(self.known), len(points)), dtype=bool)
        for row, motion in zip(found, self.known, strict=False):
            near = motion.cloud.holds(points) if motion.cloud else False
            row |= near | along(points, motion, AFAR * self.tolerance, self.tolerance / STRICTER)
        return np.where(found.sum(axis=0) == 1, found.argmax(axis=0), -1)

    def learn(self, paths: Sequence[Sequence[np.ndarray]], labels: Sequence[int]) -> None:
        """Learn from the ends of runs whether motions recognised along their paths were right."""
        left, known = [*zip(paths, labels, strict=True)], 0
        while left := [(path, label) for path, label in left if len(path) > known]:
            known += 1
            bound = self.bound(np.array([np.concatenate(path[:known])[-TAIL:] for path, _ in left]))
            for (_, label), found in zip(left, bound.tolist(), strict=True):
                self.right[found] += found == label
                self.wrong |= {found} - {label}
            left = [each for each, found in zip(left, bound, strict=True) if found < 0]

    def recognised(self, points: np.ndarray) -> np.ndarray:
        """The value of `bound`, where that is to be relied on."""
        found = self.bound(points)
        good = [n for n, right in self.right.items() if right >= ENOUGH and n not in self.wrong]
        return np.where(np.isin(found, good), found, -1)


BLOCK, MORE = 64, 256  # starts at a time; those that may be recognised from afar
STRETCH = 8  # turns between two looks in the transient
UNSETTLED, FAILED, NO_START = -1, -2, -3  # in place of the number of a lasting motion
LEFT = 32  # motions kept that had no period at first and then settled


@dataclass
class _Run:
    """A start that is being followed: its model, present states and last section points."""

    model: Model
    states: np.ndarray
    points: np.ndarray | None


@dataclass
class Motions:
    """The lasting motions of a model, found as starts are sorted into them.

    Parameters
    ----------
    base : Model
        Whose crank angle is that of the section.
    observation : Observation
        How motions are followed.
    known : list of Lasting
        What is known of them beforehand; what is found is added.
    """

    base: Model
    observation: Observation
    known: list[Lasting] = field(default_factory=list)
    left: list[np.ndarray] = field(default_factory=list)  # features of motions before they settled
    turns: np.ndarray = field(default_factory=lambda: np.zeros(0, dtype=int))

    def sort(self, starts: Sequence[Model | None], pilots: int | None = None) -> np.ndarray:
        """Follow starts to their ends.

        Parameters
        ----------
        starts : sequence of Model or None
            None: no start.
        pilots : int, optional
            How many of the first are followed until they have arrived, all others less far where these show
            that it is enough; if left out, all are.

        Returns
        -------
        ndarray of int
            Of each start its index in `known`, or UNSETTLED, FAILED, NO_START. `turns` has those after which
            it was recognised, in whole stretches; -1: not within the transient's.
        """
        labels, self.turns = np.full(len(starts), NO_START), np.full(len(starts), -1)
        first, afar = 0, None
        while first < len(starts):
            size = BLOCK if pilots is None or first < pilots else MORE
            block = {n: starts[n] for n in range(first, min(first + size, len(starts))) if starts[n]}
            paths, first = self._sort(block, labels, None if size == BLOCK else afar), first + size
            if pilots is not None and size == BLOCK:
                afar = afar or FromAfar([*self.known], self.observation.tolerance)
                afar.learn([*paths.values()], labels[[*paths]].tolist())
        for index, motion in enumerate(self.known):
            if not motion.period and any(alike(motion.points, cloud) for cloud in self.left):
                labels[labels == index] = UNSETTLED  # those that left were seen only later
        return labels

    def _sort(self, block: dict[int, Model], labels: np.ndarray, afar: FromAfar | None) -> dict[int, list]:
        """Follow starts side by side; section points of each in the transient, by stretches."""
        nothing = np.zeros((0, len(self.base.state)))
        runs = {n: _Run(model, nothing, None) for n, model in block.items()}
        paths, left = {n: [] for n in runs}, self.observation.transient
        while runs and left > 0:
            turns = min(STRETCH, left)
            left -= turns
            self._advance(runs, turns, labels, TAIL)
            for n, run in runs.items():
                paths[n].append(run.points[-turns:])
            points = np.array([run.points for run in runs.values()])
            found = self._along(points) if runs else []
            if afar and runs:
                found = np.where(found < 0, afar.recognised(points), found)
            for n, index in zip([*runs], found, strict=True):
                if index >= 0:
                    labels[n], self.turns[n] = index, self.observation.transient - left
                    del runs[n]
            if self.observation.transient - left >= TAIL:
                self._like_known(runs, labels)
        self._observe(runs, labels)
        return paths

    def _advance(self, runs: dict[int, _Run], turns: int, labels: np.ndarray, keep: int) -> None:
        """Follow runs for some turns; failed ones are taken out."""
        if not runs:
            return
        tick()
        how = replace(self.observation, turns=turns)
        cuts = section_states(self.base, [run.model for run in runs.values()], 0, how)
        good = [(n, states) for n, (states, status, _) in zip([*runs], cuts, strict=True) if not status]
        for n in runs.keys() - {n for n, _ in good}:
            labels[n] = FAILED
            del runs[n]
        if not good:
            return
        points = np.split(features(self.base, np.concatenate([each for _, each in good])), len(good))
        for (n, states), each in zip(good, points, strict=True):
            old, start = runs[n], replace(self.base, state=states[-1])
            seen = (np.concatenate([old.states, states])[-keep:], each)
            before = [] if old.points is None else [old.points]
            runs[n] = _Run(start, seen[0], np.concatenate([*before, each])[-keep:])

    def _along(self, points: np.ndarray) -> np.ndarray:
        """Index of the known periodic motion along which each run goes; -1 if there is none."""
        tolerance, found = self.observation.tolerance, np.full(len(points), -1)
        for index, motion in enumerate(self.known):
            found[(found < 0) & along(points, motion, tolerance, tolerance / STRICTER)] = index
        return found

    def _observe(self, runs: dict[int, _Run], labels: np.ndarray) -> None:
        """Find periods of runs whose transient is over, or sort them by their shares of time."""
        for run in runs.values():
            run.states, run.points = run.states[:0], None
        watched = self.observation.turns
        for again in range(1 + self.observation.patience):
            before = {n: run.points for n, run in runs.items()}
            self._advance(runs, watched, labels, max(POINTS, watched))
            for n in [*runs]:
                if (found := self._settled(runs[n])) >= 0:
                    labels[n] = found
                    del runs[n]
                    if again:
                        self.left = [*self.left, before[n]][-LEFT:]
            if not again:
                self._like_known(runs, labels)
        self._without_period(runs, labels)

    def _settled(self, run: _Run) -> int:
        """Index of the periodic motion that a run has come to, which may be new; -1 if it has no period."""
        tolerance, points = self.observation.tolerance, run.points[-self.observation.turns :]
        repeats = settled_period(points, tolerance)
        if not repeats:
            return int(self._along(points[None])[0])
        last = points[-repeats:]
        for index, motion in enumerate(self.known):
            if motion.period == repeats and set_distance(motion.points[None], last)[0] <= tolerance:
                return index
        self.known.append(Lasting(repeats, run.states[-repeats:], last))
        return len(self.known) - 1

    def _like_known(self, runs: dict[int, _Run], labels: np.ndarray) -> None:
        """Take out runs with the shares of time of a known motion without a period."""
        for index, motion in enumerate(self.known):
            for n in [*runs] if not motion.period else []:
                if alike(motion.points, runs[n].points):
                    labels[n] = index
                    del runs[n]

    def _without_period(self, runs: dict[int, _Run], labels: np.ndarray) -> None:
        """Sort runs that have no period: new lasting motions, or unsettled where others like them left."""
        names, clouds = [*runs], [run.points for run in runs.values()]
        for group in by_histograms(clouds):
            members = [names[i] for i in group]
            lost = any(alike(runs[n].points, cloud) for n in members[:LEFT] for cloud in self.left)
            label = UNSETTLED if lost else self._index_of(runs[members[0]], [clouds[i] for i in group])
            for n in members:
                labels[n] = label
            if label >= 0:
                turns = (1 + self.observation.patience) * self.observation.turns
                self.known[label].watched += len(members) * turns

    def _index_of(self, run: _Run, clouds: Sequence[np.ndarray]) -> int:
        """Index of the motion without a period that a run shows; a new one if it is like none."""
        for index, motion in enumerate(self.known):
            if not motion.period and alike(motion.points, run.points):
                return index
        cloud = Cloud(np.array(clouds)) if len(clouds) > 1 else None
        self.known.append(Lasting(0, run.states, run.points, cloud=cloud))
        return len(self.known) - 1
