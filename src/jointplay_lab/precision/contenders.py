"""The methods compared: this package's, and the loop over events that its peers share."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, field

import numpy as np

from jointplay.analysis.quantities import STATUS
from jointplay.solver.mechanism.model import Model
from jointplay.solver.motion.progress import from_progress, tick
from jointplay.solver.motion.trajectory import MAX_STEPS, Request, advance, memory
from jointplay_lab.precision.generated_code import Equations, Event

OURS = "jointplay"
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

    name = OURS

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

    name = ""

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
