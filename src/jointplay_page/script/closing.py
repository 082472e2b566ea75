"""Where a motion begins as lengths change: found again by the ideal mechanism's own equations.

A linkage begins as its ideal mechanism does, at the crank's angle. Angles and slides with their speeds are
outputs of that mechanism's equations, which close its loops (`equations.loops.loop`): the same program gives
them at other lengths. Over the turn it shows whether loops close: where they do not, there is the root of a
negative number. Assumption: ideal loops close by two links at a time; of others None. Units: rad, m, s.
"""

from __future__ import annotations

import math
from contextlib import suppress
from typing import Any

import numpy as np

from jointplay.analysis import rules
from jointplay.analysis.evaluate import Quantities
from jointplay.display.errors import InputError
from jointplay.solver.codegen import cache, outputs
from jointplay.solver.mechanism.model import Model
from jointplay.solver.mechanism.records import Mechanism, TestSystem

OUTPUTS = {"theta": "angle", "w": "angular_velocity", "slide": "slide_position", "vslide": "slide_velocity"}
TURN = 128  # angles of the crank in a turn
ROUNDED = 1e-12  # of the largest: outputs agree with the start to this, or to what is tolerated
Numbers = dict[tuple[str, int], float]


def closing(mechanism: Mechanism | TestSystem, initial: Any, model: Model) -> Closing | None:
    """Give the closing of a model at its start; None where the ideal mechanism's equations do not give it."""
    with suppress(InputError):  # its loops do not close by themselves, or not from there
        found = Closing(model, ideal(mechanism, initial)) if isinstance(mechanism, Mechanism) else None
        closes = found and not found.ideal.structure.guessed and found.followed({}, model, found.ideal)
        return found if closes else None
    return None


def ideal(mechanism: Mechanism, initial: Any) -> Model:
    """Assemble a mechanism without clearance, at its start."""
    return rules.model_for(mechanism.replace(clearance=0.0), initial)


class Closing:
    """A model and its ideal mechanism's; `keys` are outputs of the latter by places of the former's start.

    They are the first of `outputs`, of which all have to be numbers.
    """

    def __init__(self, model: Model, ideal: Model) -> None:
        self.ideal, states = ideal, cache.structure_module(model.structure).STATE
        module, own = cache.structure_module(ideal.structure), f"theta_{ideal.crank}"
        pairs = ((at, *name.partition("_")[::2]) for at, name in enumerate(states))
        named = {at: f"{OUTPUTS.get(word)}:{part}" for at, word, part in pairs}
        self.keys = {at: key for at, key in named.items() if key in module.OUTPUTS}
        moving = (key for key in module.OUTPUTS if key.partition(":")[0] in OUTPUTS.values())
        self.outputs = tuple(dict.fromkeys([*self.keys.values(), *moving]))
        turns = own in module.STATE  # else the crank's angle is led by the time
        self.step = math.tau / TURN if turns else ideal.period / TURN
        self.swept, self.turn = module.STATE.index(own) if turns else 0, TURN
        if self.begun(ideal) is None:
            self.turn = 1  # no full turn: other lengths have to close at the start
        self.first = model.state[[at - 1 for at in self.keys]]

    def begun(self, ideal: Model) -> np.ndarray | None:
        """Outputs at the start, where all are numbers at every angle of the crank; else None."""
        rows = np.tile(np.append(0.0, ideal.state), (self.turn, 1))
        rows[:, self.swept] += self.step * np.arange(self.turn)
        module, given = cache.structure_module(ideal.structure), Quantities(ideal, rows, rows[0]).given(rows)
        with np.errstate(all="ignore"):
            found = outputs.evaluate(module, self.outputs, given)
        series = np.stack([np.broadcast_to(each, self.turn) for each in found.values()], -1)
        return series[0, : len(self.keys)] if np.all(np.isfinite(series)) else None

    def followed(self, numbers: Numbers, model: Model, ideal: Model) -> Numbers | None:
        """A model's numbers, the ideal mechanism's in place of what follows; None where it does not close."""
        if ideal.structure != self.ideal.structure or (found := self.begun(ideal)) is None:
            return None
        at, angles = [*self.keys], [key.startswith("angle:") for key in self.keys.values()]
        off = model.state[[k - 1 for k in at]] - found
        off -= math.tau * np.round(off / math.tau) * angles
        allowed = [numbers.get(("absolute", k - 1), 0.0) for k in at]
        if np.any(np.abs(off) > np.maximum(allowed, ROUNDED * np.abs(found).max())):
            return None
        own = {"ideal_s": np.append(0.0, ideal.state), "ideal_p": ideal.numbers}
        kept = {place: v for place, v in numbers.items() if place[0] != "s" or place[1] not in self.keys}
        return kept | {(name, i): float(v) for name, row in own.items() for i, v in enumerate(row)}

    @property
    def data(self) -> dict[str, Any]:
        """What the driver needs, fit for JSON; angles are given but for whole turns."""
        turns = np.round((self.first - self.begun(self.ideal)) / math.tau)
        places = [[at, math.tau * n] for at, n in zip(self.keys, turns, strict=True)]
        start = {"ideal_s": [0.0, *self.ideal.state.tolist()], "ideal_p": self.ideal.numbers.tolist()}
        start["outputs"] = len(self.outputs)
        return start | {"swept": self.swept, "step": self.step, "turn": self.turn, "places": places}
