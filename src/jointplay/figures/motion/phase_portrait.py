"""Phase portrait: one variable over another."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from jointplay.figures.drawing import artists, select, style, timebase, window_panels
from jointplay.figures.registry import picture

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from xarray import DataArray, Dataset

DEFAULTS = ("eccentricity", "normal_velocity")
ON_A_LINK = ("angle", "angular_velocity")
PAIRS = (DEFAULTS, ON_A_LINK)


@picture(pair=True)
def phase_portrait(
    dataset: Dataset,
    *,
    x: str | None = None,
    y: str | None = None,
    link: str | None = None,
    joint: str | None = None,
    turns: float | Sequence[float] | None = None,
    time: Sequence[float] | None = None,
    column: str = "single",
) -> Figure:
    """Draw one variable of a response over another.

    Of several recorded windows, the last that holds some of the asked turns or time is drawn.

    Parameters
    ----------
    dataset : Dataset
        A response.
    x, y : str, optional
        The variables; states of a test system by their labels. By default eccentricity and normal velocity
        of a clearance joint, the first two states of a test system, angle and angular velocity of a link.
    link, joint : str, optional
        Of which link or joint; by default the first.
    turns, time, column
        As in `time_history`.
    """
    width = style.COLUMNS[select.choice("column", column, style.COLUMNS)]
    part = window_panels.last(timebase.window(dataset, turns, time))
    figure = style.sheet(width, 0.45 * width + 36)
    ax = figure.subplots()
    portrait_panel(ax, part, x, y, link, joint)
    if ax.get_legend_handles_labels()[1]:
        figure.legend(loc="outside lower center", ncols=3)
    return artists.finish(figure, dataset)


def portrait_panel(ax: Axes, dataset: Dataset, x: str | None, y: str | None, link=None, joint=None) -> None:
    """Draw the portrait of all of `dataset`; for a joint, contact differs from free flight."""
    one, two = pair(dataset, x, y, "time", link, joint)
    (xs, x_unit), (ys, y_unit) = artists.displayed(one), artists.displayed(two)
    at = of_joint(one, two)
    contact = select.in_contact(dataset, at) if at else None
    if at and contact is not None:
        edge = bearing_edge(dataset, one)
        touches = None if edge is None else lambda x, _: x - edge * x_unit.factor
        artists.path(ax, xs, ys, contact, one["time"].values, touches)
    else:
        artists.curve(ax, xs, ys, color=style.BLACK, linewidth=0.6)
    if xs.size:
        clearance_line(ax, dataset, one, x_unit.factor)
    artists.name_axes(ax, one, x_unit, two, y_unit)
    artists.heading(ax, artists.missing_note(xs, ys, "samples"))


def pair(dataset: Dataset, x, y, dim: str, link, joint) -> tuple[DataArray, DataArray]:
    """Return the two variables that are drawn over each other, along `dim`."""
    usual = (x, y) if x and y else usual_pair(dataset, dim)
    named = zip((x, y), usual, "xy", strict=True)
    return tuple(select.curve(dataset, n or u, option, dim, link=link, joint=joint) for n, u, option in named)


def usual_pair(dataset: Dataset, dim: str) -> tuple[str, str]:
    """Return the pair of variables that is drawn where none is named."""
    names = select.names(dataset, dim)
    states = select.labels(dataset, "state")
    clearance = bool(select.labels(dataset, "joint"))
    for usual in (DEFAULTS, tuple(states[:2]), ON_A_LINK):
        if len(usual) == 2 and set(names).issuperset(usual) and (clearance or usual != DEFAULTS):
            return usual
    raise select.refuse("x", None, "two of: " + ", ".join(names))


def of_joint(*arrays: DataArray) -> str | None:
    """Return the joint that all the curves belong to."""
    joints = {str(array["joint"].values) if "joint" in array.coords else None for array in arrays}
    return joints.pop() if len(joints) == 1 else None


def bearing_edge(dataset: Dataset, x: DataArray) -> float | None:
    """Return where on the x axis, m, the journal meets the bearing; None if that is not the eccentricity."""
    if str(x.name).removeprefix("section_") != "eccentricity" or "clearance" not in dataset:
        return None
    return float(dataset["clearance"].sel(joint=x["joint"]))


def clearance_line(ax: Axes, dataset: Dataset, x: DataArray, factor: float) -> None:
    """Mark where the journal meets the bearing, if the x axis is the eccentricity."""
    if (edge := bearing_edge(dataset, x)) is not None:
        look = {"color": style.GREY, "linewidth": 0.6, "linestyle": (0, (6, 2)), "zorder": 0}
        ax.axvline(edge * factor, **look, label="clearance $e$")
