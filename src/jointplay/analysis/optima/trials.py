"""Trials of an optimisation: quantities and exact derivatives at a design, in scaled variables.

With the bounds l, u of the variables p, the scaled ones are x = (p - l) / (u - l), 0…1. Each design is tried
once; what was found is kept, in order, and is what the dataset shows as iterations. Where a periodic orbit
was found at one design, it is sought at the next ones from where its derivative leads: no transient is
followed, and the orbit is the same one, stable or not.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from jointplay.analysis.gradients.gradient import gradient
from jointplay.analysis.gradients.gradient_dataset import VERDICTS
from jointplay.analysis.quantities import STATUS
from jointplay.display.errors import InputError, ModelWarning
from jointplay.solver.mechanism.records import Mechanism, TestSystem
from jointplay.solver.motion.progress import tick

INVALID = STATUS.index("not_converged")


@dataclass(frozen=True)
class Trial:
    """Evaluation of a design: its quantities and their derivatives in the scaled variables.

    `share` of the clearance, 0 with ideal joints. `status`: index into `STATUS`; all but 0: no motion to
    differentiate. `verdict`: index into `VERDICTS`. `orbit`, `moves`: where the periodic orbit starts, and
    the derivatives of that in the scaled variables.
    """

    x: np.ndarray
    values: np.ndarray
    slopes: np.ndarray
    status: int
    verdict: int
    share: float
    orbit: np.ndarray | None = None
    moves: np.ndarray | None = None


class NoMotion(ArithmeticError):
    """A design whose motion has no derivative: the step that led there was too long."""


@dataclass
class Trials:
    """Designs of a mechanism, each tried once.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        As it is first.
    quantities : tuple of str
        What is looked at.
    by : mapping of str to (float, float)
        Bounds of each variable.
    settings : mapping of str to object
        Keywords of `gradient`.
    share : float
        Of the clearance in these trials.
    made : list of Trial
        All so far, those with other clearance too.
    tell : callable
        Called with their number whenever there is one more.
    """

    mechanism: Mechanism | TestSystem
    quantities: tuple[str, ...]
    by: Mapping[str, tuple[float, float]]
    settings: Mapping[str, Any]
    share: float
    made: list[Trial]
    tell: Callable[[int], None]
    known: dict[bytes, Trial] = field(default_factory=dict)
    near: Trial | None = None

    @property
    def low(self) -> np.ndarray:
        """Lower bounds."""
        return np.array([low for low, _ in self.by.values()])

    @property
    def width(self) -> np.ndarray:
        """Upper less lower bounds."""
        return np.array([high - low for low, high in self.by.values()])

    def design(self, x: np.ndarray) -> Mechanism | TestSystem:
        """The mechanism at scaled variables."""
        return self.mechanism.varied(dict(zip(self.by, map(float, self.low + self.width * x), strict=True)))

    def at(self, x: np.ndarray) -> Trial:
        """Evaluate a design, once, and keep it in the list of trials."""
        key = np.asarray(x, dtype=float).tobytes()
        if key not in self.known:
            self.known[key] = self.tried(np.array(x, dtype=float))
            self.made.append(self.known[key])
            self.tell(len(self.made))
        return self.known[key]

    def tried(self, x: np.ndarray) -> Trial:
        """Evaluate a design."""
        tick()
        n, m = len(self.quantities), len(x)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", ModelWarning)  # the verdict is kept with the trial
                given = {"of": self.quantities, "by": tuple(self.by), "progress": None}
                found = gradient(self.design(x), **given, **self.settings | self._start(x))
        except InputError:  # numbers that make no mechanism together, as links that do not reach
            nothing = np.full(n, np.nan), np.full((n, m), np.nan)
            return Trial(x, *nothing, INVALID, len(VERDICTS) - 1, self.share)
        slopes = found["derivative"].values * self.width
        status = int(found["status"])
        if not status and not (np.isfinite(slopes).all() and np.isfinite(found["value"].values).all()):
            status = INVALID
        trial = Trial(x, found["value"].values, slopes, status, int(found["derivative_status"]), self.share)
        if not status and "orbit_state" in found:
            moves = found["orbit_state_derivative"].values * self.width
            self.near = trial = replace(trial, orbit=found["orbit_state"].values, moves=moves)
        return trial

    def _start(self, x: np.ndarray) -> dict[str, Any]:
        """Keywords by which the orbit at a design is sought near the one found last."""
        if self.near is None:
            return {}
        state = self.near.orbit + self.near.moves @ (x - self.near.x)
        return {"initial": state.tolist(), "transient": 0}


@dataclass(frozen=True)
class Aim:
    """Aim and constraints on values q: f = q_least is to be least, with low <= q <= high.

    Parameters
    ----------
    least : int or None
        Index of the quantity that is made least; None: the change of the variables is.
    sign : float
        -1: it is made largest instead.
    limits : ndarray
        Low and high of each quantity, shape (quantities, 2); infinite where there is none.
    first : ndarray
        Scaled variables of the mechanism as it is.
    units : ndarray
        Size of each quantity.
    """

    least: int | None
    sign: float
    limits: np.ndarray
    first: np.ndarray
    units: np.ndarray

    def sized(self, trial: Trial) -> Aim:
        """The aim with its quantities' size at a design, and that of their limits, as their units."""
        ends = np.where(np.isfinite(self.limits), np.abs(self.limits), 0.0).max(axis=1)
        size = np.maximum(np.nan_to_num(np.abs(trial.values)), ends)
        return replace(self, units=np.where(size > 0, size, 1.0))

    def value(self, trial: Trial) -> float:
        """The objective, in units of its quantity."""
        if self.least is None:
            return float(np.sum((trial.x - self.first) ** 2))
        return float(self.sign * trial.values[self.least] / self.units[self.least])

    def shown(self, trial: Trial) -> float:
        """Value of the aim, in its own units."""
        return self.value(trial) if self.least is None else float(trial.values[self.least])

    def slope(self, trial: Trial) -> np.ndarray:
        """Derivatives of the objective."""
        if self.least is None:
            return 2 * (trial.x - self.first)
        return self.sign * trial.slopes[self.least] / self.units[self.least]

    def margins(self, trial: Trial) -> np.ndarray:
        """Margin of each constraint, negative where it is not kept, in units of its quantity."""
        rows, sides = np.nonzero(np.isfinite(self.limits))
        beyond = trial.values[rows] - self.limits[rows, sides]
        return np.where(sides == 0, beyond, -beyond) / self.units[rows]

    def margin_slopes(self, trial: Trial) -> np.ndarray:
        """Derivatives of the margins."""
        rows, sides = np.nonzero(np.isfinite(self.limits))
        return trial.slopes[rows] * (np.where(sides == 0, 1.0, -1.0) / self.units[rows])[:, None]

    def missed(self, trial: Trial) -> float:
        """Amount by which the worst constraint is not kept; infinite where there is no motion."""
        return float("inf") if trial.status else float(np.max(-self.margins(trial), initial=0.0))

    def better(self, one: Trial, other: Trial | None, slack: float) -> bool:
        """Whether a trial is better than another: constraints first, then the objective."""
        if other is None:
            return True
        ours, theirs = self.missed(one), self.missed(other)
        if max(ours, theirs) > slack:
            return ours < theirs
        return self.value(one) < self.value(other)


def best(trials: list[Trial], aim: Aim, slack: float) -> Trial:
    """The best of some trials."""
    found: Trial | None = None
    for each in trials:
        found = each if aim.better(each, found, slack) else found
    return found
