"""Divergence of neighbours from a motion, and its rate.

A motion is followed past its transient; neighbours start at one small distance from it, in directions drawn
at random, and are followed beside it. Distances are in the units of `analysis.tangents.scales` (a radian, the
longest link, the nominal speed; 1 for a test system's states). Where a crank turns (a system is forced),
states are compared as each passes the same angle (phase), the angle itself left out; else, or where asked, at
equal times. Modes are left out: neighbours start in the motion's own.

The growth is that of the mean logarithm of the distances between two levels: past the first turns, in which
the differences find the direction that grows most, and short of where they stay, at the size of the attractor
or at the accuracy of the runs. Increments of a turn scatter about it, since the motion stretches unevenly,
and what is left of a straight line is a random walk; for that the best slope is the mean increment, and its
standard error that of the mean, by overlapping batches. A single curve that grows fast leaves the range
early, which favours it; over many references, each with its own range, the mean of all increments has no such
bias (Wald's identity). `lyapunov` averages over long stretches instead.
After A. Wolf, J. B. Swift, H. L. Swinney and J. A. Vastano, Physica D 16 (1985) 285-317, with neighbours made
rather than found.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from jointplay.analysis import rules
from jointplay.analysis.exponents.growth import STATE, TIME, Turn
from jointplay.analysis.quantities import STATUS
from jointplay.analysis.starts import crank_place, state_names
from jointplay.analysis.states.start_plane import beyond_a_wall
from jointplay.analysis.tangents import scales
from jointplay.solver.mechanism.model import Model
from jointplay.solver.motion.trajectory import INTERRUPTED, Request, follow

ALIGN = 2  # turns in which differences find the direction that grows most
MARGIN = math.log(30)  # distance from the level of saturation at which a curve counts as exponential
FEWEST = 3  # increments of a turn that make a mean with an error
TAIL = 4  # curve over its last part, whose median is the level of saturation
BAD, FAILED = STATUS.index("bad_parameters"), STATUS.index("not_converged")


@dataclass(frozen=True)
class Divergence:
    """A motion with a bundle of neighbours: the keywords of `sensitivity`."""

    neighbours: int
    references: int
    distance: float
    turns: int
    samples_per_turn: int
    transient: int
    compare: str | None
    rtol: float
    seed: int
    max_steps: int | None

    def follow(self, model: Model, progress=None) -> tuple[dict[str, Any], int]:
        """Follow motion and neighbours: values, status."""
        cut = model.structure.section is not None and self.compare != "time"
        crank = crank_place(model) if cut else None
        names = state_names(model)
        left_out = [place for place, name in enumerate(names) if place == crank or name in model.modes]
        random = np.random.default_rng(self.seed)
        state, status = self._settled(model)
        many, bundles = self.turns * self.samples_per_turn + 1, (self.references, self.neighbours)
        distances, times = np.full((*bundles, many), np.nan), np.full((self.references, many), np.nan)
        ended = np.full(bundles, status or STATUS.index("not_run"), dtype=np.int8)
        for i in range(0 if status else self.references):
            starts = [state, *(state + self._offsets(random, model, left_out))]
            runs = [self._samples(model, start, cut) for start in starts]
            distances[i], times[i] = self._distances(model, runs, left_out), runs[0][1]
            ended[i] = [run[2] for run in runs[1:]]
            status = INTERRUPTED if INTERRUPTED in ended[i] else runs[0][2]
            state = runs[0][0][-1].copy()
            if crank is not None:
                state[crank] = model.crank_angle
            if progress is not None:
                progress((i + 1) / self.references)
            if status:
                break
        found = {"turn": np.arange(many) / self.samples_per_turn, "neighbour_status": ended}
        found |= self._values(distances, times)
        lost = FAILED if math.isnan(found["growth"]) else 0
        return found, int(status or ended.max()) or lost

    def _settled(self, model: Model) -> tuple[np.ndarray, int]:
        """The motion's state after the transient, and the status of the run."""
        if not self.transient:
            return model.state, 0
        if model.structure.section is not None:
            state, _, status = Turn(model, self.rtol, self.max_steps)(model.state, self.transient)
            return state, status
        end = self.transient * model.period
        request = Request(end, self.rtol, at=np.array([end]), max_steps=rules.steps(self.max_steps))
        records = follow(model, request)
        if records.status:
            return model.state, int(records.status)
        return records.samples[-1, 1 : 1 + len(model.state)], 0

    def _offsets(self, random: np.random.Generator, model: Model, left_out: list[int]) -> np.ndarray:
        """Differences of the neighbours from the motion, shape (neighbours, states)."""
        away = random.standard_normal((self.neighbours, len(model.state)))
        away[:, left_out] = 0.0
        return self.distance * away / np.linalg.norm(away, axis=1, keepdims=True) * scales(model)

    def _samples(self, model: Model, state: np.ndarray, cut: bool) -> tuple[np.ndarray, np.ndarray, int]:
        """States, the first included, shape (samples, states), times in s, and the status; NaN beyond."""
        model = replace(model, state=state)
        many, n = self.turns * self.samples_per_turn, len(state)
        states, times = np.full((many + 1, n), np.nan), np.full(many + 1, np.nan)
        states[0], times[0] = state, 0.0
        if beyond_a_wall(model):
            return states, times, BAD
        records = follow(model, self._request(model, cut, many))
        rows, first, time = (records.sections, STATE, TIME) if cut else (records.samples, 1, 0)
        states[1 : 1 + len(rows)], times[1 : 1 + len(rows)] = rows[:, first : first + n], rows[:, time]
        short = FAILED if len(rows) < many else 0  # the crank stopped turning
        return states, times, records.status or short

    def _request(self, model: Model, cut: bool, many: int) -> Request:
        limit = {"rtol": self.rtol, "max_steps": rules.steps(self.max_steps)}
        end = self.turns * model.period
        if not cut:
            return Request(end, at=np.linspace(0, end, many + 1)[1:], **limit)
        forward, part = model.forward, math.tau / self.samples_per_turn
        level = {"level": model.crank_angle + forward * part, "period": part, "direction": forward}
        return Request(rules.SLACK * end, stop_after=many, **level, **limit)

    def _distances(self, model: Model, runs: list, left_out: list[int]) -> np.ndarray:
        """Distances of the neighbours, shape (neighbours, samples)."""
        states, turning = np.array([run[0] for run in runs]), np.flatnonzero(model.fold)
        apart = states[1:] - states[0]
        apart[..., turning] = (apart[..., turning] + math.pi) % math.tau - math.pi
        apart /= scales(model)
        apart[..., left_out] = 0.0
        return np.linalg.norm(apart, axis=-1)

    def _values(self, distances: np.ndarray, times: np.ndarray) -> dict[str, Any]:
        means = np.log(np.maximum(distances, self.rtol)).mean(axis=1)  # the error of runs
        fit, periods = fit_growth(means, self.samples_per_turn), np.diff(times) * self.samples_per_turn
        period = float(periods[np.isfinite(periods)].mean()) if np.isfinite(periods).any() else math.nan
        return {
            "growth": fit.growth,
            "growth_standard_error": fit.error,
            "growth_rate": fit.growth / period,
            "growth_rate_standard_error": fit.error / period,
            "saturation": math.exp(fit.level),
            "mean_log_distance": means.mean(axis=0),
            "fitted_log_distance": fit.line(means),
            "distance": distances,
            "fit_turns": fit.ranges / self.samples_per_turn,
        }


@dataclass(frozen=True)
class Fit:
    """Growth a turn, its standard error, level of saturation; first and last sample used; samples a turn."""

    growth: float
    error: float
    level: float
    ranges: np.ndarray
    per_turn: int

    def line(self, means: np.ndarray) -> np.ndarray:
        """A line of that growth through the mean curve, over the median range; NaN outside it."""
        line, curve = np.full(means.shape[1], np.nan), means.mean(axis=0)
        first, last = np.median(self.ranges, axis=0).astype(int)
        i = np.arange(first, last + 1)
        line[i] = curve[i].mean() + self.growth * (i - i.mean()) / self.per_turn
        return line


def fit_growth(means: np.ndarray, per_turn: int) -> Fit:
    """Growth a turn of mean logarithms of distances, over the ranges in which they are exponential.

    Parameters
    ----------
    means : ndarray, shape (references, samples)
        Mean logarithm of the distance.
    per_turn : int
        Samples in a turn.

    Returns
    -------
    Fit
        Growth and error NaN where the ranges hold fewer than three turns; level NaN where distances have not
        reached saturation.
    """
    ranges, levels = zip(*(_range(curve, per_turn) for curve in means), strict=True)
    pairs = zip(means, ranges, strict=True)
    steps = [np.diff(curve[first : last + 1 : per_turn]) for curve, (first, last) in pairs]
    count = sum(map(len, steps))
    if count < FEWEST:
        return Fit(math.nan, math.nan, math.nan, np.array(ranges), per_turn)
    growth = float(np.concatenate(steps).mean())
    return Fit(growth, _error(steps, growth), float(np.mean(levels)), np.array(ranges), per_turn)


def _error(steps: list[np.ndarray], mean: float) -> float:
    """Standard error of the mean of stretches of increments, from overlapping batches within them.

    A batch is as long as the cube root of a stretch: a swing that comes back in the next turns counts as one.
    """
    count = sum(map(len, steps))
    size = max(1, int((count / len(steps)) ** (1 / 3)))
    rows = [np.convolve(each - mean, np.ones(size) / size, "valid") for each in steps if len(each) >= size]
    means = np.concatenate(rows)
    return math.sqrt(size * float(np.mean(means**2)) / (count - size))


def _range(curve: np.ndarray, per_turn: int) -> tuple[tuple[int, int], float]:
    """First and last sample, whole turns apart, of the exponential range; level of saturation."""
    first, last, level = min(ALIGN * per_turn, len(curve) - 1), len(curve) - 1, math.nan
    if not np.all(np.isfinite(curve)):
        return (0, 0), level
    tail = curve[-max(len(curve) // TAIL, 1) :]
    near = np.flatnonzero(np.abs(curve - np.median(tail)) < MARGIN)
    if near.size and near[0] < len(curve) - len(tail) and _flat(tail, curve[first : near[0] + 1]):
        level, last = float(np.median(tail)), max(int(near[0]), first)
    return (first, first + (last - first) // per_turn * per_turn), level


def _flat(tail: np.ndarray, before: np.ndarray) -> bool:
    """Whether the end of a curve has less than a quarter of the slope before it."""
    half = max(len(tail) // 2, 1)
    moved = abs(tail[-half:].mean() - tail[:half].mean()) / half
    return len(before) < 2 or moved < abs(before[-1] - before[0]) / (len(before) - 1) / 4
