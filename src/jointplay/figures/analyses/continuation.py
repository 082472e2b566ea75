"""Branches of periodic orbits over a parameter: stable solid, unstable dashed, special points marked.

Between two points a branch is the cubic with its tangents at both; a straight line where these are not known,
as in old results, and where an event passed the section on the way: the quantity has a kink there.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from jointplay.display import codes
from jointplay.figures.analyses.bifurcation import Frame, diagram, lines, mark, sought
from jointplay.figures.drawing import Axes, DataArray, Dataset, Figure, artists, select, style, sweep_axes
from jointplay.figures.drawing.artists import BETWEEN, through
from jointplay.figures.registry import picture

COLOURS = (style.BLUE, style.AMBER, style.WARNING, "#2f9e44")  # by period; neighbours differ in grey too
STABLE, UNSTABLE = {"linestyle": "-", "linewidth": 1.0}, {"linestyle": (0, (3, 1.5)), "linewidth": 0.8}
MARKS = {  # kind of special point: marker, name
    "fold": ("s", "fold"),
    "branch_point": ("^", "branch point"),
    "period_doubling": ("o", "period doubling"),
    "neimark_sacker": ("D", "Neimark-Sacker"),
    "grazing": ("|", "grazing"),
}
OVER = {"color": style.BLACK, "markersize": 1.0, "zorder": 2.6}  # points of a diagram, seen on branches
UNDER = "bifurcation diagram"
SCALES, WIDTHS, AROUND = ("linear", "log"), (0.8, 1.0), 0.05  # of panels; of y beyond what is drawn


@picture(
    least=100,
    choices={"scale": SCALES},
    checks={"limits": lambda value: lines(value), "detail": lambda value: stretch(value)},
)
def continuation(
    dataset: Dataset,
    *,
    quantity: str | None = None,
    link: str | None = None,
    joint: str | None = None,
    multipliers: bool = False,
    limits: Sequence[Any] | None = None,
    scale: str = "linear",
    detail: Sequence[float] | None = None,
    over: Dataset | None = None,
) -> Figure:
    """Draw a quantity of orbits over the parameter.

    Parameters
    ----------
    dataset : Dataset
        What `jointplay.continuation` returned.
    quantity : str, optional
        A quantity on the section, a test system's state by its name, or a number of the orbit such as
        ``period_time``.
    link, joint, limits
        As in `bifurcation`.
    multipliers : bool
        Draw the moduli of the two largest multipliers below.
    scale : {"linear", "log"}
        Of the parameter.
    detail : pair, optional
        Values of the parameter between which the branches are drawn once more, enlarged, on the left; the
        panel says so where none reaches there.
    over : Dataset, optional
        A bifurcation diagram over the same parameter, drawn as small points.
    """
    if dataset.attrs.get("kind") != "continuation" or "parameter" not in dataset.attrs:
        raise select.refuse("kind", "continuation", "a result of a study of kind continuation")
    select.switch("multipliers", multipliers)
    marked = lines(limits)
    figure = style.sheet(180.0, 122.0 if multipliers else 86.0)
    heights, parts = (2, 1) if multipliers else (1,), [stretch(detail), ()] if detail is not None else [()]
    layout = {"height_ratios": heights, "width_ratios": WIDTHS[-len(parts) :]}
    axes = figure.subplots(len(heights), len(parts), sharex="col", squeeze=False, **layout)
    for column, part in zip(axes.T, parts, strict=True):
        frame = background(column[0], dataset, over, quantity, link, joint)
        branches(column[0], dataset, frame)
        if multipliers:
            moduli(column[1], dataset, frame)
            column[0].set_xlabel("")
        reach(column[0], dataset, frame, scale, part)
        shown = [one for one in marked if not part or part[0] <= one[0] <= part[1]]
        for number, ax in enumerate(column):
            mark(ax, shown, frame.x, named=number == 0)
    for ax in axes[:, 1:].ravel():
        ax.set_ylabel("")
    if "special" in dataset.dims or dataset.sizes.get("branch"):
        explain(figure, dataset, over is not None)
    artists.letter(axes.ravel())
    return artists.finish(figure, dataset)


def stretch(value: Any) -> tuple[float, ...]:
    """Return the ends of the stretch to be enlarged; none where none is asked for."""
    return (
        () if value is None else select.numbers("detail", value, 2, "two increasing values of the parameter")
    )


def reach(ax: Axes, dataset: Dataset, frame: Frame, scale: str, part: Sequence[float]) -> None:
    """Give the axis of the parameter its scale, or cut a panel down to a part of it, and to what is there."""
    x = dataset[frame.parameter].values * frame.x.factor
    if part:
        low, high = np.array(part) * frame.x.factor
        there = [
            line.get_ydata()[(line.get_xdata() >= low) & (line.get_xdata() <= high)] for line in ax.lines
        ]
        ax.set_xlim(low, high)
        if not (y := np.concatenate(there))[np.isfinite(y)].size:
            artists.say(ax, "No branch reaches this stretch")
            return
        pad = AROUND * (np.nanmax(y) - np.nanmin(y))
        ax.set_ylim(np.nanmin(y) - pad, np.nanmax(y) + pad)
    elif select.choice("scale", scale, SCALES) == "log":
        if not np.nanmin(x, initial=np.inf) > 0:
            raise select.refuse("scale", scale, "linear: values of the parameter are not all above 0")
        sweep_axes.logarithmic(ax, np.nanmin(x), np.nanmax(x))


def background(ax: Axes, dataset: Dataset, over, quantity, link, joint) -> Frame:
    """Draw the diagram that lies underneath, if there is one; label the axes, and return their frame."""
    name = dataset.attrs["parameter"]
    array = of_orbits(dataset, quantity, link, joint)
    if over is None:
        x_unit, y_unit = artists.displayed(dataset[name])[1], artists.displayed(array)[1]
        artists.name_axes(ax, dataset[name], x_unit, array, y_unit)
        return Frame(name, array, x_unit, y_unit)
    part, other = sweep_axes.one_parameter(over, None)
    if other != name:
        raise select.refuse("over", other, f"a diagram over {name} is accepted")
    under = diagram(ax, part, quantity=quantity, link=link, joint=joint, look=OVER)
    x, (low, high) = dataset[name].values * under.x.factor, ax.get_xlim()
    ax.set_xlim(np.nanmin(x, initial=low), np.nanmax(x, initial=high))
    return Frame(name, array, under.x, under.y)


def of_orbits(dataset: Dataset, quantity, link, joint) -> DataArray:
    """Return a quantity over branch, point and turn."""
    array = sought(dataset, quantity)
    array = select.labelled_slice(array, dataset, ("branch", "point", "turn"), link=link, joint=joint)
    if "turn" not in array.dims:
        array = array.expand_dims("turn", -1)
    return array.transpose("branch", "point", "turn")


def branches(ax: Axes, dataset: Dataset, frame: Frame) -> None:
    """Draw each branch, a line for each of its turns, and its special points."""
    x = dataset[frame.parameter].values * frame.x.factor
    y = frame.quantity.values * frame.y.factor
    slopes = tangents(dataset, frame)
    for b in range(len(x)):
        look = {"color": colour(dataset, b), "zorder": 2.5}
        jumps = np.flatnonzero(dataset["section_jump"].values[b])
        for turn in range(y.shape[2]):
            points, stable = np.stack([x[b], y[b, :, turn]], -1), steady(dataset, b)
            if slopes is None:
                curve(ax, *points.T, stable, look, jumps)
                continue
            events = dataset["section_event"].values[b, 1:] != 0
            path, stable = smooth(points, slopes[b, :, turn], stable, events, jumps)
            curve(ax, *path.T, stable, look)
    kinds = codes.words(dataset["special_kind"]).values
    specials = (dataset[f"special_{name}"].values for name in ("branch", "point"))
    for kind, b, p in zip(kinds, *specials, strict=True):
        shape = {"marker": MARKS[kind][0], **marker(kind)}
        there = np.isfinite(y[b, p])
        ax.plot(np.full(there.sum(), x[b, p]), y[b, p, there], **shape)


def tangents(dataset: Dataset, frame: Frame) -> np.ndarray | None:
    """Return derivatives of parameter and quantity over branch, point, turn and both; None of old results."""
    names = [f"{name}_tangent" for name in (frame.parameter, frame.quantity.name)]
    if not all(name in dataset for name in names):
        return None
    x, y = (dataset[name] for name in names)
    y = y.sel({dim: frame.quantity.coords[dim] for dim in y.dims if dim not in frame.quantity.dims})
    y = y if "turn" in y.dims else y.expand_dims("turn", -1)
    y = y.transpose("branch", "point", "turn").values * frame.y.factor
    return np.stack(np.broadcast_arrays(x.values[..., None] * frame.x.factor, y), -1)


def smooth(
    points: np.ndarray, slopes: np.ndarray, stable: np.ndarray, straight: np.ndarray, breaks: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return a dense path through points, interrupted before `breaks`, and which of its points are stable.

    `straight`: which pieces are not bent. A piece is stable where both its ends are.
    """
    spans = np.nanmax(points, axis=0, initial=-np.inf) - np.nanmin(points, axis=0, initial=np.inf)
    spans = np.where(np.isfinite(spans) & (spans > 0), spans, 1.0)
    path = through(points / spans, slopes / spans, straight) * spans
    steady = np.repeat(stable[:-1] & stable[1:], BETWEEN)
    steady = np.append(steady, stable[-1:])
    steady[::BETWEEN] = stable
    for at in breaks * BETWEEN:
        path[at - BETWEEN + 1 : at] = np.nan
    return path, steady


def marker(kind: str) -> dict[str, Any]:
    """Return the marker style of a special point."""
    small = {"color": style.GREY, "markersize": 5.0, "markeredgewidth": 0.6, "zorder": 2.7}
    large = {"color": style.BLACK, "markersize": 4.2, "markeredgewidth": 0.9}
    large["zorder"] = 3.2 + 0.1 * list(MARKS).index(kind)
    return {"linestyle": "none", "markerfacecolor": "white"} | (small if kind == "grazing" else large)


def colour(dataset: Dataset, branch: int) -> str:
    """Return the colour of a branch: by its period in turns, 1, 2, 4, …"""
    turns = np.nanmax(dataset["period"].values[branch], initial=1.0)
    return COLOURS[int(np.log2(max(turns, 1.0))) % len(COLOURS)]


def steady(dataset: Dataset, branch: int) -> np.ndarray:
    """Return which points of a branch are stable."""
    return codes.words(dataset["stable"][branch]).values == "stable"


def curve(
    ax: Axes, x: np.ndarray, y: np.ndarray, stable: np.ndarray, look: dict[str, Any], breaks=()
) -> None:
    """Draw a line, stable stretches solid, unstable ones dashed; it is interrupted before `breaks`."""
    x, y = (np.insert(each, breaks, np.nan) for each in (x, y))
    stable = np.insert(stable, breaks, False)
    there = np.isfinite(x) & np.isfinite(y)
    loose = there & (~stable | (artists.neighbours(~stable & there) & there))  # both kinds share a point
    for where, dash in ((loose, UNSTABLE), (there & stable, STABLE)):
        ax.plot(np.where(where, x, np.nan), np.where(where, y, np.nan), **(dash | look))


def moduli(ax: Axes, dataset: Dataset, frame: Frame) -> None:
    """Draw the moduli of the two largest multipliers."""
    x = dataset[frame.parameter].values * frame.x.factor
    sizes = np.hypot(*(dataset["floquet_multiplier"].sel(part=part).values for part in ("real", "imaginary")))
    ax.axhline(1.0, color=style.GREY, linewidth=0.6)
    for b in range(len(x)):
        look = {"color": colour(dataset, b)}
        curve(ax, x[b], sizes[b, :, 0], steady(dataset, b), look)
        if sizes.shape[2] > 1:
            ax.plot(x[b], sizes[b, :, 1], **look, linewidth=0.5, linestyle=(0, (1, 1)))
    ax.set_ylim(0, min(3.0, 1.1 * np.nanmax(sizes, initial=1.1)))
    ax.set_ylabel("Modulus of\nmultipliers")
    ax.set_xlabel(artists.axis_label(dataset[frame.parameter], frame.x))


def explain(figure: Figure, dataset: Dataset, over: bool = False) -> None:
    """Name line styles, colours and markers below the panels."""
    turns = sorted({float(np.nanmax(row, initial=1.0)) for row in dataset["period"].values})
    handles = [
        artists.sample(color=COLOURS[int(np.log2(t)) % len(COLOURS)], label=f"period {t:g}") for t in turns
    ]
    dashes = {"stable": STABLE, "unstable": UNSTABLE}
    handles += [artists.sample(color=style.GREY, label=word, **dash) for word, dash in dashes.items()]
    kinds = codes.flags(dataset["special_kind"])
    for code in np.unique(dataset["special_kind"].values):
        shape, name = MARKS[kinds[int(code)]]
        handles.append(artists.sample(marker=shape, label=name, **marker(kinds[int(code)])))
    if over:
        dot = OVER | {"marker": "o", "linestyle": "none", "markersize": 2}
        handles.append(artists.sample(label=UNDER, **dot))
    look = {"loc": "outside lower center", "ncols": 4, "columnspacing": 1.2, "handletextpad": 0.5}
    figure.legend(handles=handles, **look)
