"""Answers of exponents and of the growth of differences.

A motion is called chaotic only where the largest exponent of its section's map is above 0 by more than three
standard errors, and stable where it is below by as much; all else is undecided. An error bar whose batches
follow one another is too small to decide by.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from jointplay.display.number_text import plain, signed

if TYPE_CHECKING:
    from xarray import DataArray, Dataset

ERRORS = 3  # standard errors by which an exponent must differ from 0
FOLLOWING = 0.32  # correlation of batch means from which the error is too small
CHAOTIC, UNDECIDED = "chaotic", "undecided"


def decided(value: DataArray, error: DataArray, above: str = CHAOTIC, below: str = "stable") -> DataArray:
    """Return the word that the sign of each value deserves, by its error; minus infinity is below 0."""
    from xarray import where

    sure = np.isfinite(error)
    positive, negative = sure & (value > ERRORS * error), sure & (value < -ERRORS * error)
    return where(positive, above, where(negative | np.isneginf(value), below, UNDECIDED))


def largest(dataset: Dataset) -> tuple[DataArray, DataArray, str, str]:
    """Return the largest exponent and its error, what it is called and per what it counts.

    The section map's where the result has it, else the flow's, whose zero tells nothing.
    """
    word, dim = ("section", "multiplier") if "section_exponent" in dataset else ("lyapunov", "exponent")
    tail, per = ("_per_turn", "per turn") if f"{word}_exponent_per_turn" in dataset else ("", "per second")
    name = "largest exponent of the section map" if word == "section" else "largest exponent of the flow"
    value, error = (dataset[f"{word}_{each}{tail}"].isel({dim: 0}) for each in ("exponent", "standard_error"))
    return value, error, name, per


def lyapunov_verdict(dataset: Dataset) -> DataArray:
    """Return ``chaotic``, ``stable`` or ``undecided`` of each run."""
    from xarray import where

    value, error, name, _ = largest(dataset)
    words = decided(value, error)
    if "section_batch_correlation" in dataset:
        follows = dataset["section_batch_correlation"].isel(multiplier=0) > FOLLOWING
        words = where(follows & (words == CHAOTIC), UNDECIDED, words)
    if "flow" in name:
        words = where(words == "stable", "comes to rest", words)
    return words


def lyapunov(dataset: Dataset) -> str:
    """Return the largest exponent and what it says; a second line on what was checked."""
    value, error, name, per = largest(dataset)
    verdict = str(lyapunov_verdict(dataset).item())
    if math.isnan(float(value)):
        return _at_rest(dataset) or f"{name}: not known"
    lines = [f"{name} {signed(float(value), float(error))} {per}: {verdict}"]
    if verdict == UNDECIDED:
        lines.append(_why(float(value), float(error)))
    if "growth" in dataset and math.isfinite(float(dataset["growth"])):
        twin = signed(float(dataset["growth"]), float(dataset["growth_standard_error"]))
        apart = abs(float(dataset["growth_difference"]))
        away = f": {plain(apart, 2)} standard errors away" if math.isfinite(apart) else ""
        lines.append(f"without Jacobians, by twin trajectories, {twin} per turn{away}")
    return "\n".join(lines)


def _at_rest(dataset: Dataset) -> str:
    """The answer of a motion without a section; empty where the flow's exponent is not known either."""
    if "lyapunov_exponent" not in dataset:
        return ""
    value, error = (dataset[f"lyapunov_{each}"].isel(exponent=0) for each in ("exponent", "standard_error"))
    if math.isnan(float(value)):
        return ""
    said = f"largest exponent of the flow {signed(float(value), float(error))} per second"
    return f"{said}; the motion rests or comes to rest: no section"


def _why(value: float, error: float) -> str:
    if math.isfinite(error) and abs(value) > ERRORS * error:
        return "batches of the record follow one another, so that its error is too small: take more turns"
    return f"it does not differ from 0 by {ERRORS} standard errors: take more turns"


def sensitivity(dataset: Dataset) -> str:
    """Return the growth of a small difference, and the exponents over a plane of starts."""
    lines = []
    if "growth" in dataset:
        value, error = (float(dataset[name]) for name in ("growth", "growth_standard_error"))
        word = str(
            decided(dataset["growth"], dataset["growth_standard_error"], "it grows", "it shrinks").item()
        )
        lines.append(
            f"logarithm of a small difference {signed(value, error)} per turn: {word}"
            if math.isfinite(value)
            else "growth not measured: distances grew over fewer than three turns"
        )
    if "finite_time_exponent_per_turn" in dataset:
        values = dataset["finite_time_exponent_per_turn"].values
        known = values[np.isfinite(values)]
        if known.size:
            ends = f"from {plain(float(known.min()), 3)} to {plain(float(known.max()), 3)}"
            share = f"{np.count_nonzero(known > 0)} of {known.size} starts"
            lines.append(f"finite-time exponents {ends} per turn, above 0 at {share}")
    return "\n".join(lines)


def sensitivity_verdict(dataset: Dataset) -> DataArray:
    """Return whether differences grow or shrink in each run."""
    return decided(dataset["growth"], dataset["growth_standard_error"], "grows", "shrinks")
