"""Answers of curves in two parameters."""

import numpy as np
from xarray import Dataset

from jointplay.analysis.orbits.branch import WHY
from jointplay.display import codes
from jointplay.display.units import measure

LISTED = 3  # curves, and meetings, that are named


def curve(dataset: Dataset) -> str:
    """Return how far each curve goes and why it ends, and what it meets."""
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
