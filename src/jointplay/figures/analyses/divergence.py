"""Divergence: distances of neighbours from the motion at which they started, turn by turn."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from jointplay.display.errors import Problem
from jointplay.display.number_text import plain, with_error
from jointplay.figures.drawing import Dataset, Figure, artists, select, style
from jointplay.figures.registry import picture

NEIGHBOUR = {"color": style.GREY, "linewidth": 0.4, "linestyle": "-", "alpha": 0.6}
MEAN = {"color": style.BLACK, "linewidth": 1.4, "linestyle": "-"}
FIT = {"color": style.AMBER, "linewidth": 1.6, "linestyle": (0, (4, 1.5))}
LEVEL = {"color": style.BLUE, "linewidth": 0.8, "linestyle": (0, (1.5, 1.5))}


def fits(_: Any, settings: Mapping[str, Any]) -> Iterator[Problem]:
    """Yield the problem of a study without neighbours."""
    if not settings.get("neighbours", "plane" not in settings):
        yield Problem("figure.kind", "divergence", "it is accepted where analysis.neighbours is given")


@picture(needs=("mean_log_distance",), fits=fits)
def divergence(dataset: Dataset, *, neighbours: bool = True) -> Figure:
    """Draw distances of neighbours over turns, their mean logarithm, and the fitted growth.

    Parameters
    ----------
    dataset : Dataset
        What `jointplay.sensitivity` returned, with neighbours.
    neighbours : bool
        Whether to draw every neighbour beside the mean.
    """
    select.switch("neighbours", neighbours)
    expected = "a result of a study of kind sensitivity, with neighbours"
    select.require(dataset, "divergence", ["mean_log_distance"], expected)
    figure = style.sheet(88.0, 80.0)
    ax = figure.subplots()
    turn = dataset["turn"].values
    if neighbours:
        curves = dataset["distance"].transpose(..., "turn").values.reshape(-1, turn.size)
        for number, curve in enumerate(curves):
            label = "neighbours" if number == 0 else "_"
            ax.plot(turn, np.where(curve > 0, curve, np.nan), **NEIGHBOUR, label=label)
    growth = with_error(float(dataset["growth"]), float(dataset["growth_standard_error"]))
    ax.plot(turn, np.exp(dataset["mean_log_distance"].values), **MEAN, label="mean logarithm")
    if np.isfinite(dataset["growth"]):
        fit = np.exp(dataset["fitted_log_distance"].values)
        ax.plot(turn, fit, **FIT, label=f"growth {growth} per turn")
    level = float(dataset["saturation"])
    if np.isfinite(level):
        ax.axhline(level, **LEVEL, label=f"stays at {plain(level, 2)}")
    ax.set(yscale="log", xlabel="Turns", ylabel="Scaled distance")
    ax.set_xlim(turn[0], turn[-1])
    figure.legend(loc="outside lower center")
    return artists.finish(figure, dataset)
