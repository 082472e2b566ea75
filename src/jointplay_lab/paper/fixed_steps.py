"""Motion by fixed steps of the classical Runge-Kutta method, without events; and its longest stable step."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from jointplay.analysis.quantities import STATUS
from jointplay.display.errors import InputError, Problem
from jointplay.solver.codegen import cache
from jointplay.solver.mechanism.model import Model
from jointplay.solver.motion.trajectory import Pace, Request, follow, functions, in_pieces, memory

SAMPLES = 96  # of a nominal turn, at which the eigenvalues are looked at
LOOSE = 1e-4  # tolerance of the turn on which they are
DIFFERENCE = 1e-7  # of a state's scale
OK = STATUS.index("ok")
SHARE = 0.5  # of the longest stable step: the step if none is given


@dataclass(frozen=True)
class Bound:
    """The longest stable step (s), and the eigenvalue (1/s) that sets it, with its cause."""

    step: float
    eigenvalue: complex
    cause: str

    def __str__(self) -> str:
        value = self.eigenvalue
        if not value:
            return f"{self.step:.3g} s, with {self.cause},"
        shown = f"{value.real:.3g}" + (f" ± {abs(value.imag):.3g} i" if value.imag else "")
        return f"{self.step:.3g} s, where RK4 is stable with {self.cause} (eigenvalue {shown} 1/s)"


def step_bound(model: Model) -> Bound:
    """Find the longest step with which RK4 is stable.

    Looked at are the eigenvalues of the equations in free flight and in the contact modes that occur, along
    the first nominal turn.

    Raises
    ------
    InputError
        If a law of contact remembers how the contact began: fixed steps do not stop there.
    """
    if model.memories:
        expected = "contacts whose law remembers nothing of how they began are accepted"
        raise InputError([Problem("mechanism.joints", model.joints, expected)])
    at = np.linspace(0.0, model.period, SAMPLES + 1)
    rows = follow(model, Request(model.period, rtol=LOOSE, at=at)).samples
    n_x, found = len(model.state), [_turning(model, rows)]
    for row in rows:
        modes = row[1 + n_x : 1 + n_x + len(model.joints)]
        cases = [0 * modes] + [modes] * bool(np.any(modes))
        found += [_slowest(model, row[: 1 + n_x], case.astype(np.int64)) for case in cases]
    return min(found, key=lambda bound: bound.step)


def _turning(model: Model, rows: np.ndarray) -> Bound:
    """The step in which the fastest angle, or a forcing's phase, turns as far as the equations hold."""
    from jointplay.solver.method.control import TURN

    n_q = len(model.turning)
    speeds = np.abs(rows[:, 1 + n_q : 1 + 2 * n_q]) * model.turning
    fastest = max(speeds.max(initial=0.0), math.tau / model.period)
    return Bound(TURN / fastest, 0j, f"no angle turning by more than {TURN:g} rad")


def _slowest(model: Model, state: np.ndarray, modes: np.ndarray) -> Bound:
    """The bound of one state in given contact modes."""
    from jointplay.solver.method.runge_kutta import longest_steps

    n_q, n = len(model.turning), len(model.state) - len(model.turning)
    A = np.eye(n_q + n, k=n)
    A[n_q:] = _jacobian(model, state, modes)
    values, vectors = np.linalg.eig(A)
    steps = longest_steps(values)
    worst = int(np.argmin(steps))
    return Bound(float(steps[worst]), complex(values[worst]), _cause(model, vectors[n_q:, worst], modes))


def _jacobian(model: Model, state: np.ndarray, modes: np.ndarray) -> np.ndarray:
    """Derivatives of the accelerations by the state, by differences (a structure's own have two forms)."""
    from jointplay.solver.method.modes import mask, variant_of

    work, motion, options = memory(model, Request(0.0))
    motion.s[: len(state)], motion.modes[:] = state, modes
    module = cache.structure_module(model.structure)
    module.trig(motion.s, motion.p)
    mask(motion.modes, motion.m)
    lanes = work.w[8 * (options.first + 1) :].reshape(-1, 8)
    away = DIFFERENCE * (model.absolute + model.relative * np.abs(state[1:]))
    columns = []
    for r, size in enumerate(away):
        lanes[r, :2] = size, -size
        module.rate(variant_of(motion.modes), work.w, motion.s, motion.p, motion.m)
        found = lanes[options.n_q + options.n : options.n_q + 2 * options.n, :2]
        columns.append((found[:, 0] - found[:, 1]) / (2 * size))
        lanes[r, :2] = 0.0
    return np.stack(columns, axis=1)


def _cause(model: Model, speeds: np.ndarray, modes: np.ndarray) -> str:
    """Cause of a fast motion, by the link that moves most."""
    names = cache.structure_module(model.structure).STATE[1 + len(model.turning) :]
    driven = getattr(model.structure, "drive", None) == "motor"
    if driven and names[int(np.argmax(np.abs(speeds)))] == f"w_{model.crank}":
        return "the motor's slope"
    return "the contact's stiffness" if np.any(modes) else "the free motion"


def accepted_step(model: Model, step: float | None) -> float:
    """Return the step to take, s: the given one if RK4 is stable with it, a share of the longest if none is.

    Raises
    ------
    InputError
        If the step is too long; or if the speeds of the system jump.
    """
    if model.walls:
        expected = "a system whose speeds do not jump is accepted: fixed steps would pass over its impacts"
        raise InputError([Problem("mechanism", model.walls, expected)])
    bound = step_bound(model)
    if step is None:
        return SHARE * min(bound.step, model.period / SAMPLES)
    if step > bound.step:
        raise InputError([too_long("step", step, bound)])
    return step


def too_long(key: str, step: float, bound: Bound) -> Problem:
    """Problem of a step beyond the stability bound."""
    return Problem(key, step, f"at most {bound} is accepted")


@dataclass(frozen=True)
class March:
    """Integration by fixed steps that can be resumed: arrays of the method, and indices of the loads."""

    model: Model
    places: np.ndarray
    arrays: tuple

    @classmethod
    def of(cls, model: Model, loaded: tuple[str, ...] = ()) -> March:
        """Start a model; `loaded` names the parameters that are functions of time."""
        names = cache.structure_module(model.structure).PARAMETERS
        places = np.array([names.index(name) for name in loaded], dtype=np.int64)
        return cls(model, places, memory(model, Request(math.inf)))

    def __call__(self, start: np.ndarray, h: float, count: int, loads: np.ndarray | None = None):
        """Take `count` steps of length h, s, from a start (time, positions, speeds).

        The `loads`, shape (count + 1, loads), are the loaded parameters at the steps' ends, 0 if left out.
        Returned are time, state and contact modes at the start and after every step; NaN after divergence.
        """
        (f, run, pace), (work, motion, options) = self._loop, self.arrays
        loads = np.zeros((count + 1, len(self.places))) if loads is None else np.ascontiguousarray(loads)
        rows = np.empty((count + 1, len(start) + len(motion.modes)))
        motion.s[: len(start)] = start
        done = 0

        def call(until: int) -> int:
            nonlocal done
            before, done = done, until
            return run(f, work, motion, options, float(h), self.places, loads, rows, before, until)

        in_pieces(call, lambda: done, pace, OK, count)
        return rows

    @cached_property
    def _loop(self) -> tuple:
        """The structure's functions, the compiled loop and its pace."""
        return functions(self.model.structure), cache.method("runge_kutta").march, Pace()
