"""Arrays of a run over an ensemble, allocated; and their types, with which its parts are compiled.

In all of the lanes' method the same words stand for

    functions    of the structure at a point, as one trajectory has them (interface.Functions)
    vectorised   functions of eight lanes (layout.Functions)
    derivatives  functions of eight lanes that carry tangents (layout.Variations); None: none are carried
    lanes        the state of eight lanes (Lanes), i the number of one
    jobs         trajectories that wait, run, and are done (Jobs)
    tangents     of these (tangent.Tangents); None: there are none
    frame        of tangents as one trajectory has it (tangents.tangent.Tangents): scratch

and work, motion, options for what a trajectory by itself has (method.memory), with which the plain functions
are called.
"""

from typing import NamedTuple

import numpy as np

from ..interface import FUNCTIONS, INT, Array, Record, void
from ..memory import COLUMNS, lane_rows
from . import layout as rows


class Jobs(NamedTuple):
    """Trajectories that wait, run, and are done: their arrays and options, as of one (method.memory).

    These are tables (interface.table). The trajectories share scratch and a log, whose rows end with the
    trajectory's number.
    """

    work: np.ndarray
    motions: np.ndarray
    options: np.ndarray
    phases: np.ndarray  # of each trajectory at its start: phases, then their rates
    status: np.ndarray
    start: np.ndarray  # rows: time, state, modes
    log: np.ndarray
    place: np.ndarray


class Lanes(NamedTuple):
    """State of eight lanes beside `w`; numbers of positions, of memories.

    The first positions are `phases`, and the last ones have no place in the structure's own state, which has
    `n_q`; sections cut the position `crank`.
    """

    n: int
    memories: int
    phases: int
    crank: int
    n_q: int
    turning: np.ndarray  # 1 where a position is an angle, PHASE of a phase
    w: np.ndarray
    whole: np.ndarray
    real: np.ndarray
    stash: np.ndarray  # a column of a step that is looked into


def jobs(tables: tuple, phases: np.ndarray, start: np.ndarray, log: np.ndarray) -> Jobs:
    """Waiting trajectories: tables of their scratch, arrays and options, and their phases."""
    n = len(start)
    place = np.zeros(rows.PLACES, dtype=np.int64)
    return Jobs(*tables, np.ascontiguousarray(phases), np.zeros(n, dtype=np.int64), start, log, place)


def shared_log(n: int, width: int) -> np.ndarray:
    """A log of n rows, and of what one pass may need, for records of a width."""
    return np.zeros((n + rows.ROOM, COLUMNS + width + 1))


def lanes(size: int, turning: np.ndarray, crank: int, memories: int, sizes: dict[str, int]) -> Lanes:
    """Eight empty lanes of a structure: rows, which positions turn, how many speeds are memories.

    Sections cut the position `crank`; `sizes` are those of the structure's module.
    """
    n = len(turning)
    made = Lanes(
        n=n,
        memories=memories,
        phases=n + memories - sizes["speeds"],
        crank=crank,
        n_q=sizes["positions"],
        turning=turning,
        w=lane_rows(size),
        whole=np.zeros(8 * rows.LANE_WHOLES, dtype=np.int64),
        real=np.zeros(8 * rows.LANE_REALS),
        stash=lane_rows(rows.STEP_END),
    )
    made.whole[8 * rows.JOB : 8 * rows.JOB + 8] = -1
    return made


def nothing(functions, lanes, jobs, i):
    """Do nothing, and never be called: in the place of a part that is not needed."""


nothing.address = 0


TABLE, TWO_AXES, WHOLE = Array(INT, 2), Array(axes=2), Array(INT)
JOBS = Record(
    Jobs,
    {
        **dict.fromkeys(("work", "motions", "options"), TABLE),
        **dict.fromkeys(("phases", "start", "log"), TWO_AXES),
        **dict.fromkeys(("status", "place"), WHOLE),
    },
)
LANES = Record.of(lanes(1, np.zeros(1), 0, 0, {"positions": 1, "speeds": 1}))
PART = void(FUNCTIONS, LANES, JOBS, INT)
PARTS = Record(rows.Parts, dict.fromkeys(rows.Parts._fields, PART))
