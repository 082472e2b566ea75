"""State of a trajectory while it is computed: plain arrays, allocated once, and the options of a run.

All that a run needs to go on lies here, so that it can be left between two steps and taken up again, with
the same result to the last bit. In all of the method the same words stand for

    functions    of the structure, and the method's algebra for its size (interface.Functions)
    work         scratch of the method (Work)
    motion       state, parameters, modes, counters, and what has been recorded (Trajectory)
    options      of the run (Options)
    derivatives  of the functions, for tangents (interface.Variations); None: none are carried along
    tangents     a frame of tangent vectors (tangents.tangent.Tangents); None: there is none

A lane row holds a quantity at the eight places of a step at which equations are taken at once: row r of the
buffer work.w is w[8 r : 8 r + 8], lanes 0 to 6 at the seven stages (lane 6 is the step's end), lane 7 at its
base point, the motion's s. Rows follow each other as

    0                the method's own, or those of a structure's plan (codegen.elimination)
    options.first    the increment of time from the base point on; then of each position and speed; then the
                     rate of each speed; then how far each loop is from its dead centre
                     (equations.system.System.folds)
    options.guards   four guards of each contact (gap, force, sliding speed, cone); then of each rigid wall;
                     of each one's friction, where walls are rough (sliding speed, or cone while a body
                     sticks); the section quantity if there is one, and the power of each integral

as codegen.source.Layout counts them. An argument `at` is a place in such a buffer (8 r), `row` the number r.
"""

from typing import NamedTuple

import numpy as np

from .codes import Row

# Places in Trajectory.count: what has been done
STEPS, REJECTED, FAILED, EVALUATIONS, EVENTS, SECTIONS, SAMPLES, LOGGED = range(8)
CLOSE_EVENTS = 8  # events in a row of which each followed the last within the chatter time
BASE_SET = 9  # 1: sines, masks and weights are those of the base point
SMOOTH = 10  # 1: the next step may be extrapolated from the one before
SECTION_SIDE, LEVELS_PASSED = 11, 12  # side (+1, -1) of the section's level; levels that have been passed
STARTED = 13  # 1: the initial modes are set
SIMULTANEOUS = 14  # impacts at one instant, of which there is no derivative
IDLE_STEPS = 15  # steps in a row that moved nothing
JAMMED = 16  # rigid contacts without an answer
FOLLOWED = 17  # events that another one has brought about, at its time
COUNTERS = 18
# Places in Trajectory.real
H, H_PAST, ERROR_PAST, H_REJECTED, ERROR_REJECTED = range(5)  # next step; last accepted; last rejected
CONTRACTION = 5  # of Newton's iteration in the last step
LEVEL = 6  # of the section
T_EVENT, T_SECTION = 7, 8  # times of the last event and section point
H_LIMIT = 9  # longest step since one failed
H_VARIANT, H_START = 10, 13  # of each variant: last length; length of the step after an event, 0: none learnt
COARSENESS = 16  # of the last step (coarse_steps)
H_EXCITED = 17  # longest step that follows modes that grow (excited)
GROWTH = 18  # given: rate from which on such a mode is followed, 1/s; 0: none is
REBOUND_ERROR = 19  # given: speed by which rebounds left out may be wrong, as the wall turns meanwhile
FARTHEST = 20  # of the section's quantity from its level
NUMBERS = 21
# Tags of log rows (floats, as their rows), and where their columns begin
STEP_ROW, EVENT_ROW, SECTION_ROW, MISS_ROW, COARSE_ROW = map(float, Row)
DRIVE, JOINTS = 0, 1  # places of the drive's and the joints' work among the integrals of a linkage
COLUMNS = 3
HALVINGS = 40  # of an interval, to isolate roots
STACK = 10 * (HALVINGS + 2)
# Places in Work.impact: rates that unit impulses make, then rows of SIZE, a system of equations, the share of
# restitution, and the state before; behind them room to keep them.
MOST = 6  # walls at once
SIZE = 2 * MOST  # unknowns of an impact: impulses along both directions of each
MATRIX, BEFORE, AFTER, PUSH, BEST, TARGET, WALL, FRICTION, CHOICE, CHOSEN = (
    SIZE * at for at in (0, *range(SIZE, SIZE + 9))
)
EQUATIONS = SIZE * (SIZE + 9)
MEMBERS, SHARE, STATE = range(EQUATIONS + SIZE * (SIZE + 1), EQUATIONS + SIZE * (SIZE + 1) + 3)


class Work(NamedTuple):
    """Scratch of the method; a lane row is eight doubles."""

    w: np.ndarray  # lane buffer: the method's rows, then the structure's
    J: np.ndarray  # Jacobian, rows of positions and speeds; of many unknowns, the values of a plan
    predicted: np.ndarray  # a state ahead, as Trajectory.s, at which J is taken
    past: np.ndarray  # increments of the last accepted step
    whole: np.ndarray  # increments of a step that is being shortened
    gain: np.ndarray  # increments of the work in the step
    weight: np.ndarray  # 1 / tolerated error of each state
    error: np.ndarray  # estimated error of each state
    b: np.ndarray  # eight Bernstein coefficients, then a Lagrange basis
    stack: np.ndarray  # intervals of the root isolation
    contact: np.ndarray  # six numbers a contact, then a rigid wall, then a wall's friction
    impact: np.ndarray  # of impacts on several walls, or with friction (impacts)
    eigen: (
        np.ndarray
    )  # of the equations about a state: J, then a matrix whose eigenvalues are found (excited)


class Trajectory(NamedTuple):
    """State of a run, its numbers, its controls, and its records."""

    s: np.ndarray  # time, positions, speeds, sines, cosines
    p: np.ndarray  # parameters of the structure
    m: np.ndarray  # masks of the modes
    absolute: np.ndarray  # tolerated error of each state: absolute
    relative: np.ndarray  # … and relative
    turning: np.ndarray  # 1 where a position is an angle
    work: np.ndarray  # integrals of the powers since the start
    modes: np.ndarray  # mode of each contact, then of each rigid wall
    flags: np.ndarray  # PULLS, STICKS of each contact
    fired: np.ndarray  # multiplicity with which each guard starts at zero
    margin: np.ndarray  # of each guard: values up to it are within the tolerance of zero; 0: none
    clearance_squared: np.ndarray  # square of each contact's clearance; inf: it has no centre
    group: np.ndarray  # of each rigid wall: those of one number slide as one; below 0: it has no impulses
    cone: np.ndarray  # margin of each contact's cone over its normal force; of a wall's, over its square
    count: np.ndarray  # STEPS, …
    real: np.ndarray  # H, …
    sample_times: np.ndarray  # ascending
    samples: np.ndarray  # rows: time, positions, speeds, modes, work
    log: np.ndarray  # rows: tag, contact, kind, then as samples


class Options(NamedTuple):
    """Options of a run. Times in s (or the system's own unit)."""

    n_q: int  # positions
    n: int  # speeds
    first: int  # lane row of the time increment; the state's rows follow, then the rates'
    guards: int  # lane row of the first guard; those of resets, section and powers follow
    t_end: float
    h_max: float
    newton: float  # tolerance of the iteration in units of the tolerated error
    chatter_time: float  # events closer than this, one after another, are chatter
    speed_tolerance: float  # speeds at a contact up to this are within the tolerance of zero
    height_tolerance: float  # heights of a rebound, likewise
    bends: int  # 1: guards may turn faster than the state does
    gap_rounding: float  # rounding of a rigid wall's gap; 0: none that matters
    max_steps: int  # attempts
    log_from: float  # time from which steps and events are logged
    log_steps: int
    log_events: int
    log_misses: int  # closest approaches in flight
    rate_tolerance: (
        float  # tolerated error of a recorded rate, in those of its speed, a second; 0: none is recorded
    )
    section: int  # codes.Section
    direction: int  # of the level crossing
    period: float  # added to the level at each crossing; 0: the level stays
    section_event: int
    section_contact: int  # -1: any
    skip: int  # crossings not logged
    stop_after: int  # crossings after which the run ends; 0: never


def lane_rows(n: int) -> np.ndarray:
    """Zeros for n lane rows, from a multiple of 64 bytes on: so that a row is one cache line, and not two."""
    room = np.zeros(8 * n + 7)
    skip = (-(room.ctypes.data // 8)) % 8
    return room[skip : skip + 8 * n]


def method_rows(n: int) -> int:
    """Lane rows of the written-out algebra, before the structure's rows: W, R, X, a row of squares, E."""
    return 3 * n + 1 + n * n


def work(n_s: int, n_q: int, n: int, n_touch: int, n_powers: int, n_rows: int, n_jacobian: int) -> Work:
    """Allocate the scratch of a structure: `n_s` numbers in s, `n_rows` lane rows, `n_jacobian` in J.

    `n_touch`: contacts, rigid walls, and these again where they are rough.
    """
    return Work(
        w=lane_rows(n_rows),
        J=np.zeros(n_jacobian),
        predicted=np.zeros(n_s),
        past=lane_rows(n_q + n),
        whole=lane_rows(n_q + n),
        gain=lane_rows(n_powers),
        weight=np.zeros(n_q + n),
        error=np.zeros(n_q + n),
        b=lane_rows(2),
        stack=np.zeros(STACK),
        contact=np.zeros(max(6 * n_touch, 1)),
        impact=np.zeros(2 * (STATE + n_s)),
        eigen=np.zeros((n + n_q + n) * (n_q + n)),
    )


def trajectory(
    state: np.ndarray,
    numbers: np.ndarray,
    n_q: int,
    n_angles: int,
    n_contacts: int,
    n_resets: int,
    n_rubs: int = 0,
) -> Trajectory:
    """Allocate a run that starts at `state` (time, positions, speeds) with the structure's numbers.

    `n_rubs`: resets that are watched for slip and sticking.
    """
    n_x, n_guards = len(state) - 1, 4 * n_contacts + n_resets + n_rubs
    return Trajectory(
        s=np.concatenate([state, np.zeros(2 * n_angles)]),
        p=np.array(numbers, dtype=float),
        m=np.zeros(max(3 * (n_contacts + n_resets), 1)),
        absolute=np.zeros(n_x),
        relative=np.zeros(n_x),
        turning=np.zeros(max(n_q, 1)),
        work=np.zeros(0),
        modes=np.zeros(n_contacts + n_resets, dtype=np.int64),
        flags=np.zeros(n_contacts, dtype=np.int64),
        fired=np.zeros(n_guards, dtype=np.int64),
        margin=np.zeros(n_guards),
        clearance_squared=np.full(n_contacts, np.inf),
        group=np.arange(n_resets),
        cone=np.zeros(n_contacts + n_resets),
        count=np.zeros(COUNTERS, dtype=np.int64),
        real=np.zeros(NUMBERS),
        sample_times=np.zeros(0),
        samples=np.zeros((0, 1)),
        log=np.zeros((0, 1)),
    )
