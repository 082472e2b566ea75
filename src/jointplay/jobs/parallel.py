"""Parallel calls on this machine: the one place that starts worker processes and threads."""

from __future__ import annotations

import os
import signal
import threading
import time
import warnings
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, wait
from concurrent.futures.process import BrokenProcessPool as BrokenProcessPool
from contextlib import contextmanager, suppress
from functools import partial
from itertools import islice
from typing import Any

from jointplay.jobs import interrupts

AHEAD = 2  # calls sent for each process, so that none waits for its next
LOOK = 0.25  # s between looks
IDLE = 300  # s after which a process without calls ends
LEFTOVERS = "resource_tracker"  # how loky begins to tell what a dead worker left and it has cleared away
LIBRARIES = ("OMP", "OPENBLAS", "MKL", "BLIS", "NUMBA", "NUMEXPR")
ONE_THREAD = {f"{name}_NUM_THREADS": "1" for name in LIBRARIES} | {"VECLIB_MAXIMUM_THREADS": "1"}


def side_by_side(
    calls: Iterable[Callable[[], Any]],
    take: Callable[[Any], None],
    workers: int,
    backend: str = "loky",
    tick: Callable[[], None] = lambda: None,
) -> None:
    """Make calls in parallel.

    Parameters
    ----------
    calls : iterable of callable
        For processes, what can be pickled. The next is asked for when a worker is about to be free.
    take : callable
        Called with each result, as it comes.
    workers : int
        Workers.
    backend : {"loky", "threading", "here"}
        Processes, which end with this one and leave Ctrl-C to it; threads; or this thread alone.
    tick : callable
        Called several times a second while workers are busy.

    Raises
    ------
    BrokenProcessPool
        When a worker process dies. All others have ended then, as whenever an error ends the block early.
    """
    if backend == "here":
        for call in calls:
            take(call())
        return
    calls, sent = iter(calls), set[Future]()
    with _workers(workers, backend) as (submit, room):
        while True:
            sent |= {submit(call) for call in islice(calls, room - len(sent))}
            if not sent:
                return
            done, sent = wait(sent, LOOK, FIRST_COMPLETED)
            tick()
            for future in done:
                take(future.result())


@contextmanager
def _workers(workers: int, backend: str) -> Iterator[tuple[Callable[..., Future], int]]:
    """The function that sends a call to a worker, and the number of calls that may be sent at once."""
    if backend == "threading":
        yield _in_thread, workers
        return
    hush()
    from joblib.externals.loky import (
        get_reusable_executor,
    )  # a tenth of a second that one analysis need not wait

    with safe_path():
        executor = get_reusable_executor(max_workers=workers, timeout=IDLE, env=ONE_THREAD)
        try:
            yield partial(_submitted, executor), AHEAD * workers
        except BaseException:
            executor.shutdown(kill_workers=True)
            raise


def _submitted(executor: Any, call: Callable[[], Any]) -> Future:
    """Send a call to an executor, which may start workers to do it."""
    with interrupts.kept():
        return executor.submit(_in_process, os.getpid(), call)


def _in_thread(call: Callable[[], Any]) -> Future:
    """Call in a thread that, unlike an executor's, does not keep this process from ending."""
    future: Future = Future()
    threading.Thread(target=_fulfil, args=(future, call), daemon=True).start()
    return future


def _fulfil(future: Future, call: Callable[[], Any]) -> None:
    try:
        future.set_result(call())
    except BaseException as error:
        future.set_exception(error)


_followed: set[int] = set()


def _in_process(parent: int, call: Callable[[], Any]) -> Any:
    """Call in a worker process, which ends when its parent does, and leaves Ctrl-C to it."""
    with suppress(ValueError):  # only a main thread may
        signal.signal(signal.SIGINT, signal.SIG_IGN)
    if parent not in _followed:
        _followed.add(parent)
        threading.Thread(target=_follow, args=(parent,), daemon=True).start()
    return call()


def _follow(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(LOOK)
    os._exit(1)


@contextmanager
def safe_path() -> Iterator[None]:
    """Keep the current folder and its content off the path of workers that start inside."""
    before = os.environ.get("PYTHONSAFEPATH")
    os.environ["PYTHONSAFEPATH"] = "1"
    try:
        yield
    finally:
        del os.environ["PYTHONSAFEPATH"]
        os.environ.update({} if before is None else {"PYTHONSAFEPATH": before})


def hush() -> None:
    """Keep loky's messages on dead workers off the terminal; a run reports them in its own words."""
    warnings.filterwarnings("ignore", "A worker stopped while some jobs were given")
    known, own = os.environ.get("PYTHONWARNINGS", ""), f"ignore:{LEFTOVERS}:UserWarning"
    if own not in known:  # the tracker is a process of its own
        os.environ["PYTHONWARNINGS"] = ",".join(filter(None, [known, own]))
