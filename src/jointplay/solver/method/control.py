"""Decisions of one trajectory and of the lanes of an ensemble: lengths of steps, convergence, ends of runs.

Lengths follow predictive control by the errors of accepted steps. After a rejection the observed order says
how much shorter; after an event the first length is the one that served after the last event into the same
mode. References: Gustafsson, ACM Trans. Math. Softw. 20 (1994) 496-517; Hairer and Wanner (see radau),
section IV.8.
"""

import numpy as np

from .codes import Status
from .interface import inlined, inner
from .memory import ERROR_PAST, ERROR_REJECTED, H_LIMIT, H_PAST, H_REJECTED, H_VARIANT, SMOOTH, H

ORDER = 8  # of the error estimate in h
SAFETY = 0.82  # lengths aim at a fifth of the tolerated error, which goes up and down with a vibration
TURN = 0.75  # largest increment of an angle in a step: where the structure's polynomials hold
OK, DIVERGED, STEP_LIMIT, CHATTER, NOT_CONVERGED = Status.numbers()[:5]  # the others are of runs never begun
NO_DERIVATIVE, WEDGED = int(Status.NO_DERIVATIVE), int(Status.JAMMED)
FULL = -1  # the log is full: empty it and call again
CHATTER_COUNT = 12  # events that follow each other closely
IDLE_COUNT = 1000  # steps in a row that move nothing
IDLE_STEP = 1e-3  # of the time within which events crowd: 10^-10 of a turn
IDLE_CHANGE = 10.0  # tolerated errors: rounding that the error estimate bounds moves a state by a few
HUGE = 1e12  # of a state, beyond which it diverges


@inlined
def error_ratio(theta):
    """Bound of the error that Newton's iteration leaves over its last update, which shrank by theta."""
    return theta / (1.0 - theta) if theta < 0.99 else 1e100


@inlined
def converged(size, factor, tolerance, stale):
    """Whether Newton's iteration has converged, by its last update; `factor` times that bounds the error."""
    return factor * size <= tolerance and size <= stale


@inlined
def fastest(s, turning, n_q):
    """Largest speed of an angle at the base point."""
    most = 0.0
    for r in range(n_q):
        most = max(most, turning[r] * abs(s[1 + n_q + r]))
    return most


@inlined
def bounded(h, fastest, turn, left):
    """Length of the next attempt: within the angles' bound and the end of the run; no last step is tiny."""
    h = min(h, 0.8 * turn / max(fastest, 1e-300))
    return left if left < 1.001 * h else h


@inner
def at_end(time, end):
    """Whether a time is the run's end: a sum of lengths may miss it by rounding."""
    return abs(end - time) <= 4e-16 * abs(end)


@inner
def instant(time, chatter_time):
    """Time that is too short for a step, and within which two events are simultaneous."""
    return 1e-15 * max(abs(time), chatter_time)


@inlined
def after_whole(real, count, variant, h, error):
    """Length of the step after a whole one; lengths at which the iteration failed are approached slowly."""
    error = max(error, 1e-10)
    steady = count[SMOOTH] == 1 and real[H_REJECTED] == 0.0
    proposed = _proposed(h, error, real[H_PAST], real[ERROR_PAST], steady)
    real[H] = min(proposed, real[H_LIMIT])
    if error > 1e-3 or real[H] > real[H_VARIANT + variant]:  # else something else kept the step short
        real[H_VARIANT + variant] = real[H]
    real[H_LIMIT] *= 1.05
    real[H_PAST], real[ERROR_PAST], real[H_REJECTED] = h, max(error, 1e-2), 0.0
    count[SMOOTH] = 1


@inner
def _proposed(h, error, h_past, error_past, steady):
    """Length of the next step by predictive control (Gustafsson) from the errors of two accepted steps."""
    if steady:
        shrinking = (h_past / h) ** 2
        error = max(error, error * error / error_past * shrinking * shrinking * shrinking * shrinking)
    return h * min(max(SAFETY * error ** (-1.0 / ORDER), 0.2), 6.0)


@inner
def shorter(real, h, error):
    """Length to try after an attempt of length h was rejected, by the order that two such have shown.

    Where a fast transient is stepped over, shorter steps do not help until they resolve it.
    """
    order = float(ORDER)
    if real[H_REJECTED] > h and error < np.inf:
        order = np.log(real[ERROR_REJECTED] / error) / np.log(real[H_REJECTED] / h)
    real[H_REJECTED], real[ERROR_REJECTED] = h, error
    if not error < np.inf or order < 1.5:
        return h * (0.1 if error > 2.0 else 0.5)
    return h * max(0.1, 0.9 * error ** (-1.0 / min(order, float(ORDER))))


@inner
def learnt(kept, rejected, h, error):
    """Length to keep for the next step after an event like this one, where a transient needs a short one.

    The transient makes the error of low order. `kept` was learnt before; 0: nothing is kept.
    """
    if error < 1e-3:
        return 0.0
    return h * min((0.5 / error) ** 0.25, 2.0) if rejected or kept > 0.0 else kept


@inner
def restarted(h, served, kept):
    """Length of the first step after an event: the last one in the same variant, at most the learnt one."""
    h = served if served > 0.0 else h
    return min(h, kept) if kept > 0.0 else h


@inner
def close_events(count, later, chatter_time):
    """Number of events in close succession, after one that is `later` than the last."""
    return count + 1 if later < chatter_time else 0


@inner
def idle_steps(count, h, chatter_time, w, at, weight):
    """Number of idle steps in a row: very short ones, with increments w[at:] of a few tolerated errors.

    Towards a singularity of the equations, as a dead centre, their rounding grows without bound; it makes
    steps shorter and shorter, and the motion never gets there.
    """
    if not h < IDLE_STEP * chatter_time:
        return 0
    for r in range(len(weight)):
        if not abs(w[at + 8 * r + 6]) * weight[r] < IDLE_CHANGE:
            return 0
    return count + 1


@inner
def failure(s, n_x):
    """Status where no step is short enough: the state diverges, or the iteration does not converge."""
    for r in range(1 + n_x):
        if not abs(s[r]) < HUGE:
            return DIVERGED
    return NOT_CONVERGED
