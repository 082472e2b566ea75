"""Windows: the stretches of a motion whose samples are kept, in nominal turns from its start."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from pydantic import AfterValidator

from jointplay.analysis.keywords import listed
from jointplay.analysis.labels import Out
from jointplay.display.errors import Problem, refuse
from jointplay.solver.mechanism.base import Number

if TYPE_CHECKING:
    import xarray as xr

MOST = 100
ACCEPTED = f"a list of 1 to {MOST} pairs of turns, [first, last], from 0 on, ascending and apart,"


def _apart(windows: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
    edges = [edge for pair in windows for edge in pair]
    if not 1 <= len(windows) <= MOST or edges[0] < 0 or any(a >= b for a, b in pairwise(edges)):
        raise refuse(windows, f"{ACCEPTED} is accepted")
    return windows


Windows = Annotated[listed(tuple[Number, Number], ACCEPTED), AfterValidator(_apart)]


def _long_enough(windows: Windows | None, turns: float | None) -> Iterator[Problem]:
    if windows is not None and turns is not None and turns < windows[-1][1]:
        expected = f"at least {windows[-1][1]:g}, where the last window ends, is accepted"
        yield Problem("turns", turns, expected)


def _excluded_by_windows(windows: Windows | None, **other: Any) -> Iterator[Problem]:
    for key, given in other.items():
        if windows is not None and given is not None and given != 0:
            yield Problem(key, given, f"either windows or {key} is accepted, not both")


WINDOW = Out("time", "window of the sample, counted from 0")
WINDOW_RULES = (  # rules of which keywords of `simulate` are accepted beside windows
    _long_enough,
    lambda windows, duration: _excluded_by_windows(windows, duration=duration),
    lambda windows, transient: _excluded_by_windows(windows, transient=transient),
    lambda windows, at: _excluded_by_windows(windows, at=at),
    lambda windows, steps: _excluded_by_windows(windows, steps=steps),
    lambda windows, section: _excluded_by_windows(windows, section=section),
)


def sample_times(windows: Windows, period: float, samples_per_turn: int) -> tuple[np.ndarray, np.ndarray]:
    """Times of evenly spaced samples, s, from end to end of each window, and the number of its window."""
    counts = [max(1, math.ceil((last - first) * samples_per_turn - 1e-9)) for first, last in windows]
    times = [period * np.linspace(*window, count + 1) for window, count in zip(windows, counts, strict=True)]
    number = np.repeat(np.arange(len(windows), dtype=np.int8), [count + 1 for count in counts])
    return np.concatenate(times), number


def marked(dataset: xr.Dataset, number: np.ndarray, windows: Windows, period: float) -> xr.Dataset:
    """The dataset with the window of each sample, and without the events outside of all windows.

    A run that stopped early has fewer samples than `number`, which holds the window of each requested one.
    """
    times = dataset["event_time"].values
    inside = np.any([(a * period <= times) & (times <= b * period) for a, b in windows], axis=0)
    window = WINDOW.variable(number[: dataset.sizes["time"]])
    return dataset.isel(event=np.flatnonzero(inside)).assign(window=window)
