"""A tangent with each trajectory of an ensemble: in its lane, through events, with its growth recorded.

Within a step as method.tangents.tangent has it, in lanes (codegen.lanes.tangent). A lane carries one tangent;
the rate F of the state itself, which the motion has anyway, takes the part of the frame's first. What of the
tangent lies along F is taken away where a row is due, and before it hides the rest; between, nothing need be
done, since the flow takes F to F, and so does a jump (method.tangents.saltation).
"""

from math import log, sqrt
from typing import NamedTuple

import numpy as np

from ..interface import inlined, inner, trajectory_at
from ..modes import STICK, mask
from ..tangents.frame import LOST
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
    across: np.ndarray  # a tangent without what lies along the rate


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
        across=np.zeros(n_x),
    )


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
    """Note what the jump at an event needs of the side before it."""
    w, guard, x = e.w, e.whole[8 * rows.AT + i], trajectory_at(j.x, e.whole[8 * rows.JOB + i])
    gather(e, j, x, i)
    f.trig(x.s, x.p)
    for r in range(e.n if w[8 * rows.TAKEN + i] == 0.0 else 0):  # another event at the same place
        w[8 * (rows.RATE_BEFORE + r) + i] = w[8 * (rows.ACCELERATION + r) + i]
    mask(x.modes, x.m)
    v.gradient(guard, x.s, x.p, x.m, y.gradient[i])
    y.stuck[i] = _stuck(x.modes)
    w[8 * rows.NEW_SLOPES + i] = 1.0


@inner
def _stuck(modes):
    held = 0.0
    for mode in modes:
        held += 1.0 if mode == STICK else 0.0
    return held


@inner
def jump(e, j, y, i):
    """Take the tangent of a lane through an event that has just been handled (method.tangents.saltation)."""
    w, n, h, job = e.w, e.n, y.gradient[i], e.whole[8 * rows.JOB + i]
    slope, size, later, delay = h[0], abs(h[0]), h[0], 0.0
    held = _stuck(trajectory_at(j.x, job).modes)
    for r in range(n):
        moved = h[1 + r] * w[8 * (rows.SPEED + r) + i]
        before, after = w[8 * (rows.RATE_BEFORE + r) + i], w[8 * (rows.ACCELERATION + r) + i]
        slope += moved + h[1 + n + r] * before
        later += moved + h[1 + n + r] * after
        size += abs(moved) + abs(h[1 + n + r] * before)
        delay += h[1 + r] * w[8 * (rows.D_POSITION + r) + i] + h[1 + n + r] * w[8 * (rows.D_SPEED + r) + i]
    y.grazing[job] = min(y.grazing[job], abs(slope) / size if size > 0.0 else 0.0)
    if slope == 0.0:
        return
    lossy = held > y.stuck[i]
    y.volume[i] += -np.inf if lossy or later == 0.0 else log(abs(later / slope))
    whole = _length(e, i, rows.D_POSITION, rows.D_SPEED)
    for r in range(n):
        gained = w[8 * (rows.ACCELERATION + r) + i] - w[8 * (rows.RATE_BEFORE + r) + i]
        w[8 * (rows.D_SPEED + r) + i] += gained * (delay / slope)
    if lossy and not _across(e, y, i) > LOST * whole:
        y.logs[i] = -np.inf
        _replace(e, y, i, 0.0)


@inner
def _length(e, i, position, speed):
    """Length of the tangent, or of the rate, in these rows."""
    w, total = e.w, 0.0
    for r in range(e.n):
        p = w[8 * (rows.WEIGHT_POSITION + r) + i] * w[8 * (position + r) + i]
        q = w[8 * (rows.WEIGHT + r) + i] * w[8 * (speed + r) + i]
        total += p * p + q * q
    return sqrt(total)


@inner
def _across(e, y, i):
    """What of the tangent does not lie along the rate, into `y.across`; its length. Twice, for rounding."""
    w, n, left = e.w, e.n, 0.0
    rate = _length(e, i, rows.SPEED, rows.ACCELERATION)
    for r in range(n):
        y.across[r], y.across[n + r] = w[8 * (rows.D_POSITION + r) + i], w[8 * (rows.D_SPEED + r) + i]
    for _ in range(2 if rate > 0.0 else 0):
        along = 0.0
        for r in range(n):
            p, q = w[8 * (rows.WEIGHT_POSITION + r) + i], w[8 * (rows.WEIGHT + r) + i]
            along += p * y.across[r] * p * w[8 * (rows.SPEED + r) + i]
            along += q * y.across[n + r] * q * w[8 * (rows.ACCELERATION + r) + i]
        along /= rate * rate
        for r in range(n):
            y.across[r] -= along * w[8 * (rows.SPEED + r) + i]
            y.across[n + r] -= along * w[8 * (rows.ACCELERATION + r) + i]
    for r in range(n):
        p = w[8 * (rows.WEIGHT_POSITION + r) + i] * y.across[r]
        q = w[8 * (rows.WEIGHT + r) + i] * y.across[n + r]
        left += p * p + q * q
    return sqrt(left)


@inner
def _replace(e, y, i, factor):
    """The tangent is `y.across` times a factor from here on."""
    for r in range(e.n):
        e.w[8 * (rows.D_POSITION + r) + i] = factor * y.across[r]
        e.w[8 * (rows.D_SPEED + r) + i] = factor * y.across[e.n + r]
    e.w[8 * rows.FOLLOWS + i] = 0.0


@inner
def renew(e, y, i):
    """Record a row if one is due; where it hides the rest, take away what lies along the rate."""
    w, left = e.w, _across(e, y, i)
    length = log(left) if left > 0.0 else -np.inf
    if w[8 * rows.T + i] >= w[8 * rows.NEXT_ROW + i]:
        _note(e, y, i, y.logs[i] + length)
        while w[8 * rows.T + i] >= w[8 * rows.NEXT_ROW + i]:
            w[8 * rows.NEXT_ROW + i] += y.real[e.whole[8 * rows.JOB + i], Y_BLOCK]
    if w[8 * rows.DUE + i] > 1.0 and left > 0.0:
        y.logs[i] += length
        _replace(e, y, i, 1.0 / left)
    w[8 * rows.DUE + i] = 0.0


@inner
def _note(e, y, i, grown):
    """A row as those of method.tangents.tangent, then the trajectory's number."""
    w, row = e.w, y.rows[y.count[0]]
    rate = _length(e, i, rows.SPEED, rows.ACCELERATION)
    row[0], row[1], row[2], row[3] = w[8 * rows.T + i], w[8 * rows.TRACE + i], y.volume[i], 0.0
    row[4], row[5] = log(rate) if rate > 0.0 else -np.inf, grown
    for r in range(e.n):
        row[6 + r], row[6 + e.n + r] = w[8 * (rows.POSITION + r) + i], w[8 * (rows.SPEED + r) + i]
    row[6 + 2 * e.n] = e.whole[8 * rows.JOB + i]
    y.last[i] = w[8 * rows.T + i]
    y.count[0] += 1


@inner
def lay_down(e, y, i):
    """Record where a trajectory has ended."""
    if e.w[8 * rows.T + i] > y.last[i] >= 0.0:
        left = _across(e, y, i)
        _note(e, y, i, y.logs[i] + (log(left) if left > 0.0 else -np.inf))
