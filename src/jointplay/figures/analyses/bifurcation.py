"""Bifurcation diagram: section points over a parameter, below them the largest exponent and the period."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from jointplay.display.number_text import Shown, measure
from jointplay.figures.drawing import Axes, DataArray, Dataset, Figure, artists, select, style, sweep_axes
from jointplay.figures.registry import picture

USUAL = ("journal_x", "eccentricity_ratio", "state_value")
ERRORS = 2  # standard errors on either side of an exponent
CLASSES = (1, 2, 3, 4, 6, 8, 12, 16)
SIZES = (1e3, 3e4), (1.8, 0.6)  # of points, pt, by their number
RIGHT = 0.85  # of the panel's width, from where on a label stands left of its line
HEADROOM = 0.07  # of a panel: for the labels of lines
ROWS = {"points": 2.0, "exponent": 1.0, "period": 0.8, "separations": 0.8}


class Frame(NamedTuple):
    """Parameter and quantity on a diagram's axes, and the units that both are drawn in."""

    parameter: str
    quantity: DataArray
    x: Shown
    y: Shown


@picture(
    checks={"at": lambda at: first_value(at), "limits": lambda given: lines(given)}, fits=sweep_axes.fits
)
def bifurcation(
    dataset: Dataset,
    *,
    quantity: str | None = None,
    link: str | None = None,
    joint: str | None = None,
    direction: str | None = None,
    start: int | None = None,
    at: float | None = None,
    limits: Sequence[Any] | None = None,
    period: bool = False,
    separations: bool = False,
) -> Figure:
    """Draw section points over the varied parameter; below, exponents where there are any.

    Parameters
    ----------
    dataset : Dataset
        What `jointplay.bifurcation` returned.
    quantity : str, optional
        The recorded quantity, or a test system's state by its name.
    link, joint : str, optional
        Of which link or joint; by default the first.
    direction : {"up", "down", "reset"}, optional
        One direction alone; by default all, in colours.
    start : int, optional
        One start alone.
    at : float, optional
        Of two varied parameters, the value of the first; by default its first value.
    limits : sequence, optional
        Values of the parameter, in its stored units, drawn as vertical lines: numbers, or pairs of a number
        and a label.
    period : bool
        Draw the period below.
    separations : bool
        Draw below how often contact is lost, at the joint where that is most.
    """
    marked, switches = lines(limits), {"period": period, "separations": separations}
    part, name = sweep_axes.one_parameter(sweep_axes.chosen(dataset, direction, start), at)
    rows = ["points", *["exponent"] * (sweep_axes.exponents(part) is not None)]
    rows += [row for row, given in switches.items() if select.switch(row, given)]
    figure = style.sheet(180.0, 52.0 + 34.0 * len(rows))
    heights = [ROWS[row] for row in rows]
    axes = figure.subplots(len(rows), 1, sharex=True, squeeze=False, height_ratios=heights)[:, 0]
    frame = diagram(axes[0], part, quantity=quantity, link=link, joint=joint)
    below = {"exponent": exponents, "period": periods, "separations": losses}
    for row, ax in zip(rows[1:], axes[1:], strict=True):
        below[row](ax, part, name, frame.x)
        axes[0].set_xlabel("")
    for number, ax in enumerate(axes):
        mark(ax, marked, frame.x, named=number == 0)
    sweep_axes.parameter_axis(axes[-1], part[name])
    for held in (part[other] for other in sweep_axes.varied(dataset) if other != name):
        artists.heading(axes[0], select.title(held), measure(float(held), held.attrs["units"]))
    artists.letter(axes)
    return artists.finish(figure, dataset)


def diagram(
    ax: Axes,
    dataset: Dataset,
    *,
    quantity: str | None = None,
    link: str | None = None,
    joint: str | None = None,
    look: Mapping[str, Any] | None = None,
) -> Frame:
    """Draw section points over a sweep's parameter, with labels, units, scale and legend, on given axes.

    What else is drawn over the diagram (branches of orbits, say) goes at stored values times the factors of
    the `Frame`: ``ax.plot(x * frame.x.factor, y * frame.y.factor)``.

    The dataset is a sweep of one parameter (`sweep_axes.one_parameter`). By default colours tell directions
    and starts, and the size of points how many there are; `look` is instead that of all, without a legend.
    """
    (name,) = sweep_axes.parameters(dataset, "bifurcation")
    array = sought(dataset, quantity)
    array = select.labelled_slice(array, dataset, (name, "point", *sweep_axes.SWEEPS), link=link, joint=joint)
    _, y_unit = artists.displayed(array)
    x_unit = sweep_axes.parameter_axis(ax, dataset[name])
    size = float(np.interp(array.size, SIZES[0], SIZES[1]))
    handles = []
    for one, own in sweep_axes.motions(dataset.assign(drawn=array)):
        y = one["drawn"].transpose(name, "point").values * y_unit.factor
        x = np.broadcast_to((one[name].values * x_unit.factor)[:, None], y.shape)
        there, dots = np.isfinite(y), {"marker": "o", "linestyle": "none", "color": own["color"]}
        wide = {"markersize": own["size"] * size, "markeredgewidth": 0, "rasterized": True}
        ax.plot(x[there], y[there], **(dots | wide | dict(look or {})))
        if own["label"] not in ("", "_") and not look:
            handles.append(artists.sample(markersize=3, label=own["label"], **dots))
    artists.name_y(ax, array, y_unit, longest=30)
    if handles:
        ax.legend(
            handles=handles[::-1], loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, borderaxespad=0.2
        )
    return Frame(name, array, x_unit, y_unit)


def sought(dataset: Dataset, quantity: str | None) -> DataArray:
    """Return the quantity at section points; by default a usual one."""
    known = select.names(dataset, "point")
    if quantity is None:
        quantity = next((name for name in USUAL if name in known), known[0] if known else "")
    return select.variable(dataset, quantity, "quantity", "point")


def exponents(ax: Axes, dataset: Dataset, name: str, unit: Shown) -> None:
    """Draw exponents of the section's map with their error bands, and where they change sign."""
    x = dataset[name].values * unit.factor
    ax.axhline(0.0, color=style.GREY, linewidth=0.6)
    for one, look in sweep_axes.motions(dataset):
        means, spreads = sweep_axes.exponents(one)
        for k in range(means.sizes["number"]):
            values, errors = means.isel(number=k).values, ERRORS * spreads.isel(number=k).values
            faded = {"color": look["color"], "linestyle": "-" if k == 0 else (0, (1.5, 1))}
            artists.curve(ax, x, np.where(np.isfinite(values), values, np.nan), linewidth=0.7, **faded)
            ax.fill_between(x, values - errors, values + errors, color=look["color"], alpha=0.25, linewidth=0)
    largest = "Largest exponent" if means.sizes["number"] == 1 else "Largest exponents"
    ax.set_ylabel(f"{largest}\nper turn")


def periods(ax: Axes, dataset: Dataset, name: str, unit: Shown) -> None:
    """Draw periods up to 16, and where none was found."""
    from matplotlib.ticker import FixedLocator, NullLocator

    top, values = 2 * CLASSES[-1], dataset["period"]
    shown = values.where((values >= 0) & (values <= CLASSES[-1])).where(values != 0, top)
    _dots(ax, dataset.assign(drawn=shown), name, unit)
    ax.set(yscale="log", ylim=(0.8, 1.3 * top), ylabel="Period (turns)")
    ax.yaxis.set_major_locator(FixedLocator([1, 2, 4, 8, 16, top]))
    ax.yaxis.set_minor_locator(NullLocator())
    ax.set_yticklabels(["1", "2", "4", "8", "16", "none"])


def losses(ax: Axes, dataset: Dataset, name: str, unit: Shown) -> None:
    """Draw how often contact is lost in a turn, at the joint where that is most."""
    if "separations" not in dataset:
        raise select.refuse("separations", True, "false: how often contact is lost was not recorded")
    lost = dataset["separations"]
    _dots(ax, dataset.assign(drawn=lost.max([dim for dim in lost.dims if dim == "joint"])), name, unit)
    ax.set_ylabel("Contacts lost\nper turn")


def _dots(ax: Axes, dataset: Dataset, name: str, unit: Shown) -> None:
    for one, look in sweep_axes.motions(dataset):
        dots = {"marker": "o", "markersize": 1.6 * look["size"], "markeredgewidth": 0, "linestyle": "none"}
        ax.plot(one[name].values * unit.factor, one["drawn"].values, color=look["color"], **dots)


def first_value(at: Any) -> None:
    """Refuse a value that is no number."""
    if not select.is_number(at):
        raise select.refuse("at", at, "a value of the first of two parameters")


def lines(limits: Any) -> list[tuple[float, str]]:
    """Return the values and labels of vertical lines."""
    expected = "a list of values of the parameter, or of [value, label]"
    if limits is None:
        return []
    if not isinstance(limits, list | tuple):
        raise select.refuse("limits", limits, expected)
    found = [tuple(one) if isinstance(one, list | tuple) else (one, "") for one in limits]
    for given, one in zip(limits, found, strict=True):
        if len(one) != 2 or not select.is_number(one[0]) or not isinstance(one[1], str):
            raise select.refuse("limits", given, expected)
    return found


def mark(ax: Axes, marked: list[tuple[float, str]], unit: Shown, named: bool) -> None:
    """Draw vertical lines at values of the parameter, with their labels along them, above all else."""
    if named and any(label for _, label in marked):
        ax.set_ylim(top=ax.transData.inverted().transform(ax.transAxes.transform((0, 1 + HEADROOM)))[1])
    for value, label in marked:
        ax.axvline(value * unit.factor, color=style.WARNING, linewidth=0.7, linestyle=(0, (4, 2)), zorder=3)
        along = ax.transAxes.inverted().transform(ax.transData.transform((value * unit.factor, 0.0)))[0]
        if named and label and 0.0 <= along <= 1.0:
            side = {"ha": "right", "xytext": (-2, -3)} if along > RIGHT else {"ha": "left", "xytext": (2, -3)}
            place = {"xy": (value * unit.factor, 1.0), "xycoords": ("data", "axes fraction"), **side}
            ax.annotate(label, **place, textcoords="offset points", va="top", color=style.WARNING)
