"""Phase portrait: one variable over another."""

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from xarray import DataArray, Dataset

from jointplay.figures.drawing import parts, pick, style, timebase, window_panels
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

    Parameters
    ----------
    dataset : Dataset
        A response.
    x, y : str, optional
        The variables; states of a test system by their labels. By default eccentricity and normal velocity
        of a clearance joint, the first two states of a test system, angle and angular velocity of a link.
    link, joint : str, optional
        Of which link or joint; by default the first.
    turns : float or pair, optional
        The last so many turns, or [first, last]; by default everything. Of several recorded windows, the last
        that holds some of it is drawn.
    time : pair, optional
        A window in s, instead of `turns`.
    column : {"single", "double"}
        Width of the figure: 88 mm or 180 mm.

    Returns
    -------
    Figure
    """
    width = style.COLUMNS[pick.choice("column", column, style.COLUMNS)]
    part = window_panels.last(timebase.window(dataset, turns, time))
    figure = style.sheet(width, 0.45 * width + 36)
    ax = figure.subplots()
    portrait_panel(ax, part, x, y, link, joint)
    if ax.get_legend_handles_labels()[1]:
        figure.legend(loc="outside lower center", ncols=3)
    return parts.finish(figure, dataset)


def portrait_panel(
    ax: Axes, dataset: Dataset, x: str | None, y: str | None, link=None, joint=None, titles=()
) -> None:
    """Draw the portrait of all of `dataset`; one of a joint tells contact from free flight."""
    first, second = (x, y) if x and y else usual_pair(dataset, "time")
    one = pick.curve(dataset, x or first, "x", link=link, joint=joint)
    two = pick.curve(dataset, y or second, "y", link=link, joint=joint)
    (xs, x_unit), (ys, y_unit) = parts.displayed(one), parts.displayed(two)
    at = of_joint(one, two)
    contact = pick.in_contact(dataset, at) if at else None
    if at and contact is not None:
        parts.path(ax, xs, ys, contact)
    else:
        parts.curve(ax, xs, ys, color=style.BLACK, linewidth=0.6)
    if xs.size:
        clearance_line(ax, dataset, one, x_unit.factor)
    parts.name_axes(ax, one, x_unit, two, y_unit)
    parts.heading(ax, *titles, parts.missing_note(xs, ys, "samples"))


def usual_pair(dataset: Dataset, dim: str) -> tuple[str, str]:
    """Return the pair of variables that is drawn where none is named."""
    names = pick.names(dataset, dim)
    states = pick.labels(dataset, "state")
    for pair in (DEFAULTS, tuple(states[:2]), ON_A_LINK):
        if len(pair) == 2 and set(names).issuperset(pair) and has_labels(dataset, pair):
            return pair
    raise pick.refuse("x", None, "two of: " + ", ".join(names))


def has_labels(dataset: Dataset, pair: tuple[str, str]) -> bool:
    """Tell whether both variables have somewhere to be taken at: a mechanism may have no clearance joint."""
    return not (pair == DEFAULTS and not pick.labels(dataset, "joint"))


def of_joint(*arrays: DataArray) -> str | None:
    """Return the joint that all the curves belong to."""
    joints = {str(array["joint"].values) if "joint" in array.coords else None for array in arrays}
    return joints.pop() if len(joints) == 1 else None


def clearance_line(ax: Axes, dataset: Dataset, x: DataArray, factor: float) -> None:
    """Mark where the journal meets the bearing, if the x axis is the eccentricity."""
    if str(x.name).removeprefix("section_") == "eccentricity" and "clearance" in dataset:
        edge = float(dataset["clearance"].sel(joint=x["joint"])) * factor
        ax.axvline(
            edge, color=style.GREY, linewidth=0.6, linestyle=(0, (6, 2)), zorder=0, label="clearance $e$"
        )
