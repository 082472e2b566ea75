"""Time histories: one panel a variable, on one time axis, with the events of the run in a strip below."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from jointplay.display import codes
from jointplay.display.number_text import Shown
from jointplay.figures.drawing import (
    Axes,
    DataArray,
    Dataset,
    Figure,
    artists,
    envelope,
    select,
    style,
    timebase,
)
from jointplay.figures.registry import picture

DEFAULTS = ("normal_force", "angular_acceleration", "state_value")
MOST = 6  # states of a system that are drawn by themselves
LONGEST = 27  # characters of a y label that fit the height of a panel
WRAPPED = ("contact_angle",)  # jump by a turn where they pass half a turn
SOMEONE = {"link": ("of a link", "of the {}"), "pin": ("an ideal joint", "ideal joint {}")}
PANEL, STRIP, GAP, MARGINS = 37.0, 5.0, 7.0, 15.0  # mm of height: panel, row of events, between, at the ends


@picture()
def time_history(
    dataset: Dataset,
    *,
    variables: str | Sequence[str] | None = None,
    link: str | None = None,
    joint: str | None = None,
    pin: str | None = None,
    turns: float | Sequence[float] | None = None,
    time: Sequence[float] | None = None,
    axis: str | Sequence[str] | None = None,
    events: bool | Sequence[str] = False,
    column: str = "double",
) -> Figure:
    """Draw variables over time; of a run recorded in windows, a column each.

    Forces go up and down to their extremes between samples, where the result has these. A vibration of fewer
    than eight samples a cycle is drawn as its envelope.

    Parameters
    ----------
    dataset : Dataset
        A response.
    variables : str or sequence of str, optional
        What to draw, a panel each; a test system's states by their labels. By default the normal forces, or
        what else there is: angular accelerations, the first six states.
    link, joint, pin : str, optional
        Draw this link, joint with clearance or ideal joint only; by default all.
    turns : float or pair, optional
        The last so many turns, or [first, last]; by default everything.
    time : pair, optional
        A window in s, instead of `turns`.
    axis : str or pair, optional
        "time", "turns" or "angle" (of the crank) at the bottom, and another on top; by default time and
        turns, of windows the crank's angle (or, if longer than two turns, its turns) and time.
    events : bool or sequence of str, optional
        Show the events (or only these kinds) in a strip below.
    column : {"double", "single"}
        Width of the figure: 180 mm or 88 mm.
    """
    width = style.COLUMNS[select.choice("column", column, style.COLUMNS)]
    part = timebase.window(dataset, turns, time)
    arrays = chosen(part, variables, link=link, joint=joint, pin=pin)
    rows = event_rows(dataset, part, events, joint)
    panes = timebase.panes(part)
    heights = [PANEL] * len(arrays) + [2 + STRIP * len(rows)] * bool(rows)
    figure = style.sheet(width, sum(heights) + GAP * len(heights) + MARGINS)
    layout = {"sharex": "col", "squeeze": False, "height_ratios": heights}
    axes = figure.subplots(len(heights), len(panes), **layout)
    timebase.apart(figure, panes)
    for number, pane in enumerate(panes):
        bases = pane.bases(dataset, axis)
        history_column(axes[:, number], pane, arrays, bases[0], rows)
        timebase.dress(axes[-1, number], axes[0, number], bases, "right" if pane.title else "center")
    for number, row in enumerate(axes):
        if number < len(arrays):
            timebase.level(row)
        timebase.name_once(row, ticks=number >= len(arrays))
    legends(axes[:, -1])
    timebase.head(axes, panes, two_axes=len(bases) > 1)
    return artists.finish(figure, dataset)


def history_column(
    axes: Sequence[Axes], pane: timebase.Pane, arrays: Sequence[DataArray], base: timebase.Base, rows: dict
) -> None:
    """Draw variables, and events below, in one stretch of time."""
    times = pane.samples["time"].values
    for ax, array in zip(axes, arrays, strict=False):
        several = any(array.sizes[dim] > 1 for dim in array.dims if dim != "time")
        shown = array.isel(time=pane.index)
        history_panel(ax, shown, base, several, artists.displayed(array)[1], between(pane.samples, shown))
        if array.name == "eccentricity":
            rim(ax, pane.samples, array)
    if rows:
        first, last = times[[0, -1]] if times.size else (np.inf, -np.inf)
        strip(axes[-1], {kind: t[(t >= first) & (t <= last)] for kind, t in rows.items()}, base)


def rim(ax: Axes, dataset: Dataset, array: DataArray) -> None:
    """Draw the clearance, the journal's distance from the middle as it touches, of the joints shown."""
    sizes = {float(dataset["clearance"].sel(joint=joint)) for joint in np.atleast_1d(array["joint"].values)}
    for number, size in enumerate(sorted(sizes)):
        look = {"color": style.GREY, "linewidth": 0.6, "linestyle": "--", "zorder": 1}
        ax.axhline(size * artists.displayed(array)[1].factor, **look, label="_" if number else "$e$")


def chosen(dataset: Dataset, variables, **labelled: str | None) -> list[DataArray]:
    """Return the variables to draw, cut down to one link, joint or pin where one is named."""
    if variables is None:
        known = [name for name in DEFAULTS if name in dataset and dataset[name].size]
        states = select.labels(dataset, "state") if known[:1] == ["state_value"] else []
        variables = states[:MOST] or known[:1] or select.names(dataset, "time")[:1]
    names = [variables] if isinstance(variables, str) else list(variables)
    if not names:
        raise select.refuse("variables", variables, "the name of a variable over time, or several")
    arrays = [select.variable(dataset, name) for name in names]
    for dim, label in labelled.items():
        if label is not None:
            select.choice(dim, label, select.labels(dataset, dim))
            arrays = [only(array, dim, label) if dim in array.dims else array for array in arrays]
    return arrays if labelled.get("joint") is not None else list(map(held, arrays))


def held(array: DataArray) -> DataArray:
    """Return a variable without joints that have none of it, as ideal ones no contact force."""
    if "joint" not in array.dims:
        return array
    there = array.notnull().any([dim for dim in array.dims if dim != "joint"]).values
    return array.isel(joint=np.flatnonzero(there)) if there.any() else array


def only(array: DataArray, dim: str, label: str) -> DataArray:
    """Return the part of one link, joint or pin, named after it where there are several."""
    share = array.sel({dim: [label]})
    named = array.sizes[dim] > 1 or dim in SOMEONE
    return share.assign_attrs(long_name=whose(array, dim, label)) if named else share


def whose(array: DataArray, dim: str, label: str) -> str:
    """Return a name such as "coupler angular velocity", where the variable is the "link angular velocity"."""
    words, label = select.title(array), codes.contact(label)
    general, particular = SOMEONE.get(dim, ("", ""))
    if general and general in words:
        return words.replace(general, particular.format(label))
    return label + words[len(dim) :] if words.lower().startswith(f"{dim} ") else f"{words}, {label}"


def between(samples: Dataset, array: DataArray) -> list[DataArray]:
    """Return the lowest and highest values of a variable between its samples, where they were recorded."""
    names = [f"{word}_{array.name}" for word in ("lowest", "highest")]
    if not {*names} <= set(samples):
        return []
    labels = {dim: array[dim] for dim in array.dims if dim != "time" and dim in array.coords}
    return [samples[name].sel(labels) for name in names]


def history_panel(
    ax: Axes,
    array: DataArray,
    base: timebase.Base,
    named: bool,
    unit: Shown | None = None,
    extremes: Sequence[DataArray] = (),
) -> None:
    """Draw one variable over the time axis `base`: a curve for each of its labels, `named` so or not."""
    x = base.forward(array["time"].values)
    values, unit = artists.displayed(array.transpose("time", ...), unit)
    others = [dim for dim in array.dims if dim != "time"]
    names = [codes.contact(str(label)) for label in array[others[0]].values] if others else [None]
    columns = values if values.ndim == 2 else values[:, None]
    ends = [each.transpose("time", ...).values.reshape(columns.shape) * unit.factor for each in extremes]
    if not columns.size:
        artists.say(ax, artists.EMPTY)
    if x.size > 1:
        ax.set_xlim(timebase.limits(base, x))
    doubts: dict[str, list] = {}
    for number, (column, name) in enumerate(zip(columns.T, names, strict=True)):
        xs, ys = timebase.broken(column, 360.0, x, column) if array.name in WRAPPED else (x, column)
        own = tuple(each[:, number] for each in ends) or None
        doubts.setdefault(envelope.course(ax, xs, ys, own, label=name if named else "_"), []).append(name)
    said = [f"{', '.join(of)}: {words}" if named else words for words, of in doubts.items() if words]
    if said:
        artists.remark(ax, *said)
    missing = ~np.isfinite(columns)
    gaps = zip(names, missing.T, strict=True) if named else ()
    of = ", ".join(str(name) for name, gap in gaps if gap.any())
    artists.shade_missing(ax, x, missing.any(axis=1), f"no value ({of})" if of else "no value")
    artists.name_y(ax, array, unit, LONGEST)


def legends(axes: Sequence[Axes]) -> None:
    """Name the curves to the right of each panel, unless the panel above has named the same ones."""
    above = []
    for ax in axes:
        names = ax.get_legend_handles_labels()[1]
        if names and names != above:
            ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.05))
        above = names


def event_rows(dataset: Dataset, part: Dataset, events, joint: str | None) -> dict[str, np.ndarray]:
    """Return the times in s of the events in the window, by kind; absent kinds only if named."""
    if events is False or events is None:
        return {}
    if "event_kind" not in dataset:
        raise select.refuse("events", events, "false: this result has no events")
    meanings = codes.flags(dataset["event_kind"])
    named = [] if events is True else [events] if isinstance(events, str) else list(events)
    for kind in named:
        select.choice("events", kind, meanings.values(), "kind of event")
    times, kinds = dataset["event_time"].values, dataset["event_kind"].values
    span = part["time"].values[[0, -1]] if part.sizes["time"] else (np.inf, -np.inf)
    inside = (times >= span[0]) & (times <= span[1])
    if joint is not None:
        inside &= dataset["event_joint"].values == select.labels(dataset, "joint").index(joint)
    rows = {kind: times[inside & (kinds == code)] for code, kind in meanings.items()}
    return {kind: found for kind, found in rows.items() if kind in named or (not named and found.size)}


def strip(ax: Axes, rows: dict[str, np.ndarray], base: timebase.Base) -> None:
    """Draw events as ticks, a row a kind."""
    for height, times in enumerate(rows.values()):
        x = base.forward(times)
        ax.plot(x, np.full(x.size, height), "|", color=style.BLACK, markersize=7, markeredgewidth=0.7)
    ax.set_yticks(range(len(rows)), [kind.replace("_", " ") for kind in rows])
    ax.set_ylim(len(rows) - 0.4, -0.6)
    ax.tick_params(axis="y", length=0)
