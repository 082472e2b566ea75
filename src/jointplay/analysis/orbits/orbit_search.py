"""Search for a periodic orbit: follow a transient, take the nearest recurrence, move the section, solve.

A section on or near an event is moved on to the middle of the longest stretch without events: there the map
is smooth, and no jump at a wall falls on the section.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from jointplay.analysis.orbits.orbit_events import free_phase
from jointplay.analysis.orbits.section_map import Image, SectionMap
from jointplay.analysis.orbits.shooting import ITERATIONS, TOLERANCE, Orbit, newton

RECENT = 60  # last turns of the transient, among whose ends the nearest recurrences are taken
TRIES = 8  # recurrences from which Newton's method starts, the nearest first
ASIDE = 0.2  # of a turn, by which the section is moved after a failure
NEAR = 0.02  # of a turn: an event so near the section moves it
SAME = 100.0  # residuals up to which two states are the same


@dataclass(frozen=True)
class Search:
    """Turns of the transient, and tolerance and iterations of Newton's method."""

    transient: int = 100
    tolerance: float = TOLERANCE
    iterations: int = ITERATIONS


def search(section: SectionMap, settings: Search, progress: Callable[[float], None] | None = None) -> Orbit:
    """Find a periodic orbit from the start of the section's model; `progress` is that of the transient."""
    states, status = settled(section, settings.transient, progress or (lambda done: None))
    orbit = lost(section, status)
    for state in states if not status else ():
        orbit = solved(section, state, settings)
        if not orbit.status:
            return shortest(orbit, settings)
    return orbit


def solved(section: SectionMap, state: np.ndarray, settings: Search) -> Orbit:
    """Newton's method from a state, on a section away from events, then on another one."""
    how = {"tolerance": settings.tolerance, "iterations": settings.iterations}
    orbit = nearby(section, state, **how)
    if not orbit.status or section.plane:
        return orbit
    # the periodic orbit may have an event at the section where this motion has none
    other, image = section.moved(state, math.tau * ASIDE)
    return orbit if image.status else newton(other, image.state, **how)


def nearby(section: SectionMap, state: np.ndarray, **how: Any) -> Orbit:
    """Newton's method from a state, on a section away from events; `how` as in `newton`."""
    image = section.image(state, False)
    if not image.status:
        section, image = away_from_events(section, state, image)
    return lost(section, image.status) if image.status else newton(section, image.state, **how)


def lost(section: SectionMap, status: int) -> Orbit:
    """Orbit of a search that failed: its status, and NaN."""
    state = np.full_like(section.model.state, np.nan)
    return Orbit(status, section, state, Image(status, state), math.nan, 0)


def settled(
    section: SectionMap, transient: int, progress: Callable[[float], None]
) -> tuple[list[np.ndarray], int]:
    """States on the section in the last turns of a transient, the nearest to their own return first."""
    state, status = on_section(section)
    recent = min(transient, RECENT)
    if not status and transient > recent:
        state, status = _turns(section, state, transient - recent)
    states = [state]
    while not status and len(states) <= recent:
        state, status = _turns(section, state, 1)
        states.append(state)
        progress((transient - recent + len(states)) / (transient + 1))
    if status or len(states) <= section.turns:
        return [state], status
    pairs = list(zip(states, states[section.turns :], strict=False))
    distances = [np.linalg.norm(section.differ(late, early)) for early, late in pairs]
    return [pairs[i][1] for i in np.argsort(distances, kind="stable")[:TRIES]], 0


def _turns(section: SectionMap, state: np.ndarray, turns: int) -> tuple[np.ndarray, int]:
    image = section.image(state, False, turns)
    return image.state, image.status


def on_section(section: SectionMap) -> tuple[np.ndarray, int]:
    """State at the first passage of the section, which may be the model's start; status."""
    model = section.model
    if section.plane:
        if model.state[section.place] == section.phase:
            return model.state, 0
        return _turns(section, model.state, 1)
    first, state = replace(section, phase=model.crank_angle).within_a_turn(model.state)
    ahead = (section.phase - first.phase) * section.direction % math.tau
    if not ahead:
        return state, 0
    image = first.moved(state, ahead)[1]
    return image.state, image.status


def away_from_events(section: SectionMap, state: np.ndarray, image: Image) -> tuple[SectionMap, Image]:
    """The section and a state on it, both moved on if the motion has an event near the section."""
    ahead = shift_from_events(section, image.events)
    return section.moved(state, ahead) if ahead else (section, replace(image, state=state))


def shift_from_events(section: SectionMap, events: np.ndarray) -> float:
    """Angle to the middle of the longest stretch without events, rad; 0 if no event is near the section."""
    middle, nearest = free_phase(events, section.turns)
    return 0.0 if section.plane or nearest >= NEAR else math.tau * middle


def shortest(orbit: Orbit, settings: Search) -> Orbit:
    """The same orbit over the least number of turns in which it closes."""
    turns, limit = orbit.map.turns, SAME * max(orbit.residual, settings.tolerance * 1e-2)
    for fewer in range(1, turns):
        if turns % fewer == 0:
            image = orbit.map.image(orbit.state, False, fewer)
            if not image.status and np.max(np.abs(orbit.map.differ(image.state, orbit.state))) < limit:
                section = replace(orbit.map, turns=fewer)
                return newton(section, orbit.state, settings.tolerance, settings.iterations)
    return orbit


def at_phase(orbit: Orbit, phase: float) -> tuple[np.ndarray, float]:
    """State of an orbit (or of a failed search) on the wanted section, and the time to get there, s."""
    ahead = (phase - orbit.map.phase) * orbit.map.direction % math.tau
    if orbit.map.plane or orbit.image.status or not ahead:
        return orbit.state, 0.0
    image = orbit.map.moved(orbit.state, ahead)[1]
    return image.state, image.time
