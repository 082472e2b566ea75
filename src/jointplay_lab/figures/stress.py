"""Stress: run times and energy residuals of scenes far outside ordinary use."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from jointplay.display import codes
from jointplay.figures.drawing import Axes, Dataset, Figure, Line2D, artists, select, style
from jointplay.figures.registry import picture

LOOKS = {  # of a verdict: marker, colour, size; the rarer, the louder, and told apart in grey
    "ok": ("o", "#bdbdbd", 2.0),
    "sensitive": ("o", style.BLUE, 2.0),
    "stopped": ("x", style.AMBER, 3.0),
    "unconfirmed": ("+", style.BLACK, 4.0),
    "suspect": ("s", style.WARNING, 4.0),
}
HATCHES = {"suspect": "////////", "stopped": "...."}  # of bars beside others as dark
BINS = np.logspace(-17, 0, 69)  # of energy residuals; what is smaller is drawn in the first


@picture(least=140)
def stress(dataset: Dataset) -> Figure:
    """Draw the processor time of a turn over the contact's stiffness, and the energy residuals, by verdict.

    Parameters
    ----------
    dataset : Dataset
        What `jointplay.stress` returned.
    """
    select.require(dataset, "stress", ("verdict", "stiffness_number", "energy_residual"))
    figure = style.sheet(180.0, 80.0)
    times, residuals = figure.subplots(1, 2)
    time_panel(times, dataset)
    residual_panel(residuals, dataset)
    explain(figure, times.get_lines(), dataset)
    artists.letter((times, residuals))
    return artists.finish(figure, dataset)


def time_panel(ax: Axes, dataset: Dataset) -> None:
    """Draw processor times over the number of radians that the contact swings in a turn."""
    x, y = dataset["stiffness_number"].values, 1e3 * dataset["cpu_time"].values
    for word, chosen in verdicts(dataset):
        marker, colour, size = LOOKS[word]
        look = {"marker": marker, "color": colour, "markersize": size, "markeredgewidth": 0.7}
        ax.plot(x[chosen], y[chosen], linestyle="none", label=word, rasterized=True, **look)
    ax.set(xscale="log", yscale="log")
    ax.set(xlabel="Contact vibration per turn (rad)", ylabel="Processor time per turn (ms)")


def residual_panel(ax: Axes, dataset: Dataset) -> None:
    """Draw the distribution of the energy residuals, verdicts on top of each other."""
    from matplotlib.ticker import LogLocator

    values = np.clip(dataset["energy_residual"].values, BINS[0], BINS[-1])
    groups = [(word, values[chosen & np.isfinite(values)]) for word, chosen in verdicts(dataset)]
    if groups:
        below = np.zeros(len(BINS) - 1)
        for word, each in groups:
            count = np.histogram(each, BINS)[0]
            ax.bar(BINS[:-1], count, np.diff(BINS), below, align="edge", **filled(word))
            below += count
    ax.use_sticky_edges = False  # a bar's foot on top of others takes no margin away
    ax.set(xscale="log", xlabel="Energy unaccounted for, over what flowed", ylabel="Scenes")
    ax.set_ylim(bottom=0.0)
    ax.set_xlim(BINS[0], max(1e-5, 10 * np.max(values, initial=0.0, where=np.isfinite(values))))
    ax.xaxis.set_major_locator(LogLocator(numticks=7))


def filled(word: str) -> dict[str, Any]:
    """Return the style of a verdict's bars."""
    return {"facecolor": LOOKS[word][1], "edgecolor": "white", "linewidth": 0.0, "hatch": HATCHES.get(word)}


def explain(figure: Figure, points: Sequence[Line2D], dataset: Dataset) -> None:
    """Name each verdict above the panels, by its bars and points, with its number of scenes."""
    from matplotlib.legend_handler import HandlerTuple

    numbers = {word: np.count_nonzero(chosen) for word, chosen in verdicts(dataset)}
    handles = [(artists.swatch(**filled(line.get_label())), line) for line in points]
    words = [f"{line.get_label()} ({numbers[line.get_label()]})" for line in points]
    look = {"ncols": len(LOOKS), "handletextpad": 0.4, "columnspacing": 1.2, "handlelength": 2.2}
    kinds = {tuple: HandlerTuple(None)}
    figure.legend(handles, words, loc="outside upper center", handler_map=kinds, **look)


def verdicts(dataset: Dataset) -> list[tuple[str, np.ndarray]]:
    """Return the verdicts that there are, each with its scenes."""
    words = codes.words(dataset["verdict"]).values
    return [(word, words == word) for word in codes.flags(dataset["verdict"]).values() if word in words]
