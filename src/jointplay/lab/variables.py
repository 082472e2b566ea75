"""Variables of results as xarray takes them: dimensions, values, attributes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from jointplay.analysis.evaluate import flags

Variable = tuple[Any, Any, dict[str, Any]]


def number(dims: Any, values: Any, units: str, text: str) -> Variable:
    """A variable with its units and long name."""
    return dims, values, {"units": units, "long_name": text}


def code(dims: Any, values: Any, meanings: tuple[str, ...], text: str) -> Variable:
    """A CF flag variable: small integers, each an index into `meanings`."""
    return dims, np.asarray(values, dtype=np.int8), {"long_name": text} | flags(meanings)


def column(answers: Sequence[Mapping[str, Any]], key: str, missing: Any, dtype: Any = float) -> np.ndarray:
    """One entry of the answer of each cell, `missing` where a cell has none."""
    return np.array([answer.get(key, missing) for answer in answers], dtype=dtype)
