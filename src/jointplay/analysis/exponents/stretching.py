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
    bundle = framed(model, Request(begin + span, rtol, max_steps=max_steps), exponents)
    rows, ended = follow(bundle, begin)
    turn = turn_period(model, rows)
    found = batch_means.estimates(rows, of_the_flow(bundle, exponents), turn)
    found |= section_exponents.estimates(rows, bundle.logs, turn, model, bundle.neutral)
    values = {key: value for key, (value, *_) in found.items()}
    return ended | values | {"grazing": bundle.grazing, "turn_period": turn}


def frame(count: int, scale: np.ndarray, last: int = 0) -> np.ndarray:
    """Reproducible random frame of `count` tangents, orthonormal in scales' units, 0 in `last` states."""
    size = len(scale) - last
    random = np.random.default_rng(SEED).normal(size=(size, size))
    return np.pad(np.linalg.qr(random)[0].T[:count], ((0, 0), (0, last))) * scale


def framed(model: Model, request: Request, count: int, saltation: bool = True) -> Bundle:
    """Prepare a run with `count` tangents, and one more where one direction is neutral.

    None has a part in what laws of contact remember at the start.
    """
    neutral = section_exponents.timeless(model)
    return Bundle(
        model,
        request,
        frame(count + neutral, scales(model), model.memories),
        tolerance=SOLVED * request.rtol,
        saltation=saltation,
        neutral=neutral,
    )


def of_the_flow(bundle: Bundle, count: int) -> slice:
    """Columns of the `count` tangents that were asked for."""
    return slice(bundle.logs.start, bundle.logs.start + count)


def follow(
    bundle: Bundle,
    begin: float,
    error: float | None = None,
    progress: Callable[[float], None] | None = None,
) -> tuple[np.ndarray, dict[str, Any]]:
    """Follow the transient, then blocks until the end, the target error or a failure: rows, how it ended.

    Rows are those of `Bundle.row`, and ln|F| (section_exponents).
    """
    began, status, end = time.perf_counter(), OK, bundle.request.duration

    def go_on(until: float = math.inf) -> int:
        try:
            return bundle.advance(until, tell)
        except Stopped:
            return INTERRUPTED

    def tell() -> None:
        if progress is not None:
            progress(bundle.time / end)

    if begin:
        status = go_on(begin)
    kept = [_row(bundle)]
    bundle.record((end - begin) / batch_means.BLOCKS)
    while status == OK:
        status = go_on()
        if status != bundle.full:
            break
        bundle.taken()
        kept.append(_row(bundle))
        status, look = OK, len(kept) % (batch_means.BLOCKS // LOOKS) == 1
        if error is not None and look and batch_means.settled(np.array(kept), bundle.logs, error):
            break
    if status in USABLE and bundle.time > kept[-1][0]:
        kept.append(_row(bundle))
    ended = {"status": status, "wall_time": time.perf_counter() - began, "counts": counts(bundle.x)}
    return np.array(kept), ended


def _row(bundle: Bundle) -> np.ndarray:
    """A row of where the run stands, with ln|F| as its last entry; 0 where no direction is neutral."""
    size = float(np.linalg.norm(bundle.rate() / scales(bundle.model))) if bundle.neutral else 1.0
    return np.append(bundle.row()[0], math.log(size) if size > 0.0 else -math.inf)


def turn_period(model: Model, rows: np.ndarray) -> float:
    """Mean length of a turn: of the crank where its angle is a state, else the nominal period."""
    crank = crank_place(model)
    if crank is None or len(rows) < 2:
        return model.period
    at = rows.shape[1] - 1 - len(model.state) + crank
    return 2 * math.pi * float((rows[-1, 0] - rows[0, 0]) / abs(rows[-1, at] - rows[0, at]))
