"""Cells of a sweep without a value, or with a doubtful one: their reasons and marks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from jointplay.display import codes
from jointplay.figures.drawing import style

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from xarray import Dataset

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


def missing_reason(part: Dataset) -> np.ndarray:
    """Return why each cell has no value, as 1 + the index in `REASONS`; 0 where it has one."""
    status = part["cell_status"].transpose(*part["value"].dims)
    why = np.where(status == 0, 3, np.where(codes.words(status) == "crashed", 2, 1))
    return np.where(np.isfinite(part["value"].values), 0, why)


def doubtful(part: Dataset) -> np.ndarray:
    """Return which cells have a number although they did not end well."""
    failed = part["cell_status"].transpose(*part["value"].dims).values != 0
    return failed & np.isfinite(part["value"].values)


def marks(part: Dataset, faces: bool) -> list[Any]:
    """Return legend entries for the faces of a map, or the marks of curves, that occur."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    why, found = missing_reason(part), []
    for code, (word, face, mark) in enumerate(REASONS, start=1):
        if np.any(why == code):
            found.append(Patch(**face, label=word) if faces else Line2D([], [], **mark, label=word))
    if np.any(doubtful(part)):
        found.append(Line2D([], [], **DOUBTFUL, label="failed, with a value"))
    return found


def explain(figure: Figure, handles: list[Any], heading: str = "") -> None:
    """Put a legend, if it has entries or a heading, below a figure, which grows by its height."""
    from matplotlib.lines import Line2D

    if heading and not handles:
        handles, heading = [Line2D([], [], linestyle="none", label=heading)], ""
    if not handles:
        return
    width, height = figure.get_size_inches()
    columns = max(1, int(width / style.MILLIMETRE // ENTRY))
    rows = -(-len(handles) // columns) + bool(heading)
    figure.set_size_inches(width, height + rows * LINE * style.MILLIMETRE)
    place = {"loc": "outside lower center", "ncols": columns, "columnspacing": 1.2}
    figure.legend(handles=handles, title=heading, **place)
