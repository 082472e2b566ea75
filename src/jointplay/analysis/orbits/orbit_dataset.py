"""Variables of periodic orbits: state, numbers, events and history.

Types of the keywords of periodic orbits and their branches, and rules that keywords must fit.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Annotated, Any

import numpy as np
from pydantic import AfterValidator, BeforeValidator

from jointplay.analysis.contacts import begun
from jointplay.analysis.evaluate import RUN
from jointplay.analysis.keywords import Small, as_list
from jointplay.analysis.labels import Out
from jointplay.analysis.orbits import section_map, shooting
from jointplay.analysis.orbits.section_map import CONTACT, KIND, PLACE, TIME, SectionMap
from jointplay.analysis.orbits.shooting import Orbit
from jointplay.analysis.quantities import STATUS, recorded
from jointplay.analysis.rules import assembled_at, each_alike, turns_alike
from jointplay.analysis.starts import crank_place, placed, state_names
from jointplay.analysis.states.ends import Observation
from jointplay.analysis.vary import axes
from jointplay.display.errors import NOTHING, InputError, Problem, refuse, unknown, warn
from jointplay.solver.codegen import cache
from jointplay.solver.mechanism.base import Number, accepts, is_number, unit
from jointplay.solver.mechanism.model import Model
from jointplay.solver.mechanism.parameters import Parameter
from jointplay.solver.mechanism.records import CrankAngle, Mechanism, Plane, TestSystem

SAMPLES = 720  # a turn, for histories and closest approaches
PARTS = ("real", "imaginary")
STABILITY = ("unstable", "stable", "unknown", "neutral")
NEUTRAL = 1e-6  # from the unit circle: a largest multiplier that its error may put on either side
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

Tolerance = Annotated[Small, unit("tolerance of the residual", "1")]


def history(
    section: SectionMap, state: np.ndarray, duration: float, per_turn: int = SAMPLES, sharp: bool = False
) -> np.ndarray:
    """Rows of time, state, modes over an orbit in even steps; the last repeats the first (0: none).

    `sharp`: states whose accelerations are resolved (analysis.evaluate).
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
    multipliers = shooting.multipliers(image.derivative)
    gaps, _ = section_map.gaps(section.model, history(section, orbit.state, image.time)[:-1])
    return {
        "period": float(section.turns),
        "period_time": image.time,
        "residual": orbit.residual,
        "impacts": len(begun(section.model, image.events)) / section.turns,
        "smallest_impact_speed": section_map.smallest_impact_speed(section.model, image.events),
        "closest_approach": section_map.closest_approach(gaps, image.events),
        "grazing": image.grazing if len(image.events) else math.nan,
        "floquet_multiplier": np.stack([multipliers.real, multipliers.imag], -1),
        "lyapunov_exponent": shooting.exponents(multipliers, image.time),
        "stable": stability(multipliers),
    }


def stability(multipliers: np.ndarray) -> int:
    """Index into `STABILITY`."""
    near = abs(np.abs(multipliers).max(initial=0.0) - 1) < NEUTRAL
    return STABILITY.index("neutral") if near else int(shooting.stable(multipliers))


def largest_multiplier(base: Model, period: int, state: np.ndarray, how: Observation) -> float:
    """Of the periodic orbit through a state at the section of a model, in modulus; NaN where it has none."""
    if not period:
        return math.nan
    place = crank_place(base) if base.structure.section is not None else None
    limits = {"rtol": how.rtol, "max_steps": how.max_steps}
    image = SectionMap(base, period, base.crank_angle, place, base.forward, **limits).image(state)
    return math.nan if image.status else np.abs(np.linalg.eigvals(image.derivative)).max(initial=0.0)


def told_neutral(multipliers: Sequence[float]) -> dict[str, str]:
    """Warn of motions whose largest multipliers lie on the unit circle; the text as an attribute."""
    count = int(np.sum(np.abs(np.array(multipliers) - 1) < NEUTRAL))
    text = "motions are neutral, as without damping: starts beside one neither come to it nor leave it"
    return warn(f"{count} of {len(multipliers)} {text}") if count else {}


def missing_numbers(size: int) -> dict[str, Any]:
    """The numbers of an orbit that was not found."""
    sizes = {"multiplier": size, "part": len(PARTS)}
    known = {name: out for name, out in OUTS.items() if name != "orbit_state"}
    return {name: out.none(tuple(sizes[dim] for dim in out.axes))[()] for name, out in known.items()}


def coordinates(section: SectionMap) -> dict[str, Any]:
    """Values of `COORDS`."""
    names = np.array(state_names(section.model), dtype=str)
    return {"multiplier": np.arange(1, len(section.free) + 1), "part": np.array(PARTS), "state": names}


def settings(model: Model) -> dict[str, Any]:
    """Data of the mechanism that figures of an orbit need."""
    period = {"turn_period_nominal": model.period}
    return period | ({"clearance": np.asarray(model.clearances)} if model.clearances else {})


def events(orbit: Orbit, lead: float) -> dict[str, Any]:
    """The orbit's events in turn, timed from the user's section, `lead` s after that of its map."""
    rows, duration = orbit.image.events, orbit.image.time
    if rows is None:
        rows, duration = np.zeros((0, TIME + 1)), 1.0
    times = np.mod(rows[:, PLACE] * duration - lead, duration)
    order = np.argsort(times)
    return {
        "event_time": times[order],
        "event_joint": rows[order, CONTACT].astype(np.int16),
        "event_approach_speed": section_map.approach_speeds(orbit.map.model, rows)[order],
        "event_kind": rows[order, KIND],
    }


def _rising(ends: tuple[float, float]) -> tuple[float, float]:
    if not ends[0] < ends[1]:
        raise refuse(ends, "two numbers, the lower first, are accepted")
    return ends


Range = Annotated[
    tuple[Number, Number], BeforeValidator(as_list), AfterValidator(_rising), accepts("a list of two numbers")
]


def started(mechanism: Mechanism | TestSystem, initial: Any) -> Model:
    """The model that an analysis shares with its rules: the mechanism at a start, or at a whole state."""
    return assembled_at(mechanism, initial, assembled=placed)


def record_fits(mechanism: Mechanism | TestSystem, record: tuple[str, ...] | None) -> None:
    """Refuse quantities that the mechanism does not have, and integrals over time."""
    recorded(record, mechanism, integrals=False)


def section_fits(mechanism: Mechanism | TestSystem, section: Any) -> Iterator[Problem]:
    """Yield the problems of a section for the search of an orbit."""
    if isinstance(section, Plane):
        if not isinstance(mechanism, TestSystem) or mechanism.period is not None:
            expected = "a crank angle (or phase of the forcing) is accepted here: kind = 'crank_angle'"
            yield Problem("section", section.kind, expected)
        elif section.quantity not in (names := sum(mechanism.order, ())):
            yield unknown("section.quantity", section.quantity, section.quantity, names, "state")
    elif not isinstance(section, CrankAngle):
        expected = "a crank angle, or a plane of a state, is accepted"
        yield Problem("section", getattr(section, "kind", section), expected)
    elif isinstance(mechanism, TestSystem) and mechanism.period is None:
        expected = "a plane of a state is accepted for a system that nothing forces: kind = 'plane'"
        yield Problem("section", section.kind, expected)


def branch_fits(
    mechanism: Mechanism | TestSystem, parameter: str, range: Any, start: float | None
) -> Iterator[Problem]:
    """Yield the problems of a branch over a parameter and its range."""
    try:
        axes(mechanism, {parameter: list(range)}, "range")
    except InputError as error:
        yield from error.problems
        return
    own = Parameter(mechanism, parameter).value
    if isinstance(own, int):
        text = f"the range of what can change by little is accepted, and {parameter} is a whole number"
        yield Problem("range", range, text)
        return
    value = own if start is None else start
    if not is_number(value) or not range[0] <= value <= range[1]:
        given = NOTHING if value is None else value
        yield Problem("start", given, f"a number from {range[0]:g} to {range[1]:g} is needed")
    between = range[0] + 0.3183 * (range[1] - range[0])  # what holds at an odd place too holds everywhere
    yield from each_alike(mechanism, {parameter: (*range, between)})


ORBIT = (section_fits, record_fits, "model", turns_alike)
