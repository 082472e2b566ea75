"""Tolerances: samples of a quantity with its limit, what an event hangs on, and where it happens."""

from __future__ import annotations

from textwrap import fill
from typing import Any

import numpy as np

from jointplay.display import codes
from jointplay.display.number_text import percent, raised, shown
from jointplay.figures.drawing import Axes, Dataset, Figure, artists, select, style
from jointplay.figures.registry import picture

BINS, NAMES = 30, 17  # of a histogram; letters in a line of a parameter's name
COLOURS = {"no": style.BLUE, "yes": style.AMBER, "undecided": style.GREY, "failed": style.WARNING}
ABOVE = "above:"  # before the name of a quantity, its event of exceeding the limit
WITHIN, BEYOND = "within_limits", ("beyond a limit", "within all limits")
MARKERS = {"no": "o", "yes": "^", "undecided": "s", "failed": "x"}


@picture(least=180)
def tolerances(dataset: Dataset, *, event: str | None = None, quantity: str | None = None) -> Figure:
    """Draw samples by a quantity and by the two parameters that an event hangs on most, and their shares.

    Parameters
    ----------
    dataset : Dataset
        What `jointplay.tolerances` returned.
    event : str, optional
        Whose outcomes are the colours, as the dimension ``event`` has it; by default the one with a limit, or
        the first one that happens to some samples and not to all.
    quantity : str, optional
        Of the histogram; by default that of the event, or the first; without quantities the parameter that
        the event hangs on most.
    """
    select.require(dataset, "tolerances", ("value", "outcome", "parameter_name"))
    event = _event(dataset, event)
    order = _order(dataset, event)
    shares, pair = _shares(dataset, event), len(order) > 1
    bars = shares is not None and shares.sizes["factor"] > 1 and bool(np.isfinite(shares["total"]).any())
    figure = style.sheet(style.COLUMNS["double" if bars or pair else "single"], 66.0)
    axes = figure.subplots(1, 1 + bars + pair, squeeze=False)[0]
    _histogram(axes[0], dataset, event, quantity, order)
    if bars:
        _bars(axes[1], shares)
    if pair:
        _scatter(axes[-1], dataset, event, order)
    artists.shared_legend(figure, (axes[0], axes[-1]) if pair else axes[:1])
    artists.letter(axes)
    return artists.finish(figure, dataset)


def _event(dataset: Dataset, given: str | None) -> str:
    """The event whose outcomes are shown; empty where none was asked."""
    names = [str(name) for name in dataset["event"].values]
    if given is not None:
        return select.choice("event", given, names, "event")
    shares = dict(zip(names, dataset["share"].values if "share" in dataset else [], strict=False))
    some = [name for name in names if 0 < shares.get(name, 0) < 1]
    return next((name for name in some if name.startswith(ABOVE)), next(iter([*some, *names]), ""))


def _shares(dataset: Dataset, event: str) -> Dataset | None:
    """Results by the event, or by the first output that has shares; None without any."""
    if "total" not in dataset:
        return None
    return dataset.sel(output=event) if event else dataset.isel(output=0)


def _order(dataset: Dataset, event: str) -> list[int]:
    """Parameters by their total share of the event, or of the first output that has one; else as they are."""
    count = dataset.sizes["parameter"]
    if (one := _shares(dataset, event)) is None:
        return list(range(count))
    totals = one["total"]
    keys = [str(name).partition(" + ")[0] for name in dataset["factor"].values]
    known = dict(zip(keys, np.nan_to_num(totals.values), strict=True))
    sizes = [known.get(str(key), -1.0) for key in dataset["parameter"].values]
    return [int(i) for i in np.argsort(-np.array(sizes), kind="stable")]


def _outcomes(dataset: Dataset, event: str) -> np.ndarray:
    """Word of each sample."""
    if not event:
        return np.full(dataset.sizes["sample"], "no")
    return codes.words(dataset["outcome"]).sel(event=event).values


def _label(word: str, event: str) -> str:
    if word in ("no", "yes") and event:
        name = event.replace("_", " ")
        pair = ("within the limit", "above the limit") if event.startswith(ABOVE) else (f"no {name}", name)
        return (BEYOND if event == WITHIN else pair)[word == "yes"]
    return word if event else "samples"


def _histogram(ax: Axes, dataset: Dataset, event: str, quantity: str | None, order: list[int]) -> None:
    """Samples by a quantity, stacked by their outcome, with the limit."""
    words = _outcomes(dataset, event)
    names = [str(name) for name in dataset["quantity"].values] if "quantity" in dataset.dims else []
    own = quantity or event.removeprefix(ABOVE)
    if quantity is not None:
        select.choice("quantity", quantity, names, "quantity")
    if names:
        at = names.index(own) if own in names else 0
        values, units = dataset["quantity_value"].values[:, at], str(dataset["quantity_units"].values[at])
        name, shown_ = str(dataset["quantity_name"].values[at]), names[at]
    else:
        values, units = dataset["value"].values[:, order[0]], str(dataset["parameter_units"].values[order[0]])
        name, shown_ = str(dataset["parameter_name"].values[order[0]]), ""
    unit = shown(values, units)
    there = [word for word in COLOURS if np.isfinite(values[words == word]).any()]
    groups = [values[(words == word) & np.isfinite(values)] * unit.factor for word in there]
    if not there:
        artists.say(ax, "No sample ended with a value")
        return
    look: dict[str, Any] = {"stacked": True, "label": [_label(word, event) for word in there]}
    ax.hist(groups, bins=BINS, color=[COLOURS[word] for word in there], **look)
    if event == f"{ABOVE}{shown_}":
        limit = float(dataset["limit"].sel(event=event)) * unit.factor
        ax.axvline(limit, color="black", linewidth=1.0, linestyle="--", label="limit")
    label = artists.broken(artists.with_unit(artists.capital(name), raised(unit.symbol)), 2 * NAMES)
    ax.set(ylabel="Samples", xlabel=label)
    if event and "share" in dataset:
        one = dataset.sel(event=event)
        numbers = percent(*(float(one[key]) for key in ("share", "share_low", "share_high")))
        unbroken = numbers.replace(" ", "\N{NO-BREAK SPACE}")
        artists.heading(ax, f"{artists.capital(_label('yes', event))}: {unbroken}")


def _bars(ax: Axes, one: Dataset) -> None:
    """First-order and total shares with their intervals."""
    rows = np.arange(one.sizes["factor"])
    for name, off, colour in (("first_order", -0.19, style.BLUE), ("total", 0.19, style.AMBER)):
        value = np.clip(np.nan_to_num(one[name].values), 0.0, None)
        ends = [np.clip(np.nan_to_num(one[f"{name}_{end}"].values), 0.0, 1.0) for end in ("low", "high")]
        error = np.clip([value - ends[0], ends[1] - value], 0.0, None)
        text = name.replace("_", " ").replace("first order", "alone").replace("total", "with others")
        ax.barh(rows + off, value, height=0.36, color=colour, label=text)
        ax.errorbar(value, rows + off, xerr=error, fmt="none", ecolor="black", elinewidth=0.8)
    names = [fill(artists.capital(str(name)), NAMES) for name in one["factor_name"].values]
    ax.set_yticks(rows, names)
    ax.invert_yaxis()
    ax.set(xlim=(0.0, 1.0), xlabel="Share of the variance")
    ax.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.0)  # bars may fill the panel


def _scatter(ax: Axes, dataset: Dataset, event: str, order: list[int]) -> None:
    """Samples over the two first parameters, with the edge where one is located."""
    words, values = _outcomes(dataset, event), dataset["value"].values
    names, nouns = ([str(each) for each in dataset[key].values] for key in ("parameter", "parameter_name"))
    pair = order[:2]
    along = str(dataset.attrs.get("edge_parameter", ""))
    edge = "edge_line" in dataset and str(dataset["edge_event"].values) == event and along in names
    if edge and names.index(along) in pair:
        pair = sorted(pair, key=lambda i: names[i] != along)
    units = [shown(values[:, i], str(dataset["parameter_units"].values[i])) for i in pair]
    x, y = (values[:, i] * unit.factor for i, unit in zip(pair, units, strict=True))
    for word, colour in COLOURS.items():
        if (own := words == word).any():
            look = {"linestyle": "none", "markersize": 2.6, "markeredgewidth": 0.8 * (word == "failed")}
            ax.plot(x[own], y[own], MARKERS[word], color=colour, label=_label(word, event), **look)
    if edge and names[pair[0]] == along:
        firsts = [str(name).partition(" + ")[0] for name in dataset["factor"].values]
        limits = ax.get_xlim(), ax.get_ylim()
        for one in dataset["edge_line"].values if names[pair[1]] in firsts else ():
            across = dataset["edge_across"].values[firsts.index(names[pair[1]])]
            line = one[firsts.index(names[pair[1]])]
            ax.plot(
                line * units[0].factor, across * units[1].factor, color="black", linewidth=1.0, label="edge"
            )
        ax.set(xlim=limits[0], ylim=limits[1])
    labels = [
        artists.broken(artists.with_unit(artists.capital(nouns[i]), raised(unit.symbol)), 2 * NAMES)
        for i, unit in zip(pair, units, strict=True)
    ]
    ax.set(xlabel=labels[0], ylabel=labels[1])
