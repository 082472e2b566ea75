"""Error against run time and evaluations, for the method used here and for other solvers.

All follow the same motion of the same equations, in one process and by turns, with the same modes and events;
each locates events in its own way, and starts anew after them. Measured is CPU time, so that a busy machine
disturbs little; even so, times are to be read as ratios.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated

import xarray as xr

from jointplay.analysis.keywords import Length, Moving, Progress, Rtol, Start, analysis
from jointplay.analysis.rules import start_fits, steps
from jointplay.display.errors import Problem
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.base import Count, Natural, Positive, unit
from jointplay.solver.mechanism.records import Mechanism, TestSystem
from jointplay_lab.precision.schedule import PEERS, Peers, Plan, Tolerances, unknown_peers

TOLERANCES = (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12)
ROUNDS, BUDGET, RTOL = 7, 60.0, 1e-13


def _linear_contact(mechanism: Mechanism | TestSystem) -> Iterator[Problem]:
    """Other solvers are set up for the linear law alone: what begins with a power of time is not theirs."""
    for joint in mechanism.clearance_joints if isinstance(mechanism, Mechanism) else ():
        if joint.contact.law != "kelvin_voigt":
            key = f"mechanism.joints.{joint.name}.contact.law"
            yield Problem(key, joint.contact.law, "'kelvin_voigt' is accepted")


@analysis(unknown_peers, _linear_contact, start_fits)
def work_precision(
    mechanism: Moving,
    *,
    turns: Length = 1,
    tolerances: Tolerances = TOLERANCES,
    peers: Peers = tuple(PEERS),
    rounds: Count = ROUNDS,
    budget: Annotated[Positive, unit("CPU time for all runs", "s")] = BUDGET,
    rtol: Rtol = RTOL,
    initial: Start | None = None,
    max_steps: Natural | None = None,
    progress: Progress = None,
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
    initial, max_steps, progress
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
    from jointplay_lab.precision.precision_dataset import dataset
    from jointplay_lab.precision.truth import Truth

    plan = Plan(tolerances, peers)
    model, limit = assemble(mechanism, initial), steps(max_steps)
    end = turns * model.period
    truth = Truth.of(model, rtol, end, limit)
    rows = [
        Row(name, tolerance, contender(name, model, tolerance, end, truth, limit))
        for name in (OURS, *plan.installed)
        for tolerance in plan.tolerances
    ]
    if truth.outcome.status == "ok":
        measure(rows, truth, rounds, budget, progress)
    return dataset(rows, truth, plan, turns, rtol)
