"""How a run ends, and what tells that it ends badly."""

OK, DIVERGED, STEP_LIMIT, CHATTER, NOT_CONVERGED = range(5)
FULL = -1  # the log is full: empty it and call again
CHATTER_COUNT = 12  # events that follow each other closely
HUGE = 1e12  # of a state, beyond which it diverges
