"""What tips motions: the smallest knock of each kind, and how soon starts are with each motion."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from xarray import Dataset

from jointplay.display.units import shown
from jointplay.figures.drawing import artists, select, style
from jointplay.figures.registry import picture
from jointplay.figures.states.attractors import COLOURS, REST

NAMES = {"impulse": "Impulse on", "shift": "Shift of journal", "state": "Change of"}
WIDE = 0.8  # of the place of a kind of knock, that its bars take


@picture()
def tipping(dataset: Dataset) -> Figure:
    """Draw the smallest knocks that tip, a bar for each motion and kind, and fractions reached over turns.

    Parameters
    ----------
    dataset : Dataset
        What `jointplay.tipping` returned.
    """
    select.require(dataset, "tipping", ("knock_size", "fraction_reached"))
    kinds = [str(each).partition(":")[0] for each in dataset["knock"].values]
    groups = [kind for kind in NAMES if kind in kinds]
    figure = style.sheet(88.0, 44.0 + 40.0 * len(groups))
    axes = figure.subplots(1 + len(groups), 1, squeeze=False)[:, 0]
    for ax, kind in zip(axes, groups, strict=False):
        bars(ax, dataset.isel(knock=[n for n, each in enumerate(kinds) if each == kind]), NAMES[kind])
    within(axes[-1], dataset)
    if dataset.sizes["number"]:
        figure.legend(loc="outside lower left", ncols=2, handles=axes[-1].get_lines())
    return artists.finish(figure, dataset)


def colour(number: int) -> str:
    """Return the colour of a motion."""
    return COLOURS[number - 1] if number <= len(COLOURS) else REST


def bars(ax: Axes, dataset: Dataset, name: str) -> None:
    """Draw a bar for each motion and knock, and the motion that it leads to, if that is sure."""
    sizes = dataset["knock_size"].transpose("knock", "number").values
    unit = shown(sizes[np.isfinite(sizes)], str(dataset["knock_units"].values[0]))
    width = WIDE / max(dataset.sizes["number"], 1)
    for n, number in enumerate(dataset["number"].values.tolist()):
        x = np.arange(len(sizes)) + (n + 0.5) * width - WIDE / 2
        ax.bar(x, sizes[:, n] * unit.factor, width, color=colour(number))
        ends, sure = (dataset[key].sel(number=number).values for key in ("above_reaches", "knock_confirmed"))
        for place, size, end, confirmed in zip(x, sizes[:, n], ends, sure, strict=True):
            word = "none" if np.isnan(size) else f"\N{RIGHTWARDS ARROW}{end}" if confirmed else "?"
            height = np.nan_to_num(size * unit.factor)
            ax.annotate(word, (place, height), (0, 1), textcoords="offset points", ha="center", fontsize=6)
    labels = [str(each).partition(":")[2] for each in dataset["knock"].values]
    ax.set_xticks(range(len(labels)), labels)
    ax.set_ylabel(f"{name}\n({unit.symbol})")
    ax.margins(y=0.18)
    ax.set_ylim(bottom=0.0)


def within(ax: Axes, dataset: Dataset) -> None:
    """Draw the fraction of the starts that are with each motion after so many turns."""
    for number in dataset["number"].values.tolist():
        one = dataset.sel(number=number)
        period = int(one["period"])
        label = f"{number}: {f'period {period}' if period else 'no period'}"
        look = {"color": colour(number), "linestyle": "-", "label": label}
        ax.plot(one["within"].values, one["fraction_reached"].values, **look)
    ax.set(ylim=(0, 1), xlabel="Turns", ylabel="Fraction of starts\nthere by then (\N{EN DASH})")
