"""An ensemble, one trajectory in each of eight lanes: where their numbers lie, and what a run holds.

Row r of the one buffer `w` is w[8 r : 8 r + 8], a number of each of eight trajectories. All have three
angles and one contact; parameters and what follows from these alone come last, as many as a structure has.
What a lane does is decided by its own numbers: its results are the same beside any others, in any lane.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numba import types, void

from ..interface import vector
from .radau import STAGES

N = 3  # angles, and so speeds
UPDATES = 3  # of Newton's iteration in one attempt
NOTHING = 1e-6  # an update of this size ends it whatever came before
GUARDS = 4  # of the contact: gap, force, sliding speed, cone


class _Rows:
    """Gives out the rows of the buffer, block after block."""

    def __init__(self) -> None:
        self.given = 0

    def block(self, size: int) -> int:
        """First row of a block of so many."""
        self.given += size
        return self.given - size

    def blocks(self, many: int, size: int = 1) -> list[int]:
        """First rows of so many blocks of one size."""
        return [self.block(size) for _ in range(many)]


_rows = _Rows()
# One row each. Time and lengths: of this attempt, the next, the last step; what the control proposes …
T, END, H, H_NEXT, H_PAST, H_BEFORE, H_CONTROL, H_LIMIT, LATER = _rows.blocks(9)
# … tolerances; sizes of updates; errors; largest turn of an angle; how low guards go; past the section
TOLERANCE, FLOOR, SIZE, SIZE_BEFORE, ERROR, ERROR_BEFORE, TURNED, LOW, CROSSED = _rows.blocks(9)
# … the section; squared clearance; the cone's margin over F_n; attempts made and left
AHEAD, DIRECTION, BUSH, CONE, STEPS, LEFT = _rows.blocks(6)
# … what is so (1) or not (0): of an attempt's start, of its iteration, of its end, of what is done with it
OFFSET, SMOOTH, NEW, VARIANT, MISSES, JOINED, WAS_JOINED, REJECTION, ODD = _rows.blocks(9)
PASSES, SWINGS, PLAIN, WHOLE, TAKEN, KEEP = _rows.blocks(6)
H_VARIANT = _rows.block(2)  # lengths that served last in flight and in contact
MASK = _rows.block(3)  # touch, slip, stick
POSITION, SPEED, SINE, COSINE, ACCELERATION = _rows.blocks(5, N)
GUARD, SIDE, FIRED, MARGIN = _rows.blocks(4, GUARDS)  # values at the base, …
X, Y, RATE = _rows.blocks(3, N)  # a point at which the equations are taken, and what they give
WATCHED = _rows.block(GUARDS)
JACOBIAN = _rows.block(2 * N * N)  # d rate / d state
INVERSE, PAIRS = _rows.block(N * N), _rows.block(2 * 2 * N * N)  # of the real system; of the complex ones
Z, W, F, PAST = _rows.blocks(4, N * STAGES)  # stages of the speeds: increments, …
WATCHES = _rows.block(GUARDS * STAGES)  # guards at the stages
NUMBERS = _rows.given  # parameters, and what follows from these alone

CALL = void(vector)


class Functions(NamedTuple):
    """What the loop calls, all of eight lanes: a structure's, and the method's (codegen.ensemble)."""

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


SIGNATURES = dict.fromkeys(Functions._fields, CALL)
FUNCTIONS = types.NamedTuple([types.FunctionType(CALL)] * len(SIGNATURES), Functions)

# Places in Jobs.real, of one trajectory each
J_END, J_TOLERANCE, J_FLOOR, J_REST, J_NEAR, J_H, J_CONE, J_GAP, J_FORCE = range(9)
J_BUSH, J_LEVEL, J_PERIOD = range(9, 12)
# Places in Jobs.whole
J_DIRECTION, J_SKIP, J_STOP, J_STEPS, J_EVENTS, J_MISSES, J_FLAGS = range(7)
# Places in Jobs.count
C_STEPS, C_REJECTED, C_FAILED, C_EVALUATIONS, C_EVENTS, C_SECTIONS, C_STATUS, COUNTS = range(8)
# Places in Jobs.place: the next trajectory, rows in the log, passes made, passes after which the loop pauses
NEXT, LOGGED, PASSED_BY, PAUSE, PLACES = range(5)
COLUMNS = 4  # of a log row before the record: trajectory, tag, contact, kind
RECORD = 2 + 2 * N  # time, angles, speeds, mode


class Jobs(NamedTuple):
    """Trajectories that wait, run, and are done."""

    state: np.ndarray
    numbers: np.ndarray
    real: np.ndarray
    whole: np.ndarray
    count: np.ndarray
    log: np.ndarray
    start: np.ndarray  # rows: time, angles, speeds, mode
    final: np.ndarray
    place: np.ndarray


# Places in Lanes.whole, rows of eight
JOB, MODE, PHASE, AT, FRESH, TRIES, CLOSE, PASSED, SINCE, LANE_WHOLES = range(10)
# Places in Lanes.real
T_EVENT, H_START, LENGTH, DELTA, LEVEL, LANE_REALS = 0, 1, 3, 4, 5, 6


class Lanes(NamedTuple):
    """What eight lanes hold beside `w`, and scratch."""

    w: np.ndarray
    whole: np.ndarray
    real: np.ndarray
    stash: np.ndarray  # a column of a step that is looked into
    b: np.ndarray
    stack: np.ndarray
    s: np.ndarray
    p: np.ndarray
    m: np.ndarray
    out: np.ndarray
    modes: np.ndarray
    flags: np.ndarray
    fired: np.ndarray
