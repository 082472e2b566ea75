"""Events: the first guard that leaves its side within a step, and its place on the method itself.

Detection looks at the polynomial of the step (no root of it is stepped over). Location steps anew from the
step's beginning to the root with the method itself, so that the state at the event has the step's own
accuracy and no interpolant's: Newton on the length, one or two short solves from an excellent prediction.
"""

import numpy as np

from .control import instant
from .interface import compiled, inlined, inner
from .memory import EVALUATIONS
from .modes import CONE, FORCE, PULLS, RELEASED, SLIP_NEGATIVE, SLIP_POSITIVE, STICK, STICKING, inside
from .polynomial import TO_ROUNDING, basis, bernstein, first_root, interpolate, last_terms, value
from .step import converge, keep

REFINEMENTS, NEAR_ROOT = 8, 1e-6  # attempts at a root; share of a step that ends there
TOGETHER = 1e-6  # of a step that ends at an event: what happens within it is one event's
FOLLOWING = 1e-6  # share of what a guard comes to in a step
ROUNDING = 0.06  # of a guard's margin, which is more than sixteen roundings
SQUARES = 4.0  # ratio of a squared distance among the stages, from which on zero may have been passed
LEFT_OUT, FLAT = 0.01, 1e-6  # last terms of a guard that is seen whole, over its least and largest size
NEAR_FOLD, AT_FOLD = 0.04, 1e-10  # sin^2 to a dead centre below which that is looked at; that counts as 0
AWAY, NEARING, THERE = range(3)  # from a dead centre


@inner
def _passes_zero(w, row, shift):
    """Whether the squared distance in a lane row, and a shift, may have passed zero in the step.

    It may lie between two stages, unseen. On a line past zero the distance changes fivefold at least among
    the stages; it may change twofold, its square fourfold.
    """
    least, most = np.inf, 0.0
    for i in range(8):
        square = w[8 * row + i] + shift
        least, most = min(least, square), max(most, square)
    return SQUARES * least < most


@inner
def passes_centre(w, row, motion):
    """Whether a journal in contact may have passed the bearing's centre in the step: the force turns there.

    `row` is the lane row of the first guard, which is r^2 - e^2.
    """
    for j in range(len(motion.flags)):
        if motion.modes[j] > RELEASED and _passes_zero(w, row + 4 * j, motion.clearance_squared[j]):
            return True
    return False


@inner
def dead_centre(w, options):
    """Whether the step is so long that it may lead across a loop's dead centre, or one lies where it began.

    There the links turn back that lead the motion, on a path that is smooth; those that follow swing through,
    to where the equations have another sign of a root. A step across would turn them back too, or stop them.
    At the dead centre itself rounding has all digits.
    """
    found = AWAY
    for row in range(options.first + 1 + options.n_q + 2 * options.n, options.guards):
        least = np.inf
        for i in range(8):
            least = min(least, w[8 * row + i])
        if w[8 * row + 7] < AT_FOLD:
            return THERE
        if least < NEAR_FOLD and _passes_zero(w, row, 0.0):
            found = NEARING
    return found


@inner
def unresolved(w, motion, options, h):
    """Whether a guard may come nearer to zero between the stages of a step of length h than at any of them.

    One that is no polynomial of the state may turn faster than the state, which alone bounds the step. What
    the polynomial of the step leaves out of it is about as large as that one's last terms (polynomial.last).
    """
    if options.bends == 0 or h < options.chatter_time:
        return False
    for g in range(len(motion.fired)):
        at, least, most = 8 * (options.guards + g), np.inf, 0.0
        for i in range(8):
            size = abs(w[at + i])
            most = max(most, size)
            least = size if size < least and (i < 7 or motion.fired[g] == 0) else least
        if side_of(g, motion.modes, motion.flags) != 0 and last_terms(w, at) > max(
            LEFT_OUT * least, FLAT * most
        ):
            return True
    return False


@inner
def too_long(w, motion, options, h):
    """Whether in a step of length h a force, a loop or a guard may turn between two stages, unseen."""
    if passes_centre(w, options.guards, motion) or dead_centre(w, options) != AWAY:
        return True
    return unresolved(w, motion, options, h)


@inner
def set_cone_margins(w, row, lane, motion):
    """Set the margins of friction cones at a lane, by the normal force there, whose rounding they stand for.

    `row` is the lane row of the first guard.
    """
    for j in range(len(motion.flags)):
        if motion.modes[j] == STICK:
            motion.margin[4 * j + CONE] = motion.cone[j] * abs(w[8 * (row + 4 * j + FORCE) + int(lane)])
    for j in range(len(motion.flags), len(motion.modes)):
        if motion.modes[j] == STICK:
            push = w[8 * (row + 3 * len(motion.flags) + j) + int(lane)]
            motion.margin[2 * len(motion.flags) + len(motion.modes) + j] = motion.cone[j] * push * push


@compiled
def side_of(g, modes, flags):
    """The side (+1, -1) on which guard g stays; 0 if it is not watched."""
    j, walls = g // 4, len(modes) - len(flags)
    if j < len(flags):
        return inside(modes[j], g % 4, flags[j] & PULLS)
    rub = g - 4 * len(flags) - walls
    if rub < 0:
        return 1
    mode = modes[len(flags) + rub]
    return -1 if mode == SLIP_NEGATIVE else (1 if mode in (SLIP_POSITIVE, STICK) else 0)


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
    """Multiplicity of the zero with which guard g, of lane row w[at:], starts, and the level to leave."""
    none = 0 * g  # a variable, for the reason that interface gives
    if margin[g] == 0.0:
        return fired[g], 0.0
    return none, level_of(w[at + 7], side, fired[g], margin[g])


@inlined
def leaving(b, degree, side, level, stack, share):
    """First place where the polynomial with coefficients b is beyond a level; 2.0 if none. b is spent."""
    lowest = 0.0
    for i in range(degree + 1):
        b[i] -= level
        lowest = min(lowest, side * b[i])
    return first_root(b, degree, side, stack, share) if lowest < 0.0 else 2.0


@inlined
def first_event(work, motion, options, slack, share):
    """The guard that first leaves its side within the step in work, and where in [0, 1]; -1 and 2.0 if none.

    What goes beyond by less than `slack` margins does not count. The place is found to a share of the step.
    """
    which, earliest, b = -1, 2.0, work.b
    for g in range(len(motion.fired)):
        side = side_of(g, motion.modes, motion.flags)
        if side != 0:
            at = 8 * (options.guards + g)
            multiplicity, level = start_of(work.w, at, g, side, motion.fired, motion.margin)
            level -= side * slack * motion.margin[g]
            place = leaving(b, bernstein(work.w, at, multiplicity, b), side, level, work.stack, share)
            if place < earliest:
                which, earliest = g, place
    return which, earliest


@inner
def begins_beyond(w, row):
    """Whether the guard in a lane row has left its side before the step, by more than a root's rounding.

    An event has put it there; the next, at the same time, follows from that one and not from its own guard.
    """
    most = 0.0
    for i in range(7):
        most = max(most, abs(w[8 * row + i]))
    return abs(w[8 * row + 7]) > FOLLOWING * most


@inner
def root_level(b, degree, side, place, level, margin):
    """Level whose crossing is located, of a guard with coefficients b that is beyond `level` at `place`.

    Zero, where the guard has been inside by more than its margin between; or where it started, if that is
    further beyond: by a margin more from each flight to the next, rebounds would keep themselves up.
    """
    begin, start = 0 * degree, level + side * margin  # a variable, for the reason that interface gives
    back = start if side * start < -margin else 0.0
    return back if side * (value(b, begin, degree, 0.5 * place) - back) > margin else level


@inner
def comes_back(fired, h, chatter_time):
    """Whether an event at the beginning of a step of length h is spurious, and the step too long.

    Such a step shows a guard that has just fired, and leaves its root, coming back at once.
    """
    return fired > 0 and h > 1e-3 * chatter_time


@inner
def correction(b, degree, level):
    """Fraction by which to lengthen a step for the polynomial with coefficients b to end at the level."""
    slope = degree * (b[degree] - b[degree - 1])
    return (level - b[degree]) / slope if slope != 0.0 else 0.0


@inner
def corrected(h, later):
    """Length of the next attempt at a root, after one of length h that was to be longer by that share."""
    return h * (1.0 + min(max(later, -0.5), 0.5))


@inner
def level_to_leave(work, motion, options, guard, place):
    """Multiplicity with which a guard starts at zero; the level whose crossing near `place` is located."""
    row, side = options.guards + guard, side_of(guard, motion.modes, motion.flags)
    multiplicity, level = start_of(work.w, 8 * row, guard, side, motion.fired, motion.margin)
    if level != 0.0:
        degree = bernstein(work.w, 8 * row, multiplicity, work.b)
        level = root_level(work.b, degree, side, place, level, motion.margin[guard])
    return multiplicity, level


@inner
def at_root(work, motion, options, row, multiplicity, level, guard, share):
    """Fraction by which to lengthen a step to end at a root of (lane row `row`) - level, and whether it does.

    It does to a share of itself, or within the guard's margin.
    """
    degree = bernstein(work.w, 8 * row, multiplicity, work.b)
    later = correction(work.b, degree, level)
    if abs(later) < share:
        return later, True
    if guard >= 0:
        set_cone_margins(work.w, options.guards, 6.0, motion)
        if abs(work.b[degree] - level) < ROUNDING * motion.margin[guard]:
            return 0.0, True
    return later, False


@inner
def locate(functions, variant, work, motion, options, h, place, row, multiplicity, level, guard):
    """Shorten the step in work.whole, of length h, to the root near `place` of (lane row `row`) - level.

    Gives back the shortened step's length, the place of the root in units of it (1 to rounding), and
    whether it was found (a root that only the step's polynomial has is not). The shortened step is in work.w.
    The row may be that of a guard, which has a margin, or of none (-1).
    """
    length, w = place * h, work.w
    for _ in range(REFINEMENTS):
        functions.factor(variant, w, work.J, length)
        functions.extrapolate(w, work.whole, 0.0, length / h)
        functions.move(w, motion.s, length)
        solved, _ = converge(functions, variant, work, motion, length, 0.1 * options.newton, 1.0)
        if not solved:
            return length, 1.0, False
        functions.rate(variant, w, motion.s, motion.p, motion.m)
        motion.count[EVALUATIONS] += 7
        later, there = at_root(work, motion, options, row, multiplicity, level, guard, NEAR_ROOT)
        if there:
            return length, 1.0 + later, True
        length = corrected(length, later)
    return length, 1.0, False


@inlined
def accept_until_event(functions, variant, work, motion, options, h):
    """Accept an accurate attempt, or a shorter one up to its first event.

    Gives back that event's guard (-1: none), the length of the step that ends there, the place of the event
    in it (0: at its start, 1: at its end to rounding), and whether that is sure: a long step may have
    promised another event than the short one to it shows.
    """
    if variant == STICKING:
        set_cone_margins(work.w, options.guards, 7.0, motion)
    guard, place = first_event(work, motion, options, 0.0, TO_ROUNDING)
    if guard < 0:
        if len(motion.work) > 0:
            functions.rate(variant, work.w, motion.s, motion.p, motion.m)
            motion.count[EVALUATIONS] += 7
        return guard, h, 1.0, True
    together = instant(motion.s[0], options.chatter_time)
    if place * h <= together:
        return guard, h, 0.0, not comes_back(motion.fired[guard], h, options.chatter_time)
    keep(work.w, 8 * (options.first + 1), work.whole)
    multiplicity, level = level_to_leave(work, motion, options, guard, place)
    row = options.guards + guard
    length, root, solved = locate(
        functions, variant, work, motion, options, h, place, row, multiplicity, level, guard
    )
    _, earlier = first_event(work, motion, options, ROUNDING, TO_ROUNDING)
    return guard, length, root, solved and (root - earlier) * length <= together + TOGETHER * length


@compiled
def state_at(w, at, s, n_x, place, b, out):
    """Write positions and speeds at `place` of the step whose increments begin at w[at], to out[1:]."""
    basis(place, b)
    interpolate(w, at, s, 1 + 0 * n_x, n_x, b, out)
