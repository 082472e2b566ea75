"""A second estimate of the largest exponent, by renormalised twin trajectories: no Jacobian, no saltation.

It is the largest exponent of the section's map, a turn (`growth`). The exponents of a flow hold one more
where nothing outside keeps the time: that along the motion, which is 0. Without it, the flow's largest times
the length of a turn is the map's.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from jointplay.analysis.evaluate import described, status_code
from jointplay.analysis.exponents.growth import Turn, measure_after, standard_error
from jointplay.mechanism.model import Model

ERRORS = 3  # standard errors by which a lone exponent must differ from 0 to be that of the map


def twin(
    model: Model,
    turns: int,
    transient: int,
    max_steps: int | None,
    progress: Callable[[float], None] | None = None,
) -> dict[str, Any]:
    """Follow a motion and a neighbour for some turns after a transient: growth a turn, error, status."""
    turn = Turn(model, max_steps=max_steps)
    logs, _, status = measure_after(turn, transient, turns, progress=progress)
    mean = float(logs.mean()) if len(logs) else math.nan
    timeless = turn.crank is not None
    return {"growth": mean, "error": standard_error(logs), "status": status, "timeless": timeless}


def of_the_map(values: np.ndarray, errors: np.ndarray, timeless: bool) -> tuple[float, float]:
    """Largest exponent of the section's map, and its error, from the leading ones of the flow, a turn.

    Where nothing outside keeps the time (`timeless`), one of the flow's exponents is that along the motion.
    """
    if not timeless:
        return float(values[0]), float(errors[0])
    if len(values) == 1:
        apart = abs(values[0]) > ERRORS * errors[0]
        return (float(values[0]), float(errors[0])) if apart else (math.nan, math.nan)
    along = int(np.argmin(np.abs(values)))  # the first that is unknown, if any is
    first = 1 if along == 0 else 0
    return float(values[first]), float(errors[first])


def variables(values: np.ndarray, errors: np.ndarray, growth: dict[str, Any]) -> dict[str, Any]:
    """Variables of a dataset: the second estimate, and how far both differ."""
    value, error = of_the_map(values, errors, growth["timeless"])
    combined = math.hypot(error, growth["error"])
    apart = (growth["growth"] - value) / combined if combined else math.nan
    table = {
        "growth": (growth["growth"], "mean logarithm of the growth of a small difference in a turn"),
        "growth_standard_error": (growth["error"], "standard error of the growth"),
        "map_exponent": (value, "largest Lyapunov exponent of the section's map, a turn"),
        "growth_difference": (apart, "growth less the map's exponent, in combined standard errors"),
    }
    variables = described({key: ((), value, "1", text) for key, (value, text) in table.items()})
    return variables | {"growth_status": status_code(growth["status"], "how the second estimate ended")}
