"""Jobs of workers: one cell each, or several that run one after another.

In a job of several cells each may start from where the one before it ended.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from itertools import islice
from typing import Any, Protocol

from jointplay.solver.method.codes import Status

Entry = dict[str, Any]  # the answer of a cell: its `status` and its results
CRASHED = int(Status.CRASHED)
KEY = 32  # letters of a key


def key_of(*parts: Any) -> str:
    """Hash of plain values and records; numbers enter by their shortest exact text."""
    text = json.dumps(parts, sort_keys=True, separators=(",", ":"), default=_plain)
    return hashlib.sha256(text.encode()).hexdigest()[:KEY]


def _plain(value: Any) -> Any:
    if hasattr(value, "model_dump_json"):
        return value.model_dump_json()
    return value.tolist() if hasattr(value, "tolist") else repr(value)


class Notes(Protocol):
    """Notes in which a job keeps its progress and its answers."""

    def begin(self, key: str) -> None:
        """Note that a cell begins."""

    def put(self, key: str, answer: Entry) -> None:
        """Keep the answer of a finished cell."""


class Job(Protocol):
    """Cells that run one after another; `chains`: keys of cells that start where the one before ended."""

    keys: tuple[str, ...]
    chains: tuple[tuple[str, ...], ...]

    def run(self, notes: Notes) -> None:
        """Run the cells."""

    def only(self, key: str) -> Job:
        """The job up to the cell of this key."""

    def sample(self) -> Job:
        """The job that is timed to estimate the cost of a cell."""

    def left(self, done: Container[str], answers: Mapping[str, Entry]) -> Job | None:
        """The job of the cells that are not in `done`; None if there are none."""


class Kept:
    """Notes in memory; `changed` is called with all answers whenever there are more."""

    def __init__(self, changed: Callable[[dict[str, Entry]], None] = lambda _: None) -> None:
        self.answers: dict[str, Entry] = {}
        self.changed = changed

    def begin(self, key: str) -> None:
        """Do nothing."""

    def put(self, key: str, answer: Entry) -> None:
        """Keep the answer."""
        self.add({key: answer})

    def add(self, answers: Mapping[str, Entry]) -> None:
        """Keep several."""
        self.answers |= answers
        self.changed(self.answers)


def redone(jobs: Sequence[Job], index: Mapping[str, int]) -> set[str]:
    """Keys of the cells to run again: crashed ones, and the ones after them in a chain."""
    done = {key for key, status in index.items() if status != CRASHED}
    again = index.keys() - done
    for keys in (keys for job in jobs for keys in job.chains):
        n = next((i for i, key in enumerate(keys) if key not in done), len(keys))
        again |= {key for key in keys[n:] if key in done}
    return again


def remaining(jobs: Iterable[Job], done: Container[str], answers: Mapping[str, Entry]) -> list[Job]:
    """Jobs of the cells that are not in `done`; a chain goes on from the answers of its finished ones."""
    return [rest for job in jobs if (rest := job.left(done, answers)) is not None]


def part(jobs: Sequence[Job], share: tuple[int, int] | None) -> list[Job]:
    """The jobs of one part of a study, as (number from 1, number of parts); all if None."""
    return list(jobs) if share is None else list(islice(jobs, share[0] - 1, None, share[1]))
