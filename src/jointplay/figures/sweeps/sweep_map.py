"""Maps of a sweep's cells: colours over two parameters, a panel for each value of a third one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from jointplay.display import codes
from jointplay.display.units import Shown
from jointplay.figures.drawing import artists, missing_cells, select, style, sweep_axes
from jointplay.figures.sweeps.parameter_map import colour_scale

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from xarray import Dataset

PANELS = 9  # at most
HEIGHT = 78.0  # mm, height of one
ROW, BESIDE = 54.0, 14.0  # mm, height of a row of several, and of the rest


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
    figure = style.sheet(wide, HEIGHT if count == 1 else BESIDE + ROW * rows)
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
    missing_cells.explain(figure, missing_cells.marks(part, faces=True))
    return figure


def panel(ax: Axes, one: Dataset, names: Sequence[str], unit: Shown, look: dict[str, Any]) -> Any:
    """Draw one map; cells without a number in the faces of `missing_cells.REASONS`."""
    from matplotlib.collections import PolyCollection

    values = artists.displayed(one["value"], unit)[0]
    mesh, middles = sweep_axes.colour_map(ax, one, names, values, look)
    y, x = map(sweep_axes.edges, middles)
    why = missing_cells.missing_reason(one)
    for code, (_, face, _) in enumerate(missing_cells.REASONS, start=1):
        if np.any(why == code):
            ax.add_collection(PolyCollection(corners(x, y, why == code), linewidth=0.3, **face))
    doubtful = missing_cells.doubtful(one)
    up, across = np.meshgrid(*middles, indexing="ij")
    ax.plot(across[doubtful], up[doubtful], **missing_cells.DOUBTFUL)
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
