"""Optimise: a force over the turns, the largest of every joint, and the parameters, before and after."""

from __future__ import annotations

from textwrap import fill

import numpy as np

from jointplay.display import codes
from jointplay.display.number_text import measure, plain
from jointplay.figures.drawing import Axes, Dataset, Figure, artists, style
from jointplay.figures.drawing.select import require
from jointplay.figures.registry import picture

LOOKS = {"before": (style.AMBER, "before"), "after": ("black", "after")}
WIDE, LETTERS = 0.4, 30  # of a bar; of a parameter's name in a line
TOP, HEAD, ROW = 62.0, 14.0, 12.0  # mm: forces; above and below the parameters, and for each


@picture(least=160)
def optimise(dataset: Dataset) -> Figure:
    """Draw a force over the turns and the largest of each joint, and where parameters are in their bounds.

    Parameters
    ----------
    dataset : Dataset
        What `jointplay.optimise` returned.
    """
    require(dataset, "optimise", ("first_value", "optimum", "low", "high", "parameter_name"))
    forces, height = "force_before" in dataset, HEAD + ROW * dataset.sizes["parameter"]
    figure = style.sheet(180.0, TOP + height)
    above, below = figure.subfigures(2, 1, height_ratios=(TOP, height))
    ratios = (1.6, 1.0)[: 1 + forces]
    axes = [*above.subplots(1, len(ratios), squeeze=False, width_ratios=ratios)[0], below.subplots()]
    _course(axes[0], dataset)
    if forces:
        _forces(axes[1], dataset)
    _parameters(axes[-1], dataset)
    artists.letter(axes)
    artists.shared_legend(below, axes[-1:], 2)
    return artists.finish(figure, dataset)


def _course(ax: Axes, dataset: Dataset) -> None:
    there = [name for name in LOOKS if f"course_{name}" in dataset]
    for name in there:
        values, unit = artists.displayed(dataset[f"course_{name}"])
        times, seconds = artists.displayed(dataset[f"time_{name}"])
        ax.plot(times - times[0], values, color=LOOKS[name][0], linewidth=0.8, linestyle="-")
        artists.name_axes(ax, dataset[f"time_{name}"], seconds, dataset[f"course_{name}"], unit)
        ax.set_xlim(0.0, times[-1] - times[0])
    if not there:
        artists.say(ax, "No quantity of this optimisation varies over the turns")


def _forces(ax: Axes, dataset: Dataset) -> None:
    """Draw the largest force of each joint, two bars with their numbers."""
    places = np.arange(dataset.sizes["joint"])
    for side, (name, (colour, _)) in zip((-0.5, 0.5), LOOKS.items(), strict=True):
        values, unit = artists.displayed(dataset[f"force_{name}"])
        bars = ax.bar(places + side * WIDE, np.nan_to_num(values), WIDE, color=colour)
        words = ["?" if np.isnan(value) else plain(float(value), 3) for value in values]
        ax.bar_label(bars, words, fontsize=6.5, padding=1)
    ax.set_xticks(places, [artists.broken(codes.contact(str(name)), 12) for name in dataset["joint"].values])
    ax.tick_params(axis="x", length=0)
    ax.set(xlabel="Joint", ylabel=artists.with_unit("Largest force", unit.symbol))
    ax.margins(y=0.12)


def _parameters(ax: Axes, dataset: Dataset) -> None:
    """Draw a row a parameter: the bounds at its ends, and an arrow from its first value to the last."""
    low, width = dataset["low"].values, (dataset["high"] - dataset["low"]).values
    rows, units = np.arange(len(low)), [str(each) for each in dataset["parameter_units"].values]
    at = {
        "before": (dataset["first_value"].values - low) / width,
        "after": (dataset["optimum"].values - low) / width,
    }
    ax.hlines(rows, 0.0, 1.0, color=style.GREY, linewidth=0.6)
    for row in rows:
        ends = {"xy": (at["after"][row], row), "xytext": (at["before"][row], row)}
        ax.annotate("", **ends, arrowprops={"arrowstyle": "->", "linewidth": 0.8, "shrinkA": 0, "shrinkB": 2})
        for end, name, side in ((0.0, "low", "right"), (1.0, "high", "left")):
            words = measure(float(dataset[name].values[row]), units[row])
            gap = (-6 if side == "right" else 6, 0)
            ax.annotate(words, (end, row), gap, textcoords="offset points", ha=side, va="center", fontsize=7)
    for name, key, above in (("before", "first_value", -1), ("after", "optimum", 1)):
        colour, label = LOOKS[name]
        ax.plot(at[name], rows, "o", markersize=4.5, color=colour, linestyle="none", label=label)
        for row, value in zip(rows, dataset[key].values, strict=True):
            words = measure(float(value), units[row], 3)
            place = {"xytext": (0, 5 * above), "textcoords": "offset points"}
            edge = {"ha": "center", "va": "bottom" if above > 0 else "top", "fontsize": 7}
            ax.annotate(words, (at[name][row], row), **place, **edge)
    names = [artists.capital(str(name)) for name in dataset["parameter_name"].values]
    ax.set_yticks(rows, [fill(name, LETTERS) for name in names])
    ax.set(ylim=(len(rows) - 0.4, -0.6), xlim=(-0.14, 1.14), xticks=[])
    ax.tick_params(axis="y", length=0)
    artists.heading(ax, "Parameters in their bounds")
    for spine in ax.spines.values():
        spine.set_visible(False)
