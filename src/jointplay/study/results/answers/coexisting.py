"""Answers of coexisting motions."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from jointplay.display import codes
from jointplay.display.number_text import plain
from jointplay.display.units import measure

if TYPE_CHECKING:
    from xarray import Dataset

LISTED = 3  # motions named in a line
CLOSE = 0.99  # of a knock: up to there it is as good as safe


def attractors(dataset: Dataset) -> str:
    """Return the number of motions, the most likely ones, and beginnings and ends of some."""
    share = dataset["fraction"]
    name, _ = share.dims
    if not share.size:
        return "no attractor found"
    there = dataset["period"].values >= 0
    most = there.sum(axis=1)
    lines = [
        f"{_several(dataset.sizes['identity'], 'motion')}, at most {most.max()} beside each other "
        f"({_at(dataset, name, int(most.argmax()))})"
    ]
    order = np.argsort(-np.nansum(share.values, axis=0), kind="stable")
    lines.append("; ".join(_motion(dataset, name, int(n), there[:, n]) for n in order[:LISTED]))
    kinds, counts = np.unique(codes.words(dataset["change_kind"]).values, return_counts=True)
    told = [_several(int(n), str(kind)) for kind, n in zip(kinds, counts, strict=True)]
    unsettled = float(dataset["fraction_unsettled"].max())
    told += [f"up to {plain(100 * unsettled, 3)} % of the starts did not settle"] if unsettled > 0 else []
    return "\n".join([*lines, *([", ".join(told)] if told else [])])


def _several(count: int, noun: str) -> str:
    return f"{count} {noun}{'' if count == 1 else 's'}"


def _at(dataset: Dataset, name: str, place: int) -> str:
    axis = dataset[name]
    return f"{name} {measure(float(axis.values[place]), str(axis.attrs.get('units', '1')))}"


def _motion(dataset: Dataset, name: str, n: int, there: np.ndarray) -> str:
    """A motion with its periods, where it is, and its largest fraction."""
    one, places = dataset.isel(identity=n), np.flatnonzero(there)
    periods = np.unique(one["period"].values[places])
    text = ", ".join(str(p) if p else "none" for p in periods[:LISTED])
    ends = f"from {_at(dataset, name, places[0])} to {_at(dataset, name, places[-1])}"
    best = 100 * float(np.nanmax(one["fraction"].values[places]))
    return f"{int(one['identity'])}: period {text}, {ends}, up to {plain(best, 3)} % of the starts"


def tipping(dataset: Dataset) -> str:
    """Return the smallest knock that throws each motion into another, and the edge states."""
    count = dataset.sizes["number"]
    if count < 2:
        return f"{_several(count, 'motion')}: there is no other to be thrown into"
    lines = [_knock(dataset.isel(number=n)) for n in range(min(count, LISTED))]
    lines += [_several(count - LISTED, "more motion")] if count > LISTED else []
    return "\n".join(lines)


def _knock(one: Dataset) -> str:
    """The smallest knock of each kind of a motion."""
    parts = []
    for k, name in enumerate(one["knock"].values.tolist()):
        size, end = float(one["knock_size"].values[k]), int(one["knock_reaches"].values[k])
        if np.isfinite(size):
            units = str(one["knock_units"].values[k])
            sure = "" if int(one["knock_confirmed"].values[k]) else _unsure(one, k, units)
            other = str(end) if end > 0 else "no settled motion"
            parts.append(f"{name} {measure(size, units, 3)} to {other}{sure}")
    found = sorted({int(p) for p in one["edge_period"].values if p > 0})
    edges = f"; between: a state of period {', '.join(map(str, found))}" if found else ""
    told = ", ".join(parts) or "no knock that was tried tips it"
    return f"{int(one['number'])} (period {int(one['period']) or 'none'}): {told}{edges}"


def _unsure(one: Dataset, k: int, units: str) -> str:
    """Remark on a knock that is not confirmed."""
    names = ("knock_size", "knock_safe", "confirmed_size", "tipping_share")
    size, safe, sure, share = (float(one[name].values[k]) for name in names)
    below = "all smaller ones" if safe >= CLOSE * size else f"those up to {measure(safe, units, 3)}"
    told = [f"{below} that were tried return"] if safe > 0 else []
    why = ", as at a fractal boundary" if share < 1 else ""  # else what it leads to has not settled
    told.append(f"{plain(100 * share, 3)} % of those up to 1.2 times it tip{why}")
    told.append(f"{measure(sure, units, 3) if np.isfinite(sure) else 'none'} is confirmed")
    return f" (not confirmed: {', '.join(told)})"
