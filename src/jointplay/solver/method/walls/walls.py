"""Rigid walls: impacts, the rest in which ever lower rebounds end, and release.

With g a wall's gap, v = g' after an impact and a = g'' < 0 in flight, a rebound lasts 2 v/|a| and the next
one begins with r v. All that follow last

    T = 2 w/|a(t + T/3)|,   w = v/(1 - r),

to second order in v, as long as one flight with the speed w: a rebound's length and its speed at the end
both have corrections in a', and their sums come to that. Once a rebound's height v^2/(2 |a|) is within the
tolerance, the body is put on the wall, g = g' = 0; the impacts will have ended T later. The wall holds it
until it need no longer push: there a = 0, and the gap opens as the cube of time. References: Budd and Dux,
Phil. Trans. R. Soc. A 347 (1994) 365-389; Nordmark and Piiroinen, Nonlinear Dynamics 58 (2009) 85-106.

Sliding on rigid walls: slip, its end and its reversal, sticking and its end.

Where a body rests on a rough wall it slips with friction f times the push, or sticks up to that. At v_t = 0
the two one-sided accelerations decide, as at any contact (method.modes). With much friction the wall may
have to pull in one sense of slip: the body sticks then, if that holds it within the cone. Corners of one
guide on which a slider rests slide as one, and share what they may hold.
"""

from ..interface import inner
from ..memory import DRIVE, EVALUATIONS, JAMMED, JOINTS, MEMBERS, REBOUND_ERROR, TARGET, WALL, H
from ..modes import (
    FORCELESS,
    FREE,
    IMPACT,
    RELEASED,
    RESTING,
    SEPARATION,
    SLIP_NEGATIVE,
    SLIP_ONSET,
    SLIP_POSITIVE,
    SLIP_REVERSAL,
    STICK,
    STICK_ONSET,
    STICKS,
    balance,
    contact_numbers,
    mask,
    touch,
    variant_of,
)
from .impacts import bring, bring_back, laid, lay, plastic, rough, together

START, STEP, SEEK_GROWTH = -1, -2, -3  # in the place of a guard; the last of excited.at_wall
ROUNDS = 3  # of the iteration for T, each of which gains an order in v
FEW = 4.0  # margins of a gap: lower rebounds are those of its rounding, which would keep them up
STEADY = 0.1  # share of a by which it may change until the last impact
LEAP = 1e4  # of events that crowd: length of a step in which an opening gap exceeds rounding
SWEEPS = 64  # of putting a body back on several walls
ROOM = 4.0  # heights of a rebound that another wall must be away


@inner
def settle(functions, j, motion):
    """Put the body on wall j, moving with it."""
    functions.reset(walls_of(motion) + j, motion.s, motion.p)
    functions.trig(motion.s, motion.p)


@inner
def _lose(contact, at, before, after, work):
    """Work of the impulse that changes the gap's rate: the joints take it in, the drive answers it."""
    if len(work) > JOINTS and contact[6 * at + 1] > 0.0:
        impulse = (after - before) / contact[6 * at + 1]
        work[JOINTS] -= 0.5 * impulse * (before + after)
        work[DRIVE] += impulse * contact[6 * at + 3]


@inner
def _ahead(functions, j, work, motion, options, later):
    """The rate's own rate of gap j in flight, `later` on from the base point along the motion at rest."""
    at, s, rates = len(motion.flags) + j, work.predicted, 8 * (options.first + 1 + options.n_q + options.n)
    for r in range(len(motion.s)):
        s[r] = motion.s[r]
    functions.reset(walls_of(motion) + j, s, motion.p)
    functions.trig(s, motion.p)
    for i in range(8 * options.first, rates):
        work.w[i] = 0.0
    motion.modes[at] = sliding(work, motion, options, j)
    mask(motion.modes, motion.m)
    functions.rate(variant_of(motion.modes), work.w, s, motion.p, motion.m)
    motion.count[EVALUATIONS] += 1
    motion.modes[at] = FREE
    for r in range(options.n_q):
        s[1 + r] += later * s[1 + options.n_q + r]
    for r in range(options.n):
        s[1 + options.n_q + r] += later * work.w[rates + 8 * r + 7]
    s[0] += later
    functions.trig(s, motion.p)
    contact_numbers(functions.contacts, motion.modes, motion.m, s, motion.p, work.contact)
    return work.contact[6 * at + 5]


@inner
def low(v, a, options):
    """Whether a rebound with the speed v, with v' = a, is within the tolerance of none."""
    return (
        v * v <= 2.0 * options.height_tolerance * abs(a)
        or 2.0 * v <= options.chatter_time * abs(a)
        or v <= options.speed_tolerance
    )


@inner
def _lasting(functions, j, work, motion, options, before):
    """Time until the rebounds from wall j have ended; -1 if they do not end, or the first is too high.

    The body has just left the wall, which it met with the speed `before`.
    """
    at = len(motion.flags) + j
    contact_numbers(functions.contacts, motion.modes, motion.m, motion.s, motion.p, work.contact)
    v, a, lasts = work.contact[6 * at + 2], work.contact[6 * at + 5], 0.0
    ratio, now = v / before if before > 0.0 else 0.0, a
    if not (low(v, a, options) and ratio < 1.0):
        return -1.0
    for _ in range(ROUNDS):
        now = _ahead(functions, j, work, motion, options, max(lasts / 3.0, options.chatter_time))
        if not now < 0.0:
            return -1.0
        lasts = -2.0 * max(v, 0.0) / (1.0 - ratio) / now
    if lasts > options.chatter_time:
        change = abs(_ahead(functions, j, work, motion, options, lasts) - a) / -now
        slight = change * v <= motion.real[REBOUND_ERROR] or 2.0 * v <= options.chatter_time * abs(a)
        slight = slight or v * v <= 2.0 * FEW * options.gap_rounding * abs(a)
        if not (change <= STEADY and slight):
            return -1.0
    for i in range(len(motion.flags), len(motion.modes)):
        near = i != at and motion.modes[i] == FREE and work.contact[6 * i] <= -ROOM * v * v / (2.0 * now)
        if near and work.contact[6 * i + 1] >= 0.0 and not _settles_too(work, options, i):
            return -1.0
    return lasts


@inner
def _settles_too(work, options, i):
    """Whether a body near wall i has rebounds as low, which end likewise."""
    v, a = work.contact[6 * i + 2], work.contact[6 * i + 5]
    return a < 0.0 and (
        v * v <= 2.0 * ROOM * options.height_tolerance * -a or abs(v) <= options.speed_tolerance
    )


@inner
def _opening(functions, j, work, motion, options):
    """Multiplicity with which gap j starts at zero, from the base point, in flight."""
    at = len(motion.flags) + j
    contact_numbers(functions.contacts, motion.modes, motion.m, motion.s, motion.p, work.contact)
    v, a = work.contact[6 * at + 2], work.contact[6 * at + 5]
    if v > 0.0:
        return 1
    return 2 if abs(a) > 0.5 * abs(_ahead(functions, j, work, motion, options, options.chatter_time)) else 3


@inner
def strike(functions, j, work, motion, options):
    """Impact on wall j at the base point, or release from it: the kind of event, and `_lasting`.

    `fired` takes the multiplicity with which the gap starts at zero.
    """
    at, guard = len(motion.flags) + j, 4 * len(motion.flags) + j
    work.impact[MEMBERS] = 0.0
    if motion.modes[at] > RELEASED:
        settle(functions, j, motion)
        motion.modes[at], motion.fired[guard], motion.margin[guard] = FREE, 3, options.gap_rounding
        return SEPARATION, -1.0
    contact_numbers(functions.contacts, motion.modes, motion.m, motion.s, motion.p, work.contact)
    if work.contact[6 * at + 1] < 0.0:
        move(functions, j, work, motion, options)
        _slide_on(functions, work, motion, options)
        return IMPACT, -1.0
    before = -work.contact[6 * at + 2]
    several = before > 0.0 and together(functions, j, work, motion, options)
    if before > 0.0:  # else the gap opens, and rounding alone has closed it
        if not several:
            functions.reset(j, motion.s, motion.p)
        _change_sides(functions, FORCELESS, work, motion, options)
    motion.fired[guard] = _opening(functions, j, work, motion, options)
    contact_numbers(functions.contacts, motion.modes, motion.m, motion.s, motion.p, work.contact)
    if not several:
        _lose(work.contact, at, -before, work.contact[6 * at + 2], motion.work)
    throw_off(work, motion, options)
    if several:
        _stay_on(functions, j, work, motion, options)
    _slide_on(functions, work, motion, options)
    return IMPACT, _lasting(functions, j, work, motion, options, before)


@inner
def move(functions, j, work, motion, options):
    """Jump of the state where there is no wall; contacts begin and end as they then are."""
    functions.reset(j, motion.s, motion.p)
    motion.fired[4 * len(motion.flags) + j] = 0
    _change_sides(functions, 0, work, motion, options)
    contact_numbers(functions.contacts, motion.modes, motion.m, motion.s, motion.p, work.contact)
    throw_off(work, motion, options)


@inner
def _change_sides(functions, kind, work, motion, options):
    """After a jump, contacts that have the flag `kind`, or all, begin and end as they then are.

    An impact moves no gap: only switches, which are contacts without a force, may hang on speeds.
    """
    flags, modes, m, s, p, out = motion.flags, motion.modes, motion.m, motion.s, motion.p, work.contact
    for i in range(len(flags)):
        if flags[i] & kind == kind:
            contact_numbers(functions.contacts, modes, m, s, p, out)
            if modes[i] == FREE and out[6 * i] > 0.0:
                touch(functions.contacts, i, flags, modes, m, s, p, options.speed_tolerance, out)
            elif modes[i] > FREE and out[6 * i] < 0.0:
                modes[i] = FREE


@inner
def throw_off(work, motion, options):
    """Update the modes after a jump of speeds: slip by the new speeds; bodies that leave a wall are free."""
    for i in range(len(motion.flags)):
        v_t = work.contact[6 * i + 2]
        if motion.flags[i] & STICKS and motion.modes[i] > RELEASED and abs(v_t) > options.speed_tolerance:
            motion.modes[i] = SLIP_POSITIVE if v_t > 0.0 else SLIP_NEGATIVE
    for i in range(len(motion.flags), len(motion.modes)):
        if motion.modes[i] > RELEASED and abs(work.contact[6 * i + 2]) > options.speed_tolerance:
            guard = 3 * len(motion.flags) + i
            motion.modes[i], motion.fired[guard], motion.margin[guard] = FREE, 1, options.gap_rounding


@inner
def _stay_on(functions, j, work, motion, options):
    """After an impact on wall j, put back bodies that rebound from other walls by less than the tolerance.

    Else two bodies that come to rest on two walls might throw each other off without end.
    """
    q = work.impact
    for i in range(int(q[MEMBERS])):
        wall = int(q[WALL + i])
        left = wall != j and q[TARGET + i] == 0.0 and motion.modes[len(motion.flags) + wall] == FREE
        if left and _lasting(functions, wall, work, motion, options, 0.0) >= 0.0:
            hold(functions, wall, work, motion, options)


@inner
def _slide_on(functions, work, motion, options):
    """After a jump of speeds, decide the sliding of bodies that rest on rough walls."""
    for j in range(walls_of(motion)):
        if motion.modes[len(motion.flags) + j] > RELEASED and rough(motion, j):
            grip(functions, j, work, motion, options)


@inner
def hold(functions, j, work, motion, options):
    """The body rests on wall j from here on."""
    at = len(motion.flags) + j
    contact_numbers(functions.contacts, motion.modes, motion.m, motion.s, motion.p, work.contact)
    if rough(motion, j) and (work.contact[6 * at + 2] > options.speed_tolerance or not plastic(work, j)):
        lay(functions, j, work, motion, options)
        contact_numbers(functions.contacts, motion.modes, motion.m, motion.s, motion.p, work.contact)
    if len(motion.work) > JOINTS and resting(motion) > 0 and not laid(work) and not plastic(work, j):
        bring(functions, j, work, motion)
    else:
        _lose(work.contact, at, work.contact[6 * at + 2], 0.0, motion.work)
    settle(functions, j, motion)
    contact_numbers(functions.contacts, motion.modes, motion.m, motion.s, motion.p, work.contact)
    guard = 4 * len(motion.flags) + j  # from here on the push, which has no margin
    motion.fired[guard] = 1 if work.contact[6 * at + 5] >= 0.0 else 0  # it begins to be pressed there
    motion.margin[guard] = 0.0
    pressed = work.contact[6 * at + 5] < 0.0
    motion.modes[at] = RESTING
    if resting(motion) > 1:
        stay(functions, work, motion, options)
    if rough(motion, j):
        grip(functions, j, work, motion, options)
        motion.count[JAMMED] += pressed and not work.contact[6 * at + 4] < 0.0


@inner
def stay(functions, work, motion, options):
    """After a step, remove the drift of a body off the walls on which it rests.

    Of several that hold it redundantly it is taken away in turn, until what one gives to the others is small.
    """
    several = resting(motion) > 1
    functions.trig(motion.s, motion.p)
    if several and bring_back(functions, work, motion, options):
        return
    for _ in range(SWEEPS if several else 1):
        for j in range(walls_of(motion)):
            if motion.modes[len(motion.flags) + j] > RELEASED:
                settle(functions, j, motion)


@inner
def resting(motion):
    """Number of walls on which a body rests."""
    held = 0
    for j in range(len(motion.flags), len(motion.modes)):
        held += motion.modes[j] > RELEASED
    return held


@inner
def moves_with(work, at, options):
    """Whether a body starts on a wall and moves with it."""
    wall = work.contact[6 * at + 1] >= 0.0
    return (
        wall
        and abs(work.contact[6 * at]) <= options.height_tolerance
        and abs(work.contact[6 * at + 2]) <= options.speed_tolerance
    )


@inner
def begin(functions, work, motion, options):
    """Set the initial modes of walls: a body on one that moves with it and is pressed to it rests there."""
    for j in range(walls_of(motion)):
        at = len(motion.flags) + j
        motion.margin[4 * len(motion.flags) + j] = options.gap_rounding
        contact_numbers(functions.contacts, motion.modes, motion.m, motion.s, motion.p, work.contact)
        if moves_with(work, at, options):
            motion.fired[4 * len(motion.flags) + j] = _opening(functions, j, work, motion, options)
            motion.real[H] = max(motion.real[H], LEAP * options.chatter_time)
            if _lasting(functions, j, work, motion, options, 0.0) >= 0.0:
                hold(functions, j, work, motion, options)


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
