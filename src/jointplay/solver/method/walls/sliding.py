"""Sliding on rigid walls: slip, its end and its reversal, sticking and its end.

Where a body rests on a rough wall it slips with friction f times the push, or sticks up to that. At v_t = 0
the two one-sided accelerations decide, as at any contact (method.modes). With much friction the wall may
have to pull in one sense of slip: the body sticks then, if that holds it within the cone. Corners of one
guide on which a slider rests slide as one, and share what they may hold.
"""

from ..interface import inner
from ..modes import (
    RELEASED,
    RESTING,
    SLIP_NEGATIVE,
    SLIP_ONSET,
    SLIP_POSITIVE,
    SLIP_REVERSAL,
    STICK,
    STICK_ONSET,
    balance,
    look,
)
from .impacts import rough


@inner
def walls_of(x):
    """Number of rigid walls; their modes follow the contacts' modes."""
    return len(x.modes) - len(x.flags)


@inner
def sliding(k, x, o, j):
    """Mode of a body that rests on wall j, by its present sliding speed."""
    if not rough(x, j):
        return RESTING
    v_t = k.contact[6 * (len(x.modes) + j) + 2]
    return RESTING if abs(v_t) <= o.rest else (SLIP_POSITIVE if v_t > 0.0 else SLIP_NEGATIVE)


@inner
def _together(x, j, mode, fired, margin):
    """Set the mode of wall j, and of all in its guide on which the body rests: they slide as one."""
    for i in range(walls_of(x)):
        at, rub = len(x.flags) + i, 4 * len(x.flags) + walls_of(x) + i
        if i == j or (x.group[i] == x.group[j] and x.modes[at] > RELEASED):
            x.modes[at], x.fired[rub], x.margin[rub] = mode, fired, margin


@inner
def _holds(k, x, j):
    """Whether a body that sticks to wall j, and others of its guide, is pressed within the friction cone."""
    push, friction = 0.0, 0.0
    for i in range(walls_of(x)):
        if x.group[i] == x.group[j] and x.modes[len(x.flags) + i] == STICK:
            push -= k.contact[6 * (len(x.flags) + i) + 4]
            friction += k.contact[6 * (len(x.modes) + i) + 4]
    return abs(friction) <= k.contact[6 * (len(x.modes) + j)] * push


@inner
def grip(f, j, k, x, o):
    """Decide the sliding of a body on wall j, a rough one, from here on; whether it slips, or sticks."""
    at, out = len(x.flags) + j, k.contact
    look(f.contacts, x.modes, x.m, x.s, x.p, out)
    before, mode = x.modes[at], sliding(k, x, o, j)
    if mode != RESTING:
        _together(x, j, mode, 0, o.rest)
    else:
        _together(x, j, SLIP_POSITIVE, 1, o.rest)
        look(f.contacts, x.modes, x.m, x.s, x.p, out)
        plus, up = out[6 * (len(x.modes) + j) + 5], out[6 * at + 4] < 0.0
        _together(x, j, SLIP_NEGATIVE, 1, o.rest)
        look(f.contacts, x.modes, x.m, x.s, x.p, out)
        mode = balance(plus, out[6 * (len(x.modes) + j) + 5], before)
        pushes = up if mode == SLIP_POSITIVE else out[6 * at + 4] < 0.0
        if mode != STICK and not pushes:
            _together(x, j, STICK, 0, o.rest)
            look(f.contacts, x.modes, x.m, x.s, x.p, out)
            mode = STICK if _holds(k, x, j) else mode
        _together(x, j, mode, 0 if mode == STICK else 1, o.rest)
    look(f.contacts, x.modes, x.m, x.s, x.p, out)


@inner
def rub(f, j, k, x, o):
    """Slip on wall j ends at the base point, or sticking does: change modes; the kind of event."""
    at = len(x.flags) + j
    if x.modes[at] == STICK:
        look(f.contacts, x.modes, x.m, x.s, x.p, k.contact)
        friction = 0.0
        for i in range(walls_of(x)):
            if x.group[i] == x.group[j] and x.modes[len(x.flags) + i] == STICK:
                friction += k.contact[6 * (len(x.modes) + i) + 4]
        _together(x, j, SLIP_POSITIVE if friction > 0.0 else SLIP_NEGATIVE, 2, o.rest)
        return SLIP_ONSET
    grip(f, j, k, x, o)
    return STICK_ONSET if x.modes[at] == STICK else SLIP_REVERSAL
