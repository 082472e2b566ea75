"""Finite-time Lyapunov exponents over a plane of initial states.

At each node, the derivative P of the map over some turns, by the tangent flow with its saltations; the
exponent is ln of P's largest singular value over the time taken: the growth of the difference that grows
most. It depends on no first direction, as the growth of one tangent would, and is the usual definition (S. C.
Shadden, F. Lekien and J. E. Marsden, Physica D 212 (2005) 271-304). Where a motor drives the crank, states
are compared at equal crank angle: with M the derivative at equal times and F the rate of the state there,

    P = (I - F grad_h' / (grad_h . F)) M,      h the crank's angle,

without the crank's angle itself; at equal times, a difference along the motion would hide all decay. States
are measured in the units of `analysis.tangents.scales`. Validity: a start whose motion grazes a guard has a
large exponent, and no derivative at the grazing itself.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from jointplay.analysis import rules
from jointplay.analysis.cells import handed_out, warm
from jointplay.analysis.exponents.growth import Turn
from jointplay.analysis.quantities import STATUS
from jointplay.analysis.starts import crank_place
from jointplay.analysis.states.start_plane import Starts, grid, with_crashed
from jointplay.analysis.tangents import Bundle, scales
from jointplay.solver.mechanism.model import Model
from jointplay.solver.motion.trajectory import Request

BLOCK = 64  # nodes a cell
BAD = STATUS.index("bad_parameters")


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
