"""Period of a motion, in turns, from its section points.

A motion of period p has its section points on p places: those whose numbers leave the same rest on division
by p lie together. They must lie within a tolerance over all turns recorded, not only from one turn to the
next: a slow drift is no period. The places must also stay apart: points that alternate about one place and
near it slowly lie within the tolerance on two, without a period yet.
"""

import numpy as np

from jointplay.display.errors import InputError, Problem

REPEATS = 4  # a period is believed when the record holds it this often
STEADY = 0.02  # share by which distances between places may change, whatever that would come to


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
            return 0 if any(_merging(points, p, q) for q in range(1, p) if p % q == 0) else p
    return 0


def _merging(points: np.ndarray, p: int, q: int) -> bool:
    """Whether the p places, q turns apart, come together or part, instead of keeping a distance.

    Over thirds of the record the distance goes from a to b to c. Where the changes shrink like a geometric
    series, it ends at c - (b - c)^2 / ((a - b) - (b - c)).
    """
    many = (len(points) - q) // (3 * p) * 3 * p  # so that each third holds every place equally often
    apart = np.sum((points[-many:] - points[-many - q : -q]) ** 2, axis=1).reshape(3, -1)
    distances = np.sqrt(np.mean(apart, axis=1))
    first, second = -np.diff(distances)
    if abs(first + second) <= STEADY * distances[0]:
        return False
    return abs(second) >= abs(first) or distances[2] - second**2 / (first - second) < distances[2] / 2
