"""How hard a linkage with clearance is worked, in four grades.

quiet      contact is never lost
touches    it is lost, and begins again at less than `GENTLE` m/s, and forces stay below `LIGHT` times ideal
           ones
rattles    it is lost, and neither of the others holds
hammers    it hits at `HARD` m/s or more, or a force is `HEAVY` times that of ideal joints or more

They are conventions, by the largest speed with which contact begins, and by the largest ratio of a joint's
largest force to that of the same linkage with ideal joints.
"""

from __future__ import annotations

import math

import numpy as np

GRADES = ("quiet", "touches", "rattles", "hammers")
UNKNOWN = "unknown"
GENTLE, HARD = 0.01, 0.1  # m/s
LIGHT, HEAVY = 1.5, 3.0
MEANING = {
    "quiet": "contact is never lost",
    "touches": f"contact is lost, at less than {1e3 * GENTLE:g} mm/s and {LIGHT:g} times the ideal forces",
    "rattles": "contact is lost, and harder than that",
    "hammers": f"contact is lost, at {1e3 * HARD:g} mm/s and more, or with {HEAVY:g} times the ideal forces",
}


def grade(lost: bool, ratio: float, speed: float) -> int:
    """Index into `GRADES`.

    Parameters
    ----------
    lost : bool
        Whether contact is lost in any joint.
    ratio : float
        Largest force of a joint over that of the same joint in the ideal linkage, the largest of all joints.
    speed : float
        Largest speed with which contact begins, m/s.
    """
    if not lost:
        return 0
    if speed >= HARD or ratio >= HEAVY:
        return 3
    return 1 if speed < GENTLE and ratio < LIGHT else 2


def largest(numbers: np.ndarray) -> float:
    """The largest of the numbers that are known; NaN where none is."""
    return float(np.nanmax(numbers)) if np.isfinite(numbers).any() else math.nan
