"""One lane of an ensemble: a trajectory takes it, changes its mode there, and leaves (as numerics.flow)."""

from math import cos, inf, sin

from ..control import CHATTER, CHATTER_COUNT, STEP_LIMIT, at_end, close_events, restarted
from ..interface import inner
from ..memory import EVENT_ROW
from ..modes import (
    FORCE,
    FREE,
    GAP,
    IMPACT,
    PULLS,
    RELEASED,
    REMEMBERS,
    SLIDE,
    follow,
    inside,
    look,
    mask,
    start,
)
from ..walls import low, move, moves_with, throw_off
from . import layout as rows
from .attempts import DONE, STEPPING, aside, begin
from .radau import STAGES
from .record import note, record
from .tangent import before_event


@inner
def _gather(f, k, i):
    """The base point of a lane, as numerics.modes takes it."""
    w, speeds = k.w, 1 + k.n_q
    k.s[0] = w[8 * rows.T + i]
    for r in range(k.n_q):
        k.s[1 + r] = w[8 * (rows.POSITION + k.phases + r) + i]
    for r in range(k.n - k.phases):
        k.s[speeds + r] = w[8 * (rows.SPEED + k.phases + r) + i]
    first = speeds + k.n - k.phases
    for r in range(k.memories):
        k.s[first + r] = w[8 * (rows.MEMORY + r) + i]
    for r in range(len(k.p)):
        k.p[r] = w[8 * (rows.NUMBERS + r) + i]
    for c in range(len(k.modes)):
        k.modes[c] = k.whole[8 * (rows.MODE + c) + i]
    if k.phases > 0:
        f.trig(k.s, k.p)
    else:
        _gather_angles(k, i, first + k.memories)


@inner
def _gather_angles(k, i, first):
    a, angles = 0, (len(k.s) - first) // 2
    for r in range(k.n):
        if k.turning[r] != 0.0:
            k.s[first + a] = k.w[8 * (rows.SINE + r) + i]
            k.s[first + angles + a] = k.w[8 * (rows.COSINE + r) + i]
            a += 1


@inner
def _scatter(k, i):
    """The modes that a lane has now: masks, memories, and the sides of its guards."""
    w, touches = k.w, 0.0
    mask(k.modes, k.m)
    for r in range(3 * k.contacts):
        w[8 * (rows.MASK + r) + i] = k.m[r]
    for r in range(k.memories):
        w[8 * (rows.MEMORY + r) + i] = k.s[1 + 2 * k.n + r]
    for c in range(len(k.flags), k.contacts):
        w[8 * (rows.SIDE + 4 * c + GAP) + i] = 1.0
    for c in range(len(k.flags)):
        mode, pulls = k.modes[c], k.flags[c] & PULLS
        k.whole[8 * (rows.MODE + c) + i] = mode
        for g in range(4):
            w[8 * (rows.SIDE + 4 * c + g) + i] = inside(mode, g, pulls)
        touches = 1.0 if mode > RELEASED else touches
    w[8 * rows.VARIANT + i] = touches
    w[8 * rows.NEW + i] = 1.0


@inner
def enter(f, k, j, i, job):
    """Trajectory `job` takes lane i."""
    w, real, whole = k.w, j.real[job], j.whole[job]
    for at in range(i, len(w), 8):
        w[at] = 0.0
    for at in range(i, len(k.whole), 8):
        k.whole[at] = 0
    for at in range(i, len(k.real), 8):
        k.real[at] = 0.0
    k.whole[8 * rows.JOB + i], k.whole[8 * rows.SINCE + i] = job, j.place[rows.PASSED_BY]
    k.real[8 * rows.T_EVENT + i] = -inf
    for r in range(k.n):
        w[8 * (rows.POSITION + r) + i], w[8 * (rows.SPEED + r) + i] = j.state[job, r], j.state[job, k.n + r]
        w[8 * (rows.FLOOR_POSITION + r) + i] = real[rows.J_FLOORS + r]
        w[8 * (rows.FLOOR + r) + i] = real[rows.J_FLOORS + k.n + r]
    for r in range(k.memories):
        w[8 * (rows.MEMORY + r) + i] = j.state[job, 2 * k.n + r]
    for r in range(len(k.p)):
        w[8 * (rows.NUMBERS + r) + i] = j.numbers[job, r]
    w[8 * rows.TOLERANCE + i], w[8 * rows.SWIFT + i] = real[rows.J_TOLERANCE], real[rows.J_SWIFT]
    w[8 * rows.END + i], w[8 * rows.LEFT + i] = real[rows.J_END], whole[rows.J_STEPS]
    w[8 * rows.H_PAST + i] = w[8 * rows.OFFSET + i] = w[8 * rows.ERROR_BEFORE + i] = w[8 * rows.ODD + i] = 1.0
    w[8 * rows.H_LIMIT + i], w[8 * rows.H_CONTROL + i] = 1e300, real[rows.J_H]
    begin(k, i, real[rows.J_H])
    w[8 * rows.H + i] = w[8 * rows.H_NEXT + i]
    w[8 * rows.DIRECTION + i] = whole[rows.J_DIRECTION] if whole[rows.J_DIRECTION] else 1.0
    w[8 * rows.AHEAD + i] = real[rows.J_LEVEL] if whole[rows.J_DIRECTION] else 1e300
    w[8 * rows.MISSES + i] = whole[rows.J_MISSES]
    for c in range(k.contacts):
        at = rows.J_FLOORS + 2 * k.n + rows.PER_CONTACT * c
        w[8 * (rows.CONE + c) + i], w[8 * (rows.MARGIN + 4 * c + GAP) + i] = real[at], real[at + 1]
        w[8 * (rows.MARGIN + 4 * c + FORCE) + i] = real[at + 2]
        w[8 * (rows.MARGIN + 4 * c + SLIDE) + i] = real[rows.J_REST]
        w[8 * (rows.CLEARANCE_SQUARED + c) + i] = real[at + 3]
    _start(f, k, j, i)
    record(k, i, j.start[job])


@inner
def _start(f, k, j, i):
    """The mode that belongs to the initial state; what rests on a wall steps aside."""
    w = k.w
    for r in range(k.n):
        if k.turning[r] != 0.0:
            angle = w[8 * (rows.POSITION + r) + i]
            w[8 * (rows.SINE + r) + i], w[8 * (rows.COSINE + r) + i] = sin(angle), cos(angle)
    _gather(f, k, i)
    real = j.real[k.whole[8 * rows.JOB + i]]
    for c in range(len(k.flags)):
        start(f.contacts, c, k.flags, k.modes, k.m, k.s, k.p, real[rows.J_REST], k.contact)
    for c in range(len(k.flags), k.contacts):
        look(f.contacts, k.modes, k.m, k.s, k.p, k.contact)
        if moves_with(k, c, _settings(real)):
            aside(k, j, i)
    _scatter(k, i)


@inner
def _settings(real):
    return rows.Settings(real[rows.J_NEAR], real[rows.J_REST], real[rows.J_HOP], real[rows.J_PLAY])


@inner
def _met_too(k, o, c):
    """Whether another wall was met at the instant at which the state has left wall c."""
    for at in range(len(k.flags), len(k.modes)):
        near = k.contact[6 * at] <= abs(k.contact[6 * at + 2]) * o.near
        if at != c and near and k.contact[6 * at + 3] <= 0.0:
            return True
    return False


@inner
def _jump(f, k, j, i, c):
    """The state jumps, as at a wall (numerics.walls); where it may rest, or meets two, it steps aside."""
    w, x, number, fired, o = k.w, k.x, c - len(k.flags), 1.0, _settings(j.real[k.whole[8 * rows.JOB + i]])
    look(f.contacts, k.modes, k.m, k.s, k.p, k.contact)
    if k.contact[6 * c + 3] > 0.0:
        move(f, number, k, x, o)
        fired = 0.0
    elif k.contact[6 * c + 2] < 0.0:
        f.reset(number, k.s, k.p)
        look(f.contacts, k.modes, k.m, k.s, k.p, k.contact)
        throw_off(k, x, o)
        if low(k.contact[6 * c + 2], k.contact[6 * c + 5], o) or _met_too(k, o, c):
            aside(k, j, i)
    else:
        aside(k, j, i)
    w[8 * (rows.FIRED + 4 * c + GAP) + i] = fired
    for r in range(k.n_q):
        w[8 * (rows.POSITION + k.phases + r) + i] = k.s[1 + r]
    for r in range(k.n - k.phases):
        w[8 * (rows.SPEED + k.phases + r) + i] = k.s[1 + k.n_q + r]
    return IMPACT


@inner
def event(f, k, j, i, v, y):
    """Change the mode of a lane at its base point; count events that crowd."""
    w, job, t = k.w, k.whole[8 * rows.JOB + i], k.w[8 * rows.T + i]
    real, later = j.real[job], t - k.real[8 * rows.T_EVENT + i]
    k.whole[8 * rows.CLOSE + i] = close_events(k.whole[8 * rows.CLOSE + i], later, real[rows.J_NEAR])
    k.real[8 * rows.T_EVENT + i] = t
    j.count[job, rows.C_EVENTS] += 1
    row = j.log[j.place[rows.LOGGED]]
    if j.whole[job, rows.J_EVENTS]:
        record(k, i, row[rows.COLUMNS :])
        note(k, j, i, EVENT_ROW, 0.0, 0.0)
    _gather(f, k, i)
    for g in range(4 * len(k.flags)):
        k.fired[g] = int(w[8 * (rows.FIRED + g) + i])
    if y is not None:
        before_event(v, k, y, i)
    c, guard = k.whole[8 * rows.AT + i] // 4, k.whole[8 * rows.AT + i] % 4
    if c >= len(k.flags):
        kind = _jump(f, k, j, i, c)
    else:
        before = k.modes[c]
        if before == FREE and k.flags[c] & REMEMBERS:
            f.reset(c, k.s, k.p)
        kind = follow(
            f.contacts, c, guard, k.flags, k.modes, k.fired, k.m, k.s, k.p, real[rows.J_REST], k.contact
        )
        if before != FREE and k.modes[c] == FREE and k.flags[c] & REMEMBERS:
            f.reset(len(k.flags) + c, k.s, k.p)
    if j.whole[job, rows.J_EVENTS]:
        row[2], row[3] = c, kind
    for g in range(4 * len(k.flags)):
        w[8 * (rows.FIRED + g) + i] = k.fired[g]
    _scatter(k, i)
    _restart(k, i)


@inner
def _restart(k, i):
    """Length of the first step after an event: that which served the last one into the same mode."""
    w, variant = k.w, int(k.w[8 * rows.VARIANT + i])
    served, kept = w[8 * (rows.H_VARIANT + variant) + i], k.real[8 * (rows.H_START + variant) + i]
    h = restarted(w[8 * rows.H_CONTROL + i], served, kept)
    w[8 * rows.SMOOTH + i], w[8 * rows.REJECTION + i], w[8 * rows.H_BEFORE + i] = 0.0, 0.0, 0.0
    w[8 * rows.H_LIMIT + i], w[8 * rows.ODD + i], w[8 * rows.H_CONTROL + i] = 1e300, 1.0, h
    begin(k, i, h)
    w[8 * rows.H + i] = w[8 * rows.H_NEXT + i]
    k.whole[8 * rows.FRESH + i] = 1


@inner
def ends(k, j, i):
    """Whether the trajectory of a lane has ended; writes its status."""
    w, job = k.w, k.whole[8 * rows.JOB + i]
    status, end, stop = j.count[job, rows.C_STATUS], w[8 * rows.END + i], j.whole[job, rows.J_STOP]
    if k.whole[8 * rows.PHASE + i] == DONE:
        return True
    if k.whole[8 * rows.PHASE + i] != STEPPING or w[8 * rows.JOINED + i] > 0.0:
        return False
    if at_end(w[8 * rows.T + i], end):
        w[8 * rows.T + i] = end
    if k.whole[8 * rows.CLOSE + i] >= CHATTER_COUNT:
        status = CHATTER
    elif not (w[8 * rows.T + i] >= end or (stop > 0 and j.count[job, rows.C_SECTIONS] >= stop)):
        if w[8 * rows.LEFT + i] > 0.5:
            return False
        status = STEP_LIMIT
    j.count[job, rows.C_STATUS] = status
    return True


@inner
def leave(k, j, i):
    """Write down a finished trajectory; its lane is free."""
    w, job, passes = k.w, k.whole[8 * rows.JOB + i], j.place[rows.PASSED_BY] - k.whole[8 * rows.SINCE + i]
    record(k, i, j.final[job])
    j.count[job, rows.C_STEPS] = int(w[8 * rows.STEPS + i])
    j.count[job, rows.C_EVALUATIONS] = (rows.UPDATES * STAGES + 1) * passes
    k.whole[8 * rows.JOB + i], k.whole[8 * rows.PHASE + i] = -1, STEPPING
