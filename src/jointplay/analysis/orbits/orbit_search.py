"""From a start to a periodic orbit: follow, take the nearest recurrence, choose a quiet section, solve.

A section that lies on an event is moved on to the middle of the longest stretch without any: there the map
is smooth, and a wall's jump does not cut the orbit in two.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from jointplay.analysis.orbits.image import Image
from jointplay.analysis.orbits.orbit_events import free_phase
from jointplay.analysis.orbits.section_map import SectionMap
from jointplay.analysis.orbits.shooting import ITERATIONS, TOLERANCE, Orbit, newton

RECENT = 60  # turns among whose ends the nearest recurrences are looked for
TRIES = 8  # of these, from the nearest on
ASIDE = 0.2  # of a turn
NEAR = 0.02  # of a turn: an event so near the section moves it
ONE = 100.0  # how many residuals apart two states may be that are one


@dataclass(frozen=True)
class Search:
    """How an orbit is looked for: turns dropped, and Newton's tolerance and iterations."""

    transient: int = 100
    tolerance: float = TOLERANCE
    iterations: int = ITERATIONS


def search(section: SectionMap, how: Search, progress: Callable[[float], None] | None = None) -> Orbit:
    """Find a periodic orbit from where the section's model starts; `progress` is that of its transient."""
    states, status = settled(section, how.transient, progress or (lambda done: None))
    found = _lost(section, status)
    for state in states if not status else ():
        found = _from(section, state, how)
        if not found.status:
            return shortest(found, how)
    return found


def _from(section: SectionMap, state: np.ndarray, how: Search) -> Orbit:
    """Newton's method from a state, on a section that no event is near to, then on another one."""
    image = section.image(state, False)
    if image.status:
        return _lost(section, image.status)
    first, image = quiet(section, state, image)
    found = _lost(section, image.status)
    if not image.status:
        found = newton(first, image.state, how.tolerance, how.iterations)
    if not found.status or section.plane:
        return found
    # the orbit that is looked for may have an event at the section where this motion has none
    other, image = section.moved(state, math.tau * ASIDE)
    return found if image.status else newton(other, image.state, how.tolerance, how.iterations)


def _lost(section: SectionMap, status: int) -> Orbit:
    state = np.full_like(section.model.state, np.nan)
    return Orbit(status, section, state, Image(status, state), math.nan, 0)


def settled(
    section: SectionMap, transient: int, progress: Callable[[float], None] = lambda done: None
) -> tuple[list[np.ndarray], int]:
    """States on the section after some turns: of the last ones, those nearest to their own return first."""
    state, status = on_section(section)
    recent = min(transient, RECENT)
    if not status and transient > recent:
        state, status = _turns(section, state, transient - recent)
    found = [state]
    while not status and len(found) <= recent:
        state, status = _turns(section, state, 1)
        found.append(state)
        progress((transient - recent + len(found)) / (transient + 1))
    if status or len(found) <= section.turns:
        return [state], status
    pairs = list(zip(found, found[section.turns :], strict=False))
    away = [np.linalg.norm(section.differ(late, early)) for early, late in pairs]
    return [pairs[i][1] for i in np.argsort(away, kind="stable")[:TRIES]], 0


def _turns(section: SectionMap, state: np.ndarray, turns: int) -> tuple[np.ndarray, int]:
    image = section.image(state, False, turns)
    return image.state, image.status


def on_section(section: SectionMap) -> tuple[np.ndarray, int]:
    """Follow the model from its start to the section, unless it is there."""
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


def quiet(section: SectionMap, state: np.ndarray, image: Image) -> tuple[SectionMap, Image]:
    """The section and a state on it, both moved on if the orbit has an event near it."""
    where, near = free_phase(image.events, section.turns)
    if section.plane or near >= NEAR:
        return section, replace(image, state=state)
    return section.moved(state, math.tau * where)


def shortest(orbit: Orbit, how: Search) -> Orbit:
    """The same orbit over as few turns as it closes in."""
    turns, limit = orbit.map.turns, ONE * max(orbit.residual, how.tolerance * 1e-2)
    for fewer in range(1, turns):
        if turns % fewer == 0:
            image = orbit.map.image(orbit.state, False, fewer)
            if not image.status and np.max(np.abs(orbit.map.differ(image.state, orbit.state))) < limit:
                return newton(replace(orbit.map, turns=fewer), orbit.state, how.tolerance, how.iterations)
    return orbit


def at_phase(orbit: Orbit, phase: float) -> tuple[np.ndarray, float]:
    """State of an orbit (or of a failed search) on the section asked for, and the time to get there, s."""
    ahead = (phase - orbit.map.phase) * orbit.map.direction % math.tau
    if orbit.map.plane or orbit.image.status or not ahead:
        return orbit.state, 0.0
    image = orbit.map.moved(orbit.state, ahead)[1]
    return image.state, image.time
