"""Decisions taken of all lanes at once, in generated code, and of a single lane (attempts)."""

from ..control import not_beyond
from ..interface import inlined
from .layout import NOTHING
from .radau import MAX_TURN, NEWTON, STALE


@inlined
def converged(size, before, turned):
    """Whether Newton's iteration has, from the sizes of its last updates and the largest turn of an angle."""
    theta = size / before
    shrinks = size <= STALE and theta < 0.99 and size * theta <= NEWTON * (1.0 - theta)
    return turned <= MAX_TURN and (size < NOTHING or shrinks)


@inlined
def bounded(h, fast, left):
    """Length of the next attempt, within the angles' bound (the fastest turns so) and the end of the run."""
    return not_beyond(min(h, 0.8 * MAX_TURN / fast), left)
