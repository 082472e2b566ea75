"""Answers of optimisations."""

import numpy as np
from xarray import Dataset

from jointplay.display import codes
from jointplay.display.number_text import plain

LISTED = 6  # parameters named in a line
ENDS = {
    "converged": "",
    "no_descent": "the search stopped where no step went further down",
    "infeasible": "no design was found that keeps the constraints",
    "iterations": "the search stopped at its last iteration",
    "no_motion": "the motion at first has no derivative; with another start, or ideal = true, it may",
}
AGREED = 1e-4  # relative difference up to which two motions have the same value


def optimise(dataset: Dataset) -> str:
    """Return the best design, its values before and after, and what speaks against it."""
    end = str(codes.words(dataset["end"]).item())
    if int(dataset["status"]):
        return f"no optimum: {ENDS[end] or 'no motion'}"
    lines = [f"{dataset.attrs['aim']}: {_changes(dataset)}", *_values(dataset)[:1]]
    doubts = [ENDS[end]] if ENDS[end] else []
    if not dataset["confirmed_to"].fillna(1.0).values.max() <= AGREED:
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
