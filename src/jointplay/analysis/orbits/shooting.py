"""Newton's method for fixed points of a section map.

    x <- x + s (I - P)^-1 (Phi(x) - x),    s = 1, 1/2, 1/4, … until the residual shrinks.

The residual is the largest component of Phi(x) - x in units of the states' scales. Below the tolerance the
iteration goes on as long as it gains, down to the accuracy of the run. Where I - P is singular the shortest
correction is taken. Reference: Parker and Chua (1989), chapter 5; Deuflhard, Newton Methods (2011).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from jointplay.analysis.orbits.section_map import FAILED, Image, SectionMap

TOLERANCE = 1e-8  # of a residual, in units of the scales
ITERATIONS = 30
SHORTEST = 2.0**-10
GAIN = (
    0.3  # factor by which an iteration below the tolerance must reduce the residual to be followed by another
)
ROUNDING = 1e-14


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
