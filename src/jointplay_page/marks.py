"""Marks of a matplotlib panel as glyphs of a Bokeh chart: the same data, units, colours and labels."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import numpy as np
from bokeh.models import ColorBar, FixedTicker, Label, LinearColorMapper
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection, QuadMesh
from matplotlib.colors import BoundaryNorm, to_hex
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.text import Text

from jointplay_page import thin

PIXELS = 1.6  # on a screen, a point of print
SMALLEST = 2.5  # px, of a marker
MARKERS = {"o": "circle", ".": "circle", "s": "square", "^": "triangle", "v": "inverted_triangle"}
MARKERS |= {"D": "diamond", "d": "diamond", "x": "x", "+": "cross", "*": "star", "|": "dash", "_": "dash"}
DASHES = {"--": "dashed", ":": "dotted", "-.": "dotdash"}
HATCHES = {"/": "/", ".": ".", "x": "x", "\\": "\\", "+": "+", "-": "-", "|": "|"}
EVEN = 1e-4  # of a cell: borders this near to an even spacing are drawn as an image


def words(text: str) -> str:
    """Return a label without the marks of mathematical type."""
    return re.sub(r"\$([^$]*)\$", lambda found: re.sub(r"[{}]|\\(?=[a-zA-Z])", "", found[1]), text)


def in_data(ax: Axes, artist: Artist, points: np.ndarray) -> np.ndarray:
    """Return points of an artist in the panel's data coordinates."""
    transform = artist.get_transform()
    return np.asarray(
        points if transform == ax.transData else (transform - ax.transData).transform(points), dtype=float
    )


def single(values: np.ndarray) -> np.ndarray:
    """Return numbers in single precision, which is finer than any screen."""
    return np.asarray(values, dtype=np.float32)


def named(artist: Artist) -> dict[str, str]:
    """Return the entry of the legend that an artist has."""
    label = str(artist.get_label() or "_")
    return {} if label.startswith("_") else {"legend_label": words(label)}


def line(chart: Any, ax: Axes, artist: Line2D, most: int) -> str:
    """Draw a curve, its markers, or both; say what was left out."""
    x, y = in_data(ax, artist, np.ma.filled(artist.get_xydata().astype(float), np.nan)).T
    curved, dotted = artist.get_linestyle() not in ("None", "none", "", " "), artist.get_marker() in MARKERS
    said = ""
    if curved:
        keep = thin.kept_of_curve(x, y, most)
        look = {"line_color": to_hex(artist.get_color()), "line_width": PIXELS * artist.get_linewidth()}
        look |= {
            "line_dash": DASHES.get(artist.get_linestyle(), "solid"),
            "line_alpha": artist.get_alpha() or 1,
        }
        chart.line(single(x[keep]), single(y[keep]), **look, **named(artist))
        said = thin.told(keep.size, x.size, "samples of a curve")
    if dotted:
        every = artist.get_markevery()
        chosen = slice(None, None, every) if isinstance(every, int | None) else every
        x, y = x[chosen], y[chosen]
        keep = thin.kept_of_cloud(x.size, most)
        edge, face = to_hex(artist.get_markeredgecolor()), to_hex(artist.get_markerfacecolor())
        hollow = artist.get_markerfacecolor() in ("none", "None")
        look = {"size": max(SMALLEST, PIXELS * artist.get_markersize()), "fill_alpha": 0.0 if hollow else 1.0}
        look |= {"marker": MARKERS[artist.get_marker()], "fill_color": face, "line_color": edge}
        look |= {
            "line_width": artist.get_markeredgewidth(),
            "angle": np.pi / 2 * (artist.get_marker() == "|"),
        }
        chart.scatter(single(x[keep]), single(y[keep]), **look, **({} if curved else named(artist)))
        said = said or thin.told(x[keep].size, x.size, "points of a cloud")
    return said


def segments(chart: Any, ax: Axes, artist: LineCollection, most: int) -> str:
    """Draw separate stretches, such as error bars."""
    parts = [in_data(ax, artist, part) for part in artist.get_segments() if len(part)]
    colours = artist.get_color()
    look = {"line_color": to_hex(colours[0]) if len(colours) else "#000000"}
    chart.multi_line([p[:, 0] for p in parts], [p[:, 1] for p in parts], **look, **named(artist))
    return ""


def areas(chart: Any, ax: Axes, artist: PolyCollection, most: int) -> str:
    """Draw filled areas, such as error bands and cells without a value."""
    parts = [in_data(ax, artist, path.vertices) for path in artist.get_paths() if len(path.vertices)]
    polygons(chart, parts, artist.get_facecolor(), artist.get_hatch(), **named(artist))
    return ""


def shape(chart: Any, ax: Axes, artist: Patch, most: int) -> str:
    """Draw a circle, a rectangle or another closed shape."""
    path = artist.get_path().transformed(artist.get_transform())
    inverse = ax.transData.inverted()
    parts = [inverse.transform(polygon) for polygon in path.to_polygons()]
    edge = {"line_color": to_hex(artist.get_edgecolor()), "line_alpha": float(artist.get_edgecolor()[3])}
    polygons(chart, parts, [artist.get_facecolor()], artist.get_hatch(), **edge, **named(artist))
    return ""


def polygons(chart: Any, parts: list[np.ndarray], faces: Any, hatch: str | None, **look: Any) -> None:
    """Draw polygons of one colour, below lines and points."""
    face = faces[0] if len(faces) else (0.0, 0.0, 0.0, 0.0)
    filled = {"fill_color": to_hex(face[:3]), "fill_alpha": float(face[3]), "level": "underlay"}
    hatched = {"hatch_pattern": HATCHES.get(hatch[0], "/"), "hatch_alpha": 0.4} if hatch else {}
    edge = {} if "line_color" in look else {"line_alpha": 0.0}
    chart.patches([p[:, 0] for p in parts], [p[:, 1] for p in parts], **filled, **hatched, **edge, **look)


def sentence(chart: Any, ax: Axes, artist: Text, most: int) -> str:
    """Write a text where it stands."""
    if artist.get_text().strip():
        (x, y), align = (
            in_data(ax, artist, np.array([artist.get_position()]))[0],
            artist.get_horizontalalignment(),
        )
        base = {"center": "middle", "center_baseline": "middle"}
        base = base.get(artist.get_verticalalignment(), artist.get_verticalalignment())
        look = {"text_align": align, "text_baseline": base.replace("baseline", "alphabetic")}
        look |= {"text_font_size": "11px", "angle": np.deg2rad(artist.get_rotation())}
        chart.add_layout(
            Label(x=x, y=y, text=words(artist.get_text()), text_color=to_hex(artist.get_color()), **look)
        )
    return ""


def mesh(chart: Any, ax: Axes, artist: QuadMesh, most: int) -> str:
    """Draw cells in colours with their bar: an image where cells are even on the axes, else one by one."""
    corners, values = artist.get_coordinates(), np.ma.filled(artist.get_array().astype(float), np.nan)
    x, y = corners[0, :, 0], corners[:, 0, 1]
    mapper = colours(artist)
    place = [
        np.log10(v) if scale == "log" else v for v, scale in ((x, ax.get_xscale()), (y, ax.get_yscale()))
    ]
    if all(np.ptp(np.diff(v)) <= EVEN * np.abs(np.diff(v)).mean() for v in place if v.size > 2):
        box = {"x": x[0], "y": y[0], "dw": x[-1] - x[0], "dh": y[-1] - y[0]}
        cells = chart.image([single(values)], color_mapper=mapper, level="image", **box)
    else:
        down, across = (v.ravel() for v in np.indices(values.shape))
        box = {"left": x[across], "right": x[across + 1], "bottom": y[down], "top": y[down + 1]}
        source = {name: single(v) for name, v in (box | {"image": values.ravel()}).items()}
        look = {"fill_color": {"field": "image", "transform": mapper}, "line_alpha": 0.0, "level": "image"}
        cells = chart.quad("left", "right", "bottom", "top", source=source, **look)
    cells.name = "cells"
    if artist.colorbar is not None:
        chart.add_layout(colour_bar(artist.colorbar, mapper), "above")
    return ""


def colours(artist: QuadMesh) -> LinearColorMapper:
    """Return the colours of cells; of classes, each a stretch of equal length."""
    norm, cmap, low, high = artist.norm, artist.cmap, artist.norm.vmin, artist.norm.vmax
    shades = cmap(np.linspace(0, 1, 256))
    if isinstance(norm, BoundaryNorm):
        low, high = norm.boundaries[[0, -1]]
        shades = cmap(norm((norm.boundaries[:-1] + norm.boundaries[1:]) / 2))
    palette = [to_hex(shade) for shade in shades]
    return LinearColorMapper(palette=palette, low=float(low), high=float(high), nan_color="rgba(0, 0, 0, 0)")


def colour_bar(bar: Any, mapper: LinearColorMapper) -> ColorBar:
    """Return the bar beside a map, with its title and, of classes, their words."""
    title = words(bar.ax.get_xlabel() or bar.ax.get_ylabel())
    found = ColorBar(color_mapper=mapper, title=title, height=10, name="colour bar")
    if isinstance(bar.norm, BoundaryNorm):
        ticks = [float(tick) for tick in bar.get_ticks()]
        axis = bar.ax.xaxis if bar.orientation == "horizontal" else bar.ax.yaxis
        found.ticker = FixedTicker(ticks=ticks)
        labels = (each.get_text() for each in axis.get_ticklabels())
        found.major_label_overrides = {
            tick: label for tick, label in zip(ticks, labels, strict=False) if label
        }
    return found


DRAWN: tuple[tuple[type[Artist], Callable[..., str]], ...] = (
    (Line2D, line),
    (QuadMesh, mesh),
    (LineCollection, segments),
    (PolyCollection, areas),
    (Patch, shape),
    (Text, sentence),
)
