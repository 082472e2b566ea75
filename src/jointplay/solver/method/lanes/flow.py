"""The loop over an ensemble: eight trajectories at once, finished ones replaced, until none waits.

A pass is one attempt of every lane, in lanes (codegen.lanes); what is not plain goes through `attempts`.
What a lane does seldom (lane, attempts, approaches) is compiled by itself, and called by address: for the
loop with tangents and without.
"""

from ..control import FULL, OK
from ..interface import FUNCTIONS, INT, Signature, inlined, inner
from . import layout as rows
from . import tangent
from .lane import ends
from .memory import JOBS, LANES, PARTS
from .tangent import base_slopes, before_event, carry, jump, lay_down, renew, take_up


@inlined
def _refill(f, parts, e, j, y):
    """Fill free lanes with waiting trajectories; the number of running lanes, and whether any is new."""
    running, new = 0, False
    for i in range(8):
        if e.whole[8 * rows.JOB + i] < 0 and j.place[rows.NEXT] < len(j.status):
            e.whole[8 * rows.JOB + i] = j.place[rows.NEXT]
            parts.enter(f, e, j, i)
            if y is not None:
                take_up(e, j, y, i)
            j.place[rows.NEXT] += 1
            new = True
        if e.whole[8 * rows.JOB + i] >= 0:
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


@inner
def run(f, parts, g, e, j, v, y, t):
    """Run until all trajectories are done (OK), or the log is full, or it is time for a pause (FULL).

    Then empty the log, set the next pause and call again. With tangents y, functions v that carry them and
    a frame t, these go along (lanes.tangent_flow); where all are None, nothing of that is compiled.
    """
    w, ended = e.w, True
    while True:
        if ended:
            ended = False
            running, new = _refill(f, parts, e, j, y)
            if running == 0:
                return OK
            if new:
                g.prepare(w)
                g.base(w)
                if y is not None:
                    base_slopes(g, v, w)
                    _renew(e, y, t)
        if j.place[rows.LOGGED] + rows.ROOM > len(j.log) or j.place[rows.PASSED_BY] >= j.place[rows.PAUSE]:
            return FULL
        if y is not None and y.count[0] + tangent.ROOM > len(y.rows):
            return FULL
        _attempt(g, w)
        if y is not None:
            carry(g, v, w)
        j.place[rows.PASSED_BY] += 1
        odd, events = 0, 0
        for i in range(8):
            if w[8 * rows.PLAIN + i] == 0.0 and e.whole[8 * rows.JOB + i] >= 0:
                odd |= 1 << i
                parts.special(f, e, j, i)
                events |= e.whole[8 * rows.MEETS + i] << i
                if w[8 * rows.TAKEN + i] > 0.0 and w[8 * rows.PASSES + i] > 0.0:
                    parts.approaches(f, e, j, i)
        if y is not None:
            v.settle(w)
        g.settle(w)
        if events:
            for i in range(8):
                if events >> i & 1:
                    if y is not None:
                        before_event(f, v, e, j, y, i)
                    parts.event(f, e, j, i)
            g.base(w)
            if y is not None:
                base_slopes(g, v, w)
                for i in range(8):
                    if events >> i & 1:
                        jump(e, j, y, t, i)
        if y is not None:
            _renew(e, y, t)
        for i in range(8):
            if odd >> i & 1 and ends(e, j, i):
                if y is not None:
                    lay_down(e, y, t, i)
                parts.leave(f, e, j, i)
                ended = True


@inlined
def _renew(e, y, t):
    """See to the tangents where something is due."""
    for i in range(8):
        if e.w[8 * rows.DUE + i] > 0.0 and e.whole[8 * rows.JOB + i] >= 0:
            renew(e, y, t, i)


flow = run
UNIT = {"flow": Signature(INT, (FUNCTIONS, PARTS, rows.FUNCTIONS, LANES, JOBS, None, None, None))}
