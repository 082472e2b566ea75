"""Sensitivity to the start: divergence of neighbours, and exponents over a plane of starts.

Over a plane, each node's finite-time exponent follows from the
derivative P of the map over some turns, by the tangent flow with its saltations: it is ln of P's largest
singular value over the time taken, the growth of the difference that grows most. It depends on no first
direction, as the growth of one tangent would, and is the usual definition (S. C. Shadden, F. Lekien and J. E.
Marsden, Physica D 212 (2005) 271-304). Where a motor drives the crank, states are compared at equal crank
angle: with M the derivative at equal times and F the rate of the state there,

    P = (I - F grad_h' / (grad_h . F)) M,      h the crank's angle,

without the crank's angle itself; at equal times, a difference along the motion would hide all decay. States
are measured in the units of `analysis.tangents.scales`. Validity: a start whose motion grazes a guard has a
large exponent, and no derivative at the grazing itself.

The divergence of neighbours: a motion is followed past its transient; neighbours start at one small distance
from it, in directions drawn at random, and are followed beside it. Distances are in the units of
`analysis.tangents.scales` (a radian, the longest link, the nominal speed; 1 for a test system's states).
Where a crank turns (a system is forced), states are compared as each passes the same angle (phase), the angle
itself left out; else, or where asked, at equal times. Modes are left out: neighbours start in the motion's
own.

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
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Annotated, Any, Literal, Unpack

import numpy as np

from jointplay.analysis import rules
from jointplay.analysis.cells import handed_out, warm
from jointplay.analysis.declared import Outputs
from jointplay.analysis.evaluate import OUTCOME
from jointplay.analysis.exponents.batch_means import decided
from jointplay.analysis.exponents.growth import STATE, TIME, Turn, unresolved
from jointplay.analysis.keywords import HANDED, Divided, JointName, Moving, Plane, Small, analysis
from jointplay.analysis.labels import PLANE, Out, ended, xr
from jointplay.analysis.quantities import STATUS
from jointplay.analysis.starts import crank_place, state_names
from jointplay.analysis.states.start_plane import (
    Starts,
    axis_values,
    beyond_a_wall,
    grid,
    plane_fits,
    plane_status,
    with_crashed,
)
from jointplay.analysis.tangents import Bundle, scales
from jointplay.display.errors import Problem
from jointplay.display.number_text import plain, signed
from jointplay.solver.mechanism.base import Count, Natural, accepts
from jointplay.solver.mechanism.model import Model
from jointplay.solver.mechanism.records import Mechanism, TestSystem
from jointplay.solver.motion.progress import part
from jointplay.solver.motion.trajectory import INTERRUPTED, Request, follow

NEIGHBOURS = 20
FINITE = "finite-time Lyapunov exponent"
DISTANCE = 1e-9
RTOL = 1e-12  # so that the runs' own errors stay far below the distance
BLOCK = 64  # nodes a cell
BAD, FAILED = STATUS.index("bad_parameters"), STATUS.index("not_converged")

ALIGN = 2  # turns in which differences find the direction that grows most
MARGIN = math.log(30)  # distance from the level of saturation at which a curve counts as exponential
FEWEST = 3  # increments of a turn that make a mean with an error
TAIL = 4  # curve over its last part, whose median is the level of saturation
NONE = "no growth was found, as where a motion is quasi-periodic; try other turns or distances, or lyapunov"


def _something_to_do(neighbours: int | None, plane: Any) -> Iterator[Problem]:
    if not _count(neighbours, plane) and plane is None:
        yield Problem("neighbours", neighbours, "a number of 1 or more, or a plane, is accepted")


def _resolved(neighbours: int | None, plane: Any, distance: float, rtol: float) -> Iterator[Problem]:
    if _count(neighbours, plane):
        yield from unresolved(distance, rtol)


def _samples_fit(
    turns: int, samples_per_turn: int, neighbours: int | None, plane: Any, references: int
) -> Iterator[Problem]:
    many = {"neighbours": _count(neighbours, plane), "references": references}
    yield from rules.too_many({"turns": turns, "samples_per_turn": samples_per_turn} | many)


def _compare_fits(mechanism: Mechanism | TestSystem, compare: str | None) -> Iterator[Problem]:
    if compare == "section" and isinstance(mechanism, TestSystem) and mechanism.period is None:
        yield Problem("compare", compare, "'time' is accepted where nothing turns")


def _transient_fits(neighbours: int | None, plane: Any, transient: int) -> Iterator[Problem]:
    if plane is not None and not _count(neighbours, plane) and transient:
        yield Problem("transient", transient, "0 is accepted without neighbours: a node is a start")


def answer(result: xr.Dataset) -> str:
    """The growth of a small difference, and the exponents over a plane of starts."""
    lines = []
    if "growth" in result:
        value, error = (float(result[name]) for name in ("growth", "growth_standard_error"))
        word = decided(result["growth"], result["growth_standard_error"], "it grows", "it shrinks").item()
        lines.append(
            f"the logarithm of a small difference changes by {signed(value, error)} per turn: {word}"
            if math.isfinite(value)
            else "the growth was not measured: distances grew for fewer than three turns"
        )
    if "finite_time_exponent_per_turn" in result:
        values = result["finite_time_exponent_per_turn"].values
        known = values[np.isfinite(values)]
        if known.size:
            ends = f"from {plain(float(known.min()), 3)} to {plain(float(known.max()), 3)}"
            share = f"{np.count_nonzero(known > 0)} of {known.size} starts"
            lines.append(f"finite-time exponents {ends} per turn, above 0 at {share}")
    return "\n".join(lines)


def verdict(result: xr.Dataset) -> xr.DataArray:
    """Whether differences grow or shrink in each run."""
    return decided(result["growth"], result["growth_standard_error"], "grows", "shrinks")


OUTPUTS = Outputs(
    "sensitivity",
    {"turn": Out("turn", "turns since the neighbours started")},
    {
        "growth": Out(
            (),
            "growth of the mean logarithm of the distance in a turn",
            about="NaN where distances grew over fewer than three turns beyond the first two",
        ),
        "growth_standard_error": Out((), "standard error of the growth"),
        "growth_rate": Out((), "growth of the mean logarithm of the distance", "s-1"),
        "growth_rate_standard_error": Out((), "standard error of the growth rate", "s-1"),
        "saturation": Out(
            (), "distance at which the neighbours stay", about="NaN where they stay at no level yet"
        ),
        "mean_log_distance": Out("turn", "mean natural logarithm of the distance"),
        "fitted_log_distance": Out(
            "turn", "logarithm of the distance as fitted", about="NaN outside the range of the fit"
        ),
        "distance": Out(("reference", "neighbour", "turn"), "scaled distance from the motion"),
        "fit_turns": Out(("reference", "end"), "first and last turn of the fit"),
        "neighbour_status": Out(("reference", "neighbour"), "how the neighbour's run ended", flags=STATUS),
        "finite_time_exponent": Out(PLANE, FINITE, "s-1"),
        "finite_time_exponent_per_turn": Out(PLANE, f"{FINITE} per turn"),
        "field_turns": Out((), "turns of the exponents"),
        "node_status": Out(PLANE, "how the node's run ended", flags=STATUS),
    }
    | OUTCOME,
    answer,
    verdict,
    shown={"growth": ""},
)


@analysis(
    _something_to_do,
    _resolved,
    _samples_fit,
    _compare_fits,
    _transient_fits,
    plane_fits,
    "model",
    rules.turns_alike,
    usual={"rtol": RTOL, "transient": 0},
    outputs=OUTPUTS,
    model=rules.on_section,
)
def sensitivity(  # noqa: D417 (nobody gives it the model)
    mechanism: Moving,
    *,
    model: Model = HANDED,
    neighbours: Count | None = None,
    references: Natural = 1,
    distance: Small = DISTANCE,
    turns: Natural = 40,
    samples_per_turn: Natural = 1,
    compare: Annotated[Literal["section", "time"], accepts('"section" or "time"')] | None = None,
    plane: Plane | None = None,
    joint: JointName | None = None,
    seed: Count = 0,
    **motion: Unpack[Divided],
) -> xr.Dataset:
    """Follow a bundle of neighbours of a motion, or exponents over a plane of initial states, or both.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        What moves.
    neighbours : int, optional
        Number of neighbours of each reference state; 20 if left out, none beside a `plane`.
    references : int
        Number of states of the motion that have neighbours, `turns` apart; their curves are averaged.
    distance : float
        Distance of the neighbours at the start, in the units of `analysis.tangents.scales`.
    turns : int
        Number of turns of the crank, or periods of the forcing, for which all are followed.
    samples_per_turn : int
        How many times in a turn the states are compared.
    transient : int
        Number of turns of the motion before its neighbours start; it holds for the bundle only.
    compare : {"section", "time"}, optional
        Whether states are compared at equal angle of the crank (``section``) or at equal times; the first if
        left out, wherever something turns.
    plane : mapping, optional
        Two coordinates of the start, each with its values: a rising list, or ``start``, ``stop`` and ``num``.
        Of a test system two states; of a linkage ``crank_angle``, ``crank_speed``, ``journal_x``,
        ``journal_y`` (m), ``eccentricity_ratio_x``, ``eccentricity_ratio_y`` (the same over the clearance),
        ``journal_velocity_x``, ``journal_velocity_y`` (m/s), or states.
    joint : str, optional
        Joint whose journal the plane is of; the only one with clearance if left out.
    initial : optional
        As in `lyapunov`: the start that the plane goes through.
    seed : int
        Seed of the random directions of the neighbours.

    Raises
    ------
    InputError
        Listing everything that makes no sense; numerical trouble is a status instead.
    """
    rtol, initial, limit, progress = (motion[key] for key in ("rtol", "initial", "max_steps", "progress"))
    own = (references, distance, turns, samples_per_turn, motion["transient"], compare, rtol, seed, limit)
    bundle = Divergence(_count(neighbours, plane), *own)
    began, found, over, statuses = time.perf_counter(), {}, {}, []
    if bundle.neighbours:
        share = 0.5 if plane is not None else 1.0
        found, status = bundle.follow(model, part(progress, 0.0, share))
        statuses.append(status)
    if plane is not None:
        rest = part(progress, 0.5 if bundle.neighbours else 0.0, 1.0)
        starts, axes = Starts(mechanism, initial, tuple(plane), joint, model), axis_values(plane)
        found |= field(starts, axes, turns, rtol, limit, rest, motion["n_jobs"])
        over = starts.axes(axes)
        statuses.append(plane_status(found["node_status"]))
    lost = statuses[0] == FAILED == max(statuses) and np.isfinite(found.get("distance", np.nan)).all()
    attributes = {"trouble": NONE} if lost else {}
    return OUTPUTS.dataset(found | ended(max(statuses), began), plane=over, **attributes)


def _count(neighbours: Any, plane: Any) -> Any:
    """Number of neighbours, by default 20, or 0 with a plane."""
    return (NEIGHBOURS if plane is None else 0) if neighbours is None else neighbours


def field(
    starts: Starts,
    axes: Mapping[str, np.ndarray],
    turns: int,
    rtol: float,
    max_steps: int | None = None,
    progress: Callable[[float], None] | None = None,
    n_jobs: int | None = None,
) -> dict[str, Any]:
    """Values of the exponents over the values along the axes of a plane of starts."""
    warm([starts.model])
    cells = starts.cells(grid(axes), BLOCK, turns=turns, rtol=rtol, max_steps=max_steps)
    answers = handed_out(exponents, cells, progress, n_jobs)
    answers = with_crashed(answers, cells, growth=math.nan, time=math.nan)
    shape, names = tuple(map(len, axes.values())), ("growth", "time", "node_status")
    growth, time, status = (np.concatenate([each[n] for each in answers]).reshape(shape) for n in names)
    found = {"finite_time_exponent": growth / time, "finite_time_exponent_per_turn": growth / turns}
    return found | {"field_turns": np.int64(turns), "node_status": status}


def exponents(starts: Starts, nodes: np.ndarray, turns: int, rtol: float, max_steps) -> dict[str, Any]:
    """Growth of the difference that grows most, from each of some nodes.

    Returns
    -------
    dict
        ``growth`` (logarithm), ``time`` (s) and ``node_status``, an entry a node; ``status``.
    """
    models, none = starts.all(nodes), (math.nan, math.nan, BAD)
    rows = [none if model is None else stretch(model, turns, rtol, max_steps) for model in models]
    growth, time, status = map(np.array, zip(*rows, strict=True))
    return {"status": 0, "growth": growth, "time": time, "node_status": status}


def stretch(model: Model, turns: int, rtol: float, max_steps: int | None = None) -> tuple[float, float, int]:
    """Follow a model from its start, with all tangents, for some turns or nominal periods.

    Returns
    -------
    (float, float, int)
        Logarithm of the largest singular value; time taken, s; status.
    """
    duration, crank = turns * model.period, crank_place(model)
    if crank is not None:
        _, duration, status = Turn(model, rtol, max_steps)(model.state, turns)
        if status:
            return math.nan, math.nan, status
    scale = scales(model)
    plain = replace(model, structure=replace(model.structure, section=None))
    request = Request(duration, rtol, max_steps=rules.steps(max_steps))
    frame = np.delete(np.diag(scale), [] if crank is None else [crank], axis=0)
    bundle, log = Bundle(plain, request, frame, held=True), 0.0
    for i in range(1, turns + 1):
        status = bundle.advance(duration if i == turns else duration * i / turns)
        size = float(np.abs(bundle.vectors / scale).max())
        if status or not (math.isfinite(size) and size > 0):
            return math.nan, math.nan, status or FAILED
        log += math.log(size)
        bundle.tangents.d[:] /= size  # the tangents' equations are linear
    ends = bundle.vectors
    if crank is not None:
        F = bundle.rate()
        ends = np.delete(ends - np.outer(ends[:, crank] / F[crank], F), crank, axis=1)
        scale = np.delete(scale, crank)
    return log + math.log(np.linalg.norm(ends / scale, 2)), duration, 0


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
        return found, int(status or ended.max()) or FAILED * math.isnan(found["growth"])

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
        records = rules.to_the_section(model, self._request(model, cut, many))
        rows, first, time = (records.sections, STATE, TIME) if cut else (records.samples, 1, 0)
        states[1 : 1 + len(rows)], times[1 : 1 + len(rows)] = rows[:, first : first + n], rows[:, time]
        return states, times, records.status

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
