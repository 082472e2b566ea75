"""Exponents from a record of growing tangents: means, error bars, and whether these can be trusted.

Rows hold time, the sums of trace, of ln|det S| and of time by volume, then the logarithms of the tangents'
lengths, then the state. The error bar is that of batch means: the record is cut into 40 batches, and the
spread of their means, over the root of their number, is the standard error of the whole. Reference: H.
Flyvbjerg and H. G. Petersen, J. Chem. Phys. 91 (1989) 461-466.

Validity: batches must be longer than the motion's memory. Two numbers tell: the correlation of each batch's
mean with the next one's, which lies within 2/sqrt(40) = 0.32 of 0 in 95 of 100 such cases, and the effective
number of blocks, that of independent blocks of this scatter that would have this error.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from jointplay.analysis.labels import described

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


def estimates(rows: np.ndarray, logs: slice, turn: float) -> dict[str, tuple[np.ndarray, str, str]]:
    """Exponents with their errors, the largest first: values, units and long name of each variable.

    `turn` is the length of a turn in s.
    """
    means = growth(rows, logs)
    order, name = np.argsort(-means), "Lyapunov exponent"
    values, errors = means[order], standard_error(rows, logs)[order]
    correlation, blocks = batch_correlation(rows, logs)[order], effective_number(rows, logs)[order]
    return {
        "lyapunov_exponent": (values, "s-1", name),
        "lyapunov_standard_error": (errors, "s-1", f"standard error of the {name}"),
        "lyapunov_exponent_per_turn": (values * turn, "1", f"{name} a turn"),
        "lyapunov_standard_error_per_turn": (errors * turn, "1", f"standard error of the {name} a turn"),
        "batch_correlation": (correlation, "1", "correlation of a batch mean with the next"),
        "effective_blocks": (blocks, "1", "effective number of independent blocks"),
    }


def variables(rows: np.ndarray, logs: slice, turn: float, states: int) -> dict[str, Any]:
    """Variables of a dataset: exponents, the largest first, their running means, and the sum rule."""
    means = growth(rows, logs)
    over = {key: ("exponent", *each) for key, each in estimates(rows, logs, turn).items()}
    return described(over | _trace(rows, logs, np.argsort(-means)) | _sum_rule(rows, means, states))


def _trace(rows: np.ndarray, logs: slice, order: np.ndarray) -> dict[str, tuple]:
    """Running means at the ends of blocks, and their standard errors so far."""
    parts = [rows[: i + 1] for i in range(1, len(rows))]
    means, errors = (
        np.array([of(part, logs)[order] for part in parts]).reshape(-1, len(order))
        for of in (growth, standard_error)
    )
    dims, name = ("block", "exponent"), "Lyapunov exponent up to the end of the block"
    return {
        "lyapunov_trace": (dims, means, "s-1", name),
        "lyapunov_trace_error": (dims, errors, "s-1", "its standard error up to there"),
        "block_time": ("block", rows[1:, 0], "s", "end of the block"),
    }


def _sum_rule(rows: np.ndarray, means: np.ndarray, states: int) -> dict[str, tuple]:
    """Sum of a whole spectrum against the mean divergence."""
    trace, volume, unresolved = growth(rows, SUMS)
    whole = len(means) == states
    with np.errstate(invalid="ignore"):
        residual = abs(means.sum() - trace - volume) if whole else math.nan
    share, by_volume = unresolved if whole else 0.0, "share of time in which the last exponent is by volume"
    return {
        "mean_divergence": ((), trace + volume, "s-1", "mean divergence of the flow, with its jumps"),
        "sum_residual": ((), residual, "s-1", "sum of exponents less divergence"),
        "volume_share": ((), share, "1", by_volume),
    }
