"""Results of a benchmark: quantities computed, and as published."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Digits:
    """A quantity of a benchmark, in SI units, computed and as it was published."""

    quantity: str
    units: str
    computed: float
    published: float


@dataclass(frozen=True)
class Answer:
    """A benchmark that was run: its rows, its status, and the counts of its evaluations."""

    rows: tuple[Digits, ...]
    status: int
    counts: dict[str, int]
