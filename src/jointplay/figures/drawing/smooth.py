"""Paths drawn smoothly: through samples over time, and through points with tangents.

Between samples stand modified Akima splines, which do not overshoot at kinks. A contact vibrates many times a
turn. At ten samples an oscillation straight lines miss the path by 5 % of the amplitude, the splines by 1 %;
samples themselves are not moved. SciPy has the same splines, but its module of interpolation takes longer to
import than a picture to draw. Source: Akima, Journal of the ACM 17 (1970); the weights are those of his
method's modified form. Between points with tangents stand cubics, which meet smoothly.
"""

from collections.abc import Callable

import numpy as np

BETWEEN = 8  # pieces of an interval in which the path bends
BENT = np.deg2rad(4.0)  # between neighbouring lines, in a square panel that the path fills
FLAT = 1e-9  # of the largest weight: below it all lines around a point are level
MOST = 20_000  # samples; a longer path is dense enough


def smooth(
    times: np.ndarray, x: np.ndarray, y: np.ndarray, contact: np.ndarray, touches: Callable | None = None
) -> tuple[np.ndarray, ...]:
    """Return x, y and contact with further points where the path bends or contact begins or ends.

    Parameters
    ----------
    times, x, y : ndarray
        Samples; NaN where there is no value.
    contact : ndarray of bool
        Whether a sample is in contact.
    touches : callable, optional
        Of x and y: how far points are in contact, negative in flight. Between a sample in contact and one in
        flight it tells the points apart, and where contact begins or ends; without it none is in contact.
    """
    there = np.isfinite(x) & np.isfinite(y)
    rising = np.r_[True, np.diff(times) > 0]  # at an event there may be two samples
    if 4 <= x.size <= MOST and there.all() and rising.all():
        x, y, contact = denser(times, x, y, contact, touches)
    return (x, y, contact) if touches is None else edged(x, y, contact, touches(x, y))


def denser(
    times: np.ndarray, x: np.ndarray, y: np.ndarray, contact: np.ndarray, touches: Callable | None
) -> tuple[np.ndarray, ...]:
    """Return the path with points of the splines in between, as `smooth` does."""
    points = np.stack([x, y], -1)
    changing = contact[1:] != contact[:-1]
    intervals = np.flatnonzero(bends(points) | changing)
    slopes, lengths = akima(times, points), np.diff(times)[intervals, None]
    ends = (lengths * slopes[intervals], lengths * slopes[intervals + 1])
    shares = np.arange(1, BETWEEN) / BETWEEN
    curve = cubic(points[intervals], np.diff(points, axis=0)[intervals], *ends, shares)
    places = np.repeat(intervals + 1, BETWEEN - 1)
    both = np.repeat(contact[intervals] & contact[intervals + 1], BETWEEN - 1)
    if touches is not None:
        both = np.where(np.repeat(changing[intervals], BETWEEN - 1), touches(*curve.T) > 0, both)
    x, y = (np.insert(each, places, curve[:, column]) for column, each in enumerate((x, y)))
    return x, y, np.insert(contact, places, both)


def edged(x: np.ndarray, y: np.ndarray, contact: np.ndarray, level: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return the path with the points, in contact, at which it crosses from flight to contact or back."""
    before = np.flatnonzero((contact[1:] != contact[:-1]) & (level[1:] * level[:-1] < 0))
    shares = level[before] / (level[before] - level[before + 1])
    points = (each[before] + shares * (each[before + 1] - each[before]) for each in (x, y))
    x, y = (np.insert(each, before + 1, new) for each, new in zip((x, y), points, strict=True))
    return x, y, np.insert(contact, before + 1, True)


def akima(times: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return slopes at points, shape (samples, 2): means of both sides', the steadier side weighing more."""
    inner = np.diff(points, axis=0) / np.diff(times)[:, None]
    before, after = (2 * a - b for a, b in ((inner[0], inner[1]), (inner[-1], inner[-2])))
    lines = np.vstack([2 * before - inner[0], before, inner, after, 2 * after - inner[-1]])
    unsteady = np.abs(np.diff(lines, axis=0)) + np.abs(lines[1:] + lines[:-1]) / 2
    left, right = unsteady[2:], unsteady[:-2]  # weights of the lines on these sides
    whole = left + right
    flat = whole <= FLAT * whole.max()
    weighed = (left * lines[1:-2] + right * lines[2:-1]) / np.where(flat, 1.0, whole)
    return np.where(flat, (lines[:-3] + lines[3:]) / 2, weighed)


def bends(points: np.ndarray) -> np.ndarray:
    """Return between which samples a path bends visibly, of shape (samples - 1,)."""
    size = np.ptp(points, axis=0)
    steps = np.diff(points / np.where(size > 0, size, 1.0), axis=0)
    course = np.arctan2(steps[:, 1], steps[:, 0])
    sharp = np.abs((np.diff(course) + np.pi) % (2 * np.pi) - np.pi) > BENT
    return np.r_[sharp, False] | np.r_[False, sharp]


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
