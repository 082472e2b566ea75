"""Journal orbit: the path of the journal centre in the clearance circle, in units of the clearance.

A corner of a slider moves in the gap of its guide instead.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from jointplay.display import codes
from jointplay.figures.drawing import Axes, DataArray, Dataset, Figure, artists, select, style, timebase
from jointplay.figures.registry import picture

ORBIT = ("journal_x", "journal_y")


@picture(needs=ORBIT, clearance=True)
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
    part = timebase.last(timebase.window(dataset, turns, time))
    figure = style.sheet(width, min(width, 120.0) + 8)
    ax = figure.subplots()
    orbit_panel(ax, part, joint)
    figure.legend(loc="outside lower center", ncols=3)
    return artists.finish(figure, dataset)


def orbit_panel(ax: Axes, dataset: Dataset, joint: str | None) -> None:
    """Draw the orbit of one joint, all of `dataset`."""
    joint = select.label(dataset, "joint", joint)
    x, y = journal(dataset, joint, "time")
    corner = is_corner(joint)

    def beyond(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """How far points are beyond the clearance circle, or a corner beyond its face, in clearances."""
        return (y if corner else np.hypot(x, y)) - 1.0

    contact = select.in_contact(dataset, joint)
    artists.path(ax, x, y, contact, dataset["time"].values, beyond)
    orbit_frame(ax, dataset, joint, x, y)
    artists.heading(ax, artists.missing_note(x, y, "samples"), select.unseen(dataset, joint, contact))


def journal(dataset: Dataset, joint: str, dim: str) -> tuple[np.ndarray, np.ndarray]:
    """Return where a journal's centre is, in clearances; of a corner, its slide and its way to its face."""
    if not is_corner(joint):
        x, y = (in_clearances(dataset, name, joint, dim) for name in ("journal_x", "journal_y"))
        return x, y
    slide = artists.displayed(along(dataset, joint, dim))[0]
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
    if is_corner(joint):
        reach = np.max(np.abs(y), initial=0.0, where=np.isfinite(y))
        gap_frame(ax, joint, along(dataset, joint, dim), reach)
        return
    distance = np.hypot(x, y)
    artists.clearance_circle(ax, np.max(distance, initial=0.0, where=np.isfinite(distance)))
    which = f" at {joint}" if dataset.sizes["joint"] > 1 else ""
    ax.set_xlabel(f"Journal centre{which}, $r_x/e$")
    ax.set_ylabel(f"Journal centre{which}, $r_y/e$")


def is_corner(joint: str) -> bool:
    """Return whether a contact is a corner of a slider."""
    return codes.contact(joint) != joint


def along(dataset: Dataset, joint: str, dim: str) -> DataArray:
    """Return the slider's position along its guide; the time, or the crossing, where it is not recorded."""
    from xarray import DataArray

    if "slide_position" in dataset and dim in dataset["slide_position"].dims:
        return dataset["slide_position"].sel(joint=joint)
    return dataset["time"] if dim == "time" else DataArray(np.arange(dataset.sizes[dim]), name=dim, dims=dim)


def gap_frame(ax: Axes, joint: str, x: DataArray, reach: float) -> None:
    """Draw the two faces of a guide around the farthest point, at `reach`, and name the axes.

    Across the guide, the way of a slider's corner to its face is in units of the clearance. The face is at 1;
    at -1 is the corner of a slider that lies along the other face.
    """
    half = 1.08 * max(1.0, reach)
    wall = {"facecolor": "white", "edgecolor": style.GREY, "linewidth": 0.0, "hatch": "/////", "zorder": 0}
    ax.axhspan(-1.0, 1.0, facecolor=style.DISC, linewidth=0.0, zorder=0, label="gap of the guide")
    ax.axhspan(1.0, 2 * half, **wall)
    for face in (1.0, -1.0):
        ax.axhline(face, color=style.GREY, linewidth=0.6, linestyle="-", zorder=0.5)
    unit = artists.displayed(x)[1]
    ax.set(ylim=(-half, half), box_aspect=1)
    ax.set_xlabel(artists.axis_label(x, unit))
    ax.set_ylabel(f"Distance of {codes.contact(joint)}\nto its face, over $e$ (\N{EN DASH})")
