"""Section points of a motion followed by coarse fixed steps, without location of events.

What a simple program gives: contact is looked at where the steps happen to fall. A numerical-chaos hypothesis
to try on published sections; as an answer about the mechanism use `poincare`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from jointplay.analysis.evaluate import Quantities
from jointplay.analysis.rules import SLACK
from jointplay.analysis.starts import crank_place
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.model import Model
from jointplay.solver.mechanism.records import Mechanism, TestSystem
from jointplay_lab.paper.fixed_steps import March, accepted_step

CHUNK = 16384  # steps followed at once
UPDATES, CLOSE = 8, 1e-12  # of a section point's place in its step
RELEASED = 1  # the last contact mode without a force
QUANTITIES = ("angle", "angular_velocity", "journal_x", "journal_y", "penetration", "normal_velocity")


def coarse_section(
    mechanism: Mechanism | TestSystem,
    step: float | None,
    turns: int,
    transient: int = 0,
    initial: Any = None,
) -> dict[str, np.ndarray]:
    """Cut a motion that is followed by fixed steps at the crank angle of its start, once a turn.

    Each point is reached by a shorter step of the method from the last step before it.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        What moves; a test system must be forced.
    step : float or None
        Step, s, at most the longest stable one; None: half of that.
    turns, transient : int
        Section points kept, and section points dropped before.
    initial : optional
        As in `simulate`.

    Returns
    -------
    dict of str to ndarray
        By point, then as said: ``time`` (s), ``state`` (states), ``mode`` (contacts), ``separations``
        (contacts; how often the steps saw contact lost in the turn that ends there), and for a linkage those
        of `QUANTITIES` that it has (links or joints). Fewer points than asked for if the motion grows beyond
        measure or the crank stops turning.

    Raises
    ------
    InputError
        If the step is too long, or the start does not fit.
    """
    model = assemble(mechanism, initial)
    h, march, crank = accepted_step(model, step), March.of(model), Crank.of(model)
    n_x, wanted = len(model.state), transient + turns
    start, lost = np.concatenate([[0.0], model.state]), np.zeros(len(model.joints), dtype=np.int64)
    points, losses = [], [lost]
    while len(points) < wanted and start[0] < SLACK * model.period * wanted:
        rows = march(start, h, CHUNK)
        touching = rows[:, 1 + n_x :] > RELEASED
        total = lost + np.cumsum(touching[:-1] & ~touching[1:], axis=0)
        for i in crank.passes(rows):
            points.append(_point(march, crank, rows[i], h))
            losses.append(total[i])
        if not np.all(np.isfinite(rows[-1])):
            break
        start, lost = rows[-1, : 1 + n_x], total[-1]
    kept = slice(transient, wanted)
    rows = np.array(points).reshape(len(points), 1 + n_x + len(model.joints))[kept]
    separations = np.diff(np.array(losses), axis=0)[kept]
    return _columns(model, rows) | {"separations": separations}


@dataclass(frozen=True)
class Crank:
    """The crank's angle in a record's row (or the phase of a forcing): a column of it, or rate times time."""

    column: int | None
    rate: float
    start: float
    forward: int

    @classmethod
    def of(cls, model: Model) -> Crank:
        """Read it from a model."""
        place, forward = crank_place(model), -1 if model.crank_speed < 0 else 1
        column = None if place is None else 1 + place  # after the time
        return cls(column, forward * math.tau / model.period, model.crank_angle, forward)

    def __call__(self, rows: np.ndarray) -> np.ndarray:
        """Turns made since the start."""
        if self.column is None:
            return rows[..., 0] * abs(self.rate) / math.tau
        return (rows[..., self.column] - self.start) * self.forward / math.tau

    def passes(self, rows: np.ndarray) -> np.ndarray:
        """Numbers of the rows after which a turn is completed."""
        whole = np.floor(self(rows))
        return np.flatnonzero(whole[1:] > np.maximum.accumulate(whole)[:-1])


def _point(march: March, crank: Crank, row: np.ndarray, h: float) -> np.ndarray:
    """The record where the turn is completed, within a step from `row`."""
    start = row[: 1 + len(march.model.state)]
    before = crank(row)
    target, place, rate = np.floor(before) + 1.0, 0.0, None
    found, value = row, before
    for _ in range(UPDATES):
        if rate is None:
            rate = crank(march(start, h, 1)[-1]) - before
        change = (target - value) / rate
        place += change
        found = march(start, place * h, 1)[-1]
        value = crank(found)
        if abs(change) < CLOSE:
            break
    return found


def _columns(model: Model, rows: np.ndarray) -> dict[str, np.ndarray]:
    """Columns of the points by name."""
    n_x = len(model.state)
    columns = {"time": rows[:, 0], "state": rows[:, 1 : 1 + n_x], "mode": rows[:, 1 + n_x :].astype(np.int8)}
    if model.links:
        names = QUANTITIES if model.joints else QUANTITIES[:2]
        values = Quantities(model, rows, rows[0]).variables(names, "turn")
        columns |= {name: each[1] for name, each in values.items()}
    return columns
