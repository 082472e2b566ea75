"""Tipping of motions: the smallest knock of each kind, and starts with each motion over turns."""

from __future__ import annotations

import numpy as np

from jointplay.display.number_text import shown
from jointplay.figures.analyses.attractors import band
from jointplay.figures.drawing import Axes, Dataset, Figure, artists, select, style
from jointplay.figures.registry import picture

NAMES = {  # kinds of knock: what is smallest, and of what
    "impulse": ("Smallest angular impulse", "Link"),
    "blow": ("Smallest impulse", "Joint"),
    "shift": ("Smallest shift of the journal", "Joint"),
    "state": ("Smallest change", "State"),
}
LONGEST = 20  # characters of a label in a line
DASHES = ("-", (0, (5, 1.5)), (0, (6, 1, 1, 1)), (0, (1.5, 1)))
WIDE = 0.8  # of the place of a kind of knock, that its bars take


@picture()
def tipping(dataset: Dataset) -> Figure:
    """Draw the smallest knocks that tip, a bar for each motion and kind, and fractions reached over turns.

    Parameters
    ----------
    dataset : Dataset
        What `jointplay.tipping` returned.
    """
    from matplotlib.legend_handler import HandlerTuple

    select.require(dataset, "tipping", ("knock_size", "fraction_reached"))
    kinds = [str(each).partition(":")[0] for each in dataset["knock"].values]
    groups = [kind for kind in NAMES if kind in kinds]
    figure = style.sheet(88.0, 44.0 + 40.0 * len(groups))
    axes = figure.subplots(1 + len(groups), 1, squeeze=False)[:, 0]
    for ax, kind in zip(axes, groups, strict=False):
        bars(ax, dataset.isel(knock=[n for n, each in enumerate(kinds) if each == kind]), NAMES[kind])
    if groups:
        artists.heading(axes[0], "\N{RIGHTWARDS ARROW}: motion that it leads to")
    within(axes[-1], dataset)
    artists.letter(axes)
    if dataset.sizes["number"]:
        lines, kinds = axes[-1].get_lines(), {tuple: HandlerTuple(None)}
        pairs = [(artists.swatch(**band(place)), line) for place, line in enumerate(lines)]
        words = [line.get_label() for line in lines]
        figure.legend(pairs, words, loc="outside lower left", ncols=2, handler_map=kinds)
    return artists.finish(figure, dataset)


def bars(ax: Axes, dataset: Dataset, names: tuple[str, str]) -> None:
    """Draw a bar for each motion and knock, where it leads, and `?` if unconfirmed."""
    sizes = dataset["knock_size"].transpose("knock", "number").values
    unit = shown(sizes[np.isfinite(sizes)], str(dataset["knock_units"].values[0]))
    width = WIDE / max(dataset.sizes["number"], 1)
    for n, number in enumerate(dataset["number"].values.tolist()):
        x = np.arange(len(sizes)) + (n + 0.5) * width - WIDE / 2
        ax.bar(x, sizes[:, n] * unit.factor, width, **band(number - 1))
        ends, sure = (dataset[key].sel(number=number).values for key in ("knock_reaches", "knock_confirmed"))
        for place, size, end, confirmed in zip(x, sizes[:, n], ends, sure, strict=True):
            reached = f"\N{RIGHTWARDS ARROW}{end if end > 0 else ''}{'' if confirmed else '?'}"
            word = "none" if np.isnan(size) else reached
            height = np.nan_to_num(size * unit.factor)
            ax.annotate(word, (place, height), (0, 1), textcoords="offset points", ha="center", fontsize=6)
    labels = [str(each).partition(":")[2] for each in dataset["knock"].values]
    ax.set_xticks(range(len(labels)), labels)
    ax.set_xlim(-0.5, len(labels) - 0.5)
    ax.set_ylabel(artists.broken(artists.with_unit(names[0], unit.symbol), LONGEST))
    ax.set_xlabel(names[1])
    ax.margins(y=0.18)
    ax.set_ylim(bottom=0.0)


def within(ax: Axes, dataset: Dataset) -> None:
    """Draw the fraction of the starts that are with each motion after so many turns."""
    for number in dataset["number"].values.tolist():
        one = dataset.sel(number=number)
        period = int(one["period"])
        label = f"{number}: {f'period {period}' if period else 'no period'}"
        look = {"color": band(number - 1)["facecolor"], "linestyle": DASHES[(number - 1) // 2 % 4]}
        look["drawstyle"] = "steps-post"  # starts are looked at after so many turns, not in between
        ax.plot(one["within"].values, one["fraction_reached"].values, label=label, **look)
    ax.set(ylim=(0, 1), xlabel="Turns", ylabel="Fraction of starts\nsettled by then")
