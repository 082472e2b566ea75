"""A matplotlib figure as live charts: one for each panel that holds data, with its axes and legend."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from bokeh.models import FixedTicker, HoverTool, Range1d
from bokeh.plotting import figure as new_chart
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FixedLocator
from xarray import Dataset

from jointplay.figures.drawing import artists
from jointplay_page.marks import DRAWN, words

TOOLS = "pan,wheel_zoom,box_zoom,reset"
COLUMNS = 12  # of the grid that charts are laid out on
HEIGHT = 1.9  # px a pixel of print at 72 dpi
LEAST, SIDE = 150, 400  # px, of a chart's height, and of a square chart
COLUMN, BESIDE = 88, 110  # px of a column on a wide screen, and of what stands beside a chart


@dataclass(frozen=True)
class Panel:
    """A live chart.

    Parameters
    ----------
    chart : bokeh.plotting.figure
        With the name ``chart`` and its number.
    columns : int
        Of the grid's twelve, that it takes.
    over : tuple of (str or None)
        The varied parameter, or ``time``, along x and along y.
    factors : tuple of float
        From stored units to those along x and y.
    notes : tuple of str
        What is not shown as in the picture.
    """

    chart: Any
    columns: int
    over: tuple[str | None, str | None]
    factors: tuple[float, float]
    notes: tuple[str, ...]


def panels(figure: Figure, dataset: Dataset, known: list[str], first: int, most: int) -> list[Panel]:
    """Make the live charts of a figure.

    Parameters
    ----------
    figure : Figure
        As `jointplay.figures` draws it.
    dataset : Dataset
        What it shows.
    known : list of str
        Coordinates that an axis may stand for: varied parameters, time.
    first : int
        Number of the first chart.
    most : int
        Samples from which a curve or cloud is thinned.
    """
    found, ranges, axes = [], {}, sorted(drawn(figure), key=place)
    rows = Counter(place(ax)[0] for ax in axes)
    for ax in axes:
        columns = COLUMNS // rows[place(ax)[0]]
        chart = chart_of(ax, f"chart{first + len(found)}", columns, ranges)
        notes = fill(chart, ax, most)
        over, factors = zip(*(stands_for(ax, which, dataset, known) for which in "xy"), strict=True)
        found.append(Panel(chart, columns, over, factors, notes))
    return found


def drawn(figure: Figure) -> list[Axes]:
    """Return the panels that hold data, and no colour bars."""
    bars = [mark.colorbar.ax for ax in figure.axes for mark in ax.collections if mark.colorbar]
    return [ax for ax in figure.axes if ax not in bars and (ax.lines or ax.collections) and ax.axison]


def place(ax: Axes) -> tuple[float, float]:
    """Return the order of reading."""
    box = ax.get_position()
    return -round(box.y1, 2), box.x0


def chart_of(ax: Axes, name: str, columns: int, ranges: dict[Any, Range1d]) -> Any:
    """Return an empty chart with a panel's axes; panels that share an axis share its range."""
    given, labels = {}, {}
    for which in "xy":
        shared = getattr(ax, f"get_shared_{which}_axes")().get_siblings(ax)
        key = which, min(map(id, shared))
        limits = [float(v) for v in getattr(ax, f"get_{which}lim")()]
        given[f"{which}_range"] = ranges.setdefault(key, Range1d(*limits))
        given[f"{which}_axis_type"] = "log" if getattr(ax, f"get_{which}scale")() == "log" else "linear"
        named = (getattr(each, f"get_{which}label")() for each in (ax, *shared))
        labels[which] = words(next(filter(None, named), ""))
    size = ax.figure.bbox.height / ax.figure.dpi * 72 * ax.get_position().height
    square = ax.get_aspect() == 1.0 or ax.get_box_aspect() == 1.0
    side = max(LEAST, min(SIDE, COLUMN * columns - BESIDE))
    given |= {"frame_width": side, "frame_height": side} if square else {"sizing_mode": "stretch_width"}
    chart = new_chart(
        name=name,
        height=max(LEAST, round(HEIGHT * size) + 60),
        tools=TOOLS,
        active_drag="box_zoom",
        lod_timeout=300,
        x_axis_label=labels["x"],
        y_axis_label=labels["y"],
        title=words(" ".join(filter(None, map(ax.get_title, ("left", "center", "right"))))),
        **given,
    )
    chart.toolbar.logo = None
    chart.grid.visible = not any(isinstance(each, QuadMesh) for each in ax.collections)
    for which, axis in (("x", chart.xaxis[0]), ("y", chart.yaxis[0])):
        ticks(getattr(ax, f"{which}axis"), axis)
    return chart


def ticks(drawn_axis: Any, axis: Any) -> None:
    """Put ticks where a panel has them at fixed values, with their words."""
    if isinstance(drawn_axis.get_major_locator(), FixedLocator):
        values = [float(value) for value in drawn_axis.get_majorticklocs()]
        labels = drawn_axis.get_major_formatter().format_ticks(values)
        axis.ticker = FixedTicker(ticks=values)
        axis.major_label_overrides = {v: words(text) for v, text in zip(values, labels, strict=True) if text}


def fill(chart: Any, ax: Axes, most: int) -> tuple[str, ...]:
    """Draw all marks of a panel in a chart; return what is thinned or left out."""
    notes = []
    name_marks(ax)
    for mark in sorted(marks(ax), key=lambda each: each.get_zorder()):
        draw = next((draw for kind, draw in DRAWN if isinstance(mark, kind)), None)
        left = f"{type(mark).__name__} is in the still picture only"
        notes.append(draw(chart, ax, mark, most) if draw else left)
    if chart.legend:
        chart.legend[0].update(click_policy="hide", label_text_font_size="11px", spacing=12, padding=4)
        chart.legend[0].orientation = "horizontal"
        chart.add_layout(chart.legend[0], "above")
    if chart.select(name="cells"):
        chart.add_tools(HoverTool(renderers=list(chart.select(name="cells")), tooltips=[("value", "@image")]))
    return tuple(dict.fromkeys(filter(None, notes)))


def name_marks(ax: Axes) -> None:
    """Give names to points that only a legend made by hand names, told by their colour."""
    legend, unnamed = ax.get_legend(), [mark for mark in ax.lines if str(mark.get_label()).startswith("_")]
    for handle, text in zip(legend.legend_handles, legend.get_texts(), strict=True) if legend else ():
        alike = (
            mark for mark in unnamed if isinstance(handle, Line2D) and mark.get_color() == handle.get_color()
        )
        known = {mark.get_label() for mark in ax.lines}
        for mark in alike if text.get_text() not in known else ():
            mark.set_label(text.get_text())


def marks(ax: Axes) -> Iterator[Artist]:
    """Yield what is drawn in a panel, without its axes and legend."""
    for each in (*ax.patches, *ax.collections, *ax.lines, *ax.texts, *ax.images):
        if each.get_visible() and not (isinstance(each, Line2D) and not len(each.get_xdata())):
            yield each


def stands_for(ax: Axes, which: str, dataset: Dataset, known: list[str]) -> tuple[str | None, float]:
    """Return the coordinate along an axis, told by its label, and the factor to its units."""
    shared = getattr(ax, f"get_shared_{which}_axes")().get_siblings(ax)
    labels = {getattr(each, f"get_{which}label")().replace("\n", " ") for each in (ax, *shared)}
    seconds = {"Time (s)": 1.0, "Time (ms)": 1e3}
    if "time" in known and (told := labels & seconds.keys()):
        return "time", seconds[told.pop()]
    for name in known:
        unit = artists.displayed(dataset[name])[1]
        if artists.axis_label(dataset[name], unit) in labels:
            return name, float(unit.factor)
    return None, 1.0
