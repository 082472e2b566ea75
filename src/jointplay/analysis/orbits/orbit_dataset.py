"""What is told of a periodic orbit: numbers, its events, its history, as labelled variables."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from jointplay.analysis.evaluate import flags
from jointplay.analysis.orbits import floquet
from jointplay.analysis.orbits import orbit_events as met
from jointplay.analysis.orbits.section_map import SectionMap
from jointplay.analysis.orbits.shooting import Orbit
from jointplay.analysis.quantities import EVENTS
from jointplay.analysis.starts import state_names
from jointplay.codegen import cache
from jointplay.mechanism.model import Model

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

    Sharp: states whose accelerations are right (analysis.rates).
    """
    if not per_turn:
        contacts = cache.structure_module(section.model.structure).SIZES["contacts"]
        return np.zeros((0, 1 + len(state) + contacts))
    times = section.begin + np.linspace(0.0, 1.0, section.turns * per_turn + 1) * duration
    rows, status = section.sampled(state, times, sharp)
    return rows if not status else np.full_like(rows, np.nan)


def described(orbit: Orbit) -> dict[str, Any]:
    """Numbers of an orbit, by name: those of `NUMBERS`, and multipliers, exponents, stability."""
    section, image = orbit.map, orbit.image
    if orbit.status:
        return lost(len(section.free)) | {"residual": orbit.residual}
    found = floquet.multipliers(image.derivative)
    begins = np.isin(image.events[:, met.KIND], met.BEGINS)
    rows = history(section, orbit.state, image.time)[:-1]
    return {
        "period": float(section.turns),
        "period_time": image.time,
        "residual": orbit.residual,
        "impacts": float(np.sum(begins) / section.turns),
        "smallest_impact_speed": met.smallest_impact_speed(section.model, image.events),
        "closest_approach": met.closest_approach(met.gaps(section.model, rows)[0], image.events),
        "grazing": image.grazing if len(image.events) else math.nan,
        "floquet_multiplier": np.stack([found.real, found.imag], -1),
        "lyapunov_exponent": floquet.exponents(found, image.time),
        "stable": int(floquet.stable(found)),
    }


def lost(size: int) -> dict[str, Any]:
    """The numbers of an orbit that was not found."""
    nothing = {"floquet_multiplier": np.full((size, 2), np.nan), "lyapunov_exponent": np.full(size, np.nan)}
    return dict.fromkeys(NUMBERS, math.nan) | nothing | {"stable": STABILITY.index("unknown")}


def variables(told: dict[str, Any], dims: tuple[str, ...], linkage: bool) -> dict[str, Any]:
    """Labelled variables of what `described` gives (stacked along `dims`)."""
    found = {
        name: (dims, told[name], {"units": units(unit, linkage), "long_name": text})
        for name, (unit, text) in NUMBERS.items()
    }
    multiplier = {"units": "1", "long_name": "Floquet multiplier"}
    exponent = {"units": "s-1", "long_name": "Lyapunov exponent of the orbit"}
    stable = {"long_name": "stability"} | flags(STABILITY)
    return found | {
        "floquet_multiplier": ((*dims, "multiplier", "part"), told["floquet_multiplier"], multiplier),
        "lyapunov_exponent": ((*dims, "multiplier"), told["lyapunov_exponent"], exponent),
        "stable": (dims, np.int8(told["stable"]), stable),
    }


def state(values: np.ndarray, dims: tuple[str, ...]) -> dict[str, Any]:
    """The orbit's state, over its names."""
    named = {"units": "1", "long_name": "state on the section: rad, m and their rates, or a system's own"}
    return {"orbit_state": ((*dims, "state"), values, named)}


def coordinates(section: SectionMap) -> dict[str, Any]:
    """Coordinates of multipliers and states."""
    number = {"units": "1", "long_name": "number of the multiplier, the largest first"}
    names = np.array(state_names(section.model), dtype=str)
    return {
        "multiplier": ("multiplier", np.arange(1, len(section.free) + 1), number),
        "part": ("part", np.array(PARTS), {"units": "1", "long_name": "part of a complex number"}),
        "state": ("state", names, {"units": "1", "long_name": "state"}),
    }


def settings(model: Model) -> dict[str, Any]:
    """What pictures of an orbit need of its mechanism."""
    nominal = {"units": "s", "long_name": "nominal period of the drive"}
    found = {"turn_period_nominal": ((), model.period, nominal)}
    if model.clearances:
        radial = {"units": "m", "long_name": "radial clearance"}
        found["clearance"] = ("joint", np.array(model.clearances), radial)
    return found


def events(orbit: Orbit, lead: float, linkage: bool) -> dict[str, Any]:
    """The orbit's events in turn, timed from the section asked for, which is `lead` s after the map's own."""
    model, rows, duration = orbit.map.model, orbit.image.events, orbit.image.time
    if rows is None:
        rows, duration = np.zeros((0, met.TIME + 1)), 1.0
    times = np.mod(rows[:, met.PLACE] * duration - lead, duration)
    told = {
        "event_time": (times, {"units": "s", "long_name": "time of the event since the section"}),
        "event_joint": (
            rows[:, met.CONTACT].astype(np.int16),
            {"units": "1", "long_name": "joint of the event, counted from 0"},
        ),
        "event_kind": (
            rows[:, met.KIND].astype(np.int8),
            {"long_name": "kind of event"} | flags(EVENTS),
        ),
        "event_approach_speed": (
            met.approach_speeds(model, rows),
            {"units": units("m s-1", linkage), "long_name": "rate of the gap at the event"},
        ),
    }
    order = np.argsort(times)
    return {name: ("event", values[order], attributes) for name, (values, attributes) in told.items()}
