"""Where a quantity is largest in a motion: within a smooth piece, or on one side of an event, or at an end.

The motion is followed again, sampled closer about the largest value so far: motions are the same each time,
samples do not change steps. Within a piece the place is the top of a polynomial through many samples of a
more exact run, since the derivative of a largest value is exact only there.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from jointplay.analysis.gradients.at_points import values
from jointplay.solver.mechanism.model import Model
from jointplay.solver.motion.trajectory import Records, Request, follow

SAMPLES, CLOSER, ROUNDS = 4096, 33, 2  # of a turn; about the largest; how often
DEGREE, SHARPER, LEAST = 6, 1e-2, 1e-13  # of the polynomial; tolerance of its run in that of the motion's


class Peak(NamedTuple):
    """Time of an extreme value, its place (``within`` a piece, ``before`` an event, …), and its size."""

    time: float
    where: str
    value: float


def peak(model: Model, key: str, sign: float, end: float, turns: float, rtol: float, limit: int) -> Peak:
    """The largest value of sign times a quantity from time 0 to `end`.

    Raises
    ------
    ArithmeticError
        With the status, if the motion did not get there.
    """
    times = np.linspace(0.0, end, max(int(turns * SAMPLES), CLOSER))
    for _ in range(ROUNDS):
        records = _followed(model, end, rtol, times, limit)
        rows = np.concatenate([records.steps[:, 2:], records.samples])
        rows = rows[np.argsort(rows[:, 0], kind="stable")]
        found = sign * values(model, rows, key)
        top = int(np.nanargmax(found))
        at = float(rows[top, 0])
        low = rows[rows[:, 0] < at, 0].max(initial=0.0)
        high = rows[rows[:, 0] > at, 0].min(initial=end)
        times = np.unique(np.append(np.linspace(low, high, CLOSER), at))
    if np.any(records.events[:, 2] == at):
        sides = sign * values(model, records.steps[records.steps[:, 2] == at, 2:], key)
        first, last = np.abs(sides[[0, -1]] - found[top])
        return Peak(at, "before" if first <= last else "after", sign * float(found[top]))
    if at in (0.0, end):
        return Peak(at, "start" if at == 0.0 else "end", sign * float(found[top]))
    samples = _followed(model, end, max(SHARPER * rtol, LEAST), times, limit).samples
    place, most = _top(samples[:, 0], sign * values(model, samples, key), at)
    return Peak(place, "within", sign * most)


def _followed(model: Model, end: float, rtol: float, times: np.ndarray, limit: int) -> Records:
    fields = {"steps": True, "events": True, "log_from": 0.0, "max_steps": limit}
    records = follow(model, Request(end, rtol, at=times, **fields))
    if records.status:
        raise ArithmeticError(records.status)
    return records


def _top(times: np.ndarray, found: np.ndarray, guess: float) -> tuple[float, float]:
    """Time and size of the largest value of the polynomial through the samples; the guess's if outside."""
    middle, half = (times[0] + times[-1]) / 2, (times[-1] - times[0]) / 2
    fit = np.polynomial.Polynomial.fit(times, found, DEGREE)
    roots = fit.deriv().roots()
    inside = np.real(roots[(abs(roots.imag) < 1e-6 * half) & (abs(roots.real - middle) <= half)])
    place = float(max(inside, key=fit, default=guess))
    return place, float(fit(place))
