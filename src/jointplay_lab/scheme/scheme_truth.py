"""The monolithic solution over a turn, and errors of the paper's scheme against it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from jointplay.analysis.evaluate import Quantities
from jointplay.solver.codegen import cache
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.model import Model
from jointplay.solver.mechanism.records import Mechanism
from jointplay.solver.motion.trajectory import MAX_STEPS, Records, Request, follow
from jointplay_lab.scheme.scheme import Pass, Scheme, State
from jointplay_lab.scheme.waveform import Grid

COMPARED = ("deflection", "angle", "reaction")
MEASURES = (*COMPARED[:2], "force")


@dataclass(frozen=True)
class Case:
    """One turn of a mechanism with the paper's inertia terms, from a state of its own motion.

    Parameters
    ----------
    clearance : float
        Of joint B, m.
    turn : int
        Nominal turns after which the compared one starts.
    monolithic, consistent, relaxed : Model
        All unknowns at once with the paper's terms, and with all terms; the rigid mechanism of the scheme.
    """

    clearance: float
    turn: int
    monolithic: Model
    consistent: Model
    relaxed: Model

    @classmethod
    def of(cls, mechanism: Mechanism, clearance: float, turn: int, rtol: float, initial: Any) -> Case:
        """Follow a mechanism to the start of the turn."""
        paper = mechanism.replace(clearance=clearance, order="paper")
        model = assemble(paper, initial)
        if turn:
            end = turn * model.period
            row = follow(model, Request(end, rtol=rtol, at=np.array([end]))).samples[-1]
            model = replace(model, state=row[1 : 1 + len(model.state)].copy())
        consistent = replace(assemble(paper.replace(order="consistent"), initial), state=model.state)
        return cls(clearance, turn, model, consistent, assemble(paper, initial, relaxed=True))

    @property
    def label(self) -> str:
        """The case in words."""
        play = f"clearance {self.clearance:g} m" if self.clearance else "ideal joints"
        return f"{play}, turn {self.turn + 1}"

    def start(self, scheme: Scheme) -> State:
        """The start of the turn, as the scheme takes it."""
        names = cache.structure_module(self.monolithic.structure).STATE
        values = dict(zip(names, [0.0, *self.monolithic.state], strict=True))
        rigid = [values[name] for name in cache.structure_module(self.relaxed.structure).STATE]
        bent = ([values[f"{word}_{name}"] for name in scheme.modes.names] for word in ("eta", "deta"))
        return State(np.array(rigid), *map(np.array, bent))

    def follow(self, times: np.ndarray, rtol: float, max_steps: int | None = None) -> Records:
        """The monolithic motion at some times of the turn, s."""
        request = Request(float(times[-1]), rtol=rtol, at=times, max_steps=max_steps or MAX_STEPS)
        return follow(self.monolithic, request)


@dataclass(frozen=True)
class Truth:
    """Quantities by name, over times and parts, with the scale by which an error of each counts."""

    values: Mapping[str, np.ndarray]
    scales: Mapping[str, float]

    @classmethod
    def of(cls, model: Model, rows: np.ndarray) -> Truth:
        """Of the rows of a monolithic run."""
        values = described(Quantities(model, rows, rows[0]))
        force = float(np.sqrt(np.mean(values["reaction"] ** 2)))
        scales = {"deflection": float(np.abs(values["deflection"]).max()), "angle": 1.0, "reaction": force}
        return cls(values, scales)

    def deflection_error(self, found: np.ndarray) -> float:
        """Largest error of a deflection, relative to the largest deflection."""
        return float(np.abs(found - self.values["deflection"]).max() / self.scales["deflection"])

    def errors(self, found: Mapping[str, np.ndarray], where: slice = slice(None)) -> np.ndarray:
        """Largest relative error of a deflection, largest of an angle (rad), mean square of a force."""
        error = {name: (found[name] - self.values[name][where]) / self.scales[name] for name in COMPARED}
        largest = [np.abs(error[name]).max(initial=0.0) for name in COMPARED[:2]]
        return np.array([*largest, np.mean(error["reaction"] ** 2)])


def described(quantities: Quantities, **own: np.ndarray) -> dict[str, np.ndarray]:
    """The compared quantities of some rows; those that are no quantity of theirs are given."""
    names = [name for name in COMPARED if name not in own]
    return {name: each[1] for name, each in quantities.variables(names, "time").items()} | own


def of_pass(scheme: Scheme, done: Pass) -> dict[str, np.ndarray]:
    """The compared quantities of a pass."""
    return described(scheme.quantities(done.rows, done.loads), deflection=done.deflection)


def sample_times(model: Model, grid: Grid, windows: int) -> np.ndarray:
    """Times of the samples of a turn, s."""
    return np.linspace(0.0, model.period, windows * grid.kept + 1)
