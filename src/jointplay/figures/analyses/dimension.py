"""Correlation dimension: the correlation sum over distance, and its slope."""

from __future__ import annotations

import numpy as np

from jointplay.display.number_text import with_error
from jointplay.figures.drawing import Axes, Dataset, Figure, artists, select, style
from jointplay.figures.registry import picture

DISTANCE = "Distance (standard deviations)"


@picture(least=120)
def dimension(dataset: Dataset) -> Figure:
    """Draw the correlation sum and its local slope, with the range and the value of the fit.

    Parameters
    ----------
    dataset : Dataset
        What `jointplay.dimension` returned.
    """
    select.require(dataset, "dimension", ("correlation_sum", "correlation_dimension"))
    figure = style.sheet(180.0, 76.0)
    sums, slopes = figure.subplots(1, 2)
    if dataset.sizes["radius"]:
        sum_panel(sums, dataset)
        slope_panel(slopes, dataset)
    else:
        point = dataset["correlation_dimension"] == 0
        answer = "Dimension 0: all is one point", style.BLACK
        for ax in (sums, slopes):
            artists.say(ax, *(answer if point else (artists.EMPTY,)))
    artists.letter((sums, slopes))
    return artists.finish(figure, dataset)


def sum_panel(ax: Axes, dataset: Dataset) -> None:
    """Draw the share of close pairs, and the line of the fitted slope."""
    x, y = dataset["radius"].values, dataset["correlation_sum"].values
    ax.plot(x, np.where(y > 0, y, np.nan), "o", color=style.BLACK, markersize=1.8)
    ends, slope = dataset["fit_radius"].values, float(dataset["correlation_dimension"])
    inside = (x >= ends[0]) & (x <= ends[1]) & (y > 0)
    if inside.any() and np.isfinite(slope):
        middle = np.exp(np.mean(np.log(y[inside])) - slope * np.mean(np.log(x[inside])))
        ax.plot(x[inside], middle * x[inside] ** slope, color=style.AMBER, linewidth=1.2, zorder=3)
    ax.set(xscale="log", yscale="log", xlabel=DISTANCE, ylabel="Share of closer pairs")
    artists.heading(ax, f"{int(dataset['n_points'])} points")


def slope_panel(ax: Axes, dataset: Dataset) -> None:
    """Draw the slope around each distance; the fitted one as a line in a band of its spread."""
    x, ends = dataset["radius"].values, dataset["fit_radius"].values
    value = float(dataset["correlation_dimension"])
    spread, error = (float(dataset[f"correlation_dimension_{name}"]) for name in ("spread", "standard_error"))
    ax.plot(x, dataset["local_slope"], "o", color=style.BLACK, markersize=1.8)
    ax.set(xscale="log", xlabel=DISTANCE, ylabel="Slope", ylim=(0, None))
    if np.isfinite(value):
        ax.fill_between(ends, value - spread, value + spread, color=style.AMBER, alpha=0.35, linewidth=0)
        ax.plot(ends, [value, value], color=style.BLUE)
    artists.heading(ax, f"D = {with_error(value, float(np.fmax(spread, error)))}")
