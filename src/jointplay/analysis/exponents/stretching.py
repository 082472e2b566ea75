"""Growth of a frame of tangents along a motion, recorded block by block, to estimate exponents from."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from jointplay.analysis.exponents import batch_means, section_exponents
from jointplay.analysis.looks import Stopped
from jointplay.analysis.starts import crank_place
from jointplay.analysis.tangents import Bundle, scales
from jointplay.analysis.trajectory import INTERRUPTED, MAX_STEPS, Request, counts
from jointplay.mechanism.model import Model

LOOKS = 10  # how often a target error is looked at
SEED = 20
OK = 0
USABLE = (OK, INTERRUPTED)  # ends of a run whose means are those of the time that it reached
SOLVED = 3.0  # tolerance of the tangents' iteration, in units of rtol


def leading(
    model: Model, *, exponents: int, begin: float, span: float, rtol: float, max_steps: int = MAX_STEPS
) -> dict[str, Any]:
    """Leading exponents over `span` s of a motion, after `begin` s in which tangents find their directions.

    Returns
    -------
    dict
        ``status``, ``counts``, ``grazing``, ``turn_period``, and the values of `batch_means.estimates` and
        `section_exponents.estimates`.
    """
    request = Request(begin + span, rtol, max_steps=max_steps)
    bundle, rows, ended = grown(model, request, exponents, begin)
    turn = turn_period(model, rows)
    found = batch_means.estimates(*of_the_flow(bundle, rows, exponents), turn)
    found |= section_exponents.estimates(bundle, rows, turn)
    values = {key: value for key, (value, *_) in found.items()}
    return ended | values | {"grazing": bundle.grazing, "turn_period": turn}


def of_the_flow(bundle: Bundle, rows: np.ndarray, count: int) -> tuple[np.ndarray, slice]:
    """Rows with the logarithms of the `count` directions that grow fastest, these first; their columns."""
    begin, end = bundle.logs.start, bundle.logs.stop
    order = np.argsort(-batch_means.growth(rows, bundle.logs))[:count]
    columns = (rows[:, :begin], rows[:, bundle.logs][:, order], rows[:, end:])
    return np.column_stack(columns), slice(begin, begin + count)


def grown(
    model: Model,
    request: Request,
    count: int,
    begin: float,
    error: float | None = None,
    saltation: bool = True,
    progress: Callable[[float], None] | None = None,
) -> tuple[Bundle, np.ndarray, dict[str, Any]]:
    """Follow a motion with the tangents that `count` exponents need: the run, its rows, how it ended.

    Where the motion comes to rest, its rate is no direction any more, and it is followed anew without that.
    """
    timeless = section_exponents.timeless(model)
    for neutral in (True, False) if timeless else (False,):
        bundle = framed(model, request, count, saltation, neutral)
        bundle.rested = timeless and not neutral
        bundle.advance(0.0)
        start = float(bundle.y.logs[0])
        rows, ended = follow(bundle, begin, error, progress)
        if not neutral or section_exponents.moves(bundle, start):
            break
    return bundle, rows, ended


def frame(count: int, scale: np.ndarray, last: int = 0) -> np.ndarray:
    """Reproducible random frame of `count` tangents, orthonormal in scales' units, 0 in `last` states."""
    size = len(scale) - last
    random = np.random.default_rng(SEED).normal(size=(size, size))
    return np.pad(np.linalg.qr(random)[0].T[:count], ((0, 0), (0, last))) * scale


def framed(
    model: Model, request: Request, count: int, saltation: bool = True, neutral: bool = False
) -> Bundle:
    """Prepare a run with `count` tangents, and the motion's own before them where that is neutral.

    None has a part in what laws of contact remember at the start.
    """
    wanted, tolerance = frame(count + neutral, scales(model), model.memories), SOLVED * request.rtol
    rows = batch_means.BLOCKS // LOOKS
    return Bundle(model, request, wanted, tolerance, saltation, rows=rows, neutral=neutral)


def follow(
    bundle: Bundle,
    begin: float,
    error: float | None = None,
    progress: Callable[[float], None] | None = None,
) -> tuple[np.ndarray, dict[str, Any]]:
    """Follow the transient, then blocks until the end, the target error or a failure: rows, how it ended."""
    began, status, end = time.perf_counter(), OK, bundle.request.duration

    def go_on(until: float = math.inf) -> int:
        try:
            return bundle.advance(until, tell)
        except Stopped:
            return INTERRUPTED

    def tell() -> None:
        if progress is not None:
            progress(bundle.time / end)

    status = go_on(begin)
    kept = bundle.row()
    bundle.record((end - begin) / batch_means.BLOCKS)
    while status == OK:
        status = go_on()
        kept = np.concatenate([kept, bundle.taken()])
        if status != bundle.full:
            break
        status = OK
        if error is not None and batch_means.settled(kept, bundle.carried, error):
            break
    if status in USABLE and bundle.time > kept[-1, 0]:
        kept = np.concatenate([kept, bundle.row()])
    ended = {"status": status, "wall_time": time.perf_counter() - began, "counts": counts(bundle.x)}
    return kept, ended


def turn_period(model: Model, rows: np.ndarray) -> float:
    """Mean length of a turn: of the crank where its angle is a state, else the nominal period."""
    crank = crank_place(model)
    if crank is None or len(rows) < 2:
        return model.period
    at = rows.shape[1] - len(model.state) + crank
    return 2 * math.pi * float((rows[-1, 0] - rows[0, 0]) / abs(rows[-1, at] - rows[0, at]))
