"""Columns of panels, one for each recorded window of a run, with one scale where all can be read in it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from jointplay.figures.drawing import artists, timebase

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from xarray import Dataset

ALIKE = 0.4  # panels share a scale if none of them would fill less of it
WHOLE = 1e-6  # turns from a whole number that still count as whole
LONG = 2.0  # turns beyond which an axis counts turns, not degrees


@dataclass(frozen=True)
class Pane:
    """A stretch of a run without gaps: its samples, which these are, and a title where there are several."""

    samples: Dataset
    index: slice | np.ndarray = field(default_factory=lambda: slice(None))
    title: str = ""
    windowed: bool = False

    def bases(self, dataset: Dataset, axis) -> list[timebase.Base]:
        """Return the time axes: of a window crank angle (or turns) and time, else as in `timebase.bases`."""
        times = self.samples["time"].values
        if not self.windowed:
            return timebase.bases(dataset, times, axis)
        first, last = edges(self.samples)
        usual = ("turns" if last - first > LONG else "angle", "time")
        return timebase.bases(self.samples, times, axis, usual)


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
