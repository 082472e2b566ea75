"""Answers of the growth of differences."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from jointplay.analysis.exponents.batch_means import decided
from jointplay.display.number_text import plain, signed

if TYPE_CHECKING:
    from xarray import DataArray, Dataset


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
