"""What workers run: jobs of cells that run one after another, and what is left of them to run.

A job of one is a cell by itself. In a longer one each cell may start from where the last one ended.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from itertools import islice
from typing import Any, Protocol

from jointplay.numerics.codes import Status

Entry = dict[str, Any]  # what a cell answers: its `status` and what else it has found
CRASHED = int(Status.CRASHED)
KEY = 32  # letters of a key


def key_of(*parts: Any) -> str:
    """Hash of plain values; numbers by their shortest text that gives them back."""
    text = json.dumps(parts, sort_keys=True, separators=(",", ":"), default=_plain)
    return hashlib.sha256(text.encode()).hexdigest()[:KEY]


def _plain(value: Any) -> Any:
    if hasattr(value, "model_dump_json"):
        return value.model_dump_json()
    return value.tolist() if hasattr(value, "tolist") else repr(value)


class Notes(Protocol):
    """Where a job writes."""

    def begin(self, key: str) -> None:
        """Say that a cell is begun."""

    def put(self, key: str, answer: Entry) -> None:
        """Keep the answer of a finished cell."""


class Job(Protocol):
    """Cells that run one after another; `carried`: each from where the one before it ended."""

    keys: tuple[str, ...]
    carried: bool

    def run(self, notes: Notes) -> None:
        """Run them."""

    def only(self, key: str) -> Job:
        """Give the job that ends with the cell of this key."""

    def sample(self) -> Job:
        """Give what is run to tell what a cell costs."""

    def left(self, done: Container[str], answers: Mapping[str, Entry]) -> Job | None:
        """Give what is left to run, where the cells in `done` are finished; None if nothing is."""


class Kept:
    """Notes in memory; `told` is called with all answers whenever there are more."""

    def __init__(self, told: Callable[[dict[str, Entry]], None] = lambda _: None) -> None:
        self.answers: dict[str, Entry] = {}
        self.told = told

    def begin(self, key: str) -> None:
        """Nothing to write."""

    def put(self, key: str, answer: Entry) -> None:
        """Keep the answer."""
        self.add({key: answer})

    def add(self, answers: Mapping[str, Entry]) -> None:
        """Keep several."""
        self.answers |= answers
        self.told(self.answers)


def redone(jobs: Sequence[Job], index: Mapping[str, int]) -> set[str]:
    """Keys of the cells that are to run again: those that crashed, and what follows them in a chain."""
    done = {key for key, status in index.items() if status != CRASHED}
    found = {key for key in index if key not in done}
    for job in jobs:
        n = next((i for i, key in enumerate(job.keys) if key not in done), len(job.keys))
        if job.carried:
            found |= {key for key in job.keys[n:] if key in done}
    return found


def remaining(jobs: Iterable[Job], done: Container[str], answers: Mapping[str, Entry]) -> list[Job]:
    """What is left to run of some jobs, where the cells in `done` are finished."""
    return [rest for job in jobs if (rest := job.left(done, answers)) is not None]


def part(jobs: Sequence[Job], share: tuple[int, int] | None) -> list[Job]:
    """The jobs of one of several parts, as (number from 1, how many); all if None."""
    return list(jobs) if share is None else list(islice(jobs, share[0] - 1, None, share[1]))
