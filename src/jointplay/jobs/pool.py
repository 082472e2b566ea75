"""The pool that runs the cells of a sweep: processes, threads, a dask cluster, or this process alone.

Kernels are compiled before the pool starts. Tasks grow from one cell to as many as fill half a second. When a
worker process dies, the whole pool is given up: the cells that were in flight then run once more, each
alone; one that dies again is marked `crashed`, and the rest goes on in a new pool.

On a dask cluster the death of a worker costs no cell but that which it died of. Answers travel back, since
workers reach no folder of this machine; a task ends between two cells when its time is up, and what is left
goes out as a new task, so that little is lost when this process ends. The scheduler sends a task whose
worker died to another, three times unless it is set otherwise (its option ``allowed-failures``), and then
gives it up, with those that waited at the same worker. When all others have ended, the jobs of these tasks
run once more, alone on the cluster and cell by cell; a cell that is given up again is marked `crashed`.
"""

from __future__ import annotations

import logging
import re
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from jointplay.display.errors import InputError, Problem
from jointplay.jobs.job import Job, remaining
from jointplay.jobs.journal import Journal
from jointplay.jobs.origin import code, mixed
from jointplay.jobs.parallel import BrokenProcessPool
from jointplay.jobs.worker import Done, Pace, Task, in_tasks, work

MOST_JOBS = 1000  # worker processes
DEATHS = 3  # of pools without a cell in flight, before giving up
LIMIT = 30.0  # s that a task may take, but for its last cell
AHEAD = 2  # tasks sent for each worker
PATIENCE = "10s"  # for the scheduler to answer
LOST = "the cluster's scheduler was lost; what has arrived is kept"
LOOK = 5.0  # s between looks whether there are workers


@dataclass(frozen=True)
class Pool:
    """Workers that run jobs.

    Parameters
    ----------
    jobs : int
        Workers; 1: this process alone, but on a cluster.
    backend : {"loky", "threading", "dask"}
        Processes, threads, or the workers of a dask cluster.
    scheduler : str, optional
        Address of the cluster's scheduler, as ``tcp://host:8786``.
    """

    jobs: int = 2
    backend: str = "loky"
    scheduler: str | None = None

    @classmethod
    def checked(cls, jobs: int, backend: str = "loky", scheduler: str | None = None) -> Pool:
        """The pool that a user wants; `InputError` where there can be none."""
        check_jobs(jobs)
        if scheduler is not None and backend != "dask":
            raise InputError([Problem("--scheduler", scheduler, "accepted beside --backend dask only")])
        return cls(jobs, backend, scheduler)

    @property
    def workers(self) -> bool:
        """Whether cells run outside this process."""
        return self.jobs > 1 or self.backend == "dask"

    def run(self, jobs: Sequence[Job], journal: Journal, say: Callable[[str], None]) -> None:
        """Run every job; the answers of its cells are in the journal afterwards.

        `OSError` where the journal cannot be written, workers die before they begin, or a cluster is lost.
        """
        if self.backend == "dask":
            with connected(self.scheduler) as client:
                Cluster(client, journal, say).run(jobs)
            return
        left, deaths, folder = list(jobs), 0, str(journal.folder.absolute())
        while left:
            workers = min(self.jobs, len(left))  # a worker without a task would only start
            try:
                in_tasks(left, workers, self.backend if workers > 1 else "here", folder)
                return
            except BrokenProcessPool:
                left = journal.remaining(left)
                owner = {key: job for job in left for key in job.keys}
                suspects = [key for key in journal.in_flight() if key in owner]
                deaths += not suspects
                if deaths == DEATHS:
                    raise OSError("worker processes die before they begin; try --jobs 1") from None
                say(f"a worker process died; {len(suspects)} cells in flight run once more, each alone")
                for key in suspects:
                    _alone(owner[key], key, journal, say)
                left = journal.remaining(left)


def _alone(job: Job, key: str, journal: Journal, say: Callable[[str], None]) -> None:
    """Run a job up to a cell that may have killed its worker."""
    try:
        in_tasks([job.only(key)], workers=1, folder=str(journal.folder.absolute()))
    except BrokenProcessPool:
        at = journal.in_flight()
        for fatal in {key, *at} if at else {key}:
            if fatal not in journal.index():
                journal.mark_crashed(fatal, say)


def share_of(text: str | None) -> tuple[int, int] | None:
    """The numbers of ``I/N``, the part of a study; `InputError` where the text is not of this form."""
    if text is None:
        return None
    match = re.fullmatch(r"([0-9]{1,9})/([0-9]{1,9})", text)
    if match and 1 <= int(match[1]) <= int(match[2]):
        return int(match[1]), int(match[2])
    raise InputError([Problem("--part", text, "I/N is accepted, part I of N, such as 2/5")])


def check_jobs(jobs: int | None) -> None:
    """Raise an `InputError` where there cannot be so many worker processes."""
    if jobs is not None and not 1 <= jobs <= MOST_JOBS:
        accepted = f"a whole number of worker processes from 1 to {MOST_JOBS} is accepted"
        raise InputError([Problem("--jobs", jobs, accepted)])


class Cluster:
    """A dask cluster that runs jobs.

    Parameters
    ----------
    client : distributed.Client
        Its connection to the scheduler.
    journal : Journal
        Where answers go.
    say : callable
        Called with a line where there is something to tell.
    """

    def __init__(self, client: Any, journal: Journal, say: Callable[[str], None]) -> None:
        self.client, self.journal, self.say = client, journal, say
        self.waits, self.kinds = False, set[str]()

    def run(self, jobs: Sequence[Job]) -> None:
        """Run every job; the answers of its cells are in the journal afterwards.

        `OSError` where the scheduler is lost, or a worker cannot run its task, as when its code is another.
        """
        left = deque(jobs)
        while left:
            suspects = self._side_by_side(left)
            if suspects:
                self.say(f"workers died; {len(suspects)} of their chains or cells run once more, each alone")
            left.extend(rest for job in suspects for rest in self._alone(job))

    def _side_by_side(self, left: deque[Job]) -> list[Job]:
        """Run jobs side by side until none is left; return the jobs whose workers died."""
        pace, sent, suspects = Pace(), {}, []
        while left or sent:
            workers = self._workers()
            while left and len(sent) < AHEAD * workers:
                batch = [left.popleft() for _ in range(pace.size(len(left), workers))]
                sent[self._send(batch)] = batch
            for future in self._ended(list(sent)):
                batch = sent.pop(future)
                if (done := self._taken(future)) is None:
                    suspects += batch
                else:
                    pace.learn(done)
                    left.extendleft(reversed(remaining(batch, done.answers, done.answers)))
        return suspects

    def _alone(self, job: Job) -> list[Job]:
        """Run a job cell by cell until its time is up or a cell crashed; return the rest of it."""
        end, left = time.monotonic() + LIMIT, [job]
        while left:
            key = left[0].keys[0]
            future = self._send([left[0].only(key)])
            while not self._ended([future]):
                self._workers()
            done = self._taken(future)
            answers = done.answers if done else self.journal.mark_crashed(key, self.say)
            left = remaining(left, answers, answers)
            if done is None or time.monotonic() >= end:
                break
        return left

    def _send(self, jobs: Sequence[Job]) -> Any:
        return self.client.submit(work, Task(jobs, None, limit=LIMIT, code=code()), pure=False)

    def _ended(self, sent: Sequence[Any]) -> list[Any]:
        """Futures of the tasks that have ended; none after `LOOK` seconds."""
        from distributed import wait

        try:
            return list(wait(sent, timeout=LOOK, return_when="FIRST_COMPLETED").done)
        except TimeoutError:
            return []
        except CancelledError:
            raise OSError(LOST) from None

    def _taken(self, future: Any) -> Done | None:
        """Result of a task, its answers written to the journal; None where its workers died."""
        try:
            done = future.result()  # which a dying worker may take with it, after it has arrived
        except Exception as error:
            if type(error).__name__ == "KilledWorker":
                return None
            if isinstance(error, CancelledError):
                raise OSError(LOST) from None
            if future.status != "error":
                raise
            failure = f"a worker of the cluster failed ({type(error).__name__}: {error})"
            raise OSError(f"{failure}; workers need the same version of jointplay") from error
        self.journal.write(done.answers, done.origin)
        self._note_processor(done.origin.processor)
        return done

    def _note_processor(self, processor: str) -> None:
        """Remember the kind of processor of a worker; where kinds are mixed, a line says so."""
        if processor not in self.kinds:
            self.kinds.add(processor)
            if line := mixed(self.kinds):
                self.say(line)

    def _workers(self) -> int:
        """Number of worker threads, at least 1; where there is none, a line says so."""
        there = sum(self.client.nthreads().values())
        if not there and not self.waits:
            self.say("the cluster has no workers; waiting for one")
        self.waits = not there
        return max(1, there)


@contextmanager
def connected(scheduler: str | None) -> Iterator[Any]:
    """Connect to the scheduler of a dask cluster until the block ends.

    `InputError` where dask is not installed, or no scheduler answers.
    """
    try:
        from distributed import Client
    except ImportError:
        expected = "loky or threading is accepted; dask needs `pip install distributed`"
        raise InputError([Problem("--backend", "dask", expected)]) from None
    if scheduler is None:
        expected = "the address of a scheduler, as tcp://host:8786, is needed beside --backend dask"
        raise InputError([Problem("--scheduler", scheduler, expected)])
    logging.getLogger("distributed.client").setLevel(logging.CRITICAL)  # a lost scheduler is reported here
    try:
        client = Client(scheduler, timeout=PATIENCE)
    except (OSError, ValueError) as error:
        expected = f"the address of a running scheduler, as tcp://host:8786, is accepted ({error})"
        raise InputError([Problem("--scheduler", scheduler, expected)]) from None
    with client:
        yield client
