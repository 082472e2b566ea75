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
from collections.abc import Callable, Generator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from jointplay.analysis import rules as asked
from jointplay.analysis.cells import Read, Work, handed_out, warm
from jointplay.analysis.evaluate import flags
from jointplay.analysis.exponents.growth import Turn
from jointplay.analysis.quantities import STATUS
from jointplay.analysis.states import start_plane as planes
from jointplay.analysis.tangents import Bundle, scales
from jointplay.analysis.trajectory import Request
from jointplay.mechanism.model import Model

BLOCK = 64  # nodes a cell
BAD, CRASHED = STATUS.index("bad_parameters"), STATUS.index("crashed")


def field(
    mechanism,
    plane: Mapping[str, Any],
    turns: int,
    rtol: float,
    joint: str | None = None,
    initial: Any = None,
    max_steps: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> Generator[Work, Read, dict[str, Any]]:
    """Variables of the exponents over a plane that has been checked, as (dims, values, attributes)."""
    axes = planes.axes(plane)
    warm([planes.Starts(mechanism, initial, tuple(axes), joint).model])
    values = planes.nodes(axes)
    keywords = {"turns": turns, "rtol": rtol, "max_steps": max_steps}
    cells = planes.cells(mechanism, initial, joint, tuple(axes), values, BLOCK, **keywords)
    found = yield from handed_out(exponents, cells, progress)
    shape = tuple(map(len, axes.values()))
    columns = [_whole(each, len(cell["values"])) for each, cell in zip(found, cells, strict=True)]
    growth, time, status = (np.concatenate(part).reshape(shape) for part in zip(*columns, strict=True))
    return _variables(tuple(axes), growth, time, status.astype(np.int8), turns)


def _whole(found: dict[str, Any], count: int) -> tuple[np.ndarray, ...]:
    """Growth, time and status of a block's nodes; of one that crashed, NaN."""
    if "growth" in found:
        return found["growth"], found["time"], found["node_status"]
    return np.full(count, np.nan), np.full(count, np.nan), np.full(count, found["status"])


def _variables(dims, growth, time, status, turns: int) -> dict[str, Any]:
    name = "finite-time Lyapunov exponent"
    meanings = {"long_name": "how the node's run ended"} | flags(STATUS)
    return {
        "finite_time_exponent": (dims, growth / time, {"units": "s-1", "long_name": name}),
        "finite_time_exponent_per_turn": (
            dims,
            growth / turns,
            {"units": "1", "long_name": f"{name} a turn"},
        ),
        "field_turns": ((), np.int64(turns), {"units": "1", "long_name": "turns of the exponents"}),
        "node_status": (dims, status, meanings),
    }


def exponents(mechanism, initial, joint, names, values, turns: int, rtol: float, max_steps) -> dict[str, Any]:
    """Growth of the difference that grows most, from each of some nodes.

    Returns
    -------
    dict
        ``growth`` (logarithm), ``time`` (s) and ``node_status``, an entry a node; ``status``.
    """
    starts = planes.Starts(mechanism, initial, names, joint)
    rows = [_node(starts(value), turns, rtol, max_steps) for value in values]
    growth, time, status = map(np.array, zip(*rows, strict=True))
    return {"status": 0, "growth": growth, "time": time, "node_status": status}


def _node(model: Model | None, turns: int, rtol: float, max_steps) -> tuple[float, float, int]:
    if model is None:
        return math.nan, math.nan, BAD
    return stretch(model, turns, rtol, max_steps)


def stretch(model: Model, turns: int, rtol: float, max_steps: int | None = None) -> tuple[float, float, int]:
    """Follow a model from its start with all tangents.

    Parameters
    ----------
    model : Model
        Assembled with the section of `plane.section_of`.
    turns : int
        Turns of the crank, or nominal periods.
    rtol : float
        Relative tolerance of a step.
    max_steps : int, optional
        Attempted steps after which the run stops.

    Returns
    -------
    (float, float, int)
        Logarithm of the largest singular value; time taken, s; status.
    """
    duration, status, crank = turns * model.period, 0, None
    if model.structure.section is not None:
        turn = Turn(model, rtol, max_steps)
        crank = turn.crank
        if crank is not None:
            _, duration, status = turn(model.state, turns)
    if status:
        return math.nan, math.nan, status
    scale = scales(model)
    plain = replace(model, structure=replace(model.structure, section=None))
    request = Request(duration, rtol, max_steps=asked.steps(max_steps))
    frame = np.delete(np.diag(scale), [] if crank is None else [crank], axis=0)
    bundle, log = Bundle(plain, request, frame, held=True), 0.0
    for i in range(1, turns + 1):
        status = bundle.advance(duration if i == turns else duration * i / turns)
        size = float(np.abs(bundle.vectors / scale).max())
        if status or not (math.isfinite(size) and size > 0):
            return math.nan, math.nan, status or STATUS.index("not_converged")
        log += math.log(size)
        bundle.y.d[:] /= size  # the tangents' equations are linear
    ends = bundle.vectors
    if crank is not None:
        F = bundle.rate()
        ends = np.delete(ends - np.outer(ends[:, crank] / F[crank], F), crank, axis=1)
        scale = np.delete(scale, crank)
    return log + math.log(np.linalg.norm(ends / scale, 2)), duration, 0
