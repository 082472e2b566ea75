"""A second estimate of the largest exponent, by renormalised twin trajectories: no Jacobian, no saltation.

It is the largest exponent of the section's map, per turn (`growth`), which tangents give as well
(`section_exponents`).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from jointplay.analysis.evaluate import described, status_code
from jointplay.analysis.exponents.growth import Turn, measure_after, standard_error
from jointplay.mechanism.model import Model


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
    return {"growth": mean, "error": standard_error(logs), "status": status}


def variables(value: float, error: float, growth: dict[str, Any]) -> dict[str, Any]:
    """Variables of a dataset: the second estimate, and how far it is from the first, of that error."""
    combined = math.hypot(error, growth["error"])
    apart = (growth["growth"] - value) / combined if combined else math.nan
    table = {
        "growth": (growth["growth"], "mean logarithm of the growth of a small difference, per turn"),
        "growth_standard_error": (growth["error"], "standard error of the growth"),
        "growth_difference": (apart, "growth less the section map's exponent, in combined standard errors"),
    }
    variables = described({key: ((), value, "1", text) for key, (value, text) in table.items()})
    return variables | {"growth_status": status_code(growth["status"], "how the second estimate ended")}
