"""Attractors over a parameter: points in a colour for each motion, exponents, fractions as bands.

Motions that have no period anywhere share one colour: a window or one unsettled value parts a chaotic motion
into several numbers, and nothing tells whether it is the same one on both sides.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from jointplay.display.number_text import Shown
from jointplay.figures.analyses.bifurcation import ERRORS, SIZES, sought
from jointplay.figures.drawing import (
    Axes,
    DataArray,
    Dataset,
    Figure,
    Line2D,
    Patch,
    artists,
    select,
    style,
    sweep_axes,
)
from jointplay.figures.registry import picture

# dark and light in turn, and a pattern for each two: a grey print tells them
COLOURS = (style.BLUE, style.AMBER, "#5b0f0f", "#56b4e9", "#007a53", "#cc79a7", "#3b1f6b", "#9a9a3c")
CHAOS, REST = style.BLACK, "#bdbdbd"
UNSETTLED = {"facecolor": style.DISC, "edgecolor": style.GREY, "hatch": "////", "linewidth": 0.0}
PATTERNS, SIGNS = (None, "\\\\\\\\", "......", "xxxxx"), "o^sD"
TITLE = "Motions, and the periods that each has somewhere along the parameter"
NAMED = 4  # periods of a motion in the legend
ROWS = {"points": 2.0, "exponents": 1.0, "fractions": 1.0}


@picture(least=120)
def attractors(
    dataset: Dataset, *, quantity: str | None = None, link: str | None = None, joint: str | None = None
) -> Figure:
    """Draw section points over the parameter, a colour for each motion; below, exponents and fractions.

    Where no motion was found, only fractions are there to be drawn.

    Parameters
    ----------
    dataset : Dataset
        What `jointplay.attractors` returned.
    quantity : str, optional
        The recorded quantity, or a test system's state by its name.
    link, joint : str, optional
        Of which link or joint; by default the first.
    """
    select.require(dataset, "attractors", ("fraction", "fraction_unsettled"))
    colours, (name, _) = coloured(dataset), dataset["fraction"].dims
    found = dataset.sizes["identity"] > 0
    exponential = found and sweep_axes.exponents(dataset) is not None
    panels = [*["points"] * found, *["exponents"] * exponential, "fractions"]
    figure = style.sheet(180.0, 46.0 + 32.0 * len(panels))
    axes = figure.subplots(
        len(panels), 1, sharex=True, squeeze=False, height_ratios=[ROWS[p] for p in panels]
    )
    axes = dict(zip(panels, axes[:, 0], strict=True))
    unit = sweep_axes.parameter_axis(axes["fractions"], dataset[name])
    if found:
        array = sought(dataset, quantity)
        array = select.labelled_slice(array, dataset, (name, "identity", "point"), link=link, joint=joint)
        points(axes["points"], array, dataset[name], unit, colours)
    if exponential:
        exponents(axes["exponents"], dataset, name, unit, colours)
    fractions(axes["fractions"], dataset, name, unit, colours)
    artists.letter(axes.values())
    explain(figure, dataset, colours)
    return artists.finish(figure, dataset)


def coloured(dataset: Dataset) -> dict[int, str]:
    """Return the colour of each motion: one for all without a period, others by the size of their shares."""
    dim, numbers = dataset["fraction"].dims[0], dataset["identity"].values
    total = dataset["fraction"].fillna(0.0).sum(dim).values
    periodic = (dataset["period"] > 0).any(dim).values
    order = [i for i in np.argsort(-total, kind="stable") if periodic[i]][: len(COLOURS)]
    own = dict(zip(sorted(numbers[order].tolist()), COLOURS, strict=False))
    known = zip(numbers.tolist(), periodic, strict=True)
    return {number: own.get(number, REST) if has else CHAOS for number, has in known}


def band(place: int) -> dict[str, Any]:
    """Return the style of an area of the motion with the colour of this place."""
    return area(COLOURS[place] if place < len(COLOURS) else REST)


def area(colour: str) -> dict[str, Any]:
    """Return the style of an area of motions with this colour."""
    pattern = PATTERNS[COLOURS.index(colour) // 2] if colour in COLOURS else None
    return {"facecolor": colour, "edgecolor": "white", "hatch": pattern, "linewidth": 0.0}


def sign(colour: str) -> str:
    """Return the marker of the points of motions with this colour."""
    return SIGNS[COLOURS.index(colour) // 2 % len(SIGNS)] if colour in COLOURS else SIGNS[0]


def points(ax: Axes, array: DataArray, axis: DataArray, unit: Shown, colours: dict[int, str]) -> None:
    """Draw section points of every motion."""
    _, y_unit = artists.displayed(array)
    size = float(np.interp(np.count_nonzero(np.isfinite(array.values)), SIZES[0], SIZES[1]))
    for number, colour in colours.items():
        y = array.sel(identity=number).transpose(axis.name, "point").values * y_unit.factor
        x = np.broadcast_to((axis.values * unit.factor)[:, None], y.shape)
        look = {"color": colour, "markersize": size, "markeredgewidth": 0, "rasterized": True}
        ax.plot(x[np.isfinite(y)], y[np.isfinite(y)], sign(colour), linestyle="none", **look)
    artists.name_y(ax, array, y_unit, longest=30)


def exponents(ax: Axes, dataset: Dataset, name: str, unit: Shown, colours: dict[int, str]) -> None:
    """Draw the largest exponent of every motion, with its error band where it has no period."""
    means, errors = (each.isel(number=0) for each in sweep_axes.exponents(dataset))
    x = dataset[name].values * unit.factor
    ax.axhline(0.0, color=style.GREY, linewidth=0.6)
    for number, colour in colours.items():
        y, error = means.sel(identity=number).values, ERRORS * errors.sel(identity=number).values
        periodic = dataset["period"].sel(identity=number).values > 0
        error = np.where(periodic, 0.0, error)  # there the standard error exaggerates
        if colour == REST:  # several motions: no line joins them
            ax.plot(x, y, "o", color=colour, markersize=2.0)
        else:
            artists.curve(ax, x, y, color=colour, linestyle="-")
        ax.fill_between(x, y - error, y + error, color=colour, alpha=0.25, linewidth=0)
    ax.set_ylabel("Largest exponent\nper turn")


def fractions(ax: Axes, dataset: Dataset, name: str, unit: Shown, colours: dict[int, str]) -> None:
    """Draw fractions of the starts as bands, one on the other; on top the starts that did not settle."""
    x = sweep_axes.edges(dataset[name].values * unit.factor)
    shares = dataset["fraction"].transpose("identity", name).fillna(0.0).values
    rows = [*zip(shares, map(area, colours.values()), strict=True)]
    rows.append((dataset["fraction_unsettled"].fillna(0.0).values, UNSETTLED))
    below = np.zeros(len(x) - 1)
    for share, look in rows:
        sides = (np.append(each, each[-1]) for each in (below, below + share))
        ax.fill_between(x, *sides, step="post", **look)
        below = below + share
    ax.set(ylim=(0, 1), xlim=x[[0, -1]], ylabel="Fraction of\nthe starts")


def explain(figure: Figure, dataset: Dataset, colours: dict[int, str]) -> None:
    """Name each motion below the panels by the periods that it has, with its band and its points."""
    from matplotlib.legend_handler import HandlerTuple

    entries: dict[str, Any] = {}
    for number, colour in colours.items():
        if colour not in (REST, CHAOS):
            found = np.unique(dataset["period"].sel(identity=number).values)
            periods = [str(p) for p in found if p > 0]
            periods = [*periods[:NAMED], *["\N{HORIZONTAL ELLIPSIS}"] * (len(periods) > NAMED)]
            none = " or none" * (0 in found)
            entries[f"{number}: period {', '.join(periods)}{none}"] = both(colour)
    if CHAOS in colours.values():
        entries["no period"] = both(CHAOS)
    if rest := sum(colour == REST for colour in colours.values()):
        entries[f"{rest} more"] = both(REST)
    if (dataset["fraction_unsettled"] > 0).any():
        entries["not settled"] = artists.swatch(**UNSETTLED)
    kinds = {tuple: HandlerTuple(None)}
    look = {"loc": "outside lower left", "ncols": 3, "alignment": "left", "handler_map": kinds}
    figure.legend(entries.values(), entries.keys(), title=TITLE, **look)


def both(colour: str) -> tuple[Patch, Line2D]:
    """Return a band and a point of the motion with this colour, for the legend."""
    point = {"color": colour, "marker": sign(colour), "markersize": 3.0, "markeredgewidth": 0}
    return artists.swatch(**area(colour)), artists.sample(linestyle="none", **point)
