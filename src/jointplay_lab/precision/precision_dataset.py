"""The result of a comparison as one labelled dataset.

Its dimensions are `solver` and `rtol`: of xarray's `sel`, ``method`` and ``tolerance`` are keywords.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from jointplay.analysis.labels import coded, number
from jointplay.analysis.quantities import STATUS
from jointplay_lab.precision.contenders import OURS
from jointplay_lab.precision.measure import Row, time_at
from jointplay_lab.precision.schedule import Plan
from jointplay_lab.precision.truth import AGREEMENT, CONFIRMED, Truth

LEVELS = tuple(10.0**-k for k in range(4, 11))
NUMBERS = {
    "cpu_time": ("s", "CPU time of a turn, median"),
    "cpu_time_spread": ("s", "CPU time of a turn, half the distance of its quartiles"),
    "evaluations": ("1", "evaluations of the right-hand side in a turn"),
    "steps": ("1", "steps in a turn, rejected ones among them if the method tells"),
    "error": ("1", "largest error of a state at the end, in units of 1 rad and the nominal speed"),
    "events": ("1", "events"),
    "timed_runs": ("1", "runs that make the median; 0: the first run alone"),
    "preparation": ("s", "CPU time that the method took to compile"),
}
CODES = {
    "run_status": (STATUS, "how the run ended"),
    "agreement": (AGREEMENT, "whether it met the truth's events and came near its state"),
}


def _values(row: Row, turns: float) -> dict[str, float]:
    """Numbers and codes of one method at one tolerance."""
    outcome, ended = row.outcome, 1.0 if row.outcome.status == "ok" else math.nan
    return {
        "cpu_time": row.median / turns,
        "cpu_time_spread": row.spread / turns,
        "evaluations": outcome.evaluations / turns,
        "steps": ended * outcome.steps / turns,
        "error": row.error,
        "events": ended * len(outcome.events),
        "timed_runs": float(len(row.times)),
        "preparation": row.compiling,
        "run_status": STATUS.index(outcome.status),
        "agreement": AGREEMENT.index(row.agreement),
    }


def dataset(rows: Sequence[Row], truth: Truth, plan: Plan, turns: float, rtol: float) -> xr.Dataset:
    """Put a comparison together."""
    methods = list(dict.fromkeys(row.method for row in rows))
    of = {name: [row for row in rows if row.method == name] for name in methods}
    table, cells = ("solver", "rtol"), [[_values(row, turns) for row in of[name]] for name in methods]
    values = {name: np.array([[one[name] for one in row] for row in cells]) for name in (*NUMBERS, *CODES)}
    variables = {name: number(table, values[name], *about) for name, about in NUMBERS.items()}
    variables |= {name: coded(table, values[name], text, words) for name, (words, text) in CODES.items()}
    levels = [[time_at(of[method], level) / turns for level in LEVELS] for method in methods]
    text = "CPU time of a turn at an error reached"
    variables["cpu_time_at_error"] = number(("solver", "error_level"), np.array(levels), "s", text)
    variables |= _of_truth(of, truth)
    status = STATUS.index(truth.outcome.status)
    variables["status"] = coded((), status, "how the run that is the truth ended", STATUS)
    coordinates = {
        "solver": ("solver", np.array(methods), {"long_name": "solver"}),
        "rtol": number("rtol", np.array(plan.tolerances), "1", "relative tolerance"),
        "error_level": number("error_level", np.array(LEVELS), "1", "error"),
    }
    attributes = {
        "Conventions": "CF-1.11",
        "kind": "work_precision",
        "turns": turns,
        "truth_tolerance": rtol,
        "truth_confirmed_by": confirming(of)[0] or "none",
        "not_installed": ", ".join(plan.absent) or "none",
    }
    return xr.Dataset(variables, coordinates, attributes)


def confirming(of: dict[str, list[Row]]) -> tuple[str, float]:
    """The peer whose tightest run comes closest to the truth, and its error; '' and NaN where none agrees."""
    tightest = [[row for row in rows if row.outcome.status == "ok"][-1:] for rows in of.values()]
    agreeing = [row for (row,) in filter(None, tightest) if row.agreement == "same" and row.method != OURS]
    best = min(agreeing, key=lambda row: row.error, default=None)
    return (best.method, best.error) if best else ("", math.nan)


def _of_truth(of: dict[str, list[Row]], truth: Truth) -> dict[str, Any]:
    _, difference = confirming(of)
    own = "difference of the truth from its run at ten times the tolerance"
    other = "difference of the truth from the second method that comes closest"
    confirmed = np.int8(difference <= CONFIRMED)
    return {
        "truth_own_difference": number((), truth.own_difference, "1", own),
        "truth_difference": number((), difference, "1", other),
        "truth_confirmed": number((), confirmed, "1", "whether a second method confirms the truth"),
        "truth_events": number((), np.int64(len(truth.outcome.events)), "1", "events of the truth"),
    }
