"""Attempts of one lane of an ensemble that need more than the step in lanes: failures, events, sections.

They are decided as method.events and method.record decide those of one trajectory, on the step as that has
it (exchange). The steps to a root are attempts like any others, beside those of other lanes; the last
correction, 1e-5 of the step at most, is by Taylor's series.
"""

from ..control import bounded, converged, error_ratio, failure, instant, learnt
from ..events import (
    AWAY,
    NEARING,
    REFINEMENTS,
    ROUNDING,
    TOGETHER,
    at_root,
    comes_back,
    corrected,
    first_event,
    level_to_leave,
    set_cone_margins,
    side_of,
    start_of,
)
from ..interface import inlined, inner, options_at, spliced, trajectory_at, work_at
from ..memory import FAILED as FAILURES
from ..memory import H_START, LEVELS_PASSED
from ..memory import LEVEL as SECTION_LEVEL
from ..memory import REJECTED as REJECTIONS
from ..record import count_section, next_crossing
from . import layout as rows
from .exchange import gather, gather_guards, gather_position, gather_step, signed
from .memory import PART
from .radau import MAX_TURN, NEWTON, STALE

ORDER = 6  # of the error estimate in h
NEAR_ROOT, NEAR = 1e-5, 1e-8  # of a step: where an attempt at a root may end; of the step's polynomial
NOTHING = 1e-6  # an update of this size ends Newton's iteration whatever came before
AT_START = 1e-8  # of a step: no section is looked for nearer to its base point
STEPPING, ROOT, SECTION, DONE = range(4)  # phases of a lane
# What is found of an attempt; with it goes a length, or what is LATER
AGAIN, MET, TAKEN, REJECTED, FAILED = range(5)


@inner
def special(functions, lanes, jobs, i):
    """Decide what to do with an attempt of lane i that is not plain."""
    w, phase, verdict = lanes.w, lanes.whole[8 * rows.PHASE + i], _verdict(lanes.w, i)
    if verdict == 0:
        w[8 * rows.CONTINUES + i] = 1.0
        return
    job = lanes.whole[8 * rows.JOB + i]
    work, options = work_at(jobs.work, 0), options_at(jobs.options, job)
    motion = trajectory_at(jobs.motions, job)
    found, number = AGAIN, 0.0
    if verdict < 0:
        h = w[8 * rows.H + i] if phase == STEPPING else lanes.real[8 * rows.LENGTH + i]
        w[8 * rows.SMOOTH + i] = w[8 * rows.SMOOTH + i] if h > 0.2 * w[8 * rows.H_PAST + i] else 0.0
        w[8 * rows.H_LIMIT + i] = 0.75 * h
        found, number = FAILED, 0.5 * h
    elif phase == SECTION:
        found, number = _crossed(lanes, jobs, work, motion, options, i)
    elif phase == ROOT:
        found, number = _located(lanes, jobs, work, motion, options, i)
    else:
        found, number = _whole(lanes, jobs, work, motion, options, i)
    if found == TAKEN:
        end, place = 1.0 + number / w[8 * rows.H + i], 2.0
        if phase != SECTION:
            place = _passing(lanes, work, motion, options, i, end)
        _taken(lanes, i, number, place)
    elif found >= REJECTED:
        _shorten(lanes, jobs, motion, options, i, number, found)
    elif found == MET:
        lanes.whole[8 * rows.EVENT_FOLLOWS + i] = 1


@inlined
def solved(size, before, turned):
    """Whether Newton's iteration has converged, and no angle turned too far; also of all lanes at once."""
    return turned <= MAX_TURN and (
        size < NOTHING or converged(size, error_ratio(size / before), NEWTON, STALE)
    )


@inner
def _verdict(w, i):
    """State of Newton's iteration: 1 converged, 0 worth more updates, -1 failed."""
    size, before, turned = w[8 * rows.SIZE + i], w[8 * rows.SIZE_BEFORE + i], w[8 * rows.TURNED + i]
    if solved(size, before, turned):
        return 1
    theta = size / before
    hopeful = turned <= MAX_TURN and size < 1e10 and w[8 * rows.CONTINUED + i] == 0.0
    return 0 if hopeful and theta < 0.7 and size * theta * theta * theta <= NEWTON else -1


@inner
def begin(lanes, i, h):
    """Let the next attempt have the length h, within its bounds."""
    w, fast = lanes.w, lanes.w[8 * rows.TURN_SPEED + i]
    for r in range(lanes.n):
        fast = max(fast, lanes.turning[r] * abs(w[8 * (rows.SPEED + r) + i]))
    w[8 * rows.H_NEXT + i] = bounded(h, fast, MAX_TURN, w[8 * rows.END + i] - w[8 * rows.T + i])


@inner
def _shorten(lanes, jobs, motion, options, i, h, found):
    """Try again with length h, and count the rejection or failure."""
    w = lanes.w
    motion.count[REJECTIONS if found == REJECTED else FAILURES] += 1
    lanes.whole[8 * rows.PHASE + i] = STEPPING
    w[8 * rows.LEFT + i] -= 1.0
    w[8 * rows.H_CONTROL + i], w[8 * rows.REJECTION + i], w[8 * rows.SPECIAL + i] = h, 1.0, 1.0
    w[8 * rows.STASHED + i] = 0.0
    begin(lanes, i, h)
    if not h > instant(w[8 * rows.T + i], options.chatter_time):
        gather(lanes, jobs, motion, i)
        done(lanes, jobs, i, failure(motion.s, len(motion.absolute)))


@inner
def done(lanes, jobs, i, status):
    """The trajectory of a lane ends here."""
    lanes.whole[8 * rows.PHASE + i] = DONE
    jobs.status[lanes.whole[8 * rows.JOB + i]] = status


@inner
def aside(lanes, jobs, i):
    """The trajectory of a lane ends here, to be followed by itself."""
    done(lanes, jobs, i, rows.ASIDE + 0 * i)


@inner
def _first(lanes, work, motion, options, i, slack):
    """The guard that first leaves its side, and where in [0, 1]; -1 and 2.0 if none."""
    gather_guards(lanes, work, options, len(motion.fired), i)
    set_cone_margins(work.w, options.guards, 7.0, motion)
    return first_event(work, motion, options, slack, NEAR)


@spliced
def _whole(lanes, jobs, work, motion, options, i):
    """An attempt that was to end anywhere: to be taken, or shorter up to its first event."""
    w, h, error = lanes.w, lanes.w[8 * rows.H + i], lanes.w[8 * rows.ERROR + i]
    if not error < 1.0:
        return REJECTED, h * (max(0.1, 0.9 * error ** (-1.0 / ORDER)) if error < 1e10 else 0.1)
    if w[8 * rows.CENTRE + i] > NEARING:
        aside(lanes, jobs, i)
        return AGAIN, 0.0
    if w[8 * rows.CENTRE + i] > AWAY:
        w[8 * rows.SMOOTH + i], w[8 * rows.H_LIMIT + i] = 0.0, 0.75 * h
        return FAILED, 0.5 * h
    if lanes.whole[8 * rows.FRESH + i]:
        at = H_START + int(w[8 * rows.VARIANT + i])
        motion.real[at] = learnt(motion.real[at], w[8 * rows.REJECTION + i] > 0.0, h, error)
        lanes.whole[8 * rows.FRESH + i] = 0
    g, place = -1, 2.0
    if w[8 * rows.LOW + i] < 0.0:  # else the lanes have seen that none leaves
        gather(lanes, jobs, motion, i)
        g, place = _first(lanes, work, motion, options, i, 0.0)
    lanes.whole[8 * rows.AT + i] = g
    if g < 0:
        return TAKEN, 0.0
    if place * h > instant(motion.s[0], options.chatter_time):
        lanes.real[8 * rows.LENGTH + i], w[8 * rows.KEEP + i] = h, 1.0
        _, lanes.real[8 * rows.LEVEL + i] = level_to_leave(work, motion, options, g, place)
        _again(lanes, i, ROOT, place * h)
        return AGAIN, 0.0
    if comes_back(motion.fired[g], h, options.chatter_time):
        w[8 * rows.SMOOTH + i] = 0.0
        return FAILED, 0.5 * h
    w[8 * rows.STEPS + i] += 1.0
    w[8 * rows.LEFT + i] -= 1.0
    return MET, 0.0


@inlined
def _again(lanes, i, phase, h):
    """The next attempt is the same step, shorter."""
    w = lanes.w
    lanes.whole[8 * rows.PHASE + i], lanes.whole[8 * rows.TRIES + i] = phase, 0
    w[8 * rows.SMOOTH + i], w[8 * rows.OFFSET + i], w[8 * rows.SPECIAL + i] = 1.0, 0.0, 1.0
    w[8 * rows.H_NEXT + i] = h


@spliced
def _located(lanes, jobs, work, motion, options, i):
    """An attempt that was to end at a guard's root."""
    w, h = lanes.w, lanes.w[8 * rows.H + i]
    g, level = lanes.whole[8 * rows.AT + i], lanes.real[8 * rows.LEVEL + i]
    gather(lanes, jobs, motion, i)
    earlier = 2.0
    if w[8 * rows.LOW + i] < 0.0:
        _, earlier = _first(lanes, work, motion, options, i, ROUNDING)
    else:
        gather_guards(lanes, work, options, len(motion.fired), i)
    row, side = options.guards + g, side_of(g, motion.modes, motion.flags)
    multiplicity, _ = start_of(work.w, 8 * row, g, side, motion.fired, motion.margin)
    later, there = at_root(work, motion, options, row, multiplicity, level, g, NEAR_ROOT)
    if w[8 * rows.STRAINED + i] > 0.0:  # the tangent's iteration does not converge
        lanes.whole[8 * rows.TRIES + i] = REFINEMENTS
    elif there:
        if 1.0 + later - earlier <= TOGETHER + 10.0 * later * later:
            return TAKEN, later * h
        lanes.whole[8 * rows.TRIES + i] = REFINEMENTS
    return _nearer(lanes, i, corrected(h, later))


@inner
def _nearer(lanes, i, h):
    """Another attempt at a root, of length h; after too many a shorter step."""
    lanes.whole[8 * rows.TRIES + i] += 1
    if lanes.whole[8 * rows.TRIES + i] > REFINEMENTS:
        lanes.w[8 * rows.SMOOTH + i] = 0.0
        return FAILED, 0.5 * lanes.real[8 * rows.LENGTH + i]
    lanes.w[8 * rows.H_NEXT + i] = h
    return AGAIN, 0.0


@inner
def _passing(lanes, work, motion, options, i, end):
    """Place up to `end` where the section is passed; 2.0 if it is not."""
    w, row, whole = lanes.w, options.guards + len(motion.fired), 0 * i
    if not w[8 * rows.CROSSED + i] >= 0.0:
        return 2.0
    gather_position(lanes, work, row, lanes.crank, i)
    ahead = w[8 * rows.AHEAD + i] - w[8 * (rows.POSITION + lanes.crank) + i]
    place = next_crossing(
        work.w, row, whole, work.b, work.stack, ahead, -1.0, -int(w[8 * rows.DIRECTION + i])
    )
    return place if place <= end else 2.0


@spliced
def _taken(lanes, i, later, place):
    """Take the step, up to a guard's root if there is one, unless a section lies at a place in it."""
    w, h, guard = lanes.w, lanes.w[8 * rows.H + i], lanes.whole[8 * rows.AT + i]
    if guard < 0:
        w[8 * rows.KEEP + i] = 1.0
    if place <= 1.0:
        lanes.real[8 * rows.DELTA + i] = later
        if lanes.whole[8 * rows.PHASE + i] == STEPPING:
            lanes.real[8 * rows.LENGTH + i] = h
        _copy(w, lanes.stash, i)
        w[8 * rows.STASHED + i] = 1.0
        _again(lanes, i, SECTION, max(place, 0.1 * AT_START) * h)
        return
    w[8 * rows.TAKEN + i], w[8 * rows.LATER + i] = 1.0, later
    w[8 * rows.WHOLE + i] = 1.0 if guard < 0 else 0.0
    lanes.whole[8 * rows.EVENT_FOLLOWS + i] = 0 if guard < 0 else 1
    lanes.whole[8 * rows.PHASE + i] = STEPPING


@spliced
def _crossed(lanes, jobs, work, motion, options, i):
    """An attempt that was to end at the section; then the step that it lies in is taken."""
    w, job, h, at = lanes.w, lanes.whole[8 * rows.JOB + i], lanes.w[8 * rows.H + i], 8 * lanes.crank + i
    later = (w[8 * rows.AHEAD + i] - w[8 * rows.POSITION + at] - w[8 * rows.X + at]) / w[8 * rows.Y + at]
    if not abs(later) < max(NEAR_ROOT * h, AT_START * lanes.real[8 * rows.LENGTH + i]):
        return _nearer(lanes, i, h + min(max(later, -0.5 * h), 0.5 * h))
    gather(lanes, jobs, motion, i)
    gather_step(lanes, work, options, i)
    count_section(work, motion, options, motion.s[0] + (h + later), 1.0 + later / h, -1.0, 0.0)
    signed(jobs, motion, job)
    motion.count[LEVELS_PASSED] += 1
    passed = motion.count[LEVELS_PASSED]
    w[8 * rows.AHEAD + i] = motion.real[SECTION_LEVEL] + passed * options.period * options.direction
    _copy(lanes.stash, w, i)
    w[8 * rows.STASHED + i] = 0.0
    return TAKEN, lanes.real[8 * rows.DELTA + i]


@inner
def _copy(source, to, i):
    """Copy the rows of a lane that settling a step needs."""
    for r in (rows.H, rows.ERROR, rows.CONTINUED, rows.PASSES):
        to[8 * r + i] = source[8 * r + i]
    for first_row, end in ((rows.X, rows.JACOBIAN), (rows.Z, rows.W), (rows.WATCHES, rows.STEP_END)):
        for at in range(8 * first_row + i, 8 * end, 8):
            to[at] = source[at]


UNIT = {"special": PART}
