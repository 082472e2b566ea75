"""The loop over an ensemble: eight trajectories at once, finished ones replaced, until none waits.

A pass is one attempt of every lane, in lanes (codegen.ensemble); what is not plain goes through `attempts`,
events through numerics.modes, as those of one trajectory do.
"""

import numpy as np
from numba import int64, typeof, types

from ..control import FULL, OK
from ..interface import AT_POINT, entry, inlined
from ..memory import STACK, lane_rows, trajectory
from . import CONTACTS, tangent
from . import layout as rows
from .attempts import special
from .lane import ends, enter, event, leave
from .tangent import base_slopes, carry, jump, lay_down, renew, take_up

ROOM = 8 * (3 * CONTACTS + 2)  # log rows that one pass may need: in each lane approaches, an event, a section


def jobs(
    states: np.ndarray, numbers: np.ndarray, real: np.ndarray, whole: np.ndarray, contacts: int, log: int
) -> rows.Jobs:
    """Trajectories that wait: their states, parameters, and what each is asked for (layout)."""
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
        x=x,
    )
    k.whole[8 * rows.JOB : 8 * rows.JOB + 8] = -1
    return k


@inlined
def _refill(f, k, j, y):
    """Fill free lanes with what waits; how many lanes run, and whether any is new."""
    running, new = 0, False
    for i in range(8):
        if k.whole[8 * rows.JOB + i] < 0 and j.place[rows.NEXT] < len(j.state):
            enter(f, k, j, i, j.place[rows.NEXT])
            if y is not None:
                take_up(k, j, y, i)
            j.place[rows.NEXT] += 1
            new = True
        if k.whole[8 * rows.JOB + i] >= 0:
            running += 1
    return running, new


@inlined
def _attempt(g, w):
    """One attempt of every lane: three updates, which nearly all need; the rest go on in the next."""
    g.predict(w)
    g.jacobian(w)
    g.factor(w)
    for _ in range(rows.UPDATES):
        g.rates(w)
        g.solve(w)
    g.finish(w)
    g.judge(w)


def run(f, g, k, j, v, y):
    """Run until all trajectories are done (OK), or the log is full, or it is time for a pause (FULL).

    Then empty the log, set the next pause and call again. With tangents y, and functions v that carry them,
    these go along (ensemble.tangent_flow); where both are None, nothing of that is compiled.
    """
    w, ended = k.w, True
    while True:
        if ended:
            ended = False
            running, new = _refill(f, k, j, y)
            if running == 0:
                return OK
            if new:
                g.prepare(w)
                g.base(w)
                if y is not None:
                    base_slopes(g, v, w)
                    _renew(k, y)
        if j.place[rows.LOGGED] + ROOM > len(j.log) or j.place[rows.PASSED_BY] >= j.place[rows.PAUSE]:
            return FULL
        if y is not None and y.count[0] + tangent.ROOM > len(y.rows):
            return FULL
        _attempt(g, w)
        if y is not None:
            carry(g, v, w)
        j.place[rows.PASSED_BY] += 1
        odd, events = 0, 0
        for i in range(8):
            if w[8 * rows.PLAIN + i] == 0.0 and k.whole[8 * rows.JOB + i] >= 0:
                odd |= 1 << i
                if special(k, j, i):
                    events |= 1 << i
        if y is not None:
            v.settle(w)
        g.settle(w)
        if events:
            for i in range(8):
                if events >> i & 1:
                    event(f, k, j, i, v, y)
            g.base(w)
            if y is not None:
                base_slopes(g, v, w)
                for i in range(8):
                    if events >> i & 1:
                        jump(k, y, i)
        if y is not None:
            _renew(k, y)
        for i in range(8):
            if odd >> i & 1 and ends(k, j, i):
                if y is not None:
                    lay_down(k, y, i)
                leave(k, j, i)
                ended = True


@inlined
def _renew(k, y):
    """See to the tangents where something is due."""
    for i in range(8):
        if k.w[8 * rows.DUE + i] > 0.0 and k.whole[8 * rows.JOB + i] >= 0:
            renew(k, y, i)


_NONE = np.zeros(1, dtype=np.int64)
JOBS = typeof(jobs(np.zeros((1, 1)), np.zeros((1, 1)), np.zeros((1, 1)), _NONE.reshape(1, 1), 1, 1))
_SIZES = dict.fromkeys(("positions", "speeds", "angles", "resets"), 1)
LANES = typeof(lanes(1, 1, np.zeros(1), 0, 0, _NONE, _SIZES))
flow = entry(int64(AT_POINT, rows.FUNCTIONS, LANES, JOBS, types.none, types.none))(run)
