"""Exponents of a section's map, from the growth of tangents along the flow.

Where nothing outside keeps the time, the direction of the motion itself, F = dx/dt, is carried along by the
tangent flow and through every event (S F- = F+): it neither grows nor shrinks in the long run, and has the
exponent 0. A section's map has the other exponents, times the length of a turn. The volume of the first j
tangents that hold F is |F| times the volume of their projection across F, so that

    L_j = l_1 + ... + l_(j+1) - ln|F|,    l_i the logarithm of the growth of tangent i (Gram-Schmidt),

grows as the sum of the section map's first j exponents, exactly, whichever section is taken: the neutral
direction is projected out by volume. One tangent more than exponents are asked for is followed for that.
Tangents before the neutral one keep their own growth, the neutral one and the next become one, less ln|F|.

Validity: the neutral exponent is taken to be the one nearest to 0; where another is as near, either choice
gives the same within their errors. None is taken out where all that were followed are positive. A motion that
comes to rest has no section, and its exponents are NaN. Reference: Benettin et al., Meccanica 15 (1980) 9-20;
Pikovsky and Politi, Lyapunov Exponents (2016), chapter 2.
"""

from __future__ import annotations

import math

import numpy as np

from jointplay.analysis.exponents import batch_means
from jointplay.analysis.tangents import Bundle
from jointplay.analysis.trajectory import Request
from jointplay.codegen import cache
from jointplay.equations.structure import Oscillator
from jointplay.mechanism.model import Model

ERRORS = 3  # standard errors by which an exponent differs from 0
STILL = math.log(1e-6)  # fall of the speed at which a motion counts as having come to rest
LATER = 0.382  # of the period: another time, to see whether the rates depend on it
ALONG = -1  # column of ln|F| in a row


def timeless(model: Model) -> bool:
    """Whether nothing outside keeps the time, so that one exponent of the flow is 0."""
    if isinstance(model.structure, Oscillator):
        return "phase" not in cache.structure_module(model.structure).OUTPUTS
    bundle = Bundle(model, Request(model.period), np.zeros((1, len(model.state))))
    now = bundle.rate()
    bundle.x.s[0] += LATER * model.period
    return bool(np.array_equal(now, bundle.rate()))


def rows_of_the_section(rows: np.ndarray, logs: slice, states: int) -> tuple[np.ndarray, slice]:
    """Rows as those of the flow, with the logarithms of the section map's growth in place of the tangents'.

    Parameters
    ----------
    rows : ndarray
        Time, sums, logarithms of the tangents' growth, state, and ln|F| last; shape (rows, columns).
    logs : slice
        Columns of the logarithms: one more than exponents are wanted, or all `states`.
    states : int
        Number of states.
    """
    growth, means, count = rows[:, logs], batch_means.growth(rows, logs), logs.stop - logs.start - 1
    with np.errstate(invalid="ignore"):
        moves = rows[-1, ALONG] - rows[0, ALONG] >= STILL  # an equilibrium has -inf at both
    if len(rows) < 2 or np.any(np.isnan(means)) or not moves:
        columns = np.full((len(rows), count), np.nan)
    elif (nearest := int(np.argmin(np.abs(means)))) == count or _later(rows, logs, nearest, states):
        columns = np.delete(growth, nearest, axis=1)
    else:
        both = growth[:, nearest] + growth[:, nearest + 1] - rows[:, ALONG]
        columns = np.column_stack([growth[:, :nearest], both, growth[:, nearest + 2 :]])
    begin = logs.start
    return np.column_stack([rows[:, :begin], columns]), slice(begin, begin + count)


def _later(rows: np.ndarray, logs: slice, nearest: int, states: int) -> bool:
    """Whether even the exponent nearest to 0 is positive, so that the neutral one was not followed."""
    mean, error = (of(rows, logs)[nearest] for of in (batch_means.growth, batch_means.standard_error))
    return bool(mean > ERRORS * error) and logs.stop - logs.start < states


def estimates(
    rows: np.ndarray, logs: slice, turn: float, model: Model, neutral: bool
) -> dict[str, tuple[np.ndarray, str, str]]:
    """Exponents of the section's map with errors, the largest first: values, units, long name of each.

    `turn` is the length of a turn in s; `neutral` says that one of the flow's exponents is 0.
    """
    if neutral:
        rows, logs = rows_of_the_section(rows, logs, len(model.state))
    found = batch_means.estimates(rows, logs, turn)
    return {new: (found[old][0], found[old][1], text) for new, (old, text) in NAMES.items()}


_NAME = "exponent of the section's map"
NAMES = {
    "section_exponent": ("lyapunov_exponent", f"{_NAME}, over the length of a turn"),
    "section_standard_error": ("lyapunov_standard_error", f"standard error of the {_NAME}"),
    "section_exponent_per_turn": ("lyapunov_exponent_per_turn", f"{_NAME}, per turn"),
    "section_standard_error_per_turn": (
        "lyapunov_standard_error_per_turn",
        f"standard error of the {_NAME}, per turn",
    ),
    "section_batch_correlation": ("batch_correlation", f"correlation of a batch mean with the next, {_NAME}"),
}
NUMBER = "number of the exponent of the section's map, the largest first"
