"""What a worker does: run cells one after another and write each to the journal as it finishes."""

from __future__ import annotations

import math
import os
import signal
import threading
import time
import uuid
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

from jointplay.study.cells import Strand
from jointplay.study.journal import KEY, Entry, code, write_part

BATCH = 0.5  # s; cells shorter than this share a part of the journal
WATCH = 0.25  # s between looks whether the parent is still there
DIED = "the worker process died twice at this cell, as when memory runs out"


@dataclass(frozen=True)
class Task:
    """Cells for a worker.

    Parameters
    ----------
    strands : sequence of Strand
        What to run.
    folder : str, optional
        The journal; None where this machine cannot reach it: answers then travel back.
    parent : int, optional
        The process that sent the task, where it is on this machine: the worker ends with it.
    limit : float, optional
        Seconds after which answers travel back, though cells are left.
    code : str, optional
        Which code is to compute them, as `journal.code` tells.
    """

    strands: Sequence[Strand]
    folder: str | None
    parent: int | None = None
    limit: float | None = None
    code: str | None = None


@dataclass(frozen=True)
class Done:
    """What came of a task: how many strands, in how many seconds, and the answers that travel back."""

    strands: int
    seconds: float
    answers: dict[str, Entry]


def work(task: Task) -> Done:
    """Run the cells of a task; what each answers is in the journal.

    Raises
    ------
    RuntimeError
        When this is other code than the task asks for.
    """
    if task.code not in (None, code()):
        raise RuntimeError(f"its code is {code()}, and {task.code} is needed")
    if task.parent is not None and task.parent != os.getpid():
        _follow_parent(task.parent)
    began = time.perf_counter()
    with Notes(task.folder, task.limit) as notes, suppress(_TimeIsUp):
        for strand in task.strands:
            strand.run(notes)
    return Done(len(task.strands), time.perf_counter() - began, notes.answers if task.folder is None else {})


class _TimeIsUp(Exception):
    """Ends a task between two cells."""


class Notes:
    """What a worker writes down: at which cell it is, and what finished ones answered."""

    def __init__(self, folder: str | None, limit: float | None = None) -> None:
        self.folder = None if folder is None else Path(folder)
        self.end = math.inf if limit is None else time.monotonic() + limit
        self.late = False
        self.answers: dict[str, Entry] = {}
        self.written = time.monotonic()
        self.mark = self.folder and self.folder / f"{os.getpid()}-{uuid.uuid4().hex[:8]}.at"
        self.file = self.mark and self.mark.open("wb", buffering=0)  # once: to open one takes 0.2 ms

    def begin(self, key: str) -> None:
        """Say that a cell is begun; not after the time is up, if any has been finished."""
        if self.late:
            raise _TimeIsUp
        if self.file:
            self.file.seek(0)
            self.file.write(f"{key:{KEY}}".encode())

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
        return self

    def __exit__(self, *_: object) -> None:
        self._write()
        if self.file and self.mark:
            self.file.close()
            self.mark.unlink(missing_ok=True)


_watched: set[int] = set()


def _follow_parent(parent: int) -> None:
    """End when the parent does, and leave Ctrl-C to it."""
    with suppress(ValueError):  # only a main thread may
        signal.signal(signal.SIGINT, signal.SIG_IGN)
    if parent not in _watched:
        _watched.add(parent)
        threading.Thread(target=_watch, args=(parent,), daemon=True).start()


def _watch(parent: Any) -> None:
    while os.getppid() == parent:
        time.sleep(WATCH)
    os._exit(1)
