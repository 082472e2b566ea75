"""An ensemble, one trajectory in each of eight lanes: places of their numbers, and arrays of a run.

Row r of the one buffer `w` is w[8 r : 8 r + 8], a number of each of eight trajectories. Blocks are as long as
the largest structure needs, so that places are constants; a structure takes the beginning of each. Positions
are its angles and others, each with a speed; what laws of contact remember stays the same between events.
Parameters and what follows from these alone come last, as many as a structure has. What a lane does is
decided by its own numbers: its results are the same beside any others, in any lane.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

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


# One row each. Time and lengths: of this attempt, the next, the last step; what the control proposes …
T, END, H, H_NEXT, H_PAST, H_BEFORE, H_CONTROL, H_LIMIT, LATER, _next = _blocks(0, 9)
# … tolerances; sizes of updates; errors; largest turn of an angle; how low guards go; past the section
TOLERANCE, SIZE, SIZE_BEFORE, ERROR, ERROR_BEFORE, TURNED, LOW, CROSSED, _next = _blocks(_next, 8)
# … the section; attempts made and left; speed of an angle by which the longest step is bounded
AHEAD, DIRECTION, STEPS, LEFT, SWIFT, _next = _blocks(_next, 5)
# … what is so (1) or not (0): of an attempt's start, of its iteration, of its end, of what is done with it
OFFSET, SMOOTH, NEW, VARIANT, MISSES, JOINED, WAS_JOINED, REJECTION, ODD, _next = _blocks(_next, 9)
PASSES, CENTRE, PLAIN, WHOLE, TAKEN, KEEP, WITHIN, _next = _blocks(_next, 7)
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
# Of tangents (method.lanes.tangent): what is so of the iteration and of the base point; sizes, sums …
ACTIVE, STRAINED, FOLLOWS, DUE, NEW_SLOPES, _next = _blocks(_next, 5)
D_SIZE, D_RATIO, D_LENGTH, D_TOLERANCE, D_LIMIT, NEXT_ROW, TRACE, GAIN, _next = _blocks(_next, 8)
D_POSITION, D_SPEED, WEIGHT_POSITION, WEIGHT, RATE_BEFORE, _next = _blocks(_next, 5, N)
D_Z, D_W, D_F, D_PAST, _next = _blocks(_next, 4, N * STAGES)  # as those of the speeds
SLOPES, _next = _blocks(_next, 1, (1 + STAGES) * 2 * N * N)  # d rate / d state: base, stages
NUMBERS = _next  # parameters, and what follows from these alone

CALL, STAGE_CALL = void(vector), void(vector, INT)


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


class AtEvent(NamedTuple):
    """Functions of a structure at one point, for events (codegen.module)."""

    contacts: Callable
    trig: Callable
    reset: Callable


class Parts(NamedTuple):
    """Parts of the loop that are called by address: a trajectory enters, an event, a jump, approaches."""

    enter: Callable
    event: Callable
    jump: Callable
    approaches: Callable


class Variations(NamedTuple):
    """Functions that carry a tangent: of its size, of the structure, and the gradient of its guards."""

    start: Callable
    point: Callable
    keep: Callable
    vary: Callable
    improve: Callable
    judge: Callable
    settle: Callable
    base: Callable
    gradient: Callable


SIGNATURES = dict.fromkeys(Functions._fields + Variations._fields, CALL)
SIGNATURES |= {"point": STAGE_CALL, "keep": STAGE_CALL}
SIGNATURES["gradient"] = ONE_BY_ONE["gradient"]


FUNCTIONS, VARIATIONS = Record(Functions, SIGNATURES), Record(Variations, SIGNATURES)

# Places in Jobs.real, of one trajectory each
J_END, J_TOLERANCE, J_REST, J_NEAR, J_HOP, J_PLAY, J_H, J_SWIFT, J_LEVEL, J_PERIOD, J_FLOORS = range(11)
# … floors of positions and speeds; then of each contact, and jump: cone, gap, force, squared clearance
PER_CONTACT = 4
# Places in Jobs.whole
J_DIRECTION, J_SKIP, J_STOP, J_STEPS, J_EVENTS, J_MISSES = range(6)
# Places in Jobs.count
C_STEPS, C_REJECTED, C_FAILED, C_EVALUATIONS, C_EVENTS, C_SECTIONS, C_STATUS, COUNTS = range(8)
# Places in Jobs.place: the next trajectory, rows in the log, passes made, passes after which the loop pauses
NEXT, LOGGED, PASSED_BY, PAUSE, PLACES = range(5)
ASIDE = -1  # status of a trajectory that rests on a wall, or is at a dead centre: to be followed by itself
COLUMNS = 4  # of a log row before the record: trajectory, tag, contact, kind; then time, state, modes


class Jobs(NamedTuple):
    """Trajectories that wait, run, and are done."""

    state: np.ndarray
    numbers: np.ndarray
    real: np.ndarray
    whole: np.ndarray
    count: np.ndarray
    log: np.ndarray
    start: np.ndarray  # rows: time, positions, speeds, memories, modes
    final: np.ndarray
    place: np.ndarray


# Places in Lanes.whole, rows of eight
JOB, PHASE, AT, FRESH, TRIES, CLOSE, PASSED, SINCE, MODE = range(9)
LANE_WHOLES = MODE + CONTACTS
# Places in Lanes.real
T_EVENT, H_START, LENGTH, DELTA, LEVEL, LANE_REALS = 0, 1, 3, 4, 5, 6


class Settings(NamedTuple):
    """Options of a run (method.memory.Options) that method.walls.walls needs."""

    near: float
    rest: float
    hop: float
    play: float


class Lanes(NamedTuple):
    """State of eight lanes besides `w`, and scratch; numbers of positions, of memories, of contacts.

    The first positions are `phases`, and the last ones have no place in the structure's own state, which has
    `n_q`; sections cut the position `crank`. Contacts are those of the structure (of which there are flags),
    then jumps of the state. Arrays from `s` on are as those of a trajectory (method.memory).
    """

    n: int
    memories: int
    contacts: int
    phases: int
    crank: int
    n_q: int
    turning: np.ndarray  # 1 where a position is an angle, PHASE of a phase
    w: np.ndarray
    whole: np.ndarray
    real: np.ndarray
    stash: np.ndarray  # a column of a step that is looked into
    b: np.ndarray
    stack: np.ndarray
    s: np.ndarray
    p: np.ndarray
    m: np.ndarray
    contact: np.ndarray  # six numbers a contact (codegen.module)
    modes: np.ndarray
    flags: np.ndarray
    fired: np.ndarray
    margin: np.ndarray
