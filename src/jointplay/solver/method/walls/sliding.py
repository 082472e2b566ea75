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
    contact_numbers,
)
from .impacts import rough


@inner
def walls_of(motion):
    """Number of rigid walls; their modes follow the contacts' modes."""
    return len(motion.modes) - len(motion.flags)


@inner
def sliding(work, motion, options, j):
    """Mode of a body that rests on wall j, by its present sliding speed."""
    if not rough(motion, j):
        return RESTING
    v_t = work.contact[6 * (len(motion.modes) + j) + 2]
    return RESTING if abs(v_t) <= options.speed_tolerance else (SLIP_POSITIVE if v_t > 0.0 else SLIP_NEGATIVE)


@inner
def _together(motion, j, mode, fired, margin):
    """Set the mode of wall j, and of all in its guide on which the body rests: they slide as one."""
    for i in range(walls_of(motion)):
        at, rub = len(motion.flags) + i, 4 * len(motion.flags) + walls_of(motion) + i
        if i == j or (motion.group[i] == motion.group[j] and motion.modes[at] > RELEASED):
            motion.modes[at], motion.fired[rub], motion.margin[rub] = mode, fired, margin


@inner
def _holds(work, motion, j):
    """Whether a body that sticks to wall j, and others of its guide, is pressed within the friction cone."""
    push, friction = 0.0, 0.0
    for i in range(walls_of(motion)):
        if motion.group[i] == motion.group[j] and motion.modes[len(motion.flags) + i] == STICK:
            push -= work.contact[6 * (len(motion.flags) + i) + 4]
            friction += work.contact[6 * (len(motion.modes) + i) + 4]
    return abs(friction) <= work.contact[6 * (len(motion.modes) + j)] * push


@inner
def grip(functions, j, work, motion, options):
    """Decide the sliding of a body on wall j, a rough one, from here on; whether it slips, or sticks."""
    at, out = len(motion.flags) + j, work.contact
    contact_numbers(functions.contacts, motion.modes, motion.m, motion.s, motion.p, out)
    before, mode = motion.modes[at], sliding(work, motion, options, j)
    if mode != RESTING:
        _together(motion, j, mode, 0, options.speed_tolerance)
    else:
        _together(motion, j, SLIP_POSITIVE, 1, options.speed_tolerance)
        contact_numbers(functions.contacts, motion.modes, motion.m, motion.s, motion.p, out)
        plus, up = out[6 * (len(motion.modes) + j) + 5], out[6 * at + 4] < 0.0
        _together(motion, j, SLIP_NEGATIVE, 1, options.speed_tolerance)
        contact_numbers(functions.contacts, motion.modes, motion.m, motion.s, motion.p, out)
        mode = balance(plus, out[6 * (len(motion.modes) + j) + 5], before)
        pushes = up if mode == SLIP_POSITIVE else out[6 * at + 4] < 0.0
        if mode != STICK and not pushes:
            _together(motion, j, STICK, 0, options.speed_tolerance)
            contact_numbers(functions.contacts, motion.modes, motion.m, motion.s, motion.p, out)
            mode = STICK if _holds(work, motion, j) else mode
        _together(motion, j, mode, 0 if mode == STICK else 1, options.speed_tolerance)
    contact_numbers(functions.contacts, motion.modes, motion.m, motion.s, motion.p, out)


@inner
def rub(functions, j, work, motion, options):
    """Slip on wall j ends at the base point, or sticking does: change modes; the kind of event."""
    at = len(motion.flags) + j
    if motion.modes[at] == STICK:
        contact_numbers(functions.contacts, motion.modes, motion.m, motion.s, motion.p, work.contact)
        friction = 0.0
        for i in range(walls_of(motion)):
            if motion.group[i] == motion.group[j] and motion.modes[len(motion.flags) + i] == STICK:
                friction += work.contact[6 * (len(motion.modes) + i) + 4]
        _together(motion, j, SLIP_POSITIVE if friction > 0.0 else SLIP_NEGATIVE, 2, options.speed_tolerance)
        return SLIP_ONSET
    grip(functions, j, work, motion, options)
    return STICK_ONSET if motion.modes[at] == STICK else SLIP_REVERSAL
