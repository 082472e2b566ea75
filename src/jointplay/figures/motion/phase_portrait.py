"""Phase portrait: one variable over another.

Poincaré section: the points at which the motion crosses a section.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from jointplay.display.number_text import plain
from jointplay.figures.drawing import Axes, DataArray, Dataset, Figure, artists, select, style, timebase
from jointplay.figures.motion.journal_orbit import journal, orbit_frame
from jointplay.figures.registry import picture

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
    part = timebase.last(timebase.window(dataset, turns, time))
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
    edge = bearing_edge(dataset, one)
    if at and contact is not None:
        touches = None if edge is None else lambda x, _: x - edge * x_unit.factor
        artists.path(ax, xs, ys, contact, one["time"].values, touches)
    else:
        artists.curve(ax, xs, ys, color=style.BLACK, linewidth=0.6)
    if xs.size and edge is not None:
        look = {"color": style.GREY, "linewidth": 0.6, "linestyle": (0, (6, 2)), "zorder": 0}
        ax.axvline(edge * x_unit.factor, **look, label="clearance $e$")
    artists.name_axes(ax, one, x_unit, two, y_unit)
    artists.heading(ax, artists.missing_note(xs, ys, "samples"), select.unseen(dataset, at, contact))


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


@picture(pair=True)
def poincare_section(
    dataset: Dataset,
    *,
    x: str | None = None,
    y: str | None = None,
    link: str | None = None,
    joint: str | None = None,
    turns: float | Sequence[float] | None = None,
    zoom: bool = False,
    xlim: Sequence[float] | None = None,
    ylim: Sequence[float] | None = None,
) -> Figure:
    """Draw the points of a section: the journal in its clearance circle, and one variable over another.

    Parameters
    ----------
    dataset : Dataset
        A section, or a response that kept one.
    x, y : str, optional
        The variables of the second panel, for instance "contact_angle" and "tangential_velocity"; by default
        eccentricity (beside other results over the clearance) and normal velocity. A test system has this
        panel only, by default its first two states.
    link, joint : str, optional
        Of which link or joint; by default the first.
    turns : float or pair, optional
        The last so many crossings, or [first, last] counted from 0; by default all.
    zoom : bool
        Cut the first panel down to the points, instead of showing the whole clearance circle.
    xlim, ylim : pair, optional
        Lowest and highest value of the second panel's variables, in SI units; by default around the points.
    """
    from matplotlib.figure import SubFigure

    select.switch("zoom", zoom)
    part = crossings(dataset, turns)
    there = {"journal_x", "journal_y"} <= set(select.names(dataset, "turn"))
    orbit = there and bool(select.labels(dataset, "joint"))
    figure = style.sheet(180.0 if orbit else 88.0, 88.0)
    upright = isinstance(figure, SubFigure) and figure.bbox.height > figure.bbox.width
    count = 2 if orbit else 1
    axes = figure.subplots(*((count, 1) if upright else (1, count)), squeeze=False).ravel()
    if orbit:
        journal_points(axes[0], part, joint, zoom, counted(part))
    text = "" if orbit else counted(part)
    one = orbit and repeated(part, select.label(part, "joint", joint))[0] == 1
    variable_points(axes[-1], part, x, y, link, joint, text, one, (xlim, ylim))
    artists.letter(axes)
    return artists.finish(figure, dataset)


def crossings(dataset: Dataset, turns) -> Dataset:
    """Return the crossings inside a window; a dataset without a section is an error."""
    expected = "a result with a section: a study of kind section has one"
    select.require(dataset, "poincare_section", ["turn"], expected)
    count = dataset.sizes["turn"]
    if turns is None or not count:
        return dataset
    expected = "a number of crossings greater than 0, or [first, last]"
    if isinstance(turns, list | tuple):
        first, last = select.numbers("turns", turns, 2, expected)
    else:
        (wanted,) = select.numbers("turns", turns, 1, expected)
        first, last = count - wanted, count - 1
    part = dataset.isel(turn=slice(max(int(np.ceil(first)), 0), max(int(last) + 1, 0)))
    if not part.sizes["turn"]:
        raise select.refuse("turns", turns, f"{expected}, among the {count} that there are, counted from 0")
    return part


def journal_points(ax: Axes, dataset: Dataset, joint: str | None, zoom: bool, count: str) -> None:
    """Draw where the journal centre is at the crossings, in units of the clearance."""
    joint = select.label(dataset, "joint", joint)
    x, y = journal(dataset, joint, "turn")
    artists.cloud(ax, x, y)
    orbit_frame(ax, dataset, joint, x, y, "turn")
    if zoom and x.size:
        ax.set(aspect="auto", box_aspect=1)
        artists.roomy(ax, x, y)
    explain(ax, x, y, words(*repeated(dataset, joint), count))


def repeated(dataset: Dataset, joint: str) -> tuple[int, float]:
    """Return the period of a journal at the crossings, and its misfit, in clearances."""
    return artists.returning(np.stack(journal(dataset, joint, "turn"), -1))


def words(period: int, missed: float, count: str) -> str:
    """Return the number of points, of periodic ones with their scatter."""
    if not period:
        return count
    within = f"within {plain(max(missed, 1e-16), 1)} $e$".replace(" ", "\N{NO-BREAK SPACE}")
    return f"{count}: period\N{NO-BREAK SPACE}{period}, {within if missed else 'all the same'}"


def variable_points(
    ax: Axes,
    dataset: Dataset,
    x,
    y,
    link=None,
    joint=None,
    count="",
    single=False,
    ends: Sequence[Sequence[float] | None] = (None, None),
) -> None:
    """Draw one variable over another at the crossings; `single` where they are one point but for rounding."""
    one, two = pair(dataset, x, y, "turn", link, joint)
    if x is None and style.same_sheet():
        one = over_clearance(dataset, one)
    (xs, x_unit), (ys, y_unit) = artists.displayed(one), artists.displayed(two)
    artists.cloud(ax, xs, ys)
    artists.roomy(ax, xs, ys, single)
    for axis, limits, unit in zip("xy", ends, (x_unit, y_unit), strict=True):
        if limits is not None and not style.same_sheet():  # on a sheet the axes of all are one
            low, high = select.numbers(f"{axis}lim", limits, 2, "two increasing numbers")
            getattr(ax, f"set_{axis}lim")(low * unit.factor, high * unit.factor)
    artists.name_axes(ax, one, x_unit, two, y_unit)
    ax.set_box_aspect(1)
    explain(ax, xs, ys, count)


def over_clearance(dataset: Dataset, one: DataArray) -> DataArray:
    """Return the eccentricity over the clearance: results of different clearances have its axis in common."""
    edge = bearing_edge(dataset, one)
    attrs = {"units": "1", "long_name": "eccentricity over clearance"}
    return (one / edge).rename("eccentricity_ratio").assign_attrs(attrs) if edge else one


def explain(ax: Axes, x: np.ndarray, y: np.ndarray, count: str) -> None:
    """Write the number of points, or of missing ones."""
    if not x.size:
        artists.say(ax, "The run never crossed the section")
    artists.heading(ax, artists.missing_note(x, y, "crossings") or count)


def counted(dataset: Dataset) -> str:
    """Return the number of points in words."""
    count = dataset.sizes["turn"]
    return f"{count} crossing" + "s" * (count != 1)
