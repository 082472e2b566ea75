"""Comparison: several results on one sheet, each as its own figure shows it, with the same axes and units."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from textwrap import fill
from typing import Any, TypeAlias

import numpy as np

from jointplay.figures.drawing import Axes, Dataset, Figure, SubFigure, artists, style, timebase

ROW, COLUMN = 54.0, 118.0  # mm of height: of a result below others, and beside others
UPRIGHT = ("poincare_section",)  # kinds that stand beside each other
LETTER = re.compile(r"^\([a-z]\) *")
WIDE = 1.9  # mm a letter
LEGEND = 16.0  # mm
OVER = (
    {"color": style.AMBER, "linewidth": 2.0, "linestyle": "-"},
    {"color": style.BLACK, "linewidth": 0.8, "linestyle": "-"},
)
AROUND = 0.03  # of an axis that several panels have in common

Part: TypeAlias = "tuple[Dataset, dict[str, Any]]"


def compared(parts: Sequence[Part], draw: Callable[..., Figure], columns: int | None = None) -> Figure:
    """Draw results on one sheet, in columns or a row; axes that show the same unit have one scale.

    Parameters
    ----------
    parts : sequence of (Dataset, dict)
        Results, with the options of the figure of each.
    draw : callable
        Draws one result with its options, and ``ax`` among them.
    columns : int, optional
        How many beside each other; by default all that are upright, and else one.
    """
    count, upright = len(parts), all(options.get("kind") in UPRIGHT for _, options in parts)
    columns = columns or (count if upright else 1)
    rows = -(-count // columns)
    with style.paper():
        figure = style.sheet(180.0, COLUMN if upright else ROW * rows)
        places = figure.subfigures(rows, columns, squeeze=False).ravel()
        with style.settings(ax=None, same_sheet=tuple(dataset for dataset, _ in parts)):
            for place, (dataset, options) in zip(places, parts, strict=True):
                draw(dataset, options | {"ax": place})
                title(place, dataset, 180.0 / columns)
        panels = [place.axes for place in places]
        if len({len(row) for row in panels}) == 1:
            for same in zip(*panels, strict=True):
                share(same)
            if upright:
                align(places)
            else:
                for column in range(columns):
                    once(panels[column::columns])
                for row in range(0, count, columns):
                    same_lines(places[row : row + columns])
        artists.settle(figure)
        for column in range(columns * (not upright)):
            level(figure, panels[column::columns])
    return figure


def overlaid(
    parts: Sequence[Part], draw: Callable[..., Figure], windows: Sequence[Sequence[float]]
) -> Figure:
    """Draw curves of results over each other, a panel for each window of time; the first is broad and light.

    Parameters
    ----------
    parts, draw
        As in `compared`; of figures that have one panel.
    windows : sequence of pair
        First and last time of each panel, s.
    """
    with style.paper(), style.settings(ax=None, same_sheet=tuple(dataset for dataset, _ in parts)):
        figure = style.sheet(180.0, ROW * len(windows) + LEGEND)
        axes = figure.subplots(len(windows), 1, squeeze=False)[:, 0]
        for ax, window in zip(axes, windows, strict=True):
            for look, (dataset, options) in zip(OVER, parts, strict=False):
                drawn = len(ax.lines)
                draw(dataset, options | {"time": list(window), "ax": ax})
                for line in ax.lines[drawn:]:
                    line.set(**look, label=str(dataset.attrs.get("title", "")))
            for upper in list(ax.child_axes[1:]):
                upper.remove()
            if legend := ax.get_legend():  # of curves that the drawing of a single result named
                legend.remove()
            artists.heading(ax, beside_top_axis=True)
        artists.letter(axes)
        artists.shared_legend(figure, axes, 1)
        artists.settle(figure)
    return figure


def level(figure: Figure, rows: Sequence[Sequence[Axes]]) -> None:
    """Give panels below each other frames of one size, so that they can be compared by eye."""
    figure.set_layout_engine("none")
    places = np.array([[ax.get_position().extents for ax in row] for row in rows])
    left, right = places[..., 0].max(axis=0), places[..., 2].min(axis=0)
    height = (places[..., 3] - places[..., 1]).min()
    for row, bottoms in zip(rows, places[..., 1], strict=True):
        for ax, x, width, y in zip(row, left, right - left, bottoms, strict=True):
            ax.set_position((x, y, width, height))


def title(place: SubFigure, dataset: Dataset, width: float) -> None:
    """Write the study's title over a result, and take the letters off its panels."""
    words = str(dataset.attrs.get("title", dataset.attrs.get("study", "")))
    place.suptitle(fill(words.replace("Fig. ", "Fig.\N{NO-BREAK SPACE}"), int(width / WIDE)), fontsize=8)
    for ax in place.axes:
        artists.heading(ax, LETTER.sub("", ax.get_title(loc="left")), beside_top_axis=bool(ax.child_axes))


def share(panels: Sequence[Axes]) -> None:
    """Give panels the limits that hold all of them, in the directions in which they show one unit."""
    for axis in "xy":
        units = {artists.unit(getattr(ax, f"get_{axis}label")()) for ax in panels}
        if len(units) == 1:
            ends = np.array([getattr(ax, f"get_{axis}lim")() for ax in panels])
            low, high = ends[:, 0].min(), ends[:, 1].max()
            pad = AROUND * (high - low) * bool(np.ptp(ends, axis=0).any())
            for ax in panels:
                getattr(ax, f"set_{axis}lim")(low - pad, high + pad)


def align(places: Sequence[SubFigure]) -> None:
    """Give titles in a row the same number of lines: panels are then at one height."""
    same_lines(places)
    for row in zip(*(place.axes for place in places), strict=True):
        for ax, text in zip(row, padded([ax.get_title(loc="left") for ax in row]), strict=True):
            ax.set_title(text, loc="left")


def same_lines(places: Sequence[SubFigure]) -> None:
    """Give titles beside each other the same number of lines."""
    titles = padded([place.get_suptitle() for place in places])
    for place, words in zip(places, titles, strict=True):
        place.suptitle(words, fontsize=8)


def padded(texts: Sequence[str]) -> list[str]:
    """Return texts with as many lines as the longest of them, the words at the bottom."""
    most = max(text.count("\n") for text in texts)
    return ["\n" * (most - text.count("\n")) + text for text in texts]


def once(rows: Sequence[Sequence[Axes]]) -> None:
    """Label the common axes of rows once: the upper axis and titles above, the lower axis below."""
    for row in rows:
        for ax in row:
            ax.tick_params(labelleft=True)
        timebase.level(row)
    for row in rows[:-1]:
        for ax in row:
            ax.set_xlabel("")
    for row in rows[1:]:
        for ax in row:
            artists.heading(ax)
            for upper in list(ax.child_axes):
                upper.remove()
