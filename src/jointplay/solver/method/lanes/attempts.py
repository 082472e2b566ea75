"""Attempts of one lane of an ensemble that need more than the step in lanes: failures, events, sections.

They are decided as method.events and method.sections decide those of one trajectory, on the step as that has
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
from ..memory import H_START, PASSED
from ..memory import LEVEL as SECTION_LEVEL
from ..memory import REJECTED as REJECTIONS
from ..sections import count_section, next_crossing
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
def special(f, e, j, i):
    """Decide what to do with an attempt of lane i that is not plain."""
    w, phase, verdict = e.w, e.whole[8 * rows.PHASE + i], _verdict(e.w, i)
    if verdict == 0:
        w[8 * rows.JOINED + i] = 1.0
        return
    job = e.whole[8 * rows.JOB + i]
    k, x, o = work_at(j.k, 0), trajectory_at(j.x, job), options_at(j.o, job)
    found, number = AGAIN, 0.0
    if verdict < 0:
        h = w[8 * rows.H + i] if phase == STEPPING else e.real[8 * rows.LENGTH + i]
        w[8 * rows.SMOOTH + i] = w[8 * rows.SMOOTH + i] if h > 0.2 * w[8 * rows.H_PAST + i] else 0.0
        w[8 * rows.H_LIMIT + i] = 0.75 * h
        found, number = FAILED, 0.5 * h
    elif phase == SECTION:
        found, number = _crossed(e, j, k, x, o, i)
    elif phase == ROOT:
        found, number = _located(e, j, k, x, o, i)
    else:
        found, number = _whole(e, j, k, x, o, i)
    if found == TAKEN:
        end, place = 1.0 + number / w[8 * rows.H + i], 2.0
        if phase != SECTION:
            place = _passing(e, k, x, o, i, end)
        _taken(e, i, number, place)
    elif found >= REJECTED:
        _shorten(e, j, x, o, i, number, found)
    elif found == MET:
        e.whole[8 * rows.MEETS + i] = 1


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
    hopeful = turned <= MAX_TURN and size < 1e10 and w[8 * rows.WAS_JOINED + i] == 0.0
    return 0 if hopeful and theta < 0.7 and size * theta * theta * theta <= NEWTON else -1


@inner
def begin(e, i, h):
    """Let the next attempt have the length h, within its bounds."""
    w, fast = e.w, e.w[8 * rows.SWIFT + i]
    for r in range(e.n):
        fast = max(fast, e.turning[r] * abs(w[8 * (rows.SPEED + r) + i]))
    w[8 * rows.H_NEXT + i] = bounded(h, fast, MAX_TURN, w[8 * rows.END + i] - w[8 * rows.T + i])


@inner
def _shorten(e, j, x, o, i, h, found):
    """Try again with length h, and count the rejection or failure."""
    w = e.w
    x.count[REJECTIONS if found == REJECTED else FAILURES] += 1
    e.whole[8 * rows.PHASE + i] = STEPPING
    w[8 * rows.LEFT + i] -= 1.0
    w[8 * rows.H_CONTROL + i], w[8 * rows.REJECTION + i], w[8 * rows.ODD + i] = h, 1.0, 1.0
    w[8 * rows.WITHIN + i] = 0.0
    begin(e, i, h)
    if not h > instant(w[8 * rows.T + i], o.near):
        gather(e, j, x, i)
        done(e, j, i, failure(x.s, len(x.absolute)))


@inner
def done(e, j, i, status):
    """The trajectory of a lane ends here."""
    e.whole[8 * rows.PHASE + i] = DONE
    j.status[e.whole[8 * rows.JOB + i]] = status


@inner
def aside(e, j, i):
    """The trajectory of a lane ends here, to be followed by itself."""
    done(e, j, i, rows.ASIDE + 0 * i)


@inner
def _first(e, k, x, o, i, doubt):
    """The guard that first leaves its side, and where in [0, 1]; -1 and 2.0 if none."""
    gather_guards(e, k, o, len(x.fired), i)
    set_cone_margins(k.w, o.guards, 7.0, x)
    return first_event(k, x, o, doubt, NEAR)


@spliced
def _whole(e, j, k, x, o, i):
    """An attempt that was to end anywhere: to be taken, or shorter up to its first event."""
    w, h, error = e.w, e.w[8 * rows.H + i], e.w[8 * rows.ERROR + i]
    if not error < 1.0:
        return REJECTED, h * (max(0.1, 0.9 * error ** (-1.0 / ORDER)) if error < 1e10 else 0.1)
    if w[8 * rows.CENTRE + i] > NEARING:
        aside(e, j, i)
        return AGAIN, 0.0
    if w[8 * rows.CENTRE + i] > AWAY:
        w[8 * rows.SMOOTH + i], w[8 * rows.H_LIMIT + i] = 0.0, 0.75 * h
        return FAILED, 0.5 * h
    if e.whole[8 * rows.FRESH + i]:
        at = H_START + int(w[8 * rows.VARIANT + i])
        x.real[at] = learnt(x.real[at], w[8 * rows.REJECTION + i] > 0.0, h, error)
        e.whole[8 * rows.FRESH + i] = 0
    g, place = -1, 2.0
    if w[8 * rows.LOW + i] < 0.0:  # else the lanes have seen that none leaves
        gather(e, j, x, i)
        g, place = _first(e, k, x, o, i, 0.0)
    e.whole[8 * rows.AT + i] = g
    if g < 0:
        return TAKEN, 0.0
    if place * h > instant(x.s[0], o.near):
        e.real[8 * rows.LENGTH + i], w[8 * rows.KEEP + i] = h, 1.0
        _, e.real[8 * rows.LEVEL + i] = level_to_leave(k, x, o, g, place)
        _again(e, i, ROOT, place * h)
        return AGAIN, 0.0
    if comes_back(x.fired[g], h, o.near):
        w[8 * rows.SMOOTH + i] = 0.0
        return FAILED, 0.5 * h
    w[8 * rows.STEPS + i] += 1.0
    w[8 * rows.LEFT + i] -= 1.0
    return MET, 0.0


@inlined
def _again(e, i, phase, h):
    """The next attempt is the same step, shorter."""
    w = e.w
    e.whole[8 * rows.PHASE + i], e.whole[8 * rows.TRIES + i] = phase, 0
    w[8 * rows.SMOOTH + i], w[8 * rows.OFFSET + i], w[8 * rows.ODD + i] = 1.0, 0.0, 1.0
    w[8 * rows.H_NEXT + i] = h


@spliced
def _located(e, j, k, x, o, i):
    """An attempt that was to end at a guard's root."""
    w, h, g, level = e.w, e.w[8 * rows.H + i], e.whole[8 * rows.AT + i], e.real[8 * rows.LEVEL + i]
    gather(e, j, x, i)
    earlier = 2.0
    if w[8 * rows.LOW + i] < 0.0:
        _, earlier = _first(e, k, x, o, i, ROUNDING)
    else:
        gather_guards(e, k, o, len(x.fired), i)
    row, side = o.guards + g, side_of(g, x.modes, x.flags)
    multiplicity, _ = start_of(k.w, 8 * row, g, side, x.fired, x.margin)
    later, there = at_root(k, x, o, row, multiplicity, level, g, NEAR_ROOT)
    if w[8 * rows.STRAINED + i] > 0.0:  # the tangent's iteration does not converge
        e.whole[8 * rows.TRIES + i] = REFINEMENTS
    elif there:
        if 1.0 + later - earlier <= TOGETHER + 10.0 * later * later:
            return TAKEN, later * h
        e.whole[8 * rows.TRIES + i] = REFINEMENTS
    return _nearer(e, i, corrected(h, later))


@inner
def _nearer(e, i, h):
    """Another attempt at a root, of length h; after too many a shorter step."""
    e.whole[8 * rows.TRIES + i] += 1
    if e.whole[8 * rows.TRIES + i] > REFINEMENTS:
        e.w[8 * rows.SMOOTH + i] = 0.0
        return FAILED, 0.5 * e.real[8 * rows.LENGTH + i]
    e.w[8 * rows.H_NEXT + i] = h
    return AGAIN, 0.0


@inner
def _passing(e, k, x, o, i, end):
    """Place up to `end` where the section is passed; 2.0 if it is not."""
    w, row, whole = e.w, o.guards + len(x.fired), 0 * i
    if not w[8 * rows.CROSSED + i] >= 0.0:
        return 2.0
    gather_position(e, k, row, e.crank, i)
    ahead = w[8 * rows.AHEAD + i] - w[8 * (rows.POSITION + e.crank) + i]
    place = next_crossing(k.w, row, whole, k.b, k.stack, ahead, -1.0, -int(w[8 * rows.DIRECTION + i]))
    return place if place <= end else 2.0


@spliced
def _taken(e, i, later, place):
    """Take the step, up to a guard's root if there is one, unless a section lies at a place in it."""
    w, h, guard = e.w, e.w[8 * rows.H + i], e.whole[8 * rows.AT + i]
    if guard < 0:
        w[8 * rows.KEEP + i] = 1.0
    if place <= 1.0:
        e.real[8 * rows.DELTA + i] = later
        if e.whole[8 * rows.PHASE + i] == STEPPING:
            e.real[8 * rows.LENGTH + i] = h
        _copy(w, e.stash, i)
        w[8 * rows.WITHIN + i] = 1.0
        _again(e, i, SECTION, max(place, 0.1 * AT_START) * h)
        return
    w[8 * rows.TAKEN + i], w[8 * rows.LATER + i] = 1.0, later
    w[8 * rows.WHOLE + i] = 1.0 if guard < 0 else 0.0
    e.whole[8 * rows.MEETS + i] = 0 if guard < 0 else 1
    e.whole[8 * rows.PHASE + i] = STEPPING


@spliced
def _crossed(e, j, k, x, o, i):
    """An attempt that was to end at the section; then the step that it lies in is taken."""
    w, job, h, at = e.w, e.whole[8 * rows.JOB + i], e.w[8 * rows.H + i], 8 * e.crank + i
    later = (w[8 * rows.AHEAD + i] - w[8 * rows.POSITION + at] - w[8 * rows.X + at]) / w[8 * rows.Y + at]
    if not abs(later) < max(NEAR_ROOT * h, AT_START * e.real[8 * rows.LENGTH + i]):
        return _nearer(e, i, h + min(max(later, -0.5 * h), 0.5 * h))
    gather(e, j, x, i)
    gather_step(e, k, o, i)
    count_section(k, x, o, x.s[0] + (h + later), 1.0 + later / h, -1.0, 0.0)
    signed(j, x, job)
    x.count[PASSED] += 1
    w[8 * rows.AHEAD + i] = x.real[SECTION_LEVEL] + x.count[PASSED] * o.period * o.direction
    _copy(e.stash, w, i)
    w[8 * rows.WITHIN + i] = 0.0
    return TAKEN, e.real[8 * rows.DELTA + i]


@inner
def _copy(source, to, i):
    """Copy the rows of a lane that settling a step needs."""
    for r in (rows.H, rows.ERROR, rows.WAS_JOINED, rows.PASSES):
        to[8 * r + i] = source[8 * r + i]
    for first_row, end in ((rows.X, rows.JACOBIAN), (rows.Z, rows.W), (rows.WATCHES, rows.STEP_END)):
        for at in range(8 * first_row + i, 8 * end, 8):
            to[at] = source[at]


UNIT = {"special": PART}
