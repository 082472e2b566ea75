"""Workers: run the jobs of a task, and write each cell to the journal as it finishes.

Tasks grow from one job to as many as fill half a second.
"""

from __future__ import annotations

import math
import os
import time
import uuid
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Self

from jointplay.jobs.job import KEY, Entry, Job
from jointplay.jobs.journal import write_part
from jointplay.jobs.origin import Origin, code, own
from jointplay.jobs.parallel import side_by_side
from jointplay.solver.motion.progress import heard

FILL = 0.5  # s that a task is to last
BATCH = 0.5  # s; cells shorter than this share a part of the journal
PLACE = 80  # letters of where a cell stands


@dataclass(frozen=True)
class Task:
    """Cells for a worker.

    Parameters
    ----------
    jobs : sequence of Job
        What to run.
    folder : str, optional
        The journal's; None where this machine cannot reach it: answers then travel back.
    limit : float, optional
        Seconds after which answers travel back, though cells are left.
    code : str, optional
        Digest of the code that is to compute them, as `origin.code` gives it.
    marks : str, optional
        Folder in which it is noted at which cell a worker is.
    """

    jobs: Sequence[Job]
    folder: str | None
    limit: float | None = None
    code: str | None = None
    marks: str | None = None


@dataclass(frozen=True)
class Done:
    """Result of a task: number of jobs, seconds taken, answers that travel back, and their origin."""

    count: int
    seconds: float
    answers: dict[str, Entry]
    origin: Origin


def work(task: Task) -> Done:
    """Run a task; its answers go to the journal. `RuntimeError` where it needs other code than this."""
    if task.code not in (None, code()):
        raise RuntimeError(f"its code is {code()}, and {task.code} is needed")
    began = time.perf_counter()
    with Notes(task.folder, task.limit, task.marks) as notes, suppress(_TimeIsUp):
        for job in task.jobs:
            job.run(notes)
    answers = notes.answers if task.folder is None else {}
    return Done(len(task.jobs), time.perf_counter() - began, answers, own())


class _TimeIsUp(Exception):
    """Ends a task between two cells."""


class Notes:
    """Writes down at which cell a worker is, and the answers of finished cells."""

    def __init__(self, folder: str | None, limit: float | None = None, marks: str | None = None) -> None:
        self.folder = None if folder is None else Path(folder)
        self.end = math.inf if limit is None else time.monotonic() + limit
        self.late = False
        self.answers: dict[str, Entry] = {}
        self.written = time.monotonic()
        self.mark = Path(marks) / f"{os.getpid()}-{uuid.uuid4().hex[:8]}.at" if marks else None
        self.file = self.mark and self.mark.open("wb", buffering=0)  # once: to open one takes 0.2 ms
        self.key, self.held = "", ExitStack()

    def begin(self, key: str) -> None:
        """Note that a cell begins; end the task instead where its time is up and a cell is finished."""
        if self.late:
            raise _TimeIsUp
        self.key = key
        self._note(0.0, "")

    def _note(self, fraction: float, place: str) -> None:
        """Write down at which cell the worker is, how much of it is done, and where it stands."""
        if self.file:
            self.file.seek(0)
            self.file.write(f"{self.key:{KEY}} {fraction:.4f} {place[:PLACE]:{PLACE}}".encode())

    def put(self, key: str, answer: Entry) -> None:
        """Keep the answer of a finished cell."""
        self.answers[key] = answer
        if time.monotonic() - self.written >= BATCH:
            self._write()
        self.late = time.monotonic() >= self.end

    def _write(self) -> None:
        if self.folder and self.answers:
            write_part(self.folder, self.answers)
            self.answers, self.written = {}, time.monotonic()

    def __enter__(self) -> Self:
        self.held.enter_context(heard(self._note))
        return self

    def __exit__(self, *_: object) -> None:
        self.held.close()
        self._write()
        if self.file and self.mark:
            self.file.close()
            self.mark.unlink(missing_ok=True)


class Pace:
    """Number of jobs in a task, by the duration of earlier ones."""

    def __init__(self) -> None:
        self.done, self.seconds = 0, 0.0

    def learn(self, done: Done) -> None:
        """Add the duration of a task."""
        self.done, self.seconds = self.done + done.count, self.seconds + done.seconds

    def size(self, left: int, workers: int) -> int:
        """Number of jobs of the next task; towards the end fewer, so that all workers end at once."""
        wanted = int(FILL * self.done / self.seconds) if self.seconds else 1
        return max(1, min(wanted, left // (4 * max(workers, 1))))


def in_tasks(
    jobs: Sequence[Job],
    workers: int,
    backend: str = "loky",
    folder: str | None = None,
    take: Callable[[Done], None] = lambda _: None,
    tick: Callable[[], None] = lambda: None,
    marks: str | None = None,
) -> None:
    """Run jobs in tasks on this machine.

    Parameters
    ----------
    jobs : sequence of Job
        In their order.
    workers, backend, tick
        As in `side_by_side`.
    folder : str, optional
        The journal's; else answers travel back.
    take : callable
        Called with the result of each task.
    marks : str, optional
        As in `Task`; the journal's if left out.
    """
    pace, left = Pace(), deque(jobs)

    def tasks() -> Iterator[Callable[[], Done]]:
        while left:
            batch = [left.popleft() for _ in range(pace.size(len(left), workers))]
            yield partial(work, Task(batch, folder, marks=marks or folder))

    def took(done: Done) -> None:
        pace.learn(done)
        take(done)

    side_by_side(tasks(), took, workers, backend, tick)
