"""Axes of somebody else's figure in the place of a figure of our own, for drawings of one panel."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from jointplay.figures.drawing import select

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


class Panel:
    """A user's axes that answer as a figure with one panel; size and layout are their owner's.

    Parameters
    ----------
    ax : Axes
        Where to draw.
    """

    def __init__(self, ax: Axes) -> None:
        self.ax, self.figure, self.axes = ax, ax.figure, [ax]

    def subplots(self, rows: int = 1, columns: int = 1, squeeze: bool = True, **_: Any) -> Any:
        """Give the axes, where one panel is wanted."""
        if rows * columns > 1:
            self._several(rows * columns)
        return self.ax if squeeze else np.array([[self.ax]])

    def subfigures(self, rows: int, columns: int, **_: Any) -> Any:
        """Refuse: a sheet of several results has several panels."""
        self._several(rows * columns)

    def subplot_mosaic(self, mosaic: str, **_: Any) -> Any:
        """Refuse: a mosaic has several panels."""
        self._several(len({*mosaic} - {";"}))

    def add_gridspec(self, rows: int, columns: int, **_: Any) -> Any:
        """Give the place of the axes, where one panel is wanted."""
        if rows * columns > 1:
            self._several(rows * columns)
        return np.empty((1, 1))

    def add_subplot(self, _: Any) -> Axes:
        """Give the axes."""
        return self.ax

    def supxlabel(self, words: str, **_: Any) -> None:
        """Write below the label of the x axis."""
        self.ax.set_xlabel(f"{self.ax.get_xlabel()}\n{words}")

    @staticmethod
    def _several(count: int) -> None:
        expected = f"a matplotlib SubFigure: this figure has {count} panels, which one Axes cannot hold"
        raise select.refuse("ax", "an Axes", expected)

    def legend(self, *entries: Any, loc: str = "best", **look: Any) -> None:
        """Put the legend inside the axes."""
        self.ax.legend(*entries, **look, loc="best" if loc.startswith("outside") else loc)

    def colorbar(self, mesh: Any, **look: Any) -> Any:
        """Put the colour bar next to the axes."""
        return self.ax.figure.colorbar(mesh, **look)

    def findobj(self, *match: Any) -> list[Any]:
        """Find artists in the axes."""
        return self.ax.findobj(*match)

    def suptitle(self, words: str, **look: Any) -> None:
        """Write on top of the axes."""
        look.pop("bbox", None)
        self.ax.set_title(words, **look)


def owner(figure: Any) -> Figure:
    """Return the whole figure that something was drawn in."""
    inner = figure.ax.figure if isinstance(figure, Panel) else figure
    return inner.get_figure(root=True)
