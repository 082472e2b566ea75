"""Windows: the stretches of a motion whose samples are kept, in nominal turns from its start."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from numbers import Real
from typing import Any

import numpy as np
import xarray as xr

from jointplay.errors import InputError, Problem

Windows = Sequence[Sequence[float]]
EXCLUDED = ("duration", "transient", "at", "steps", "section")
MOST = 100
ACCEPTED = f"1 to {MOST} pairs of turns, [first, last], from 0 on, ascending and apart, are accepted"


def check_windows(windows: Any, turns: Any, beside: dict[str, Any]) -> None:
    """Refuse windows that make no sense, and what cannot be asked for beside them.

    Parameters
    ----------
    windows : sequence of pairs
        First and last turn of each.
    turns : float or None
        Length of the motion, where it was given.
    beside : dict
        Other keywords by name: those in `EXCLUDED` must be left out.

    Raises
    ------
    InputError
        Listing every problem.
    """
    found = [*_problems(windows, turns)]
    found += [Problem(key, beside[key], excluded(key)) for key in EXCLUDED if _given(beside.get(key))]
    if found:
        raise InputError(found)


def excluded(key: str) -> str:
    """What is said of a keyword that cannot stand beside windows."""
    return f"either windows or {key} is accepted, not both"


def too_short(windows: Windows) -> str:
    """What is said of a length that ends before the last window."""
    return f"at least {windows[-1][1]:g}, where the last window ends, is accepted"


def problem(windows: Any) -> str:
    """What would be accepted instead of these windows; empty where they make sense."""
    pairs = list(windows) if isinstance(windows, list | tuple | np.ndarray) else []
    if not 1 <= len(pairs) <= MOST or not all(_is_pair(pair) for pair in pairs):
        return ACCEPTED
    edges = [edge for pair in pairs for edge in pair]
    ascending = all(a < b for a, b in pairwise(edges))
    return "" if ascending and edges[0] >= 0 else ACCEPTED


def _problems(windows: Any, turns: Any) -> Iterator[Problem]:
    if problem(windows):
        yield Problem("windows", windows, problem(windows))
    elif _is_number(turns) and turns < windows[-1][1]:
        yield Problem("turns", turns, too_short(windows))


def _given(value: Any) -> bool:
    return value is not None and not (isinstance(value, Real) and value == 0)


def _is_pair(pair: Any) -> bool:
    return isinstance(pair, list | tuple | np.ndarray) and len(pair) == 2 and all(map(_is_number, pair))


def _is_number(value: Any) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool) and math.isfinite(value)


def sample_times(windows: Windows, period: float, samples_per_turn: int) -> tuple[np.ndarray, np.ndarray]:
    """Times of evenly spaced samples, s, and the window that each lies in, counted from 0.

    Parameters
    ----------
    windows : sequence of pairs
        First and last turn of each; both are sampled.
    period : float
        Length of a nominal turn, s.
    samples_per_turn : int
        At least.
    """
    counts = [max(1, math.ceil((last - first) * samples_per_turn - 1e-9)) for first, last in windows]
    times = [period * np.linspace(*window, count + 1) for window, count in zip(windows, counts, strict=True)]
    number = np.repeat(np.arange(len(windows), dtype=np.int8), [count + 1 for count in counts])
    return np.concatenate(times), number


def marked(dataset: xr.Dataset, number: np.ndarray, windows: Windows, period: float) -> xr.Dataset:
    """The dataset with the window of each sample, and without the events outside of all windows.

    Parameters
    ----------
    dataset : Dataset
        Over ``time`` and ``event``; a run that stopped early has fewer samples than were asked for.
    number : ndarray
        The window of each sample asked for.
    windows, period
        As in `sample_times`.
    """
    times = dataset["event_time"].values
    inside = np.any([(a * period <= times) & (times <= b * period) for a, b in windows], axis=0)
    named = {"units": "1", "long_name": "window of the sample, counted from 0"}
    return dataset.isel(event=np.flatnonzero(inside)).assign(
        window=("time", number[: dataset.sizes["time"]], named)
    )
