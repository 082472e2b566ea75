"""Doubtful steps: those whose recorded rates may be off are noted, and followed again in shorter ones.

They are followed each from its own beginning (analysis.rates).
"""

from numpy import inf

from .interface import inner
from .memory import DOUBT_ROW, DOUBTED, GROWTH, H_LIMIT, SAMPLES, STARTED, T_EVENT, T_SECTION, H, Options
from .radau import ERROR, GAMMA
from .record import note

KEPT = 0.5  # share of a decay that the polynomial keeps at most, soon after the step's beginning
MISSED = 0.15  # times h / gamma and the slope's error at the beginning: largest error between the stages
FIRED, END, TIME = 0, 1, 2  # columns of a doubt
PARTS = 2  # steps at least
BEGUN = 1e-2  # of a step: the first one again
FADING = 0.1  # share of its doubt that a step leaves to the next


@inner
def doubtful(k, x, o, h):
    """Whether rates of angles on the step of length h may be off by more than is tolerated (o.sharp).

    At its base point the rate differs from the polynomial's slope. What of that the error's filter
    (I - h J / gamma)^-1 takes away is the rate of components that the step passes over: decays, of which the
    polynomial keeps a part. Between the stages it also misses the slow motion of these components, by a
    share of h times that difference, and rates by as many times more as the filter made it smaller. Now and
    then that difference passes zero at the base point itself: what was in doubt a step before still is.
    """
    at, span, doubted = 8 * (o.first + 1 + o.n_q), h / GAMMA, FADING * x.real[DOUBTED]
    for r in range(o.n):
        slope = k.w[at + 8 * (o.n + r) + 7]
        for i in range(7):
            slope += ERROR[i] * k.w[at + 8 * r + i] / span
        slow = k.error[o.n_q + r] / span
        off = x.turning[r] * abs(slope - slow) * max(KEPT * abs(slow), MISSED * abs(slope))
        off, allowed = off * k.weight[o.n_q + r], o.sharp * abs(slow)
        if off > allowed:
            doubted = max(doubted, off / allowed if allowed > 0.0 else 1.0 / FADING)
    x.real[DOUBTED] = doubted
    return doubted > 1.0


@inner
def doubt(k, x, o, end):
    """Note a step that is doubtful: its base point, what guards fired there (a number to base 4), its end."""
    fired, digit = 0.0, 1.0
    for g in range(len(x.fired)):
        fired += digit * x.fired[g]
        digit *= 4.0
    note(k, x, o, DOUBT_ROW, fired, end, x.s[0], 0.0)


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


def again(flow, f, k, x, o, doubts, first):
    """Follow each step in doubt; samples from number first[d] on are those within the step of doubt d.

    The flow comes as an address: joined to this loop, it would be compiled a second time.
    """
    for d in range(len(doubts)):
        _resume(doubts[d], o.n_q + o.n, x)
        x.count[SAMPLES] = first[d]
        end, h_max = doubts[d, END], (doubts[d, END] - doubts[d, TIME]) / PARTS
        flow(f, k, x, Options(*o[:4], end, h_max, *o[6:]), None, None)
