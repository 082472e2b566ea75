"""Work and precision: error over run time and over evaluations, a line a method."""

from __future__ import annotations

import numpy as np

from jointplay.display import codes
from jointplay.figures.drawing import Axes, Dataset, Figure, Line2D, artists, select, style
from jointplay.figures.registry import picture

LOOKS = {  # of a method: colour, marker, dashes
    "jointplay": (style.BLACK, "o", "-"),
    "heyoka": (style.BLUE, "s", "-"),
    "CVODE": (style.AMBER, "D", "-"),
    "LSODA": (style.GREY, "^", (0, (4, 1.5))),
    "Radau": (style.BLUE, "v", (0, (1.2, 1.2))),
    "DOP853": (style.AMBER, "P", (0, (6, 1, 1, 1))),
}
OTHER = (style.GREY, "X", "-")
PANELS = {"cpu_time": "CPU time per turn (ms)", "evaluations": "Evaluations per turn"}
HEIGHTS = {"single": 142.0, "double": 86.0}  # mm
LEAST = 1e-16  # an error of nothing is drawn there


@picture()
def work_precision(dataset: Dataset, *, column: str = "single") -> Figure:
    """Draw the error of each method over the CPU time and the evaluations of a turn.

    Hollow marks without a line are runs whose events, or whose end, are not the truth's. Errors in the grey
    band are below what the truth is known to.

    Parameters
    ----------
    dataset : Dataset
        What `jointplay.work_precision` returned.
    column : {"single", "double"}
        Width of the figure.
    """
    from matplotlib.ticker import NullFormatter

    select.require(dataset, "work_precision", ("error", "agreement", *PANELS))
    width = style.COLUMNS[select.choice("column", column, style.COLUMNS)]
    figure = style.sheet(width, HEIGHTS[column])
    shape = (2, 1) if column == "single" else (1, 2)
    axes = figure.subplots(*shape, sharey=True).ravel()
    for ax, (name, text) in zip(axes, PANELS.items(), strict=True):
        panel(ax, dataset, name, 1e3 if name == "cpu_time" else 1.0)
        ax.set(xscale="log", yscale="log", xlabel=text)
        ax.set(xlim=decades(*ax.get_xlim()))
        ax.xaxis.set_minor_formatter(NullFormatter())
    if not int(dataset["truth_confirmed"]):
        artists.heading(axes[0], "no second method confirms the truth")
    artists.letter(axes)
    for ax in axes if column == "single" else axes[:1]:
        ax.set_ylabel("Error at the end")
    place = {"loc": "outside upper center", "ncols": 3 if column == "single" else 6, "columnspacing": 1.2}
    figure.legend(handles=handles(dataset, axes[0]), **place)
    return artists.finish(figure, dataset)


def panel(ax: Axes, dataset: Dataset, name: str, factor: float) -> None:
    """Draw the errors of all methods over one measure of work."""
    for method in select.labels(dataset, "solver"):
        one = dataset.sel(solver=method)
        x, y = factor * one[name].values, np.maximum(one["error"].values, LEAST)
        there, good = np.isfinite(x) & np.isfinite(y), codes.words(one["agreement"]).values == "same"
        colour, marker, dashes = LOOKS.get(method, OTHER)
        look = {"color": colour, "marker": marker, "markersize": 3.2, "linewidth": 0.9}
        ax.plot(x[there & good], y[there & good], linestyle=dashes, label=method, **look)
        hollow = look | {"markerfacecolor": "white", "linestyle": "none"}
        ax.plot(x[there & ~good], y[there & ~good], label="_", **hollow)
    known = float(dataset["truth_difference"])
    if known > 0:
        ax.axhspan(LEAST / 10, known, color=style.DISC, zorder=0, linewidth=0)
    limits(ax, dataset, known)


def decades(low: float, high: float) -> tuple[float, float]:
    """Return limits of a logarithmic axis with two powers of ten between them at least."""
    if low <= 0:
        return low, high
    if np.floor(np.log10(high)) - np.ceil(np.log10(low)) < 1:
        low = 10 ** np.floor(np.log10(low))
    if np.floor(np.log10(high)) - np.ceil(np.log10(low)) < 1:
        high = 10 ** np.ceil(np.log10(high))
    return low, high


def limits(ax: Axes, dataset: Dataset, known: float) -> None:
    """Set limits that show every error, and the truth's own."""
    errors = dataset["error"].values
    errors = np.append(np.maximum(errors[np.isfinite(errors)], LEAST), [known] if known > 0 else [])
    if errors.size:
        ax.set_ylim(errors.min() / 4, errors.max() * 4)


def handles(dataset: Dataset, ax: Axes) -> list[Line2D]:
    """Return the entries of the legend: lines of methods, and the mark of other events or ends."""
    found = [line for line in ax.lines if not line.get_label().startswith("_")]
    if np.isin(codes.words(dataset["agreement"]).values, ("other_events", "other_state")).any():
        look = {"color": style.BLACK, "marker": "o", "markersize": 3.2, "markerfacecolor": "white"}
        found.append(artists.sample(linestyle="none", label="other events or end", **look))
    return found
