"""One lane of an ensemble: a trajectory takes it, changes its mode there, and leaves (as method.flow)."""

from math import cos, sin

from ..control import CHATTER, CHATTER_COUNT, STEP_LIMIT, at_end
from ..flow import event as plain_event
from ..flow import initial_modes
from ..interface import inlined, inner, options_at, trajectory_at, work_at
from ..memory import (
    CLOSE_EVENTS,
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
def enter(functions, lanes, jobs, i):
    """The trajectory whose number is at JOB takes lane i."""
    job = lanes.whole[8 * rows.JOB + i]
    w, work = lanes.w, work_at(jobs.work, 0)
    motion, options = trajectory_at(jobs.motions, job), options_at(jobs.options, job)
    for at in range(i, len(w), 8):
        w[at] = 0.0
    for at in range(i, len(lanes.whole), 8):
        lanes.whole[at] = 0
    for at in range(i, len(lanes.real), 8):
        lanes.real[at] = 0.0
    lanes.whole[8 * rows.JOB + i], lanes.whole[8 * rows.SINCE + i] = job, jobs.place[rows.PASSED_BY]
    initial_modes(functions, work, motion, options)
    _take_up(lanes, jobs, motion, i)
    for r in range(len(motion.p)):
        w[8 * (rows.NUMBERS + r) + i] = motion.p[r]
    w[8 * rows.TOLERANCE + i], w[8 * rows.TURN_SPEED + i] = (
        motion.relative[lanes.n_q],
        MAX_TURN / options.h_max,
    )
    w[8 * rows.END + i], w[8 * rows.LEFT + i] = options.t_end, options.max_steps
    w[8 * rows.H_PAST + i] = w[8 * rows.OFFSET + i] = w[8 * rows.ERROR_BEFORE + i] = w[
        8 * rows.SPECIAL + i
    ] = 1.0
    w[8 * rows.H_LIMIT + i], w[8 * rows.H_CONTROL + i] = 1e300, motion.real[H]
    begin(lanes, i, motion.real[H])
    w[8 * rows.H + i] = w[8 * rows.H_NEXT + i]
    w[8 * rows.DIRECTION + i] = options.direction if options.direction != 0 else 1.0
    w[8 * rows.AHEAD + i] = motion.real[LEVEL] if options.direction != 0 else 1e300
    w[8 * rows.MISSES + i] = options.log_misses
    for c in range(len(motion.flags)):
        w[8 * (rows.CONE + c) + i] = motion.cone[c]
        w[8 * (rows.CLEARANCE_SQUARED + c) + i] = motion.clearance_squared[c]
    at_base(work, options)
    n_x, start, s, modes = len(motion.absolute), 8 * (options.first + 1), motion.s, motion.modes
    write(jobs.start[job], s[0], 0.0, work.w, start, s, n_x, work.b, modes, work.gain, motion.work)
    if resting(motion) > 0:
        aside(lanes, jobs, i)


@inner
def _take_up(lanes, jobs, motion, i):
    """Write the start of a trajectory, its phases and tolerated errors to a lane."""
    w, job = lanes.w, lanes.whole[8 * rows.JOB + i]
    for r in range(lanes.n):
        w[8 * (rows.FLOOR_POSITION + r) + i] = w[8 * (rows.FLOOR + r) + i] = NO_ERROR
    for r in range(lanes.n_q):
        w[8 * (rows.FLOOR_POSITION + lanes.phases + r) + i] = motion.absolute[r]
    for r in range(lanes.n - lanes.phases):
        w[8 * (rows.FLOOR + lanes.phases + r) + i] = motion.absolute[lanes.n_q + r]
    for r in range(lanes.phases):
        w[8 * (rows.POSITION + r) + i] = jobs.phases[job, r]
        w[8 * (rows.SPEED + r) + i] = jobs.phases[job, lanes.phases + r]
    scatter(lanes, motion, i)
    for r in range(lanes.n):
        if lanes.turning[r] != 0.0:
            angle = w[8 * (rows.POSITION + r) + i]
            w[8 * (rows.SINE + r) + i], w[8 * (rows.COSINE + r) + i] = sin(angle), cos(angle)


@inner
def event(functions, lanes, jobs, i):
    """Change the mode of a contact, or let the state jump, at the base point of a lane."""
    w, job = lanes.w, lanes.whole[8 * rows.JOB + i]
    work, options = work_at(jobs.work, 0), options_at(jobs.options, job)
    motion = trajectory_at(jobs.motions, job)
    gather(lanes, jobs, motion, i)
    at_base(work, options)
    motion.real[H], motion.real[H_VARIANT + IN_FLIGHT] = w[8 * rows.H_CONTROL + i], w[8 * rows.H_VARIANT + i]
    for variant in (SLIPPING, STICKING):  # in lanes one form of the equations has both
        motion.real[H_VARIANT + variant] = w[8 * (rows.H_VARIANT + SLIPPING) + i]
        motion.real[H_START + variant] = motion.real[H_START + SLIPPING]
    lanes.whole[8 * rows.EVENT_FOLLOWS + i] = 0
    plain_event(functions, work, motion, options, lanes.whole[8 * rows.AT + i])
    signed(jobs, motion, job)
    scatter(lanes, motion, i)
    w[8 * rows.SMOOTH + i], w[8 * rows.REJECTION + i], w[8 * rows.H_BEFORE + i] = 0.0, 0.0, 0.0
    w[8 * rows.H_LIMIT + i], w[8 * rows.SPECIAL + i], w[8 * rows.H_CONTROL + i] = 1e300, 1.0, motion.real[H]
    begin(lanes, i, motion.real[H])
    w[8 * rows.H + i] = w[8 * rows.H_NEXT + i]
    lanes.whole[8 * rows.FRESH + i] = 1
    if resting(motion) > 0 or motion.count[JAMMED] > 0:
        aside(lanes, jobs, i)


@inlined
def ends(lanes, jobs, i):
    """Whether the trajectory of a lane has ended; writes its status."""
    w, job = lanes.w, lanes.whole[8 * rows.JOB + i]
    motion, options = trajectory_at(jobs.motions, job), options_at(jobs.options, job)
    end, stop = w[8 * rows.END + i], options.stop_after
    if lanes.whole[8 * rows.PHASE + i] == DONE:
        return True
    if lanes.whole[8 * rows.PHASE + i] != STEPPING or w[8 * rows.CONTINUES + i] > 0.0:
        return False
    if at_end(w[8 * rows.T + i], end):
        w[8 * rows.T + i] = end
    if motion.count[CLOSE_EVENTS] >= CHATTER_COUNT:
        done(lanes, jobs, i, CHATTER + 0 * i)
    elif not (w[8 * rows.T + i] >= end or (stop > 0 and motion.count[SECTIONS] >= stop)):
        if w[8 * rows.LEFT + i] > 0.5:
            return False
        done(lanes, jobs, i, STEP_LIMIT + 0 * i)
    return True


@inner
def leave(functions, lanes, jobs, i):
    """Write down a finished trajectory; its lane is free."""
    job = lanes.whole[8 * rows.JOB + i]
    passes = jobs.place[rows.PASSED_BY] - lanes.whole[8 * rows.SINCE + i]
    motion = trajectory_at(jobs.motions, job)
    gather(lanes, jobs, motion, i)
    motion.count[STEPS] = int(lanes.w[8 * rows.STEPS + i])
    motion.count[EVALUATIONS] += (rows.UPDATES * STAGES + 1) * passes
    lanes.whole[8 * rows.JOB + i], lanes.whole[8 * rows.PHASE + i] = -1, STEPPING


UNIT = dict.fromkeys(("enter", "event", "leave"), PART)
