"""Curves drawn through points with their tangents: cubics between neighbours, which meet smoothly."""

import numpy as np

BETWEEN = 8  # pieces of an interval


def through(points: np.ndarray, tangents: np.ndarray, straight: np.ndarray | bool = False) -> np.ndarray:
    """Return a denser path through points, shape (points, 2), with tangents along any smooth parameter.

    The parameter's steps are those that fit the chords best: a parabola is met exactly. Where a tangent
    points away from the neighbour, as at a cusp, or is none, the chord takes its place, as it does at both
    ends of pieces that are `straight`.
    """
    if len(points) < 2:
        return points
    chords, means = np.diff(points, axis=0), (tangents[:-1] + tangents[1:]) / 2
    size = np.sum(means**2, axis=1, keepdims=True)
    steps = np.sum(chords * means, axis=1, keepdims=True) / np.where(size > 0, size, np.inf)
    steps = np.where(np.reshape(straight, (-1, 1)), np.nan, steps)
    begin, end = (_forward(steps * each, chords) for each in (tangents[:-1], tangents[1:]))
    path = cubic(points[:-1], chords, begin, end, np.arange(BETWEEN) / BETWEEN)
    return np.concatenate([path, points[-1:]])


def cubic(
    points: np.ndarray, chords: np.ndarray, begin: np.ndarray, end: np.ndarray, shares: np.ndarray
) -> np.ndarray:
    """Return points at shares of intervals, given where each begins, its chord and its tangents by share."""
    t = shares[None, :, None]
    path = points[:, None] + t * chords[:, None]
    path = path + t * (1 - t) * ((1 - t) * (begin - chords)[:, None] + t * (chords - end)[:, None])
    return path.reshape(-1, 2)


def _forward(tangents: np.ndarray, chords: np.ndarray) -> np.ndarray:
    """Return tangents, or chords where they point away or are far longer."""
    along, size = np.sum(tangents * chords, axis=1, keepdims=True), np.sum(chords**2, axis=1, keepdims=True)
    fits = (along > 0) & (np.sum(tangents**2, axis=1, keepdims=True) < 9 * size)
    return np.where(fits, tangents, chords)
