"""Readings: each panel of the paper's Figure 12 under each reading of the paper, as one table."""

from __future__ import annotations

import numpy as np

from jointplay.display import codes
from jointplay.display.number_text import plain
from jointplay.figures.drawing import Axes, Dataset, Figure, artists, select, style
from jointplay.figures.registry import picture

NAMES, ROW, HEAD, FOOT = 38.3, 8.6, 13.0, 1.0  # mm: the readings' names, a row, above and below the rows
COLUMNS = {"separations": 14.4, "period": 8.8, "growth": 13.6, "section": 8.6}  # mm of width
HEADINGS = {
    "separations": "separations\nper turn",
    "period": "period\n(turns)",
    "growth": "growth\nper turn",
    "section": "section",
}
SMALL = 1e-4  # errors below it have a power of ten, which leaves room for one digit
FEW = 20  # distinct points of a section, which are drawn larger
SHADE = {"periodic": 0.0, "undecided": 0.35, "chaotic": 0.85}  # of the growth, by what the motion is


@picture()
def readings(dataset: Dataset) -> Figure:
    """Draw a table: a row a reading; for each panel separations and growth a turn, period and section.

    The darker, the more separations; growth is shaded white where the motion is periodic, grey where that is
    undecided, dark where it is chaotic. Sections are drawn in the clearance circle.

    Parameters
    ----------
    dataset : Dataset
        What `jointplay.readings` returned.
    """
    select.require(dataset, "readings", ("reading", "panel"), "a result over reading and panel")
    part = sum(COLUMNS.values())
    width = NAMES + (part + 1.5) * dataset.sizes["panel"] + 1.0
    figure, ax = artists.page(width, HEAD + ROW * dataset.sizes["reading"] + FOOT)
    for row, name in enumerate(select.labels(dataset, "reading")):
        artists.write(ax, 1.0, HEAD + (row + 0.5) * ROW, name.replace("_", " "))
    most = float(dataset["separations"].max())
    for number, panel in enumerate(select.labels(dataset, "panel")):
        panel_columns(ax, dataset.sel(panel=panel), NAMES + number * (part + 1.5), most)
    return artists.finish(figure, dataset)


def panel_columns(ax: Axes, part: Dataset, left: float, most: float) -> None:
    """Draw the columns of one panel, from `left` mm on; cells with `most` separations are darkest."""
    edges = dict(zip(COLUMNS, left + np.cumsum([0, *COLUMNS.values()]), strict=False))
    middle = left + sum(COLUMNS.values()) / 2
    artists.write(ax, middle, 2.0, panel_title(part), ha="center", fontsize=8)
    for name, words in HEADINGS.items():
        artists.write(ax, edges[name] + COLUMNS[name] / 2, HEAD - 1.0, words, ha="center", va="bottom")
    motions = codes.words(part["motion"]).values
    for row in range(part.sizes["reading"]):
        one = part.isel(reading=row)
        motion = str(motions[row])
        shown = {
            "separations": (plain(float(one["separations"]), 3), float(one["separations"]) / (most or 1.0)),
            "period": ({0: "none", -1: "\N{EN DASH}"}.get(int(one["period"]), f"{int(one['period'])}"), 0.0),
            "growth": (growth(one), SHADE.get(motion if np.isfinite(one["growth"]) else "", 0.0)),
            "section": ("", 0.0),
        }
        for name, (words, shade) in shown.items():
            artists.cell(ax, (edges[name], HEAD + row * ROW, COLUMNS[name], ROW), words, shade)
    if {"section_x", "section_y"} <= set(part):
        sections(ax, part, edges["section"])


def panel_title(part: Dataset) -> str:
    """Return a panel's letter with its clearance and gear ratio, as far as they are known."""
    known = [f"({part['panel'].item()})"]
    if "clearance" in part.coords:
        known.append(f"$e$ = {1e3 * float(part['clearance']):.3g} mm,")
    if "gear_ratio" in part.coords:
        known.append(f"$i$ = {float(part['gear_ratio']):g}")
    return " ".join(known)


def growth(one: Dataset) -> str:
    """Return the growth of a difference with its standard error."""
    value, error = float(one["growth"]), float(one["growth_standard_error"])
    if not np.isfinite(value):
        return "\N{EN DASH}"
    words = f"{value:+.3f}".replace("-", "\N{MINUS SIGN}")
    digits = 2 if error >= SMALL else 1
    return f"{words}\n± {plain(error, digits)}" if np.isfinite(error) else words


def sections(ax: Axes, part: Dataset, left: float) -> None:
    """Draw the stored section points of each reading in a circle of the clearance."""
    from matplotlib.patches import Circle

    x, y = (part[f"section_{axis}"].transpose("reading", ...).values for axis in "xy")
    size = np.hypot(x, y)
    reach = 1.1 * max(1.0, float(np.max(size, initial=0.0, where=np.isfinite(size))))
    scale = ROW / 2 / reach
    middle, rows = left + COLUMNS["section"] / 2, HEAD + ROW * (np.arange(part.sizes["reading"]) + 0.5)
    look = {"color": style.BLACK, "markeredgewidth": 0, "rasterized": True, "linestyle": "none"}
    for row, xs, ys in zip(rows, x, y, strict=True):
        ax.add_patch(Circle((middle, row), scale, facecolor=style.DISC, edgecolor=style.GREY, linewidth=0.4))
        size = 1.6 if artists.spots(xs, ys) < FEW else 0.6
        ax.plot(middle + scale * xs, row - scale * ys, "o", markersize=size, **look)
