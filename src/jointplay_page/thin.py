"""Thinning of what a page shows, and how it says so: curves keep extremes, clouds every so many points."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence

import numpy as np
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure

BUDGET = 200_000  # samples of all curves and clouds of a page
ROOM = 1_800_000  # bytes of all numbers of a page: in base64, with Bokeh, solver and picture, less than 5 MB
KEPT = 5  # samples of each stretch of a curve: the first, and those furthest left, right, down and up


def limit(sizes: Sequence[int], budget: int = BUDGET) -> int:
    """Return the number of samples from which a mark is thinned, so that all marks together fit a budget."""
    left, most = budget, 0
    for count, size in enumerate(sorted(sizes)):
        most = left // (len(sizes) - count)
        if size > most:
            return max(most, KEPT)
        left -= size
    return max(sizes, default=0)


def sizes(figures: Iterable[Figure]) -> list[int]:
    """Return the number of samples of each curve and cloud."""
    return [len(each.get_xdata()) for figure in figures for ax in figure.axes for each in ax.lines]


def room(figures: Collection[Figure]) -> int:
    """Return the bytes that a page has left beside its figures."""
    counts = sizes(figures)
    drawn = 8 * sum(min(count, limit(counts)) for count in counts)
    marks = (mark for figure in figures for ax in figure.axes for mark in ax.collections)
    return max(
        0, ROOM - drawn - 4 * sum(mark.get_array().size for mark in marks if isinstance(mark, QuadMesh))
    )


def kept_of_curve(x: np.ndarray, y: np.ndarray, most: int) -> np.ndarray:
    """Return which samples of a curve are kept: of each stretch the first and the extremes either way."""
    if x.size <= most:
        return np.arange(x.size)
    size = -(-x.size * KEPT // most)
    whole = x.size // size * size
    starts = np.arange(0, whole, size)
    blocks = [np.where(np.isfinite(v[:whole]), v[:whole], np.nan).reshape(-1, size) for v in (x, y)]
    found = [starts]
    for block in blocks:
        found += [starts + np.argmin(np.nan_to_num(block, nan=np.inf), 1)]
        found += [starts + np.argmax(np.nan_to_num(block, nan=-np.inf), 1)]
    gaps = np.flatnonzero(np.diff(np.isfinite(x + y).astype(np.int8)))  # a gap stays one
    gaps = np.concatenate([gaps, gaps + 1]) if gaps.size < most else gaps[:0]
    return np.unique(np.concatenate([*found, gaps, np.arange(whole, x.size)]))


def kept_of_cloud(size: int, most: int) -> slice:
    """Return which points of a cloud are kept: every so many."""
    return slice(None, None, max(1, -(-size // most)))


def told(kept: int, size: int, what: str) -> str:
    """Say that something was thinned; empty where it was not."""
    return f"{kept:,} of {size:,} {what} are drawn here" if kept < size else ""
