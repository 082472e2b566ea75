"""The pool that runs the cells of a sweep: processes, threads, a dask cluster, or this process alone.

Kernels are compiled before the pool starts. Tasks grow from one cell to as many as fill half a second. When a
worker process dies, the whole pool is given up: the cells that were in flight then run once more, each
alone; one that dies again is marked `crashed`, and the rest goes on in a new pool.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from jointplay.display.errors import InputError, Problem
from jointplay.jobs.cluster import Cluster, connected
from jointplay.jobs.job import Job
from jointplay.jobs.journal import Journal
from jointplay.jobs.parallel import BrokenProcessPool
from jointplay.jobs.worker import in_tasks

MOST_JOBS = 1000  # worker processes
DEATHS = 3  # of pools without a cell in flight, before giving up


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
        """The pool that a user asks for; `InputError` where there can be none."""
        check_jobs(jobs)
        if scheduler is not None and backend != "dask":
            raise InputError([Problem("--scheduler", scheduler, "accepted beside --backend dask only")])
        return cls(jobs, backend, scheduler)

    @property
    def workers(self) -> bool:
        """Whether cells run beside this process."""
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
