"""Progress reports and clean stops of a long computation, between two of its pieces.

Compiled code runs in pieces (pieces), and long loops of Python have passes: each calls `tick`. What tells
knows nothing of who asked; what runs deep inside an analysis needs no callable handed down.
"""

from __future__ import annotations

import _thread
import math
import signal
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager
from contextvars import ContextVar
from functools import wraps
from typing import ParamSpec, TypeVar

from jointplay.display.terminal import held, requested_progress

P = ParamSpec("P")
T = TypeVar("T")
EVERY = 0.25  # s between two reports, where no more is known to be done
PATIENCE = 1.0  # s in which what is asked to end comes to a look; else it is interrupted wherever it is


class Stopped(KeyboardInterrupt):
    """End of a run between two pieces, with its results so far kept."""


class Aborted(KeyboardInterrupt):
    """End of a run, wherever it is, that made no check in time: complete results are kept."""


class OutOfTime(BaseException):
    """End of a block, at a `tick`, that has used the time it was given (`limited`)."""


class Reporter:
    """A user's `progress`, called with fractions that never fall, and the last one again as time passes."""

    def __init__(self, progress: Callable[[float], None]):
        self.progress, self.fraction, self.last = progress, 0.0, -math.inf
        self.error: Exception | None = None

    def __call__(self, fraction: float) -> None:
        self.fraction, self.last = min(1.0, max(self.fraction, float(fraction))), time.monotonic()
        try:
            self.progress(self.fraction)
        except Exception as error:
            self.error = error
            raise

    def again(self) -> None:
        """Report the same fraction again if the last report is a while ago."""
        if time.monotonic() - self.last >= EVERY:
            self(self.fraction)


_reporter: ContextVar[Reporter | None] = ContextVar("reporter", default=None)
_end: ContextVar[float] = ContextVar("end", default=math.inf)  # on the clock of the thread's processor time
_listener: ContextVar[Callable[[float, str], None] | None] = ContextVar("listener", default=None)


def reported(analysis: Callable[P, T]) -> Callable[P, T]:
    """Make an analysis report to its `progress`: as time passes, never falling, and 1 at the end, if not cut.

    True stands for a bar on a terminal or in a notebook, or lines in a log; left out, a call that lasts has a
    bar there, too.
    """

    @wraps(analysis)
    def call(*arguments, progress: bool | Callable[[float], None] | None = None, **keywords):
        with requested_progress(progress, analysis.__name__) as report:
            if not callable(report):  # None, or what the analysis refuses
                return analysis(*arguments, progress=report, **keywords)
            with held(_reporter, tell := Reporter(report)):
                result = analysis(*arguments, progress=tell, **keywords)
                if not _stop.heard:
                    tell(1.0)
                return result

    return call


def part(
    progress: Callable[[float], None] | None, first: float, last: float
) -> Callable[[float], None] | None:
    """The progress of a part of the work, which is the whole's from `first` to `last`."""
    return None if progress is None else lambda done: progress(first + (last - first) * done)


def from_progress(error: Exception) -> bool:
    """Whether a user's `progress` raised an error, which is then no failure of the computation."""
    reporter = _reporter.get()
    return reporter is not None and reporter.error is error


def tick() -> None:
    """Report that the computation still runs; end it here if `stop` was called.

    Raises
    ------
    Stopped
        Once, after `stop`.
    OutOfTime
        In a block whose time is used up.
    """
    if (reporter := _reporter.get()) is not None:
        reporter.again()
    if (end := _end.get()) < math.inf and time.thread_time() >= end:
        raise OutOfTime
    if _stop.requested:
        _stop.reset(heard=True)
        raise Stopped


def ticked(passes: Iterable[T]) -> Iterator[T]:
    """The same items, with a `tick` before each."""
    for each in passes:
        tick()
        yield each


def limited(seconds: float) -> AbstractContextManager[None]:
    """Let a block have so many seconds of the processor: it ends as `OutOfTime` at the next `tick`."""
    return held(_end, time.thread_time() + seconds)


def heard(listener: Callable[[float, str], None]) -> AbstractContextManager[None]:
    """Have a function called with the fraction that is done, and its words, as the block tells (`stands`)."""
    return held(_listener, listener)


def stands(fraction: float, place: str) -> None:
    """Say how much of a cell is done, and in a few words where it is."""
    if (listener := _listener.get()) is not None:
        listener(fraction, place)


class _Stop:
    """Request to stop: whether a running computation heeds it, whether it was made, and was heard."""

    heeded = requested = late = heard = False
    timer: threading.Timer | None = None

    def reset(self, heeded: bool = False, heard: bool = False) -> None:
        self.heeded, self.requested, self.late, self.heard = heeded, False, False, heard
        if self.timer is not None:
            self.timer.cancel()
            self.timer = None


_stop = _Stop()


@contextmanager
def stoppable(kept: bool = True) -> Iterator[None]:
    """Let `stop` end computations in the block at their next `tick`; where none came, at the block's end."""
    _stop.reset(heeded=kept)
    left = False
    try:
        yield
        left = _stop.requested
    finally:
        _stop.reset()
    if left:
        signal.raise_signal(signal.SIGINT)


def stop() -> bool:
    """Make the running computation end at its next `tick` and keep its results; False where none does so.

    Where no look comes soon, as while something compiles, the main thread is interrupted all the same.

    Raises
    ------
    Late
        In that interrupt, which calls this once more.
    """
    if _stop.late:
        raise Aborted
    if not _stop.heeded or _stop.requested:
        return False
    _stop.requested = True
    _stop.timer = threading.Timer(PATIENCE, _interrupt)
    _stop.timer.daemon = True
    _stop.timer.start()
    return True


def _interrupt() -> None:
    if not _stop.requested:
        return
    _stop.heeded, _stop.requested, _stop.late, _stop.heard = False, False, True, True
    if hasattr(signal, "pthread_kill"):  # a real one, that ends what the main thread waits for
        signal.pthread_kill(threading.main_thread().ident, signal.SIGINT)
    else:
        _thread.interrupt_main()
