"""Floquet multipliers in the complex plane, with the unit circle; a table of their sizes and exponents."""

from __future__ import annotations

import numpy as np

from jointplay.display import codes
from jointplay.display.number_text import plain
from jointplay.figures.drawing import Axes, Dataset, Figure, artists, select, style
from jointplay.figures.drawing.artists import lines
from jointplay.figures.registry import picture

MARGIN = 1.15
WIDEST = {True: 4.0, False: 2.0}  # of one orbit, of many; farther out: arrows at the edge, or nothing
TOP, ROW = 0.93, 0.085  # of a table's height
COLUMNS = {0.0: "left", 0.1: "left", 0.68: "right", 1.0: "right"}
LOST, BELOW, DASH = 1e-10, "< 10⁻¹⁰", "\N{EN DASH}"  # below it, multipliers are rounding
LISTED = 8


@picture()
def floquet(dataset: Dataset) -> Figure:
    """Draw multipliers of one orbit, with a table; or of all orbits of branches.

    Parameters
    ----------
    dataset : Dataset
        What `jointplay.periodic_orbit` or `jointplay.continuation` returned.
    """
    expected = "a result of a study of kind periodic_orbit or continuation"
    select.require(dataset, "floquet", ["floquet_multiplier"], expected)
    one = "branch" not in dataset.dims
    figure = style.sheet(180.0 if one else 88.0, 84.0)
    axes = figure.subplots(1, 2 if one else 1, squeeze=False, width_ratios=(1, 1) if one else None)[0]
    plane(axes[0], dataset, one)
    if one:
        table(axes[1], dataset)
    artists.letter(axes)
    return artists.finish(figure, dataset)


def plane(ax: Axes, dataset: Dataset, one: bool) -> None:
    """Draw the unit circle and multipliers; of one orbit, multipliers far outside as arrows at the edge."""
    from matplotlib.patches import Circle

    real, imaginary = (
        dataset["floquet_multiplier"].sel(part=part).values.ravel() for part in ("real", "imaginary")
    )
    there = np.isfinite(real)
    x, y = real[there], imaginary[there]
    reach = MARGIN * float(np.clip(np.hypot(x, y).max(initial=1.0), 1.0, WIDEST[one]))
    ax.add_patch(Circle((0, 0), 1, facecolor=style.DISC, edgecolor=style.GREY, linewidth=0.6, zorder=0))
    inside = np.hypot(x, y) <= reach
    stable = np.hypot(x, y) < 1
    look = {"linestyle": "none", "marker": "o"}
    look |= (
        {"markersize": 4.5, "markeredgewidth": 0.8} if one else {"markersize": 1.6, "markeredgewidth": 0.4}
    )
    within, outside = inside & stable, inside & ~stable
    ax.plot(x[within], y[within], color=style.BLUE, **look, label="within: stable")
    look |= {"color": style.WARNING, "markerfacecolor": "white", "label": "outside: unstable"}
    ax.plot(x[outside], y[outside], **look)
    for a, b in zip(x[~inside] if one else (), y[~inside] if one else (), strict=True):
        end = np.array([a, b]) / np.hypot(a, b) * 0.97 * reach
        ax.annotate("", end, 0.8 * end, arrowprops={"arrowstyle": "->", "color": style.WARNING})
    ax.axhline(0, color=style.GREY, linewidth=0.4, zorder=0)
    ax.axvline(0, color=style.GREY, linewidth=0.4, zorder=0)
    ax.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal")
    ax.set(xlabel="Real part", ylabel="Imaginary part")
    if not there.any():
        artists.say(ax, "No orbit was found")


def table(ax: Axes, dataset: Dataset) -> None:
    """Write the multipliers and their exponents, stability and period."""
    ax.set_axis_off()
    multipliers, exponents = dataset["floquet_multiplier"].values, dataset["lyapunov_exponent"].values
    rows = [("", "multiplier", "modulus", "ln|µ|/T (1/s)")]
    for number, ((a, b), exponent) in enumerate(zip(multipliers, exponents, strict=True), 1):
        lost = float(np.hypot(a, b)) < LOST
        sign = "+" if b > 0 else "\N{MINUS SIGN}"
        shown = f"{plain(a, 5)} {sign} {plain(abs(b), 5)}i" if b else plain(a, 5)
        texts = (BELOW, BELOW, DASH) if lost else (shown, plain(float(np.hypot(a, b)), 5), plain(exponent, 5))
        rows.append((f"$\\mu_{{{number}}}$", *texts))
    lines(ax, rows[: LISTED + 1], COLUMNS, (TOP, ROW), remarks(dataset), 1.5)


def remarks(dataset: Dataset) -> list[str]:
    """Return lines on the orbit's stability and period, and on its residual."""
    if not np.isfinite(dataset["period"]):
        return ["no orbit was found"]
    word = codes.words(dataset["stable"]).item()
    turns, impacts = float(dataset["period"]), float(dataset["impacts"])
    return [
        f"{word}; period {turns:g} turn{'s' * (turns != 1)}, {plain(float(dataset['period_time']), 7)} s",
        f"{plain(impacts, 4)} contact{'s' * (impacts != 1)} begun per turn",
        f"residual {plain(float(dataset['residual']), 2)}",
    ]
