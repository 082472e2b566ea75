"""Tables as pictures: cells in mm on a bare page, shaded from white to dark grey."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from jointplay.figures.drawing import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DARKEST = 0.62  # of black: how dark a cell of shade 1 is
TEXT, BESIDE = 6.5, 7.0  # pt
PAD = 1.0  # mm above and below


def page(width: float, height: float) -> tuple[Figure, Axes]:
    """Return a figure and its one bare axes, in mm from the upper left corner."""
    figure = style.sheet(width, height + 2 * PAD)
    figure.get_layout_engine().set(w_pad=0.0, h_pad=PAD * style.MILLIMETRE)
    ax = figure.subplots()
    ax.set(xlim=(0, width), ylim=(height, 0), aspect="equal")
    ax.set_axis_off()
    return figure, ax


def cell(ax: Axes, box: tuple[float, float, float, float], words: str = "", shade: float = 0.0) -> None:
    """Draw one cell: `box` is left, top, width and height in mm, `shade` from 0 (white) to 1."""
    from matplotlib.patches import Rectangle

    left, top, width, height = box
    grey = 1.0 - DARKEST * (float(np.clip(shade, 0.0, 1.0)) if np.isfinite(shade) else 0.0)
    look = {"facecolor": str(grey), "edgecolor": style.GREY, "linewidth": 0.4}
    ax.add_patch(Rectangle((left, top), width, height, **look))
    colour = "white" if grey < 0.55 else "black"
    write(ax, left + width / 2, top + height / 2, words, ha="center", color=colour)


def lines(ax: Axes, rows, columns: dict[float, str], heights: tuple[float, float], notes, spacing) -> None:
    """Write rows of words, then notes, in a panel: columns by place and alignment, heights of top and row."""
    height, step = heights
    look = {"fontsize": BESIDE, "transform": ax.transAxes}
    for row in rows:
        for (place, align), words in zip(columns.items(), row, strict=True):
            ax.text(place, height, words, ha=align, va="center", **look)
        height -= step
    ax.text(0.0, height, "\n".join(notes), va="top", linespacing=spacing, **look)


def write(ax: Axes, x: float, y: float, words: str, **look) -> None:
    """Write words at a place in mm."""
    ax.text(x, y, words, **{"va": "center", "fontsize": TEXT, "linespacing": 1.05} | look)
