"""Sensitivity to the start: divergence of neighbours, and exponents over a plane of starts.

Neighbours: see `analysis.states.divergence`. Over a plane, each node's finite-time exponent follows from the
derivative P of the map over some turns, by the tangent flow with its saltations: it is ln of P's largest
singular value over the time taken, the growth of the difference that grows most. It depends on no first
direction, as the growth of one tangent would, and is the usual definition (S. C. Shadden, F. Lekien and J. E.
Marsden, Physica D 212 (2005) 271-304). Where a motor drives the crank, states are compared at equal crank
angle: with M the derivative at equal times and F the rate of the state there,

    P = (I - F grad_h' / (grad_h . F)) M,      h the crank's angle,

without the crank's angle itself; at equal times, a difference along the motion would hide all decay. States
are measured in the units of `analysis.tangents.scales`. Validity: a start whose motion grazes a guard has a
large exponent, and no derivative at the grazing itself.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any, Literal, Unpack

import numpy as np

from jointplay.analysis import rules
from jointplay.analysis.cells import handed_out, warm
from jointplay.analysis.declared import Outputs
from jointplay.analysis.evaluate import OUTCOME
from jointplay.analysis.exponents.batch_means import decided
from jointplay.analysis.exponents.growth import Turn, unresolved
from jointplay.analysis.keywords import HANDED, JointName, Moving, Plane, Settling, Small, analysis
from jointplay.analysis.labels import PLANE, Out, ended
from jointplay.analysis.quantities import STATUS
from jointplay.analysis.starts import crank_place
from jointplay.analysis.states.divergence import Divergence
from jointplay.analysis.states.start_plane import (
    Starts,
    axis_values,
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
from jointplay.solver.motion.trajectory import Request

if TYPE_CHECKING:
    import xarray as xr

NEIGHBOURS = 20
FINITE = "finite-time Lyapunov exponent"
DISTANCE = 1e-9
RTOL = 1e-12  # so that the runs' own errors stay far below the distance
BLOCK = 64  # nodes a cell
BAD = STATUS.index("bad_parameters")


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
    n_jobs: Natural | None = None,
    **motion: Unpack[Settling],
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
        Distance of the neighbours at the start, in scaled units (see `analysis.states.divergence`).
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
    n_jobs : int, optional
        Number of worker processes for the plane.

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
        found |= field(starts, axes, turns, rtol, limit, rest, n_jobs)
        over = starts.axes(axes)
        statuses.append(plane_status(found["node_status"]))
    return OUTPUTS.dataset(found | ended(max(statuses), began), plane=over)


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
    columns = (np.concatenate([each[name] for each in answers]).reshape(shape) for name in names)
    growth, time, status = columns
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
            return math.nan, math.nan, status or STATUS.index("not_converged")
        log += math.log(size)
        bundle.tangents.d[:] /= size  # the tangents' equations are linear
    ends = bundle.vectors
    if crank is not None:
        F = bundle.rate()
        ends = np.delete(ends - np.outer(ends[:, crank] / F[crank], F), crank, axis=1)
        scale = np.delete(scale, crank)
    return log + math.log(np.linalg.norm(ends / scale, 2)), duration, 0
