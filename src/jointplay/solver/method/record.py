"""Records of a run: samples at given times; a log of steps, events, sections and closest approaches.

As a parameter changes, a closest approach in flight reaches zero and a new contact begins (grazing). They are
extrema of the step's polynomial, found as its derivative's roots, so that none is stepped over.

Sections: the states in which a motion passes a level of some quantity, apart from the steps it takes.

A crossing within a step is located as an event is, by a shorter step of the method itself; afterwards the
whole step is brought back, so that looking does not change the motion. A level that moves on by a period at
each crossing (the crank's angle, a turn on) is watched from one side only; any other from the side on which
the quantity is, and is passed where the quantity goes beyond it by more than rounding: what rests at it does
not. A jump across the level, as of a force at contact, is a crossing at the event.

Coarse steps: steps whose recorded rates may be off are noted, and retaken in shorter ones (retake).
"""

from .codes import Section
from .events import locate, state_at
from .interface import inner
from .memory import (
    COARSE_ROW,
    COARSENESS,
    COLUMNS,
    FARTHEST,
    LEVEL,
    LEVELS_PASSED,
    LOGGED,
    MISS_ROW,
    SECTION_ROW,
    SECTION_SIDE,
    SECTIONS,
    T_SECTION,
)
from .modes import FREE, GAP, RELEASED, STICK
from .polynomial import (
    TO_ROUNDING,
    basis,
    bernstein,
    differentiate,
    first_root,
    interpolate,
    keep_right,
    next_extremum,
)
from .radau import COLLOCATION, ERROR, GAMMA, NODES
from .step import keep

SECTIONS_A_STEP = 8
# Tolerated errors of the farthest from the level: what goes less beyond it touches; if held, it rests there
PASSED, HELD = 1.0, 1e3
CONSTANT = 1e-12  # of the level: roundings of a quantity that lies there
_, _, BY_EVENT = Section.numbers()

KEPT = 0.5  # share of a decay that the polynomial keeps at most, soon after the step's beginning
MISSED = 0.15  # times h / gamma and the slope's error at the beginning: largest error between the stages
FIRED, END, TIME = 0, 1, 2  # columns of a coarse step
FADING = 0.1  # share of its coarseness that a step leaves to the next


@inner
def gains(w, row, h, gain):
    """Increments h A P of the work at the stages of a step, its powers P in lane rows from `row` on."""
    for r in range(len(gain) // 8):
        for i in range(8):
            total = 0.0
            for j in range(7):
                total += COLLOCATION[8 * j + i] * w[8 * (row + r) + j]
            gain[8 * r + i] = h * total


@inner
def write(row, time, place, w, at, s, n_x, b, modes, gain, work):
    """One record: time, state at `place` of the step whose increments begin at w[at], modes, work."""
    row[0] = time
    state_at(w, at, s, n_x, place, b, row)
    to = 1 + n_x
    for j in range(len(modes)):
        row[to + j] = modes[j]
    start = 0 * n_x  # a variable, for the reason that interface gives
    interpolate(gain, start, work, start, len(work), b, row[to + len(modes) :])


@inner
def sample(samples, times, i, h, end, w, at, s, n_x, b, modes, gain, work):
    """Samples at given times from number i on within the step of length h, up to `end`; the next number."""
    while i < len(times) and times[i] <= end:
        write(samples[i], times[i], (times[i] - s[0]) / h, w, at, s, n_x, b, modes, gain, work)
        i += 1
    return i


@inner
def note(work, motion, options, tag, contact, kind, time, place):
    """Add a log row: its tag, contact and kind, then the record."""
    row, at, n_x = motion.log[motion.count[LOGGED]], 8 * (options.first + 1), options.n_q + options.n
    row[0], row[1], row[2] = tag, contact, kind
    write(row[COLUMNS:], time, place, work.w, at, motion.s, n_x, work.b, motion.modes, work.gain, motion.work)
    motion.count[LOGGED] += 1


@inner
def closest_approaches(work, motion, options, h, end):
    """Log the closest approaches of every open gap within the step of length h, up to its place `end`."""
    modes, contacts = motion.modes, len(motion.flags)
    for g in range(len(motion.fired)):
        j, row = g // 4, 8 * (options.guards + g)
        wall = g - 4 * contacts
        if wall >= 0:
            if wall < len(modes) - contacts and modes[contacts + wall] == FREE:
                _of_gap(work, motion, options, h, end, row, -1.0, contacts + wall)
        elif modes[j] == FREE and g % 4 == GAP:
            _of_gap(work, motion, options, h, end, row, 1.0, j)


@inner
def _of_gap(work, motion, options, h, end, row, rising, contact):
    """`rising`: sign of the guard's slope on the way to contact. The gap goes where events have kinds."""
    b = work.b
    whole = 0 * options.n  # no root is divided out; a variable, for the reason that interface gives
    degree, side = differentiate(b, bernstein(work.w, row, whole, b))
    at, degree = next_extremum(b, degree, 0.0, side, end, work.stack)
    while at <= 1.0:
        if side * rising > 0.0 and motion.s[0] + h * at >= options.log_from:
            basis(at, b)
            gap = 0.0
            for i in range(8):
                gap += b[8 + i] * work.w[row + i]
            note(work, motion, options, MISS_ROW, float(contact), -rising * gap, motion.s[0] + h * at, at)
        side = -side
        at, degree = next_extremum(b, degree, at, side, end, work.stack)


@inner
def _bring_back(source, w, at, h):
    """Copy the increments of a step of length h back to the lane buffer, the time's at w[at]."""
    for i in range(8):
        w[at + i] = h * NODES[i]
    for i in range(len(source)):
        w[at + 8 + i] = source[i]


@inner
def next_crossing(w, row, multiplicity, b, stack, level, after, side):
    """Place of the next crossing of `level` from `side`, after one at `after` (< 0: none); 2.0 if none."""
    degree = bernstein(w, 8 * row, multiplicity, b)
    for i in range(degree + 1):
        b[i] -= level
    if after >= 0.0:
        degree = keep_right(b, degree, after)
    place = first_root(b, degree, side, stack, TO_ROUNDING)
    return place if after < 0.0 or place > 1.0 else after + place * (1.0 - after)


@inner
def _held(motion):
    """Whether a contact sticks, or a body rests on a wall: it keeps some quantity at a value."""
    for j in range(len(motion.modes)):
        if motion.modes[j] == STICK or (j >= len(motion.flags) and motion.modes[j] > RELEASED):
            return True
    return False


@inner
def sections(functions, variant, work, motion, options, h, end):
    """Level crossings within the step, up to the place `end`; each is located by a step of its own."""
    count, real, at = motion.count, motion.real, 8 * (options.first + 1)
    row, place = options.guards + len(motion.fired), -1.0
    whole = 0 * options.n  # no root is divided out; a variable, for the reason that interface gives
    none = whole - 1  # it is no guard's row
    away, tolerance = 0.0, motion.relative[options.n_q]
    for i in range(8):
        away = max(away, abs(work.w[8 * row + i] - real[LEVEL]))
    real[FARTHEST] = max(real[FARTHEST], away)
    if away <= CONSTANT * abs(real[LEVEL]) or (away < HELD * tolerance * real[FARTHEST] and _held(motion)):
        return
    if count[SECTION_SIDE] == 0:
        ahead = options.period == 0.0 and (work.w[8 * row + 7] - real[LEVEL]) * options.direction >= 0.0
        count[SECTION_SIDE] = options.direction if ahead else -options.direction
    for _ in range(SECTIONS_A_STEP):
        after = place if options.period == 0.0 else -1.0
        level = real[LEVEL] + count[LEVELS_PASSED] * options.period * options.direction  # a sum would drift
        side = count[SECTION_SIDE]
        place = next_crossing(work.w, row, whole, work.b, work.stack, level, after, side)
        if place > end or (options.stop_after and count[SECTIONS] >= options.stop_after):
            return
        if options.period == 0.0:
            beyond = level - side * PASSED * tolerance * real[FARTHEST]
            if next_crossing(work.w, row, whole, work.b, work.stack, beyond, -1.0, side) > end:
                return
        later = motion.s[0] + place * h - real[T_SECTION]
        if count[SECTION_SIDE] == -options.direction and later > 1e-3 * options.chatter_time:
            keep(work.w, at, work.whole)
            length, root, sure = locate(
                functions, variant, work, motion, options, h, max(place, 1e-12), row, whole, level, none
            )
            if not sure:  # the step's own polynomial is the best that there is
                _bring_back(work.whole, work.w, at - 8, h)
                length, root = h, place
            else:
                gains(work.w, row + 1, length, work.gain)
            real[T_SECTION] = motion.s[0] + length * root
            count_section(work, motion, options, real[T_SECTION], root, -1.0, 0.0)
            _bring_back(work.whole, work.w, at - 8, h)
            functions.rate(variant, work.w, motion.s, motion.p, motion.m)
            gains(work.w, row + 1, h, work.gain)
        if options.period == 0.0:
            count[SECTION_SIDE] = -count[SECTION_SIDE]
        count[LEVELS_PASSED] += 1


@inner
def count_event(work, motion, options, j, kind, time):
    """A section point, if events of that kind make the section."""
    watched = options.section_contact < 0 or options.section_contact == j
    if options.section == BY_EVENT and kind == options.section_event and watched:
        count_section(work, motion, options, time, 0.0, float(j), float(kind))


@inner
def count_section(work, motion, options, time, place, contact, kind):
    """A section point: logged after the first `skip`."""
    motion.count[SECTIONS] += 1
    if motion.count[SECTIONS] > options.skip:
        note(work, motion, options, SECTION_ROW, contact, kind, time, place)


@inner
def is_coarse(work, motion, options, h):
    """Whether rates of angles on the step of length h may be off by more than is tolerated (rate_tolerance).

    At its base point the rate differs from the polynomial's slope. What of that the error's filter
    (I - h J / gamma)^-1 takes away is the rate of components that the step passes over: decays, of which the
    polynomial keeps a part. Between the stages it also misses the slow motion of these components, by a
    share of h times that difference, and rates by as many times more as the filter made it smaller. Now and
    then that difference passes zero at the base point itself: what was coarse a step before still is.
    """
    at, span, coarseness = 8 * (options.first + 1 + options.n_q), h / GAMMA, FADING * motion.real[COARSENESS]
    for r in range(options.n):
        slope = work.w[at + 8 * (options.n + r) + 7]
        for i in range(7):
            slope += ERROR[i] * work.w[at + 8 * r + i] / span
        slow = work.error[options.n_q + r] / span
        off = motion.turning[r] * abs(slope - slow) * max(KEPT * abs(slow), MISSED * abs(slope))
        off, allowed = off * work.weight[options.n_q + r], options.rate_tolerance * abs(slow)
        if off > allowed:
            coarseness = max(coarseness, off / allowed if allowed > 0.0 else 1.0 / FADING)
    motion.real[COARSENESS] = coarseness
    return coarseness > 1.0


@inner
def note_coarse(work, motion, options, end):
    """Note a coarse step: its base point, the guards fired there (a number to base 4), its end."""
    fired, digit = 0.0, 1.0
    for g in range(len(motion.fired)):
        fired += digit * motion.fired[g]
        digit *= 4.0
    note(work, motion, options, COARSE_ROW, fired, end, motion.s[0], 0.0)
