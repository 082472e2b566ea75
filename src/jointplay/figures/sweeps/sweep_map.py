"""Maps of a sweep's cells: colours over two parameters, a panel for each value of a third one."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import BoundaryNorm, ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from xarray import Dataset

from jointplay.figures.drawing import missing_cells, parts, pick, style, sweep_axes
from jointplay.figures.drawing.units import Shown
from jointplay.figures.sweeps.parameter_map import shades as coloured

PANELS = 9  # at most
HEIGHT = 78.0  # mm, height of one
ROW, BESIDE = 54.0, 14.0  # mm, height of a row of several, and of what is above and below


def maps(part: Dataset, free: list[str], column: str | None) -> Figure:
    """Draw values over the last two parameters as colours, a panel for each value of a third one."""
    *first, down, across = free
    count = part.sizes[first[0]] if first else 1
    if len(first) > 1 or count > PANELS:
        expected = f"values of parameters are needed, until at most three vary, the first {PANELS} times"
        raise pick.refuse("at", ", ".join(free), f"{expected}, as at.{free[0]} = ...")
    columns = min(count, 3)
    rows = -(-count // columns)
    wide = style.COLUMNS[column or ("double" if first else "single")]
    figure = style.sheet(wide, HEIGHT if count == 1 else BESIDE + ROW * rows)
    axes = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    look, label, extend, ticks = shades(part)
    for number, ax in enumerate(axes.ravel()[:count]):
        one = part.isel({first[0]: number}) if first else part
        mesh = panel(
            ax, one.transpose(..., down, across), (down, across), parts.displayed(part["value"])[1], look
        )
        ax.set_title(parts.valued(one[first[0]]) if first else "", loc="left")
        ax.label_outer()
    for ax in axes.ravel()[count:]:
        ax.set_axis_off()
    bar = figure.colorbar(mesh, ax=axes, location="top", extend=extend, label=label, pad=0.02)
    bar.locator = bar.locator if ticks else MaxNLocator(6)
    if ticks:
        bar.set_ticks(list(ticks), labels=[word.replace("_", " ") for word in ticks.values()])
    missing_cells.explain(figure, missing_cells.marks(part, faces=True))
    return figure


def panel(ax: Axes, one: Dataset, names: Sequence[str], unit: Shown, look: dict[str, Any]) -> Any:
    """Draw one map; cells without a number in the faces of `lacks.LACKS`."""
    shown = [sweep_axes.parameter_axis(ax, one[name], which) for name, which in zip(names, "yx", strict=True)]
    middles = [one[name].values * each.factor for name, each in zip(names, shown, strict=True)]
    y, x = map(sweep_axes.edges, middles)
    values = parts.displayed(one["value"], unit)[0]
    mesh = ax.pcolormesh(x, y, np.ma.masked_invalid(values), rasterized=True, **look)
    why = missing_cells.lacking(one)
    for code, (_, face, _) in enumerate(missing_cells.LACKS, start=1):
        if np.any(why == code):
            ax.add_collection(PolyCollection(corners(x, y, why == code), linewidth=0.3, **face))
    doubtful = missing_cells.doubtful(one)
    up, across = np.meshgrid(*middles, indexing="ij")
    ax.plot(across[doubtful], up[doubtful], **missing_cells.DOUBTFUL)
    ax.set(xlim=x[[0, -1]], ylim=y[[0, -1]])
    return mesh


def corners(x: np.ndarray, y: np.ndarray, marked: np.ndarray) -> np.ndarray:
    """Return the corners of the marked cells between edges, shape (cells, 4, 2)."""
    i, j = np.nonzero(marked)
    across, up = (
        np.stack([x[j], x[j + 1], x[j + 1], x[j]], -1),
        np.stack([y[i], y[i], y[i + 1], y[i + 1]], -1),
    )
    return np.stack([across, up], -1)


def shades(part: Dataset) -> tuple[dict[str, Any], str, str, dict[int, str]]:
    """Return colours, label, ends of the colour bar, and the words that values stand for, of all panels."""
    value = part["value"].rename(part.attrs["quantity"])
    words = pick.flags(value)
    if words:
        codes = sorted(words)
        borders = [codes[0] - 0.5, *(code + 0.5 for code in codes)]
        colours = colormaps["viridis"](np.linspace(0.1, 0.9, len(codes)))
        look = {"cmap": ListedColormap(colours), "norm": BoundaryNorm(borders, len(codes))}
        return look, pick.title(value), "neither", words
    values, label, extend, look = coloured(value)
    finite = values[np.isfinite(values)]
    usual = Normalize(finite.min(), finite.max()) if finite.size else Normalize(0, 1)
    return {"norm": usual} | look, label, extend, {}
