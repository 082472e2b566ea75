"""Stress: run times and energy residuals of scenes far outside ordinary use."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator
from xarray import Dataset

from jointplay.display import codes
from jointplay.figures.drawing import artists, select, style
from jointplay.figures.registry import picture

LOOKS = {  # of a verdict: marker, colour, size; the rarer, the louder, and told apart in grey
    "ok": ("o", "#bdbdbd", 2.0),
    "sensitive": ("o", style.BLUE, 2.0),
    "stopped": ("x", style.AMBER, 3.0),
    "unconfirmed": ("+", style.BLACK, 4.0),
    "suspect": ("s", style.WARNING, 4.0),
}
BINS = np.logspace(-17, 0, 69)  # of energy residuals; what is smaller is drawn in the first


@picture()
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
    artists.letter((times, residuals))
    return artists.finish(figure, dataset)


def time_panel(ax: Axes, dataset: Dataset) -> None:
    """Draw processor times over the number of radians that the contact swings in a turn."""
    x, y = dataset["stiffness_number"].values, 1e3 * dataset["cpu_time"].values
    for word, chosen in verdicts(dataset):
        marker, colour, size = LOOKS[word]
        look = {"marker": marker, "color": colour, "markersize": size, "markeredgewidth": 0.7}
        label = f"{word} ({np.count_nonzero(chosen)})"
        ax.plot(x[chosen], y[chosen], linestyle="none", label=label, rasterized=True, **look)
    ax.set(xscale="log", yscale="log")
    ax.set(xlabel="Contact vibration per turn (rad)", ylabel="Processor time per turn (ms)")
    ax.figure.legend(loc="outside upper center", ncols=len(LOOKS), handletextpad=0.2, columnspacing=1.2)


def residual_panel(ax: Axes, dataset: Dataset) -> None:
    """Draw how the energy residuals are spread, verdicts on top of each other."""
    values = np.clip(dataset["energy_residual"].values, BINS[0], BINS[-1])
    groups = [(word, values[chosen & np.isfinite(values)]) for word, chosen in verdicts(dataset)]
    if groups:
        colours = [LOOKS[word][1] for word, _ in groups]
        ax.hist([each for _, each in groups], BINS, stacked=True, color=colours)
    ax.set(xscale="log", xlabel="Energy unaccounted for, over what flowed", ylabel="Scenes")
    ax.set_xlim(BINS[0], max(1e-5, 10 * np.max(values, initial=0.0, where=np.isfinite(values))))
    ax.xaxis.set_major_locator(LogLocator(numticks=7))


def verdicts(dataset: Dataset) -> list[tuple[str, np.ndarray]]:
    """Return the verdicts that there are, each with its scenes."""
    words = codes.words(dataset["verdict"]).values
    return [(word, words == word) for word in codes.flags(dataset["verdict"]).values() if word in words]
