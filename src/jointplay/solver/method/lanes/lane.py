"""One lane of an ensemble: a trajectory takes it, changes its mode there, and leaves (as method.flow)."""

from math import cos, sin

from ..control import CHATTER, CHATTER_COUNT, STEP_LIMIT, at_end
from ..flow import event as plain_event
from ..flow import initial_modes
from ..interface import inlined, inner, options_at, trajectory_at, work_at
from ..memory import (
    CLOSE,
    EVALUATIONS,
    H_START,
    H_VARIANT,
    JAMMED,
    LEVEL,
    SECTIONS,
    STEPS,
    H,
)
from ..modes import IN_FLIGHT, SLIPPING, STICKING
from ..record import write
from ..walls.walls import resting
from . import layout as rows
from .attempts import DONE, STEPPING, aside, begin, done
from .exchange import at_base, gather, scatter, signed
from .memory import PART
from .radau import MAX_TURN, STAGES

NO_ERROR = 1e100  # scale of an error that does not count: of phases, and of what nothing depends on


@inner
def enter(f, e, j, i):
    """The trajectory whose number is at JOB takes lane i."""
    job = e.whole[8 * rows.JOB + i]
    w, k, x, o = e.w, work_at(j.k, 0), trajectory_at(j.x, job), options_at(j.o, job)
    for at in range(i, len(w), 8):
        w[at] = 0.0
    for at in range(i, len(e.whole), 8):
        e.whole[at] = 0
    for at in range(i, len(e.real), 8):
        e.real[at] = 0.0
    e.whole[8 * rows.JOB + i], e.whole[8 * rows.SINCE + i] = job, j.place[rows.PASSED_BY]
    initial_modes(f, k, x, o)
    _take_up(e, j, x, i)
    for r in range(len(x.p)):
        w[8 * (rows.NUMBERS + r) + i] = x.p[r]
    w[8 * rows.TOLERANCE + i], w[8 * rows.SWIFT + i] = x.relative[e.n_q], MAX_TURN / o.h_max
    w[8 * rows.END + i], w[8 * rows.LEFT + i] = o.t_end, o.max_steps
    w[8 * rows.H_PAST + i] = w[8 * rows.OFFSET + i] = w[8 * rows.ERROR_BEFORE + i] = w[8 * rows.ODD + i] = 1.0
    w[8 * rows.H_LIMIT + i], w[8 * rows.H_CONTROL + i] = 1e300, x.real[H]
    begin(e, i, x.real[H])
    w[8 * rows.H + i] = w[8 * rows.H_NEXT + i]
    w[8 * rows.DIRECTION + i] = o.direction if o.direction != 0 else 1.0
    w[8 * rows.AHEAD + i] = x.real[LEVEL] if o.direction != 0 else 1e300
    w[8 * rows.MISSES + i] = o.log_misses
    for c in range(len(x.flags)):
        w[8 * (rows.CONE + c) + i] = x.cone[c]
        w[8 * (rows.CLEARANCE_SQUARED + c) + i] = x.clearance_squared[c]
    at_base(k, o)
    n_x, start = len(x.absolute), 8 * (o.first + 1)
    write(j.start[job], x.s[0], 0.0, k.w, start, x.s, n_x, k.b, x.modes, k.gain, x.work)
    if resting(x) > 0:
        aside(e, j, i)


@inner
def _take_up(e, j, x, i):
    """Write the start of a trajectory, its phases and tolerated errors to a lane."""
    w, job = e.w, e.whole[8 * rows.JOB + i]
    for r in range(e.n):
        w[8 * (rows.FLOOR_POSITION + r) + i] = w[8 * (rows.FLOOR + r) + i] = NO_ERROR
    for r in range(e.n_q):
        w[8 * (rows.FLOOR_POSITION + e.phases + r) + i] = x.absolute[r]
    for r in range(e.n - e.phases):
        w[8 * (rows.FLOOR + e.phases + r) + i] = x.absolute[e.n_q + r]
    for r in range(e.phases):
        w[8 * (rows.POSITION + r) + i] = j.phases[job, r]
        w[8 * (rows.SPEED + r) + i] = j.phases[job, e.phases + r]
    scatter(e, x, i)
    for r in range(e.n):
        if e.turning[r] != 0.0:
            angle = w[8 * (rows.POSITION + r) + i]
            w[8 * (rows.SINE + r) + i], w[8 * (rows.COSINE + r) + i] = sin(angle), cos(angle)


@inner
def event(f, e, j, i):
    """Change the mode of a contact, or let the state jump, at the base point of a lane."""
    w, job = e.w, e.whole[8 * rows.JOB + i]
    k, x, o = work_at(j.k, 0), trajectory_at(j.x, job), options_at(j.o, job)
    gather(e, j, x, i)
    at_base(k, o)
    x.real[H], x.real[H_VARIANT + IN_FLIGHT] = w[8 * rows.H_CONTROL + i], w[8 * rows.H_VARIANT + i]
    for variant in (SLIPPING, STICKING):  # in lanes one form of the equations has both
        x.real[H_VARIANT + variant] = w[8 * (rows.H_VARIANT + SLIPPING) + i]
        x.real[H_START + variant] = x.real[H_START + SLIPPING]
    e.whole[8 * rows.MEETS + i] = 0
    plain_event(f, k, x, o, e.whole[8 * rows.AT + i])
    signed(j, x, job)
    scatter(e, x, i)
    w[8 * rows.SMOOTH + i], w[8 * rows.REJECTION + i], w[8 * rows.H_BEFORE + i] = 0.0, 0.0, 0.0
    w[8 * rows.H_LIMIT + i], w[8 * rows.ODD + i], w[8 * rows.H_CONTROL + i] = 1e300, 1.0, x.real[H]
    begin(e, i, x.real[H])
    w[8 * rows.H + i] = w[8 * rows.H_NEXT + i]
    e.whole[8 * rows.FRESH + i] = 1
    if resting(x) > 0 or x.count[JAMMED] > 0:
        aside(e, j, i)


@inlined
def ends(e, j, i):
    """Whether the trajectory of a lane has ended; writes its status."""
    w, job = e.w, e.whole[8 * rows.JOB + i]
    x, o, end = trajectory_at(j.x, job), options_at(j.o, job), w[8 * rows.END + i]
    if e.whole[8 * rows.PHASE + i] == DONE:
        return True
    if e.whole[8 * rows.PHASE + i] != STEPPING or w[8 * rows.JOINED + i] > 0.0:
        return False
    if at_end(w[8 * rows.T + i], end):
        w[8 * rows.T + i] = end
    if x.count[CLOSE] >= CHATTER_COUNT:
        done(e, j, i, CHATTER + 0 * i)
    elif not (w[8 * rows.T + i] >= end or (o.stop_after > 0 and x.count[SECTIONS] >= o.stop_after)):
        if w[8 * rows.LEFT + i] > 0.5:
            return False
        done(e, j, i, STEP_LIMIT + 0 * i)
    return True


@inner
def leave(f, e, j, i):
    """Write down a finished trajectory; its lane is free."""
    job = e.whole[8 * rows.JOB + i]
    passes, x = j.place[rows.PASSED_BY] - e.whole[8 * rows.SINCE + i], trajectory_at(j.x, job)
    gather(e, j, x, i)
    x.count[STEPS] = int(e.w[8 * rows.STEPS + i])
    x.count[EVALUATIONS] += (rows.UPDATES * STAGES + 1) * passes
    e.whole[8 * rows.JOB + i], e.whole[8 * rows.PHASE + i] = -1, STEPPING


UNIT = dict.fromkeys(("enter", "event", "leave"), PART)
