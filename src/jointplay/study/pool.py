"""The pool that runs the cells of a sweep: processes, threads, a dask cluster, or this process alone.

Kernels are compiled before the pool starts. Tasks grow from one cell to as many as fill half a second. When a
worker dies, joblib gives the whole pool up: the cells that were in flight then run once more, each alone; one
that dies again is marked `crashed`, and the rest goes on in a new pool.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from typing import Any

from joblib import Parallel, delayed, parallel_config
from joblib.externals.loky.process_executor import BrokenProcessPool

from jointplay.errors import InputError, Problem
from jointplay.study.cells import Strand
from jointplay.study.journal import CRASHED, Journal
from jointplay.study.run import check_jobs
from jointplay.study.worker import Done, Task, work

FILL = 0.5  # s that a task is to last
PATIENCE = "10s"  # for the scheduler of a cluster to answer
DEATHS = 3  # of pools without a cell in flight, before giving up
DIED = "the worker process died twice at this cell, as when memory runs out"


@dataclass(frozen=True)
class Pool:
    """What runs the cells.

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
        """Make a pool of what a user asks for.

        Raises
        ------
        InputError
            When there can be none.
        """
        check_jobs(jobs)
        if scheduler is not None and backend != "dask":
            raise InputError([Problem("--scheduler", scheduler, "accepted beside --backend dask only")])
        return cls(jobs, backend, scheduler)

    @property
    def workers(self) -> bool:
        """Whether cells run beside this process."""
        return self.jobs > 1 or self.backend == "dask"

    def run(self, strands: Sequence[Strand], journal: Journal, say: Callable[[str], None]) -> None:
        """Run every strand; what its cells answer is in the journal afterwards.

        Raises
        ------
        OSError
            When the journal cannot be written, or workers die before they begin.
        """
        left, deaths = list(strands), 0
        while left:
            try:
                self._round(left, journal)
            except BrokenProcessPool:
                left = _left(left, journal)
                suspects = _owned(left, journal.in_flight())
                deaths += not suspects
                if deaths == DEATHS:
                    raise OSError("worker processes die before they begin; try --jobs 1") from None
                say(f"a worker process died; {len(suspects)} cells in flight run once more, each alone")
                for strand, key in suspects:
                    self._alone(strand, key, journal, say)
                left = _left(left, journal)
            except Exception as error:
                if type(error).__name__ != "KilledWorker":  # of dask, which need not be installed
                    raise
                raise OSError(f"the cluster lost the workers of some cells ({error})") from None
            else:
                return

    def _round(self, strands: Sequence[Strand], journal: Journal) -> None:
        """Run strands in one pool."""
        pace = _Pace(strands, self.jobs)
        tasks = (delayed(work)(Task(batch, *self._reach(journal))) for batch in pace.batches())
        with self._context():
            pool = Parallel(
                n_jobs=-1 if self.backend == "dask" else self.jobs,
                return_as="generator_unordered",
                batch_size=1,
                pre_dispatch="2 * n_jobs",
            )
            for done in pool(tasks):
                pace.learn(done)
                journal.write(done.answers)

    def _alone(self, strand: Strand, key: str, journal: Journal, say: Callable[[str], None]) -> None:
        """Run a strand up to a cell that may have killed its worker."""
        task = Task([strand.only(key)], *self._reach(journal))
        try:
            with parallel_config("loky", inner_max_num_threads=1):
                for done in Parallel(n_jobs=2, return_as="generator_unordered")([delayed(work)(task)]):
                    journal.write(done.answers)
        except BrokenProcessPool:
            at = journal.in_flight()
            for fatal in {key, *at} if at else {key}:
                if fatal not in journal.index():
                    say(f"cell marked as crashed: {DIED}")
                    journal.write({fatal: {"status": CRASHED, "trouble": DIED}})

    def _reach(self, journal: Journal) -> tuple[str | None, int | None]:
        """The journal's folder where workers reach it, and the process that they follow."""
        if self.backend == "dask":
            return None, None
        return str(journal.folder.absolute()), os.getpid()

    def _context(self) -> AbstractContextManager[Any]:
        if self.backend == "dask":
            return _cluster(self.scheduler)
        if self.jobs == 1:
            return nullcontext()
        only_one = {"inner_max_num_threads": 1} if self.backend == "loky" else {}
        return parallel_config(self.backend, **only_one)


def share_of(text: str | None) -> tuple[int, int] | None:
    """The numbers of ``I/N``.

    Raises
    ------
    InputError
        When it is none.
    """
    if text is None:
        return None
    first, _, last = text.partition("/")
    if first.isdecimal() and last.isdecimal() and 1 <= int(first) <= int(last):
        return int(first), int(last)
    raise InputError([Problem("--part", text, "I/N is accepted, part I of N, such as 2/5")])


class _Pace:
    """Batches of strands that fill their time, however long a strand takes."""

    def __init__(self, strands: Sequence[Strand], jobs: int) -> None:
        self.strands, self.jobs = strands, jobs
        self.done, self.seconds = 0, 0.0

    def learn(self, done: Done) -> None:
        """Note how long a batch took."""
        self.done, self.seconds = self.done + done.strands, self.seconds + done.seconds

    def batches(self) -> Iterator[Sequence[Strand]]:
        """Strands in their order; joblib asks for the next batch as workers get free."""
        at = 0
        while at < len(self.strands):
            wanted = int(FILL * self.done / self.seconds) if self.seconds else 1
            fair = (len(self.strands) - at) // (4 * max(self.jobs, 1))
            size = max(1, min(wanted, fair))
            yield self.strands[at : at + size]
            at += size


def _left(strands: Sequence[Strand], journal: Journal) -> list[Strand]:
    index = journal.index()
    answers = journal.load(key for strand in strands if len(strand.keys) > 1 for key in strand.keys)
    return [rest for strand in strands if (rest := strand.left(index, answers)) is not None]


def _owned(strands: Sequence[Strand], keys: Sequence[str]) -> list[tuple[Strand, str]]:
    """Cells that were in flight, each with its strand."""
    owner = {key: strand for strand in strands for key in strand.keys}
    return [(owner[key], key) for key in keys if key in owner]


def _cluster(scheduler: str | None) -> AbstractContextManager[Any]:
    """Connect to a dask cluster.

    Raises
    ------
    InputError
        When dask is not installed, or no scheduler answers.
    """
    try:
        from distributed import Client
    except ImportError:
        expected = "loky or threading is accepted; dask needs `pip install distributed`"
        raise InputError([Problem("--backend", "dask", expected)]) from None
    if scheduler is None:
        expected = "the address of a scheduler, as tcp://host:8786, is needed beside --backend dask"
        raise InputError([Problem("--scheduler", scheduler, expected)])
    try:
        client = Client(scheduler, timeout=PATIENCE)
    except (OSError, ValueError) as error:
        expected = f"the address of a running scheduler, as tcp://host:8786, is accepted ({error})"
        raise InputError([Problem("--scheduler", scheduler, expected)]) from None
    return _Connected(client)


class _Connected:
    """A client, and joblib set up to use it, until the block ends."""

    def __init__(self, client: Any) -> None:
        self.client, self.config = client, parallel_config("dask")

    def __enter__(self) -> None:
        self.config.__enter__()

    def __exit__(self, *error: object) -> None:
        self.config.__exit__(*error)
        self.client.close()
