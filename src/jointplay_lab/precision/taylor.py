"""heyoka as a peer: Taylor series of the same equations, from the expressions that ours are compiled from.

An integrator for each set of modes, compiled when it is first met; numbers are written out, slip directions
are run-time parameters. Expressions tuned by hand for one mechanism took a tenth less time. Reference:
F. Biscani and D. Izzo, MNRAS 504 (2021) 2614-2628; events, MNRAS 513 (2022) 4833-4844.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterable
from functools import lru_cache
from typing import Any

import numpy as np

from jointplay.solver.equations.structure import Linkage, Oscillator
from jointplay.solver.method.modes import RELEASED, SLIDE, SLIP_NEGATIVE, SLIP_POSITIVE, STICK, variant_of
from jointplay_lab.precision.contenders import Peer, Trouble
from jointplay_lab.precision.generated_code import Equations

CHUNK = 20_000  # steps between two looks at the time
SIGNS = {SLIP_POSITIVE: 1.0, SLIP_NEGATIVE: -1.0}
COMPACT = 5  # speeds; where there are more, straight code would take minutes to compile


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
