"""States and requests of a model in the form in which lanes follow it (codegen.lanes.equations)."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from jointplay.solver.codegen import cache, outputs
from jointplay.solver.equations.parameters import parameter_names
from jointplay.solver.mechanism.model import Model
from jointplay.solver.method.lanes import CLOCK, PHASE
from jointplay.solver.motion.trajectory import Request

LATE = 1e-6  # of a period that a run lasts beyond its last sample


@dataclass(frozen=True)
class Form:
    """Form of a structure, as lanes need it.

    Parameters
    ----------
    phases : tuple of str
        Angles that turn by themselves, before the positions.
    sizes : dict
        Of its module (codegen.module).
    memories : int
        How many speeds are what laws of contact remember.
    turns : tuple of float
        1 where a position is an angle.
    crank : int
        Place of the angle or phase that sections cut.
    """

    phases: tuple[str, ...]
    sizes: dict[str, int]
    memories: int
    turns: tuple[float, ...]
    crank: int

    @classmethod
    def of(cls, model: Model) -> Form:
        """The form of a model's structure."""
        module, own = cache.ensemble_module(model.structure), cache.structure_module(model.structure)
        turns = tuple(float(turn) for turn in model.turning[: own.SIZES["positions"]])
        phases, crank = tuple(module.PHASES), f"theta_{model.crank}"
        place = len(phases) + own.STATE.index(crank) - 1 if crank in own.STATE else 0
        return cls(phases, own.SIZES, model.memories, turns, place)

    @property
    def unused(self) -> int:
        """Positions on which nothing depends, whose speeds are states of first order."""
        return self.sizes["speeds"] - self.memories - self.sizes["positions"]

    @property
    def turning(self) -> tuple[float, ...]:
        """Kind of bound on the turn of each position in a step."""
        return (PHASE,) * len(self.phases) + self.turns + (0.0,) * self.unused

    def turned(self, model: Model) -> np.ndarray:
        """Phases at the start, then their rates."""
        now, later = self._phases(model)
        return np.concatenate([now, later - now])

    def _phases(self, model: Model) -> np.ndarray:
        """Phases at the times 0 and 1, shape (2, phases)."""
        if model.links:  # of a crank whose speed is imposed, and of loads
            numbers = dict(zip(parameter_names(model.structure), model.numbers, strict=True))
            names = [f"nu_{name.removeprefix('phase_')}" for name in self.phases]
            rates = [numbers.get(name, model.crank_speed) for name in names]
            first = [model.crank_angle if name == model.crank else 0.0 for name in self.phases]
            return first + np.outer([0.0, 1.0], rates)
        own = [name for name in self.phases if name != CLOCK]
        module = cache.structure_module(model.structure)
        given = dict(zip(module.STATE, [np.array([0.0, 1.0]), *model.state], strict=False))
        given |= dict(zip(module.PARAMETERS, model.numbers, strict=True))
        found = outputs.evaluate(module, own, given) if own else {}
        found[CLOCK] = np.array([0.0, math.tau / model.period])
        return np.array([np.broadcast_to(found[name], 2) for name in self.phases]).reshape(-1, 2).T

    def by_sections(self, model: Model, request: Request) -> Request:
        """The request, with samples at even times as section points of the first phase."""
        if len(request.at) < 2:
            return request
        rate = np.diff(self._phases(model)[:, 0])[0]
        first, far = rate * request.at[0], abs(rate) * (request.at[1] - request.at[0])
        end = request.at[-1] + LATE * model.period
        cut = {"at": request.at[:0], "level": first, "period": far, "direction": int(np.sign(rate))}
        return replace(request, duration=end, skip=0, stop_after=len(request.at), **cut)
