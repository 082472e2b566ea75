"""Integer codes as the words that their flags give them."""

import numpy as np
from xarray import DataArray

STRANGE = "?"  # of a code that has no word


def words(array: DataArray) -> DataArray:
    """Return the codes of a variable as words; a code without one as ``?``.

    Parameters
    ----------
    array : DataArray
        With the attributes ``flag_values`` and ``flag_meanings``.
    """
    known = dict(zip(np.atleast_1d(array.attrs["flag_values"]).tolist(), meanings(array), strict=True))
    found, inverse = np.unique(array.values, return_inverse=True)
    named = np.array([known.get(code, STRANGE) for code in found.tolist()], dtype=str)
    result = array.copy(data=named[inverse].reshape(array.shape))
    result.attrs = {name: text for name, text in array.attrs.items() if not name.startswith("flag_")}
    return result


def coded(array: DataArray) -> bool:
    """Whether words stand behind a variable's numbers."""
    return "flag_meanings" in array.attrs


def meanings(array: DataArray) -> list[str]:
    """Return the words of a variable's flags."""
    return str(array.attrs["flag_meanings"]).split()


def counted(names: np.ndarray) -> str:
    """Return how often each word occurs, the most frequent first: ``3 ok, 1 step_limit``."""
    found, counts = np.unique(names, return_counts=True)
    order = np.argsort(-counts, kind="stable")
    return ", ".join(f"{counts[i]} {found[i]}" for i in order)
