"""Events: the first guard that leaves its side within a step, and its place on the method itself.

Detection looks at the polynomial of the step (no root of it is stepped over). Location steps anew from the
step's beginning to the root with the method itself, so that the state at the event has the step's own
accuracy and no interpolant's: Newton on the length, one or two short solves from an excellent prediction.
"""

import numpy as np

from .interface import compiled, inlined, inner
from .memory import EVALUATIONS
from .modes import CONE, FORCE, PULLS, RELEASED, STICK, STICKING, inside
from .polynomial import basis, bernstein, first_root, value
from .step import converge

REFINEMENTS = 8
TOGETHER = 1e-6  # of a step that ends at an event: what happens within it is one event's
ROUNDING = 0.06  # of a guard's margin, which is more than sixteen roundings
SWING = 4.0  # ratio of r^2 among the stages, from which on the journal swings


@inner
def swings(w, row, x):
    """Whether a journal in contact may have passed the bearing's centre in the step: the force turns there.

    A flight across a bearing that is small beside the penetration lies between two stages, unseen. On a line
    past the centre r changes fivefold at least among the stages; it may change twofold, r^2 (known from the
    guard r^2 - e^2) fourfold. `row` is the lane row of the first guard.
    """
    for j in range(len(x.flags)):
        if x.modes[j] > RELEASED:
            least, most = np.inf, 0.0
            for i in range(8):
                square = w[8 * (row + 4 * j) + i] + x.clearance_squared[j]
                least, most = min(least, square), max(most, square)
            if SWING * least < most:
                return True
    return False


@inner
def blur(w, row, lane, x):
    """Set the margins of cones at a lane: rounding of a normal force counts by that force.

    `row` is the lane row of the first guard.
    """
    for j in range(len(x.flags)):
        if x.modes[j] == STICK:
            x.margin[4 * j + CONE] = x.cone[j] * abs(w[8 * (row + 4 * j + FORCE) + int(lane)])


@compiled
def side_of(g, modes, flags):
    """The side (+1, -1) on which guard g stays; 0 if it is not watched."""
    j = g // 4
    return inside(modes[j], g % 4, flags[j] & PULLS) if j < len(flags) else 1


@inlined
def level_of(start, side, fired, margin):
    """Level that a guard is to leave, from its value at the start.

    A guard that starts from zero, or within its margin on the wrong side, may first go that margin beyond.
    Its sign there is that of rounding, or of a tolerance, and so may be that of its rate (where slip begins).
    """
    if fired > 0 or 0.0 <= -side * start <= margin:
        return start - side * margin
    return 0.0


@inner
def start_of(w, at, g, side, fired, margin):
    """How guard g, of lane row w[at:], starts: multiplicity of its zero there, and the level to leave."""
    none = 0 * g  # a variable, for the reason that interface gives
    if margin[g] == 0.0:
        return fired[g], 0.0
    return none, level_of(w[at + 7], side, fired[g], margin[g])


@inlined
def leaving(b, degree, side, level, stack):
    """Where the polynomial with coefficients b first goes beyond a level; 2.0 if nowhere. b is spent."""
    lowest = 0.0
    for i in range(degree + 1):
        b[i] -= level
        lowest = min(lowest, side * b[i])
    return first_root(b, degree, side, stack) if lowest < 0.0 else 2.0


@inlined
def first_event(w, row, modes, flags, fired, margin, doubt, b, stack):
    """The guard that first leaves its side within the step in w, and where in [0, 1]; -1 and 2.0 if none.

    `row` is the lane row of the first guard. What goes beyond by less than `doubt` margins does not count.
    """
    which, earliest = -1, 2.0
    for g in range(len(fired)):
        side = side_of(g, modes, flags)
        if side != 0:
            at = 8 * (row + g)
            multiplicity, level = start_of(w, at, g, side, fired, margin)
            level -= side * doubt * margin[g]
            place = leaving(b, bernstein(w, at, multiplicity, b), side, level, stack)
            if place < earliest:
                which, earliest = g, place
    return which, earliest


@inner
def aim(b, degree, side, place, level, margin):
    """Level at which a guard with coefficients b is left, if it was found beyond `level` at `place`.

    That is zero where it has been inside by more than its margin between.
    """
    begin = 0 * degree  # a variable, for the reason that interface gives
    return 0.0 if side * value(b, begin, degree, 0.5 * place, b[8:]) > margin else level


@inner
def comes_back(fired, h, near):
    """Whether an event at a step's beginning is none, and the step of length h too long.

    Such a step shows a guard that has just fired, and leaves its root, coming back at once.
    """
    return fired > 0 and h > 1e-3 * near


@inner
def correction(b, degree, level):
    """By how much of itself a step is to be longer, for what has the coefficients b to end at the level."""
    slope = degree * (b[degree] - b[degree - 1])
    return (level - b[degree]) / slope if slope != 0.0 else 0.0


@inner
def corrected(h, later):
    """Length of the next attempt at a root, after one of length h that was to be longer by that share."""
    return h * (1.0 + min(max(later, -0.5), 0.5))


@inner
def locate(f, variant, k, x, o, h, place, row, multiplicity, level, guard):
    """Shorten the step in k.whole, of length h, to the root near `place` of (lane row `row`) - level.

    Gives back the shortened step's length, the place of the root in units of it (1 to rounding), and
    whether it was found (a root that only the step's polynomial has is not). The shortened step is in k.w.
    The row may be that of a guard, which has a margin, or of none (-1).
    """
    length, w, b = place * h, k.w, k.b
    for _ in range(REFINEMENTS):
        f.factor(variant, w, k.J, length)
        f.extrapolate(w, k.whole, 0.0, length / h)
        f.move(w, x.s, length)
        solved, _ = converge(f, variant, k, x, length, 0.1 * o.newton, 1.0)
        if not solved:
            return length, 1.0, False
        f.rate(variant, w, x.s, x.p, x.m)
        x.count[EVALUATIONS] += 7
        degree = bernstein(w, 8 * row, multiplicity, b)
        later = correction(b, degree, level)
        if abs(later) < 1e-6:
            return length, 1.0 + later, True
        if variant == STICKING:
            blur(w, o.guards, 6.0, x)
        if guard >= 0 and abs(b[degree] - level) < ROUNDING * x.margin[guard]:
            return length, 1.0, True
        length = corrected(length, later)
    return length, 1.0, False


@compiled
def state_at(w, at, s, n_x, place, b, out):
    """Write positions and speeds at `place` of the step whose increments begin at w[at], to out[1:]."""
    basis(place, b)
    if b[14] == 1.0:  # the step's end
        for r in range(n_x):
            out[1 + r] = s[1 + r] + w[at + 8 * r + 6]
        return
    for r in range(n_x):
        total = s[1 + r]
        for i in range(7):
            total += b[8 + i] * w[at + 8 * r + i]
        out[1 + r] = total
