"""Field: finite-time Lyapunov exponents over a plane of initial states."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from jointplay.display import codes
from jointplay.display.errors import Problem
from jointplay.display.units import shown
from jointplay.figures.drawing import artists, select, style
from jointplay.figures.registry import picture

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from xarray import DataArray, Dataset

PER = {"turn": "finite_time_exponent_per_turn", "second": "finite_time_exponent"}
COLOURS = "cividis"
CIRCLE = {"eccentricity_ratio_x", "eccentricity_ratio_y"}
OUTER = 0.01, 0.99  # quantiles of the exponents between which colours differ


def fits(_: Any, asked: Mapping[str, Any]) -> Iterator[Problem]:
    """Yield the problem of a study without a plane."""
    if "plane" not in asked:
        yield Problem("figure.kind", "field", "it is accepted where analysis.plane is given")


@picture(needs=("finite_time_exponent",), choices={"per": PER}, fits=fits)
def field(dataset: Dataset, *, per: str = "turn") -> Figure:
    """Draw exponents as colours over the plane.

    Parameters
    ----------
    dataset : Dataset
        What `jointplay.sensitivity` returned, with a plane.
    per : {"turn", "second"}
        Exponents a turn, or in 1/s.
    """
    name = PER[select.choice("per", per, PER)]
    select.require(dataset, "field", [name], "a result of a study of kind sensitivity, with a plane")
    figure = style.sheet(88.0, 78.0)
    ax = figure.subplots()
    exponents = dataset[name]
    low, high = limits(exponents.values)
    mesh = draw_cells(ax, exponents, cmap=COLOURS, vmin=low, vmax=high)
    turns = int(dataset["field_turns"])
    unit = shown(exponents.values, str(exponents.attrs["units"])).symbol
    per_turn = " per turn" if per == "turn" else ""
    bar = figure.colorbar(mesh, ax=ax, extend="both", pad=0.02)
    over = f"over {turns} turn" + "s" * (turns != 1)
    bar.set_label(artists.with_unit(f"Exponent{per_turn}, {over}", unit))
    if low < 0 < high:
        bar.ax.axhline(0.0, color=style.AMBER, linewidth=1.0)
    artists.heading(ax, without_start(dataset))
    return artists.finish(figure, dataset)


def limits(values: np.ndarray) -> tuple[float, float]:
    """Return the range of the colours: nearly all values, the farthest left out."""
    there = values[np.isfinite(values)]
    if not there.size:
        return 0.0, 1.0
    low, high = np.quantile(there, OUTER)
    return float(low), float(high if high > low else low + 1e-12)


def draw_cells(ax: Axes, array: DataArray, **look):
    """Draw a cell a node over a plane's two coordinates, its first along x; name the axes."""
    from matplotlib.patches import Circle

    first, second = array.dims
    (xs, x_unit), (ys, y_unit) = (artists.displayed(array[dim]) for dim in (first, second))
    numbers = array.transpose(second, first).values.astype(float)
    values = np.ma.array(numbers, mask=~np.isfinite(numbers))
    mesh = ax.pcolormesh(xs, ys, values, shading="nearest", rasterized=True, **look)
    artists.name_axes(ax, array[first], x_unit, array[second], y_unit)
    if {first, second} == CIRCLE:
        rim = ax.add_patch(Circle((0, 0), 1, facecolor="none", edgecolor=style.GREY, linewidth=0.8))
        if np.hypot(*np.meshgrid(xs, ys))[~values.mask].max(initial=0.0) <= 1.0:
            mesh.set_clip_path(rim)  # cells of starts inside it
        ax.set_aspect("equal")
    return mesh


def without_start(dataset: Dataset) -> str:
    """Return a note on the number of nodes without a value though a motion starts there; empty if none."""
    meanings = codes.flags(dataset["node_status"])
    status = dataset["node_status"].values
    words = [(meanings.get(int(code), "?"), int(np.sum(status == code))) for code in np.unique(status)]
    return ", ".join(f"{word}: {count}" for word, count in words if word not in ("ok", "bad_parameters"))
