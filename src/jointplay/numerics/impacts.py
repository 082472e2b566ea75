"""Impacts on several walls of one rigid guide at one instant: Newton's law for all of them at once.

Two corners of a slider meet a face together, or one meets it while another rests there. With v_i the rate of
gap i, A_ik what an impulse on wall k that changes v_k by 1 adds to it, and r the restitutions,

    v+ = v- + A L,    L_i >= 0,    v+_i + r_i v-_i >= 0,    L_i (v+_i + r_i v-_i) = 0

over every wall of the group that rests, or is that near: within what it moves in the time in which events
crowd. A wall that opens, or at which a body rests, counts with r = 0. The impulses are found by projected
Gauss-Seidel sweeps, which converge: A is the inverse mass matrix that the walls feel, scaled by columns. The
energy changes by the sum of P_i (v+_i + v-_i)/2, P_i >= 0 the impulse; where all close or rest it falls, as
v+_i = -r_i v-_i or P_i = 0. Should it grow where one opens, all count with r = 0, and what is left is a
projection, with which it falls. Single impacts in a row would not do: two corners of a light slider hand the
impulse to each other almost without end, ever faster. A neighbouring motion meets the walls one after the
other: it does not stay near, and tangents end here. References: Glocker, Set-Valued Force Laws (2001); Leine
and Nijmeijer (2004).
"""

from .interface import inner
from .memory import EVENT_ROW, EVENTS, JOINTS, TOGETHER
from .modes import FREE, IMPACT, RESTING, look
from .record import note
from .sections import count_event

SWEEPS = 20000
EXACT = 1e-15  # of the fastest rate
# Rows of scratch after the matrix A: whether a wall takes part, its rate before and after, that at which it
# has to leave, and the impulse, by what it adds to the wall's own rate.
PART, BEFORE, AFTER, TARGET, PUSH, ROWS = range(6)


@inner
def together(f, j, k, x, o):
    """Impact on wall j, and on others at the same instant; whether there were any, else nothing is done."""
    first, walls, w, several = len(x.flags), len(x.modes) - len(x.flags), k.w, False
    if walls < 2 or walls * (walls + ROWS) > 8 * o.first:
        return False
    look(f.contacts, x.modes, x.m, x.s, x.p, k.contact)
    at = walls * walls
    for i in range(walls):
        met = _met(k, x, o, i, j)
        several = several or (met and i != j)
        w[at + PART * walls + i] = 1.0 if met else 0.0
        w[at + BEFORE * walls + i] = k.contact[6 * (first + i) + 2]
    if not several:
        return False
    for r in range(len(x.s)):
        k.ahead[r] = x.s[r]
    for i in range(walls):
        if w[at + PART * walls + i] > 0.0:
            _aim(f, i, k, x, walls)
    _sweep(w, walls)
    look(f.contacts, x.modes, x.m, x.s, x.p, k.contact)
    if _gain(k, x, walls) > 0.0:
        for i in range(walls):
            w[at + TARGET * walls + i] = 0.0
        _sweep(w, walls)
    _apply(f, j, k, x, o, walls)
    return True


@inner
def _met(k, x, o, i, j):
    """Whether wall i takes part in an impact on wall j."""
    at = len(x.flags) + i
    near = k.contact[6 * at] <= abs(k.contact[6 * at + 2]) * o.near
    return i == j or (x.group[i] == x.group[j] and (x.modes[at] == RESTING or near))


@inner
def _aim(f, i, k, x, walls):
    """Column i of A, and the rate that wall i is to have: what an impact on it alone would give it."""
    first, w, at = len(x.flags), k.w, walls * walls
    f.reset(2 * walls + 2 * first + i, x.s, x.p)
    look(f.contacts, x.modes, x.m, x.s, x.p, k.contact)
    for c in range(walls):
        w[c * walls + i] = k.contact[6 * (first + c) + 2] - w[at + BEFORE * walls + c]
    _back(k, x)
    f.reset(i, x.s, x.p)
    look(f.contacts, x.modes, x.m, x.s, x.p, k.contact)
    closing = w[at + BEFORE * walls + i] < 0.0 and x.modes[first + i] == FREE
    w[at + TARGET * walls + i] = k.contact[6 * (first + i) + 2] if closing else 0.0
    _back(k, x)


@inner
def _back(k, x):
    for r in range(len(x.s)):
        x.s[r] = k.ahead[r]


@inner
def _sweep(w, walls):
    """Impulses of all walls, and the rates after them: projected Gauss-Seidel."""
    at, fastest = walls * walls, 0.0
    for i in range(walls):
        w[at + PUSH * walls + i] = 0.0
        w[at + AFTER * walls + i] = w[at + BEFORE * walls + i]
        fastest = max(fastest, abs(w[at + BEFORE * walls + i]))
    for _ in range(SWEEPS):
        change = 0.0
        for i in range(walls):
            if w[at + PART * walls + i] > 0.0:
                push = w[at + PUSH * walls + i]
                more = max(w[at + TARGET * walls + i] - w[at + AFTER * walls + i], -push)
                w[at + PUSH * walls + i] = push + more
                for c in range(walls):
                    w[at + AFTER * walls + c] += w[c * walls + i] * more
                change = max(change, abs(more))
        if change <= EXACT * fastest:
            return


@inner
def _gain(k, x, walls):
    """Kinetic energy that the impulses would add."""
    w, at, total = k.w, walls * walls, 0.0
    for i in range(walls):
        inverse = k.contact[6 * (len(x.flags) + i) + 1]
        both = w[at + BEFORE * walls + i] + w[at + AFTER * walls + i]
        total += 0.5 * w[at + PUSH * walls + i] * both / inverse if inverse > 0.0 else 0.0
    return total


@inner
def _apply(f, j, k, x, o, walls):
    """Note the impacts beside that on wall j, and let the impulses act; what is lost is the joints' work."""
    first, w, time, at = len(x.flags), k.w, x.s[0], walls * walls
    x.count[TOGETHER] += 1
    if len(x.work) > JOINTS:
        x.work[JOINTS] -= _gain(k, x, walls)
    for i in range(walls):
        if i != j and w[at + PUSH * walls + i] > 0.0 and x.modes[first + i] == FREE:
            x.count[EVENTS] += 1
            if o.log_events and time >= o.log_from:
                note(k, x, o, EVENT_ROW, float(first + i), float(IMPACT), time, 0.0)
    for i in range(walls):
        push = w[at + PUSH * walls + i]
        if push > 0.0:
            for r in range(len(x.s)):
                k.ahead[r] = x.s[r]
            f.reset(2 * walls + 2 * first + i, x.s, x.p)
            for r in range(len(x.s)):
                x.s[r] = k.ahead[r] + push * (x.s[r] - k.ahead[r])
    for i in range(walls):
        if i != j and w[at + PUSH * walls + i] > 0.0 and x.modes[first + i] == FREE:
            count_event(k, x, o, first + i, IMPACT, time)
