"""The pool that runs the cells of a sweep: processes, threads, a dask cluster, or this process alone.

Kernels are compiled before the pool starts. Tasks grow from one cell to as many as fill half a second. When a
worker process dies, the whole pool is given up: the cells that were in flight then run once more, each
alone; one that dies again is marked `crashed`, and the rest goes on in a new pool.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from jointplay.errors import InputError, Problem
from jointplay.jobs.cluster import Cluster, connected
from jointplay.jobs.job import CRASHED, Job, remaining
from jointplay.jobs.journal import Journal
from jointplay.jobs.parallel import BrokenProcessPool
from jointplay.jobs.worker import DIED, Done, in_tasks

MOST_JOBS = 1000  # worker processes
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

    def run(self, jobs: Sequence[Job], journal: Journal, say: Callable[[str], None]) -> None:
        """Run every job; what its cells answer is in the journal afterwards.

        Raises
        ------
        OSError
            When the journal cannot be written, workers die before they begin, or a cluster is lost.
        """
        if self.backend == "dask":
            with connected(self.scheduler) as client:
                Cluster(client, journal, say).run(jobs)
            return
        left, deaths = list(jobs), 0
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
                for job, key in suspects:
                    _alone(job, key, journal, say)
                left = _left(left, journal)

    def _round(self, jobs: Sequence[Job], journal: Journal) -> None:
        """Run jobs in one pool."""
        workers = min(self.jobs, len(jobs))  # a worker without a task would only start
        backend = self.backend if workers > 1 else "here"
        in_tasks(jobs, _nothing, workers, backend, _folder(journal))


def _folder(journal: Journal) -> str:
    return str(journal.folder.absolute())


def _nothing(_: Done) -> None:
    """Nothing to do: the answers of a task are in the journal."""


def _alone(job: Job, key: str, journal: Journal, say: Callable[[str], None]) -> None:
    """Run a job up to a cell that may have killed its worker."""
    try:
        in_tasks([job.only(key)], _nothing, workers=1, folder=_folder(journal))
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
    found = re.fullmatch(r"([0-9]{1,9})/([0-9]{1,9})", text)
    if found and 1 <= int(found[1]) <= int(found[2]):
        return int(found[1]), int(found[2])
    raise InputError([Problem("--part", text, "I/N is accepted, part I of N, such as 2/5")])


def _left(jobs: Sequence[Job], journal: Journal) -> list[Job]:
    index = journal.index()
    answers = journal.load(key for job in jobs if len(job.keys) > 1 for key in job.keys)
    return remaining(jobs, index, answers)


def _owned(jobs: Sequence[Job], keys: Sequence[str]) -> list[tuple[Job, str]]:
    """Cells that were in flight, each with its job."""
    owner = {key: job for job in jobs for key in job.keys}
    return [(owner[key], key) for key in keys if key in owner]


def check_jobs(jobs: int | None) -> None:
    """Refuse a number of worker processes that there cannot be.

    Raises
    ------
    jointplay.errors.InputError
        As it says.
    """
    if jobs is not None and not 1 <= jobs <= MOST_JOBS:
        accepted = f"a whole number of worker processes from 1 to {MOST_JOBS} is accepted"
        raise InputError([Problem("--jobs", jobs, accepted)])
