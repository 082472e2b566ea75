"""What workers run: strands of cells that run one after another, and what is left of them to run.

A strand of one is a cell by itself. In a longer one each cell may start from where the last one ended.
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
    """Where a strand writes."""

    def begin(self, key: str) -> None:
        """Say that a cell is begun."""

    def put(self, key: str, answer: Entry) -> None:
        """Keep the answer of a finished cell."""


class Strand(Protocol):
    """Cells that run one after another; `carried`: each from where the one before it ended."""

    keys: tuple[str, ...]
    carried: bool

    def run(self, notes: Notes) -> None:
        """Run them."""

    def only(self, key: str) -> Strand:
        """Give the strand that ends with the cell of this key."""

    def sample(self) -> Strand:
        """Give what is run to tell what a cell costs."""

    def left(self, done: Container[str], answers: Mapping[str, Entry]) -> Strand | None:
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


def redone(strands: Sequence[Strand], index: Mapping[str, int]) -> set[str]:
    """Keys of the cells that are to run again: those that crashed, and what follows them in a chain."""
    done = {key for key, status in index.items() if status != CRASHED}
    found = {key for key in index if key not in done}
    for strand in strands:
        n = next((i for i, key in enumerate(strand.keys) if key not in done), len(strand.keys))
        if strand.carried:
            found |= {key for key in strand.keys[n:] if key in done}
    return found


def remaining(strands: Iterable[Strand], done: Container[str], answers: Mapping[str, Entry]) -> list[Strand]:
    """What is left to run of some strands, where the cells in `done` are finished."""
    return [rest for strand in strands if (rest := strand.left(done, answers)) is not None]


def part(strands: Sequence[Strand], share: tuple[int, int] | None) -> list[Strand]:
    """The strands of one of several parts, as (number from 1, how many); all if None."""
    return list(strands) if share is None else list(islice(strands, share[0] - 1, None, share[1]))
