"""Runs of all methods, taking turns: first one of each that is judged, then rounds that are only timed."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from jointplay.solver.mechanism.model import Model
from jointplay.solver.motion.looks import seen
from jointplay_lab.precision.contenders import OURS, Ours, Outcome, Peer
from jointplay_lab.precision.generated_code import Equations
from jointplay_lab.precision.solvers import Cvode, Scipy
from jointplay_lab.precision.taylor import Heyoka
from jointplay_lab.precision.truth import Truth

NEXT = 3.0  # a run at the next tolerance may take so many times as long as the last
SHORT = 0.01  # s: the first run after another method's tells what it left in the processor's caches
FEWEST = 1e-4  # s: least cost of a round, beside the run itself


@dataclass
class Row:
    """A method at a tolerance: outcome and error of its first run, and the times of all timed runs, s."""

    method: str
    tolerance: float
    contender: Ours | Peer
    outcome: Outcome = field(default_factory=lambda: Outcome("not_run"))
    error: float = math.nan
    agreement: str = "no_end"
    compiling: float = 0.0
    times: list[float] = field(default_factory=list)

    @property
    def median(self) -> float:
        """Median time; of the first run where there was no other."""
        return float(np.median(self.times)) if self.times else self.outcome.seconds

    def timed(self) -> float:
        """Time of one more run, s; a short one is made twice, and the second counts."""
        seconds = self.contender.run().seconds
        return self.contender.run().seconds if seconds < SHORT else seconds

    @property
    def spread(self) -> float:
        """Half the distance of the times' quartiles; NaN of fewer than three."""
        if len(self.times) < 3:
            return math.nan
        low, high = np.percentile(self.times, [25, 75])
        return float(high - low) / 2


def contender(
    method: str | type[Peer], model: Model, tolerance: float, end: float, truth: Truth, max_steps: int
) -> Ours | Peer:
    """A method, named or given as the class of a peer, ready to run."""
    if method == OURS:
        return Ours(model, tolerance, end, max_steps)
    given = Equations(model, tolerance), tolerance, end, truth.unit, len(truth.outcome.events)
    if isinstance(method, str):
        method = {"heyoka": Heyoka, "CVODE": Cvode}.get(method, partial(Scipy, method))
    return method(*given)


def measure(
    rows: Sequence[Row],
    truth: Truth,
    rounds: int,
    budget: float,
    progress: Callable[[float], None] | None = None,
) -> None:
    """Judge every row by the truth, then time all of them in turns, `rounds` times at most.

    The rows of each method go from loose to tight tolerances. The methods share the `budget` of CPU time (s)
    evenly, and have as much for compiling; a run that would not fit is left out, and so are tighter ones.
    """
    share = budget / max(1, len({row.method for row in rows}))
    spent, compiled = (dict.fromkeys((row.method for row in rows), 0.0) for _ in range(2))
    tell = progress or (lambda _: None)
    for number, row in enumerate(seen(rows)):
        if compiled[row.method] < share:
            _judge(row, rows[:number], truth, spent, share)
        compiled[row.method] += row.compiling
        tell(0.6 * (number + 1) / len(rows))
    for count in range(rounds):
        for row in seen(sorted(rows, key=lambda row: -row.tolerance)):
            if row.outcome.status == "ok" and spent[row.method] + row.outcome.seconds < share:
                row.times.append(row.timed())
                spent[row.method] += row.times[-1] + FEWEST
        tell(0.6 + 0.4 * (count + 1) / rounds)


def _judge(row: Row, before: Sequence[Row], truth: Truth, spent: dict[str, float], share: float) -> None:
    """Run a row once, unless its method has no time left for it."""
    mine = [one for one in before if one.method == row.method and one.outcome.status == "ok"]
    left, took = share - spent[row.method], mine[-1].outcome.seconds if mine else 0.0
    if not NEXT * took < left:
        return
    row.outcome = row.contender.run(left / 2)
    row.compiling = getattr(row.contender, "compiling", 0.0)
    spent[row.method] += row.outcome.seconds
    row.error, row.agreement = truth.error(row.outcome), truth.agreement(row.outcome, row.tolerance)


def time_at(rows: Sequence[Row], error: float) -> float:
    """CPU time (s) at which a method reaches an error; NaN where it does not.

    Between the runs that no other run of it beats, log over log.
    """
    timed = [row for row in rows if 0 < row.median < math.inf]  # 0: too short to time
    front: list[Row] = []
    for row in sorted((row for row in timed if row.agreement == "same"), key=lambda row: row.median):
        if not front or row.error < front[-1].error:
            front.append(row)
    if not front or front[-1].error > error:
        return math.nan
    errors = [math.log(max(row.error, 1e-300)) for row in reversed(front)]
    times = [math.log(row.median) for row in reversed(front)]
    return math.exp(np.interp(math.log(error), errors, times))
