"""Doubtful steps: steps whose recorded rates may be off are noted, and followed again in shorter ones.

They are followed each from its own beginning (again).
"""

from .interface import inner
from .memory import DOUBT_ROW, DOUBTED
from .radau import ERROR, GAMMA
from .record import note

KEPT = 0.5  # share of a decay that the polynomial keeps at most, soon after the step's beginning
MISSED = 0.15  # times h / gamma and the slope's error at the beginning: largest error between the stages
FIRED, END, TIME = 0, 1, 2  # columns of a doubt
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
    """Note a step that is doubtful: its base point, the guards fired there (a number to base 4), its end."""
    fired, digit = 0.0, 1.0
    for g in range(len(x.fired)):
        fired += digit * x.fired[g]
        digit *= 4.0
    note(k, x, o, DOUBT_ROW, fired, end, x.s[0], 0.0)
