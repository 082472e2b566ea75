"""Coarse steps: steps whose recorded rates may be off are noted, and retaken in shorter ones (retake)."""

from .interface import inner
from .memory import COARSE_ROW, COARSENESS
from .radau import ERROR, GAMMA
from .record import note

KEPT = 0.5  # share of a decay that the polynomial keeps at most, soon after the step's beginning
MISSED = 0.15  # times h / gamma and the slope's error at the beginning: largest error between the stages
FIRED, END, TIME = 0, 1, 2  # columns of a coarse step
FADING = 0.1  # share of its coarseness that a step leaves to the next


@inner
def is_coarse(work, motion, options, h):
    """Whether rates of angles on the step of length h may be off by more than is tolerated (rate_tolerance).

    At its base point the rate differs from the polynomial's slope. What of that the error's filter
    (I - h J / gamma)^-1 takes away is the rate of components that the step passes over: decays, of which the
    polynomial keeps a part. Between the stages it also misses the slow motion of these components, by a
    share of h times that difference, and rates by as many times more as the filter made it smaller. Now and
    then that difference passes zero at the base point itself: what was coarse a step before still is.
    """
    at, span, coarseness = 8 * (options.first + 1 + options.n_q), h / GAMMA, FADING * motion.real[COARSENESS]
    for r in range(options.n):
        slope = work.w[at + 8 * (options.n + r) + 7]
        for i in range(7):
            slope += ERROR[i] * work.w[at + 8 * r + i] / span
        slow = work.error[options.n_q + r] / span
        off = motion.turning[r] * abs(slope - slow) * max(KEPT * abs(slow), MISSED * abs(slope))
        off, allowed = off * work.weight[options.n_q + r], options.rate_tolerance * abs(slow)
        if off > allowed:
            coarseness = max(coarseness, off / allowed if allowed > 0.0 else 1.0 / FADING)
    motion.real[COARSENESS] = coarseness
    return coarseness > 1.0


@inner
def note_coarse(work, motion, options, end):
    """Note a coarse step: its base point, the guards fired there (a number to base 4), its end."""
    fired, digit = 0.0, 1.0
    for g in range(len(motion.fired)):
        fired += digit * motion.fired[g]
        digit *= 4.0
    note(work, motion, options, COARSE_ROW, fired, end, motion.s[0], 0.0)
