"""Lyapunov exponents of a motion through its contacts, each with an error bar and an independent check."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import numpy as np
import xarray as xr

from jointplay.analysis import request as asked
from jointplay.analysis.quantities import dataset, scalars
from jointplay.analysis.run import Request, counts
from jointplay.analysis.tangents import Bundle, scales
from jointplay.codegen import cache
from jointplay.errors import InputError, Problem
from jointplay.mechanism.assemble import assemble
from jointplay.mechanism.records import Mechanism, TestSystem
from jointplay.mechanism.scene import Scene

BATCHES = 40  # of the error bar
BLOCKS = 400  # rows of the convergence trace, at most; a multiple of BATCHES
LOOKS = 10  # how often a target error is looked at
SEED = 20
OK = 0
SOLVED = 1.0  # tolerance of the tangents' iteration, in units of rtol


def lyapunov(
    mechanism: Mechanism | TestSystem,
    *,
    exponents: int | str = 1,
    turns: float | None = None,
    duration: float | None = None,
    transient: float = 0,
    rtol: float = 1e-8,
    error: float | None = None,
    initial: Any = None,
    saltation: bool = True,
    max_steps: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Give the leading Lyapunov exponents of a motion.

    Tangents are carried along in the same steps, through every event by its saltation matrix, and made
    orthonormal after each step (Benettin et al. 1980). The error bar is that of batch means over 40 batches;
    it says how much the mean would differ on another stretch of the same length, if the batches are long
    compared to the motion's memory.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        What moves.
    exponents : int or "all"
        How many, the largest first.
    turns, duration : float
        Length after the transient: nominal turns of the crank (or forcing periods), or s. One of them. The
        budget, where `error` is given.
    transient : float
        Turns that motion and tangents are followed first.
    rtol : float
        Tolerated error of a step.
    error : float, optional
        Standard error of the largest exponent, 1/s, at which the run stops.
    initial, max_steps, progress
        As in `simulate`.
    saltation : bool
        False leaves the tangents' jumps at events out, as a comparison: the result is then wrong wherever a
        force jumps.

    Returns
    -------
    xarray.Dataset
        ``lyapunov_exponent`` and ``lyapunov_standard_error`` (1/s), both also per turn, over ``exponent``;
        ``lyapunov_trace`` (running means) over ``block`` and ``exponent``, at ``block_time``; ``sum_residual``
        (1/s; of a whole spectrum), ``mean_divergence`` and ``volume_share``: see Notes; ``grazing`` and
        ``status``.

    Raises
    ------
    InputError
        If anything asked for makes no sense; numerical trouble is a status instead.

    Notes
    -----
    The sum of all exponents is the mean divergence: trace of the Jacobian, and ln|det S| of the jumps.
    ``sum_residual`` is the difference. A direction that shrinks by more than a factor 50 within a step is
    followed to zero, but not at its true rate; there the last exponent of a whole spectrum is what the volume
    leaves for it, and ``volume_share`` is the share of time in which that was so. An exponent is minus
    infinity where sticking loses a dimension. ``grazing`` is the smallest approach speed of a guard at an
    event relative to the terms that it is a sum of: near 0, exponents are uncertain.
    """
    asked.check(mechanism, turns, duration, transient, rtol, max_steps)
    scene = assemble(mechanism, initial)
    _check(exponents, error, saltation, len(scene.state))
    count = len(scene.state) if exponents == "all" else int(exponents)
    begin = transient * scene.period
    span = duration if turns is None else turns * scene.period
    request = Request(begin + span, rtol, max_steps=asked.steps(max_steps))
    bundle = _bundle(scene, request, count, saltation)
    rows, ended = _follow(bundle, begin, error, progress)
    return _dataset(scene, bundle, rows, ended)


def _check(exponents: Any, error: Any, saltation: Any, states: int) -> None:
    found = list(_problems(exponents, error, saltation, states))
    if found:
        raise InputError(found)


def _problems(exponents: Any, error: Any, saltation: Any, states: int) -> Iterator[Problem]:
    whole = isinstance(exponents, int) and not isinstance(exponents, bool)
    if exponents != "all" and not (whole and 1 <= exponents <= states):
        accepted = f'a whole number from 1 to {states}, or "all", is accepted'
        yield Problem("exponents", exponents, accepted)
    if error is not None and not (isinstance(error, int | float) and 0 < error < math.inf):
        yield Problem("error", error, "a standard error greater than 0 (1/s) is accepted")
    if not isinstance(saltation, bool):
        yield Problem("saltation", saltation, "true or false is accepted")


def frame(count: int, scale: np.ndarray) -> np.ndarray:
    """A frame in general position, orthonormal in units of the scales; the same each time."""
    random = np.random.default_rng(SEED).normal(size=(len(scale), len(scale)))
    return np.linalg.qr(random)[0].T[:count] * scale


def _bundle(scene: Scene, request: Request, count: int, saltation: bool) -> Bundle:
    return Bundle(
        scene,
        request,
        frame(count, scales(scene)),
        tolerance=SOLVED * request.rtol,
        saltation=saltation,
        rows=BLOCKS // LOOKS,
    )


def _follow(bundle: Bundle, begin: float, error: float | None, progress) -> tuple[np.ndarray, dict[str, Any]]:
    """Transient, then blocks until the end, the target error, or trouble: rows, and how it ended."""
    began, status, end = time.perf_counter(), OK, bundle.request.duration
    if begin:
        status = bundle.advance(begin)
    rows = bundle.row()
    bundle.record((end - begin) / BLOCKS)
    while status == OK:
        status = bundle.advance()
        rows = np.concatenate([rows, bundle.taken()])
        if progress is not None:
            progress(min(1.0, bundle.time / end))
        if status != bundle.full:
            break
        status = OK
        if error is not None and _standard_error(rows, bundle.logs)[0] <= error:
            break
    if status == OK and bundle.time > rows[-1, 0]:
        rows = np.concatenate([rows, bundle.row()])
    return rows, {"status": status, "wall_time": time.perf_counter() - began, "counts": counts(bundle.x)}


def _growth(rows: np.ndarray, logs: slice) -> np.ndarray:
    """Mean growth rates over the rows, by vector; minus infinity where a dimension was lost."""
    if len(rows) < 2:
        return np.full(rows[:0, logs].shape[1], np.nan)
    with np.errstate(invalid="ignore"):
        found = (rows[-1, logs] - rows[0, logs]) / (rows[-1, 0] - rows[0, 0])
    return np.where(np.isneginf(rows[-1, logs]), -np.inf, found)


def _standard_error(rows: np.ndarray, logs: slice) -> np.ndarray:
    """Standard errors of the mean growth rates, from the means of up to 40 batches."""
    ends = np.unique(np.linspace(0, len(rows) - 1, BATCHES + 1).astype(int)) if len(rows) else []
    if len(ends) < 3:
        return np.full(rows[:0, logs].shape[1], np.nan)
    means = np.array([_growth(rows[[a, b]], logs) for a, b in pairwise(ends)])
    finite = np.all(np.isfinite(means), axis=0)
    spread = np.std(np.where(finite, means, 0.0), axis=0, ddof=1) / math.sqrt(len(means))
    return np.where(finite, spread, np.nan)


def _dataset(scene: Scene, bundle: Bundle, rows: np.ndarray, ended: dict[str, Any]) -> xr.Dataset:
    logs, turn = bundle.logs, _turn(scene, rows)
    found = _growth(rows, logs)
    order = np.argsort(-found)
    values, errors = found[order], _standard_error(rows, logs)[order]
    name = "Lyapunov exponent"
    variables = {
        "lyapunov_exponent": ("exponent", values, {"units": "s-1", "long_name": name}),
        "lyapunov_standard_error": (
            "exponent",
            errors,
            {"units": "s-1", "long_name": f"standard error of the {name}"},
        ),
        "lyapunov_exponent_per_turn": (
            "exponent",
            values * turn,
            {"units": "1", "long_name": f"{name} a turn"},
        ),
        "lyapunov_standard_error_per_turn": (
            "exponent",
            errors * turn,
            {"units": "1", "long_name": f"standard error of the {name} a turn"},
        ),
    }
    variables |= (
        _trace(rows, logs, order)
        | _checks(rows, found, len(scene.state))
        | {
            "turn_period": ((), turn, {"units": "s", "long_name": "mean period of a turn"}),
            "grazing": (
                (),
                bundle.grazing,
                {"units": "1", "long_name": "smallest relative approach to a guard"},
            ),
        }
    )
    variables |= scalars(scene, SimpleNamespace(**ended))
    number = (
        "exponent",
        np.arange(1, len(values) + 1),
        {"units": "1", "long_name": "number of the exponent"},
    )
    return dataset(scene, variables, {"exponent": number}, "lyapunov")


def _turn(scene: Scene, rows: np.ndarray) -> float:
    """Mean length of a turn: of the crank where its angle is a state, else the nominal period."""
    state = cache.structure_module(scene.structure).STATE[1:]
    angle = f"theta_{scene.crank}"
    if angle not in state or len(rows) < 2:
        return scene.period
    at = rows.shape[1] - len(state) + state.index(angle)
    return 2 * math.pi * float((rows[-1, 0] - rows[0, 0]) / abs(rows[-1, at] - rows[0, at]))


def _trace(rows: np.ndarray, logs: slice, order: np.ndarray) -> dict[str, Any]:
    """Running means at the ends of blocks."""
    means = [_growth(rows[[0, i]], logs)[order] for i in range(1, len(rows))]
    values = np.array(means).reshape(-1, len(order))
    return {
        "lyapunov_trace": (
            ("block", "exponent"),
            values,
            {"units": "s-1", "long_name": "Lyapunov exponent up to the end of the block"},
        ),
        "block_time": ("block", rows[1:, 0], {"units": "s", "long_name": "end of the block"}),
    }


def _checks(rows: np.ndarray, found: np.ndarray, states: int) -> dict[str, Any]:
    """Sum rule of a whole spectrum."""
    trace, volume, unresolved = _growth(rows, slice(1, 4))
    with np.errstate(invalid="ignore"):
        residual = abs(found.sum() - trace - volume) if len(found) == states else math.nan
    return {
        "mean_divergence": (
            (),
            trace + volume,
            {"units": "s-1", "long_name": "mean divergence of the flow, with its jumps"},
        ),
        "sum_residual": ((), residual, {"units": "s-1", "long_name": "sum of exponents less divergence"}),
        "volume_share": (
            (),
            unresolved if len(found) == states else 0.0,
            {"units": "1", "long_name": "share of time in which the last exponent is by volume"},
        ),
    }
