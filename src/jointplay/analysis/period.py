"""Period of a motion, in turns, from its section points.

A motion of period p has its section points on p places: those whose numbers leave the same rest on division
by p lie together. They must lie within a tolerance over all turns recorded, not only from one turn to the
next: a slow drift is no period.
"""

import numpy as np

from jointplay.errors import InputError, Problem

REPEATS = 4  # a period is believed when the record holds it this often


def period(points: np.ndarray, tolerance: float, longest: int | None = None) -> int:
    """Smallest period of section points, in turns; 0 if there is none, or if a point is not finite.

    Parameters
    ----------
    points : ndarray, shape (turns,) or (turns, coordinates)
        Section points in turn, all coordinates in comparable units.
    tolerance : float
        Largest spread of points that count as one, in the points' units.
    longest : int, optional
        Longest period looked for; as many turns as the record holds four times if left out.

    Raises
    ------
    InputError
        If the tolerance is not greater than 0.
    """
    if not tolerance > 0:
        raise InputError([Problem("tolerance", tolerance, "a number greater than 0 is accepted")])
    points = np.asarray(points, dtype=float).reshape(len(points), -1)
    if not np.all(np.isfinite(points)):
        return 0
    most = len(points) // REPEATS
    for p in range(1, (most if longest is None else min(most, longest)) + 1):
        if all(np.ptp(points[rest::p], axis=0).max() <= tolerance for rest in range(p)):
            return p
    return 0
