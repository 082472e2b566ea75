"""Answers of cells as labelled tables: what a cell lacks is said so."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from jointplay.analysis.evaluate import flags
from jointplay.lab.paper.character import MOTIONS


def table(answers: Sequence[Mapping[str, Any]], shape: tuple[int, ...], key: str, missing: Any, dtype: type):
    """One value of every answer, as an array of that shape."""
    return np.array([answer.get(key, missing) for answer in answers], dtype=dtype).reshape(shape)


def motions(
    answers: Sequence[Mapping[str, Any]],
    dims: tuple[str, ...],
    shape: tuple[int, ...],
    numbers: Mapping[str, tuple[str, str]],
) -> dict[str, Any]:
    """Variables of what `character` says: numbers by their units and long names, period and motion."""
    found: dict[str, Any] = {
        name: (dims, table(answers, shape, name, math.nan, float), {"units": units, "long_name": text})
        for name, (units, text) in numbers.items()
    }
    told = {"units": "1", "long_name": "period in turns; 0: none found, -1: not computed"}
    found["period"] = (dims, table(answers, shape, "period", -1, np.int32), told)
    told = {"long_name": "what the motion is"} | flags(MOTIONS)
    found["motion"] = (dims, table(answers, shape, "motion", 0, np.int8), told)
    return found
