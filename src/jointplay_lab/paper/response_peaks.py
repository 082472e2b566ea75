"""Peaks of a linkage's response in two windows, start-up and steady: joint force, accelerations, deflection.

Of each turn of a window the largest value (of deflections also the root mean square) is taken, and these
are averaged over the turns, with a standard error: an irregular motion has no one peak.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import xarray as xr

from jointplay.analysis.quantities import EVENTS
from jointplay.analysis.simulate import simulate
from jointplay.solver.mechanism.parts.beam import modal
from jointplay.solver.mechanism.records import Mechanism

# Turns; the motor takes up its load in the first 0.005, before the first contact and with ideal joints too
START_UP = (0.005, 1.0)
DROPPED = 100  # turns before the steady window: a slow swing of the contact's direction dies over some 50
INTERVAL = 1e-5  # s between samples: some 30 in one half-wave of the contact force
WINDOWS = ("start_up", "steady")
Pair = tuple[float, float]


def peaks(
    mechanism: Mechanism,
    *,
    joint: str = "B",
    link: str = "coupler",
    turns: int = 10,
    rtol: float = 1e-8,
    max_steps: int | None = None,
) -> dict[str, Any]:
    """Follow a motor-driven linkage and take the peaks of its response.

    Parameters
    ----------
    mechanism : Mechanism
        With a joint, ideal or with clearance, and links coupler and crank.
    joint, link : str
        Whose force and whose deflection.
    turns : int
        Length of the steady window, turns.
    rtol : float
        Relative tolerance of a step.
    max_steps : int, optional
        Attempted steps after which the run stops.

    Returns
    -------
    dict
        ``status``; as lists of (mean over the turns, its standard error), one a window: ``peak_force`` (N),
        ``peak_coupler_acceleration`` and ``peak_crank_acceleration`` (rad/s²), ``impacts`` (1 a turn), and
        of an elastic link ``peak_deflection``, ``rms_deflection`` (m), ``vibration`` and ``irregularity``
        (1), the last NaN in the window of one turn. The standard error in a window of one turn is 0.
    """
    clear, elastic = mechanism.joint(joint).clearance > 0, mechanism.link(link).elastic
    force = ["normal_force", "tangential_force"] if clear else ["reaction"]
    record = ["angle", "angular_acceleration", *force] + ["deflection"] * elastic
    windows, limits = (START_UP, (DROPPED, DROPPED + turns)), {"rtol": rtol, "max_steps": max_steps}
    period = math.tau / abs(mechanism.drive.nominal_speed)
    rate = round(period / INTERVAL)
    sampled = simulate(mechanism, windows=windows, samples_per_turn=rate, record=record, **limits)
    # A jump of the contact force shakes the crank for microseconds only: take both sides of every event too
    own = simulate(mechanism, turns=DROPPED + turns, steps=True, record=record, **limits)
    if sampled.status or own.status:
        return {"status": int(sampled.status or own.status)}
    answer: dict[str, Any] = {"status": 0, "impacts": [_impacts(own, window) for window in windows]}
    for name, of in _quantities(joint, link, elastic).items():
        sources = [(_turns(found), np.abs(of(found))) for found in (sampled, own)]
        answer[f"peak_{name}"] = [_peak(sources, window) for window in windows]
    return answer | (_of_beam(sampled, mechanism, link, windows) if elastic else {})


def _quantities(joint: str, link: str, elastic: bool) -> dict[str, Callable[[xr.Dataset], np.ndarray]]:
    """Functions from a result to the quantities that have peaks, by name."""
    found: dict[str, Callable[[xr.Dataset], np.ndarray]] = {"force": lambda found: _force(found, joint)}
    for one in ("coupler", "crank"):
        found[f"{one}_acceleration"] = lambda found, k=one: found.angular_acceleration.sel(link=k).values
    return found | ({"deflection": lambda found: found.deflection.sel(link=link).values} if elastic else {})


def _force(found: xr.Dataset, joint: str) -> np.ndarray:
    """Magnitude of the joint's force, N."""
    if "reaction" in found:
        return found.reaction.sel(pin=joint).values
    return np.hypot(*(found[name].sel(joint=joint).values for name in ("normal_force", "tangential_force")))


def _turns(found: xr.Dataset) -> np.ndarray:
    """Times in nominal turns; a sample at the end of a turn belongs to the next."""
    return found.time.values / float(found.turn_period_nominal) + 1e-9


def _each(turns: np.ndarray, window: Pair) -> list[np.ndarray]:
    """Rows of each turn of a window."""
    first, last = window
    whole = range(math.floor(first), round(last))
    return [np.flatnonzero((turns >= max(n, first)) & (turns < n + 1)) for n in whole]


def _peak(sources: list[tuple[np.ndarray, np.ndarray]], window: Pair) -> Pair:
    """Mean over turns of the largest value that any source holds in a turn, and its standard error."""
    each = [[value[rows].max() for rows in _each(turns, window)] for turns, value in sources]
    return mean(np.max(each, axis=0))


def mean(values: np.ndarray) -> Pair:
    """Mean and standard error, 0 for a single value."""
    values = np.asarray(values)
    error = values.std(ddof=1) / math.sqrt(len(values)) if len(values) > 1 else 0.0
    return float(values.mean()), float(error)


def rms(value: np.ndarray) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(value**2)))


def _impacts(found: xr.Dataset, window: Pair) -> Pair:
    """Contacts begun per turn; without an error, as it only says whether there are any."""
    contacts = found.event_time.values[found.event_kind.values == EVENTS.index("contact")]
    turns = contacts / float(found.turn_period_nominal)
    first, last = window
    return float(np.sum((turns >= first) & (turns <= last)) / (last - first)), 0.0


def _of_beam(found: xr.Dataset, mechanism: Mechanism, link: str, windows: tuple[Pair, ...]) -> dict[str, Any]:
    value, angle = found.deflection.sel(link=link).values, found.angle.sel(link="crank").values
    natural = math.tau / modal(mechanism.link(link)).frequency[0]
    width = max(1, round(natural / float(found.time[1] - found.time[0])))
    each = [_each(_turns(found), window) for window in windows]
    whole = [np.concatenate(rows) for rows in each]
    return {
        "rms_deflection": [mean([rms(value[rows]) for rows in one]) for one in each],
        "vibration": [mean([vibration(value[rows], width) for rows in one]) for one in each],
        "irregularity": [irregularity(angle[rows], value[rows]) for rows in whole],
    }


def vibration(value: np.ndarray, width: int) -> float:
    """Part of a deflection faster than the first natural vibration, over the whole: root mean squares.

    Parameters
    ----------
    value : ndarray, shape (samples,)
        Even samples.
    width : int
        Samples in a period of that vibration: its mean over a period is what is slow.
    """
    slow = np.convolve(value, np.ones(width) / width, "valid")
    left = (width - 1) // 2
    return rms(value[left : left + len(slow)] - slow) / rms(value)


def irregularity(angle: np.ndarray, value: np.ndarray) -> Pair:
    """Change from one turn to the next at equal crank angle, over the whole: root mean squares.

    Parameters
    ----------
    angle : ndarray, shape (samples,)
        Crank angle, monotonic, rad.
    value : ndarray, shape (samples,)
        What should repeat.

    Returns
    -------
    (float, float)
        Mean over the changes and its standard error. 0: the same every turn; sqrt(2): turns that have
        nothing in common. NaN for less than two turns.
    """
    turns = np.abs(angle - angle[0]) / math.tau
    whole = math.floor(turns[-1])
    if whole < 2:
        return math.nan, math.nan
    per_turn = len(value) // (whole + 1)
    table = np.interp(np.arange(whole * per_turn) / per_turn, turns, value).reshape(whole, per_turn)
    return mean(np.sqrt(np.mean(np.diff(table, axis=0) ** 2, axis=1)) / rms(table))
