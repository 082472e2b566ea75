"""Speeds of approach that laws of contact remember, of a mechanism that starts."""

from __future__ import annotations

import math

import numpy as np

from jointplay.equations.laws import LAWS
from jointplay.mechanism.kinematic_chains import Angles, Forest, place_of
from jointplay.mechanism.records import Mechanism


def approaches(
    mechanism: Mechanism,
    forest: Forest,
    turning: tuple[Angles, Angles],
    state: tuple[np.ndarray, np.ndarray],
) -> np.ndarray:
    """Give what each law that remembers has for the speed with which a contact began, at the start.

    A joint that starts in contact has no beginning to remember: it counts as begun with the size of the
    normal speed that it has there, or with the smallest speed of its law, whichever is larger; one that
    starts in flight has the smallest speed.

    Parameters
    ----------
    mechanism : Mechanism
        The linkage.
    forest : Forest
        The same, cut at its clearance joints.
    turning : tuple of mapping
        Angles and angular velocities by link, rad and rad/s.
    state : tuple of ndarray
        Positions and speeds in the equations' order, m and m/s where they are of floating chains.

    Returns
    -------
    ndarray, shape (laws that remember, 2)
        The speed, and the law's smallest one, m/s.
    """
    rows = []
    for joint in mechanism.clearance_joints:
        if LAWS[joint.contact.law].floor:
            slowest = joint.contact.coefficients[LAWS[joint.contact.law].floor]
            r, v = _relative(forest, joint, turning, state)
            distance = math.hypot(*r)
            touches = distance >= joint.clearance
            along = abs(r[0] * v[0] + r[1] * v[1]) / distance if touches else 0.0
            rows.append((max(along, slowest), slowest))
    return np.array(rows, dtype=float).reshape(-1, 2)


def _relative(forest: Forest, joint, turning, state) -> tuple[np.ndarray, np.ndarray]:
    """Position and velocity of the journal's centre relative to its bearing."""
    total = np.array(forest.separation(joint).motion(*turning))
    for pin, sign in ((joint.journal, 1), (joint.bearing, -1)):
        chain = place_of(forest.places, pin).chain
        if chain is not None:
            first = len(state[0]) - 2 * len(forest.floats) + 2 * chain
            total += sign * np.array([row[first : first + 2] for row in state])
    return total[0], total[1]
