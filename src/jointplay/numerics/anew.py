"""Steps of a motion followed anew, each from its own beginning and in shorter ones (analysis.rates).

The flow comes as an address: joined to this loop, it would be compiled a second time.
"""

from numpy import inf

from .interface import inner
from .memory import H_LIMIT, SAMPLES, STARTED, T_EVENT, T_SECTION, H, Options

FIRED, END, TIME = 0, 1, 2  # columns of a doubt (numerics.record)
PARTS = 2  # steps at least
BEGUN = 1e-2  # of a step: the first one anew


@inner
def take_up(row, n_x, x):
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
        x.fired[g], fired = fired % 3, fired // 3
    for i in range(len(x.count)):
        x.count[i] = 0
    for i in range(len(x.real)):
        x.real[i] = 0.0
    x.count[STARTED], x.real[H_LIMIT] = 1, inf
    x.real[T_EVENT], x.real[T_SECTION] = -inf, -inf
    x.real[H] = BEGUN * (row[END] - row[TIME])


def again(flow, f, k, x, o, doubts, first):
    """Follow each step in doubt; samples from number first[d] on are those within the step of doubt d."""
    for d in range(len(doubts)):
        take_up(doubts[d], o.n_q + o.n, x)
        x.count[SAMPLES] = first[d]
        end, h_max = doubts[d, END], (doubts[d, END] - doubts[d, TIME]) / PARTS
        flow(f, k, x, Options(*o[:4], end, h_max, *o[6:]), None, None)
