"""Figures of a result inside a page: each as SVG, as in print, and where on it values stand."""

from __future__ import annotations

import re
from io import StringIO
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from xarray import Dataset

from jointplay.figures.drawing import artists

MOST = 3_000  # marks of a cloud, or cells of a map, that are drawn one by one; more are an image
DPI = 200  # of such an image
SCREEN = 155  # px an inch of print, at most
STOPS = 257  # along an axis of another scale
SECONDS = {"Time (s)": 1.0, "Time (ms)": 1e3}  # labels of an axis of time, and its factors


def svg(figure: Figure, prefix: str) -> str:
    """Return a figure as an SVG element; names in it begin with a prefix, so that several stand in a page."""
    for mark in (mark for ax in figure.axes for mark in (*ax.lines, *ax.collections)):
        mark.set_rasterized(marks(mark) > MOST)
    file = StringIO()
    with rc_context({"svg.hashsalt": prefix}):
        figure.savefig(file, format="svg", dpi=DPI, metadata={"Date": None})
    text = file.getvalue()
    text = re.sub(r"<metadata>.*?</metadata>", "", text[text.index("<svg") :], flags=re.S)
    text = re.sub(r'(id="|href="#|url\(#)', rf"\1{prefix}-", text)
    wide = f'style="max-width: {SCREEN * figure.bbox.width / figure.dpi:.0f}px" '
    return re.sub(r'<svg (.*?)width="\S+" height="\S+"', rf"<svg {wide}\1", text, count=1, flags=re.S).strip()


def marks(artist: Any) -> int:
    """Return the number of marks that an artist draws one by one; a curve is one."""
    if isinstance(artist, QuadMesh):
        return artist.get_array().size
    dotted = isinstance(artist, Line2D) and artist.get_marker() not in ("None", "none", "", " ", None)
    return len(artist.get_xdata()) if dotted else 1


def panels(figure: Figure, dataset: Dataset, known: list[str]) -> list[dict[str, Any]]:
    """Return where values stand on a drawn figure, for each panel that holds data, in reading order.

    Parameters
    ----------
    figure : Figure
        As `jointplay.figures` draws it.
    dataset : Dataset
        What it shows.
    known : list of str
        Coordinates that an axis may stand for: varied parameters, time.

    Returns
    -------
    list of dict
        ``box``: left, top, width and height in the SVG's units (pt). ``log``: which axes are logarithmic.
        ``stops`` of x and y, in the axes' units: the two ends, or values at even distances on a scale that is
        neither linear nor logarithmic. ``over``: the varied parameter, or ``time``, along each. ``factors``:
        from stored units to the axes'. ``labels`` of the axes.
    """
    width, height = 72 * figure.get_size_inches()
    found = []
    for ax in sorted(with_data(figure), key=place):
        box = ax.get_position()
        over, factors = zip(*(stands_for(ax, which, dataset, known) for which in "xy"), strict=True)
        found.append(
            {
                "box": [box.x0 * width, (1 - box.y1) * height, box.width * width, box.height * height],
                "stops": [stops(ax.xaxis), stops(ax.yaxis)],
                "log": [ax.get_xscale() == "log", ax.get_yscale() == "log"],
                "over": over,
                "factors": factors,
                "labels": [plain(next(filter(None, labels(ax, which)), "")) for which in "xy"],
            }
        )
    return found


def with_data(figure: Figure) -> list[Axes]:
    """Return the panels that hold data, and no colour bars."""
    bars = [mark.colorbar.ax for ax in figure.axes for mark in ax.collections if mark.colorbar]
    return [ax for ax in figure.axes if ax not in bars and (ax.lines or ax.collections) and ax.axison]


def place(ax: Axes) -> tuple[float, float]:
    """Return the order of reading."""
    box = ax.get_position()
    return -round(box.y1, 2), box.x0


def stops(axis: Axis) -> list[float]:
    """Return values at even distances along an axis; on a linear or logarithmic one its ends are enough."""
    transform, count = axis.get_transform(), 2 if axis.get_scale() in ("linear", "log") else STOPS
    places = np.linspace(*transform.transform(axis.get_view_interval()), count)
    return transform.inverted().transform(places).tolist()


def labels(ax: Axes, which: str) -> list[str]:
    """Return the labels of an axis and of axes that share it, its own first."""
    shared = getattr(ax, f"get_shared_{which}_axes")().get_siblings(ax)
    return [getattr(each, f"get_{which}label")() for each in (ax, *shared)]


def plain(text: str) -> str:
    """Return a label without the marks of mathematical type."""
    return re.sub(r"\$([^$]*)\$", lambda found: re.sub(r"[{}]|\\(?=[a-zA-Z])", "", found[1]), text)


def stands_for(ax: Axes, which: str, dataset: Dataset, known: list[str]) -> tuple[str | None, float]:
    """Return the coordinate along an axis, found by its label, and the factor to its units."""
    written = {label.replace("\n", " ") for label in labels(ax, which)}
    if "time" in known and (told := written & SECONDS.keys()):
        return "time", SECONDS[told.pop()]
    for name in known:
        unit = artists.displayed(dataset[name])[1]
        if artists.axis_label(dataset[name], unit) in written:
            return name, float(unit.factor)
    return None, 1.0
