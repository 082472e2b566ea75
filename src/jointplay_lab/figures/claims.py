"""Claims: a paper's conclusions, the ratios by which each is graded beside a line at 1, and their grades."""

from __future__ import annotations

from textwrap import fill

import numpy as np

from jointplay.display import codes
from jointplay.figures.drawing import Axes, Dataset, Figure, artists, select, style
from jointplay.figures.registry import picture

ROW, AROUND, LINE = 6.5, 17.0, 3.4  # mm: a comparison, around a conclusion's, a line of words
LETTERS, NAMES, AWAY = 108, 30, 3.0  # in a line of words; a ratio from which the axis has logarithms
LOOKS = {  # of a ratio: what is concluded of it
    "as concluded": {"color": style.BLUE, "marker": "o"},
    "undecided": {"color": style.GREY, "marker": "D"},
    "not as concluded": {"color": style.AMBER, "marker": "s"},
}
OPEN = "not as concluded"
ERRORS = {"fmt": "none", "ecolor": style.GREY, "elinewidth": 0.8}


@picture(least=180)
def claims(dataset: Dataset) -> Figure:
    """Draw the ratios of what is compared, a row each, with the grade of the row and of the conclusion.

    Parameters
    ----------
    dataset : Dataset
        What `jointplay.claims` returned.
    """
    select.require(dataset, "claims", ("claim", "grade", "ratio", "compared"))
    each = [dataset.sel(claim=claim) for claim in dataset["claim"].values]
    rows = [np.flatnonzero(dataset["compared_for"].values == one["claim"].item()) for one in each]
    words = [fill(str(one["evidence"].item()).replace(" -", " \N{MINUS SIGN}"), LETTERS) for one in each]
    counts = zip(rows, words, strict=True)
    heights = [
        AROUND + (ROW * len(row) if len(row) else LINE * (1 + text.count("\n"))) for row, text in counts
    ]
    figure = style.sheet(180.0, sum(heights))
    places = figure.subfigures(len(each), 1, squeeze=False, height_ratios=heights)[:, 0]
    for place, one, row, text in zip(places, each, rows, words, strict=True):
        place.suptitle(title(one), x=0.01, ha="left", fontsize=8)
        ax = place.subplots()
        if len(row):
            ratios(ax, dataset.isel(comparison=row))
            ax.set_xlabel(f"Ratio: {str(one['evidence'].item()).partition(':')[0]}")
        else:
            ax.text(0.0, 1.0, text, transform=ax.transAxes, va="top", fontsize=7)
            ax.set_axis_off()
    drawn = [place.axes[0] for place, row in zip(places, rows, strict=True) if len(row)]
    if drawn:
        artists.shared_legend(places[-1], drawn, len(LOOKS))
    return artists.finish(figure, dataset)


def title(one: Dataset) -> str:
    """Return a conclusion with its grade."""
    text = str(one.get("claim_text", one["claim"]).item())
    return fill(f"{artists.capital(text)}: {codes.words(one['grade']).item()}", LETTERS)


def ratios(ax: Axes, part: Dataset) -> None:
    """Draw ratios with three standard errors, and the grade of each row at its right end."""
    from matplotlib.ticker import MaxNLocator

    values, holds = part["ratio"].values, part["ratio_holds"].values
    height = np.broadcast_to(np.arange(len(values))[:, None], values.shape)
    there = np.isfinite(values)
    of = {"as concluded": holds == 1, "undecided": there & np.isnan(holds), OPEN: holds == 0}
    ax.axvline(1.0, color=style.BLACK, linewidth=0.8)
    ax.errorbar(values[there], height[there], xerr=3 * part["ratio_error"].values[there], **ERRORS)
    for name, where in of.items():
        hollow = "white" if name == OPEN else LOOKS[name]["color"]
        look = {"markersize": 3.5, "linestyle": "none", "markerfacecolor": hollow}
        ax.plot(values[where], height[where], **look, **LOOKS[name], label=name)
    names = [
        fill(artists.capital(str(name)), NAMES, break_on_hyphens=False) for name in part["compared"].values
    ]
    ax.set_yticks(np.arange(len(values)), names)
    ax.set(ylim=(len(values) - 0.5, -0.5))
    if np.nanmax(values) > AWAY:
        ax.set_xscale("log")
    else:
        ax.xaxis.set_major_locator(MaxNLocator(8))
    grades = ax.secondary_yaxis("right")
    each = (part.isel(comparison=row) for row in range(len(values)))
    labels = [f"{codes.words(one['compared_grade']).item()}: {count(one)}" for one in each]
    grades.set_yticks(np.arange(len(values)), labels)
    for axis in (ax, grades):
        axis.tick_params(axis="y", length=0)


def count(row: Dataset) -> str:
    """Return how many of a row's ratios are as concluded, of those that are decided."""
    holds, there = row["ratio_holds"].values, np.isfinite(row["ratio"].values)
    decided = np.count_nonzero(np.isfinite(holds))
    rest = np.count_nonzero(there) - decided
    return f"{int(np.nansum(holds))} of {decided}" + (f", {rest} undecided" if rest else "")
