"""A periodic orbit, stable or not, by Newton's method on a section map, with its Floquet multipliers.

The unknowns are the coordinates of the section (a linkage: all but the crank's angle; the period is free, as
the motor does not know the time). The map's derivative is exact through contacts: section_map. Validity: the
orbit meets no event at grazing incidence, where the map has no derivative (`grazing`, `closest_approach`).
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Unpack

from jointplay.analysis.evaluate import Quantities, dataset
from jointplay.analysis.keywords import Moving, Names, Settling, analysis
from jointplay.analysis.labels import labelled, outcome
from jointplay.analysis.orbits import orbit_dataset
from jointplay.analysis.orbits.orbit_request import ORBIT, Tolerance
from jointplay.analysis.orbits.orbit_search import Search, at_phase, search
from jointplay.analysis.orbits.section_map import section_map
from jointplay.analysis.orbits.shooting import ITERATIONS, TOLERANCE
from jointplay.analysis.quantities import recorded
from jointplay.analysis.rates import needed
from jointplay.analysis.starts import placed
from jointplay.solver.mechanism.base import Natural
from jointplay.solver.mechanism.records import CrankAngle, Mechanism, Section, TestSystem
from jointplay.solver.motion.looks import part

if TYPE_CHECKING:
    import xarray as xr

ONCE_A_TURN = CrankAngle()
RTOL = 1e-11
SETTLED = 0.5  # progress at the end of the transient


@analysis(*ORBIT, usual={"rtol": RTOL})
def periodic_orbit(
    mechanism: Moving,
    section: Section = ONCE_A_TURN,
    *,
    period: Natural = 1,
    tolerance: Tolerance = TOLERANCE,
    max_iterations: Natural = ITERATIONS,
    record: Names | None = None,
    samples_per_turn: Natural = orbit_dataset.SAMPLES,
    **motion: Unpack[Settling],
) -> xr.Dataset:
    """Find a periodic orbit and its Floquet multipliers.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        What moves.
    section : CrankAngle or Plane
        Section of the map: a crank angle, or the phase of a forcing; of a test system that nothing forces, a
        plane of one of its states.
    period : int
        Turns (periods of the forcing, crossings of the plane) after which the orbit closes; of an orbit that
        closes in fewer the result has the lower number.
    initial : optional
        As in `simulate`, or the whole state as a list; or an orbit, as this function gives it: its state,
        with its `period` and a `transient` of 0 where these are left out.
    transient : int
        Turns that are followed first. Newton's method then starts where, among the last ones, the motion came
        back nearest to itself; with 0, at the start: the way to unstable orbits.
    tolerance : float
        Residual at which the search has succeeded, in units of the states' scales (a radian or the longest
        link, the nominal speed); it goes on below, as far as it gains.
    max_iterations : int
        Of Newton's method.
    record : sequence of str, optional
        Quantities to sample over the orbit; none if left out.
    samples_per_turn : int
        Of these.

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
    quantities, linkage = names(record, mechanism), isinstance(mechanism, Mechanism)
    model, began = placed(mechanism, motion["initial"], section), time.perf_counter()
    requested = section_map(model, section, period, motion["rtol"], motion["max_steps"])
    how = Search(motion["transient"], tolerance, max_iterations)
    orbit = search(requested, how, part(motion["progress"], 0.0, SETTLED))
    state, lead = at_phase(orbit, requested.phase)
    variables = orbit_dataset.variables(state, orbit_dataset.orbit_numbers(orbit), linkage)
    variables |= orbit_dataset.events(orbit, lead, linkage) | orbit_dataset.settings(model)
    variables |= labelled({"n_iterations": (orbit.iterations, "1", "iterations of Newton")})
    coords = orbit_dataset.coordinates(orbit.map)
    if quantities:
        there = replace(orbit.map, phase=requested.phase)
        given = there, state, orbit.image.time, 0 if orbit.status else samples_per_turn
        rows = orbit_dataset.history(*given)
        sharp = orbit_dataset.history(*given, sharp=True) if needed(model, quantities) else rows
        variables |= Quantities(model, rows, rows[:1].ravel(), sharp).variables(quantities, "time")
        coords |= labelled({"time": (rows[:, 0] - there.begin, "s", "time since the section")}, "time")
    variables |= outcome(orbit.status, began, "how the search ended")
    return dataset(model, variables, coords, "periodic_orbit")


def names(record: Sequence[str] | None, mechanism: Mechanism | TestSystem) -> tuple[str, ...]:
    """Names of the quantities that are sampled over the orbit."""
    return () if record is None else recorded(record, mechanism, integrals=False)
