"""One lane of an ensemble: a trajectory takes it, changes its mode there, and leaves (as numerics.flow)."""

from math import inf

from ..control import at_end, restarted
from ..interface import inner
from ..memory import EVENT_ROW
from ..modes import FREE, PULLS, RELEASED, follow, inside, mask, start
from ..status import CHATTER, CHATTER_COUNT, STEP_LIMIT, crowded
from . import layout as c
from .attempts import DONE, STEPPING, begin
from .radau import STAGES
from .record import note, record


@inner
def _gather(k, i):
    """The base point of a lane, as numerics.modes takes it."""
    w = k.w
    k.s[0] = w[8 * c.T + i]
    for r in range(c.N):
        k.s[1 + r], k.s[1 + c.N + r] = w[8 * (c.POSITION + r) + i], w[8 * (c.SPEED + r) + i]
        k.s[1 + 2 * c.N + r], k.s[1 + 3 * c.N + r] = w[8 * (c.SINE + r) + i], w[8 * (c.COSINE + r) + i]
    for r in range(len(k.p)):
        k.p[r] = w[8 * (c.NUMBERS + r) + i]
    k.modes[0] = k.whole[8 * c.MODE + i]


@inner
def _scatter(k, i):
    """The mode that a lane has now: its masks, and the sides of its guards."""
    w, mode, pulls = k.w, k.modes[0], k.flags[0] & PULLS
    k.whole[8 * c.MODE + i] = mode
    mask(k.modes, k.m)
    for r in range(3):
        w[8 * (c.MASK + r) + i] = k.m[r]
    for g in range(4):
        w[8 * (c.SIDE + g) + i] = inside(mode, g, pulls)
    w[8 * c.VARIANT + i] = 1.0 if mode > RELEASED else 0.0
    w[8 * c.NEW + i] = 1.0


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
    k.whole[8 * c.JOB + i], k.whole[8 * c.SINCE + i] = job, j.place[c.PASSED_BY]
    k.real[8 * c.T_EVENT + i] = -inf
    for r in range(c.N):
        w[8 * (c.POSITION + r) + i], w[8 * (c.SPEED + r) + i] = j.state[job, r], j.state[job, c.N + r]
    for r in range(len(k.p)):
        w[8 * (c.NUMBERS + r) + i] = j.numbers[job, r]
    w[8 * c.TOLERANCE + i], w[8 * c.FLOOR + i] = real[c.J_TOLERANCE], real[c.J_FLOOR]
    w[8 * c.END + i], w[8 * c.LEFT + i] = real[c.J_END], whole[c.J_STEPS]
    w[8 * c.H_PAST + i] = w[8 * c.OFFSET + i] = w[8 * c.ERROR_BEFORE + i] = w[8 * c.ODD + i] = 1.0
    w[8 * c.H_LIMIT + i], w[8 * c.H_CONTROL + i] = 1e300, real[c.J_H]
    begin(w, i, real[c.J_H])
    w[8 * c.H + i] = w[8 * c.H_NEXT + i]
    w[8 * c.DIRECTION + i] = whole[c.J_DIRECTION] if whole[c.J_DIRECTION] else 1.0
    w[8 * c.AHEAD + i] = real[c.J_LEVEL] if whole[c.J_DIRECTION] else 1e300
    w[8 * c.MARGIN + i], w[8 * (c.MARGIN + 1) + i] = real[c.J_GAP], real[c.J_FORCE]
    w[8 * (c.MARGIN + 2) + i], w[8 * c.CONE + i] = real[c.J_REST], real[c.J_CONE]
    w[8 * c.BUSH + i], w[8 * c.MISSES + i] = real[c.J_BUSH], whole[c.J_MISSES]
    k.flags[0] = whole[c.J_FLAGS]
    _start(f, k, i, real[c.J_REST])
    record(k, i, j.start[job])


@inner
def _start(f, k, i, rest):
    """The mode that belongs to the initial state."""
    _gather(k, i)
    f.trig(k.s, k.p)
    for r in range(c.N):
        k.w[8 * (c.SINE + r) + i], k.w[8 * (c.COSINE + r) + i] = k.s[1 + 2 * c.N + r], k.s[1 + 3 * c.N + r]
    start(f.contacts, 0 * i, k.flags, k.modes, k.m, k.s, k.p, rest, k.out)
    _scatter(k, i)


@inner
def event(f, k, j, i):
    """Change the mode of a lane at its base point; count events that crowd."""
    w, job, t = k.w, k.whole[8 * c.JOB + i], k.w[8 * c.T + i]
    real, later = j.real[job], t - k.real[8 * c.T_EVENT + i]
    k.whole[8 * c.CLOSE + i] = crowded(k.whole[8 * c.CLOSE + i], later, real[c.J_NEAR])
    k.real[8 * c.T_EVENT + i] = t
    j.count[job, c.C_EVENTS] += 1
    row = j.log[j.place[c.LOGGED]]
    if j.whole[job, c.J_EVENTS]:
        record(k, i, row[c.COLUMNS :])
        note(k, j, i, EVENT_ROW, 0.0, 0.0)
    _gather(k, i)
    k.flags[0] = j.whole[job, c.J_FLAGS]
    for g in range(4):
        k.fired[g] = int(w[8 * (c.FIRED + g) + i])
    guard = k.whole[8 * c.AT + i]
    kind = follow(f.contacts, 0 * i, guard, k.flags, k.modes, k.fired, k.m, k.s, k.p, real[c.J_REST], k.out)
    if j.whole[job, c.J_EVENTS]:
        row[3] = kind
    for g in range(4):
        w[8 * (c.FIRED + g) + i] = k.fired[g]
    _scatter(k, i)
    _restart(k, i)


@inner
def _restart(k, i):
    """Length of the first step after an event: that which served the last one into the same mode."""
    w, variant = k.w, int(k.w[8 * c.VARIANT + i])
    served, kept = w[8 * (c.H_VARIANT + variant) + i], k.real[8 * (c.H_START + variant) + i]
    h = restarted(w[8 * c.H_CONTROL + i], served, kept)
    w[8 * c.SMOOTH + i], w[8 * c.REJECTION + i], w[8 * c.H_BEFORE + i] = 0.0, 0.0, 0.0
    w[8 * c.H_LIMIT + i], w[8 * c.ODD + i], w[8 * c.H_CONTROL + i] = 1e300, 1.0, h
    begin(w, i, h)
    w[8 * c.H + i] = w[8 * c.H_NEXT + i]
    k.whole[8 * c.FRESH + i] = 1


@inner
def ends(k, j, i):
    """Whether a lane is done, and why."""
    w, job = k.w, k.whole[8 * c.JOB + i]
    status, end, stop = j.count[job, c.C_STATUS], w[8 * c.END + i], j.whole[job, c.J_STOP]
    if k.whole[8 * c.PHASE + i] == DONE:
        return True
    if k.whole[8 * c.PHASE + i] != STEPPING or w[8 * c.JOINED + i] > 0.0:
        return False
    if at_end(w[8 * c.T + i], end):
        w[8 * c.T + i] = end
    if k.whole[8 * c.CLOSE + i] >= CHATTER_COUNT:
        status = CHATTER
    elif not (w[8 * c.T + i] >= end or (stop > 0 and j.count[job, c.C_SECTIONS] >= stop)):
        if w[8 * c.LEFT + i] > 0.5:
            return False
        status = STEP_LIMIT
    j.count[job, c.C_STATUS] = status
    return True


@inner
def leave(k, j, i):
    """Write down a finished trajectory; its lane is free."""
    w, job, passes = k.w, k.whole[8 * c.JOB + i], j.place[c.PASSED_BY] - k.whole[8 * c.SINCE + i]
    record(k, i, j.final[job])
    j.count[job, c.C_STEPS] = int(w[8 * c.STEPS + i])
    j.count[job, c.C_EVALUATIONS] = (c.UPDATES * STAGES + 1) * passes
    k.whole[8 * c.JOB + i], k.whole[8 * c.MODE + i], k.whole[8 * c.PHASE + i] = -1, FREE, STEPPING
