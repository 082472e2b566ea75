"""One lane of an ensemble: a trajectory takes it, changes its mode there, and leaves (as method.flow)."""

from math import cos, inf, sin

from ..control import CHATTER, CHATTER_COUNT, STEP_LIMIT, at_end
from ..interface import inlined, inner, spliced
from ..modes import FORCE, FREE, GAP, REMEMBERS, SLIDE, follow, look, start
from ..walls.walls import moves_with
from . import layout as rows
from .attempts import DONE, STEPPING, aside, begin
from .exchange import begin_event, end_event, gather, scatter, settings
from .memory import PART
from .radau import STAGES
from .record import record


@spliced
def _start(f, k, j, i):
    """Set the mode that belongs to the initial state; a trajectory that rests on a wall goes aside."""
    w = k.w
    for r in range(k.n):
        if k.turning[r] != 0.0:
            angle = w[8 * (rows.POSITION + r) + i]
            w[8 * (rows.SINE + r) + i], w[8 * (rows.COSINE + r) + i] = sin(angle), cos(angle)
    gather(f, k, i)
    real = j.real[k.whole[8 * rows.JOB + i]]
    for c in range(len(k.flags)):
        start(f.contacts, c, k.flags, k.modes, k.m, k.s, k.p, real[rows.J_REST], k.contact)
    for c in range(len(k.flags), k.contacts):
        look(f.contacts, k.modes, k.m, k.s, k.p, k.contact)
        if moves_with(k, c, settings(real)):
            aside(k, j, i)
    scatter(k, i)


@inner
def enter(f, k, j, i):
    """The trajectory whose number is at JOB takes lane i."""
    job = k.whole[8 * rows.JOB + i]
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
def event(f, k, j, i):
    """Change the mode of a contact at the base point of a lane."""
    c, guard = k.whole[8 * rows.AT + i] // 4, k.whole[8 * rows.AT + i] % 4
    real = j.real[k.whole[8 * rows.JOB + i]]
    begin_event(f, k, j, i)
    before = k.modes[c]
    if before == FREE and k.flags[c] & REMEMBERS:
        f.reset(c, k.s, k.p)
    kind = follow(
        f.contacts, c, guard, k.flags, k.modes, k.fired, k.m, k.s, k.p, real[rows.J_REST], k.contact
    )
    if before != FREE and k.modes[c] == FREE and k.flags[c] & REMEMBERS:
        f.reset(len(k.flags) + c, k.s, k.p)
    end_event(k, j, i, c, kind)


@inlined
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


UNIT = {"enter": PART, "event": PART}
