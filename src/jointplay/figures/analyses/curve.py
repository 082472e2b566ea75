"""Curves in the plane of two parameters along which a periodic orbit changes, and where they meet."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import cycle

import numpy as np

from jointplay.display import codes
from jointplay.figures.analyses.parameter_map import panel
from jointplay.figures.drawing import Axes, Dataset, Figure, artists, select, style, sweep_axes
from jointplay.figures.drawing.artists import through
from jointplay.figures.registry import picture

LOOKS = {  # kind of curve: colour and dashes, which tell them apart in grey too
    "fold": (style.BLACK, "-"),
    "period_doubling": (style.BLUE, (0, (5, 1.2))),
    "neimark_sacker": ("#7b3294", (0, (4, 1, 1, 1))),
    "symmetry_breaking": ("#007a53", (0, (2, 1))),
    "grazing": (style.WARNING, (0, (1, 1))),
    "coincidence": ("#8c510a", (0, (3, 1, 1, 1, 1, 1))),
}
MARKED = {"linestyle": "none", "markerfacecolor": "white", "color": style.BLACK}
MARKED |= {"markeredgewidth": 0.9, "zorder": 3.2}
SIZES = np.linspace(6.4, 2.4, 4)  # the later on top and smaller: two kinds at one place are both seen
HALO = {"linewidth": 2.6, "foreground": "white"}  # around a curve: seen on a dark map too
SIGNS = "osD^v<>pP*"  # of the kinds of points at which curves meet
EXPONENTS = ("section_exponent_per_turn", "lyapunov_exponent_per_turn", "period")


@picture()
def curve(dataset: Dataset, *, over: Dataset | None = None, shown: str | None = None) -> Figure:
    """Draw the curves over both parameters.

    Parameters
    ----------
    dataset : Dataset
        What `jointplay.curve` returned.
    over : Dataset, optional
        A bifurcation diagram over the same two parameters, which is drawn underneath.
    shown : str, optional
        Which number of it; its exponent, or period, if left out.
    """
    if dataset.attrs.get("kind") != "curve" or "parameters" not in dataset.attrs:
        raise select.refuse("kind", "curve", "a result of a study of kind curve")
    figure = style.sheet(120.0, 96.0)
    ax = figure.subplots()
    names = background(ax, dataset, over, shown)
    units = [artists.displayed(dataset[name])[1] for name in names]
    if over is None:
        artists.name_axes(ax, dataset[names[0]], units[0], dataset[names[1]], units[1])
    else:
        units = [artists.displayed(over[name])[1] for name in names]
    factors = np.array([unit.factor for unit in units])
    kinds = codes.words(dataset["curve_kind"]).values
    for number, kind in enumerate(kinds):
        line(ax, dataset.isel(curve=number), names, factors, kind)
    meetings(ax, dataset, names, factors)
    explain(figure, ax, kinds)
    if not len(kinds):
        artists.say(ax, "no curve was found")
    return artists.finish(figure, dataset)


def background(ax: Axes, dataset: Dataset, over: Dataset | None, shown: str | None) -> list[str]:
    """Draw the map that lies underneath, if there is one; return the parameters along x and y."""
    names = str(dataset.attrs["parameters"]).split()
    if over is None:
        return names
    known = sweep_axes.parameters(over, "parameter_map")
    if sorted(known) != sorted(names):
        raise select.refuse("over", known, f"a map over {' and '.join(names)} is accepted")
    part = sweep_axes.chosen(over, select.label(over, "direction", None), 0).isel(direction=0)
    part = part.isel(start=0) if "start" in part.dims else part
    numbers = [str(name) for name, each in part.data_vars.items() if set(known) <= set(each.dims)]
    if shown is not None and shown not in numbers:
        raise select.refuse("shown", shown, f"a number of the map, {', '.join(numbers)}, is accepted")
    array = part[shown or next(name for name in EXPONENTS if name in part)]
    array = array.isel({dim: 0 for dim in array.dims if dim not in known})
    panel(ax, part, array, known, "")
    return known[::-1]


def line(ax: Axes, one: Dataset, names: Sequence[str], factors: np.ndarray, kind: str) -> None:
    """Draw one curve by its points and directions."""
    from matplotlib.patheffects import withStroke

    count = int(one["n_points"])
    points, slopes = (
        np.stack([one[f"{name}{suffix}"].values[:count] for name in names], -1) * factors
        for suffix in ("", "_tangent")
    )
    spans = np.ptp(points, axis=0)
    spans = np.where(spans > 0, spans, 1.0)
    colour, dashes = LOOKS[kind]
    path = through(points / spans, slopes / spans) * spans
    look = {"color": colour, "linestyle": dashes, "linewidth": 1.2}
    ax.plot(*path.T, **look, zorder=2.5, path_effects=[withStroke(**HALO)])


def meetings(ax: Axes, dataset: Dataset, names: Sequence[str], factors: np.ndarray) -> None:
    """Mark the points at which curves meet others, a sign for each kind."""
    x, y = (dataset[f"meeting_{name}"].values * factor for name, factor in zip(names, factors, strict=True))
    kinds = codes.words(dataset["meeting_kind"]).values
    for kind, sign, size in zip(dict.fromkeys(kinds), cycle(SIGNS), cycle(SIZES)):
        there = kinds == kind
        ax.plot(x[there], y[there], sign, markersize=size, label=_met(kind), **MARKED)


def explain(figure: Figure, ax: Axes, kinds: Sequence[str]) -> None:
    """Name the kinds of curves, and of the points at which they meet, below the panel."""
    handles = [
        artists.sample(color=LOOKS[kind][0], linestyle=LOOKS[kind][1], label=_name(kind))
        for kind in LOOKS
        if kind in kinds
    ]
    handles += [line for line in ax.get_lines() if not line.get_label().startswith("_")]
    if handles:
        figure.legend(handles=handles, loc="outside lower center", ncols=min(len(handles), 3))


def _met(kind: str) -> str:
    return "two grazings" if kind == "grazing" else _name(kind).replace(" grazing", " and grazing")


def _name(kind: str) -> str:
    if kind.startswith("resonance"):
        return "resonance " + ":".join(kind.split("_")[1:])
    return kind.replace("neimark_sacker", "Neimark-Sacker").replace("_", " ")
