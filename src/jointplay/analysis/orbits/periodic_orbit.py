"""A periodic orbit, stable or not, by Newton's method on a section map, with its Floquet multipliers.

The unknowns are the coordinates of the section (a linkage: all but the crank's angle; the period is free, as
the motor does not know the time). The map's derivative is exact through contacts: section_map. Validity: the
orbit meets no event at grazing incidence, where the map has no derivative (`grazing`, `closest_approach`).
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Unpack

import numpy as np

from jointplay.analysis.declared import Outputs
from jointplay.analysis.evaluate import OF_A_MODEL, RUN, Quantities, joint_flags, needed
from jointplay.analysis.keywords import HANDED, Moving, Names, Settling, analysis
from jointplay.analysis.labels import Out, ended, units, xr
from jointplay.analysis.orbits import orbit_dataset
from jointplay.analysis.orbits.orbit_dataset import ORBIT, Tolerance
from jointplay.analysis.orbits.section_map import section_map
from jointplay.analysis.orbits.shooting import ITERATIONS, TOLERANCE, Search, at_phase, search
from jointplay.analysis.quantities import EVENTS, recorded
from jointplay.analysis.rules import recorded_from
from jointplay.analysis.starts import placed
from jointplay.display import codes
from jointplay.display.number_text import measure, plain
from jointplay.solver.mechanism.base import Natural
from jointplay.solver.mechanism.model import Model
from jointplay.solver.mechanism.records import ONCE_A_TURN, Mechanism, Section, TestSystem
from jointplay.solver.motion.progress import part

RTOL = 1e-11
SETTLED = 0.5  # progress at the end of the transient


def verdict(result: xr.Dataset) -> xr.DataArray:
    """Period and stability of each orbit, such as ``period 1, stable``."""
    period, stable = result["period"], codes.words(result["stable"])
    named = codes.chosen(np.isfinite(period), period.fillna(0).astype(int).astype(str), "")
    words = "period " + named.astype(object) + ", " + stable.astype(object)
    return codes.chosen(np.isfinite(period), words, "no orbit found")


def answer(result: xr.Dataset) -> str:
    """Period, stability and largest multiplier of the orbit, and its contacts."""
    if not math.isfinite(float(result["period"])):
        left = float(result["residual"])
        how = f": the state still changes by {plain(left, 2)} over a period" if math.isfinite(left) else ""
        return f"no periodic orbit was found{how}"
    lines = [f"{verdict(result).item()}, {_multiplier(result['floquet_multiplier'].values[0])}"]
    parts = [f"it lasts {measure(float(result['period_time']), 's', 6)}"]
    if math.isfinite(float(result["impacts"])) and "clearance" in result:
        parts.append(f"contacts begun per turn: {plain(float(result['impacts']), 4)}")
    parts.append(f"closed to a residual of {plain(float(result['residual']), 1)}")
    return "\n".join([*lines, ", ".join(parts)])


def _multiplier(value: np.ndarray) -> str:
    real, imaginary = map(float, value)
    size = f"largest multiplier {plain(math.hypot(real, imaginary), 3)}"
    if imaginary:
        return f"{size} in modulus ({plain(real, 3)} ± {plain(abs(imaginary), 3)}i)"
    return f"largest multiplier {plain(real, 3)}"


OUTPUTS = Outputs(
    "periodic_orbit",
    orbit_dataset.COORDS | {"time": Out("time", "time since the section", "s")},
    orbit_dataset.OUTS
    | {
        "event_time": Out("event", "time of the event since the section", "s"),
        "event_joint": Out("event", "joint of the event, counted from 0"),
        "event_approach_speed": Out("event", "rate of the gap at the event", "{speed}"),
        "event_kind": Out("event", "kind of event", flags=EVENTS),
        "turn_period_nominal": RUN["turn_period_nominal"],
        "clearance": OF_A_MODEL["clearance"],
        "n_iterations": Out((), "iterations of Newton"),
        "QUANTITY": Out("time", "what `record` asks for", ""),
    }
    | orbit_dataset.SOUGHT,
    answer,
    verdict,
    shown={"floquet_multiplier": "largest modulus of a Floquet multiplier"},
)


def _started(mechanism: Mechanism | TestSystem, initial: Any, section: Any) -> Model:
    return recorded_from(mechanism, initial, section, (), placed)


@analysis(*ORBIT, usual={"rtol": RTOL}, outputs=OUTPUTS, model=_started)
def periodic_orbit(  # noqa: D417 (nobody gives it the model)
    mechanism: Moving,
    section: Section = ONCE_A_TURN,
    *,
    model: Model = HANDED,
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
        Section of the map: a crank angle, or a phase of the forcing; of a test system that nothing forces, a
        plane of one of its states.
    period : int
        Number of turns, periods of the forcing or crossings of the plane after which the orbit closes. Of an
        orbit that closes in fewer the result has the lower number.
    initial : optional
        As in `simulate`, or the whole state as a list; or an orbit, as this function gives it: its state,
        with its `period` and a `transient` of 0 where these are left out.
    transient : int
        Number of turns that are followed first. Newton's method then starts where, among the last ones, the
        motion came back nearest to itself; with 0, at the start: the way to unstable orbits.
    tolerance : float
        Residual at which the search has succeeded, in units of the states' scales (a radian or the longest
        link, the nominal speed). The search goes on below it as long as it gains.
    max_iterations : int
        Largest number of iterations of Newton's method.
    record : sequence of str, optional
        Quantities that are sampled over the orbit; none if left out.
    samples_per_turn : int
        Number of samples of these in a turn.

    Raises
    ------
    InputError
        If anything asked for makes no sense; numerical trouble is a status instead.
    """
    quantities = names(record, mechanism)
    began = time.perf_counter()
    requested = section_map(model, section, period, motion["rtol"], motion["max_steps"])
    how = Search(motion["transient"], tolerance, max_iterations)
    orbit = search(requested, how, part(motion["progress"], 0.0, SETTLED))
    state, lead = at_phase(orbit, requested.phase)
    values = orbit_dataset.orbit_numbers(orbit) | orbit_dataset.events(orbit, lead)
    values |= orbit_dataset.settings(model) | orbit_dataset.coordinates(orbit.map)
    values |= {"orbit_state": state, "n_iterations": orbit.iterations} | ended(orbit.status, began)
    history = {}
    if quantities:
        there = replace(orbit.map, phase=requested.phase)
        given = there, state, orbit.image.time, 0 if orbit.status else samples_per_turn
        rows = orbit_dataset.history(*given)
        sharp = orbit_dataset.history(*given, sharp=True) if needed(model, quantities) else rows
        history = Quantities(model, rows, rows[:1].ravel(), sharp).variables(quantities, "time")
        values["time"] = rows[:, 0] - there.begin
    of = units(isinstance(mechanism, Mechanism))
    found = OUTPUTS.dataset(values, of=of, model=model, groups={"QUANTITY": history}, **orbit.trouble)
    found["event_joint"].attrs |= joint_flags(orbit.map.model)
    return found


def names(record: Sequence[str] | None, mechanism: Mechanism | TestSystem) -> tuple[str, ...]:
    """Names of the quantities that are sampled over the orbit."""
    return () if record is None else recorded(record, mechanism, integrals=False)
