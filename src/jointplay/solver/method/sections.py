"""Sections: the states in which a motion passes a level of some quantity, apart from the steps it takes.

A crossing within a step is located as an event is, by a shorter step of the method itself; afterwards the
whole step is brought back, so that looking does not change the motion. A level that moves on by a period at
each crossing (the crank's angle, a turn on) is watched from one side only; any other from the side on which
the quantity is. A jump across the level, as of a force at contact, is a crossing at the event.
"""

from .codes import Section
from .events import locate
from .interface import inner
from .memory import LEVEL, PASSED, SECTION_ROW, SECTIONS, SIDE, T_SECTION
from .polynomial import TO_ROUNDING, bernstein, first_root, keep_right
from .radau import NODES
from .record import note
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
def sections(f, variant, k, x, o, h, end):
    """Level crossings within the step, up to the place `end`; each is located by a step of its own."""
    count, real, at = x.count, x.real, 8 * (o.first + 1)
    row, place = o.guards + len(x.fired), -1.0
    whole = 0 * o.n  # no root is divided out; a variable, for the reason that interface gives
    none = whole - 1  # it is no guard's row
    if count[SIDE] == 0:
        ahead = o.period == 0.0 and (k.w[8 * row + 7] - real[LEVEL]) * o.direction >= 0.0
        count[SIDE] = o.direction if ahead else -o.direction
    for _ in range(SECTIONS_A_STEP):
        after = place if o.period == 0.0 else -1.0
        level = real[LEVEL] + count[PASSED] * o.period * o.direction  # a sum would drift
        place = next_crossing(k.w, row, whole, k.b, k.stack, level, after, count[SIDE])
        if place > end or (o.stop_after and count[SECTIONS] >= o.stop_after):
            return
        if count[SIDE] == -o.direction and x.s[0] + place * h - real[T_SECTION] > 1e-3 * o.near:
            keep(k.w, at, k.whole)
            near = max(place, 1e-12)
            length, root, sure = locate(f, variant, k, x, o, h, near, row, whole, level, none)
            if not sure:  # the step's own polynomial is the best that there is
                _bring_back(k.whole, k.w, at - 8, h)
                length, root = h, place
            real[T_SECTION] = x.s[0] + length * root
            count_section(k, x, o, real[T_SECTION], root, -1.0, 0.0)
            _bring_back(k.whole, k.w, at - 8, h)
            f.rate(variant, k.w, x.s, x.p, x.m)
        if o.period == 0.0:
            count[SIDE] = -count[SIDE]
        count[PASSED] += 1


@inner
def count_event(k, x, o, j, kind, time):
    """A section point, if events of that kind make the section."""
    watched = o.section_contact < 0 or o.section_contact == j
    if o.section == BY_EVENT and kind == o.section_event and watched:
        count_section(k, x, o, time, 0.0, float(j), float(kind))


@inner
def count_section(k, x, o, time, place, contact, kind):
    """A section point: logged after the first `skip`."""
    x.count[SECTIONS] += 1
    if x.count[SECTIONS] > o.skip:
        note(k, x, o, SECTION_ROW, contact, kind, time, place)
