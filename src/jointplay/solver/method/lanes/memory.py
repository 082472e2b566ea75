"""Arrays of a run over an ensemble, allocated; and their types, with which its parts are compiled."""

import numpy as np

from ..interface import INT, SIGNATURES, Record, void
from ..memory import STACK, lane_rows, trajectory
from . import CONTACTS
from . import layout as rows

ROOM = 8 * (3 * CONTACTS + 2)  # log rows that one pass may need: in each lane approaches, an event, a section


def jobs(
    states: np.ndarray, numbers: np.ndarray, real: np.ndarray, whole: np.ndarray, contacts: int, log: int
) -> rows.Jobs:
    """Waiting trajectories: their states, parameters, and requests (layout)."""
    n, record = len(states), 1 + states.shape[1] + contacts
    return rows.Jobs(
        state=np.ascontiguousarray(states),
        numbers=np.ascontiguousarray(numbers),
        real=real,
        whole=whole,
        count=np.zeros((n, rows.COUNTS), dtype=np.int64),
        log=np.zeros((log + ROOM, rows.COLUMNS + record)),
        start=np.zeros((n, record)),
        final=np.zeros((n, record)),
        place=np.zeros(rows.PLACES, dtype=np.int64),
    )


def lanes(
    size: int,
    parameters: int,
    turning: np.ndarray,
    crank: int,
    memories: int,
    flags: np.ndarray,
    sizes: dict[str, int],
) -> rows.Lanes:
    """Eight empty lanes of a structure: rows, parameters, which positions turn, memories, contacts' flags.

    Sections cut the position `crank`; `sizes` are those of the structure's module.
    """
    n, contacts, jumps = len(turning), len(flags), sizes["resets"]
    n_q, speeds, angles = (sizes[name] for name in ("positions", "speeds", "angles"))
    state = np.zeros(1 + n_q + speeds)
    x = trajectory(state, np.zeros(parameters), n_q, angles, contacts, jumps)._replace(flags=flags)
    k = rows.Lanes(
        n=n,
        memories=memories,
        contacts=contacts + jumps,
        phases=n + memories - speeds,
        crank=crank,
        n_q=n_q,
        turning=turning,
        w=lane_rows(size),
        whole=np.zeros(8 * rows.LANE_WHOLES, dtype=np.int64),
        real=np.zeros(8 * rows.LANE_REALS),
        stash=lane_rows(rows.STEP_END),
        b=np.zeros(16),
        stack=np.zeros(STACK),
        s=x.s,
        p=x.p,
        m=x.m,
        contact=np.zeros(max(6 * (contacts + jumps), 1)),
        modes=x.modes,
        flags=x.flags,
        fired=x.fired,
        margin=x.margin,
    )
    k.whole[8 * rows.JOB : 8 * rows.JOB + 8] = -1
    return k


_NONE = np.zeros(1, dtype=np.int64)
JOBS = Record.of(jobs(np.zeros((1, 1)), np.zeros((1, 1)), np.zeros((1, 1)), _NONE.reshape(1, 1), 1, 1))
_SIZES = dict.fromkeys(("positions", "speeds", "angles", "resets"), 1)
LANES = Record.of(lanes(1, 1, np.zeros(1), 0, 0, _NONE, _SIZES))
AT_EVENT = Record(rows.AtEvent, SIGNATURES)
PART = void(AT_EVENT, LANES, JOBS, INT)
PARTS = Record(rows.Parts, dict.fromkeys(rows.Parts._fields, PART))


def nothing(f, k, j, i):
    """Do nothing, and never be called: in the place of a part that is not needed."""


nothing.address = 0
