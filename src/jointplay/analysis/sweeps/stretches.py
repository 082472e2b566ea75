"""Words over the values of parameters: number of cells with each, and their places along the axis."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from jointplay.display import codes
from jointplay.display.units import measure

if TYPE_CHECKING:
    from xarray import DataArray, Dataset

FAILED = "failed"
NAMED = 3  # stretches of a word, or words, that are told one by one


def told(words: np.ndarray, axes: Sequence[DataArray]) -> str:
    """Return counts of the words of cells, the most frequent first, with the places of all but the first.

    Parameters
    ----------
    words : ndarray of str
        Of each cell, over the axes.
    axes : sequence of DataArray
        The varied parameters.
    """
    found, counts = np.unique(words, return_counts=True)
    order = np.argsort(-counts, kind="stable")
    if len(found) == 1:
        return f"{found[0]} at {'all ' if words.size > 1 else ''}{words.size} value{'s' * (words.size > 1)}"
    first = f"{found[order[0]]} at {counts[order[0]]} of {words.size} values"
    rest = [f"{found[i]} at {counts[i]}{places(words == found[i], axes)}" for i in order[1:]]
    named = len(rest) if len(rest) <= NAMED + 1 else NAMED
    left = [f"{len(rest) - named} more at {sum(counts[order[1 + named :]])}"] if len(rest) > named else []
    return "; ".join([first, *rest[:named], *left])


def places(chosen: np.ndarray, axes: Sequence[DataArray]) -> str:
    """Return where chosen cells are along one parameter, or their range along each of several."""
    if not chosen.any():
        return ""
    if len(axes) > 1:
        along = (np.moveaxis(chosen, i, 0).reshape(len(axis), -1) for i, axis in enumerate(axes))
        spans = map(_span, axes, (each.any(axis=1) for each in along))
        return f" ({', '.join(spans)})"
    edges = np.flatnonzero(np.diff(np.concatenate([[0], chosen.astype(int), [0]])))
    runs = list(zip(edges[::2], edges[1::2] - 1, strict=True))
    if len(runs) > NAMED:
        return f" in {len(runs)} stretches of {_span(axes[0], chosen)}"
    values, units = axes[0].values, str(axes[0].attrs.get("units", "1"))
    return f" ({axes[0].name} {', '.join(_between(values[a], values[b], units) for a, b in runs)})"


def _span(axis: DataArray, chosen: np.ndarray) -> str:
    values = axis.values[chosen]
    return f"{axis.name} {_between(values.min(), values.max(), str(axis.attrs.get('units', '1')))}"


def _between(low: float, high: float, units: str) -> str:
    return measure(low, units) if low == high else f"{measure(low, units)} to {measure(high, units)}"


def failures(dataset: Dataset, dims: Sequence[str]) -> list[str]:
    """Return a line on the cells that failed: number, reasons, and places; none where all ended well."""
    bad = dataset["cell_status"] != 0
    if not bad.any():
        return []
    kinds = codes.counted(codes.words(dataset["cell_status"]).values[bad.values])
    over = bad.any([dim for dim in bad.dims if dim not in dims]).transpose(*dims).values
    return [f"{int(bad.sum())} of {bad.size} failed: {kinds}{places(over, [dataset[dim] for dim in dims])}"]
