"""Maps over two parameters, as colours: exponent, period, impacts and all other results."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np

from jointplay.display.errors import Problem, raise_any, strangers, with_keys
from jointplay.figures.drawing import (
    Axes,
    DataArray,
    Dataset,
    Figure,
    ListedColormap,
    artists,
    select,
    style,
    sweep_axes,
)
from jointplay.figures.registry import picture

USUAL = ("section_exponent_per_turn", "period", "impacts")
FLOW = "lyapunov_exponent_per_turn"  # of a result without exponents of the section's map
SIGNED = (USUAL[0], FLOW, "lyapunov_exponent", "growth", "growth_rate")
NUMBERED = ("exponent", "multiplier")
LONGEST = 8  # a period that has a colour of its own
SMALL, LOWER = 7, 1.1  # pt: numbers of the classes, and by how much they are lower than those of other scales
REST = 98  # percentile of absolute values that the colours reach


def fits(options: Mapping[str, Any], settings: Mapping[str, Any]) -> Iterator[Problem]:
    """Yield the problems of a study without two parameters."""
    if len(settings["over"]) != 2:
        yield Problem("figure.kind", "parameter_map", "accepted only where two parameters vary")
    yield from sweep_axes.fits(options, settings)


@picture(least=140, over=2, fits=fits)
def parameter_map(
    dataset: Dataset,
    *,
    maps: Sequence[str] | None = None,
    joint: str | None = None,
    exponent: int = 1,
    direction: str | None = None,
    start: int = 0,
) -> Figure:
    """Draw quantities over two parameters, a panel each.

    Cells without a value are hatched on grey; those that another point stands for are hatched in colour.

    Parameters
    ----------
    dataset : Dataset
        What `jointplay.bifurcation` returned for two parameters.
    maps : sequence of str, optional
        Of the result, one value a point: by default the section map's exponent, the period and the impacts.
    joint : str, optional
        Of which joint; by default the first.
    exponent : int
        Which exponent, 1 the largest.
    direction : {"up", "down", "reset"}, optional
        Of which sweep; by default the first.
    start : int
        Of which start.
    """
    names = sweep_axes.parameters(dataset, "parameter_map")
    if len(names) != 2:
        raise select.refuse("kind", "parameter_map", "a result over two parameters")
    known = mapped(dataset, names)
    usual = USUAL if USUAL[0] in known else (FLOW, *USUAL[1:])
    wanted = [v for v in usual if v in known] if maps is None else listed(maps, known)
    part = sweep_axes.chosen(dataset, select.label(dataset, "direction", direction), start).isel(direction=0)
    part = part.isel(start=0) if "start" in part.dims else part
    columns = 2 if len(wanted) == 4 else min(len(wanted), 3)
    rows = -(-len(wanted) // columns)
    figure = style.sheet(180.0 if columns > 1 else 88.0, 78.0 * rows)
    axes = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False).ravel()
    panels = zip(axes, wanted, artists.letters(len(wanted)), strict=False)
    for number, (ax, name, letter) in enumerate(panels):
        array = part[name]
        for dim in NUMBERED:
            if dim in array.dims:
                array = array.sel({dim: numbered(dataset, dim, exponent)})
        array = select.labelled_slice(array, dataset, names, joint=joint)
        panel(ax, part, array, names, letter)
        if number % columns:
            ax.set_ylabel("")
        lowest = number + columns >= len(wanted)
        ax.tick_params(labelbottom=lowest)
        if not lowest:
            ax.set_xlabel("")
    for ax in axes[len(wanted) :]:
        ax.set_axis_off()
    if stand_ins(dataset) is not None:
        with hatched() as look:
            note = "hatched: not computed, and shown as the nearest computed point of its box"
            figure.legend(handles=[artists.swatch(label=note, **look)], loc="outside lower center")
    return artists.finish(figure, dataset)


def mapped(dataset: Dataset, names: Sequence[str]) -> list[str]:
    """Return the variables that have one number a point of the sweep."""
    allowed = {*names, *sweep_axes.SWEEPS, "joint", *NUMBERED}
    return [
        str(name)
        for name, array in dataset.data_vars.items()
        if set(names) <= set(array.dims) <= allowed and array.dtype.kind in "fiu" and name != "cell_status"
    ]


def listed(maps: Any, known: Sequence[str]) -> list[str]:
    """Return the wanted variables, all of them known."""
    wanted = [maps] if isinstance(maps, str) else list(maps)
    if not wanted:
        raise select.refuse("maps", maps, "a list of at least one name")
    raise_any(strangers(with_keys("figure.maps", wanted), known, "variable"))
    return wanted


def numbered(dataset: Dataset, dim: str, exponent: Any) -> int:
    """Return the number of an exponent that the result has."""
    known = dataset[dim].values.tolist()
    if isinstance(exponent, bool) or exponent not in known:
        raise select.refuse("exponent", exponent, f"the number of an exponent, 1 to {known[-1]}")
    return exponent


def panel(ax: Axes, dataset: Dataset, array: DataArray, names: Sequence[str], letter: str) -> None:
    """Draw one variable as colours over the two parameters, the last along x."""
    from matplotlib import rcParams

    ax.patch.set(facecolor=style.DISC, edgecolor=style.GREY, hatch="////")  # seen where nothing is drawn
    colours = classes if array.name == "period" else colour_scale
    values, label, extend, look = colours(array.transpose(*names))
    mesh, _ = sweep_axes.colour_map(ax, dataset, names, values, look)
    if (others := stand_ins(dataset)) is not None:
        cells = np.ma.masked_equal(others.transpose(*names).values, 0)
        corners = mesh.get_coordinates()
        with hatched() as look:
            ax.pcolor(corners[..., 0], corners[..., 1], cells, rasterized=True, **look)
    text = f"{letter} {label}".lstrip()
    bar = ax.figure.colorbar(mesh, ax=ax, location="top", extend=extend, label=text, pad=0.02)
    if colours is classes:
        bar.set_ticks(range(1, LONGEST + 3), labels=[*map(str, range(1, LONGEST + 1)), f">{LONGEST}", "0"])
        bar.ax.tick_params(length=0, labelsize=SMALL, pad=rcParams["xtick.major.pad"] + LOWER)


@contextmanager
def hatched() -> Iterator[dict[str, Any]]:
    """Give the look of cells that another point stands for, whose colour stays seen."""
    from matplotlib import rc_context

    with rc_context({"hatch.linewidth": 0.4}):
        yield {"hatch": "\\\\\\\\", "facecolor": "none", "edgecolor": style.GREY, "linewidth": 0.0}


def stand_ins(dataset: Dataset) -> DataArray | None:
    """Return which cells another point stands for; None where all were computed."""
    others = dataset["computed"] == 0 if "computed" in dataset else None
    return others if others is not None and others.any() else None


def colour_scale(array: DataArray) -> tuple[np.ndarray, str, str, dict[str, Any]]:
    """Return numbers with label and colours: signed ones lighter below 0 than above it."""
    from matplotlib.colors import Normalize

    values, unit = artists.displayed(array)
    label, finite = artists.axis_label(array, unit), np.abs(values[np.isfinite(values)])
    if array.name not in SIGNED:
        return values, label, "neither", {"cmap": "viridis"}
    reach = (np.percentile(finite, REST) if finite.size else 0.0) or 1.0
    values = np.where(np.isneginf(values), -2 * reach, values)  # what rests forgets its start: lowest colour
    return values, label, "both", {"cmap": signs(), "norm": Normalize(-reach, reach)}


def signs() -> ListedColormap:
    """Return light blues below 0, above it reds that are darker than any: the sign shows in a grey print."""
    from matplotlib import colormaps
    from matplotlib.colors import ListedColormap

    below, above = np.linspace(0.5, 1.0, 128), np.linspace(0.6, 1.0, 128)
    return ListedColormap([*colormaps["Blues_r"](below), *colormaps["Reds"](above)], "signs")


def classes(array: DataArray) -> tuple[np.ndarray, str, str, dict[str, Any]]:
    """Return periods as classes, each with a colour of its own; longer ones in white, none in black."""
    from matplotlib import colormaps
    from matplotlib.colors import BoundaryNorm, ListedColormap

    place = array.values.astype(float)
    place = np.where(place > LONGEST, LONGEST + 1, np.where(place == 0, LONGEST + 2, place))
    colours = [*colormaps["viridis_r"](np.linspace(0.05, 0.9, LONGEST)), "white", style.BLACK]
    norm = BoundaryNorm(np.arange(0.5, LONGEST + 3), LONGEST + 2)
    look = {"cmap": ListedColormap(colours), "norm": norm}
    return np.where(place < 0, np.nan, place), "Period (turns; 0: none)", "neither", look
