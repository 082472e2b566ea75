"""Assessment: largest forces and impact speeds over each parameter, and the force over a turn."""

from __future__ import annotations

from textwrap import fill

import numpy as np

from jointplay.display import codes
from jointplay.display.number_text import shown
from jointplay.figures.drawing import Axes, Dataset, Figure, artists, select, style, sweep_axes
from jointplay.figures.registry import picture

SHADES = {
    "quiet": "#eef5ea",
    "touches": "#fbf3d5",
    "rattles": "#f7dfc4",
    "hammers": "#eec4bc",
    "unknown": "#ffffff",
}
DOT = {"color": style.BLACK, "marker": "o", "linestyle": "", "markersize": 2.4, "markeredgewidth": 0.5}
OPEN = DOT | {"markerfacecolor": "white"}
MARKS = {  # of a change: colour, line, words
    "contact_loss": (style.BLUE, (0, (5, 2)), "contact lost or kept"),
    "doubling": (style.AMBER, (0, (2, 1)), "period 1 lost or reached"),
    "chaos": (style.BLACK, (0, (1, 1)), "chaos begins or ends"),
}


@picture(least=180)
def assess(dataset: Dataset, *, joint: str | None = None) -> Figure:
    """Draw largest forces and impact speeds over each parameter, and a joint's force over a turn.

    Parameters
    ----------
    dataset : Dataset
        What `jointplay.assess` returned.
    joint : str, optional
        Whose force is drawn; the hardest worked one if left out.
    """
    select.require(dataset, "assess", ("force_ratio", "edge_ratio", "joint_force", "curve_ratio"))
    followed = codes.words(dataset["curve_status"]) != "not_run"
    looked = followed.any("value").values
    rows, rest = int(looked.sum()), [str(each) for each in dataset["parameter_name"].values[~looked]]
    heights = [58.0] * (rows + 1) + [12.0] * bool(rest)
    figure = style.sheet(180.0, sum(heights) + 12.0 * bool(rows))
    grid = figure.add_gridspec(len(heights), 2, height_ratios=heights)
    name = select.label(dataset, "joint", joint or hardest(dataset))
    panels = []
    for i, number in enumerate(np.flatnonzero(looked)):
        one = dataset.isel(parameter=number, value=followed.isel(parameter=number).values)
        force, speed = (figure.add_subplot(grid[i, k]) for k in (0, 1))
        panels += [force, speed]
        force_panel(force, one, name)
        speed_panel(speed, one)
    turn, peaks = (figure.add_subplot(grid[rows, k]) for k in (0, 1))
    turn_panel(turn, dataset, name)
    peak_panel(peaks, dataset)
    artists.letter((*panels, turn, peaks))
    if rest:
        ax, words = (
            figure.add_subplot(grid[rows + 1, :]),
            f"Forces and impact speeds over these were not looked at: {', '.join(rest)}.",
        )
        ax.set_axis_off()
        ax.text(0.0, 0.5, fill(words, 110), va="center")
    if looked.any():
        _legend(figure, dataset.isel(parameter=looked), followed.values[looked])
    return artists.finish(figure, dataset)


def _legend(figure: Figure, dataset: Dataset, followed: np.ndarray) -> None:
    """One legend for all panels over a parameter: grades that are met, and lines."""
    met = set(map(str, codes.words(dataset["curve_grade"]).values[followed]))
    edge = {"edgecolor": style.GREY, "linewidth": 0.4}
    handles = [artists.swatch(facecolor=SHADES[g], **edge, label=g) for g in SHADES if g in met]
    counts = {*followed.sum(axis=1).tolist()}
    count = f"{counts.pop()} values" if len(counts) == 1 else "values"
    handles.append(artists.sample(label=f"{count} and their grades", **DOT))
    if (dataset["curve_period"].values == 0).any():
        handles.append(artists.sample(label="not seen to repeat: chaos, or not settled", **OPEN))
    handles.append(artists.sample(color=style.GREY, linewidth=1.2, linestyle="-", label="present value"))
    for name, (colour, line, words) in MARKS.items():
        if np.isfinite(dataset["edge_ratio"].sel(change=name)).any():
            handles.append(artists.sample(color=colour, linewidth=0.9, linestyle=line, label=words))
    figure.legend(handles=handles, loc="outside lower center", ncols=3)


def hardest(dataset: Dataset) -> str | None:
    """Return the joint whose force is largest against the ideal mechanism's; None where none is known."""
    ratio = dataset["force_ratio"].values
    known = np.isfinite(ratio).any()
    return str(dataset["joint"].values[int(np.nanargmax(ratio))]) if known else None


def force_panel(ax: Axes, one: Dataset, joint: str) -> None:
    """Draw the largest force of a joint over one parameter, beside the ideal mechanism's."""
    values = _values(one)
    here = one.sel(joint=joint)
    artists.curve(
        ax,
        values,
        here["curve_ideal_peak_force"].values,
        color=style.AMBER,
        linewidth=1.4,
        label="ideal joints",
    )
    force = here["curve_peak_force"].values
    artists.curve(ax, values, force, color=style.BLACK, linestyle="-", label="with clearance")
    _dots(ax, one, force)
    sweep_axes.logarithmic(ax, *ax.dataLim.intervaly, "y")
    ax.set(ylabel="Largest force (N)")
    _over(ax, one, values)
    ax.legend(loc="best")
    artists.heading(ax, f"joint {codes.contact(joint)}")


def speed_panel(ax: Axes, one: Dataset) -> None:
    """Draw the largest impact speed of each joint with clearance over one parameter."""
    values, loose = _values(one), one.isel(joint=np.flatnonzero(one["clearance"].values > 0))
    for joint, line in zip(loose["joint"].values, ("-", "--", ":", "-."), strict=False):
        speed = 1e3 * loose["curve_impact_speed"].sel(joint=joint).values
        name = f"joint {codes.contact(str(joint))}"
        artists.curve(ax, values, speed, color=style.BLACK, linestyle=line, label=name)
        _dots(ax, one, speed)
    ax.set(ylabel="Largest impact speed (mm/s)", ylim=(0, None))
    _over(ax, one, values)
    if loose.sizes["joint"] > 1:
        ax.legend(loc="best")


def _dots(ax: Axes, one: Dataset, numbers: np.ndarray) -> None:
    """Mark the values of a curve, open where the motion was not seen to repeat."""
    unsure = one["curve_period"].values == 0
    for which, look in ((~unsure, DOT), (unsure, OPEN)):
        ax.plot(_values(one)[which], numbers[which], **look)


def _unit(one: Dataset) -> tuple[str, float]:
    unit = shown(float(one["present_value"]), str(one["parameter_units"].values))
    return str(unit.symbol), float(unit.factor)


def _values(one: Dataset) -> np.ndarray:
    return one["curve_ratio"].values * float(one["present_value"]) * _unit(one)[1]


def _over(ax: Axes, one: Dataset, values: np.ndarray) -> None:
    """The axis of the parameter: grades behind the curve, the present value and the changes as lines."""
    symbol, factor = _unit(one)
    present = float(one["present_value"]) * factor
    grades = codes.words(one["curve_grade"]).values
    middles = np.sqrt(values[1:] * values[:-1]) * np.sign(present)
    for ratio in one["grade_change_ratio"].sel(place="after").values:
        i = int(np.searchsorted(one["curve_ratio"].values, ratio))
        if 0 < i < len(values) and grades[i - 1] != grades[i]:
            middles[i - 1] = ratio * present
    ends = np.concatenate([values[:1], middles, values[-1:]])
    for low, high, grade in zip(ends[:-1], ends[1:], grades, strict=True):
        ax.axvspan(low, high, color=SHADES[str(grade)], linewidth=0, zorder=-1)
    ax.axvline(present, color=style.GREY, linewidth=1.2, linestyle="-", zorder=0)
    for name, (colour, line, _) in MARKS.items():
        edges = one["edge_ratio"].sel(change=name).values
        for ratio in edges[np.isfinite(edges)]:
            ax.axvline(ratio * present, color=colour, linewidth=0.9, linestyle=line, zorder=1)
    if present > 0:
        sweep_axes.logarithmic(ax, values[0], values[-1])
    label = artists.with_unit(artists.capital(str(one["parameter_name"].values)), symbol)
    ax.set(xlim=tuple(sorted((values[0], values[-1]))), xlabel=label)


def turn_panel(ax: Axes, dataset: Dataset, joint: str) -> None:
    """Draw the force at a joint over the turn with its largest, and the ideal mechanism's."""
    share = dataset["turn_share"].values
    own, ideal = (dataset[name].sel(joint=joint).values for name in ("joint_force", "ideal_joint_force"))
    artists.curve(ax, share, ideal, color=style.AMBER, linewidth=1.4, label="ideal mechanism")
    artists.curve(ax, share, own, color=style.BLACK, linestyle="-", label="with clearance")
    ax.set(xlabel="Share of a turn", ylabel="Joint force (N)", xlim=(0, 1), ylim=(0, None))
    ax.legend(loc="best")
    artists.heading(ax, f"joint {codes.contact(joint)}")


def peak_panel(ax: Axes, dataset: Dataset) -> None:
    """Draw the largest force of each joint with its error, next to the ideal mechanism's."""
    place = np.arange(dataset.sizes["joint"])
    for shift, name, colour in ((-0.2, "ideal_peak_force", style.AMBER), (0.2, "peak_force", style.BLACK)):
        ax.bar(place + shift, dataset[name].values, 0.36, color=colour)
        look = {"fmt": "none", "ecolor": style.GREY, "capsize": 2, "linewidth": 0.8}
        ax.errorbar(place + shift, dataset[name].values, dataset[f"{name}_error"].values, **look)
    tops = dataset["peak_force"].values + dataset["peak_force_error"].fillna(0.0).values
    for i, (top, ratio) in enumerate(zip(tops, dataset["force_ratio"].values, strict=True)):
        if np.isfinite(ratio):
            ax.annotate(
                f"{ratio:.3g}×", (i, top), (0, 3), textcoords="offset points", ha="center", fontsize=7
            )
    ax.set_xticks(place, [artists.broken(codes.contact(str(name)), 12) for name in dataset["joint"].values])
    ax.set(xlabel="Joint", ylabel="Largest force (N)")
    ax.margins(y=0.12)
