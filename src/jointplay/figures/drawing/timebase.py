"""The time axis: seconds, turns of the crank (periods of the forcing) or crank angle, and windows in them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from jointplay.display.units import shown
from jointplay.figures.drawing import artists, select

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from xarray import Dataset

AXES = ("time", "turns", "angle")
CRANK = "crank"
LATE = 10.0  # s: until then, a short stretch of time is given in ms
FEW = 5  # intervals of the axis on top
SNAP = 2e-3  # turns by which an axis may be longer, to end with a whole turn


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
    asked = [axis] if isinstance(axis, str) else list(axis) if isinstance(axis, list | tuple) else []
    if not 1 <= len(asked) <= 2:
        raise select.refuse("axis", axis, "one or two of: " + ", ".join(AXES))
    return [select.choice("axis", name, AXES) for name in asked]


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


def time_limits(asked) -> tuple[float, ...]:
    """Return the first and last time of a window, in s."""
    return select.numbers("time", asked, 2, "two increasing numbers, in s")


def turn_limits(asked, last: float) -> tuple[float, float]:
    """Return the first and last turn of a window."""
    if isinstance(asked, list | tuple):
        return select.numbers("turns", asked, 2, "a number of turns, or [first, last]")
    (count,) = select.numbers("turns", asked, 1, "a number of turns, or [first, last]")
    if count <= 0:
        raise select.refuse("turns", asked, "a number of turns greater than 0")
    return last - count, last


def cut(dataset: Dataset, option: str, asked, inside: np.ndarray) -> Dataset:
    """Return the samples `inside`; a window without samples is an error that names the recorded times."""
    if not inside.any():
        times = dataset["time"].values
        raise select.refuse(
            option, asked, f"a window that meets the recorded {times[0]:.6g} to {times[-1]:.6g} s"
        )
    return dataset.isel(time=np.flatnonzero(inside))


def dress(bottom: Axes, top: Axes, shown_bases: list[Base], loc: str = "center") -> None:
    """Label the time axis under the panel `bottom`, and the second one above the panel `top`."""
    from matplotlib.ticker import MaxNLocator

    bottom.set_xlabel(shown_bases[0].label)
    degrees(bottom.xaxis, shown_bases[0])
    if len(shown_bases) < 2:
        return
    under, over = shown_bases
    second = top.secondary_xaxis(
        "top",
        functions=(lambda x: over.forward(under.inverse(x)), lambda x: under.forward(over.inverse(x))),
    )
    second.set_xlabel(over.label, loc=loc)
    second.xaxis.set_major_locator(MaxNLocator(FEW, steps=[1, 2, 2.5, 5, 10]))
    degrees(second.xaxis, over)


def degrees(axis, shown_base: Base) -> None:
    """Put ticks at round parts of a turn on an axis of degrees."""
    from jointplay.figures.drawing.ticks import Degrees

    if "(deg)" in shown_base.label:
        axis.set_major_locator(Degrees())
