"""Classical fourth-order Runge-Kutta with steps of one length and no location of events.

The rigid half of the paper's own scheme (Chunmei, Yang, Ling and Ling, 2002, section 3, step 1): at each of
the four stages a contact is on where u >= 0 (equation 15) and friction has the sign of v_t (17); a law that
does not pull is on only while it pushes. Of order 4 as long as nothing switches; a step over a switch costs
an error of the size of the jump times the step. Stable only while every h lambda lies in |R| <= 1,
R(z) = 1 + z + z^2/2 + z^3/6 + z^4/24.

Some parameters may be functions of time (loads): given at the steps' ends, linear between them.
"""

import math

import numpy as np

from .control import DIVERGED, HUGE, OK
from .interface import (
    FUNCTIONS,
    INT,
    OPTIONS,
    REAL,
    TRAJECTORY,
    WORK,
    Array,
    Signature,
    compiled,
    inlined,
    inner,
)
from .memory import EVALUATIONS, STEPS
from .modes import (
    CONTACT,
    FORCE,
    FREE,
    GAP,
    PULLS,
    RELEASED,
    SLIDE,
    SLIP_NEGATIVE,
    SLIP_POSITIVE,
    STICKS,
    mask,
    variant_of,
)

LOOKS = 3  # at a stage: at most free flight, a contact with the wrong slip, the right one


@compiled
def _decide(w, guards, flags, modes, m):
    """Mode of every contact from the guards at the stage; whether one changed."""
    changed = False
    for j in range(len(modes)):
        at = 8 * (guards + 4 * j) + 7
        mode = FREE
        if w[at + 8 * GAP] >= 0.0:
            mode = CONTACT if flags[j] & PULLS or w[at + 8 * FORCE] > 0.0 else RELEASED
        if mode == CONTACT and flags[j] & STICKS and w[at + 8 * SLIDE] != 0.0:
            mode = SLIP_POSITIVE if w[at + 8 * SLIDE] > 0.0 else SLIP_NEGATIVE
        changed = changed or mode != modes[j]
        modes[j] = mode
    mask(modes, m)
    return changed


@inlined
def _rates(f, k, x, o):
    """Accelerations at the stage in k.w, in the modes that it decides itself, guessed from the present ones.

    In free flight there is no v_t: a second look gives it.
    """
    for _ in range(LOOKS):
        f.rate(variant_of(x.modes), k.w, x.s, x.p, x.m)
        x.count[EVALUATIONS] += 1
        if not _decide(k.w, o.guards, x.flags, x.modes, x.m):
            break


@inlined
def _stage(k, x, o, share, reach):
    """Add `share` of the rates to the step's sum; go to `reach` of them from its start."""
    n_q, n_x, state, w = o.n_q, o.n_q + o.n, 8 * (o.first + 1) + 7, k.w
    for r in range(n_x):
        slope = x.s[1 + n_q + r] + w[state + 8 * (n_q + r)] if r < n_q else w[state + 8 * (o.n + r)]
        k.whole[r] += share * slope
        w[state + 8 * r] = reach * slope


@compiled
def _load(p, places, a, b, part):
    """Set the loads at a place between two steps' ends."""
    for i in range(len(places)):
        p[places[i]] = a[i] + part * (b[i] - a[i])


@inlined
def _step(f, k, x, o, h, places, a, b):
    """One step of length h, of which the first rates are in k.w; loads go from `a` to `b`."""
    n_x, time = o.n_q + o.n, 8 * o.first + 7
    for r in range(n_x):
        k.whole[r] = 0.0
    _stage(k, x, o, h / 6.0, 0.5 * h)
    k.w[time] = 0.5 * h
    _load(x.p, places, a, b, 0.5)
    _rates(f, k, x, o)
    _stage(k, x, o, h / 3.0, 0.5 * h)
    _rates(f, k, x, o)
    _stage(k, x, o, h / 3.0, h)
    k.w[time] = h
    _load(x.p, places, a, b, 1.0)
    _rates(f, k, x, o)
    _stage(k, x, o, h / 6.0, 0.0)
    k.w[time] = 0.0
    for r in range(n_x):
        x.s[1 + r] += k.whole[r]
    x.count[STEPS] += 1


@inlined
def _arrive(f, k, x, o, row):
    """Rates at the base point; write it down: time, state, contact modes."""
    f.trig(x.s, x.p)
    _rates(f, k, x, o)
    n_x = o.n_q + o.n
    for r in range(1 + n_x):
        row[r] = x.s[r]
    for j in range(len(x.modes)):
        row[1 + n_x + j] = x.modes[j]


@inner
def march(f, k, x, o, h, places, loads, rows, done, count):
    """Take steps of length h from x.s, and write down the state at the start and after each.

    Row i of `loads` holds the parameters at `places` after i steps. Of the len(rows) - 1 steps, those from
    `done`, the number that has been taken, up to `count` are taken now. Gives back OK, or DIVERGED, where the
    rows that were not reached are NaN. Call again to go on from there.
    """
    n_x = o.n_q + o.n
    if done == 0:
        for r in range(8 * (1 + n_x)):
            k.w[8 * o.first + r] = 0.0
        _load(x.p, places, loads[0], loads[0], 0.0)
        _arrive(f, k, x, o, rows[0])
    start = rows[0, 0]
    for i in range(done + 1, count + 1):
        _step(f, k, x, o, h, places, loads[i - 1], loads[i])
        x.s[0] = start + i * h
        _arrive(f, k, x, o, rows[i])
        for r in range(n_x):
            if not abs(x.s[1 + r]) < HUGE:
                rows[i + 1 :] = np.nan
                return DIVERGED
    return OK


def longest_steps(eigenvalues: np.ndarray) -> np.ndarray:
    """Longest step h for which |R(h lambda)| <= 1 on the way from 0, for each eigenvalue (1/s); inf for 0.

    What grows by itself grows in any method: a positive real part is left out.
    """
    steps = np.full(len(eigenvalues), np.inf)
    for i, value in enumerate(eigenvalues):
        if value != 0.0:
            direction = complex(min(value.real, 0.0), value.imag) / abs(value)
            steps[i] = _reach(direction) / abs(value) if direction != 0.0 else np.inf
    return steps


def _reach(direction: complex) -> float:
    """Distance from 0 to the edge of the stability region along a direction of the left half-plane."""
    R = np.polynomial.Polynomial([direction**k / math.factorial(k) for k in range(5)])
    rest = (np.polynomial.Polynomial(R.coef) * np.polynomial.Polynomial(R.coef.conj())).coef.real[1:]
    roots = np.polynomial.Polynomial(rest).roots()  # of (|R|^2 - 1)/distance; those near 0 are rounding
    return float(min(root.real for root in roots if abs(root.imag) < 1e-9 and root.real > 1.0))


_TABLE = Array(axes=2)
_TAKES = FUNCTIONS, WORK, TRAJECTORY, OPTIONS, REAL, Array(INT), _TABLE, _TABLE, INT, INT
UNIT = {"march": Signature(INT, _TAKES)}
