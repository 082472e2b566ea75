"""Runs of all methods, taking turns: first one of each that is judged, then rounds that are only timed.

SciPy's and SUNDIALS' solvers are peers: compiled rates, Jacobians, guards; events located, then restarted.
References: A. C. Hindmarsh et al., ACM Trans. Math. Softw. 31 (2005) 363-396 (CVODE); L. Petzold, SIAM J.
Sci. Stat. Comput. 4 (1983) 136-148 (LSODA); E. Hairer and G. Wanner, Solving Ordinary Differential Equations
I and II (DOP853, Radau).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from jointplay.solver.mechanism.model import Model
from jointplay.solver.motion.looks import seen
from jointplay_lab.precision.contenders import OURS, Ours, Outcome, Peer, Trouble
from jointplay_lab.precision.generated_code import Equations
from jointplay_lab.precision.taylor import Heyoka
from jointplay_lab.precision.truth import Truth

NEXT = 3.0  # a run at the next tolerance may take so many times as long as the last
SHORT = 0.01  # s: the first run after another method's tells what it left in the processor's caches
FEWEST = 1e-4  # s: least cost of a round, beside the run itself
EXPLICIT = ("DOP853",)


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


class Cvode(Peer):
    """Variable-order BDF with root functions; a new solver after each event."""

    name = "CVODE"

    def __init__(self, *given):
        from sksundae.cvode import CVODE

        super().__init__(*given)
        self.solver = CVODE

    def integrate(self, t: float, y: np.ndarray) -> tuple[float, np.ndarray, int | None]:
        equations, n = self.equations, self.equations.guards

        def rate(time, state, out):
            self.count()
            equations.rate(time, state, out)

        def jacobian(time, state, _, out):
            equations.jacobian(time, state, out)

        def roots(time, state, out):
            equations.roots(time, state, out)

        roots.terminal, roots.direction = [True] * n, [-1] * n
        options = {"eventsfn": roots, "num_events": n} if n else {}
        options |= {"jacfn": jacobian, "max_num_steps": 10**8, "rtol": self.tolerance, "atol": self.absolute}
        found = self.solver(rate, **options).solve([t, self.end], y)
        self.steps += len(found.t)
        end, state = float(found.t[-1]), np.array(found.y[-1])
        if found.status == 2:
            return end, state, int(np.flatnonzero(found.i_events[-1])[0])
        if end < self.end:
            raise Trouble("not_converged")
        return end, state, None


class Scipy(Peer):
    """A method of `scipy.integrate.solve_ivp`, with terminal events."""

    def __init__(self, name: str, *given):
        from scipy.integrate import solve_ivp

        super().__init__(*given)
        self.solver = solve_ivp
        self.name = name
        self._out, self._square = np.empty(len(self.absolute)), np.empty(2 * [len(self.absolute)])

    def integrate(self, t: float, y: np.ndarray) -> tuple[float, np.ndarray, int | None]:
        equations = self.equations

        def rate(time, state):
            self.count()
            equations.rate(time, state, self._out)
            return self._out.copy()

        def jacobian(time, state):
            equations.jacobian(time, state, self._square)
            return self._square.copy()

        options = {"method": self.name, "rtol": self.tolerance, "atol": self.absolute}
        options |= {"events": self._guards(), "first_step": min(self.first_step, self.end - t)}
        options |= {} if self.name in EXPLICIT else {"jac": jacobian}
        found = self.solver(rate, (t, self.end), y, **options)
        self.steps += len(found.t) - 1
        if found.status == -1:
            raise Trouble("not_converged")
        fired = [k for k, times in enumerate(found.t_events or ()) if len(times)]
        return float(found.t[-1]), found.y[:, -1].copy(), fired[0] if found.status == 1 else None

    def _guards(self):
        """The watched guards, as functions of their own that share an evaluation's array."""
        out = np.empty(max(self.equations.guards, 1))

        def one(k):
            def guard(time, state):
                self.equations.roots(time, state, out)
                return out[k]

            guard.terminal, guard.direction = True, -1
            return guard

        return [one(k) for k in range(self.equations.guards)] or None
