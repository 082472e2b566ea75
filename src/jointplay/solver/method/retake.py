"""Doubtful steps followed again, compiled only where accelerations are recorded (analysis.rates)."""

from numpy import inf

from . import flow as _flow
from .coarse_steps import END, FIRED, TIME
from .interface import FUNCTIONS, INT, OPTIONS, TRAJECTORY, WORK, Array, inner, until, void
from .memory import GROWTH, H_LIMIT, SAMPLES, STARTED, T_EVENT, T_SECTION, H

PARTS = 2  # steps at least
BEGUN = 1e-2  # of a step: the first one again


@inner
def _resume(row, n_x, x):
    """Begin at a doubt's base point, as if the run had come here."""
    modes, work = TIME + 1 + n_x, TIME + 1 + n_x + len(x.modes)
    for i in range(1 + n_x):
        x.s[i] = row[TIME + i]
    for j in range(len(x.modes)):
        x.modes[j] = int(row[modes + j])
    for i in range(len(x.work)):
        x.work[i] = row[work + i]
    fired = int(row[FIRED])
    for g in range(len(x.fired)):
        x.fired[g], fired = fired % 4, fired // 4
    for i in range(len(x.count)):
        x.count[i] = 0
    for i in range(GROWTH):
        x.real[i] = 0.0
    x.count[STARTED], x.real[H_LIMIT] = 1, inf
    x.real[T_EVENT], x.real[T_SECTION] = -inf, -inf
    x.real[H] = BEGUN * (row[END] - row[TIME])


@inner
def again(flow, f, k, x, o, doubts, first):
    """Follow each step in doubt; samples from number first[d] on are within the step of doubt d.

    The flow (flow.flow) comes as an address: joined to this loop, it would be compiled a second time.
    """
    for d in range(len(doubts)):
        _resume(doubts[d], o.n_q + o.n, x)
        x.count[SAMPLES] = first[d]
        end, h_max = doubts[d, END], (doubts[d, END] - doubts[d, TIME]) / PARTS
        flow(f, k, x, until(o, end, h_max), None, None)


UNIT = {"again": void(_flow.UNIT["flow"], FUNCTIONS, WORK, TRAJECTORY, OPTIONS, Array(axes=2), Array(INT))}
