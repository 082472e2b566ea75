"""Basins: which attractor each start of a plane reaches, the attractors' own points, and their shares.

Field: finite-time Lyapunov exponents over a plane of initial states.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from jointplay.display import codes
from jointplay.display.errors import Problem
from jointplay.display.number_text import shown, with_error
from jointplay.figures.drawing import Axes, DataArray, Dataset, Figure, Patch, artists, select, style
from jointplay.figures.registry import picture

# eight lightnesses, no two alike, neighbours far apart: a grey print tells them
COLOURS = ("#a9d9f2", "#b02a2a", "#fdf3c7", "#3f7fc4", "#06280f", "#78ac52", "#4d1f7a", "#f3a552")
REST, NONE = "#bdbdbd", "#ffffff"
POINTS = 60  # of an attractor that are marked, at most

PER = {"turn": "finite_time_exponent_per_turn", "second": "finite_time_exponent"}
SHADES = "cividis"
CIRCLE = {"eccentricity_ratio_x", "eccentricity_ratio_y"}
OUTER = 0.01, 0.99  # quantiles of the exponents between which colours differ


@picture()
def basins(dataset: Dataset, *, points: bool = True) -> Figure:
    """Draw a colour for each attractor over the plane, with its section points and its share of the starts.

    Parameters
    ----------
    dataset : Dataset
        What `jointplay.basins` returned.
    points : bool
        Whether to mark the attractors' section points.
    """
    from matplotlib.colors import BoundaryNorm, ListedColormap

    select.switch("points", points)
    select.require(dataset, "basins", ("attractor", "section_plane"))
    shown = largest(dataset)
    entries = legend(dataset, shown)
    figure = style.sheet(88.0, 76.0 + 4.2 * len(entries))
    ax = figure.subplots()
    places = {number: place for place, number in enumerate(shown, start=1)}
    labels = dataset["attractor"].astype(float)
    coloured = [places.get(int(v), len(COLOURS) + 1 if v else 0) for v in labels.values.ravel()]
    colours = ListedColormap([NONE, *COLOURS, REST])
    norm = BoundaryNorm(np.arange(-0.5, len(COLOURS) + 2), colours.N)
    draw_cells(ax, labels.copy(data=np.reshape(coloured, labels.shape)), cmap=colours, norm=norm)
    if points:
        mark(ax, dataset, shown)
    ax.set_title(boundary(dataset), loc="left")
    figure.legend(handles=entries, loc="outside lower left")
    return artists.finish(figure, dataset)


def largest(dataset: Dataset) -> list[int]:
    """Return the numbers of the attractors with colours of their own, ascending."""
    counts = dataset["count"].values
    order = np.argsort(-counts, kind="stable")[: len(COLOURS)]
    return sorted(int(dataset["number"].values[i]) for i in order if counts[i])


def legend(dataset: Dataset, shown: list[int]) -> list[Patch]:
    """Return an entry an attractor: period, share with its standard error."""
    entries = []
    for colour, number in zip(COLOURS, shown, strict=False):
        one = dataset.sel(number=number)
        period = int(one["period"])
        kind = f"period {period}" if period else "no period"
        share, error = 100 * float(one["fraction"]), 100 * float(one["fraction_standard_error"])
        entries.append(artists.swatch(color=colour, label=f"{number}: {kind}, {share:.1f} ± {error:.1f} %"))
    rest = int(np.sum(dataset["count"].values > 0)) - len(shown)
    if rest:
        entries.append(artists.swatch(color=REST, label=f"{rest} more"))
    none = 100 * float(dataset["fraction_none"])
    if none > 0:
        words = without_start(dataset)
        label = f"none ({words})" if words else f"none, {none:.1f} %"
        entries.append(artists.swatch(facecolor=NONE, edgecolor=style.GREY, label=label))
    return entries


def mark(ax: Axes, dataset: Dataset, shown: list[int]) -> None:
    """Mark section points of the attractors, each in its colour within a dark and a white ring."""
    factors = [artists.displayed(dataset[dim])[1].factor for dim in dataset["attractor"].dims]
    limits = ax.get_xlim(), ax.get_ylim()
    for colour, number in zip(COLOURS, shown, strict=False):
        points = dataset["section_plane"].sel(number=number).transpose("point", "axis").values
        x, y = (points[~np.isnan(points[:, 0])][:POINTS] * factors).T
        size = 4.5 if x.size <= 12 else 2.2
        look = {"linestyle": "none", "marker": "o", "clip_on": True}
        ax.plot(x, y, markersize=size + 1.6, color="black", markeredgewidth=0, **look)
        ax.plot(x, y, markersize=size, color=colour, markeredgecolor="white", markeredgewidth=0.6, **look)
    ax.set(xlim=limits[0], ylim=limits[1])


def boundary(dataset: Dataset) -> str:
    """Return the boundary's dimension with its error; empty where it is not known."""
    if "boundary_dimension" not in dataset or not np.isfinite(float(dataset["boundary_dimension"])):
        return ""
    error = float(dataset["uncertainty_exponent_standard_error"])
    return f"Boundary's dimension {with_error(float(dataset['boundary_dimension']), error)}"


def fits(_: Any, settings: Mapping[str, Any]) -> Iterator[Problem]:
    """Yield the problem of a study without a plane."""
    if "plane" not in settings:
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
    mesh = draw_cells(ax, exponents, cmap=SHADES, vmin=low, vmax=high)
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
