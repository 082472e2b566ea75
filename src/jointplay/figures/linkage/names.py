"""Places for names beside what they name: where the least is drawn, and other names are not."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from jointplay.figures.drawing import style
from jointplay.figures.linkage import symbols

if TYPE_CHECKING:
    from matplotlib.axes import Axes

LETTER, NEAR = 1.5, 2.6  # mm: half the width of two letters' worth of text, the reach of what is drawn
DENSE = 1.5  # mm between points that stand for a line
SIDES = np.deg2rad(np.arange(0, 360, 30))


@dataclass
class Names:
    """Names on axes whose limits and place are settled.

    Parameters
    ----------
    ax : Axes
        Where they stand.
    taken : ndarray, shape (points, 2)
        Points, in mm on the paper, that stand for what is drawn.
    """

    ax: Axes
    taken: np.ndarray = field(default_factory=lambda: np.zeros((0, 2)))

    def paper(self, points) -> np.ndarray:
        """Return points of the axes in mm on the paper."""
        return self.ax.transData.transform(points) / self.ax.figure.dpi / style.MILLIMETRE

    def lines(self, ends: Iterable[np.ndarray]) -> None:
        """Keep names off straight lines, each given by its two ends."""
        for first, last in map(self.paper, ends):
            share = np.linspace(0.0, 1.0, 2 + int(np.hypot(*(last - first)) / DENSE))
            self.taken = np.concatenate([self.taken, first + share[:, None] * (last - first)])

    def around(self, point, text: str, away: float = 4.0, **look) -> None:
        """Write a name around a point."""
        self._best([(point, away * np.array([np.cos(a), np.sin(a)]), 0.0) for a in SIDES], text, look)

    def along(self, ends, text: str, away: float = 3.2, **look) -> None:
        """Write a name along a line, on one of its sides."""
        first, last = np.asarray(ends)
        course = np.subtract(*self.paper([last, first]))
        across = np.array([-course[1], course[0]]) / np.hypot(*course)
        turn = (np.rad2deg(np.arctan2(course[1], course[0])) + 90) % 180 - 90
        shares = (0.5, 0.42, 0.58, 0.34, 0.66, 0.26, 0.74)
        places = [
            (first + s * (last - first), side * away * across, turn) for s in shares for side in (1, -1)
        ]
        self._best(places, text, {"rotation": turn, "rotation_mode": "anchor"} | look)

    def _best(self, places, text: str, look: dict) -> None:
        """Write a name at the best of some places: point, offset in mm, and turn in degrees."""
        half = LETTER * len(text) / 2

        def letters(place) -> np.ndarray:
            point, offset, turn = place
            course = np.array([np.cos(np.deg2rad(turn)), np.sin(np.deg2rad(turn))])
            return self.paper(point) + offset + np.linspace(-half, half, 5)[:, None] * course

        def crowded(place) -> float:
            gaps = letters(place)[:, None] - self.taken
            return float(np.exp(-np.square(gaps / NEAR).sum(-1)).sum())

        best = min(places, key=crowded)
        self.taken = np.concatenate([self.taken, letters(best)])
        symbols.word(self.ax, best[0], text, tuple(best[1]), **look)
