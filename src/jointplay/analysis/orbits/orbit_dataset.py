"""Variables of periodic orbits: state, numbers, events and history."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from jointplay.analysis.evaluate import joint_flags
from jointplay.analysis.labels import coded, labelled
from jointplay.analysis.orbits import floquet, orbit_events
from jointplay.analysis.orbits.orbit_events import BEGINS, CONTACT, KIND, PLACE, TIME
from jointplay.analysis.orbits.section_map import SectionMap
from jointplay.analysis.orbits.shooting import Orbit
from jointplay.analysis.quantities import EVENTS
from jointplay.analysis.starts import state_names
from jointplay.solver.codegen import cache
from jointplay.solver.mechanism.model import Model

SAMPLES = 720  # a turn, for histories and closest approaches
PARTS = ("real", "imaginary")
STABILITY = ("unstable", "stable", "unknown")
NUMBERS = {  # name: units, long name
    "period": ("1", "period in turns"),
    "period_time": ("s", "period"),
    "residual": ("1", "largest change of the state over a period, in units of the states' scales"),
    "impacts": ("1", "contacts begun in a turn"),
    "smallest_impact_speed": ("m s-1", "smallest speed with which a contact begins"),
    "closest_approach": ("m", "smallest gap, or penetration, that is turned back from"),
    "grazing": ("1", "smallest relative approach to a guard"),
}


def units(unit: str, linkage: bool) -> str:
    """Units of a quantity: a test system's lengths have none."""
    return unit if linkage or "m" not in unit else "1"


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
    """Numbers of an orbit, by name: `NUMBERS`, and multipliers, exponents, stability."""
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
    nothing = {"floquet_multiplier": np.full((size, 2), np.nan), "lyapunov_exponent": np.full(size, np.nan)}
    return dict.fromkeys(NUMBERS, math.nan) | nothing | {"stable": STABILITY.index("unknown")}


def variables(
    state: np.ndarray, numbers: dict[str, Any], linkage: bool, dims: tuple[str, ...] = ()
) -> dict[str, Any]:
    """Variables of an orbit's state and of its `orbit_numbers` (each stacked along `dims`)."""
    scalars = {name: (numbers[name], units(unit, linkage), text) for name, (unit, text) in NUMBERS.items()}
    multipliers = {"floquet_multiplier": (numbers["floquet_multiplier"], "1", "Floquet multiplier")}
    exponents = {"lyapunov_exponent": (numbers["lyapunov_exponent"], "s-1", "Lyapunov exponent of the orbit")}
    named = "state on the section: rad, m and their rates, or a system's own"
    return {
        **labelled(scalars, dims),
        **labelled(multipliers, (*dims, "multiplier", "part")),
        **labelled(exponents, (*dims, "multiplier")),
        **labelled({"orbit_state": (state, "1", named)}, (*dims, "state")),
        "stable": coded(dims, numbers["stable"], "stability", STABILITY),
    }


def coordinates(section: SectionMap) -> dict[str, Any]:
    """Coordinates of multipliers and states."""
    number, text = np.arange(1, len(section.free) + 1), "number of the multiplier, the largest first"
    names = np.array(state_names(section.model), dtype=str)
    return {
        **labelled({"multiplier": (number, "1", text)}, "multiplier"),
        **labelled({"part": (PARTS, "1", "part of a complex number")}, "part"),
        **labelled({"state": (names, "1", "state")}, "state"),
    }


def settings(model: Model) -> dict[str, Any]:
    """Data of the mechanism that figures of an orbit need."""
    period = labelled({"turn_period_nominal": (model.period, "s", "nominal period of the drive")})
    clearances = {"clearance": (model.clearances, "m", "radial clearance")}
    return period | (labelled(clearances, "joint") if model.clearances else {})


def events(orbit: Orbit, lead: float, linkage: bool) -> dict[str, Any]:
    """The orbit's events in turn, timed from the wanted section, `lead` s after that of its map."""
    rows, duration = orbit.image.events, orbit.image.time
    if rows is None:
        rows, duration = np.zeros((0, TIME + 1)), 1.0
    times = np.mod(rows[:, PLACE] * duration - lead, duration)
    speeds = orbit_events.approach_speeds(orbit.map.model, rows)
    order = np.argsort(times)
    contacts, kinds = rows[order, CONTACT].astype(np.int16), rows[order, KIND]
    table = {
        "event_time": (times[order], "s", "time of the event since the section"),
        "event_joint": (contacts, "1", "joint of the event, counted from 0"),
        "event_approach_speed": (speeds[order], units("m s-1", linkage), "rate of the gap at the event"),
    }
    variables = labelled(table, "event") | {"event_kind": coded("event", kinds, "kind of event", EVENTS)}
    variables["event_joint"][2].update(joint_flags(orbit.map.model))
    return variables
