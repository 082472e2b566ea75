"""Journal orbit: the path of the journal centre in the clearance circle, in units of the clearance."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from xarray import DataArray, Dataset

from jointplay.figures.drawing import artists, select, style, timebase, window_panels
from jointplay.figures.registry import picture


@picture(needs=("journal_x", "journal_y"), clearance=True)
def journal_orbit(
    dataset: Dataset,
    *,
    joint: str | None = None,
    turns: float | Sequence[float] | None = None,
    time: Sequence[float] | None = None,
    column: str = "single",
) -> Figure:
    """Draw the path of a journal centre relative to its bearing, distinguishing contact from free flight.

    Of several recorded windows, the last that holds some of the asked turns or time is drawn.

    Parameters
    ----------
    dataset : Dataset
        A response with `journal_x`, `journal_y` and `clearance`.
    joint : str, optional
        The joint; by default the first with clearance.
    turns, time, column
        As in `time_history`.
    """
    width = style.COLUMNS[select.choice("column", column, style.COLUMNS)]
    part = window_panels.last(timebase.window(dataset, turns, time))
    figure = style.sheet(width, min(width, 120.0) + 8)
    ax = figure.subplots()
    orbit_panel(ax, part, joint)
    figure.legend(loc="outside lower center", ncols=3)
    return artists.finish(figure, dataset)


def orbit_panel(ax: Axes, dataset: Dataset, joint: str | None, *titles: str) -> None:
    """Draw the orbit of one joint, all of `dataset`."""
    joint = select.label(dataset, "joint", joint)
    x, y = (in_clearances(dataset, name, joint, "time") for name in ("journal_x", "journal_y"))
    artists.path(ax, x, y, select.in_contact(dataset, joint), dataset["time"].values, outside)
    orbit_frame(ax, dataset, joint, x, y)
    artists.heading(ax, *titles, artists.missing_note(x, y, "samples"))


def outside(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return which points, in clearances, lie beyond the clearance circle."""
    return np.hypot(x, y) > 1.0


def in_clearances(dataset: Dataset, name: str, joint: str, dim: str) -> np.ndarray:
    """Return a journal coordinate in units of the clearance."""
    array: DataArray = select.curve(dataset, name, "variables", dim, joint=joint)
    if "clearance" not in dataset:
        raise select.refuse("kind", dataset.attrs.get("kind"), "a result that holds the variable clearance")
    return array.values / float(dataset["clearance"].sel(joint=joint))


def orbit_frame(ax: Axes, dataset: Dataset, joint: str, x: np.ndarray, y: np.ndarray) -> None:
    """Draw the clearance circle around the points and name the axes."""
    distance = np.hypot(x, y)
    artists.clearance_circle(ax, np.max(distance, initial=0.0, where=np.isfinite(distance)))
    which = f" at {joint}" if dataset.sizes["joint"] > 1 else ""
    ax.set_xlabel(f"Journal centre{which}, $r_x/e$")
    ax.set_ylabel(f"Journal centre{which}, $r_y/e$")
