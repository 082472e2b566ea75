"""Pseudo-arclength continuation of fixed points of a section map, in one parameter or in two.

Unknowns z = (x/c, q): the section's coordinates in units of their scales over a constant c, and the
parameters as fractions of their ranges. From a point with unit tangent t the next one solves

    Phi(x, q) - x = 0,   t . (z - z0) = s,   and with two parameters   g(x, q) = 0

by Newton's method from z0 + s t (Keller 1977); g is the condition of a curve (curves.tracing). c is such
that at the start a step is divided evenly between orbit and parameters. Derivatives of the map, in the state
and in parameters, are exact through every event (map_derivative). A section with an event near it is moved on
(orbit_search).
References: Allgower and Georg, Introduction to Numerical Continuation Methods (2003), chapters 2, 6 and 7.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from jointplay.analysis.orbits.family import Family, Point, Trial
from jointplay.analysis.orbits.shooting import Orbit
from jointplay.display.errors import InputError
from jointplay.solver.mechanism.directions import Directions

CORRECTIONS = 8  # at most
PATIENCE = 3  # corrections after which the residual must shrink
GAIN = 0.3  # factor by which a correction below the tolerance must reduce the residual
ROUNDING = 1e-14
SHORT = 0.1  # share of a condition that the first correction leaves on the side where it has a meaning
BACK = (0.1, 0.5, 0.75, 0.9, 0.99, 0.999)  # shares of a correction that ends beyond a curve
AWAY = (1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1)  # distances off a curve, by its condition, from a guess beyond it
KEPT = 1e-9  # singular values below it, relative to the largest, are not divided by


def solve(family: Family, like: Point, guess: np.ndarray, normal: np.ndarray) -> Point | None:
    """Point of the branch on the plane through `guess` with this normal; None if Newton's method fails.

    Parameters
    ----------
    family : Family
        Of maps.
    like : Point
        Point whose section, turns and unit are used.
    guess, normal : ndarray
        Scaled, as `Point.z`.
    """
    try:
        return _newton(family, like, guess, normal)
    except InputError:  # far beyond its range a parameter may have no meaning
        return None


def _newton(family: Family, like: Point, guess: np.ndarray, normal: np.ndarray) -> Point | None:
    z, size, count, last = np.array(guess), np.inf, 0, None
    sided = family.condition is not None and family.condition.sided
    A = _known(like) if sided else None
    while count <= CORRECTIONS:
        here = family.trial(z, like)
        if sided and not np.isfinite(here.size(like.unit)):
            here = _drawn_back(family, like, z, last.z if last else None)
        z = here.z
        before, size = size, here.size(like.unit)
        if not np.isfinite(size) or (count > PATIENCE and size > max(before, family.tolerance)):
            return None
        done = size < ROUNDING or (
            size <= family.tolerance and (size > GAIN * before or count == CORRECTIONS)
        )
        directions = like.directions  # good enough for corrections
        if done or directions is None:
            directions = family.directions(family.place(z), like.orbit.map)
        free = len(here.section.free)
        if done or A is None:  # between these, the other derivatives are accurate enough
            A = jacobian(family, like, here, directions)
        elif last is not None and family.condition is not None:  # Broyden's update
            by = z - last.z
            A[free] += (here.r[free] - last.r[free] - A[free] @ by) * by / (by @ by)
        A[:free, :free] = here.image.derivative - np.eye(free)
        if done:
            orbit = Orbit(0, here.section, here.state, here.image, size, count)
            return Point(orbit, family.place(z), like.unit, _tangent(A, normal), count, A, directions)
        if not np.all(np.isfinite(A)):
            return None
        rows = np.vstack([A, normal])
        left = np.append(-here.r, normal @ (guess - z))
        count, last = count + 1, here
        if sided and here.r[free] > 0:
            left[free] *= 1 - SHORT**count
        z = z + np.linalg.lstsq(rows, left, rcond=KEPT)[0]
    return None


def _known(like: Point) -> np.ndarray | None:
    """The derivatives at a point of a curve, if it has them: for corrections nearby."""
    known = like.directions is not None and np.all(np.isfinite(like.jacobian))
    return like.jacobian.copy() if known else None


def _drawn_back(family: Family, like: Point, z: np.ndarray, last: np.ndarray | None) -> Trial:
    """A trial on that side of a curve where its condition has a meaning, if one is found.

    From unknowns z beyond it towards the last ones, or off the curve by its normal at the point `like`.
    """
    if last is not None:
        others = [z + share * (last - z) for share in BACK]
    elif like.jacobian is not None:
        inward = like.jacobian[-1]
        others = [z + distance * inward / (inward @ inward) for distance in AWAY]
    else:
        others = []
    trial = family.trial(z, like)
    for other in others:
        if np.isfinite(trial.size(like.unit)):
            break
        trial = family.trial(other, like)
    return trial


def jacobian(family: Family, like: Point, trial: Trial, directions: Directions) -> np.ndarray:
    """Derivatives of the residual with respect to the unknowns; NaN where they could not be had."""
    free = len(trial.section.free)
    image = trial.section.image(trial.state, directions=directions)
    if image.status:
        return np.full((len(trial.r), free + family.count), np.nan)
    A = family.slopes(image)
    A[:, :free] -= np.eye(free)
    A[:, free:] /= like.unit
    if family.condition is None:
        return A
    image = replace(image, events=trial.image.events)  # beside a grazing this run may differ by rounding
    row = family.condition.gradient(family, replace(trial, image=image, directions=directions), like)
    return np.vstack([A, row])


def _tangent(A: np.ndarray, along: np.ndarray) -> np.ndarray:
    """Unit null vector of A, with the sense of `along`; `along` itself where A is not finite."""
    if not np.all(np.isfinite(A)):
        return along / np.linalg.norm(along)
    null = np.linalg.svd(A)[2][-1]
    return null if null @ along >= 0 else -null


def first(family: Family, orbit: Orbit, q: Any, sense: Any = 1.0) -> Point:
    """Point of a branch at an orbit, with the constant that divides steps evenly.

    `sense`: in which the parameters change along it, as many numbers.
    """
    point = Point(orbit, q, 1.0, np.append(np.zeros(len(orbit.map.free)), sense))
    directions = family.directions(q, orbit.map)
    A = jacobian(family, point, family.trial(point.z, point), directions)
    if not np.all(np.isfinite(A)):
        return point
    along = _tangent(A, point.tangent)
    size = np.linalg.norm(along[: -family.count])
    of_parameters = max(np.linalg.norm(along[-family.count :]), 1e-12)
    unit = float(np.clip(size / of_parameters, 1e-6, 1e6)) if size > 0 else 1.0
    tangent = np.append(along[: -family.count] / unit, along[-family.count :])
    free = len(along) - family.count
    A[:free, free:] /= unit
    A[free:, :free] *= unit
    return Point(orbit, q, unit, tangent / np.linalg.norm(tangent), 0, A, directions)
