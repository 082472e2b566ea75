"""The pool that runs the cells of a sweep: processes, threads, a dask cluster, or this process alone.

Kernels are compiled before the pool starts. Tasks grow from one cell to as many as fill half a second. When a
worker process dies, joblib gives the whole pool up: the cells that were in flight then run once more, each
alone; one that dies again is marked `crashed`, and the rest goes on in a new pool.
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
from jointplay.study.cells import Strand, remaining
from jointplay.study.cluster import Cluster, connected
from jointplay.study.journal import CRASHED, Journal
from jointplay.study.pace import Pace
from jointplay.study.run import check_jobs
from jointplay.study.worker import DIED, Task, work

DEATHS = 3  # of pools without a cell in flight, before giving up


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
            When the journal cannot be written, workers die before they begin, or a cluster is lost.
        """
        if self.backend == "dask":
            with connected(self.scheduler) as client:
                Cluster(client, journal, say).run(strands)
            return
        left, deaths = list(strands), 0
        while left:
            try:
                self._round(left, journal)
                return
            except BrokenProcessPool:
                left = _left(left, journal)
                suspects = _owned(left, journal.in_flight())
                deaths += not suspects
                if deaths == DEATHS:
                    raise OSError("worker processes die before they begin; try --jobs 1") from None
                say(f"a worker process died; {len(suspects)} cells in flight run once more, each alone")
                for strand, key in suspects:
                    _alone(strand, key, journal, say)
                left = _left(left, journal)

    def _round(self, strands: Sequence[Strand], journal: Journal) -> None:
        """Run strands in one pool; joblib asks for the next task as workers get free."""
        pace = Pace()

        def tasks() -> Iterator[Any]:
            at = 0
            while at < len(strands):
                size = pace.size(len(strands) - at, self.jobs)
                yield delayed(work)(_task(strands[at : at + size], journal))
                at += size

        with self._context():
            pool = Parallel(
                n_jobs=self.jobs,
                return_as="generator_unordered",
                batch_size=1,
                pre_dispatch="2 * n_jobs",
            )
            for done in pool(tasks()):
                pace.learn(done)

    def _context(self) -> AbstractContextManager[Any]:
        if self.jobs == 1:
            return nullcontext()
        only_one = {"inner_max_num_threads": 1} if self.backend == "loky" else {}
        return parallel_config(self.backend, **only_one)


def _task(strands: Sequence[Strand], journal: Journal) -> Task:
    return Task(strands, str(journal.folder.absolute()), os.getpid())


def _alone(strand: Strand, key: str, journal: Journal, say: Callable[[str], None]) -> None:
    """Run a strand up to a cell that may have killed its worker."""
    task = _task([strand.only(key)], journal)
    try:
        with parallel_config("loky", inner_max_num_threads=1):
            for _ in Parallel(n_jobs=2, return_as="generator_unordered")([delayed(work)(task)]):
                pass
    except BrokenProcessPool:
        at = journal.in_flight()
        for fatal in {key, *at} if at else {key}:
            if fatal not in journal.index():
                say(f"cell marked as crashed: {DIED}")
                journal.write({fatal: {"status": CRASHED, "trouble": DIED}})


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


def _left(strands: Sequence[Strand], journal: Journal) -> list[Strand]:
    index = journal.index()
    answers = journal.load(key for strand in strands if len(strand.keys) > 1 for key in strand.keys)
    return remaining(strands, index, answers)


def _owned(strands: Sequence[Strand], keys: Sequence[str]) -> list[tuple[Strand, str]]:
    """Cells that were in flight, each with its strand."""
    owner = {key: strand for strand in strands for key in strand.keys}
    return [(owner[key], key) for key in keys if key in owner]
