"""Labelled variables of datasets, made of tables of values, units and long names."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from jointplay.analysis.evaluate import flags
from jointplay.analysis.quantities import STATUS


def number(dims: Any, values: Any, units: str, text: str) -> tuple[Any, Any, dict[str, Any]]:
    """A variable with its units and long name."""
    return dims, values, {"units": units, "long_name": text}


def labelled(rows: Mapping[str, tuple[Any, str, str]], dims: str | tuple[str, ...] = ()) -> dict[str, Any]:
    """Variables over the same dimensions, of name: (values, units, long name)."""
    return {
        name: number(dims, np.asarray(values), units, text) for name, (values, units, text) in rows.items()
    }


def coded(dims: str | tuple[str, ...], values: Any, text: str, meanings: tuple[str, ...] = STATUS) -> tuple:
    """A variable of integer codes with their meanings, statuses if none are given."""
    return dims, np.asarray(values, dtype=np.int8), {"long_name": text} | flags(meanings)


def outcome(status: int, began: float, text: str = "how the run ended") -> dict[str, Any]:
    """Status of an analysis and its wall time, since `began` by `time.perf_counter`."""
    return {"status": coded((), status, text)} | labelled(
        {"wall_time": (time.perf_counter() - began, "s", "wall time of the run")}
    )


def column(answers: Sequence[Mapping[str, Any]], key: str, missing: Any, dtype: Any = float) -> np.ndarray:
    """One entry of the answer of each cell, `missing` where a cell has none."""
    return np.array([answer.get(key, missing) for answer in answers], dtype=dtype)
