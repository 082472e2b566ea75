"""Assessment: joint forces against the ideal mechanism's, and where the motion changes, on one page."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from jointplay.figures.drawing import artists, select, style
from jointplay.figures.registry import picture

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from xarray import Dataset

MARKS = {  # of a change: marker, colour, how far below its parameter's line, words
    "contact_loss": ("o", style.BLUE, -0.16, "contact lost or kept"),
    "doubling": ("s", style.AMBER, 0.0, "period 1 lost or reached"),
    "chaos": ("D", style.BLACK, 0.16, "chaos begins or ends"),
}
SHARES = (0.25, 0.5, 0.7, 1.0, 1.4, 2.0, 4.0)


@picture()
def assess(dataset: Dataset, *, joint: str | None = None) -> Figure:
    """Draw a joint's force over a turn, the largest forces of all joints, and the changes of the motion.

    Parameters
    ----------
    dataset : Dataset
        What `jointplay.assess` returned.
    joint : str, optional
        Whose force is drawn over a turn; the hardest worked one if left out.
    """
    select.require(dataset, "assess", ("force_ratio", "edge_ratio", "joint_force"))
    figure = style.sheet(180.0, 100.0 + 7.0 * dataset.sizes["parameter"])
    grid = figure.add_gridspec(2, 2, height_ratios=(3, 1 + 0.5 * dataset.sizes["parameter"]))
    turn, peaks, edges = (figure.add_subplot(place) for place in (grid[0, 0], grid[0, 1], grid[1, :]))
    turn_panel(turn, dataset, select.label(dataset, "joint", joint or hardest(dataset)))
    peak_panel(peaks, dataset)
    edge_panel(edges, dataset)
    artists.letter((turn, peaks, edges))
    return artists.finish(figure, dataset)


def hardest(dataset: Dataset) -> str | None:
    """Return the joint whose force is largest against the ideal mechanism's; None where none is known."""
    ratio = dataset["force_ratio"].values
    known = np.isfinite(ratio).any()
    return str(dataset["joint"].values[int(np.nanargmax(ratio))]) if known else None


def turn_panel(ax: Axes, dataset: Dataset, joint: str) -> None:
    """Draw the force at a joint over the last turn, and the ideal mechanism's."""
    share = dataset["turn_share"].values
    own, ideal = (dataset[name].sel(joint=joint).values for name in ("joint_force", "ideal_joint_force"))
    artists.curve(ax, share, ideal, color=style.AMBER, linewidth=1.4, label="ideal mechanism")
    artists.curve(ax, share, own, color=style.BLACK, linestyle="-", label="with clearance")
    ax.set(xlabel="Share of a turn", ylabel="Joint force (N)", xlim=(0, 1), ylim=(0, None))
    ax.legend(loc="best")
    artists.heading(ax, f"joint {joint}")


def peak_panel(ax: Axes, dataset: Dataset) -> None:
    """Draw the largest force of each joint with its error, next to the ideal mechanism's."""
    place = np.arange(dataset.sizes["joint"])
    for shift, name, colour in ((-0.2, "ideal_peak_force", style.AMBER), (0.2, "peak_force", style.BLACK)):
        ax.bar(place + shift, dataset[name].values, 0.36, color=colour)
        look = {"fmt": "none", "ecolor": style.GREY, "capsize": 2, "linewidth": 0.8}
        ax.errorbar(place + shift, dataset[name].values, dataset[f"{name}_error"].values, **look)
    tops = dataset["peak_force"].values + dataset["peak_force_error"].fillna(0.0).values
    for i, (top, ratio) in enumerate(zip(tops, dataset["force_ratio"].values, strict=True)):
        if np.isfinite(ratio):
            ax.annotate(
                f"{ratio:.3g}×", (i, top), (0, 3), textcoords="offset points", ha="center", fontsize=7
            )
    ax.set_xticks(place, [str(name) for name in dataset["joint"].values])
    ax.set(xlabel="Joint", ylabel="Largest force (N)")
    ax.margins(y=0.12)


def edge_panel(ax: Axes, dataset: Dataset) -> None:
    """Draw for each parameter the searched range, and the changes of the motion, over the present value."""
    from matplotlib.ticker import FuncFormatter, NullFormatter

    names = [str(name) for name in dataset["parameter_name"].values]
    for i, limits in enumerate(dataset["limit_ratio"].values):
        ax.plot(
            [np.nanmin(limits), np.nanmax(limits)],
            [i, i],
            color=style.GREY,
            linewidth=0.8,
            linestyle="-",
            zorder=1,
        )
    for name, (marker, colour, below, label) in MARKS.items():
        one = dataset.sel(change=name)
        look = {"marker": marker, "color": colour, "linestyle": "none", "markersize": 4, "label": label}
        rows = np.broadcast_to(np.arange(len(names))[:, None] + below, one["edge_ratio"].shape)
        ax.plot(one["edge_ratio"].values.ravel(), rows.ravel(), **look)
    ax.axvline(1.0, color=style.GREY, linewidth=0.8, linestyle=(0, (4, 2)), zorder=0)
    ax.set_xscale("log")
    ax.set_xticks([share for share in SHARES if np.nanmin(dataset["limit_ratio"]) / 1.3 < share])
    ax.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    ax.xaxis.set_minor_formatter(NullFormatter())
    low, high = (f(dataset["limit_ratio"].values) for f in (np.nanmin, np.nanmax))
    ax.set(
        xlim=(low / 1.05, high * 1.05),
        ylim=(len(names) - 0.5, -0.5),
        xlabel="Over the present value",
    )
    ax.set_yticks(range(len(names)), names)
    artists.shared_legend(ax.figure, [ax], len(MARKS))
