"""Rigid walls: impacts, the rest in which ever lower rebounds end, and release.

With g a wall's gap, v = g' after an impact and a = g'' < 0 in flight, a rebound lasts 2 v/|a| and the next
one begins with r v. All that follow last

    T = 2 w/|a(t + T/3)|,   w = v/(1 - r),

to second order in v, as long as one flight with the speed w: a rebound's length and its speed at the end
both have corrections in a', and their sums come to that. Once a rebound's height v^2/(2 |a|) is within the
tolerance, the body is put on the wall, g = g' = 0; the impacts will have ended T later. The wall holds it
until it need no longer push: there a = 0, and the gap opens as the cube of time. References: Budd and Dux,
Phil. Trans. R. Soc. A 347 (1994) 365-389; Nordmark and Piiroinen, Nonlinear Dynamics 58 (2009) 85-106.
"""

from ..interface import inner
from ..memory import ASTRAY, DRIVE, EVALUATIONS, JAMMED, JOINTS, MEMBERS, TARGET, WALL, H
from ..modes import (
    FREE,
    IMPACT,
    RELEASED,
    RESTING,
    SEPARATION,
    SLIP_NEGATIVE,
    SLIP_POSITIVE,
    STICKS,
    look,
    mask,
    touch,
    variant_of,
)
from .impacts import bring, laid, lay, plastic, rough, together
from .sliding import grip, sliding, walls_of

START, STEP, LOOK = -1, -2, -3  # in the place of a guard; the last of excited.at_wall
ROUNDS = 3  # of the iteration for T, each of which gains an order in v
FEW = 4.0  # margins of a gap: lower rebounds are those of its rounding, which would keep them up
STEADY = 0.1  # share of a by which it may change until the last impact
LEAP = 1e4  # of events that crowd: length of a step in which an opening gap exceeds rounding
SWEEPS = 64  # of putting a body back on several walls
ROOM = 4.0  # heights of a rebound that another wall must be away


@inner
def settle(f, j, x):
    """Put the body on wall j, moving with it."""
    f.reset(walls_of(x) + j, x.s, x.p)
    f.trig(x.s, x.p)


@inner
def _lose(contact, at, before, after, work):
    """Work of the impulse that changes the gap's rate: the joints take it in, the drive answers it."""
    if len(work) > JOINTS and contact[6 * at + 1] > 0.0:
        impulse = (after - before) / contact[6 * at + 1]
        work[JOINTS] -= 0.5 * impulse * (before + after)
        work[DRIVE] += impulse * contact[6 * at + 3]


@inner
def _ahead(f, j, k, x, o, later):
    """The rate's own rate of gap j in flight, `later` on from the base point along the motion at rest."""
    at, s, rates = len(x.flags) + j, k.ahead, 8 * (o.first + 1 + o.n_q + o.n)
    for r in range(len(x.s)):
        s[r] = x.s[r]
    f.reset(walls_of(x) + j, s, x.p)
    f.trig(s, x.p)
    for i in range(8 * o.first, rates):
        k.w[i] = 0.0
    x.modes[at] = sliding(k, x, o, j)
    mask(x.modes, x.m)
    f.rate(variant_of(x.modes), k.w, s, x.p, x.m)
    x.count[EVALUATIONS] += 1
    x.modes[at] = FREE
    for r in range(o.n_q):
        s[1 + r] += later * s[1 + o.n_q + r]
    for r in range(o.n):
        s[1 + o.n_q + r] += later * k.w[rates + 8 * r + 7]
    s[0] += later
    f.trig(s, x.p)
    look(f.contacts, x.modes, x.m, s, x.p, k.contact)
    return k.contact[6 * at + 5]


@inner
def low(v, a, o):
    """Whether a rebound with the speed v, with v' = a, is within the tolerance of none."""
    return v * v <= 2.0 * o.hop * abs(a) or 2.0 * v <= o.near * abs(a) or v <= o.rest


@inner
def _lasting(f, j, k, x, o, before):
    """Time until the rebounds from wall j have ended; -1 if they do not end, or the first is too high.

    The body has just left the wall, which it met with the speed `before`.
    """
    at = len(x.flags) + j
    look(f.contacts, x.modes, x.m, x.s, x.p, k.contact)
    v, a, lasts = k.contact[6 * at + 2], k.contact[6 * at + 5], 0.0
    ratio, now = v / before if before > 0.0 else 0.0, a
    if not (low(v, a, o) and ratio < 1.0):
        return -1.0
    for _ in range(ROUNDS):
        now = _ahead(f, j, k, x, o, max(lasts / 3.0, o.near))
        if not now < 0.0:
            return -1.0
        lasts = -2.0 * max(v, 0.0) / (1.0 - ratio) / now
    if lasts > o.near:
        change = abs(_ahead(f, j, k, x, o, lasts) - a) / -now
        slight = change * v <= x.real[ASTRAY] or 2.0 * v <= o.near * abs(a)
        slight = slight or v * v <= 2.0 * FEW * o.play * abs(a)
        if not (change <= STEADY and slight):
            return -1.0
    for i in range(len(x.flags), len(x.modes)):
        near = i != at and x.modes[i] == FREE and k.contact[6 * i] <= -ROOM * v * v / (2.0 * now)
        if near and k.contact[6 * i + 1] >= 0.0 and not _settles_too(k, o, i):
            return -1.0
    return lasts


@inner
def _settles_too(k, o, i):
    """Whether a body near wall i has rebounds as low, which end likewise."""
    v, a = k.contact[6 * i + 2], k.contact[6 * i + 5]
    return a < 0.0 and (v * v <= 2.0 * ROOM * o.hop * -a or abs(v) <= o.rest)


@inner
def _opening(f, j, k, x, o):
    """Multiplicity with which gap j starts at zero, from the base point, in flight."""
    at = len(x.flags) + j
    look(f.contacts, x.modes, x.m, x.s, x.p, k.contact)
    v, a = k.contact[6 * at + 2], k.contact[6 * at + 5]
    if v > 0.0:
        return 1
    return 2 if abs(a) > 0.5 * abs(_ahead(f, j, k, x, o, o.near)) else 3


@inner
def strike(f, j, k, x, o):
    """Impact on wall j at the base point, or release from it: the kind of event, and `_lasting`.

    `fired` takes the multiplicity with which the gap starts at zero.
    """
    at, guard = len(x.flags) + j, 4 * len(x.flags) + j
    k.impact[MEMBERS] = 0.0
    if x.modes[at] > RELEASED:
        settle(f, j, x)
        x.modes[at], x.fired[guard], x.margin[guard] = FREE, 3, o.play
        return SEPARATION, -1.0
    look(f.contacts, x.modes, x.m, x.s, x.p, k.contact)
    if k.contact[6 * at + 1] < 0.0:
        move(f, j, k, x, o)
        _slide_on(f, k, x, o)
        return IMPACT, -1.0
    before = -k.contact[6 * at + 2]
    several = before > 0.0 and together(f, j, k, x, o)
    if before > 0.0 and not several:  # else the gap opens, and rounding alone has closed it
        f.reset(j, x.s, x.p)
    x.fired[guard] = _opening(f, j, k, x, o)
    look(f.contacts, x.modes, x.m, x.s, x.p, k.contact)
    if not several:
        _lose(k.contact, at, -before, k.contact[6 * at + 2], x.work)
    throw_off(k, x, o)
    if several:
        _stay_on(f, j, k, x, o)
    _slide_on(f, k, x, o)
    return IMPACT, _lasting(f, j, k, x, o, before)


@inner
def move(f, j, k, x, o):
    """Jump of the state where there is no wall; contacts begin and end as they then are."""
    f.reset(j, x.s, x.p)
    x.fired[4 * len(x.flags) + j] = 0
    for i in range(len(x.flags)):
        look(f.contacts, x.modes, x.m, x.s, x.p, k.contact)
        u = k.contact[6 * i]
        if x.modes[i] == FREE and u > 0.0:
            touch(f.contacts, i, x.flags, x.modes, x.m, x.s, x.p, o.rest, k.contact)
        elif x.modes[i] > FREE and u < 0.0:
            x.modes[i] = FREE
    look(f.contacts, x.modes, x.m, x.s, x.p, k.contact)
    throw_off(k, x, o)


@inner
def throw_off(k, x, o):
    """Update the modes after a jump of speeds: slip by the new speeds; bodies that leave a wall are free."""
    for i in range(len(x.flags)):
        v_t = k.contact[6 * i + 2]
        if x.flags[i] & STICKS and x.modes[i] > RELEASED and abs(v_t) > o.rest:
            x.modes[i] = SLIP_POSITIVE if v_t > 0.0 else SLIP_NEGATIVE
    for i in range(len(x.flags), len(x.modes)):
        if x.modes[i] > RELEASED and abs(k.contact[6 * i + 2]) > o.rest:
            guard = 3 * len(x.flags) + i
            x.modes[i], x.fired[guard], x.margin[guard] = FREE, 1, o.play


@inner
def _stay_on(f, j, k, x, o):
    """After an impact on wall j, put back bodies that rebound from other walls by less than the tolerance.

    Else two bodies that come to rest on two walls might throw each other off without end.
    """
    q = k.impact
    for i in range(int(q[MEMBERS])):
        wall = int(q[WALL + i])
        left = wall != j and q[TARGET + i] == 0.0 and x.modes[len(x.flags) + wall] == FREE
        if left and _lasting(f, wall, k, x, o, 0.0) >= 0.0:
            hold(f, wall, k, x, o)


@inner
def _slide_on(f, k, x, o):
    """After a jump of speeds, decide the sliding of bodies that rest on rough walls."""
    for j in range(walls_of(x)):
        if x.modes[len(x.flags) + j] > RELEASED and rough(x, j):
            grip(f, j, k, x, o)


@inner
def hold(f, j, k, x, o):
    """The body rests on wall j from here on."""
    at = len(x.flags) + j
    look(f.contacts, x.modes, x.m, x.s, x.p, k.contact)
    if rough(x, j) and (k.contact[6 * at + 2] > o.rest or not plastic(k, j)):
        lay(f, j, k, x, o)
        look(f.contacts, x.modes, x.m, x.s, x.p, k.contact)
    if len(x.work) > JOINTS and resting(x) > 0 and not laid(k) and not plastic(k, j):
        bring(f, j, k, x)
    else:
        _lose(k.contact, at, k.contact[6 * at + 2], 0.0, x.work)
    settle(f, j, x)
    look(f.contacts, x.modes, x.m, x.s, x.p, k.contact)
    guard = 4 * len(x.flags) + j  # from here on the push, which has no margin
    x.fired[guard] = 1 if k.contact[6 * at + 5] >= 0.0 else 0  # it begins to be pressed there
    x.margin[guard] = 0.0
    pressed = k.contact[6 * at + 5] < 0.0
    x.modes[at] = RESTING
    if resting(x) > 1:
        stay(f, x)
    if rough(x, j):
        grip(f, j, k, x, o)
        x.count[JAMMED] += pressed and not k.contact[6 * at + 4] < 0.0


@inner
def stay(f, x):
    """After a step, remove the drift of a body off the walls on which it rests.

    Of several it is taken away in turn, until what one gives to the others is small.
    """
    for _ in range(1 if resting(x) < 2 else SWEEPS):
        for j in range(walls_of(x)):
            if x.modes[len(x.flags) + j] > RELEASED:
                f.trig(x.s, x.p)
                settle(f, j, x)


@inner
def resting(x):
    """Number of walls on which a body rests."""
    held = 0
    for j in range(len(x.flags), len(x.modes)):
        held += x.modes[j] > RELEASED
    return held


@inner
def moves_with(k, at, o):
    """Whether a body starts on a wall and moves with it."""
    wall = k.contact[6 * at + 1] >= 0.0
    return wall and abs(k.contact[6 * at]) <= o.hop and abs(k.contact[6 * at + 2]) <= o.rest


@inner
def begin(f, k, x, o):
    """Set the initial modes of walls: a body on one that moves with it and is pressed to it rests there."""
    for j in range(walls_of(x)):
        at = len(x.flags) + j
        x.margin[4 * len(x.flags) + j] = o.play
        look(f.contacts, x.modes, x.m, x.s, x.p, k.contact)
        if moves_with(k, at, o):
            x.fired[4 * len(x.flags) + j] = _opening(f, j, k, x, o)
            x.real[H] = max(x.real[H], LEAP * o.near)
            if _lasting(f, j, k, x, o, 0.0) >= 0.0:
                hold(f, j, k, x, o)
