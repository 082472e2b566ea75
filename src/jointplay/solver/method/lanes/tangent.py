"""Tangents with each trajectory of an ensemble: in its lane, through events, with their growth recorded.

Within a step as method.tangents.tangent has it, in lanes (codegen.lanes.tangent). The rate F of the state
itself, which the motion has anyway, takes the part of the frame's first. Events take all through as those of
one trajectory (method.tangents.saltation). What of a tangent lies along F is taken away there, where a row is
due, and before it hides the rest; between, the flow takes F to F. Several are made orthonormal after each
step, as those of one trajectory.
"""

from typing import NamedTuple

import numpy as np

from ..interface import inlined, inner, trajectory_at
from ..memory import lane_rows
from ..modes import mask
from ..tangents.saltation import stuck, through
from ..tangents.tangent import AHEAD, GRAZING, NEUTRAL, SALTATION, TRAILING, VOLUME, orthonormal
from ..tangents.tangent import tangents as of_one
from . import layout as rows
from .exchange import gather
from .radau import STAGES

MOST = 10  # updates of an iteration; nearly all take three to five
# Places in Tangents.real, of one trajectory each
Y_BEGIN, Y_BLOCK, Y_TOLERANCE, Y_LIMIT, REALS = range(5)
NO_LIMIT = 1e300  # of an error: finite, for a tangent that was lost has no length
ROOM = 16  # rows that one pass may need


class Tangents(NamedTuple):
    """Tangents of the trajectories of layout.Jobs, their rows, and scratch of eight lanes."""

    own: np.ndarray  # of the rate and of each tangent, its rows (layout.OWN) of eight lanes
    frame: np.ndarray  # of each trajectory, tangents at its start
    weight: np.ndarray  # 1 / scale of each state
    real: np.ndarray
    grazing: np.ndarray  # of each trajectory, as Tangents of method.tangents.tangent has it
    rows: np.ndarray  # time, sums; logarithms of |F| and of the growth; state; trajectory
    count: np.ndarray  # rows
    volume: np.ndarray  # of each lane: ln |det S| of its jumps
    last: np.ndarray  # time of its last row
    stuck: np.ndarray  # contacts that stuck before an event
    gradient: np.ndarray  # of its guard: time, state


def tangents(frame: np.ndarray, scale: np.ndarray, real: np.ndarray, n_rows: int) -> Tangents:
    """Allocate for trajectories with these tangents, scales and numbers (`Y_BEGIN`, …), a row each."""
    n, count, n_x = frame.shape
    return Tangents(
        own=lane_rows((1 + count) * rows.OWN_SIZE).reshape(1 + count, -1),
        frame=np.ascontiguousarray(frame),
        weight=1.0 / np.ascontiguousarray(scale),
        real=real,
        grazing=np.full(n, np.inf),
        rows=np.zeros((n_rows + ROOM, AHEAD + 1 + count + n_x + 1)),
        count=np.zeros(1, dtype=np.int64),
        volume=np.zeros(8),
        last=np.zeros(8),
        stuck=np.zeros(8),
        gradient=np.zeros((8, 1 + n_x)),
    )


def frame(count: int, n_x: int):
    """Scratch: the frame of a motion's rate and so many tangents, as one trajectory has it."""
    frame = of_one(np.zeros((1 + count, n_x)), np.ones(n_x), n_x // 2, 1, 1)
    frame.count[SALTATION] = frame.count[NEUTRAL] = 1
    return frame


@inner
def _place(row, i):
    """Place of a lane's number in the rows of a tangent."""
    return 8 * (row - rows.OWN) + i


@inner
def take_up(lanes, jobs, tangents, i):
    """Begin the tangents of a trajectory that has just entered a lane."""
    w, job = lanes.w, lanes.whole[8 * rows.JOB + i]
    for m in range(len(tangents.own)):
        for at in range(i, len(tangents.own[m]), 8):
            tangents.own[m, at] = 0.0
    for m in range(1, len(tangents.own)):
        own, limit = tangents.own[m], tangents.real[job, Y_LIMIT]
        for r in range(lanes.n):
            own[_place(rows.D_POSITION + r, i)] = tangents.frame[job, m - 1, r]
            own[_place(rows.D_SPEED + r, i)] = tangents.frame[job, m - 1, lanes.n + r]
        limit *= TRAILING if m > 1 else 1.0
        own[_place(rows.D_LIMIT, i)] = NO_LIMIT if m + 1 == 2 * lanes.n else limit  # known by its volume
    for r in range(lanes.n):
        w[8 * (rows.WEIGHT_POSITION + r) + i] = tangents.weight[job, r]
        w[8 * (rows.WEIGHT + r) + i] = tangents.weight[job, lanes.n + r]
    w[8 * rows.D_TOLERANCE + i] = tangents.real[job, Y_TOLERANCE]
    w[8 * rows.NEXT_ROW + i] = tangents.real[job, Y_BEGIN]
    w[8 * rows.DUE + i], w[8 * rows.NEW_SLOPES + i] = 2.0, 1.0
    w[8 * rows.UNRESOLVED + i] = tangents.volume[i] = 0.0
    tangents.last[i] = -1.0


@inlined
def carry(vectorised, derivatives, w, tangents):
    """Solve for the tangents of all steps that may be accepted, and judge them too."""
    for m in range(1, len(tangents.own)):
        derivatives.start(w, tangents.own[m])
    for s in range(STAGES):  # of all steps: the error of one that is rejected hangs on no other's
        derivatives.point(w, s)
        vectorised.jacobian(w)
        derivatives.keep(w, s)
    for m in range(1, len(tangents.own)):
        own = tangents.own[m]
        for _ in range(MOST):
            if not _any(own, rows.ACTIVE - rows.OWN):
                break
            derivatives.vary(w, own)
            derivatives.improve(w, own)
    for m in range(1, len(tangents.own)):
        derivatives.check(w, tangents.own[m])


@inlined
def follow(derivatives, w, tangents):
    """Take the tangents to the end of steps that are TAKEN; several are made orthonormal there.

    By Gram and Schmidt, each twice (Giraud et al. 2005); what predicts the next stages goes with them.
    """
    count = len(tangents.own)
    derivatives.advance(w)
    for m in range(1, count):
        derivatives.follow(w, tangents.own[m])
    if count == 2:
        derivatives.due(w, tangents.own[1])
        return
    derivatives.rate(w, tangents.own[0])
    for m in range(count):
        for _ in range(2):
            for j in range(m):
                derivatives.remove(w, tangents.own[m], tangents.own[j])
        derivatives.shorten(w, tangents.own[m])
    if count == tangents.frame.shape[2]:
        derivatives.complete(w, tangents.own[count - 1])


@inner
def _any(w, row):
    """Whether a row is above 0 in any lane."""
    most = 0.0
    for i in range(8):
        most = max(most, w[8 * row + i])
    return most > 0.0


@inlined
def base_slopes(vectorised, derivatives, w):
    """Slopes at the base points that are new; X and Y are at the base."""
    vectorised.jacobian(w)
    derivatives.base(w)


@inner
def before_event(functions, derivatives, lanes, jobs, tangents, i):
    """Note the values before an event that the jump of the tangent needs."""
    w, guard = lanes.w, lanes.whole[8 * rows.AT + i]
    motion = trajectory_at(jobs.motions, lanes.whole[8 * rows.JOB + i])
    gather(lanes, jobs, motion, i)
    functions.trig(motion.s, motion.p)
    for r in range(lanes.n if w[8 * rows.TAKEN + i] == 0.0 else 0):  # another event at the same place
        w[8 * (rows.RATE_BEFORE + r) + i] = w[8 * (rows.ACCELERATION + r) + i]
    mask(motion.modes, motion.m)
    derivatives.gradient(guard, motion.s, motion.p, motion.m, tangents.gradient[i])
    tangents.stuck[i] = stuck(motion.modes)
    w[8 * rows.NEW_SLOPES + i] = 1.0


@inner
def _write_frame(lanes, tangents, frame, i):
    """Write the rate and the tangents of a lane, as a frame of one trajectory."""
    w, n, job, width = lanes.w, lanes.n, lanes.whole[8 * rows.JOB + i], 1 + 2 * lanes.n
    for r in range(n):
        frame.d[1 + r], frame.d[1 + n + r] = w[8 * (rows.SPEED + r) + i], w[8 * (rows.ACCELERATION + r) + i]
    for m in range(1, len(frame.alive)):
        own, first = tangents.own[m], m * width + 1
        for r in range(n):
            frame.d[first + r] = own[_place(rows.D_POSITION + r, i)]
            frame.d[first + n + r] = own[_place(rows.D_SPEED + r, i)]
    for r in range(2 * n):
        frame.weight[r] = tangents.weight[job, r]
    for m in range(len(frame.alive)):
        frame.alive[m], frame.logs[m] = 1, 0.0


@inner
def _orthonormal(lanes, tangents, frame, i):
    """Write that frame made orthonormal; logarithms of its lengths are in `frame.logs`."""
    _write_frame(lanes, tangents, frame, i)
    orthonormal(frame, 1 + 2 * lanes.n, 0.0)


@inner
def _take(lanes, tangents, frame, i):
    """Write the tangents of a frame back to the lane, and add up their growth."""
    n, width = lanes.n, 1 + 2 * lanes.n
    for m in range(1, len(frame.alive)):
        own, first = tangents.own[m], m * width + 1
        for r in range(n):
            own[_place(rows.D_POSITION + r, i)] = frame.d[first + r]
            own[_place(rows.D_SPEED + r, i)] = frame.d[first + n + r]
        own[_place(rows.FOLLOWS, i)] = 0.0
        own[_place(rows.D_LOG, i)] += frame.logs[m]
    tangents.own[0, _place(rows.D_LOG, i)] = frame.logs[0]


@inner
def jump(lanes, jobs, tangents, frame, i):
    """Take the tangents of a lane through an event that has just been handled."""
    w, n, job = lanes.w, lanes.n, lanes.whole[8 * rows.JOB + i]
    _write_frame(lanes, tangents, frame, i)
    for r in range(n):
        frame.before[r] = frame.after[r] = w[8 * (rows.SPEED + r) + i]
        frame.before[n + r] = w[8 * (rows.RATE_BEFORE + r) + i]
        frame.after[n + r] = w[8 * (rows.ACCELERATION + r) + i]
    for r in range(1 + 2 * n):
        frame.gradient[r] = tangents.gradient[i, r]
    frame.real[GRAZING], frame.real[VOLUME] = tangents.grazing[job], tangents.volume[i]
    lossy = stuck(trajectory_at(jobs.motions, job).modes) > tangents.stuck[i]
    if through(frame, n, 2 * n, False, lossy):
        _take(lanes, tangents, frame, i)
    tangents.grazing[job], tangents.volume[i] = frame.real[GRAZING], frame.real[VOLUME]


@inner
def renew(lanes, tangents, frame, i):
    """Record a row if one is due; remove the part along the rate where it hides the rest."""
    w = lanes.w
    _orthonormal(lanes, tangents, frame, i)
    if w[8 * rows.T + i] >= w[8 * rows.NEXT_ROW + i]:
        _note(lanes, tangents, frame, i)
        while w[8 * rows.T + i] >= w[8 * rows.NEXT_ROW + i]:
            w[8 * rows.NEXT_ROW + i] += tangents.real[lanes.whole[8 * rows.JOB + i], Y_BLOCK]
    if w[8 * rows.DUE + i] > 1.0 and frame.alive[1]:
        _take(lanes, tangents, frame, i)
    w[8 * rows.DUE + i] = 0.0


@inner
def _note(lanes, tangents, frame, i):
    """Add a row as of method.tangents.tangent, then the trajectory's number."""
    w, row, count = lanes.w, tangents.rows[tangents.count[0]], len(frame.logs)
    row[0], row[1], row[2] = w[8 * rows.T + i], w[8 * rows.TRACE + i], tangents.volume[i]
    row[3], row[AHEAD] = w[8 * rows.UNRESOLVED + i], frame.logs[0]
    for m in range(1, count):
        row[AHEAD + m] = tangents.own[m, _place(rows.D_LOG, i)] + frame.logs[m]
    for r in range(lanes.n):
        row[AHEAD + count + r] = w[8 * (rows.POSITION + r) + i]
        row[AHEAD + count + lanes.n + r] = w[8 * (rows.SPEED + r) + i]
    row[AHEAD + count + 2 * lanes.n] = lanes.whole[8 * rows.JOB + i]
    tangents.last[i] = w[8 * rows.T + i]
    tangents.count[0] += 1


@inner
def lay_down(lanes, tangents, frame, i):
    """Record where a trajectory has ended."""
    if lanes.w[8 * rows.T + i] > tangents.last[i] >= 0.0:
        _orthonormal(lanes, tangents, frame, i)
        _note(lanes, tangents, frame, i)
