"""Integer codes as the words that their flags give them, and how many cells have each, and where."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from jointplay.display.number_text import measured

if TYPE_CHECKING:
    from xarray import DataArray, Dataset

CORNER = re.compile(r"(.+)_(upper|lower)_(front|rear)")  # label of a slider's corner
STRANGE = "?"  # of a code that has no word
FAILED = "failed"
NAMED = 3  # stretches of a word, or words, that are told one by one


def flags(array: DataArray) -> dict[int, str]:
    """Return the word of each code that a variable's flags name; none of one without flags."""
    values = np.atleast_1d(array.attrs.get("flag_values", []))
    return dict(zip(map(int, values), str(array.attrs.get("flag_meanings", "")).split(), strict=False))


def contact(label: str) -> str:
    """Return a label in words, ``upper front corner of G`` for ``G_upper_front``; other ones as they are."""
    found = CORNER.fullmatch(label)
    return f"{found[2]} {found[3]} corner of {found[1]}" if found else label


def words(array: DataArray) -> DataArray:
    """Return the codes of a variable as words; a code without one as ``?``.

    Parameters
    ----------
    array : DataArray
        With the attributes ``flag_values`` and ``flag_meanings``.
    """
    known = flags(array)
    found, inverse = np.unique(array.values, return_inverse=True)
    named = np.array([known.get(code, STRANGE) for code in found.tolist()], dtype=str)
    result = array.copy(data=named[inverse].reshape(array.shape))
    result.attrs = {name: text for name, text in array.attrs.items() if not name.startswith("flag_")}
    return result


def chosen(condition: DataArray, yes: Any, no: Any) -> DataArray:
    """Return one word where a condition holds, and another elsewhere; coordinates keep their units.

    xarray's own `where` takes attributes off the coordinates of its arguments before its release 2025.6.
    """
    from xarray import apply_ufunc

    result = apply_ufunc(np.where, condition, yes, no, keep_attrs=True)
    result.attrs = {}
    return result


def coded(array: DataArray) -> bool:
    """Whether words stand behind a variable's numbers."""
    return "flag_meanings" in array.attrs


def counted(names: np.ndarray) -> str:
    """Return the count of each word, the most frequent first: ``3 ok, 1 step_limit``."""
    found, counts = np.unique(names, return_counts=True)
    order = np.argsort(-counts, kind="stable")
    return ", ".join(f"{counts[i]} {found[i]}" for i in order)


def tally(words: np.ndarray, axes: Sequence[DataArray]) -> str:
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
    values = axes[0].values
    return f" ({axes[0].name} {', '.join(_between(axes[0], values[a], values[b]) for a, b in runs)})"


def _span(axis: DataArray, chosen: np.ndarray) -> str:
    values = axis.values[chosen]
    return f"{axis.name} {_between(axis, values.min(), values.max())}"


def _between(axis: DataArray, low: float, high: float) -> str:
    return " to ".join(measured(end, axis) for end in dict.fromkeys((low, high)))


def failures(dataset: Dataset, dims: Sequence[str]) -> list[str]:
    """Return a line on the cells that failed: number, reasons, and places; none where all ended well."""
    bad = dataset["cell_status"] != 0
    if not bad.any():
        return []
    kinds = counted(words(dataset["cell_status"]).values[bad.values])
    over = bad.any([dim for dim in bad.dims if dim not in dims]).transpose(*dims).values
    return [f"{int(bad.sum())} of {bad.size} failed: {kinds}{places(over, [dataset[dim] for dim in dims])}"]
