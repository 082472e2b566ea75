"""Error against run time and evaluations, for the method used here and for other solvers.

All follow the same motion of the same equations, in one process and by turns, with the same modes and events;
each locates events in its own way, and starts anew after them. Measured is CPU time, so that a busy machine
disturbs little; even so, times are to be read as ratios.

The result's dimensions are `solver` and `rtol`: of xarray's `sel`, ``method`` and ``tolerance`` are keywords.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Annotated, Any, Unpack

import numpy as np
import xarray as xr

from jointplay.analysis.keywords import Length, Motion, Moving, analysis
from jointplay.analysis.labels import coded, number
from jointplay.analysis.quantities import STATUS
from jointplay.analysis.rules import start_fits, steps
from jointplay.display.errors import Problem
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.base import Count, Positive, unit
from jointplay.solver.mechanism.records import Mechanism, TestSystem
from jointplay_lab.precision.contenders import OURS
from jointplay_lab.precision.measure import Row, time_at
from jointplay_lab.precision.schedule import PEERS, Peers, Plan, Tolerances, unknown_peers
from jointplay_lab.precision.truth import AGREEMENT, CONFIRMED, Truth

TOLERANCES = (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12)
ROUNDS, BUDGET, RTOL = 7, 60.0, 1e-13
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


def _linear_contact(mechanism: Mechanism | TestSystem) -> Iterator[Problem]:
    """Other solvers are set up for the linear law alone: what begins with a power of time is not theirs."""
    for joint in mechanism.clearance_joints if isinstance(mechanism, Mechanism) else ():
        if joint.contact.law != "kelvin_voigt":
            key = f"mechanism.joints.{joint.name}.contact.law"
            yield Problem(key, joint.contact.law, "'kelvin_voigt' is accepted")


@analysis(unknown_peers, _linear_contact, start_fits, usual={"rtol": RTOL})
def work_precision(
    mechanism: Moving,
    *,
    turns: Length = 1,
    tolerances: Tolerances = TOLERANCES,
    peers: Peers = tuple(PEERS),
    rounds: Count = ROUNDS,
    budget: Annotated[Positive, unit("CPU time for all runs", "s")] = BUDGET,
    **motion: Unpack[Motion],
) -> xr.Dataset:
    """Compare this package's method with other solvers on one motion.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        What moves.
    turns : float
        Nominal turns, or forcing periods, that are followed.
    tolerances : sequence of float
        Relative tolerances that every method runs at, falling.
    peers : sequence of str
        Of heyoka, CVODE (scikit-sundae), LSODA, Radau, DOP853 (SciPy). Those not installed are named in
        the result and left out.
    rounds : int
        Timed runs of each method and tolerance at most, after a first that is judged.
    budget : float
        CPU time for all runs, s, shared evenly by the methods. What does not fit is not run.
    rtol : float
        Tolerance of the run that is taken as the truth.
    max_steps
        As in `simulate`; `max_steps` is of this package's runs.

    Returns
    -------
    xarray.Dataset
        Over ``solver`` and ``rtol``: ``error`` (largest of a state at the end, in units of 1 rad and
        the nominal speed), ``cpu_time`` of a turn (s, median) and ``cpu_time_spread``, ``evaluations`` and
        ``steps`` of a turn, ``events``, ``run_status``, ``agreement`` (flags same, other_events,
        other_state, no_end). Over ``error_level``: ``cpu_time_at_error``. Of the truth:
        ``truth_difference`` to the second method that comes closest, ``truth_confirmed``,
        ``truth_own_difference``, ``status``.

    Raises
    ------
    InputError
        Listing what makes no sense.
    """
    from jointplay_lab.precision.measure import OURS, Row, contender, measure
    from jointplay_lab.precision.truth import Truth

    plan = Plan(tolerances, peers)
    model, limit = assemble(mechanism, motion["initial"]), steps(motion["max_steps"])
    end = turns * model.period
    truth = Truth.of(model, motion["rtol"], end, limit)
    rows = [
        Row(name, tolerance, contender(name, model, tolerance, end, truth, limit))
        for name in (OURS, *plan.installed)
        for tolerance in plan.tolerances
    ]
    if truth.outcome.status == "ok":
        measure(rows, truth, rounds, budget, motion["progress"])
    return dataset(rows, truth, plan, turns, motion["rtol"])


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
