"""A periodic orbit, stable or not, by Newton's method on a section map, with its Floquet multipliers.

The unknowns are the coordinates of the section (a linkage: all but the crank's angle; the period is free, as
the motor does not know the time). The map's derivative is exact through contacts: section_map. Validity: the
orbit meets no event at grazing incidence, where the map has no derivative (`grazing`, `closest_approach`).
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import xarray as xr

from jointplay.analysis.evaluate import Quantities, dataset, flags
from jointplay.analysis.keywords import Moving, Names, Progress, Rtol, Start, analysis
from jointplay.analysis.looks import part
from jointplay.analysis.orbits import orbit_dataset
from jointplay.analysis.orbits.orbit_request import ORBIT, Tolerance
from jointplay.analysis.orbits.orbit_search import Search, at_phase, search
from jointplay.analysis.orbits.section_map import section_map
from jointplay.analysis.orbits.shooting import ITERATIONS, TOLERANCE, Orbit
from jointplay.analysis.quantities import STATUS, recorded
from jointplay.analysis.rates import needed
from jointplay.analysis.starts import placed
from jointplay.mechanism.base import Count, Natural
from jointplay.mechanism.records import CrankAngle, Mechanism, Section, TestSystem

ONCE_A_TURN = CrankAngle()
RTOL = 1e-11
TRANSIENT = 100
SETTLED = 0.5  # of the progress, when Newton's method begins


@analysis(*ORBIT)
def periodic_orbit(
    mechanism: Moving,
    section: Section = ONCE_A_TURN,
    *,
    period: Natural = 1,
    initial: Start | None = None,
    transient: Count = TRANSIENT,
    rtol: Rtol = RTOL,
    tolerance: Tolerance = TOLERANCE,
    max_iterations: Natural = ITERATIONS,
    record: Names | None = None,
    samples_per_turn: Natural = orbit_dataset.SAMPLES,
    max_steps: Natural | None = None,
    progress: Progress = None,
) -> xr.Dataset:
    """Find a periodic orbit and its Floquet multipliers.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        What moves.
    section : CrankAngle or Plane
        Where the orbit is looked for: a crank angle, or the phase of a forcing; of a test system that
        nothing forces, a plane of one of its states.
    period : int
        Turns (periods of the forcing, crossings of the plane) after which the orbit closes; an orbit that
        closes in fewer is told as such.
    initial : optional
        As in `simulate`, or the whole state as a list.
    transient : int
        Turns that are followed first. Newton's method then starts where, among the last ones, the motion came
        back nearest to itself; with 0, at the start: the way to unstable orbits.
    rtol : float
        Relative tolerance of a step.
    tolerance : float
        Residual at which the search has succeeded, in units of the states' scales (a radian or the longest
        link, the nominal speed); it goes on below, as far as it gains.
    max_iterations : int
        Of Newton's method.
    record : sequence of str, optional
        Quantities to sample over the orbit; none if left out.
    samples_per_turn : int
        Of these.
    max_steps : int, optional
        Attempted steps after which a run stops.
    progress : callable, optional
        Called with the fraction done.

    Returns
    -------
    xarray.Dataset
        ``orbit_state`` on the section; ``period`` (turns) and ``period_time`` (s); ``residual``;
        ``floquet_multiplier`` over ``multiplier`` (the largest first) and ``part``; ``lyapunov_exponent``,
        ln|multiplier| over the period (minus infinity where sticking loses a direction); ``stable``; the
        events of the orbit; ``impacts`` a turn; ``smallest_impact_speed``, ``closest_approach`` and
        ``grazing``: how near the orbit is to other events; quantities of `record` over ``time``; ``status``.

    Raises
    ------
    InputError
        If anything asked for makes no sense; numerical trouble is a status instead.
    """
    quantities = names(record, mechanism)
    model = placed(mechanism, initial, section)
    began = time.perf_counter()
    turns = section_map(model, section, period, rtol, max_steps)
    orbit = search(turns, Search(transient, tolerance, max_iterations), part(progress, 0.0, SETTLED))
    told = _dataset(orbit, turns.phase, quantities, samples_per_turn, isinstance(mechanism, Mechanism))
    seconds = {"units": "s", "long_name": "wall time of the run"}
    return told.assign(wall_time=((), time.perf_counter() - began, seconds))


def names(record: Sequence[str] | None, mechanism: Mechanism | TestSystem) -> tuple[str, ...]:
    """Names of the quantities that are sampled over the orbit."""
    return () if record is None else recorded(record, mechanism, integrals=False)


def _dataset(orbit: Orbit, phase: float, names, per_turn: int, linkage: bool) -> xr.Dataset:
    model = orbit.map.model
    state, lead = at_phase(orbit, phase)
    variables = orbit_dataset.state(state, ())
    variables |= orbit_dataset.variables(orbit_dataset.described(orbit), (), linkage)
    variables |= orbit_dataset.events(orbit, lead, linkage)
    variables["n_iterations"] = ((), orbit.iterations, {"units": "1", "long_name": "iterations of Newton"})
    variables["status"] = ((), np.int8(orbit.status), {"long_name": "how the search ended"} | flags(STATUS))
    variables |= orbit_dataset.settings(model)
    coords = orbit_dataset.coordinates(orbit.map)
    if names:
        on = replace(orbit.map, phase=phase)
        asked_for = on, state, orbit.image.time, 0 if orbit.status else per_turn
        rows = orbit_dataset.history(*asked_for)
        sharp = orbit_dataset.history(*asked_for, sharp=True) if needed(names) else rows
        variables |= Quantities(model, rows, rows[:1].ravel(), sharp).variables(names, "time")
        named = {"units": "s", "long_name": "time since the section"}
        coords["time"] = ("time", rows[:, 0] - on.begin, named)
    return dataset(model, variables, coords, "periodic_orbit")
