"""What a comparison found, as one labelled dataset.

Its dimensions are `solver` and `rtol`: of xarray's `sel`, ``method`` and ``tolerance`` are keywords.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import xarray as xr

from jointplay.analysis.evaluate import flags
from jointplay.analysis.quantities import STATUS
from jointplay.lab.precision.contenders import OURS
from jointplay.lab.precision.measure import Row, time_at
from jointplay.lab.precision.schedule import Plan
from jointplay.lab.precision.truth import AGREEMENT, CONFIRMED, Truth

LEVELS = tuple(10.0**-k for k in range(4, 11))
CODES: dict[str, tuple[tuple[str, ...], str, Callable[[Row], str]]] = {
    "run_status": (STATUS, "how the run ended", lambda row: row.outcome.status),
    "agreement": (
        AGREEMENT,
        "whether it met the truth's events and came near its state",
        lambda row: row.agreement,
    ),
}
OF_TURN: dict[str, tuple[str, str, Callable[[Row], float]]] = {
    "cpu_time": ("s", "CPU time of a turn, median", lambda row: row.median),
    "cpu_time_spread": (
        "s",
        "CPU time of a turn, half the distance of its quartiles",
        lambda row: row.spread,
    ),
    "evaluations": ("1", "evaluations of the right-hand side in a turn", lambda row: row.outcome.evaluations),
    "steps": (
        "1",
        "steps in a turn, rejected ones among them if the method tells",
        lambda row: _ended(row, row.outcome.steps),
    ),
}
OF_RUN: dict[str, tuple[str, str, Callable[[Row], float]]] = {
    "error": (
        "1",
        "largest error of a state at the end, in units of 1 rad and the nominal speed",
        lambda row: row.error,
    ),
    "events": ("1", "events", lambda row: _ended(row, len(row.outcome.events))),
    "timed_runs": (
        "1",
        "runs that make the median; 0: the first run alone",
        lambda row: float(len(row.times)),
    ),
    "preparation": ("s", "CPU time that the method took to compile", lambda row: row.compiling),
}


def _ended(row: Row, value: float) -> float:
    return float(value) if row.outcome.status == "ok" else math.nan


def dataset(rows: Sequence[Row], truth: Truth, plan: Plan, turns: float, rtol: float) -> xr.Dataset:
    """Put a comparison together."""
    methods = list(dict.fromkeys(row.method for row in rows))
    of = {name: [row for row in rows if row.method == name] for name in methods}
    table, variables = ("solver", "rtol"), {}
    for found, scale in ((OF_TURN, turns), (OF_RUN, 1.0)):
        for name, (unit, text, value) in found.items():
            values = [[value(row) / scale for row in of[method]] for method in methods]
            variables[name] = (table, np.array(values), {"units": unit, "long_name": text})
    for name, (words, text, word) in CODES.items():
        values = [[words.index(word(row)) for row in of[method]] for method in methods]
        variables[name] = (table, np.array(values, dtype=np.int8), {"long_name": text} | flags(words))
    levels = [[time_at(of[method], level) / turns for level in LEVELS] for method in methods]
    text = {"units": "s", "long_name": "CPU time of a turn at an error reached"}
    variables["cpu_time_at_error"] = (("solver", "error_level"), np.array(levels), text)
    variables |= _of_truth(of, truth)
    code = np.int8(STATUS.index(truth.outcome.status))
    variables["status"] = ((), code, {"long_name": "how the run that is the truth ended"} | flags(STATUS))
    return xr.Dataset(variables, _coordinates(methods, plan), _attributes(of, truth, plan, turns, rtol))


def confirming(of: dict[str, list[Row]]) -> tuple[str, float]:
    """The peer whose tightest run comes closest to the truth, and how close; '' and NaN where none agrees."""
    tightest = [[row for row in rows if row.outcome.status == "ok"][-1:] for rows in of.values()]
    agreeing = [row for (row,) in filter(None, tightest) if row.agreement == "same" and row.method != OURS]
    best = min(agreeing, key=lambda row: row.error, default=None)
    return (best.method, best.error) if best else ("", math.nan)


def _of_truth(of: dict[str, list[Row]], truth: Truth) -> dict[str, Any]:
    _, difference = confirming(of)
    own = {"units": "1", "long_name": "difference of the truth from its run at ten times the tolerance"}
    other = {"units": "1", "long_name": "difference of the truth from the second method that comes closest"}
    confirmed = {"units": "1", "long_name": "whether a second method confirms the truth"}
    return {
        "truth_own_difference": ((), truth.own_difference, own),
        "truth_difference": ((), difference, other),
        "truth_confirmed": ((), np.int8(difference <= CONFIRMED), confirmed),
        "truth_events": (
            (),
            np.int64(len(truth.outcome.events)),
            {"units": "1", "long_name": "events of the truth"},
        ),
    }


def _coordinates(methods: list[str], plan: Plan) -> dict[str, Any]:
    tolerance = {"units": "1", "long_name": "relative tolerance"}
    return {
        "solver": ("solver", np.array(methods), {"long_name": "solver"}),
        "rtol": ("rtol", np.array(plan.tolerances), tolerance),
        "error_level": ("error_level", np.array(LEVELS), {"units": "1", "long_name": "error"}),
    }


def _attributes(
    of: dict[str, list[Row]], truth: Truth, plan: Plan, turns: float, rtol: float
) -> dict[str, Any]:
    return {
        "Conventions": "CF-1.11",
        "kind": "work_precision",
        "turns": turns,
        "truth_tolerance": rtol,
        "truth_confirmed_by": confirming(of)[0] or "none",
        "not_installed": ", ".join(plan.absent) or "none",
    }
