"""A model's equations, guards and changes of mode, for solvers that know nothing of contacts.

Such a solver calls them for one state at a time. The structure's own compiled functions do the work, on eight
lanes of which one is used: for a rigid four-bar 0.1 µs, twice what one state written out by hand takes. Going
in and out of Python costs any solver that calls back from there several times as much. What stands here is
compiled for each structure anew, around the addresses of its functions: some tenths of a second.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import numba
import numpy as np
from numba import float64, int64, types, void

from jointplay.display.errors import refuse
from jointplay.solver.codegen import cache
from jointplay.solver.equations.structure import Linkage, Oscillator
from jointplay.solver.mechanism.model import SPEED_FLOOR, Model
from jointplay.solver.method.compiler import POLICY, ready, signed
from jointplay.solver.method.events import side_of
from jointplay.solver.method.interface import SIGNATURES, Functions, interpreted
from jointplay.solver.method.memory import lane_rows
from jointplay.solver.method.modes import FREE, IMPACT, RESTING, SEPARATION, mask, variant_of
from jointplay.solver.method.modes import follow as marked
from jointplay.solver.method.numba_private import only_version
from jointplay.solver.motion.trajectory import Request, functions, memory

AWAY = 1e-7  # of a state's unit: difference over which a Jacobian that is not written out is taken
Event = tuple[int, int]  # number of the contact or reset, and kind by its place in analysis.quantities.EVENTS
VARIANT, N_Q, N, FIRST, GUARDS, S, P, M, END = range(9)  # places in `place`; S, P, M, END are places in `b`
USED = 7  # of the lanes
vector, whole, matrix = float64[::1], int64[::1], float64[:, ::1]


def units(model: Model) -> np.ndarray:
    """Unit of each state: 1 rad or a length, the nominal speed; errors of small deflections as tolerated."""
    return model.absolute * np.maximum(1.0, model.relative / SPEED_FLOOR)


def starting_modes(model: Model) -> np.ndarray:
    """Contact modes of a model's start."""
    work, motion, options = memory(model, Request(0.0))
    cache.method("flow").flow(functions(model.structure), work, motion, options, None, None)
    return motion.modes.copy()


@lru_cache(maxsize=16)
def compiled(structure: Linkage | Oscillator):
    """The callbacks of a structure, to be called without a search for the version that fits."""
    own, planned = functions(structure), cache.structure_module(structure).SIZES["planned"]
    made = callbacks(own, bool(planned))
    return made if interpreted() else Callbacks(*map(only_version, made))


def aligned(blocks: list[np.ndarray]) -> np.ndarray:
    """Arrays one after another, from where the lane rows of the first lie as the method has them."""
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
        work, motion, options = memory(model, Request(0.0, rtol))
        self.modes, self.flags, self.fired = motion.modes, motion.flags, motion.fired
        self.speed_tolerance, self._out = options.speed_tolerance, work.contact
        blocks = [work.w, motion.s, motion.p, motion.m]
        ends = np.cumsum([len(block) for block in blocks])
        rows = options.first, options.guards
        self.place, self.b = np.array([0, options.n_q, options.n, *rows, *ends]), aligned(blocks)
        self._s, self._p, self._m = np.split(self.b, ends[:-1])[1:]
        self._scratch = AWAY * model.absolute if self.module.SIZES["planned"] else work.J
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
        given = (guard, self.flags, self.modes, self.fired, self.speed_tolerance, self._out)
        kind = self._call.changed(self.place, self.b, t, y, *given)
        self._enter(self.modes)
        return y.copy(), (guard // 4, int(kind))

    def _jump(self, t: float, y: np.ndarray, reset: int) -> tuple[np.ndarray, Event]:
        """The state after a reset, or after a wall lets go a body that rested on it."""
        at = len(self.flags) + reset
        if self.modes[at] == RESTING:
            self._enter(np.where(np.arange(len(self.modes)) == at, FREE, self.modes))
            return y.copy(), (reset, SEPARATION)
        self._s[0], self._s[1 : 1 + len(y)] = t, y
        self.module.trig(self._s, self._p)
        self.module.reset(reset, self._s, self._p)
        return self._s[1 : 1 + len(y)].copy(), (reset, IMPACT)


class Callbacks(NamedTuple):
    """Functions of (place, b, t, y, …, out); their compilers document the results."""

    rates: Callable
    watched: Callable
    derivatives: Callable
    changed: Callable


class _Pointer(types.WrapperAddressProtocol):
    """A function of a structure, by its address, as numba takes it."""

    def __init__(self, function, signature):
        self._function, self._signature = function, signature

    def __wrapper_address__(self) -> int:
        return self._function.address

    def signature(self):
        return self._signature


def callbacks(functions: Functions, planned: bool) -> Callbacks:
    """Compile the callbacks of a structure, from its functions."""
    if not interpreted():
        called = ("trig", "rate", "jacobian", "contacts")
        own = {name: _Pointer(getattr(functions, name), signed(SIGNATURES[name])) for name in called}
        functions = functions._replace(**own)
    placed = _placing(functions.trig)
    evaluate = _evaluation(functions.rate, placed)
    derivatives = _by_differences(evaluate) if planned else _written_out(functions.jacobian, placed)
    return Callbacks(_rates(evaluate), _watched(evaluate), derivatives, _changed(functions.contacts, placed))


def _compiled(*arguments, gives=void):
    """Compile without a cache: an address is good for one process."""
    return numba.njit(gives(whole, vector, float64, vector, *arguments), **POLICY)


def _placing(trig):
    """Move the base point to (t, y); give back it, the parameters and the masks."""

    @numba.njit(**POLICY)
    def placed(place, b, t, y):
        s, p, m = b[place[S] : place[P]], b[place[P] : place[M]], b[place[M] : place[END]]
        s[0] = t
        for r in range(place[N_Q] + place[N]):
            s[1 + r] = y[r]
        trig(s, p)
        return s, p, m

    return placed


def _evaluation(rate, placed):
    """Evaluate at (t, y), from lanes without increments."""

    @numba.njit(**POLICY)
    def evaluate(place, b, t, y):
        s, p, m = placed(place, b, t, y)
        rate(place[VARIANT], b[: place[S]], s, p, m)

    return evaluate


def _rates(evaluate):
    """Write y' to `out`."""

    @_compiled(vector)
    def rates(place, b, t, y, out):
        n_q, n = place[N_Q], place[N]
        evaluate(place, b, t, y)
        row = place[FIRST] + 1 + n_q + n
        for i in range(n_q):
            out[i] = y[n_q + i]
        for k in range(n):
            out[n_q + k] = b[8 * (row + k) + USED]

    return rates


def _watched(evaluate):
    """Write the guards that `watch` names (number, side, number, …) to `out`, positive on their side."""

    @_compiled(whole, vector)
    def watched(place, b, t, y, watch, out):
        evaluate(place, b, t, y)
        for k in range(len(watch) // 2):
            out[k] = watch[2 * k + 1] * b[8 * (place[GUARDS] + watch[2 * k]) + USED]

    return watched


def _written_out(jacobian, placed):
    """Write dy'/dy to `out`, from the structure's Jacobian, of which `scratch` holds the rows."""

    @_compiled(vector, matrix)
    def written_out(place, b, t, y, scratch, out):
        n_q, n_x = place[N_Q], place[N_Q] + place[N]
        s, p, m = placed(place, b, t, y)
        jacobian(place[VARIANT], s, p, m, scratch)
        for i in range(n_x):
            for k in range(n_x):
                out[i, k] = scratch[(i - n_q) * n_x + k] if i >= n_q else (1.0 if k == n_q + i else 0.0)

    return written_out


def _by_differences(evaluate):
    """Write dy'/dy to `out`, by central differences over `scratch`: for structures of many unknowns."""

    @_compiled(vector, matrix)
    def by_differences(place, b, t, y, scratch, out):
        n_q, n, n_x = place[N_Q], place[N], place[N_Q] + place[N]
        for k in range(n_x):
            at = 8 * (place[FIRST] + 1 + k)
            b[at], b[at + 1] = scratch[k], -scratch[k]
            evaluate(place, b, t, y)
            b[at], b[at + 1] = 0.0, 0.0
            for i in range(n_q):
                out[i, k] = 1.0 if k == n_q + i else 0.0
            for i in range(n):
                row = 8 * (place[FIRST] + 1 + n_x + i)
                out[n_q + i, k] = (b[row] - b[row + 1]) / (2 * scratch[k])

    return by_differences


def _changed(contacts, placed):
    """Change modes where a guard has fallen to zero; give back the kind of event."""

    follow = ready(marked)

    @_compiled(int64, whole, whole, whole, float64, vector, gives=int64)
    def changed(place, b, t, y, guard, flags, modes, fired, rest, out):
        s, p, m = placed(place, b, t, y)
        return follow(contacts, guard // 4, guard % 4, flags, modes, fired, m, s, p, rest, out)

    return changed
