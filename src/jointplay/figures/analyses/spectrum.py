"""Power spectral density over the crank's orders, or over frequency."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from jointplay.display.number_text import raised
from jointplay.figures.drawing import Axes, Dataset, Figure, artists, select, style
from jointplay.figures.registry import picture

ABSCISSAE = {"order": "Frequency over that of the crank", "frequency": "Frequency (Hz)"}
DECADES = 1.15  # of the density's range that the axis spans
FLOOR = 1e-14  # of the largest density: below it, there is only rounding


@picture(choices={"abscissa": ABSCISSAE}, checks={"between": lambda value: limits(value)})
def spectrum(
    dataset: Dataset,
    *,
    abscissa: str = "order",
    between: Sequence[float] | None = None,
    column: str = "single",
) -> Figure:
    """Draw a power spectral density, with its 95 % interval as a bar that holds at every frequency.

    Parameters
    ----------
    dataset : Dataset
        What `jointplay.spectrum` returned.
    abscissa : {"order", "frequency"}
        Over what.
    between : pair of float, optional
        The range shown, in the abscissa's units.
    column : {"single", "double"}
        Width of the figure.
    """
    select.choice("abscissa", abscissa, ABSCISSAE)
    select.choice("column", column, style.COLUMNS)
    select.require(dataset, "spectrum", ["power_spectral_density"])
    density = dataset["power_spectral_density"]
    x, y = dataset[abscissa].values[1:], density.values[1:]  # the mean has been taken out
    low, high = x[[0, -1]]
    if between is not None:
        low, high = limits(between)
    figure = style.sheet(style.COLUMNS[column], 66.0)
    ax = figure.subplots()
    shown = (x >= low) & (x <= high) & np.isfinite(y) & (y > 0)
    if shown.any():
        y = np.maximum(y, FLOOR * y[shown].max())
        artists.curve(ax, x[shown], y[shown], linewidth=0.6)
        ax.set(yscale="log", xlim=(low, high))
        interval_bar(ax, dataset)
    else:
        artists.say(ax, artists.EMPTY)
    unit = raised(str(density.attrs["units"]))
    ax.set(xlabel=ABSCISSAE[abscissa])
    ax.set_ylabel(f"Power spectral density ({unit})")
    artists.heading(ax, density.attrs["long_name"].removeprefix("power spectral density of "))
    return artists.finish(figure, dataset)


def limits(between) -> tuple[float, ...]:
    """Return the two numbers between which a spectrum is shown."""
    return select.numbers("between", between, 2, "[first, last], rising")


def interval_bar(ax: Axes, dataset: Dataset) -> None:
    """Draw the interval of confidence in the upper right corner."""
    lower, upper = dataset["confidence_factor"].values
    if not np.isfinite(upper):
        return
    bottom, top = ax.get_ylim()
    ax.set_ylim(bottom, top * (top / bottom) ** (DECADES - 1))
    place = ax.get_ylim()[1] / upper**1.5
    reach, at = [[place * (1 - lower)], [place * (upper - 1)]], {"transform": ax.get_yaxis_transform()}
    ax.errorbar(0.93, place, yerr=reach, color=style.BLACK, linewidth=0.8, capsize=2, **at)
    ax.text(0.91, place, "95 %", ha="right", va="center", fontsize=7, **at)
