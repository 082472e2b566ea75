"""Attempts of one lane of an ensemble that need more than the step in lanes: failures, events, sections.

As method.events and method.flow have it for one trajectory: the first guard that leaves its side on the
step's polynomial (with its margin), the step again up to that root, the check that no other guard leaves
earlier. The steps to a root are attempts like any others, beside those of other lanes; the last correction,
1e-5 of the step at most, is by Taylor's series.
"""

from math import inf

from ..control import bounded, converged, error_ratio, failure, instant, learnt
from ..events import AWAY, NEARING, REFINEMENTS, ROUNDING, TOGETHER, comes_back, corrected, correction
from ..interface import inlined, inner, spliced
from ..memory import SECTION_ROW
from . import layout as rows
from .guards import coefficients, first, level_to_leave, margin, passing
from .radau import MAX_TURN, NEWTON, STAGES, STALE
from .record import note, record_end

ORDER = 6  # of the error estimate in h
NEAR_ROOT = 1e-5  # of a step
NOTHING = 1e-6  # an update of this size ends Newton's iteration whatever came before
AT_START = 1e-8  # of a step: no section is looked for nearer to its base point
STEPPING, ROOT, SECTION, DONE = range(4)  # phases of a lane
# What is found of an attempt; with it goes a length, or what is LATER
AGAIN, MET, TAKEN, REJECTED, FAILED = range(5)


@spliced
def special(k, j, i):
    """An attempt of lane i that is not plain. True: an event follows when it is settled."""
    w, phase, verdict = k.w, k.whole[8 * rows.PHASE + i], _verdict(k.w, i)
    if verdict == 0:
        w[8 * rows.JOINED + i] = 1.0
        return False
    found, number = AGAIN, 0.0
    if verdict < 0:
        h = w[8 * rows.H + i] if phase == STEPPING else k.real[8 * rows.LENGTH + i]
        w[8 * rows.SMOOTH + i] = w[8 * rows.SMOOTH + i] if h > 0.2 * w[8 * rows.H_PAST + i] else 0.0
        w[8 * rows.H_LIMIT + i] = 0.75 * h
        found, number = FAILED, 0.5 * h
    elif phase == SECTION:
        found, number = _crossed(k, j, i)
    elif phase == ROOT:
        found, number = _located(k, i)
    else:
        found, number = _whole(k, j, i)
    if found == TAKEN:
        end, place = 1.0 + number / w[8 * rows.H + i], 2.0
        if phase != SECTION:
            place = passing(w, k.b, k.stack, k.crank, i, end)
        return _taken(k, i, number, place)
    if found >= REJECTED:
        _shorten(k, j, i, number, found)
    return found == MET


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
def begin(k, i, h):
    """Let the next attempt have the length h, within its bounds."""
    w, fast = k.w, k.w[8 * rows.SWIFT + i]
    for r in range(k.n):
        fast = max(fast, k.turning[r] * abs(w[8 * (rows.SPEED + r) + i]))
    w[8 * rows.H_NEXT + i] = bounded(h, fast, MAX_TURN, w[8 * rows.END + i] - w[8 * rows.T + i])


@inner
def _shorten(k, j, i, h, found):
    """Try again with length h, and count the rejection or failure."""
    w, job = k.w, k.whole[8 * rows.JOB + i]
    j.count[job, rows.C_REJECTED if found == REJECTED else rows.C_FAILED] += 1
    k.whole[8 * rows.PHASE + i] = STEPPING
    w[8 * rows.LEFT + i] -= 1.0
    w[8 * rows.H_CONTROL + i], w[8 * rows.REJECTION + i], w[8 * rows.ODD + i] = h, 1.0, 1.0
    w[8 * rows.WITHIN + i] = 0.0
    begin(k, i, h)
    if not h > instant(w[8 * rows.T + i], j.real[job, rows.J_NEAR]):
        k.whole[8 * rows.PHASE + i] = DONE
        j.count[job, rows.C_STATUS] = failure(w[8 * rows.POSITION + i :: 8], 2 * rows.N - 1)


@inner
def aside(k, j, i):
    """The trajectory of a lane ends here, to be followed by itself."""
    k.whole[8 * rows.PHASE + i] = DONE
    j.count[k.whole[8 * rows.JOB + i], rows.C_STATUS] = rows.ASIDE


@spliced
def _whole(k, j, i):
    """An attempt that was to end anywhere: to be taken, or shorter up to its first event."""
    w, h, error = k.w, k.w[8 * rows.H + i], k.w[8 * rows.ERROR + i]
    if not error < 1.0:
        return REJECTED, h * (max(0.1, 0.9 * error ** (-1.0 / ORDER)) if error < 1e10 else 0.1)
    if w[8 * rows.CENTRE + i] > NEARING:
        aside(k, j, i)
        return AGAIN, 0.0
    if w[8 * rows.CENTRE + i] > AWAY:
        w[8 * rows.SMOOTH + i], w[8 * rows.H_LIMIT + i] = 0.0, 0.75 * h
        return FAILED, 0.5 * h
    if k.whole[8 * rows.FRESH + i]:
        at = 8 * (rows.H_START + int(w[8 * rows.VARIANT + i])) + i
        k.real[at] = learnt(k.real[at], w[8 * rows.REJECTION + i] > 0.0, h, error)
        k.whole[8 * rows.FRESH + i] = 0
    g, place = -1, 2.0
    if w[8 * rows.LOW + i] < 0.0:  # else the lanes have seen that none leaves
        g, place = first(w, k.b, k.stack, k.contacts, i, 0.0)
    k.whole[8 * rows.AT + i] = g
    if g < 0:
        return TAKEN, 0.0
    near = j.real[k.whole[8 * rows.JOB + i], rows.J_NEAR]
    if place * h > instant(w[8 * rows.T + i], near):
        k.real[8 * rows.LENGTH + i], w[8 * rows.KEEP + i] = h, 1.0
        k.real[8 * rows.LEVEL + i] = level_to_leave(w, k.b, i, g, place)
        _again(k, i, ROOT, place * h)
        return AGAIN, 0.0
    if comes_back(w[8 * (rows.FIRED + g) + i], h, near):
        w[8 * rows.SMOOTH + i] = 0.0
        return FAILED, 0.5 * h
    w[8 * rows.STEPS + i] += 1.0
    w[8 * rows.LEFT + i] -= 1.0
    return MET, 0.0


@inlined
def _again(k, i, phase, h):
    """The next attempt is the same step, shorter."""
    w = k.w
    k.whole[8 * rows.PHASE + i], k.whole[8 * rows.TRIES + i] = phase, 0
    w[8 * rows.SMOOTH + i], w[8 * rows.OFFSET + i], w[8 * rows.ODD + i] = 1.0, 0.0, 1.0
    w[8 * rows.H_NEXT + i] = h


@spliced
def _located(k, i):
    """An attempt that was to end at a guard's root."""
    w, h, g, least = k.w, k.w[8 * rows.H + i], k.whole[8 * rows.AT + i], k.real[8 * rows.LEVEL + i]
    coefficients(w, 8 * (rows.WATCHES + g), w[8 * (rows.GUARD + g) + i], i, k.b)
    later = correction(k.b, STAGES + 0 * g, least)
    there = abs(least - k.b[STAGES]) < ROUNDING * margin(w, i, g)
    if w[8 * rows.STRAINED + i] > 0.0:  # the tangent's iteration does not converge
        k.whole[8 * rows.TRIES + i] = REFINEMENTS
    elif abs(later) < NEAR_ROOT or there:
        exact, earlier = later if abs(later) < NEAR_ROOT else 0.0, 2.0
        if w[8 * rows.LOW + i] < 0.0:
            _, earlier = first(w, k.b, k.stack, k.contacts, i, ROUNDING)
        if 1.0 + exact - earlier <= TOGETHER + 10.0 * exact * exact:
            return TAKEN, exact * h
        k.whole[8 * rows.TRIES + i] = REFINEMENTS
    return _nearer(k, i, corrected(h, later))


@inner
def _nearer(k, i, h):
    """Another attempt at a root, of length h; after too many a shorter step."""
    k.whole[8 * rows.TRIES + i] += 1
    if k.whole[8 * rows.TRIES + i] > REFINEMENTS:
        k.w[8 * rows.SMOOTH + i] = 0.0
        return FAILED, 0.5 * k.real[8 * rows.LENGTH + i]
    k.w[8 * rows.H_NEXT + i] = h
    return AGAIN, 0.0


@spliced
def _taken(k, i, later, place):
    """Take the step, up to a guard's root if there is one, unless a section lies at a place in it.

    True: an event follows.
    """
    w, h, guard = k.w, k.w[8 * rows.H + i], k.whole[8 * rows.AT + i]
    if guard < 0:
        w[8 * rows.KEEP + i] = 1.0
    if place <= 1.0:
        k.real[8 * rows.DELTA + i] = later
        if k.whole[8 * rows.PHASE + i] == STEPPING:
            k.real[8 * rows.LENGTH + i] = h
        _copy(w, k.stash, i)
        w[8 * rows.WITHIN + i] = 1.0
        _again(k, i, SECTION, max(place, 0.1 * AT_START) * h)
        return False
    w[8 * rows.TAKEN + i], w[8 * rows.LATER + i] = 1.0, later
    w[8 * rows.WHOLE + i] = 1.0 if guard < 0 else 0.0
    k.whole[8 * rows.PHASE + i] = STEPPING
    return guard >= 0


@spliced
def _crossed(k, j, i):
    """An attempt that was to end at the section; then the step that it lies in is taken."""
    w, job, h = k.w, k.whole[8 * rows.JOB + i], k.w[8 * rows.H + i]
    at = 8 * k.crank + i
    later = (w[8 * rows.AHEAD + i] - w[8 * rows.POSITION + at] - w[8 * rows.X + at]) / w[8 * rows.Y + at]
    if not abs(later) < max(NEAR_ROOT * h, AT_START * k.real[8 * rows.LENGTH + i]):
        return _nearer(k, i, h + min(max(later, -0.5 * h), 0.5 * h))
    j.count[job, rows.C_SECTIONS] += 1
    if j.count[job, rows.C_SECTIONS] > j.whole[job, rows.J_SKIP]:
        record_end(k, i, j.log[j.place[rows.LOGGED], rows.COLUMNS :], later)
        note(k, j, i, float(SECTION_ROW), -1.0, 0.0)
    k.whole[8 * rows.PASSED + i] += 1
    passed = k.whole[8 * rows.PASSED + i] * j.real[job, rows.J_PERIOD] * w[8 * rows.DIRECTION + i]
    w[8 * rows.AHEAD + i] = j.real[job, rows.J_LEVEL] + passed if j.real[job, rows.J_PERIOD] > 0.0 else inf
    _copy(k.stash, w, i)
    w[8 * rows.WITHIN + i] = 0.0
    return TAKEN, k.real[8 * rows.DELTA + i]


@inner
def _copy(source, to, i):
    """Copy the rows of a lane that settling a step needs."""
    for r in (rows.H, rows.ERROR, rows.WAS_JOINED, rows.PASSES):
        to[8 * r + i] = source[8 * r + i]
    for first_row, end in ((rows.X, rows.JACOBIAN), (rows.Z, rows.W), (rows.WATCHES, rows.STEP_END)):
        for at in range(8 * first_row + i, 8 * end, 8):
            to[at] = source[at]
