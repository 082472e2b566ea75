"""Optimise: the course of a quantity before and after, and the way of the parameters and of the objective."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from jointplay.figures.drawing import artists, style
from jointplay.figures.drawing.select import require
from jointplay.figures.registry import picture

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from xarray import Dataset

LOOKS = {"before": (style.AMBER, "before"), "after": ("black", "after")}
BELOW = {"loc": "upper center", "bbox_to_anchor": (0.5, -0.22)}  # of a legend: under the label of the x axis
SIGNS, SHOWN = "os^Dv", 40  # markers of lines, and how many a line has at most


@picture()
def optimise(dataset: Dataset) -> Figure:
    """Draw a force over the turns before and after, and parameters over the designs tried, in their bounds.

    Parameters
    ----------
    dataset : Dataset
        What `jointplay.optimise` returned.
    """
    require(dataset, "optimise", ("tried_value", "optimum", "low", "high"))
    figure = style.sheet(180.0, 68.0 + 3.0 * dataset.sizes["parameter"])
    left, right = figure.subplots(1, 2)
    _course(left, dataset)
    _designs_tried(right, dataset)
    artists.letter((left, right))
    return artists.finish(figure, dataset)


def _course(ax: Axes, dataset: Dataset) -> None:
    there = [name for name in LOOKS if f"course_{name}" in dataset]
    for name in there:
        values, unit = artists.displayed(dataset[f"course_{name}"])
        times, seconds = artists.displayed(dataset[f"time_{name}"])
        colour, label = LOOKS[name]
        ax.plot(times - times[0], values, color=colour, linewidth=0.8, linestyle="-", label=label)
        artists.name_axes(ax, dataset[f"time_{name}"], seconds, dataset[f"course_{name}"], unit)
    if there:
        ax.legend(**BELOW, ncols=2)
    else:
        artists.say(ax, "No quantity of this optimisation varies over the turns")


def _designs_tried(ax: Axes, dataset: Dataset) -> None:
    from matplotlib.ticker import MaxNLocator

    low, width = dataset["low"].values, (dataset["high"] - dataset["low"]).values
    share = (dataset["tried_value"].values - low) / width
    steps = np.arange(1, len(share) + 1)
    opened = np.flatnonzero(np.diff(dataset["tried_share"].values))
    for i, name in enumerate(dataset["parameter"].values):
        look = {"marker": SIGNS[i % len(SIGNS)], "markevery": max(len(steps) // SHOWN, 1), "markersize": 2.5}
        ax.plot(steps, share[:, i], "-", linewidth=0.8, label=str(name), **look)
    for place, label in zip(opened + 1.5, ["clearance changes here"] + [None] * len(opened), strict=False):
        ax.axvline(place, color=style.GREY, linestyle="--", linewidth=0.8, label=label)
    ax.set(xlabel="Design tried", ylabel="Place between the bounds", ylim=(-0.05, 1.05))
    ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    ax.legend(**BELOW, fontsize=7)
