"""Answers of derivatives in parameters, and of optimisations."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from jointplay.analysis.gradients.gradient_dataset import WHY
from jointplay.analysis.gradients.multipliers import MULTIPLIERS
from jointplay.display import codes
from jointplay.display.number_text import plain

if TYPE_CHECKING:
    from xarray import Dataset

LISTED = 6  # parameters of a design named in a line
LEADING = 3  # quantities, and parameters of each, whose derivatives are named
ENDS = {
    "converged": "",
    "no_descent": "the search stopped where no step went further down",
    "infeasible": "no design was found that keeps the constraints",
    "iterations": "the search stopped at its last iteration",
    "no_motion": "the motion at first has no derivative; with another start, or ideal = true, it may",
}
AGREED = 1e-4  # relative difference up to which two motions have the same value


def optimise(dataset: Dataset) -> str:
    """Return the best design, its values before and after, and doubts about it."""
    end = str(codes.words(dataset["end"]).item())
    if end == "infeasible":
        return "\n".join([ENDS[end] + _play(dataset), *_missed(dataset)])
    if int(dataset["status"]):
        return f"no optimum: {ENDS[end] or 'no motion'}"
    lines = [f"{dataset.attrs['aim']}: {_changes(dataset)}", *_values(dataset)[:1]]
    doubts = [ENDS[end]] if ENDS[end] else []
    followed = [name.partition(":")[0] not in MULTIPLIERS for name in dataset["quantity"].values]
    if dataset["confirmed_to"].fillna(1.0).values[followed].max(initial=0.0) > AGREED:
        doubts.append("the motion from the usual start does not settle to the orbit that was optimised")
    if float(dataset["neighbour_gain"]) > 0:
        gain = plain(float(dataset["neighbour_gain"]), 3)
        doubts.append(f"a design {plain(100 * dataset.attrs['neighbourhood'], 3)} % away is better by {gain}")
    return "\n".join([*lines, "; ".join(doubts)] if doubts else lines)


def _changes(dataset: Dataset) -> str:
    rows = zip(
        dataset["parameter"].values,
        dataset["first_value"].values,
        dataset["optimum"].values,
        dataset["parameter_units"].values,
        strict=True,
    )
    told = [
        f"{name} {plain(float(first), 4)} to {plain(float(last), 4)}" + (f" {units}" if units != "1" else "")
        for name, first, last, units in rows
    ]
    return ", ".join(told[:LISTED]) + (" and others" if len(told) > LISTED else "")


def _values(dataset: Dataset) -> list[str]:
    told = []
    for i in range(dataset.sizes["quantity"]):
        one, unit = dataset.isel(quantity=i), str(dataset["quantity_units"].values[i])
        before = plain(float(one["before"]), 4) if np.isfinite(one["before"]) else "unknown"
        after = plain(float(one["value"]), 6) + (f" {unit}" if unit != "1" else "")
        told.append(f"{one['quantity'].item()} {before} before, {after} after")
    return ["; ".join(told)]


def _play(dataset: Dataset) -> str:
    """Up to which share of the clearance there are designs, where it is not all of it."""
    share = float(dataset["play_kept"])
    return "" if share == 1 else f"; with {plain(100 * share, 3)} % of the clearance there are some"


def _missed(dataset: Dataset) -> list[str]:
    """Constraints not kept at the best design, and the parameters that are at their bounds there."""
    told = []
    for one in (dataset.isel(quantity=i) for i in range(dataset.sizes["quantity"])):
        value, low, high = (float(one[name]) for name in ("value", "limit_low", "limit_high"))
        limit = f"at least {plain(low, 4)}" if not value >= low else f"at most {plain(high, 4)}"
        if not low <= value <= high:
            now = plain(value, 4) if np.isfinite(value) else "unknown"
            told.append(f"{one['quantity'].item()} is {now}, {limit} is asked for")
    low, high, at = (dataset[name].values for name in ("low", "high", "optimum"))
    ends = ((at - low <= 1e-6 * (high - low), "lowest"), (high - at <= 1e-6 * (high - low), "highest"))
    names = dataset["parameter"].values
    bound = [f"{names[i]} at its {word} value" for there, word in ends for i in np.flatnonzero(there)]
    return ["; ".join(told), ", ".join(bound)][: 1 + bool(bound)]


def gradient(dataset: Dataset) -> str:
    """Return the strongest dependences of each quantity, relatively, and whether there is a derivative."""
    verdict = str(codes.words(dataset["derivative_status"]).item())
    if not np.isfinite(dataset["derivative"].values).any():
        return f"no derivative: {WHY.get(verdict, verdict)}"
    lines = [_quantity(dataset.isel(quantity=i)) for i in range(min(LEADING, dataset.sizes["quantity"]))]
    if verdict != "ok":
        lines.append(f"hardly a derivative here: {WHY.get(verdict, verdict)}")
    return "\n".join(lines)


def _quantity(one: Dataset) -> str:
    sizes = np.nan_to_num(one["relative_sensitivity"].values)
    order = np.argsort(-np.abs(sizes), kind="stable")[:LEADING]
    parts = [f"{plain(float(sizes[i]), 3)} by {one['parameter'].values[i]}" for i in order if sizes[i]]
    name, units = str(one["quantity"].item()), str(one["quantity_units"].item())
    value = f"{name} = {plain(float(one['value']), 6)}" + (f" {units}" if units != "1" else "")
    return (
        f"{value}: relative sensitivity {', '.join(parts)}" if parts else f"{value}: depends on none of them"
    )
