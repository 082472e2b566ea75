"""Curves over time with their extremes between samples; a vibration of few samples a cycle is its envelope.

Straight lines between a few samples a cycle are polygons that beat with the vibration (moiré), and miss its
peaks. Where its lowest and highest values between samples were recorded, they join the samples.
"""

from __future__ import annotations

import numpy as np

from jointplay.figures.drawing import Axes, artists, style

RUN, BENDS = 65, 16  # samples in a row, and turning points among them from which they are too few
SWING = 0.02  # of a curve's whole height: less than this is no turning point
REACH = 4  # samples to either side of which an envelope has the extremes: a cycle
SEEN = 0.5  # mm on the paper between samples, from which the course of a cycle is missed
NO_PEAKS = "sampled too coarsely: peaks between samples are missing"
BAND = "vibration,\nlowest to\nhighest"  # of what an envelope shows of the one curve of a panel
NO_CYCLES = "sampled too coarsely to show single cycles"


def course(
    ax: Axes, x: np.ndarray, y: np.ndarray, between: tuple[np.ndarray, np.ndarray] | None = None, **look
) -> str:
    """Draw y over x, with its lowest and highest values `between` a sample and the one before, if recorded.

    Returns what the picture misses, in words; empty where that is nothing.
    """
    low, high = (np.r_[y[:1], each[1:]] for each in between or (y, y))  # the first is of time not shown
    places, xs, ys = joined(x, y, low, high)
    few = sparse(np.bincount(places[turning(ys)], minlength=y.size))
    if not few.any():
        artists.curve(ax, xs, ys, **look)
        return ""
    line = artists.curve(ax, xs, np.where((few & ~artists.neighbours(~few))[places], np.nan, ys), **look)
    colour = line.get_color()
    low, high = -widest(-np.fmin(y, low)), widest(np.fmax(y, high))
    name = str(look.get("label", "_"))
    label = BAND if name.startswith("_") else f"{name}: lowest\nto highest"
    look = {"facecolor": colour, "alpha": 0.3, "linewidth": 0.0, "label": label}
    ax.fill_between(x, low, high, where=few, **look)
    for edge in (low, high):
        artists.curve(ax, x, np.where(few, edge, np.nan), color=colour, linestyle="-", linewidth=0.4)
    if between is None:
        return NO_PEAKS
    apart = ax.bbox.width / ax.figure.dpi / style.MILLIMETRE * np.diff(x[few][:2]) / np.ptp(x)
    return NO_CYCLES if apart.size and apart[0] > SEEN else ""


def sparse(bends: np.ndarray) -> np.ndarray:
    """Return which samples are too few for the curve's turning points around them, in long runs only."""
    if bends.size < RUN:
        return np.zeros(bends.size, dtype=bool)
    few = np.convolve(bends, np.ones(RUN), "same") >= BENDS
    edges = np.flatnonzero(np.diff(np.r_[False, few, False]))
    gaps = np.flatnonzero(np.diff(edges)[1::2] < RUN)
    runs = np.delete(edges, np.r_[2 * gaps + 1, 2 * gaps + 2]).reshape(-1, 2)
    marks = np.zeros(bends.size + 1, dtype=int)
    for first, end in runs[np.diff(runs)[:, 0] >= RUN]:
        marks[[first, end]] += 1, -1
    return np.cumsum(marks)[:-1] > 0


def joined(
    x: np.ndarray, y: np.ndarray, low: np.ndarray, high: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return a curve through samples and, in the middle before one, what lies beyond it and the one before.

    With it goes the sample to which each point belongs.
    """
    before = np.r_[y[:1], y[:-1]]
    beyond = np.stack([low < np.fmin(y, before), high > np.fmax(y, before)], -1)
    values = np.stack([low, high], -1)
    falls = before > y  # what is nearer to the sample before comes first
    beyond[falls], values[falls] = beyond[falls, ::-1], values[falls, ::-1]
    at = np.nonzero(beyond)[0]
    between = np.insert(x, at, (x[at] + x[at - 1]) / 2)
    return np.insert(np.arange(y.size), at, at), between, np.insert(y, at, values[beyond])


def turning(y: np.ndarray) -> np.ndarray:
    """Return the points between which a curve rises and falls by more than a small part of its height."""
    change = np.diff(y)
    bends = np.flatnonzero(change[1:] * change[:-1] < 0) + 1
    swings = np.abs(np.diff(y[bends], prepend=np.nan, append=np.nan))
    least = SWING * np.ptp(y[np.isfinite(y)]) if np.isfinite(y).any() else 0.0
    return bends[np.fmin(swings[1:], swings[:-1]) > least]


def widest(high: np.ndarray) -> np.ndarray:
    """Return the samples with all valleys filled that are narrower than twice the reach (closing)."""
    return -greatest(-greatest(high))


def greatest(high: np.ndarray) -> np.ndarray:
    """Return the greatest of the samples within reach."""
    padded = np.pad(high, REACH, constant_values=np.nan)
    return np.fmax.reduce(np.lib.stride_tricks.sliding_window_view(padded, 2 * REACH + 1), axis=-1)
