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
from .tangent import base_slopes, before_event, carry, follow, jump, lay_down, renew, take_up


@inlined
def _refill(functions, parts, lanes, jobs, tangents):
    """Fill free lanes with waiting trajectories; the number of running lanes, and whether any is new."""
    running, new = 0, False
    for i in range(8):
        if lanes.whole[8 * rows.JOB + i] < 0 and jobs.place[rows.NEXT] < len(jobs.status):
            lanes.whole[8 * rows.JOB + i] = jobs.place[rows.NEXT]
            parts.enter(functions, lanes, jobs, i)
            if tangents is not None:
                take_up(lanes, jobs, tangents, i)
            jobs.place[rows.NEXT] += 1
            new = True
        if lanes.whole[8 * rows.JOB + i] >= 0:
            running += 1
    return running, new


@inlined
def _attempt(vectorised, w):
    """One attempt of every lane: three updates, which nearly all need; the rest go on in the next."""
    vectorised.predict(w)
    vectorised.jacobian(w)
    vectorised.factor(w)
    for _ in range(rows.UPDATES):
        vectorised.rates(w)
        vectorised.solve(w)
    vectorised.finish(w)
    vectorised.judge(w)


@inner
def run(functions, parts, vectorised, lanes, jobs, derivatives, tangents, frame):
    """Run until all trajectories are done (OK), or the log is full, or it is time for a pause (FULL).

    Then empty the log, set the next pause and call again. With tangents, derivatives that carry them and a
    frame, these go along (lanes.tangent_flow); where all are None, nothing of that is compiled.
    """
    w, ended = lanes.w, True
    while True:
        if ended:
            ended = False
            running, new = _refill(functions, parts, lanes, jobs, tangents)
            if running == 0:
                return OK
            if new:
                vectorised.prepare(w)
                vectorised.base(w)
                if tangents is not None:
                    base_slopes(vectorised, derivatives, w)
                    _renew(lanes, tangents, frame)
        place = jobs.place
        if place[rows.LOGGED] + rows.ROOM > len(jobs.log) or place[rows.PASSED_BY] >= place[rows.PAUSE]:
            return FULL
        if tangents is not None and tangents.count[0] + tangent.ROOM > len(tangents.rows):
            return FULL
        _attempt(vectorised, w)
        if tangents is not None:
            carry(vectorised, derivatives, w, tangents)
        jobs.place[rows.PASSED_BY] += 1
        odd, events = 0, 0
        for i in range(8):
            if w[8 * rows.PLAIN + i] == 0.0 and lanes.whole[8 * rows.JOB + i] >= 0:
                odd |= 1 << i
                parts.special(functions, lanes, jobs, i)
                events |= lanes.whole[8 * rows.EVENT_FOLLOWS + i] << i
                if w[8 * rows.TAKEN + i] > 0.0 and w[8 * rows.PASSES + i] > 0.0:
                    parts.approaches(functions, lanes, jobs, i)
        if tangents is not None:
            follow(derivatives, w, tangents)
        vectorised.settle(w)
        if events:
            for i in range(8):
                if events >> i & 1:
                    if tangents is not None:
                        before_event(functions, derivatives, lanes, jobs, tangents, i)
                    parts.event(functions, lanes, jobs, i)
            vectorised.base(w)
            if tangents is not None:
                base_slopes(vectorised, derivatives, w)
                for i in range(8):
                    if events >> i & 1:
                        jump(lanes, jobs, tangents, frame, i)
        if tangents is not None:
            _renew(lanes, tangents, frame)
        for i in range(8):
            if odd >> i & 1 and ends(lanes, jobs, i):
                if tangents is not None:
                    lay_down(lanes, tangents, frame, i)
                parts.leave(functions, lanes, jobs, i)
                ended = True


@inlined
def _renew(lanes, tangents, frame):
    """See to the tangents where something is due."""
    for i in range(8):
        if lanes.w[8 * rows.DUE + i] > 0.0 and lanes.whole[8 * rows.JOB + i] >= 0:
            renew(lanes, tangents, frame, i)


flow = run
UNIT = {"flow": Signature(INT, (FUNCTIONS, PARTS, rows.FUNCTIONS, LANES, JOBS, None, None, None))}
