"""Adaptive maps: boxes of a grid that are halved where points on them differ, down to neighbouring points.

A box is a stretch of grid points along each axis. Its corners are computed first. Where points that are
computed on it, on its border too, have features that differ, it is halved along every axis and the corners
of the parts are computed; so on, until nothing differs or nothing lies between. A point inside a box whose
points are alike is not computed: its nearest corner stands for it. Which points are computed follows from
their features alone, and not from when or where they were computed.

Validity: what lies within a box and touches no point on it is not seen; the coarsest box sets how small that
may be.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise, product
from typing import NamedTuple, TypeVar

import numpy as np

from jointplay.analysis.labels import PLANE, Out
from jointplay.solver.motion.progress import part

Point = tuple[int, ...]
Features = TypeVar("Features")


class Box(NamedTuple):
    """Grid points from `low` to `high`, both of them in it; `level`: number of halvings."""

    low: Point
    high: Point
    level: int

    @property
    def corners(self) -> list[Point]:
        """Its corners, each once."""
        return list(product(*({low, high} for low, high in zip(self.low, self.high, strict=True))))

    @property
    def parts(self) -> list[Box]:
        """Its halves along every axis that has points between; none where no axis has."""
        middles = [sorted({a, (a + b) // 2, b}) for a, b in zip(self.low, self.high, strict=True)]
        if all(b - a <= 1 for a, b in zip(self.low, self.high, strict=True)):
            return []
        return [Box(low, high, self.level + 1) for low, high in _boxes(middles)]

    def nearest(self, point: Point) -> Point:
        """The corner that is nearest to a point, along each axis."""
        ends = zip(point, self.low, self.high, strict=True)
        return tuple(low if 2 * at <= low + high else high for at, low, high in ends)


def _boxes(edges: list[list[int]]) -> list[tuple[Point, Point]]:
    """Lowest and highest points between neighbouring edges along each axis."""
    stretches = [list(pairwise(each)) or [(each[0], each[0])] for each in edges]
    return [tuple(zip(*ends, strict=True)) for ends in product(*stretches)]


def coarse(shape: tuple[int, ...], levels: int) -> list[Box]:
    """Boxes of 2^levels steps along each axis, the last ones shorter where that does not come out."""
    step = 2**levels
    return [Box(low, high, 0) for low, high in _boxes([sorted({*range(0, n, step), n - 1}) for n in shape])]


def refined(
    shape: tuple[int, ...],
    levels: int,
    alike: Callable[[list[Features]], bool],
    evaluated: Callable[[list[Point], Callable[[float], None] | None], dict[Point, Features]],
    progress: Callable[[float], None] | None = None,
) -> tuple[list[Box], dict[Point, Features]]:
    """Evaluate points, in rounds, until no box has points on it that differ.

    Parameters
    ----------
    shape : tuple of int
        Of the grid.
    levels : int
        How often the coarsest boxes can be halved.
    alike : callable
        Whether points with these features may stand for each other.
    evaluated : callable
        Gives the features of some points, in the grid's order, and is to tell how far it is.
    progress : callable, optional
        Called with the fraction done; how many rounds there will be is unknown.

    Returns
    -------
    boxes, features
        The boxes that are left, in the grid's order, and the features of all points that were computed.
    """
    boxes, features, left = coarse(shape, levels), {}, 1.0
    while needed := sorted({corner for box in boxes for corner in box.corners} - features.keys()):
        features |= evaluated(needed, part(progress, 1 - left, 1 - left / 2))
        left /= 2
        table = np.empty(shape, dtype=object)
        for point, feature in features.items():
            table[point] = feature
        boxes = [part for box in boxes for part in _halved(box, table, alike)]
    return boxes, features


OUTS = {
    "computed": Out(PLANE, "1: computed; 0: the nearest computed corner of its box stands for it"),
    "refinement_level": Out(PLANE, "halvings of the point's box"),
}


def variables(computed: dict[Point, Features], level: np.ndarray) -> dict[str, np.ndarray]:
    """Values of `OUTS`: the computed points, and the fineness of the map."""
    done = np.zeros(level.shape, dtype=np.int8)
    done[tuple(np.transpose(list(computed)))] = 1
    return {"computed": done, "refinement_level": level.astype(np.int8)}


def _halved(box: Box, table: np.ndarray, alike: Callable[[list[Features]], bool]) -> list[Box]:
    """The box, or its parts where it is to be halved, which are halved in turn as far as is known."""
    inside = table[tuple(slice(low, high + 1) for low, high in zip(box.low, box.high, strict=True))]
    known = [feature for feature in inside.flat if feature is not None]
    if any(table[corner] is None for corner in box.corners) or alike(known) or not (parts := box.parts):
        return [box]
    return [each for part in parts for each in _halved(part, table, alike)]


def representatives(
    shape: tuple[int, ...], boxes: list[Box], computed: dict[Point, Features]
) -> tuple[np.ndarray, ...]:
    """For each grid point, the computed one that stands for it (flat index) and its box's level.

    A point that is computed stands for itself; one on several boxes belongs to the finest of them.
    """
    place, level = np.full(shape, -1), np.full(shape, -1)
    for box in sorted(boxes, key=lambda box: box.level):
        ranges = (range(low, high + 1) for low, high in zip(box.low, box.high, strict=True))
        for point in product(*ranges):
            own = point if point in computed else box.nearest(point)
            place[point], level[point] = np.ravel_multi_index(own, shape), box.level
    return place, level
