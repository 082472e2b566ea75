"""Exponents from a record of growing tangents: means, error bars, and whether these can be trusted.

Rows hold time, the sums of trace, of ln|det S| and of time by volume, then the logarithms of the tangents'
lengths, then the state. The error bar is that of batch means: the record is cut into 40 batches, and the
spread of their means, over the root of their number, is the standard error of the whole. Reference: H.
Flyvbjerg and H. G. Petersen, J. Chem. Phys. 91 (1989) 461-466.

Validity: batches must be longer than the motion's memory. Two numbers tell: the correlation of each batch's
mean with the next one's, which lies within 2/sqrt(40) = 0.32 of 0 in 95 of 100 such cases, and the effective
number of blocks, that of independent blocks of this scatter that would have this error.

A motion is called chaotic only where the largest exponent of its section's map is above 0 by more than three
standard errors and by more than ln N / N after N turns, since neighbours of a motion that neither settles nor
is chaotic part as N; and stable where it is below 0 by three errors. All else is undecided. An error bar
whose batches follow one another is too small, and is widened before it decides: means of correlation r from
one to the next have the error of independent ones times sqrt((1 + r)/(1 - r)).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from jointplay.analysis.labels import KEPT, Out, xr
from jointplay.display import codes

BATCHES = 40
BLOCKS = 400  # rows of a whole record; a multiple of BATCHES
SUMS = slice(1, 4)  # trace, volume, time by volume


def growth(rows: np.ndarray, logs: slice) -> np.ndarray:
    """Mean growth rates over the rows, by vector; minus infinity where a dimension was lost."""
    if len(rows) < 2:
        return np.full(rows[:0, logs].shape[1], np.nan)
    with np.errstate(invalid="ignore"):
        means = (rows[-1, logs] - rows[0, logs]) / (rows[-1, 0] - rows[0, 0])
    return np.where(np.isneginf(rows[-1, logs]), -np.inf, means)


def rates(rows: np.ndarray, logs: slice, parts: int) -> np.ndarray:
    """Growth rates in up to so many stretches of equally many rows, shape (stretches, vectors)."""
    ends = np.unique(np.linspace(0, len(rows) - 1, parts + 1).astype(int)) if len(rows) else np.zeros(0, int)
    with np.errstate(invalid="ignore"):
        return np.diff(rows[ends, logs], axis=0) / np.diff(rows[ends, 0])[:, None]


def standard_error(rows: np.ndarray, logs: slice) -> np.ndarray:
    """Standard errors of the mean growth rates by batch means; NaN where a rate is not finite."""
    means = rates(rows, logs, BATCHES)
    if len(means) < 2:
        return np.full(rows[:0, logs].shape[1], np.nan)
    finite = np.all(np.isfinite(means), axis=0)
    spread = np.std(np.where(finite, means, 0.0), axis=0, ddof=1) / math.sqrt(len(means))
    return np.where(finite, spread, np.nan)


def batch_correlation(rows: np.ndarray, logs: slice) -> np.ndarray:
    """Correlation of each batch mean with the next; NaN where they do not vary."""
    means = rates(rows, logs, BATCHES)
    if len(means) < 3:
        return np.full(rows[:0, logs].shape[1], np.nan)
    with np.errstate(invalid="ignore", divide="ignore"):
        away = means - means.mean(axis=0)
        return np.sum(away[1:] * away[:-1], axis=0) / np.sum(away**2, axis=0)


def effective_number(rows: np.ndarray, logs: slice) -> np.ndarray:
    """Number of independent blocks that would have the same standard error."""
    blocks = rates(rows, logs, BLOCKS)
    if len(blocks) < 2:
        return np.full(rows[:0, logs].shape[1], np.nan)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.var(blocks, axis=0, ddof=1) / standard_error(rows, logs) ** 2


def settled(rows: np.ndarray, logs: slice, error: float) -> bool:
    """Whether the first exponent has that standard error, from batches that do not follow one another."""
    correlated = batch_correlation(rows, logs)[0] > 2 / math.sqrt(BATCHES)
    return bool(standard_error(rows, logs)[0] <= error and not correlated)


NAME, UP_TO_THERE = "Lyapunov exponent", "Lyapunov exponent up to the end of the block"
ESTIMATES = {
    "lyapunov_exponent": Out("exponent", NAME, "s-1", "of the flow, the largest first"),
    "lyapunov_standard_error": Out("exponent", f"standard error of the {NAME}", "s-1"),
    "lyapunov_exponent_per_turn": Out("exponent", f"{NAME}, per turn", about="where something turns"),
    "lyapunov_standard_error_per_turn": Out("exponent", f"standard error of the {NAME}, per turn"),
    "batch_correlation": Out("exponent", "correlation of a batch mean with the next"),
    "effective_blocks": Out("exponent", "effective number of independent blocks"),
}
TRACE = {
    "lyapunov_trace": Out(("block", "exponent"), UP_TO_THERE, "s-1", missing=KEPT),
    "lyapunov_trace_error": Out(("block", "exponent"), "its standard error up to there", "s-1", missing=KEPT),
    "block_time": Out("block", "end of the block", "s", missing=KEPT),
}
SUM_RULE = {
    "mean_divergence": Out((), "mean divergence of the flow, with its jumps", "s-1"),
    "sum_residual": Out((), "sum of exponents less divergence", "s-1", "of a whole spectrum"),
    "volume_share": Out((), "share of time in which the last exponent is by volume"),
}


def estimates(rows: np.ndarray, logs: slice, turn: float) -> dict[str, np.ndarray]:
    """Values of `ESTIMATES`; `turn` is the length of a turn in s."""
    means = growth(rows, logs)
    order = np.argsort(-means)
    values, errors = means[order], standard_error(rows, logs)[order]
    correlation, blocks = batch_correlation(rows, logs)[order], effective_number(rows, logs)[order]
    found = values, errors, values * turn, errors * turn, correlation, blocks
    return dict(zip(ESTIMATES, found, strict=True))


def values(rows: np.ndarray, logs: slice, turn: float, states: int) -> dict[str, Any]:
    """Values of exponents, the largest first, of their running means, and of the sum rule."""
    means = growth(rows, logs)
    found = estimates(rows, logs, turn) | _trace(rows, logs, np.argsort(-means))
    return found | _sum_rule(rows, means, states)


def _trace(rows: np.ndarray, logs: slice, order: np.ndarray) -> dict[str, np.ndarray]:
    """Running means at the ends of blocks, and their standard errors so far."""
    parts = [rows[: i + 1] for i in range(1, len(rows))]
    means, errors = (
        np.array([of(part, logs)[order] for part in parts]).reshape(-1, len(order))
        for of in (growth, standard_error)
    )
    return dict(zip(TRACE, (means, errors, rows[1:, 0]), strict=True))


def _sum_rule(rows: np.ndarray, means: np.ndarray, states: int) -> dict[str, float]:
    """Sum of a whole spectrum against the mean divergence."""
    trace, volume, unresolved = growth(rows, SUMS)
    whole = len(means) == states
    with np.errstate(invalid="ignore"):
        residual = abs(means.sum() - trace - volume) if whole else math.nan
    return dict(zip(SUM_RULE, (trace + volume, residual, unresolved if whole else 0.0), strict=True))


ERRORS = 3  # standard errors by which an exponent must differ from 0
FOLLOWING = 0.32  # correlation of batch means from which the error is too small
CHAOTIC, UNDECIDED = "chaotic", "undecided"


def widened(error: Any, correlation: Any) -> Any:
    """Errors of means whose batches are correlated; only where that shows, as by chance one in 40 does."""
    shown = np.where(correlation > FOLLOWING, np.minimum(correlation, 1 - 1e-9), 0.0)
    return error * np.sqrt((1 + shown) / (1 - shown))


def largest_exponent(result: xr.Dataset) -> tuple[xr.DataArray, xr.DataArray, str, str]:
    """The largest exponent, its error, its name, and ``per turn`` or ``per second``.

    The section map's where the result has it, else the flow's, whose zero tells nothing.
    """
    of_section = any(str(name).startswith("section_exponent") for name in result)
    word, dim = ("section", "multiplier") if of_section else ("lyapunov", "exponent")
    tail, per = ("_per_turn", "per turn") if f"{word}_exponent_per_turn" in result else ("", "per second")
    name = "largest exponent of the section map" if word == "section" else "largest exponent of the flow"
    value, error = (result[f"{word}_{each}{tail}"].isel({dim: 0}) for each in ("exponent", "standard_error"))
    return value, error, name, per


def parting(turns: Any) -> Any:
    """Growth per turn of neighbours that part as the number of turns; 0 where that is not known."""
    return np.where(turns > 1, np.log(np.maximum(turns, 1)) / np.maximum(turns, 1), 0.0)


def sure_growth(error: Any, correlation: Any, turns: Any) -> Any:
    """Growth per turn from which a motion is chaotic: beyond its error, and beyond `parting`."""
    return np.maximum(ERRORS * widened(error, correlation), parting(turns))


def decided(
    value: xr.DataArray,
    error: xr.DataArray,
    above: str = CHAOTIC,
    below: str = "stable",
    correlation: Any = 0.0,
    turns: Any = 0.0,
) -> xr.DataArray:
    """The word that the sign of each value deserves, by its error; minus infinity is below 0.

    Values per turn are above 0 only if neighbours part faster than as the number of `turns`.
    """
    positive = value > sure_growth(error, correlation, turns)
    negative = value < -ERRORS * widened(error, correlation)
    return codes.chosen(positive, above, codes.chosen(negative | np.isneginf(value), below, UNDECIDED))


def evidence(dataset: xr.Dataset) -> dict[str, Any]:
    """Evidence besides its error for the largest exponent (`decided`), as far as it was recorded."""
    found = {"correlation": dataset.get("section_batch_correlation"), "turns": dataset.get("exponent_turns")}
    return {n: a.isel(multiplier=0, missing_dims="ignore") for n, a in found.items() if a is not None}


def judged(dataset: xr.Dataset) -> xr.DataArray:
    """The word that the sign of the largest exponent deserves."""
    value, error, *_ = largest_exponent(dataset)
    return decided(value, error, **evidence(dataset))
