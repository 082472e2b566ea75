"""A model's equations, guards and changes of mode, for solvers that know nothing of contacts."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from jointplay.display.errors import refuse
from jointplay.solver.codegen import cache
from jointplay.solver.equations.structure import Linkage, Oscillator
from jointplay.solver.mechanism.model import SPEED_FLOOR, Model
from jointplay.solver.motion.trajectory import Request, functions, memory

AWAY = 1e-7  # of a state's unit: difference over which a Jacobian that is not written out is taken

Event = tuple[int, int]  # number of the contact or reset, and kind by its place in analysis.quantities.EVENTS


def units(model: Model) -> np.ndarray:
    """Unit of each state: 1 rad or a length, the nominal speed; errors of small deflections as tolerated."""
    return model.absolute * np.maximum(1.0, model.relative / SPEED_FLOOR)


def starting_modes(model: Model) -> np.ndarray:
    """Contact modes of a model's start."""
    k, x, o = memory(model, Request(0.0))
    cache.method("flow").flow(functions(model.structure), k, x, o, None, None)
    return x.modes.copy()


@lru_cache(maxsize=16)
def compiled(structure: Linkage | Oscillator):
    """The callbacks of a structure, to be called without a search for the version that fits."""
    from jointplay.solver.method.interface import interpreted
    from jointplay.solver.method.numba_private import only_version
    from jointplay_lab.precision.callbacks import Callbacks, callbacks

    f, planned = functions(structure), cache.structure_module(structure).SIZES["planned"]
    made = callbacks(f, bool(planned))
    return made if interpreted() else Callbacks(*map(only_version, made))


def aligned(blocks: list[np.ndarray]) -> np.ndarray:
    """Arrays one after another, from where the lane rows of the first lie as the method has them."""
    from jointplay.solver.method.memory import lane_rows

    total = sum(map(len, blocks))
    joined = lane_rows(-(-total // 8))[:total]
    joined[:] = np.concatenate(blocks)
    return joined


class Equations:
    """A model in its present contact modes, one state at a time.

    Parameters
    ----------
    model : Model
        What moves.
    rtol : float
        Tolerance within which a sliding speed counts as zero where a contact begins.
    """

    def __init__(self, model: Model, rtol: float):
        self.model, self.module = model, cache.structure_module(model.structure)
        if self.module.SIZES["rubs"]:
            text = "a mechanism without it is accepted: other solvers know no such impacts here"
            raise refuse("friction at rigid impacts", text, "mechanism")
        k, x, o = memory(model, Request(0.0, rtol))
        self.modes, self.flags, self.fired = x.modes, x.flags, x.fired
        self.rest, self._out = o.rest, k.contact
        blocks = [k.w, x.s, x.p, x.m]
        ends = np.cumsum([len(block) for block in blocks])
        self.place, self.b = np.array([0, o.n_q, o.n, o.first, o.guards, *ends]), aligned(blocks)
        self._s, self._p, self._m = np.split(self.b, ends[:-1])[1:]
        self._scratch = AWAY * model.absolute if self.module.SIZES["planned"] else k.J
        self._call = compiled(model.structure)
        self._entered: dict[tuple[int, ...], tuple] = {}
        self.start, self._first = model.state.copy(), starting_modes(model)
        self.begin()

    def begin(self) -> None:
        """Take the modes of the start."""
        self._enter(self._first)

    def _enter(self, modes: np.ndarray) -> None:
        """Take contact modes."""
        key = tuple(modes.tolist())
        if key not in self._entered:
            self._entered[key] = self._watching(modes)
        self.modes[:] = modes
        self.key = key
        self._m[:], self.place[0], self.watch, self.guards = self._entered[key]

    def _watching(self, modes: np.ndarray) -> tuple[np.ndarray, int, np.ndarray, int]:
        """Masks of modes, their variant, the watched guards (guard, side, guard, …) and their number."""
        from jointplay.solver.method.events import side_of
        from jointplay.solver.method.modes import mask, variant_of

        m = np.zeros_like(self._m)
        mask(modes, m)
        sides = [(g, int(side_of(g, modes, self.flags))) for g in range(len(self.fired))]
        watch = np.array([pair for pair in sides if pair[1]], dtype=np.int64).ravel()
        return m, int(variant_of(modes)), watch, len(watch) // 2

    def rate(self, t: float, y: np.ndarray, out: np.ndarray) -> None:
        """Write the rates of a state."""
        self._call.rates(self.place, self.b, t, y, out)

    def roots(self, t: float, y: np.ndarray, out: np.ndarray) -> None:
        """Write the guards, positive until an event."""
        self._call.watched(self.place, self.b, t, y, self.watch, out)

    def jacobian(self, t: float, y: np.ndarray, out: np.ndarray) -> None:
        """Write the derivatives of the rates, shape (states, states)."""
        self._call.derivatives(self.place, self.b, t, y, self._scratch, out)

    def after_event(self, t: float, y: np.ndarray, k: int) -> tuple[np.ndarray, Event]:
        """Change modes, or jump, where the k-th watched guard fell to zero; give back state and event."""
        guard = int(self.watch[2 * k])
        if guard >= 4 * len(self.flags):
            return self._jump(t, y, guard - 4 * len(self.flags))
        given = (guard, self.flags, self.modes, self.fired, self.rest, self._out)
        kind = self._call.changed(self.place, self.b, t, y, *given)
        self._enter(self.modes)
        return y.copy(), (guard // 4, int(kind))

    def _jump(self, t: float, y: np.ndarray, reset: int) -> tuple[np.ndarray, Event]:
        """The state after a reset, or after a wall lets go what has rested on it."""
        from jointplay.solver.method.modes import FREE, IMPACT, RESTING, SEPARATION

        at = len(self.flags) + reset
        if self.modes[at] == RESTING:
            self._enter(np.where(np.arange(len(self.modes)) == at, FREE, self.modes))
            return y.copy(), (reset, SEPARATION)
        self._s[0], self._s[1 : 1 + len(y)] = t, y
        self.module.trig(self._s, self._p)
        self.module.reset(reset, self._s, self._p)
        return self._s[1 : 1 + len(y)].copy(), (reset, IMPACT)
