"""The time axis: seconds, turns of the crank (periods of the forcing) or crank angle, and windows in them.

Angles in degrees: wrapped, unwrapped, on the principal branch; and lines interrupted at jumps.

Columns of panels, one for each recorded window of a run, with one scale where all can be read in it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from jointplay.display.number_text import shown
from jointplay.figures.drawing import Axes, Dataset, Figure, artists, select

AXES = ("time", "turns", "angle")
CRANK = "crank"
LATE = 10.0  # s: until then, a short stretch of time is given in ms
FEW = 5  # intervals of the axis on top
SNAP = 2e-3  # turns by which an axis may be longer, to end with a whole turn

ALIKE = 0.4  # panels share a scale if none of them would fill less of it
WHOLE = 1e-6  # turns from a whole number that still count as whole
LONG = 2.0  # turns beyond which an axis counts turns, not degrees


@dataclass(frozen=True)
class Base:
    """A time axis given by knots: `values` at `times` in s, and straight lines between them."""

    label: str
    times: np.ndarray
    values: np.ndarray

    def forward(self, time):
        """Return the value on the axis at `time` in s."""
        return stretch(time, self.times, self.values)

    def inverse(self, value):
        """Return the time in s at which the axis shows `value`."""
        return stretch(value, self.values, self.times)


def limits(base: Base, x: np.ndarray) -> tuple[float, float]:
    """Return the ends of the axis `base` for values `x` in it: at whole turns, if they are that near."""
    ends = np.array([x[0], x[-1]])
    turn = 360.0 if "(deg)" in base.label else 1.0 if "turns" in base.label else None
    if turn is not None:
        whole = turn * np.round(ends / turn)
        ends = np.where(np.abs(whole - ends) < SNAP * turn, whole, ends)
    return float(min(ends[0], x[0])), float(max(ends[1], x[-1]))


def stretch(x, xp: np.ndarray, fp: np.ndarray):
    """Interpolate linearly, and beyond the ends go on with the mean slope."""
    x = np.asarray(x, dtype=float)
    slope = (fp[-1] - fp[0]) / (xp[-1] - xp[0])
    return np.interp(x, xp, fp) + slope * (x - np.clip(x, xp[0], xp[-1]))


def seconds(times: np.ndarray, units: str) -> Base:
    """Return the axis of plain time, in the display unit that suits `times`."""
    late = np.max(np.abs(times), initial=0.0) >= LATE
    unit = shown(times if late or not times.size else np.ptp(times), units)
    return Base(artists.with_unit("Time", unit.symbol), np.array([0.0, 1.0]), np.array([0.0, unit.factor]))


def turns(dataset: Dataset, name: str = "turns") -> Base | None:
    """Return the axis of `turns` or `angle`: the recorded crank's where it only grows, else nominal."""
    words, per_turn = ("turns", 1.0) if name == "turns" else ("angle (deg)", 360.0)
    if "angle" in dataset and CRANK in select.labels(dataset, "link"):
        angle = dataset["angle"].sel(link=CRANK).values
        if angle.size > 1 and np.all(np.diff(angle) >= 0) and angle[-1] > angle[0]:
            return Base(f"Crank {words}", dataset["time"].values, per_turn * angle / (2 * np.pi))
    period = float(dataset.get("turn_period_nominal", np.nan))
    if not period > 0:
        return None
    whose = "Forcing" if "state_value" in dataset else "Nominal crank"
    words = words.replace("turns", "periods").replace("angle", "phase") if whose == "Forcing" else words
    return Base(f"{whose} {words}", np.array([0.0, period]), np.array([0.0, per_turn]))


def bases(dataset: Dataset, times: np.ndarray, axis, usual=("time", "turns")) -> list[Base]:
    """Return the bottom axis and, where there is one, the top axis, as the option `axis` names them."""
    named = usual if axis is None else axis_names(axis)
    units = dataset["time"].attrs.get("units", "s")
    found = [seconds(times, units) if name == "time" else turns(dataset, name) for name in named]
    if None in found and axis is not None:
        raise select.refuse("axis", axis, "time (this result has neither a crank angle nor a nominal period)")
    return [one for one in found if one is not None][: 2 if times.size > 1 else 1]


def axis_names(axis) -> list[str]:
    """Return one or two names of time axes."""
    names = [axis] if isinstance(axis, str) else list(axis) if isinstance(axis, list | tuple) else []
    if not 1 <= len(names) <= 2:
        raise select.refuse("axis", axis, "one or two of: " + ", ".join(AXES))
    return [select.choice("axis", name, AXES) for name in names]


def window(dataset: Dataset, turns_asked=None, time_asked=None) -> Dataset:
    """Return the samples inside a window: the last so many turns, or from-to in turns or in seconds."""
    if "time" not in dataset.dims:
        expected = "poincare_section: this result has no time histories"
        raise select.refuse("kind", dataset.attrs.get("kind"), expected)
    if turns_asked is not None and time_asked is not None:
        raise select.refuse("time", time_asked, "either turns or time, not both")
    times = dataset["time"].values
    if time_asked is not None:
        start, stop = time_limits(time_asked)
        return cut(dataset, "time", time_asked, (times >= start) & (times <= stop))
    if turns_asked is None or not times.size:
        return dataset
    turning = turns(dataset)
    if turning is None:
        raise select.refuse("turns", turns_asked, "a window in time: this result has no turns")
    count = turning.forward(times)
    start, stop = turn_limits(turns_asked, count[-1])
    slack = 1e-9 * (1 + abs(stop))  # a sample at the very start of the last turn belongs to it
    return cut(dataset, "turns", turns_asked, (count >= start - slack) & (count <= stop + slack))


def time_limits(value) -> tuple[float, ...]:
    """Return the first and last time of a window, in s."""
    return select.numbers("time", value, 2, "two increasing numbers, in s")


def turn_limits(value, last: float) -> tuple[float, float]:
    """Return the first and last turn of a window."""
    if isinstance(value, list | tuple):
        return select.numbers("turns", value, 2, "a number of turns, or [first, last]")
    (count,) = select.numbers("turns", value, 1, "a number of turns, or [first, last]")
    if count <= 0:
        raise select.refuse("turns", value, "a number of turns greater than 0")
    return last - count, last


def cut(dataset: Dataset, option: str, value, inside: np.ndarray) -> Dataset:
    """Return the samples `inside`; a window without samples is an error that names the recorded times."""
    if not inside.any():
        times = dataset["time"].values
        raise select.refuse(
            option, value, f"a window that meets the recorded {times[0]:.6g} to {times[-1]:.6g} s"
        )
    return dataset.isel(time=np.flatnonzero(inside))


def dress(bottom: Axes, top: Axes, shown_bases: list[Base], loc: str = "center") -> None:
    """Label the time axis under the panel `bottom`, and the second one above the panel `top`."""
    from matplotlib.ticker import MaxNLocator

    bottom.set_xlabel(shown_bases[0].label)
    if "(deg)" in shown_bases[0].label:
        artists.in_degrees(bottom.xaxis)
    if len(shown_bases) < 2:
        return
    under, over = shown_bases
    second = top.secondary_xaxis(
        "top", functions=(lambda x: over.forward(under.inverse(x)), lambda x: under.forward(over.inverse(x)))
    )
    second.set_xlabel(over.label, loc=loc)
    second.xaxis.set_major_locator(MaxNLocator(FEW, steps=[1, 2, 2.5, 5, 10]))
    if "(deg)" in over.label:
        artists.in_degrees(second.xaxis)


def within(degrees: np.ndarray, span: float) -> np.ndarray:
    """Return the angle within a range about 0 deg; with one of 180 deg, opposite directions are one."""
    return (degrees + span / 2) % span - span / 2


def unwrapped(degrees: np.ndarray) -> np.ndarray:
    """Return the angle followed beyond half a turn, from the first sample on; gaps stay gaps."""
    followed, there = degrees.astype(float), np.isfinite(degrees)
    followed[there] = np.unwrap(degrees[there], period=360.0)
    return followed


def broken(degrees: np.ndarray, span: float, *arrays: np.ndarray) -> list[np.ndarray]:
    """Interrupt a line where an angle jumps by more than half its range `span`.

    Each of `arrays` gets a sample more at every jump: NaN in those that are the angle itself, else what the
    sample after the jump has.
    """
    jumps = np.flatnonzero(np.abs(np.diff(degrees)) > span / 2) + 1
    return [np.insert(array, jumps, np.nan if array is degrees else array[jumps]) for array in arrays]


@dataclass(frozen=True)
class Pane:
    """A stretch of a run without gaps: its samples, which these are, and a title where there are several."""

    samples: Dataset
    index: slice | np.ndarray = field(default_factory=lambda: slice(None))
    title: str = ""
    windowed: bool = False

    def bases(self, dataset: Dataset, axis) -> list[Base]:
        """Return the time axes: of a window crank angle (or turns) and time, else as in `bases`."""
        times = self.samples["time"].values
        if not self.windowed:
            return bases(dataset, times, axis)
        first, last = edges(self.samples)
        usual = ("turns" if last - first > LONG else "angle", "time")
        return bases(self.samples, times, axis, usual)


def panes(part: Dataset) -> list[Pane]:
    """Return the stretches of `part`: all of it, or its windows."""
    if "window" not in part or not part.sizes["time"]:
        return [Pane(part)]
    numbers = part["window"].values
    found = []
    for number in np.unique(numbers):
        index = np.flatnonzero(numbers == number)
        samples = part.isel(time=index)
        found.append(Pane(samples, index, title(samples, number == numbers.max()), windowed=True))
    return found


def last(part: Dataset) -> Dataset:
    """Return the last window of `part`, or all of it: a path is not drawn across a gap."""
    return panes(part)[-1].samples


def edges(samples: Dataset) -> tuple[float, float]:
    """Return the first and last nominal turn of samples, counted from the start; NaN where there are none."""
    period = float(samples.get("turn_period_nominal", np.nan))
    first, end = samples["time"].values[[0, -1]] / period
    return float(first), float(end)


def title(samples: Dataset, final: bool) -> str:
    """Return a window's title, such as "start-up, turn 1" or, of the last, "steady, turns 21-25"."""
    first, end = edges(samples)
    if not np.isfinite(first):
        return ""
    kind = "start-up, " if first < WHOLE else "steady, " if final else ""
    return kind + turn_words(first, end)


def turn_words(first: float, end: float) -> str:
    """Return the turns between two counts, in words: from 20 to 25 they are the turns 21 to 25."""
    whole = [round(edge) for edge in (first, end)]
    if max(abs(first - whole[0]), abs(end - whole[1])) > WHOLE or whole[0] == whole[1]:
        return f"from {first:.4g} to {end:.4g} turns"
    single = whole[1] == whole[0] + 1
    return f"turn {whole[1]}" if single else f"turns {whole[0] + 1}\N{EN DASH}{whole[1]}"


def apart(figure: Figure, columns: Sequence[Pane]) -> None:
    """Keep the tick labels of neighbouring columns apart."""
    if len(columns) > 1:
        figure.get_layout_engine().set(wspace=0.05)


def level(axes: Sequence[Axes]) -> None:
    """Give the panels of a row one scale where all of them can be read in it."""
    limits = np.array([ax.get_ylim() for ax in axes])
    low, high = limits.min(), limits.max()
    if np.ptp(limits, axis=1).min() < ALIKE * (high - low):
        return
    for ax in axes:
        ax.set_ylim(low, high)
    name_once(axes, ticks=True)


def name_once(axes: Sequence[Axes], ticks: bool = False) -> None:
    """Keep the y label, and if `ticks` the tick labels, of the first panel of a row alone."""
    for ax in axes[1:]:
        ax.set_ylabel("")
        if ticks:
            ax.tick_params(labelleft=False)


def head(axes: np.ndarray, columns: Sequence[Pane], two_axes: bool) -> None:
    """Write the windows' titles above the first row, and letters where there are several rows."""
    for ax, pane in zip(axes[0], columns, strict=True):
        artists.heading(ax, pane.title, beside_top_axis=two_axes)
    if len(axes) > 1:
        artists.letter(axes.flat)
