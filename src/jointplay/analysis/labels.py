"""Labelled variables of datasets, made of tables of values, units and long names."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from jointplay.analysis.quantities import STATUS

ENDED = "how the run ended"


def flags(meanings: tuple[str, ...]) -> dict[str, Any]:
    """CF attributes of an integer code."""
    values = np.arange(len(meanings), dtype=np.int8)
    return {"units": "1", "flag_values": values, "flag_meanings": " ".join(meanings)}


def described(table: Mapping[str, tuple[Any, Any, str, str]]) -> dict[str, Any]:
    """Variables of a dataset from their dimensions, values, units and long names."""
    return {key: (dims, v, {"units": u, "long_name": text}) for key, (dims, v, u, text) in table.items()}


def number(dims: Any, values: Any, units: str, text: str) -> tuple[Any, Any, dict[str, Any]]:
    """A variable with its units and long name."""
    return dims, values, {"units": units, "long_name": text}


def labelled(rows: Mapping[str, tuple[Any, str, str]], dims: str | tuple[str, ...] = ()) -> dict[str, Any]:
    """Variables over the same dimensions, of name: (values, units, long name)."""
    return {
        name: number(dims, np.asarray(values), units, text) for name, (values, units, text) in rows.items()
    }


def coded(
    dims: str | tuple[str, ...], values: Any, text: str = ENDED, meanings: tuple[str, ...] = STATUS
) -> tuple:
    """A variable of integer codes with their meanings, statuses if none are given."""
    return dims, np.asarray(values, dtype=np.int8), {"long_name": text} | flags(meanings)


def outcome(status: int, began: float, text: str = ENDED) -> dict[str, Any]:
    """Status of an analysis and its wall time, since `began` by `time.perf_counter`."""
    return {"status": coded((), status, text)} | labelled(
        {"wall_time": (time.perf_counter() - began, "s", "wall time of the run")}
    )


def column(answers: Sequence[Mapping[str, Any]], key: str, missing: Any, dtype: Any = float) -> np.ndarray:
    """One entry of the answer of each cell, `missing` where a cell has none."""
    return np.array([answer.get(key, missing) for answer in answers], dtype=dtype)
