"""Benchmark: relative difference of each quantity from the published one."""

from __future__ import annotations

import numpy as np

from jointplay.figures.drawing import Dataset, Figure, artists, select, style
from jointplay.figures.registry import picture

NAME = 18  # characters of a quantity that leave room for the axis
LEAST = 1e-16  # a difference that is rounding: smaller ones are drawn there


@picture()
def benchmark(dataset: Dataset) -> Figure:
    """Draw relative differences from the published answer, a row a quantity.

    Parameters
    ----------
    dataset : Dataset
        What `jointplay.benchmark` returned.
    """
    select.require(dataset, "benchmark", ("computed", "published", "relative_difference"))
    names, off = dataset["quantity"].values, dataset["relative_difference"].values
    longer = max(0, max(map(len, names)) - NAME)
    figure = style.sheet(88.0 + 2.0 * longer, 20.0 + 4.5 * len(names))
    ax, rows = figure.subplots(), np.arange(len(names))
    ax.plot(np.maximum(off, LEAST), rows, "o", color=style.BLUE, markersize=3)
    ax.set(
        xscale="log",
        xlim=(LEAST, max(1e-6, 10 * off.max())),
        xlabel="Relative difference from the published value",
    )
    ax.set_yticks(rows, [str(name) for name in names])
    ax.invert_yaxis()
    ax.grid(True, axis="y", linewidth=0.3)
    return artists.finish(figure, dataset)
