"""Journal orbit: the path of the journal centre in the clearance circle, in units of the clearance.

A corner of a slider moves in the gap of its guide instead.
"""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from xarray import DataArray, Dataset

from jointplay.figures.drawing import artists, select, style, timebase, window_panels
from jointplay.figures.motion import guide_gap
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


def orbit_panel(ax: Axes, dataset: Dataset, joint: str | None) -> None:
    """Draw the orbit of one joint, all of `dataset`."""
    joint = select.label(dataset, "joint", joint)
    x, y = journal(dataset, joint, "time")
    beyond = beyond_face if guide_gap.is_corner(joint) else outside
    artists.path(ax, x, y, select.in_contact(dataset, joint), dataset["time"].values, beyond)
    orbit_frame(ax, dataset, joint, x, y)
    artists.heading(ax, artists.missing_note(x, y, "samples"))


def outside(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return which points, in clearances, lie beyond the clearance circle."""
    return np.hypot(x, y) > 1.0


def beyond_face(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return which ways of a corner end beyond its face."""
    return y > 1.0


def journal(dataset: Dataset, joint: str, dim: str) -> tuple[np.ndarray, np.ndarray]:
    """Return where a journal's centre is, in clearances; of a corner, its slide and its way to its face."""
    if not guide_gap.is_corner(joint):
        x, y = (in_clearances(dataset, name, joint, dim) for name in ("journal_x", "journal_y"))
        return x, y
    slide = artists.displayed(guide_gap.along(dataset, joint, dim))[0]
    return slide, in_clearances(dataset, "eccentricity", joint, dim)


def in_clearances(dataset: Dataset, name: str, joint: str, dim: str) -> np.ndarray:
    """Return a journal coordinate in units of the clearance."""
    array: DataArray = select.curve(dataset, name, "variables", dim, joint=joint)
    if "clearance" not in dataset:
        raise select.refuse("kind", dataset.attrs.get("kind"), "a result that holds the variable clearance")
    return array.values / float(dataset["clearance"].sel(joint=joint))


def orbit_frame(
    ax: Axes, dataset: Dataset, joint: str, x: np.ndarray, y: np.ndarray, dim: str = "time"
) -> None:
    """Draw the clearance circle around the points, or the gap of a guide, and name the axes."""
    if guide_gap.is_corner(joint):
        reach = np.max(np.abs(y), initial=0.0, where=np.isfinite(y))
        guide_gap.gap_frame(ax, joint, guide_gap.along(dataset, joint, dim), reach)
        return
    distance = np.hypot(x, y)
    artists.clearance_circle(ax, np.max(distance, initial=0.0, where=np.isfinite(distance)))
    which = f" at {joint}" if dataset.sizes["joint"] > 1 else ""
    ax.set_xlabel(f"Journal centre{which}, $r_x/e$")
    ax.set_ylabel(f"Journal centre{which}, $r_y/e$")
