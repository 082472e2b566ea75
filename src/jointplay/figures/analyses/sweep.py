"""Value of each cell of a sweep: a curve over one parameter, a map over two, a row of maps over three."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from jointplay.display import codes
from jointplay.display.number_text import Shown
from jointplay.figures.analyses.parameter_map import colour_scale
from jointplay.figures.drawing import (
    Axes,
    DataArray,
    Dataset,
    Figure,
    artists,
    cell_quantity,
    select,
    style,
    sweep_axes,
)
from jointplay.figures.registry import picture

CASE = "case"  # the dimension of combinations that make no grid
CURVES, NUMBERED = 4, 10  # at most
HEIGHT = 66.0  # mm
LOOKS = ((style.BLACK, "o"), (style.BLUE, "s"), (style.AMBER, "^"), (style.GREY, "D"))
PANELS = 9  # at most
MAP_HEIGHT = 78.0  # mm, height of one
ROW, BESIDE = 54.0, 14.0  # mm, height of a row of several, and of the rest
ENTRY, LINE = 42.0, 5.0  # mm, width of an entry of the legend and height of its lines
MARK = {"markersize": 4.0, "linestyle": "none"}
# why a cell has no number, its face in a map, its mark below a curve
REASONS: tuple[tuple[str, dict[str, Any], dict[str, Any]], ...] = (
    (
        "failed",
        {"facecolor": "white", "edgecolor": style.WARNING, "hatch": "xxxxx"},
        {"marker": "x", "color": style.WARNING, **MARK},
    ),
    (
        "crashed",
        {"facecolor": style.BLACK, "edgecolor": style.BLACK},
        {"marker": "s", "color": style.BLACK, **MARK},
    ),
    (
        "no value",
        {"facecolor": style.DISC, "edgecolor": style.GREY, "hatch": "////"},
        {"marker": "o", "color": style.GREY, "markerfacecolor": "white", **MARK},
    ),
)
DOUBTFUL: dict[str, Any] = {"marker": "+", "color": style.WARNING, **MARK, "markersize": 6.0}


@picture(checks={"at": lambda value: entries(value)})
def sweep(
    dataset: Dataset,
    *,
    quantity: str | None = None,
    at: dict[str, Any] | None = None,
    along: str | None = None,
    column: str | None = None,
) -> Figure:
    """Draw the value of each cell of a sweep; cells that failed, crashed or have no value are marked.

    Parameters
    ----------
    dataset : Dataset
        Of a study with `[vary]`, of another kind than bifurcation.
    quantity : str, optional
        A variable that cells have; by default what the row of the kind of study says (`jointplay.kinds`).
    at : dict, optional
        Which entry along a dimension of the quantity, as ``{"exponent": 2}``, or ``"largest"``; and values of
        parameters, of which the nearest ones are taken.
    along : str, optional
        The parameter along x of curves, one for each value of the other; of cases in place of their number.
    column : {"single", "double"}, optional
        Width: one column of a page, or the page.
    """
    if not cell_quantity.varied(dataset):
        raise select.refuse("kind", "sweep", "a result of a study with [vary], but not of kind bifurcation")
    at = entries(at)
    if column is not None:
        select.choice("column", column, style.COLUMNS)
    part = cell_quantity.cell_values(cut(dataset, at), quantity, at)
    varied = cell_quantity.varied(part)
    free = [dim for dim in varied if part.sizes[dim] > 1] or varied[-1:]
    part = part.isel({dim: 0 for dim in varied if dim not in free})
    mapped = along is None and len(free) > 1
    return artists.finish(maps(part, free, column) if mapped else curves(part, free, along, column), part)


def entries(at: Any) -> dict[str, Any]:
    """Return the wanted entries, a table."""
    if at is not None and not isinstance(at, dict):
        raise select.refuse("at", at, "a table, as at.exponent = 2 or at.clearance = 1e-4, is accepted")
    return dict(at or {})


def cut(dataset: Dataset, at: dict[str, Any]) -> Dataset:
    """Return a sweep at the values of parameters nearest to the wanted ones."""
    for name in [name for name in cell_quantity.varied(dataset) if name in at]:
        if not select.is_number(at[name]):
            raise select.refuse(f"at.{name}", at[name], f"a value of {name}")
        dataset = dataset.sel({name: [at[name]]}, method="nearest")
    return dataset


def curves(part: Dataset, free: list[str], along: str | None, column: str | None) -> Figure:
    """Draw values over one parameter, a curve for each value of the other."""
    known = [str(name) for name, axis in part.coords.items() if axis.dims and set(axis.dims) <= set(free)]
    over = free[-1] if along is None else select.choice("along", along, known, "varied parameter")
    others = [dim for dim in free if dim not in part[over].dims]
    if np.prod([part.sizes[dim] for dim in others]) > CURVES:
        expected = (
            f"more values are needed, such as at.{others[0]} = ..., so that at most {CURVES} curves are left"
        )
        raise select.refuse("at", ", ".join(others), expected)
    figure = style.sheet(style.COLUMNS[column or "single"], HEIGHT)
    ax = figure.subplots()
    _, unit = artists.displayed(part["value"])
    if np.any(part["value"].values < 0) and np.any(part["value"].values > 0):
        ax.axhline(0.0, color=style.GREY, linewidth=0.6)
    stacked = part.stack(curve=others) if others else part.expand_dims("curve")
    for number in range(stacked.sizes["curve"]):
        one = stacked.isel(curve=number)
        curve(ax, one, over, unit, number, ", ".join(artists.valued(one[dim]) for dim in others))
    if np.any(missing_reason(part)):  # room below, for their marks
        low, high = ax.get_ylim()
        ax.set_ylim(low - 0.06 * (len(others) + 1) * (high - low), high)
    name_x(ax, part, over)
    name_y(ax, part["value"], unit)
    bars = f"bars: {part.attrs['reach']}" if "low" in part else ""
    handles = [*ax.get_legend_handles_labels()[0], *marks(part, faces=False)]
    explain(figure, handles, bars)
    return figure


def curve(ax: Axes, one: Dataset, over: str, unit: Shown, number: int, label: str) -> None:
    """Draw one curve with its errors, and below it marks of cells without a number."""
    x = artists.displayed(one[over])[0]
    rise = np.argsort(x, kind="stable")
    y = one["value"].values * unit.factor
    colour, marker = LOOKS[number]
    line = "none" if over == CASE else "-"
    look = {"color": colour, "marker": marker, "markersize": 2.4, "linewidth": 0.8, "linestyle": line}
    ends = [one[end].values * unit.factor for end in ("low", "high") if end in one]
    if ends:
        reach = np.abs(np.stack(ends) - y)[:, rise]
        ax.errorbar(x[rise], y[rise], reach, **look, elinewidth=0.6, capsize=1.5, label=label or "_")
    else:
        ax.plot(x[rise], y[rise], **look, label=label or "_")
    doubtful = doubtful_cells(one)
    ax.plot(x[doubtful], y[doubtful], **DOUBTFUL)
    height, place = 0.03 + 0.05 * number, {"transform": ax.get_xaxis_transform(), "clip_on": False}
    for code, (_, _, look) in enumerate(REASONS, start=1):
        at = x[missing_reason(one) == code]
        if at.size:
            ax.plot(at, np.full(at.size, height), **look, label="_", **place)


def name_x(ax: Axes, part: Dataset, over: str) -> None:
    """Scale and label the x axis; cases have their parameters' values below them."""
    if over != CASE:
        sweep_axes.parameter_axis(ax, part[over].sortby(part[over]) if part[over].dims else part[over])
        return
    names = [str(name) for name, axis in part.coords.items() if axis.dims == (CASE,) and name != CASE]
    shown = {name: artists.displayed(part[name]) for name in names}
    step = -(-part.sizes[CASE] // NUMBERED)
    ticks = part[CASE].values[::step]
    columns = (shown[name][0][::step] for name in names)
    ax.set_xticks(ticks, ["\n".join(f"{value:.3g}" for value in each) for each in zip(*columns, strict=True)])
    ax.set_xlabel("\n".join(artists.axis_label(part[name], shown[name][1]) for name in names))


def name_y(ax: Axes, value: DataArray, unit: Shown) -> None:
    """Label the y axis; values that stand for words get these."""
    words = codes.flags(value)
    if words:
        ax.set_yticks(list(words), [word.replace("_", " ") for word in words.values()])
        ax.set_ylim(min(words) - 0.5, max(words) + 0.5)
        ax.set_ylabel(select.title(value))
    else:
        artists.name_y(ax, value, unit, longest=30)


def maps(part: Dataset, free: list[str], column: str | None) -> Figure:
    """Draw values over the last two parameters as colours, a panel for each value of a third one."""
    from matplotlib.ticker import MaxNLocator

    *first, down, across = free
    count = part.sizes[first[0]] if first else 1
    if len(first) > 1 or count > PANELS:
        expected = f"values of parameters are needed, until at most three vary, the first {PANELS} times"
        raise select.refuse("at", ", ".join(free), f"{expected}, as at.{free[0]} = ...")
    columns = min(count, 3)
    rows = -(-count // columns)
    wide = style.COLUMNS[column or ("double" if first else "single")]
    figure = style.sheet(wide, MAP_HEIGHT if count == 1 else BESIDE + ROW * rows)
    axes = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    look, label, extend, ticks = shades(part)
    for number, ax in enumerate(axes.ravel()[:count]):
        one = part.isel({first[0]: number}) if first else part
        unit = artists.displayed(part["value"])[1]
        mesh = panel(ax, one.transpose(..., down, across), (down, across), unit, look)
        ax.set_title(artists.valued(one[first[0]]) if first else "", loc="left")
        ax.label_outer()
    for ax in axes.ravel()[count:]:
        ax.set_axis_off()
    bar = figure.colorbar(mesh, ax=axes, location="top", extend=extend, label=label, pad=0.02)
    bar.locator = bar.locator if ticks else MaxNLocator(6)
    if ticks:
        bar.set_ticks(list(ticks), labels=[word.replace("_", " ") for word in ticks.values()])
    explain(figure, marks(part, faces=True))
    return figure


def panel(ax: Axes, one: Dataset, names: Sequence[str], unit: Shown, look: dict[str, Any]) -> Any:
    """Draw one map; cells without a number in the faces of `REASONS`."""
    from matplotlib.collections import PolyCollection

    values = artists.displayed(one["value"], unit)[0]
    mesh, middles = sweep_axes.colour_map(ax, one, names, values, look)
    y, x = map(sweep_axes.edges, middles)
    why = missing_reason(one)
    for code, (_, face, _) in enumerate(REASONS, start=1):
        if np.any(why == code):
            ax.add_collection(PolyCollection(corners(x, y, why == code), linewidth=0.3, **face))
    doubtful = doubtful_cells(one)
    up, across = np.meshgrid(*middles, indexing="ij")
    ax.plot(across[doubtful], up[doubtful], **DOUBTFUL)
    return mesh


def corners(x: np.ndarray, y: np.ndarray, marked: np.ndarray) -> np.ndarray:
    """Return the corners of the marked cells between edges, shape (cells, 4, 2)."""
    i, j = np.nonzero(marked)
    across, up = [x[j], x[j + 1], x[j + 1], x[j]], [y[i], y[i], y[i + 1], y[i + 1]]
    return np.stack([np.stack(across, -1), np.stack(up, -1)], -1)


def shades(part: Dataset) -> tuple[dict[str, Any], str, str, dict[int, str]]:
    """Return colours, label, ends of the colour bar, and the words that values stand for, of all panels."""
    from matplotlib import colormaps
    from matplotlib.colors import BoundaryNorm, ListedColormap, Normalize

    value = part["value"].rename(part.attrs["quantity"])
    words = codes.flags(value)
    if words:
        numbers = sorted(words)
        borders = [numbers[0] - 0.5, *(number + 0.5 for number in numbers)]
        colours = colormaps["viridis"](np.linspace(0.1, 0.9, len(numbers)))
        look = {"cmap": ListedColormap(colours), "norm": BoundaryNorm(borders, len(numbers))}
        return look, select.title(value), "neither", words
    values, label, extend, look = colour_scale(value)
    finite = values[np.isfinite(values)]
    usual = Normalize(finite.min(), finite.max()) if finite.size else Normalize(0, 1)
    return {"norm": usual} | look, label, extend, {}


def missing_reason(part: Dataset) -> np.ndarray:
    """Return why each cell has no value, as 1 + the index in `REASONS`; 0 where it has one."""
    status = part["cell_status"].transpose(*part["value"].dims)
    why = np.where(status == 0, 3, np.where(codes.words(status) == "crashed", 2, 1))
    return np.where(np.isfinite(part["value"].values), 0, why)


def doubtful_cells(part: Dataset) -> np.ndarray:
    """Return which cells have a number although they did not end well."""
    failed = part["cell_status"].transpose(*part["value"].dims).values != 0
    return failed & np.isfinite(part["value"].values)


def marks(part: Dataset, faces: bool) -> list[Any]:
    """Return legend entries for the faces of a map, or the marks of curves, that occur."""
    why, found = missing_reason(part), []
    for code, (word, face, mark) in enumerate(REASONS, start=1):
        if np.any(why == code):
            found.append(artists.swatch(**face, label=word) if faces else artists.sample(**mark, label=word))
    if np.any(doubtful_cells(part)):
        found.append(artists.sample(**DOUBTFUL, label="failed, with a value"))
    return found


def explain(figure: Figure, handles: list[Any], heading: str = "") -> None:
    """Put a legend, if it has entries or a heading, below a figure, which grows by its height."""
    if heading and not handles:
        handles, heading = [artists.sample(linestyle="none", label=heading)], ""
    if not handles:
        return
    width, height = figure.get_size_inches()
    columns = max(1, int(width / style.MILLIMETRE // ENTRY))
    rows = -(-len(handles) // columns) + bool(heading)
    figure.set_size_inches(width, height + rows * LINE * style.MILLIMETRE)
    place = {"loc": "outside lower center", "ncols": columns, "columnspacing": 1.2}
    figure.legend(handles=handles, title=heading, **place)
