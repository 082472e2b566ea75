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
def _rates(functions, work, motion, options):
    """Accelerations at the stage in work.w, in modes that it decides itself, guessed from the present ones.

    In free flight there is no v_t: a second look gives it.
    """
    for _ in range(LOOKS):
        functions.rate(variant_of(motion.modes), work.w, motion.s, motion.p, motion.m)
        motion.count[EVALUATIONS] += 1
        if not _decide(work.w, options.guards, motion.flags, motion.modes, motion.m):
            break


@inlined
def _stage(work, motion, options, share, reach):
    """Add `share` of the rates to the step's sum; go to `reach` of them from its start."""
    n_q, n_x, state, w = options.n_q, options.n_q + options.n, 8 * (options.first + 1) + 7, work.w
    for r in range(n_x):
        slope = (
            motion.s[1 + n_q + r] + w[state + 8 * (n_q + r)] if r < n_q else w[state + 8 * (options.n + r)]
        )
        work.whole[r] += share * slope
        w[state + 8 * r] = reach * slope


@compiled
def _load(p, places, a, b, part):
    """Set the loads at a place between two steps' ends."""
    for i in range(len(places)):
        p[places[i]] = a[i] + part * (b[i] - a[i])


@inlined
def _step(functions, work, motion, options, h, places, a, b):
    """One step of length h, of which the first rates are in work.w; loads go from `a` to `b`."""
    n_x, time = options.n_q + options.n, 8 * options.first + 7
    for r in range(n_x):
        work.whole[r] = 0.0
    _stage(work, motion, options, h / 6.0, 0.5 * h)
    work.w[time] = 0.5 * h
    _load(motion.p, places, a, b, 0.5)
    _rates(functions, work, motion, options)
    _stage(work, motion, options, h / 3.0, 0.5 * h)
    _rates(functions, work, motion, options)
    _stage(work, motion, options, h / 3.0, h)
    work.w[time] = h
    _load(motion.p, places, a, b, 1.0)
    _rates(functions, work, motion, options)
    _stage(work, motion, options, h / 6.0, 0.0)
    work.w[time] = 0.0
    for r in range(n_x):
        motion.s[1 + r] += work.whole[r]
    motion.count[STEPS] += 1


@inlined
def _arrive(functions, work, motion, options, row):
    """Rates at the base point; write it down: time, state, contact modes."""
    functions.trig(motion.s, motion.p)
    _rates(functions, work, motion, options)
    n_x = options.n_q + options.n
    for r in range(1 + n_x):
        row[r] = motion.s[r]
    for j in range(len(motion.modes)):
        row[1 + n_x + j] = motion.modes[j]


@inner
def march(functions, work, motion, options, h, places, loads, rows, done, count):
    """Take steps of length h from the base point, and write down the state at the start and after each.

    Row i of `loads` holds the parameters at `places` after i steps. Of the len(rows) - 1 steps, those from
    `done`, the number that has been taken, up to `count` are taken now. Gives back OK, or DIVERGED, where the
    rows that were not reached are NaN. Call again to go on from there.
    """
    n_x = options.n_q + options.n
    if done == 0:
        for r in range(8 * (1 + n_x)):
            work.w[8 * options.first + r] = 0.0
        _load(motion.p, places, loads[0], loads[0], 0.0)
        _arrive(functions, work, motion, options, rows[0])
    start = rows[0, 0]
    for i in range(done + 1, count + 1):
        _step(functions, work, motion, options, h, places, loads[i - 1], loads[i])
        motion.s[0] = start + i * h
        _arrive(functions, work, motion, options, rows[i])
        for r in range(n_x):
            if not abs(motion.s[1 + r]) < HUGE:
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
