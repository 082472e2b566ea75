"""An ensemble, one trajectory in each of eight lanes: places of their numbers, and arrays of a run.

Row r of the one buffer `w` is w[8 r : 8 r + 8], a number of each of eight trajectories. Blocks are as long as
the largest structure needs, so that places are constants; a structure takes the beginning of each. Positions
are its angles and others, each with a speed; what laws of contact remember stays the same between events.
Parameters and what follows from these alone come last, as many as a structure has. What a lane does is
decided by its own numbers: its results are the same beside any others, in any lane.
"""

from collections.abc import Callable
from typing import NamedTuple

from ..interface import INT, Record, vector, void
from ..interface import SIGNATURES as ONE_BY_ONE
from . import CONTACTS, FOLDS, N
from .radau import STAGES

FOLD = 4 * CONTACTS  # of each: gap, force, sliding speed, cone; then how far loops are from dead centres
GUARDS = FOLD + FOLDS
UPDATES = 3  # of Newton's iteration in one attempt


def _blocks(first: int, count: int, size: int = 1) -> range:
    """First rows of so many blocks of one size, and the row that follows them."""
    return range(first, first + count * size + 1, size)


# One row each. Time; the run's end; lengths of this attempt, of the next, of the step that PAST is of, of the
# last whole one; what the control proposes; the longest since a failure; how far the base point goes beyond
# the step's end …
T, END, H, H_NEXT, H_PAST, H_BEFORE, H_CONTROL, H_LIMIT, LATER, _next = _blocks(0, 9)
# … tolerance; sizes of this update and of the one before; errors of this attempt and of the last whole step;
# largest turn of an angle; how low guards go beyond their levels; how far the section's is passed …
TOLERANCE, SIZE, SIZE_BEFORE, ERROR, ERROR_BEFORE, TURNED, LOW, CROSSED, _next = _blocks(_next, 8)
# … the section's level and direction; steps made; attempts left; a speed of an angle that bounds the step …
AHEAD, DIRECTION, STEPS, LEFT, TURN_SPEED, _next = _blocks(_next, 5)
# … what is so (1) or not (0) as an attempt begins: stages are extrapolated from PAST, and from its end; the
# base point is new; a contact touches; closest approaches are recorded …
SMOOTH, OFFSET, NEW, VARIANT, MISSES, _next = _blocks(_next, 5)
# … its iteration goes on in the next attempt; it went on from the last; one was rejected since a whole step;
# the attempt goes through `attempts` whatever comes …
CONTINUES, CONTINUED, REJECTION, SPECIAL, _next = _blocks(_next, 4)
# … as it ends: a gap has a closest approach; how near a dead centre is (events.AWAY, …); it is plain; it is a
# whole step, which the control judges; the base point goes to its end; its increments become PAST; a step is
# stashed, in which it looks for the section
PASSES, CENTRE, PLAIN, WHOLE, TAKEN, KEEP, STASHED, _next = _blocks(_next, 7)
H_VARIANT, _next = _blocks(_next, 1, 2)  # lengths that served last in flight and in contact
CLEARANCE_SQUARED, CONE, MEMORY, _next = _blocks(_next, 3, CONTACTS)  # the cone's margin over F_n; v_0
MASK, _next = _blocks(_next, 1, 3 * CONTACTS)  # touch, slip, stick
POSITION, SPEED, SINE, COSINE, ACCELERATION, FLOOR_POSITION, FLOOR, _next = _blocks(_next, 7, N)
GUARD, SIDE, FIRED, MARGIN, _next = _blocks(_next, 4, GUARDS)  # values at the base, …
X, Y, RATE, _next = _blocks(_next, 3, N)  # a point at which the equations are taken, and what they give
WATCHED, _next = _blocks(_next, 1, GUARDS)
JACOBIAN, _next = _blocks(_next, 1, 2 * N * N)  # d rate / d state
INVERSE, _next = _blocks(_next, 1, N * N)  # of the real system
PAIRS, _next = _blocks(_next, 1, 2 * 2 * N * N)  # of the complex ones
Z, W, F, PAST, _next = _blocks(_next, 4, N * STAGES)  # stages of the speeds: increments, …
WATCHES, _next = _blocks(_next, 1, GUARDS * STAGES)  # guards at the stages
STEP_END = _next
# Of tangents (method.lanes.tangent): what is so of them and of the base point; tolerance, sums; of a step its
# length, the trace's integral, the logarithm of the frame's growth; time in which its last is by volume
DUE, STRAINED, NEW_SLOPES, D_TOLERANCE, NEXT_ROW, TRACE, _next = _blocks(_next, 6)
SPAN, GAIN, GROWN, UNRESOLVED, _next = _blocks(_next, 4)
WEIGHT_POSITION, WEIGHT, RATE_BEFORE, _next = _blocks(_next, 3, N)
SLOPES, _next = _blocks(_next, 1, (1 + STAGES) * 2 * N * N)  # d rate / d state: base, stages
NUMBERS = _next  # parameters, and what follows from these alone
# In an array that each tangent, and the rate before them, has of its own: logarithm of its growth, or of the
# rate's length; what is so of its iteration; sizes, the error allowed …
OWN = 1 << 20
D_LOG, ACTIVE, LEFT_OVER, FOLLOWS, D_SIZE, D_RATIO, D_LENGTH, D_LIMIT, _next = _blocks(OWN, 8)
D_POSITION, D_SPEED, _next = _blocks(_next, 2, N)
D_Z, D_W, D_F, D_PAST, _next = _blocks(_next, 4, N * STAGES)  # as those of the speeds
OWN_SIZE = _next - OWN

# Places in Jobs.place: the next trajectory, rows in the log, passes made, passes after which the loop pauses
NEXT, LOGGED, PASSED_BY, PAUSE, PLACES = range(5)
ASIDE = -1  # status of a trajectory that rests on a wall, or is at a dead centre: to be followed by itself
ROOM = 8 * (3 * CONTACTS + 2)  # log rows that one pass may need: in each lane approaches, an event, a section

# Places in Lanes.whole, rows of eight: the trajectory's number, -1 of none; phase (attempts.STEPPING, …); the
# guard whose root is sought; whether an event follows the step; whether it is the first after an event;
# attempts at the root; the pass before the first
JOB, PHASE, AT, EVENT_FOLLOWS, FRESH, TRIES, SINCE, LANE_WHOLES = range(8)
# Places in Lanes.real: length of the step in which a root or the section is sought; LATER of the step that is
# stashed; the level whose crossing is sought
LENGTH, DELTA, LEVEL, LANE_REALS = range(4)


class Functions(NamedTuple):
    """Functions of eight lanes that the loop calls: a structure's, and the method's (codegen.lanes)."""

    prepare: Callable
    jacobian: Callable
    rates: Callable
    finish: Callable
    base: Callable
    predict: Callable
    factor: Callable
    solve: Callable
    judge: Callable
    settle: Callable


class Parts(NamedTuple):
    """Parts of the loop that are called by address: what a lane does seldom (lane, attempts, approaches)."""

    enter: Callable
    event: Callable
    leave: Callable
    special: Callable
    approaches: Callable


class Variations(NamedTuple):
    """Functions that carry tangents: of their size, of the structure, and the gradient of its guards."""

    start: Callable
    point: Callable
    keep: Callable
    vary: Callable
    improve: Callable
    check: Callable
    follow: Callable
    due: Callable
    advance: Callable
    base: Callable
    rate: Callable
    remove: Callable
    shorten: Callable
    complete: Callable
    gradient: Callable


OF_ONE = "start", "vary", "improve", "check", "follow", "due", "rate", "shorten", "complete"
CALL, STAGE_CALL, OWN_CALL = void(vector), void(vector, INT), void(vector, vector)
SIGNATURES = dict.fromkeys(Functions._fields + Variations._fields, CALL)
SIGNATURES |= {"point": STAGE_CALL, "keep": STAGE_CALL, "gradient": ONE_BY_ONE["gradient"]}
SIGNATURES |= dict.fromkeys(OF_ONE, OWN_CALL) | {"remove": void(vector, vector, vector)}
FUNCTIONS, VARIATIONS = Record(Functions, SIGNATURES), Record(Variations, SIGNATURES)
