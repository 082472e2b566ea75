"""Ctrl-C: held back where it would leave a library's lock taken, heeded where no Python runs to do so."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

STUCK = 1.2  # s of CPU time that compiled code, such as the compiler's, may go on after Ctrl-C
LOOK = 0.05  # s
PROBE = getattr(signal, "SIGURG", None)  # which nobody else listens to


class _Note(list):
    """A handler that remembers its signals."""

    def __call__(self, number: int, _: object) -> None:
        self.append(number)


@contextmanager
def held() -> Iterator[Callable[[], bool]]:
    """Hold Ctrl-C back until the block ends, when it comes to who was to get it: nothing is half done.

    Gives a function that says whether it was pressed; a block that takes long may end itself then, by
    `KeyboardInterrupt`. A block inside another is a part of it. In another thread than the main one, which
    gets no signals, nothing is held.
    """
    before = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread():
        yield lambda: False
    elif isinstance(before, _Note):
        yield lambda: bool(before)
    else:
        pressed = _Note()
        signal.signal(signal.SIGINT, pressed)
        try:
            yield lambda: bool(pressed)
        except KeyboardInterrupt:
            pressed.clear()  # heeded
            raise
        finally:
            signal.signal(signal.SIGINT, signal.SIG_DFL if before is None else before)
            if pressed:
                signal.raise_signal(signal.SIGINT)


@contextmanager
def kept() -> Iterator[None]:
    """Keep Ctrl-C from processes that start inside: this one ends them."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def guarded(leave: Callable[[], None]) -> Iterator[None]:
    """Call `leave`, which ends the process, where Ctrl-C comes while compiled code runs and it goes on.

    A handler of Python waits for such code. Where it lets other threads run, as the compiler does, one of
    them looks whether the main thread answers a signal.
    """
    if PROBE is None or threading.current_thread() is not threading.main_thread():
        yield
        return
    answered, over = threading.Event(), threading.Event()
    reader, writer = os.pipe()
    os.set_blocking(writer, False)
    before = signal.signal(PROBE, lambda *_: answered.set())
    woken = signal.set_wakeup_fd(writer, warn_on_full_buffer=False)
    threading.Thread(target=_guard, args=(reader, answered, over, leave), daemon=True).start()
    try:
        yield
    finally:
        signal.set_wakeup_fd(woken)
        signal.signal(PROBE, signal.SIG_DFL if before is None else before)
        os.close(writer)
        over.set()


def _guard(reader: int, answered: threading.Event, over: threading.Event, leave: Callable[[], None]) -> None:
    main = threading.main_thread().ident
    while numbers := os.read(reader, 64):
        if signal.SIGINT not in numbers or main is None:
            continue
        answered.clear()
        signal.pthread_kill(main, PROBE)
        end = time.process_time() + STUCK
        while not (answered.wait(LOOK) or over.is_set()):
            if time.process_time() > end:
                leave()
    os.close(reader)


def write_line(text: str) -> None:
    """Write a last line to standard error, which may be closed, past all that is buffered."""
    with suppress(OSError, AttributeError, ValueError):
        sys.stderr.flush()
    with suppress(OSError):
        os.write(2, f"{text}\n".encode())
