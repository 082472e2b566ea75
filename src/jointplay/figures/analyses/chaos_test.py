"""0-1 test for chaos: K of every frequency, the driven point, and its mean square displacement."""

from __future__ import annotations

import numpy as np

from jointplay.display import codes
from jointplay.display.number_text import PLAIN
from jointplay.figures.drawing import Axes, Dataset, Figure, artists, select, style
from jointplay.figures.registry import picture

NEEDED = ("chaos_indicator", "chaos_indicator_quartile", "walk_x", "walk_y", "square_displacement")
REGULAR = "Regular: all are one point"
MARGIN = 0.12  # of K, beyond 0 and 1
NARROW = 20  # characters of a line of a label


@picture(least=100)
def chaos_test(dataset: Dataset) -> Figure:
    """Draw K over frequency with its quartiles, the driven point's path, and its mean square displacement.

    Parameters
    ----------
    dataset : Dataset
        What `jointplay.chaos_test` returned.
    """
    select.require(dataset, "chaos_test", NEEDED)
    figure = style.sheet(180.0, 66.0)
    indicators, walk, displacement = figure.subplots(1, 3)
    indicator_panel(indicators, dataset)
    excuse = nothing_to_see(dataset)
    for ax, panel in ((walk, walk_panel), (displacement, displacement_panel)):
        if excuse:
            artists.say(ax, excuse, style.BLACK if excuse == REGULAR else style.WARNING)
        else:
            panel(ax, dataset)
            artists.heading(ax, f"c = {float(dataset['walk_frequency']):.3f}")
    artists.letter((indicators, walk, displacement))
    figure.suptitle(f"Samples: {dataset['sample'].attrs['long_name']}", fontsize=8)
    return artists.finish(figure, dataset)


def indicator_panel(ax: Axes, dataset: Dataset) -> None:
    """Draw K of each frequency; the median as a line in a band of the middle half."""
    low, median, high = dataset["chaos_indicator_quartile"].values
    ax.plot(dataset["test_frequency"], dataset["chaos_indicator"], "o", color=style.BLACK, markersize=1.8)
    ax.axhspan(low, high, color=style.AMBER, alpha=0.35, linewidth=0, zorder=0)
    ax.axhline(median, color=style.BLUE, linewidth=0.8)
    lowest = np.nanmin(dataset["chaos_indicator"].values, initial=0.0)
    ax.set(ylim=(min(lowest, 0.0) - MARGIN, 1 + MARGIN))
    ax.set(xlabel="Frequency c (rad per sample)", ylabel="K")
    verdict = codes.words(dataset["verdict"]).item()
    text = f"median {median:.2f}: {verdict}" if np.isfinite(median) else verdict
    artists.heading(ax, text.replace("-", "\N{MINUS SIGN}"))


def walk_panel(ax: Axes, dataset: Dataset) -> None:
    """Draw the path of the point that the samples drive."""
    x, unit = artists.displayed(dataset["walk_x"])
    y, _ = artists.displayed(dataset["walk_y"], unit)
    ax.plot(x, y, color=style.GREY, linewidth=0.4, rasterized=x.size > artists.DENSE)
    ax.plot(x, y, ".", color=style.BLACK, markersize=1.0, rasterized=True)
    ax.set(xlabel=artists.with_unit("p", unit.symbol), ylabel=artists.with_unit("q", unit.symbol))
    ax.set_aspect("equal", adjustable="datalim")


def displacement_panel(ax: Axes, dataset: Dataset) -> None:
    """Draw the mean square displacement of that point over the number of samples."""
    _, unit = artists.displayed(dataset["walk_x"])
    symbol = unit.symbol if unit.symbol in PLAIN.values() else f"{unit.symbol}²"
    ax.plot(dataset["lag"], dataset["square_displacement"] * unit.factor**2, color=style.BLACK)
    label = artists.broken(artists.with_unit("Mean square displacement", symbol), NARROW)
    ax.set(xlim=(0, None), ylim=(0, None), xlabel="Samples n", ylabel=label)


def nothing_to_see(dataset: Dataset) -> str:
    """Return the reason why there is no path to draw; empty where there is one."""
    if not np.any(np.isfinite(dataset["chaos_indicator"])):
        return "Too few samples"
    return "" if np.any(dataset["chaos_indicator"]) else REGULAR
