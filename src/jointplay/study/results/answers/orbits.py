"""Answers of periodic orbits, their branches and curves."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from jointplay.analysis.orbits.branch import WHY
from jointplay.display import codes
from jointplay.display.number_text import plain
from jointplay.display.units import measure

if TYPE_CHECKING:
    from xarray import DataArray, Dataset

LISTED = 3  # special points, attractors, curves or their meetings named in a line


def periodic_orbit_verdict(dataset: Dataset) -> DataArray:
    """Return period and stability of each orbit, such as ``period 1, stable``."""
    from xarray import where

    period, stable = dataset["period"], codes.words(dataset["stable"])
    named = where(np.isfinite(period), period.fillna(0).astype(int).astype(str), "")
    words = "period " + named.astype(object) + ", " + stable.astype(object)
    return where(np.isfinite(period), words, "no orbit found")


def periodic_orbit(dataset: Dataset) -> str:
    """Return period, stability and largest multiplier of the orbit, and its contacts."""
    if not math.isfinite(float(dataset["period"])):
        left = float(dataset["residual"])
        how = f": the state still changes by {plain(left, 2)} over a period" if math.isfinite(left) else ""
        return f"no periodic orbit found{how}"
    lines = [
        f"{periodic_orbit_verdict(dataset).item()}, {_multiplier(dataset['floquet_multiplier'].values[0])}"
    ]
    parts = [f"it lasts {measure(float(dataset['period_time']), 's', 6)}"]
    if math.isfinite(float(dataset["impacts"])) and "clearance" in dataset:
        parts.append(f"contacts begun per turn: {plain(float(dataset['impacts']), 4)}")
    parts.append(f"closed to {plain(float(dataset['residual']), 1)}")
    return "\n".join([*lines, ", ".join(parts)])


def _multiplier(value: np.ndarray) -> str:
    real, imaginary = map(float, value)
    size = f"largest multiplier {plain(math.hypot(real, imaginary), 3)}"
    if imaginary:
        return f"{size} in modulus ({plain(real, 3)} ± {plain(abs(imaginary), 3)}i)"
    return f"largest multiplier {plain(real, 3)}"


def continuation(dataset: Dataset) -> str:
    """Return the extent of the branches, the reasons of their ends, and the special points on them."""
    name = str(dataset.attrs["parameter"]).rpartition(".")[2]
    if not np.isfinite(dataset["period"].values).any():
        return "no periodic orbit found to begin with"
    lines = [_branch(dataset, name, b) for b in range(min(dataset.sizes["branch"], LISTED - 1))]
    if more := dataset.sizes["branch"] - len(lines):
        lines[-1] += f"; {more} more branches"
    return "\n".join([*lines, _special(dataset)])


def _branch(dataset: Dataset, name: str, b: int) -> str:
    one, units = dataset.isel(branch=b), str(dataset[name].attrs.get("units", "1"))
    values = one[name].values[: int(one["n_points"])]
    ends, stable = codes.words(one["branch_end"]).values, codes.words(one["stable"]).values[: len(values)]
    places = zip(values[[0, -1]], ends, strict=True)
    told = [f"ended at {measure(float(v), units)}: {WHY.get(end, end)}" for v, end in places]
    if ends[0] == ends[1] == "range":
        told = [f"over the whole range, {measure(values.min(), units)} to {measure(values.max(), units)}"]
    share = np.count_nonzero(stable == "stable")
    how = "stable" if share == len(values) else f"stable at {share} of {len(values)} points"
    period = plain(float(np.nanmax(one["period"].values)), 4)
    return f"branch {b + 1}, period {period}, {how}: {' and '.join(told)}"


def _special(dataset: Dataset) -> str:
    if not dataset.sizes["special"]:
        return (
            "no bifurcation and no grazing on them" if dataset.sizes["branch"] > 1 else "no bifurcation found"
        )
    units = str(dataset["special_parameter"].attrs.get("units", "1"))
    kinds, places = codes.words(dataset["special_kind"]).values, dataset["special_parameter"].values
    bifurcations = np.flatnonzero(kinds != "grazing")
    named = [f"{kinds[i].replace('_', ' ')} at {measure(float(places[i]), units, 6)}" for i in bifurcations]
    parts = named[:LISTED]
    if len(named) > LISTED:
        parts.append(f"{len(named) - LISTED} more")
    if grazings := len(kinds) - len(named):
        parts.append(f"{grazings} grazings (an event appears or vanishes)")
    return ", ".join(parts)


def curve(dataset: Dataset) -> str:
    """Return the extent of each curve, the reason of its end, and its meetings with others."""
    if not np.isfinite(dataset["period"].values).any():
        return "no curve found: no periodic orbit, or no change of it on the branch over the first parameter"
    lines = [_line(dataset, number) for number in range(min(dataset.sizes["curve"], LISTED))]
    if more := dataset.sizes["curve"] - len(lines):
        lines[-1] += f"; {more} more curves"
    return "\n".join([*lines, *_meetings(dataset)])


def _line(dataset: Dataset, number: int) -> str:
    one, names = dataset.isel(curve=number), str(dataset.attrs["parameters"]).split()
    kind = codes.words(one["curve_kind"]).item().replace("_", " ")
    spans = []
    for name in names:
        values, units = one[name].values[: int(one["n_points"])], str(dataset[name].attrs.get("units", "1"))
        long = str(dataset[name].attrs.get("long_name", name))
        spans.append(f"{long} {measure(float(values.min()), units)} to {measure(float(values.max()), units)}")
    ends = [WHY.get(end, end) for end in codes.words(one["curve_end"]).values]
    told = f"both ends: {ends[0]}" if ends[0] == ends[1] else f"first end: {ends[0]}; last end: {ends[1]}"
    return f"{kind}, {int(one['n_points'])} points: {', '.join(spans)}; {told}"


def _meetings(dataset: Dataset) -> list[str]:
    if not dataset.sizes["meeting"]:
        return []
    names, parts = str(dataset.attrs["parameters"]).split(), []
    kinds = [kind.replace("_", " ") for kind in codes.words(dataset["meeting_kind"]).values]
    for i, kind in enumerate(kinds[:LISTED]):
        place = [
            measure(float(dataset[f"meeting_{name}"][i]), str(dataset[name].attrs.get("units", "1")), 6)
            for name in names
        ]
        parts.append(f"{kind} at ({', '.join(place)})")
    if len(kinds) > LISTED:
        parts.append(f"{len(kinds) - LISTED} more")
    return ["meets " + ", ".join(parts)]
