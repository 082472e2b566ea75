"""The methods compared: this package's and its peers, which share a loop over events.

A peer is a class of `Peer`: its name, the package that it needs, and how it gets to the next root. Those of
SciPy and SUNDIALS call compiled rates, Jacobians and guards. heyoka's Taylor series are of the same
expressions that ours are compiled from: an integrator for each set of modes, compiled when it is first met;
numbers are written out, slip directions are run-time parameters. Expressions tuned by hand for one mechanism
took a tenth less time.
References: A. C. Hindmarsh et al., ACM Trans. Math. Softw. 31 (2005) 363-396 (CVODE); L. Petzold, SIAM J.
Sci. Stat. Comput. 4 (1983) 136-148 (LSODA); E. Hairer and G. Wanner, Solving Ordinary Differential Equations
I and II (DOP853, Radau); F. Biscani and D. Izzo, MNRAS 504 (2021) 2614-2628 and 513 (2022) 4833-4844
(heyoka).
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any, ClassVar

import numpy as np

from jointplay.analysis.quantities import STATUS
from jointplay.solver.equations.structure import Linkage, Oscillator
from jointplay.solver.mechanism.model import Model
from jointplay.solver.method.modes import RELEASED, SLIDE, SLIP_NEGATIVE, SLIP_POSITIVE, STICK, variant_of
from jointplay.solver.motion.progress import from_progress, tick
from jointplay.solver.motion.trajectory import MAX_STEPS, Request, advance, memory
from jointplay_lab.precision.generated_code import Equations, Event

LOOK = 1024  # evaluations between two looks at the time
ENDLESS = 10, 100  # times as many events as the truth has, and so many more, are no end of them

CHUNK = 20_000  # steps between two looks at the time
SIGNS = {SLIP_POSITIVE: 1.0, SLIP_NEGATIVE: -1.0}
COMPACT = 5  # speeds; where there are more, straight code would take minutes to compile


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


class Heyoka(Peer):
    """Adaptive Taylor series with terminal events."""

    name, package = "heyoka", "heyoka"

    def __init__(self, *given):
        import heyoka

        super().__init__(*given)
        heyoka.set_logger_level_error()  # a run that diverges has a status for it
        self.ends = heyoka.taylor_outcome
        self._made: dict[tuple, tuple] = {}

    def integrate(self, t: float, y: np.ndarray) -> tuple[float, np.ndarray, int | None]:
        (ta, state, pars), guards = self._integrator(), self.equations.guards
        ta.time, state[:] = t, y
        if len(pars):
            pars[:] = slips(self.equations.key)[: len(pars)]
        if guards:
            ta.reset_cooldowns()
        while True:
            outcome, _, _, taken, *_ = ta.propagate_until(self.end, max_steps=CHUNK)
            self.steps += taken
            if outcome == self.ends.time_limit:
                return ta.time, state.copy(), None
            if int(outcome.value) < 0 and -int(outcome.value) <= guards:
                return ta.time, state.copy(), -int(outcome.value) - 1
            if outcome != self.ends.step_limit:
                raise Trouble("diverged")
            self.tick()

    def counted(self) -> float:
        """Series have no evaluations."""
        return math.nan

    def _integrator(self) -> tuple:
        """Integrator of the present modes, with views of its state and parameters."""
        key = tuple(SLIP_POSITIVE if mode == SLIP_NEGATIVE else mode for mode in self.equations.key)
        if key not in self._made:
            began = time.process_time()
            ta = self._compiled()
            self._made[key] = ta, ta.state, ta.pars
            self.compiling += time.process_time() - began
        return self._made[key]

    def _compiled(self):
        """Compile a Taylor integrator of the equations in their present modes."""
        import heyoka

        states, rates, guards = self.expressions()
        events = [heyoka.t_event(guard, direction=heyoka.event_direction.negative) for guard in guards]
        options = {"t_events": events, "fast_math": True, "compact_mode": len(rates) > 2 * COMPACT}
        system = list(zip(states, rates, strict=True))
        return heyoka.taylor_adaptive(system, np.zeros(len(states)), tol=self.tolerance, **options)

    def expressions(self) -> tuple[list[Any], list[Any], list[Any]]:
        """States, their rates and the watched guards as heyoka's expressions, in the present modes."""
        import heyoka

        equations = self.equations
        model = equations.model
        system, program = assignments(model.structure, int(variant_of(equations.modes)))
        symbols = system.positions + system.speeds
        states = [heyoka.expression(f"x{i}") for i in range(len(symbols))]
        given = {"t": heyoka.time} | dict(zip(map(str, symbols), states, strict=True))
        given |= {str(p): float(v) for p, v in zip(system.parameters, model.numbers, strict=True)}
        given |= _masks(equations, system)
        for name, value in program:
            given[name] = translated(value, given)
        n_q, n = len(system.positions), len(system.speeds)
        rates = [*states[n_q : 2 * n_q], *(given[f"out_rate_{k}"] for k in range(n))]
        watch = equations.watch.reshape(-1, 2).tolist()
        guards = [_side(equations, g, side) * given[f"out_guard_{g}"] for g, side in watch]
        return states, [rate + 0.0 * states[0] for rate in rates], guards


def slips(modes: Iterable[int]) -> list[float]:
    """Slip direction of each contact, 0 where it does not slip."""
    return [SIGNS.get(mode, 0.0) for mode in modes]


def _masks(equations: Equations, system) -> dict[str, Any]:
    """Touch and stick of the contacts as numbers, slip as run-time parameters."""
    import heyoka

    found = {}
    for j, (contact, mode) in enumerate(zip((*system.contacts, *system.resets), equations.key, strict=True)):
        found[f"touch_{contact.name}"] = float(mode > RELEASED)
        found[f"stick_{contact.name}"] = float(mode == STICK)
        found[f"slip_{contact.name}"] = heyoka.par[j] if mode in SIGNS else 0.0
    return found


def _side(equations: Equations, guard: int, side: int):
    """Factor that makes a guard positive; of a sliding speed, the run-time slip direction."""
    import heyoka

    slides = guard < 4 * len(equations.flags) and guard % 4 == SLIDE
    return heyoka.par[guard // 4] if slides else float(side)


@lru_cache(maxsize=16)
def assignments(structure: Linkage | Oscillator, variant: int) -> tuple[Any, list[tuple[str, Any]]]:
    """The equations of a variant, and their program as (name, expression) up to out_rate_k, out_guard_g."""
    from sympy import cos, sin

    from jointplay.solver.codegen.dynamics import Dynamics
    from jointplay.solver.codegen.module import guards, watched
    from jointplay.solver.codegen.variants import variants
    from jointplay.solver.equations.write import system as written

    system = written(structure)
    word = variants(system)[variant]
    solved = Dynamics(system, word)
    results = {f"out_rate_{k}": value for k, value in enumerate(solved.a)}
    for j in range(len(system.contacts)):
        results |= {f"out_guard_{4 * j + place}": value for place, value in guards(solved, j, word).items()}
    first = 4 * len(system.contacts)
    results |= {f"out_guard_{first + k}": watched(solved, k) for k in range(len(system.resets))}
    angles = [pair for a in system.angles for pair in ((a.sin, sin(a.value)), (a.cos, cos(a.value)))]
    return system, [(str(name), value) for name, value in [*angles, *solved.tape.program(results)]]


def translated(value, scope: dict[str, Any]):
    """A SymPy expression as heyoka's, its symbols as `scope` has them; numbers stay numbers."""
    import heyoka

    if value.is_Number:
        return float(value)
    if value.is_Symbol:
        return scope[str(value)]
    parts = [translated(part, scope) for part in value.args]
    if value.is_Add:
        return heyoka.sum([heyoka.expression(part) if isinstance(part, float) else part for part in parts])
    if value.is_Mul:
        return math.prod(parts)
    if value.is_Pow:
        return _power(parts[0], value.exp)
    return getattr(heyoka, type(value).__name__)(parts[0])


def _power(base, exponent):
    """A small power by products, its inverse by division, half powers by a root."""
    import heyoka

    if exponent < 0:
        return 1.0 / _power(base, -exponent)
    if exponent.is_Integer:
        return math.prod([base] * int(exponent))
    return heyoka.sqrt(_power(base, 2 * exponent))
