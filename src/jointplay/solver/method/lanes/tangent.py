"""A tangent with each trajectory of an ensemble: in its lane, through events, with its growth recorded.

Within a step as method.tangents.tangent has it, in lanes (codegen.lanes.tangent). A lane carries one tangent;
the rate F of the state itself, which the motion has anyway, takes the part of the frame's first. Events take
both through as those of one trajectory (method.tangents.saltation). What of the tangent lies along F is taken
away there, where a row is due, and before it hides the rest; between, the flow takes F to F.
"""

from typing import NamedTuple

import numpy as np

from ..interface import inlined, inner, trajectory_at
from ..modes import mask
from ..tangents.frame import orthonormalise
from ..tangents.saltation import stuck, through
from ..tangents.tangent import GRAZING, NEUTRAL, SALTATION, VOLUME
from ..tangents.tangent import tangents as of_one
from . import layout as rows
from .exchange import gather
from .radau import STAGES

MOST = 10  # updates of an iteration; nearly all take three to five
# Places in Tangents.real, of one trajectory each
Y_BEGIN, Y_BLOCK, Y_TOLERANCE, Y_LIMIT, REALS = range(5)
ROOM = 16  # rows that one pass may need


class Tangents(NamedTuple):
    """Tangents of the trajectories of layout.Jobs, their rows, and scratch of eight lanes."""

    frame: np.ndarray  # of each trajectory, at its start
    weight: np.ndarray  # 1 / scale of each state
    real: np.ndarray
    grazing: np.ndarray  # of each trajectory, as Tangents of method.tangents.tangent has it
    rows: np.ndarray  # time, trace, volume, 0; logarithms of |F| and of the growth; state; trajectory
    count: np.ndarray  # rows
    logs: np.ndarray  # of each lane: logarithm of the growth
    volume: np.ndarray  # ln |det S| of its jumps
    last: np.ndarray  # time of its last row
    stuck: np.ndarray  # contacts that stuck before an event
    gradient: np.ndarray  # of its guard: time, state


def tangents(frame: np.ndarray, scale: np.ndarray, real: np.ndarray, n_rows: int) -> Tangents:
    """Allocate for trajectories with these tangents, scales and numbers (`Y_BEGIN`, …), a row each."""
    n, n_x = frame.shape
    return Tangents(
        frame=np.ascontiguousarray(frame),
        weight=1.0 / np.ascontiguousarray(scale),
        real=real,
        grazing=np.full(n, np.inf),
        rows=np.zeros((n_rows + ROOM, 7 + n_x)),
        count=np.zeros(1, dtype=np.int64),
        logs=np.zeros(8),
        volume=np.zeros(8),
        last=np.zeros(8),
        stuck=np.zeros(8),
        gradient=np.zeros((8, 1 + n_x)),
    )


def frame(n_x: int):
    """Scratch: the frame of a motion's rate and one tangent, as one trajectory has it."""
    t = of_one(np.zeros((2, n_x)), np.ones(n_x), n_x // 2, 1, 1)
    t.count[SALTATION] = t.count[NEUTRAL] = 1
    return t


@inner
def take_up(e, j, y, i):
    """Begin the tangent of a trajectory that has just entered a lane."""
    w, job = e.w, e.whole[8 * rows.JOB + i]
    for r in range(e.n):
        w[8 * (rows.D_POSITION + r) + i], w[8 * (rows.D_SPEED + r) + i] = (
            y.frame[job, r],
            y.frame[job, e.n + r],
        )
        w[8 * (rows.WEIGHT_POSITION + r) + i] = y.weight[job, r]
        w[8 * (rows.WEIGHT + r) + i] = y.weight[job, e.n + r]
    w[8 * rows.D_TOLERANCE + i], w[8 * rows.D_LIMIT + i] = y.real[job, Y_TOLERANCE], y.real[job, Y_LIMIT]
    w[8 * rows.NEXT_ROW + i] = y.real[job, Y_BEGIN]
    w[8 * rows.DUE + i], w[8 * rows.NEW_SLOPES + i] = 2.0, 1.0
    y.logs[i] = y.volume[i] = 0.0
    y.last[i] = -1.0


@inlined
def carry(g, v, w):
    """Solve for the tangents of all steps that may be accepted, and judge them too."""
    v.start(w)
    if not _any(w, rows.ACTIVE):
        v.judge(w)
        return
    for s in range(STAGES):
        v.point(w, s)
        g.jacobian(w)
        v.keep(w, s)
    for _ in range(MOST):
        v.vary(w)
        v.improve(w)
        if not _any(w, rows.ACTIVE):
            break
    v.judge(w)


@inner
def _any(w, row):
    """Whether a row is above 0 in any lane."""
    most = 0.0
    for i in range(8):
        most = max(most, w[8 * row + i])
    return most > 0.0


@inlined
def base_slopes(g, v, w):
    """Slopes at the base points that are new; X and Y are at the base."""
    g.jacobian(w)
    v.base(w)


@inner
def before_event(f, v, e, j, y, i):
    """Note the values before an event that the jump of the tangent needs."""
    w, guard, x = e.w, e.whole[8 * rows.AT + i], trajectory_at(j.x, e.whole[8 * rows.JOB + i])
    gather(e, j, x, i)
    f.trig(x.s, x.p)
    for r in range(e.n if w[8 * rows.TAKEN + i] == 0.0 else 0):  # another event at the same place
        w[8 * (rows.RATE_BEFORE + r) + i] = w[8 * (rows.ACCELERATION + r) + i]
    mask(x.modes, x.m)
    v.gradient(guard, x.s, x.p, x.m, y.gradient[i])
    y.stuck[i] = stuck(x.modes)
    w[8 * rows.NEW_SLOPES + i] = 1.0


@inner
def _frame(e, y, t, i):
    """Write the rate and the tangent of a lane, as a frame of one trajectory."""
    w, n, job = e.w, e.n, e.whole[8 * rows.JOB + i]
    second = 2 + 2 * n
    for r in range(n):
        t.d[1 + r], t.d[1 + n + r] = w[8 * (rows.SPEED + r) + i], w[8 * (rows.ACCELERATION + r) + i]
        t.d[second + r] = w[8 * (rows.D_POSITION + r) + i]
        t.d[second + n + r] = w[8 * (rows.D_SPEED + r) + i]
    for r in range(2 * n):
        t.weight[r] = y.weight[job, r]
    for m in range(2):
        t.alive[m], t.logs[m] = 1, 0.0


@inner
def _orthonormal(e, y, t, i):
    """Write that frame made orthonormal; logarithms of its lengths are in `t.logs`."""
    _frame(e, y, t, i)
    orthonormalise(t.d, 1 + 2 * e.n, t.weight, t.alive, t.norms, t.logs, 0.0)


@inner
def _take(e, y, t, i):
    """Write the tangent of a frame back to the lane, and add up its growth."""
    w, n, second = e.w, e.n, 2 + 2 * e.n
    for r in range(n):
        w[8 * (rows.D_POSITION + r) + i] = t.d[second + r]
        w[8 * (rows.D_SPEED + r) + i] = t.d[second + n + r]
    w[8 * rows.FOLLOWS + i] = 0.0
    y.logs[i] += t.logs[1]


@inner
def jump(e, j, y, t, i):
    """Take the tangent of a lane through an event that has just been handled."""
    w, n, job = e.w, e.n, e.whole[8 * rows.JOB + i]
    _frame(e, y, t, i)
    for r in range(n):
        t.before[r] = t.after[r] = w[8 * (rows.SPEED + r) + i]
        t.before[n + r] = w[8 * (rows.RATE_BEFORE + r) + i]
        t.after[n + r] = w[8 * (rows.ACCELERATION + r) + i]
    for r in range(1 + 2 * n):
        t.gradient[r] = y.gradient[i, r]
    t.real[GRAZING], t.real[VOLUME] = y.grazing[job], y.volume[i]
    lossy = stuck(trajectory_at(j.x, job).modes) > y.stuck[i]
    if through(t, n, 2 * n, False, lossy):
        _take(e, y, t, i)
    y.grazing[job], y.volume[i] = t.real[GRAZING], t.real[VOLUME]


@inner
def renew(e, y, t, i):
    """Record a row if one is due; remove the part along the rate where it hides the rest."""
    w = e.w
    _orthonormal(e, y, t, i)
    if w[8 * rows.T + i] >= w[8 * rows.NEXT_ROW + i]:
        _note(e, y, t, i)
        while w[8 * rows.T + i] >= w[8 * rows.NEXT_ROW + i]:
            w[8 * rows.NEXT_ROW + i] += y.real[e.whole[8 * rows.JOB + i], Y_BLOCK]
    if w[8 * rows.DUE + i] > 1.0 and t.alive[1]:
        _take(e, y, t, i)
    w[8 * rows.DUE + i] = 0.0


@inner
def _note(e, y, t, i):
    """Add a row as of method.tangents.tangent, then the trajectory's number."""
    w, row = e.w, y.rows[y.count[0]]
    row[0], row[1], row[2], row[3] = w[8 * rows.T + i], w[8 * rows.TRACE + i], y.volume[i], 0.0
    row[4], row[5] = t.logs[0], y.logs[i] + t.logs[1]
    for r in range(e.n):
        row[6 + r], row[6 + e.n + r] = w[8 * (rows.POSITION + r) + i], w[8 * (rows.SPEED + r) + i]
    row[6 + 2 * e.n] = e.whole[8 * rows.JOB + i]
    y.last[i] = w[8 * rows.T + i]
    y.count[0] += 1


@inner
def lay_down(e, y, t, i):
    """Record where a trajectory has ended."""
    if e.w[8 * rows.T + i] > y.last[i] >= 0.0:
        _orthonormal(e, y, t, i)
        _note(e, y, t, i)
