"""Sections: the states in which a motion passes a level of some quantity, apart from the steps it takes.

A crossing within a step is located as an event is, by a shorter step of the method itself; afterwards the
whole step is brought back, so that looking does not change the motion. A level that moves on by a period at
each crossing (the crank's angle, a turn on) is watched from one side only; any other from the side on which
the quantity is. A jump across the level, as of a force at contact, is a crossing at the event.
"""

from .codes import Section
from .events import locate
from .interface import inner
from .memory import LEVEL, LEVELS_PASSED, SECTION_ROW, SECTION_SIDE, SECTIONS, T_SECTION
from .polynomial import TO_ROUNDING, bernstein, first_root, keep_right
from .radau import NODES
from .record import gains, note
from .step import keep

SECTIONS_A_STEP = 8
_, _, BY_EVENT = Section.numbers()


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
def sections(functions, variant, work, motion, options, h, end):
    """Level crossings within the step, up to the place `end`; each is located by a step of its own."""
    count, real, at = motion.count, motion.real, 8 * (options.first + 1)
    row, place = options.guards + len(motion.fired), -1.0
    whole = 0 * options.n  # no root is divided out; a variable, for the reason that interface gives
    none = whole - 1  # it is no guard's row
    if count[SECTION_SIDE] == 0:
        ahead = options.period == 0.0 and (work.w[8 * row + 7] - real[LEVEL]) * options.direction >= 0.0
        count[SECTION_SIDE] = options.direction if ahead else -options.direction
    for _ in range(SECTIONS_A_STEP):
        after = place if options.period == 0.0 else -1.0
        level = real[LEVEL] + count[LEVELS_PASSED] * options.period * options.direction  # a sum would drift
        place = next_crossing(work.w, row, whole, work.b, work.stack, level, after, count[SECTION_SIDE])
        if place > end or (options.stop_after and count[SECTIONS] >= options.stop_after):
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
