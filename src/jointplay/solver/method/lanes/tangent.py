"""A tangent with each trajectory of an ensemble: in its lane, through events, with its growth recorded.

Within a step as method.tangents.tangent has it, in lanes (codegen.lanes.tangent). A lane carries one tangent;
the rate F of the state itself, which the motion has anyway, takes the part of the frame's first. What of the
tangent lies along F is taken away where a row is due, and before it hides the rest; between, nothing need be
done, since the flow takes F to F, and so does a jump (method.tangents.saltation).
"""

from math import log, sqrt
from typing import NamedTuple

import numpy as np

from ..interface import inlined, inner
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
    rows: np.ndarray  # trajectory, time, trace, volume, 0; logarithms of |F| and of the growth; state
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
def take_up(k, j, y, i):
    """Begin the tangent of a trajectory that has just entered a lane."""
    w, job = k.w, k.whole[8 * rows.JOB + i]
    for r in range(k.n):
        w[8 * (rows.D_POSITION + r) + i], w[8 * (rows.D_SPEED + r) + i] = (
            y.frame[job, r],
            y.frame[job, k.n + r],
        )
        w[8 * (rows.WEIGHT_POSITION + r) + i] = y.weight[job, r]
        w[8 * (rows.WEIGHT + r) + i] = y.weight[job, k.n + r]
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
def before_event(f, v, k, y, i):
    """Note the values before an event that the jump of the tangent needs."""
    w, guard = k.w, k.whole[8 * rows.AT + i]
    gather(f, k, i)
    for r in range(k.n if w[8 * rows.TAKEN + i] == 0.0 else 0):  # another event at the same place
        w[8 * (rows.RATE_BEFORE + r) + i] = w[8 * (rows.ACCELERATION + r) + i]
    mask(k.modes, k.m)
    v.gradient(guard, k.s, k.p, k.m, y.gradient[i])
    y.stuck[i] = _stuck(k.modes)
    w[8 * rows.NEW_SLOPES + i] = 1.0


@inner
def _stuck(modes):
    held = 0.0
    for mode in modes:
        held += 1.0 if mode == STICK else 0.0
    return held


@inner
def jump(k, y, i):
    """Take the tangent of a lane through an event that has just been handled (method.tangents.saltation)."""
    w, n, h, job = k.w, k.n, y.gradient[i], k.whole[8 * rows.JOB + i]
    slope, size, later, delay, held = h[0], abs(h[0]), h[0], 0.0, 0.0
    for c in range(len(k.flags)):
        held += 1.0 if k.whole[8 * (rows.MODE + c) + i] == STICK else 0.0
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
    whole = _length(k, i, rows.D_POSITION, rows.D_SPEED)
    for r in range(n):
        gained = w[8 * (rows.ACCELERATION + r) + i] - w[8 * (rows.RATE_BEFORE + r) + i]
        w[8 * (rows.D_SPEED + r) + i] += gained * (delay / slope)
    if lossy and not _across(k, y, i) > LOST * whole:
        y.logs[i] = -np.inf
        _replace(k, y, i, 0.0)


@inner
def _length(k, i, position, speed):
    """Length of the tangent, or of the rate, in these rows."""
    w, total = k.w, 0.0
    for r in range(k.n):
        p = w[8 * (rows.WEIGHT_POSITION + r) + i] * w[8 * (position + r) + i]
        q = w[8 * (rows.WEIGHT + r) + i] * w[8 * (speed + r) + i]
        total += p * p + q * q
    return sqrt(total)


@inner
def _across(k, y, i):
    """Write the tangent's part across the rate into `y.across`; its length. Twice, for rounding."""
    w, n, left = k.w, k.n, 0.0
    rate = _length(k, i, rows.SPEED, rows.ACCELERATION)
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
def _replace(k, y, i, factor):
    """The tangent is `y.across` times a factor from here on."""
    for r in range(k.n):
        k.w[8 * (rows.D_POSITION + r) + i] = factor * y.across[r]
        k.w[8 * (rows.D_SPEED + r) + i] = factor * y.across[k.n + r]
    k.w[8 * rows.FOLLOWS + i] = 0.0


@inner
def renew(k, y, i):
    """Record a row if one is due; remove the part along the rate where it hides the rest."""
    w, left = k.w, _across(k, y, i)
    length = log(left) if left > 0.0 else -np.inf
    if w[8 * rows.T + i] >= w[8 * rows.NEXT_ROW + i]:
        _note(k, y, i, y.logs[i] + length)
        while w[8 * rows.T + i] >= w[8 * rows.NEXT_ROW + i]:
            w[8 * rows.NEXT_ROW + i] += y.real[k.whole[8 * rows.JOB + i], Y_BLOCK]
    if w[8 * rows.DUE + i] > 1.0 and left > 0.0:
        y.logs[i] += length
        _replace(k, y, i, 1.0 / left)
    w[8 * rows.DUE + i] = 0.0


@inner
def _note(k, y, i, grown):
    """Add a row as of method.tangents.tangent, after the trajectory's number."""
    w, row = k.w, y.rows[y.count[0]]
    rate = _length(k, i, rows.SPEED, rows.ACCELERATION)
    row[0], row[1], row[2] = k.whole[8 * rows.JOB + i], w[8 * rows.T + i], w[8 * rows.TRACE + i]
    row[3], row[4], row[5], row[6] = y.volume[i], 0.0, log(rate) if rate > 0.0 else -np.inf, grown
    for r in range(k.n):
        row[7 + r], row[7 + k.n + r] = w[8 * (rows.POSITION + r) + i], w[8 * (rows.SPEED + r) + i]
    y.last[i] = w[8 * rows.T + i]
    y.count[0] += 1


@inner
def lay_down(k, y, i):
    """Record where a trajectory has ended."""
    if k.w[8 * rows.T + i] > y.last[i] >= 0.0:
        left = _across(k, y, i)
        _note(k, y, i, y.logs[i] + (log(left) if left > 0.0 else -np.inf))
