"""Integer codes as the words that their flags give them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from xarray import DataArray

STRANGE = "?"  # of a code that has no word


def flags(array: DataArray) -> dict[int, str]:
    """Return the word of each code that a variable's flags name; none of one without flags."""
    values = np.atleast_1d(array.attrs.get("flag_values", []))
    return dict(zip(map(int, values), str(array.attrs.get("flag_meanings", "")).split(), strict=False))


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
