"""Answers of covariant vectors: where chaos lives, and how far growing directions stay from the others.

A direction counts as growing where its exponent is above 0 by more than three standard errors.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from jointplay.display.number_text import plain, signed
from jointplay.study.results.answers.exponents import ERRORS

if TYPE_CHECKING:
    from xarray import Dataset

UNSETTLED = 1e-3  # rad, from which a vector is not known
COARSE = 20.0  # ln of the spread of growth in a block, from which the last vectors are inaccurate
WORDS = {"crank": "the crank's motion", "bending": "the bending of links"}


def covariant(dataset: Dataset) -> str:
    """Return what takes part in the direction that grows most, its angle with the others, and doubts."""
    if "mean_share" not in dataset:
        return "\n".join(["covariant vectors: not known", *filter(None, [_doubts(dataset)])])
    tail, per = ("_per_turn", "per turn") if "turn_period" in dataset else ("", "per second")
    values, errors = (dataset[f"covariant_{name}{tail}"].values for name in ("exponent", "standard_error"))
    growing = int(np.count_nonzero(values > ERRORS * errors))
    rate = f"{signed(float(values[0]), float(errors[0]))} {per}"
    shares = _shares(dataset)
    lines = [
        f"chaos lives in {shares} (direction that grows by {rate})"
        if growing
        else f"no chaos: nothing grows for sure; the leading direction, {rate}, is in {shares}"
    ]
    if 0 < growing < len(values):
        angles = np.degrees(dataset["splitting_angle"].isel(splitting=growing - 1).values)
        low, middle = plain(float(angles.min()), 2), plain(float(np.median(angles)), 2)
        what = "the growing direction" if growing == 1 else f"the {growing} growing directions"
        lines.append(f"angle of {what} with the others: at least {low}°, median {middle}°")
    return "\n".join([*lines, *filter(None, [_doubts(dataset)])])


def _shares(dataset: Dataset) -> str:
    """Parts of the first vector, the largest first, with their mean shares."""
    share = dataset["mean_share"].isel(vector=0).values
    names = [str(name) for name in dataset["part"].values]
    order = [i for i in np.argsort(-share) if share[i] >= 0.01]
    return ", ".join(f"{_named(names[i])} {plain(100 * float(share[i]), 3)} %" for i in order)


def _named(part: str) -> str:
    if part.startswith("play "):
        return f"the play of {part.removeprefix('play ')}"
    return WORDS.get(part, part)


def _doubts(dataset: Dataset) -> str:
    told, loose = [], np.zeros(0)
    if "settling_residual" in dataset:
        loose = dataset["vector"].values[dataset["settling_residual"].values > UNSETTLED]
    if loose.size:
        numbers = ", ".join(map(str, loose))
        told.append(f"vectors {numbers} have not settled: a longer settling or transient, or equal exponents")
    if float(dataset["block_spread"]) > COARSE:
        told.append("directions shrink so differently that the last vectors are inaccurate")
    if lost := int(dataset["lost"]):
        told.append(f"{lost} direction{'s' * (lost > 1)} lost at events, without a vector")
    return "; ".join(told)
