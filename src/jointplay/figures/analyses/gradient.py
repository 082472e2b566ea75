"""Gradient: bars of relative sensitivities, a panel a quantity, the same parameters in each."""

from __future__ import annotations

from textwrap import fill

import numpy as np

from jointplay.figures.drawing import Dataset, Figure, artists, select, style
from jointplay.figures.registry import picture

ROW, HEAD, WIDE = 5.5, 22.0, 4  # mm a parameter; mm; panels side by side
NAMES, LETTERS = 52.0, 34  # for the parameters' names: mm, letters in a line


@picture()
def gradient(dataset: Dataset) -> Figure:
    """Draw relative sensitivities, the parameters in the order of their largest, with errors.

    Parameters
    ----------
    dataset : Dataset
        What `jointplay.gradient` returned.
    """
    select.require(dataset, "gradient", ("relative_sensitivity", "derivative", "parameter_name"))
    shown = dataset["relative_sensitivity"]
    indices = np.flatnonzero(np.isfinite(shown.values).any(axis=1))[:WIDE]
    figure = style.sheet(NAMES + 33.5 * max(len(indices), 1), HEAD + ROW * dataset.sizes["parameter"])
    axes = figure.subplots(1, max(len(indices), 1), sharey=True, squeeze=False)[0]
    if not len(indices):
        artists.say(axes[0], "No relative sensitivity is known")
        return artists.finish(figure, dataset)
    sizes = np.nan_to_num(np.abs(shown.values[indices])).max(axis=0)
    order, rows = np.argsort(-sizes, kind="stable"), np.arange(len(sizes))
    for ax, i in zip(axes, indices, strict=False):
        size = shown.values[i][order]
        with np.errstate(invalid="ignore", divide="ignore"):
            share = (dataset["error"] / abs(dataset["derivative"])).values[i][order]
        error = np.nan_to_num(np.abs(size) * share)
        ax.barh(rows, np.nan_to_num(size), color=style.BLUE, height=0.6)
        ax.errorbar(np.nan_to_num(size), rows, xerr=error, fmt="none", ecolor="black", elinewidth=0.8)
        ax.axvline(0, color=style.GREY, linewidth=0.6)
        ax.set(xlabel="Relative sensitivity")
        artists.heading(ax, artists.capital(str(dataset["quantity_name"].values[i])))
    names = [artists.capital(str(name)) for name in dataset["parameter_name"].values[order]]
    axes[0].set_yticks(rows, [fill(name, LETTERS) for name in names])
    axes[0].invert_yaxis()
    artists.letter(axes)
    return artists.finish(figure, dataset)
