"""Compiled loops run in pieces, so that Python can report and stop (motion.progress) between them.

While compiled code runs, no handler of a signal does, and no progress is reported. So each loop is called for
as many attempts at a time as took `PIECE` s so far. A loop that stopped at its limit goes on where it was
left (method.memory), to the last bit as if it had not stopped: no answer depends on the pieces.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import lru_cache

from jointplay.solver.equations.structure import Linkage, Oscillator
from jointplay.solver.motion.progress import tick

PIECE = 0.1  # s
FIRST, GROWTH = 64, 8  # attempts of the first piece ever; how much longer a piece may be than the one before


class Pace:
    """Number of attempts in a piece, learned from the duration of earlier pieces."""

    def __init__(self) -> None:
        self.size = FIRST

    def learn(self, made: int, seconds: float) -> None:
        """Fit the next pieces to one that was whole, or too long."""
        if made >= self.size or seconds > PIECE:
            self.size = max(1, int(min(GROWTH * self.size, made * PIECE / max(seconds, 1e-9))))


@lru_cache(maxsize=1024)
def pace(structure: Linkage | Oscillator, loop: str, tangents: int = 0) -> Pace:
    """Pace of a loop with a structure and a number of tangents, shared by all its runs."""
    return Pace()


def in_pieces(
    call: Callable[[int], int],
    made: Callable[[], int],
    pace: Pace,
    unfinished: int,
    most: float,
    tell: Callable[[], None] | None = None,
) -> int:
    """Call a compiled loop until it ends for another reason than the limit of a piece.

    Parameters
    ----------
    call, made : callable
        Runs the loop up to a number of attempts in all and gives back how it ended; attempts made so far.
    pace : Pace
        Of this loop.
    unfinished : int
        What `call` gives back at its limit.
    most : float
        Attempts that were asked for.
    tell : callable, optional
        Called after each piece.
    """
    while True:
        before, began = made(), time.perf_counter()
        limit = min(most, before + pace.size)
        code = call(limit)
        pace.learn(made() - before, time.perf_counter() - began)
        if tell is not None:
            tell()
        tick()
        if code != unfinished or limit == most:
            return int(code)
