"""What competes: this package's method, and the loop over events that its peers share."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, field

import numpy as np

from jointplay.analysis.looks import from_progress, look
from jointplay.analysis.quantities import STATUS
from jointplay.analysis.trajectory import MAX_STEPS, Request, advance, memory
from jointplay.codegen import cache
from jointplay.lab.precision.generated_code import Equations, Event
from jointplay.mechanism.model import Model

OURS = "jointplay"
LOOK = 1024  # evaluations between two looks at the time
ENDLESS = 10, 100  # times as many events as the truth has, and so many more, are no end of them


class Trouble(ArithmeticError):
    """A run that ends early, with a word of `STATUS`."""


@dataclass
class Outcome:
    """What a run reached: its state, s of CPU time, and counts."""

    status: str = "ok"
    state: np.ndarray = field(default_factory=lambda: np.zeros(0))
    seconds: float = math.nan
    evaluations: float = math.nan
    steps: int = 0
    events: list[Event] = field(default_factory=list)


class Ours:
    """This package's method. What is timed is the integration; assembling and allocating come before."""

    name = OURS

    def __init__(self, model: Model, tolerance: float, end: float, max_steps: int = MAX_STEPS):
        request = Request(end, tolerance, events=True, log_from=0.0, max_steps=max_steps)
        self.model, self.tolerance, self.request = model, tolerance, request

    def run(self, limit: float = math.inf) -> Outcome:
        """Follow the motion; `limit` is for peers, this has its own of steps."""
        from jointplay.numerics import memory as at

        full, (k, x, o) = cache.method("flow").FULL, memory(self.model, self.request)
        events: list[Event] = []
        seconds, code = 0.0, full
        while code == full:
            began = time.process_time()
            code = advance(self.model.structure, k, x, o)
            seconds += time.process_time() - began
            events += [(int(row[1]), int(row[2])) for row in x.log[: x.count[at.LOGGED]]]
            x.count[at.LOGGED] = 0
        steps = int(x.count[[at.STEPS, at.REJECTED, at.FAILED]].sum())
        state = x.s[1 : 1 + len(self.model.state)].copy()
        return Outcome(STATUS[code], state, seconds, float(x.count[at.EVALUATIONS]), steps, events)


class Peer:
    """A solver that follows a motion up to a root; here it goes on from event to event.

    Parameters
    ----------
    equations : Equations
        What it solves.
    tolerance : float
        Its relative tolerance.
    end : float
        Time to stop at, s.
    unit : ndarray
        Unit of each state; a hundredth of the tolerance, in these, is its absolute tolerance.
    events : int
        How many events the motion has.
    """

    name = ""

    def __init__(self, equations: Equations, tolerance: float, end: float, unit: np.ndarray, events: int):
        self.equations, self.tolerance, self.end = equations, tolerance, end
        self.absolute, self.most = tolerance / 100 * unit, ENDLESS[0] * events + ENDLESS[1]
        self.first_step = 1e-7 * equations.model.period  # a motor at no load shows no time scale in its rate
        self.evaluations, self.steps, self.compiling, self.deadline = 0, 0, 0.0, math.inf

    def run(self, limit: float = math.inf) -> Outcome:
        """Follow the motion for at most `limit` s of CPU time; what it compiles is not counted in."""
        began = time.process_time()
        self.evaluations, self.steps, self.compiling, self.deadline = 0, 0, 0.0, began + limit
        found = Outcome()
        try:
            found.state = self._follow(found.events)
        except Trouble as trouble:
            found.status = str(trouble)
        except Exception as error:  # a peer may fail in any way of its own
            if from_progress(error):
                raise
            found.status = "crashed"
        found.seconds = time.process_time() - began - self.compiling
        found.evaluations, found.steps = self.counted(), self.steps
        return found

    def _follow(self, events: list[Event]) -> np.ndarray:
        self.equations.begin()
        t, y = 0.0, self.equations.start.copy()
        while True:
            t, y, fired = self.until(t, y)
            if fired is None:
                return y
            y, event = self.equations.meet(t, y, fired)
            events.append(event)
            if len(events) > self.most:
                raise Trouble("chatter")

    def until(self, t: float, y: np.ndarray) -> tuple[float, np.ndarray, int | None]:
        """Follow the motion in its present modes; give back time, state, and the watched guard that fired."""
        raise NotImplementedError

    def counted(self) -> float:
        """Evaluations of the rates; NaN where they are not counted so."""
        return float(self.evaluations)

    def count(self) -> None:
        """Count an evaluation, and stop where time is up."""
        self.evaluations += 1
        if not self.evaluations % LOOK:
            self.look()

    def look(self) -> None:
        """Stop where time is up."""
        look()
        if time.process_time() > self.deadline:
            raise Trouble("step_limit")
