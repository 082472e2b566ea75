"""The methods compared: this package's and its peers, which share a loop over events.

A peer is a class of `Peer`: its name, the package that it needs, and how it gets to the next root. Those of
SciPy and SUNDIALS call compiled rates, Jacobians and guards; heyoka is in `jointplay_lab.precision.taylor`.
References: A. C. Hindmarsh et al., ACM Trans. Math. Softw. 31 (2005) 363-396 (CVODE); L. Petzold, SIAM J.
Sci. Stat. Comput. 4 (1983) 136-148 (LSODA); E. Hairer and G. Wanner, Solving Ordinary Differential Equations
I and II (DOP853, Radau).
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from jointplay.analysis.quantities import STATUS
from jointplay.solver.mechanism.model import Model
from jointplay.solver.motion.progress import from_progress, tick
from jointplay.solver.motion.trajectory import MAX_STEPS, Request, advance, memory
from jointplay_lab.precision.generated_code import Equations, Event

LOOK = 1024  # evaluations between two looks at the time
ENDLESS = 10, 100  # times as many events as the truth has, and so many more, are no end of them


class Trouble(ArithmeticError):
    """Early end of a run, named by a word of `STATUS`."""


@dataclass
class Outcome:
    """End of a run: its status and state, CPU time in s, counts and events."""

    status: str = "ok"
    state: np.ndarray = field(default_factory=lambda: np.zeros(0))
    seconds: float = math.nan
    evaluations: float = math.nan
    steps: int = 0
    events: list[Event] = field(default_factory=list)


class Ours:
    """This package's method; the integration is timed, assembling and allocating are not."""

    name = "jointplay"

    def __init__(self, model: Model, tolerance: float, end: float, max_steps: int = MAX_STEPS):
        request = Request(end, tolerance, events=True, log_from=0.0, max_steps=max_steps)
        self.model, self.tolerance, self.request = model, tolerance, request

    def run(self, limit: float = math.inf) -> Outcome:
        """Integrate up to the end; `limit`, of CPU time, is for peers: this method has a limit of steps."""
        from jointplay.solver.method import memory as at
        from jointplay.solver.method.control import FULL

        work, motion, options = memory(self.model, self.request)
        events: list[Event] = []
        seconds, code = 0.0, FULL
        while code == FULL:
            began = time.process_time()
            code = advance(self.model.structure, work, motion, options)
            seconds += time.process_time() - began
            events += [(int(row[1]), int(row[2])) for row in motion.log[: motion.count[at.LOGGED]]]
            motion.count[at.LOGGED] = 0
        steps = int(motion.count[[at.STEPS, at.REJECTED, at.FAILED]].sum())
        state = motion.s[1 : 1 + len(self.model.state)].copy()
        return Outcome(STATUS[code], state, seconds, float(motion.count[at.EVALUATIONS]), steps, events)


class Peer:
    """Base class of other solvers: a subclass integrates up to a root, this goes on from event to event.

    It solves the equations up to time `end`, s, with a relative tolerance and, in the states' units, a
    hundredth of it as absolute tolerance; `events` is the number of events that the motion has.
    """

    name: ClassVar[str]
    package: ClassVar[str]  # that it comes from

    def __init__(self, equations: Equations, tolerance: float, end: float, unit: np.ndarray, events: int):
        self.equations, self.tolerance, self.end = equations, tolerance, end
        self.absolute, self.most = tolerance / 100 * unit, ENDLESS[0] * events + ENDLESS[1]
        self.first_step = 1e-7 * equations.model.period  # a motor at no load shows no time scale in its rate
        self.evaluations, self.steps, self.compiling, self.deadline = 0, 0, 0.0, math.inf

    def run(self, limit: float = math.inf) -> Outcome:
        """Follow the motion for at most `limit` s of CPU time; compilation is not counted."""
        began = time.process_time()
        self.evaluations, self.steps, self.compiling, self.deadline = 0, 0, 0.0, began + limit
        outcome = Outcome()
        try:
            outcome.state = self._follow(outcome.events)
        except Trouble as trouble:
            outcome.status = str(trouble)
        except Exception as error:  # a peer may fail in any way of its own
            if from_progress(error):
                raise
            outcome.status = "crashed"
        outcome.seconds = time.process_time() - began - self.compiling
        outcome.evaluations, outcome.steps = self.counted(), self.steps
        return outcome

    def _follow(self, events: list[Event]) -> np.ndarray:
        self.equations.begin()
        t, y = 0.0, self.equations.start.copy()
        while True:
            t, y, fired = self.integrate(t, y)
            if fired is None:
                return y
            y, event = self.equations.after_event(t, y, fired)
            events.append(event)
            if len(events) > self.most:
                raise Trouble("chatter")

    def integrate(self, t: float, y: np.ndarray) -> tuple[float, np.ndarray, int | None]:
        """Follow the motion in its present modes; give back time, state, and the watched guard that fired."""
        raise NotImplementedError

    def counted(self) -> float:
        """Evaluations of the rates; NaN where they are not counted so."""
        return float(self.evaluations)

    def count(self) -> None:
        """Count an evaluation, and stop where time is up."""
        self.evaluations += 1
        if not self.evaluations % LOOK:
            self.tick()

    def tick(self) -> None:
        """Stop where time is up."""
        tick()
        if time.process_time() > self.deadline:
            raise Trouble("step_limit")


class Cvode(Peer):
    """Variable-order BDF with root functions; a new solver after each event."""

    name, package = "CVODE", "sksundae"

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
    """Base class of the methods of `scipy.integrate.solve_ivp`, with terminal events."""

    package = "scipy"
    implicit: ClassVar[bool] = True

    def __init__(self, *given):
        from scipy.integrate import solve_ivp

        super().__init__(*given)
        self.solver = solve_ivp
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
        options |= {"jac": jacobian} if self.implicit else {}
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


class Lsoda(Scipy):
    """Adams' methods and BDF, by turns."""

    name = "LSODA"


class Radau(Scipy):
    """Radau IIA of order 5."""

    name = "Radau"


class Dop853(Scipy):
    """Dormand and Prince's explicit method of order 8."""

    name, implicit = "DOP853", False
