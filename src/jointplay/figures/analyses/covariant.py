"""Covariant vectors: shares of the parts in each, and angles between subspaces."""

from __future__ import annotations

from functools import partial

import numpy as np

from jointplay.display.number_text import with_error
from jointplay.figures.drawing import Axes, Dataset, Figure, artists, select, style
from jointplay.figures.registry import picture

ENDS = (np.array([0.0, 0.2, 0.3]), np.array([0.95, 0.95, 0.95]))  # colours of the first and the last part
LISTED = 12  # vectors that have room


@picture(least=160, needs=("mean_share",), checks={"vectors": partial(select.leading, "vectors")})
def covariant(dataset: Dataset, *, vectors: int | None = None) -> Figure:
    """Draw the mean shares of parts in each vector, and the distribution of angles between subspaces.

    Parameters
    ----------
    dataset : Dataset
        What `jointplay.covariant` returned.
    vectors : int, optional
        How many, those of the largest exponents first; up to twelve if left out.
    """
    select.require(dataset, "covariant", ("mean_share", "covariant_exponent"))
    count = min(select.leading("vectors", vectors) or LISTED, dataset.sizes["vector"])
    figure = style.sheet(180.0, 76.0)
    shares, angles = figure.subplots(1, 2)
    share_panel(shares, dataset.isel(vector=slice(count)))
    angle_panel(angles, dataset.isel(splitting=slice(count)))
    artists.letter((shares, angles))
    return artists.finish(figure, dataset)


def share_panel(ax: Axes, dataset: Dataset) -> None:
    """Draw a bar for each vector, divided by its parts, and its exponent next to the bar."""
    from matplotlib.colors import to_hex

    shares, numbers = dataset["mean_share"].values, dataset["vector"].values
    tail, unit = ("_per_turn", "per turn") if "turn_period" in dataset else ("", "1/s")
    values, errors = (dataset[f"covariant_{name}{tail}"].values for name in ("exponent", "standard_error"))
    left, names = np.zeros(len(numbers)), [str(name) for name in dataset["part"].values]
    for place, name in enumerate(names):
        at = place / max(len(names) - 1, 1)
        colour = to_hex((1 - at) * ENDS[0] + at * ENDS[1])
        look = {"color": colour, "edgecolor": style.BLACK, "linewidth": 0.4, "height": 0.7}
        ax.barh(numbers, shares[:, place], left=left, label=name, **look)
        left = left + shares[:, place]
    words = [f"{n}:  {with_error(v, e)}" for n, v, e in zip(numbers, values, errors, strict=True)]
    ax.set_yticks(numbers, words)
    ax.tick_params(axis="y", length=0)
    ax.set(xlim=(0, 1), ylim=(numbers[-1] + 0.6, numbers[0] - 0.6))
    ax.set(xlabel="Mean share", ylabel=f"Vector: exponent ({unit})")
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.18), ncols=4)


def angle_panel(ax: Axes, dataset: Dataset) -> None:
    """Draw for each splitting the share of section points whose angle is smaller."""
    if not dataset.sizes["splitting"] or not dataset.sizes["turn"]:
        artists.say(ax, "One vector: no angle", style.BLACK)
        return
    count = dataset.sizes["turn"]
    for place, number in enumerate(dataset["splitting"].values):
        angles = np.sort(np.degrees(dataset["splitting_angle"].isel(splitting=place).values))
        first = "1" if number == 1 else f"1\N{EN DASH}{number}"
        look = {"where": "post", "linewidth": 0.8 * (1 + place // 4)}  # dashes repeat after four
        ax.step(angles, np.arange(1, count + 1) / count, label=f"{first} and the rest", **look)
    ax.set(xscale="log", ylim=(0, 1), ylabel="Share of section points")
    ax.set(xlabel="Smallest angle between the spans (deg)")
    ax.legend(loc="upper left", fontsize=6)
