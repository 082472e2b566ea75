"""Passes of the paper's scheme: a rigid run under the modes' accelerations, then the modes under its loads.

Reference: Chunmei, Yang, Ling and Ling (2002), section 3, steps 1 to 4. The rigid pass is that of
`method.runge_kutta`, the modes' that of `method.modal_response`. Between them go functions of time on
one grid: the modes' rates (which turn the links' ends) and accelerations one way, their loads the other
(equations 9 and 12).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from jointplay.analysis.evaluate import Quantities
from jointplay.solver.codegen import cache, outputs
from jointplay.solver.mechanism.model import Model
from jointplay_lab.paper.fixed_steps import March


@dataclass(frozen=True)
class Modes:
    """The modes of all elastic links in one row.

    Parameters
    ----------
    names : tuple of str
        Link and number of each, as ``coupler_0``.
    omega, damping_ratio : ndarray, shape (modes,)
        Natural frequency, rad/s, and damping ratio.
    gauge : ndarray, shape (modes, links)
        Deflection of a link at its gauge by a unit of a mode.
    """

    names: tuple[str, ...]
    omega: np.ndarray
    damping_ratio: np.ndarray
    gauge: np.ndarray

    @classmethod
    def of(cls, model: Model) -> Modes:
        """Read them from the numbers of a relaxed model."""
        owners = [(beam.link, i) for beam in model.structure.beams for i in range(beam.modes)]
        numbers = dict(zip(cache.structure_module(model.structure).PARAMETERS, model.numbers, strict=True))
        k, c, gauge = (
            np.array([numbers[f"{word}_{link}_{i}"] for link, i in owners]) for word in ("k", "c", "gauge")
        )
        own = np.array([[link == other for other in model.links] for link, _ in owners])
        omega = np.sqrt(k)
        return cls(tuple(f"{link}_{i}" for link, i in owners), omega, c / (2.0 * omega), own * gauge[:, None])


@dataclass(frozen=True)
class State:
    """State at the start of a window: of the rigid mechanism, with the time; modal coordinates and rates."""

    rigid: np.ndarray
    eta: np.ndarray
    rate: np.ndarray


@dataclass(frozen=True)
class Pass:
    """One pass over a window, at its grid points.

    Parameters
    ----------
    rows : ndarray, shape (points, 1 + states + contacts)
        Of the rigid pass: time, state, contact modes.
    loads : ndarray, shape (points, 2 modes)
        Rates and accelerations of the modes that the pass was given.
    eta, rate, acceleration : ndarray, shape (points, modes)
        Response of the modes.
    deflection : ndarray, shape (points, links)
        m, at the links' gauges.
    """

    rows: np.ndarray
    loads: np.ndarray
    eta: np.ndarray
    rate: np.ndarray
    acceleration: np.ndarray
    deflection: np.ndarray

    @property
    def finite(self) -> bool:
        """Whether the pass stayed within measure."""
        return bool(np.all(np.isfinite(self.rows[-1])) and np.all(np.isfinite(self.eta[-1])))

    def thinned(self, every: int, first: bool) -> Pass:
        """Keep every so manieth grid point; the start of a window belongs to the one before, if any."""
        kept = slice(0 if first else every, None, every)
        return Pass(**{name: getattr(self, name)[kept].copy() for name in Pass.__annotations__})


@dataclass(frozen=True)
class Visit:
    """A pass with its window and number, its change from the one before, and whether it is the last."""

    window: int
    number: int
    done: Pass
    change: float
    last: bool


class Loaded(Quantities):
    """Quantities of a rigid pass's rows, with the loads that it had."""

    def __init__(self, model: Model, rows: np.ndarray, loads: dict[str, np.ndarray]):
        super().__init__(model, rows, model.state)
        self.loads = loads

    def given(self, rows: np.ndarray) -> dict[str, Any]:
        return super().given(rows) | self.loads

    def evaluated(self, names: list[str]) -> np.ndarray:
        """Outputs of the structure by their own names, shape (rows, names)."""
        found = outputs.evaluate(self.module, names, self.given(self.rows))
        return np.stack([np.broadcast_to(found[name], len(self.rows)) for name in names], -1)


class Scheme:
    """Passes over windows of a motion, for one relaxed model and one step h (s)."""

    def __init__(self, model: Model, h: float):
        from jointplay.solver.method.modal_response import recurrence

        self.model, self.h, self.modes = model, h, Modes.of(model)
        self.loaded = tuple(f"{word}_{name}" for word in ("rate", "acc") for name in self.modes.names)
        self.march = March.of(model, self.loaded)
        self.recurrence = recurrence(self.modes.omega, self.modes.damping_ratio, h)

    def start(self) -> State:
        """The start of the model, its links straight and at rest in their frames."""
        n = len(self.modes.names)
        return State(np.concatenate([[0.0], self.model.state]), np.zeros(n), np.zeros(n))

    def relax(self, state: State, count: int, windows: int, limit: int, tolerance: float) -> Iterator[Visit]:
        """All passes over windows of `count` steps; a window starts where the one before ended.

        A window takes passes until one changes by no more than `tolerance`, or `limit` of them; a change of a
        deflection is relative to the largest in the windows before and in this one's first pass. A pass that
        grows beyond measure ends everything.
        """
        largest = np.finfo(float).tiny
        for window in range(windows):
            loads, before, scale = np.zeros((count + 1, len(self.loaded))), None, largest
            for number in range(limit):
                done = self.once(state, loads)
                scale = scale if number else max(scale, np.abs(done.deflection).max())
                change = self._change(before, done, scale)
                last = change <= tolerance or number == limit - 1 or not done.finite
                yield Visit(window, number, done, change, last)
                if last:
                    break
                loads, before = np.concatenate([done.rate, done.acceleration], axis=1), done
            if not done.finite:
                return
            end = done.rows[-1, : 1 + len(self.model.state)]
            state = State(end, done.eta[-1], done.rate[-1])
            largest = max(largest, np.abs(done.deflection).max())

    def once(self, start: State, loads: np.ndarray) -> Pass:
        """One pass under given loads."""
        from jointplay.solver.method.modal_response import accelerations

        rows = self.march(start.rigid, self.h, len(loads) - 1, loads)
        force = np.full((len(rows), len(self.modes.names)), np.nan)
        if np.all(np.isfinite(rows[-1])):
            loaded = [f"modal_load:{name}" for name in self.modes.names]
            force = self.quantities(rows, loads).evaluated(loaded)
        eta, rate = np.empty_like(force), np.empty_like(force)
        eta[0], rate[0] = start.eta, start.rate
        cache.method("modal_response").respond(self.recurrence, force, eta, rate)
        found = accelerations(self.modes.omega, self.modes.damping_ratio, force, eta, rate)
        return Pass(rows, loads, eta, rate, found, eta @ self.modes.gauge)

    def quantities(self, rows: np.ndarray, loads: np.ndarray) -> Loaded:
        """Quantities of rows of a pass and their loads."""
        return Loaded(self.model, rows, dict(zip(self.loaded, loads.T, strict=True)))

    def _change(self, before: Pass | None, done: Pass, scale: float) -> float:
        """Largest change of a deflection, relative to `scale`, or of a speed, to the crank's nominal one."""
        if before is None:
            return math.inf
        bent = np.abs(done.deflection - before.deflection).max() / scale
        speeds = slice(1 + len(self.model.turning), 1 + len(self.model.state))
        turned = np.abs(done.rows[:, speeds] - before.rows[:, speeds]).max()
        change = float(np.maximum(bent, turned * self.model.period / math.tau))  # NaN if either is
        return math.inf if math.isnan(change) else change
