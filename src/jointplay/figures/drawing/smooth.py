"""Paths drawn smoothly between samples: modified Akima splines over time, which do not overshoot at kinks.

A contact vibrates many times a turn. At ten samples an oscillation straight lines miss the path by 5 % of the
amplitude, the splines by 1 %; samples themselves are not moved. SciPy has the same splines, but its module of
interpolation takes longer to import than a picture to draw.
Source: Akima, Journal of the ACM 17 (1970); the weights are those of his method's modified form.
"""

from collections.abc import Callable

import numpy as np

from jointplay.figures.drawing import hermite

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
    curve = hermite.cubic(points[intervals], np.diff(points, axis=0)[intervals], *ends, shares)
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
    """Return slopes at points, shape (samples, 2): means of those beside, the steadier side weighing more."""
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
