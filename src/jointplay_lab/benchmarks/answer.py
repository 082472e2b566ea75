"""Results of a benchmark: quantities computed, and as published."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from jointplay.solver.motion.trajectory import Records


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


def compared(
    published: Mapping[str, tuple[str, float]], computed: Iterable[float], records: Records
) -> Answer:
    """The answer of a motion: numbers computed, in the order of those published with their units."""
    rows = zip(published.items(), computed, strict=True)
    made = (Digits(name, units, float(value), known) for (name, (units, known)), value in rows)
    return Answer(tuple(made), records.status, records.counts)
