"""Variables of periodic orbits: state, numbers, events and history."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from jointplay.analysis.evaluate import RUN
from jointplay.analysis.labels import Out
from jointplay.analysis.orbits import floquet, orbit_events
from jointplay.analysis.orbits.orbit_events import BEGINS, CONTACT, KIND, PLACE, TIME
from jointplay.analysis.orbits.section_map import SectionMap
from jointplay.analysis.orbits.shooting import Orbit
from jointplay.analysis.quantities import STATUS
from jointplay.analysis.starts import state_names
from jointplay.solver.codegen import cache
from jointplay.solver.mechanism.model import Model

SAMPLES = 720  # a turn, for histories and closest approaches
PARTS = ("real", "imaginary")
STABILITY = ("unstable", "stable", "unknown")
OUTS = {
    "period": Out((), "period in turns"),
    "period_time": Out((), "period", "s"),
    "residual": Out((), "largest change of the state over a period, in units of the states' scales"),
    "impacts": Out((), "contacts begun in a turn"),
    "smallest_impact_speed": Out((), "smallest speed with which a contact begins", "{speed}"),
    "closest_approach": Out((), "smallest gap, or penetration, that is turned back from", "{length}"),
    "grazing": Out((), "smallest relative approach to a guard", about="near 0: near another event"),
    "floquet_multiplier": Out(("multiplier", "part"), "Floquet multiplier"),
    "lyapunov_exponent": Out(
        "multiplier", "Lyapunov exponent of the orbit", "s-1", "ln|multiplier| over the period"
    ),
    "orbit_state": Out("state", "state on the section: rad, m and their rates, or a system's own"),
    "stable": Out((), "stability", flags=STABILITY, missing="unknown"),
}
COORDS = {
    "multiplier": Out("multiplier", "number of the multiplier, the largest first"),
    "part": Out("part", "part of a complex number"),
    "state": Out("state", "state"),
}
SOUGHT = {"status": Out((), "how the search ended", flags=STATUS), "wall_time": RUN["wall_time"]}


def history(
    section: SectionMap, state: np.ndarray, duration: float, per_turn: int = SAMPLES, sharp: bool = False
) -> np.ndarray:
    """Rows of time, state, modes over an orbit in even steps; the last repeats the first (0: none).

    `sharp`: states whose accelerations are resolved (analysis.rates).
    """
    if not per_turn:
        contacts = cache.structure_module(section.model.structure).SIZES["contacts"]
        return np.zeros((0, 1 + len(state) + contacts))
    times = section.begin + np.linspace(0.0, 1.0, section.turns * per_turn + 1) * duration
    rows, status = section.sampled(state, times, sharp)
    return rows if not status else np.full_like(rows, np.nan)


def orbit_numbers(orbit: Orbit) -> dict[str, Any]:
    """Numbers of an orbit: values of `OUTS` but for its state."""
    section, image = orbit.map, orbit.image
    if orbit.status:
        return missing_numbers(len(section.free)) | {"residual": orbit.residual}
    multipliers = floquet.multipliers(image.derivative)
    begins = np.isin(image.events[:, KIND], BEGINS)
    gaps, _ = orbit_events.gaps(section.model, history(section, orbit.state, image.time)[:-1])
    return {
        "period": float(section.turns),
        "period_time": image.time,
        "residual": orbit.residual,
        "impacts": float(np.sum(begins) / section.turns),
        "smallest_impact_speed": orbit_events.smallest_impact_speed(section.model, image.events),
        "closest_approach": orbit_events.closest_approach(gaps, image.events),
        "grazing": image.grazing if len(image.events) else math.nan,
        "floquet_multiplier": np.stack([multipliers.real, multipliers.imag], -1),
        "lyapunov_exponent": floquet.exponents(multipliers, image.time),
        "stable": int(floquet.stable(multipliers)),
    }


def missing_numbers(size: int) -> dict[str, Any]:
    """The numbers of an orbit that was not found."""
    sizes = {"multiplier": size, "part": len(PARTS)}
    known = {name: out for name, out in OUTS.items() if name != "orbit_state"}
    return {name: out.none(tuple(sizes[dim] for dim in out.axes))[()] for name, out in known.items()}


def coordinates(section: SectionMap) -> dict[str, Any]:
    """Values of `COORDS`."""
    names = np.array(state_names(section.model), dtype=str)
    numbers = np.arange(1, len(section.free) + 1)
    return {"multiplier": numbers, "part": np.array(PARTS), "state": names}


def settings(model: Model) -> dict[str, Any]:
    """Data of the mechanism that figures of an orbit need."""
    period = {"turn_period_nominal": model.period}
    return period | ({"clearance": np.asarray(model.clearances)} if model.clearances else {})


def events(orbit: Orbit, lead: float) -> dict[str, Any]:
    """The orbit's events in turn, timed from the section asked for, `lead` s after that of its map."""
    rows, duration = orbit.image.events, orbit.image.time
    if rows is None:
        rows, duration = np.zeros((0, TIME + 1)), 1.0
    times = np.mod(rows[:, PLACE] * duration - lead, duration)
    order = np.argsort(times)
    return {
        "event_time": times[order],
        "event_joint": rows[order, CONTACT].astype(np.int16),
        "event_approach_speed": orbit_events.approach_speeds(orbit.map.model, rows)[order],
        "event_kind": rows[order, KIND],
    }
