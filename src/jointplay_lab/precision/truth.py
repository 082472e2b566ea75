"""The end of a motion with which all runs are compared, and the agreement of a run with it.

The truth is the method's own run at the tightest tolerance, and counts as confirmed where another method's
tightest run meets the same events and comes within `CONFIRMED` of it; how close it comes is how well the
truth is known, and errors below that mean nothing. A run of a method agrees where it meets the truth's
events, in their order, and its error is within `LARGE` times its tolerance: a solver whose equations were
others would not come closer however tight its tolerance.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from jointplay.solver.mechanism.model import Model
from jointplay.solver.motion.trajectory import MAX_STEPS
from jointplay_lab.precision.contenders import Ours, Outcome
from jointplay_lab.precision.generated_code import units

AGREEMENT = ("same", "other_events", "other_state", "no_end")
CONFIRMED = 1e-6
LARGE = 1e5
LOOSER = 10.0  # tolerance of the run that says how far the truth's own error may reach


@dataclass(frozen=True)
class Truth:
    """End of a motion: the tightest run, its difference from one at ten times its tolerance, units."""

    outcome: Outcome
    own_difference: float
    unit: np.ndarray

    @classmethod
    def of(cls, model: Model, rtol: float, end: float, max_steps: int = MAX_STEPS) -> Truth:
        """Follow a model up to a time with the tightest tolerance, and once more."""
        tight = Ours(model, rtol, end, max_steps).run()
        truth = cls(tight, math.nan, units(model))
        looser = Ours(model, LOOSER * rtol, end, max_steps).run()
        return cls(tight, truth.error(looser), truth.unit)

    def error(self, outcome: Outcome) -> float:
        """Largest difference of a state at the end, in its unit; NaN where either run did not get there."""
        if outcome.status != "ok" or self.outcome.status != "ok":
            return math.nan
        return float(np.max(np.abs(outcome.state - self.outcome.state) / self.unit))

    def agreement(self, outcome: Outcome, tolerance: float) -> str:
        """Agreement of a run, as a word of `AGREEMENT`."""
        error = self.error(outcome)
        if not math.isfinite(error):
            return "no_end"
        if outcome.events != self.outcome.events:
            return "other_events"
        return "same" if error <= LARGE * tolerance else "other_state"
