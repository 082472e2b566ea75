"""Generated equations as a general solver calls them: one state at a time.

The structure's own compiled functions do the work, on eight lanes of which one is used: for a rigid four-bar
0.1 µs, twice what one state written out by hand takes. Going in and out of Python costs any solver that calls
back from there several times as much. What stands here is compiled for each structure anew, around the
addresses of its functions: some tenths of a second.
"""

from collections.abc import Callable
from typing import NamedTuple

import numba
from numba import float64, int64, types, void

from jointplay.solver.method.compiler import POLICY, ready, signed
from jointplay.solver.method.interface import SIGNATURES, Functions, interpreted
from jointplay.solver.method.modes import follow as marked

VARIANT, N_Q, N, FIRST, GUARDS, S, P, M, END = range(9)  # places in `place`; S, P, M, END are places in `b`
USED = 7  # of the lanes
vector, whole, matrix = float64[::1], int64[::1], float64[:, ::1]


class Callbacks(NamedTuple):
    """Functions of (place, b, t, y, …, out); those that compile them document what they write."""

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


def callbacks(f: Functions, planned: bool) -> Callbacks:
    """Compile the callbacks of a structure, from its functions."""
    if not interpreted():
        called = ("trig", "rate", "jacobian", "contacts")
        f = f._replace(**{name: _Pointer(getattr(f, name), signed(SIGNATURES[name])) for name in called})
    placed = _placing(f.trig)
    evaluate = _evaluation(f.rate, placed)
    derivatives = _by_differences(evaluate) if planned else _written_out(f.jacobian, placed)
    return Callbacks(_rates(evaluate), _watched(evaluate), derivatives, _changed(f.contacts, placed))


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
