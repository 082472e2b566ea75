"""How a run ends."""

from .codes import Status
from .interface import inner

OK, DIVERGED, STEP_LIMIT, CHATTER, NOT_CONVERGED = Status.numbers()[:5]  # the others are of runs never begun
FULL = -1  # the log is full: empty it and call again
CHATTER_COUNT = 12  # events that follow each other closely
HUGE = 1e12  # of a state, beyond which it diverges


@inner
def crowded(count, later, near):
    """How many events have followed each other closely, after one that is `later` than the last."""
    return count + 1 if later < near else 0


@inner
def trouble(s, n_x):
    """Why no step is short enough: the state grew beyond measure, or the iteration does not converge."""
    for r in range(1 + n_x):
        if not abs(s[r]) < HUGE:
            return DIVERGED
    return NOT_CONVERGED
