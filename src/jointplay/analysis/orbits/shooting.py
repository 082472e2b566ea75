"""Newton's method for fixed points of a section map, and the search for its start.

    x <- x + s (I - P)^-1 (Phi(x) - x),    s = 1, 1/2, 1/4, … until the residual shrinks.

The residual is the largest component of Phi(x) - x in units of the states' scales. Below the tolerance the
iteration goes on as long as it gains, down to the accuracy of the run. Where I - P is singular the shortest
correction is taken. Reference: Parker and Chua (1989), chapter 5; Deuflhard, Newton Methods (2011).

Floquet multipliers of a periodic orbit, and its stability.

A multiplier mu is an eigenvalue of the section map's derivative P at its fixed point; the orbit is stable
where all |mu| < 1, and ln|mu|/T is an exponent of the flow.
Reference: Kuznetsov, Elements of Applied Bifurcation Theory (2004), chapters 5 and 10.

Search for a periodic orbit: follow a transient, take the nearest recurrence, move the section, solve.

A section on or near an event is moved on to the middle of the longest stretch without events: there the map
is smooth, and no jump at a wall falls on the section.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from jointplay.analysis.orbits.section_map import FAILED, Image, SectionMap, free_phase
from jointplay.display.number_text import counted

TOLERANCE = 1e-8  # of a residual, in units of the scales
ITERATIONS = 30
SHORTEST = 2.0**-10
# factor by which an iteration below the tolerance must reduce the residual to be followed by another
GAIN = 0.3
ROUNDING = 1e-14

RECENT = 60  # last turns of the transient, among whose ends the nearest recurrences are taken
TRIES = 8  # recurrences from which Newton's method starts, the nearest first
ASIDE = 0.2  # of a turn, by which the section is moved after a failure
NEAR = 0.02  # of a turn: an event so near the section moves it
SAME = 100.0  # residuals up to which two states are the same
TRY = "it may be chaotic or of another period; try other turns, a longer transient, another initial state"


@dataclass(frozen=True)
class Orbit:
    """A fixed point of a section map, or where the search for one ended.

    Parameters
    ----------
    status : int
        Index into `STATUS`.
    map : SectionMap
        Whose fixed point.
    state : ndarray
        On the section.
    image : Image
        Its image under the map.
    residual : float
        Largest difference of state and image, in units of the scales.
    iterations : int
        Steps taken.
    contraction : float
        Residual after the first step over that before it; NaN where that was not looked at.
    """

    status: int
    map: SectionMap
    state: np.ndarray
    image: Image
    residual: float
    iterations: int
    contraction: float = np.nan

    @property
    def trouble(self) -> dict[str, str]:
        """Why nothing was found, as an attribute of a result; none where a run failed: its status tells."""
        text = f"no periodic orbit of {counted(self.map.turns, 'turn')} was found near the motion; {TRY}"
        return {} if self.status != FAILED or self.image.status else {"trouble": text}


def residual(section: SectionMap, state: np.ndarray, image: Image) -> np.ndarray:
    """Difference Phi(x) - x in units of the scales; infinite where the run failed."""
    if image.status:
        return np.full(len(section.free), np.inf)
    return section.differ(image.state, state)


def newton(
    section: SectionMap,
    state: np.ndarray,
    tolerance: float = TOLERANCE,
    iterations: int = ITERATIONS,
    enough: float = ROUNDING,
    shortest: float = SHORTEST,
    unseen: float = 0.0,
) -> Orbit:
    """Find the fixed point near a state on the section; status ``not_converged`` if there is none.

    A residual that is `enough` is made no smaller; a part of a step is no smaller than the `shortest`. The
    step from a residual below `unseen` is the last: the image and its residual are those before it.
    """
    image = section.image(state)
    r = residual(section, state, image)
    size, count, contraction = np.max(np.abs(r)), 0, np.nan
    while count < iterations and np.isfinite(size) and size > enough:
        P = image.derivative
        step = np.linalg.lstsq(np.eye(len(P)) - P, r, rcond=None)[0]
        if size < unseen:
            state = section.state(section.unknowns(state) + step)
            return Orbit(0, section, state, image, float(size), count + 1, float(contraction))
        trial = _damped(section, state, step, size, shortest)
        count += 1
        if trial is None:
            break
        before, (state, image, r) = size, trial
        size = np.max(np.abs(r))
        contraction = size / before if count == 1 else contraction
        if size <= tolerance and size / before > GAIN:
            break
    status = image.status or (0 if size <= tolerance else FAILED)
    return Orbit(status, section, state, image, float(size), count, float(contraction))


def _damped(section: SectionMap, state: np.ndarray, step: np.ndarray, size: float, shortest: float):
    """State, image and residual after the longest part of a step that reduces it; None if none does."""
    part = 1.0
    while part >= shortest:
        trial = section.state(section.unknowns(state) + part * step)
        image = section.image(trial)
        r = residual(section, trial, image)
        if np.max(np.abs(r)) < (1 - 0.25 * part) * size:
            return trial, image, r
        part /= 2
    return None


def multipliers(derivative: np.ndarray) -> np.ndarray:
    """Eigenvalues of a section map's derivative, the largest first, of a pair the upper one."""
    values = np.linalg.eigvals(derivative).astype(complex)
    return values[descending(values)]


def descending(values: np.ndarray) -> np.ndarray:
    """Order of multipliers: the largest first, of a pair the upper one."""
    return np.lexsort((-values.imag, -np.round(np.abs(values), 12)))


def exponents(multipliers: np.ndarray, period: float) -> np.ndarray:
    """Lyapunov exponents ln|mu|/T of an orbit, 1/s; minus infinity where a multiplier is 0."""
    with np.errstate(divide="ignore"):
        return np.log(np.abs(multipliers)) / period


def stable(multipliers: np.ndarray) -> bool:
    """Whether every multiplier lies within the unit circle."""
    return bool(np.all(np.abs(multipliers) < 1))


def critical(multipliers: np.ndarray, kind: str) -> complex:
    """The critical multiplier of a bifurcation: nearest to +1, to -1, or to the unit circle off the axis."""
    if kind == "neimark_sacker":
        pairs = multipliers[multipliers.imag > 0]
        return complex(pairs[np.argmin(np.abs(np.abs(pairs) - 1))]) if len(pairs) else complex(np.nan)
    return complex(multipliers[np.argmin(np.abs(multipliers - (-1 if kind == "period_doubling" else 1)))])


def direction(derivative: np.ndarray, value: float) -> np.ndarray:
    """Unit eigenvector of the derivative to a real eigenvalue, given at least roughly."""
    return np.linalg.svd(derivative - value * np.eye(len(derivative)))[2][-1]


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
    fewer = sooner(orbit, SAME * max(orbit.residual, settings.tolerance * 1e-2))
    if not fewer:
        return orbit
    return newton(replace(orbit.map, turns=fewer), orbit.state, settings.tolerance, settings.iterations)


def sooner(orbit: Orbit, limit: float) -> int:
    """Least number of turns, a part of its own, after which an orbit closes to a limit; 0 if none."""
    turns = orbit.map.turns
    for fewer in (n for n in range(1, turns // 2 + 1) if turns % n == 0):
        image = orbit.map.image(orbit.state, False, fewer)
        if not image.status and np.max(np.abs(orbit.map.differ(image.state, orbit.state))) < limit:
            return fewer
    return 0


def at_phase(orbit: Orbit, phase: float) -> tuple[np.ndarray, float]:
    """State of an orbit (or of a failed search) on the wanted section, and the time to get there, s."""
    ahead = (phase - orbit.map.phase) * orbit.map.direction % math.tau
    if orbit.map.plane or orbit.image.status or not ahead:
        return orbit.state, 0.0
    image = orbit.map.moved(orbit.state, ahead)[1]
    return image.state, image.time
