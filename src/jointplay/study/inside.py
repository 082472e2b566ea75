"""Cells inside one analysis: blocks of a plane of starts, or the runs behind a table.

The analysis divides its work itself, by the study alone and not by who runs it, and hands the cells to
`analysis.cells.run_cells`, which passes them on to whoever is set there. A cell's key says in so many
hexadecimal digits: the hash of the study, which call of `run_cells` this is, the cell's number, and how many
there are; so a journal tells how much of a study is finished.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

from jointplay.analysis.cells import cells_run_by
from jointplay.errors import InputError, Problem
from jointplay.study.cells import Cell
from jointplay.study.journal import KEY, key_of
from jointplay.study.kinds import Study
from jointplay.study.run import analysed, takes_jobs

CALL, NUMBER = 2, 7  # digits
HASH = KEY - CALL - 2 * NUMBER


def divided(record: Study) -> bool:
    """Whether a study is one analysis that has cells inside: its function takes a number of workers.

    What can do without a plane of starts has cells only where there is one.
    """
    plane = getattr(record.analysis, "plane", ())
    return not record.has_cells and takes_jobs(record.kind) and plane is not None


def head(record: Study) -> str:
    """How the keys of a study's cells begin."""
    return key_of(record.kind, record.integrator, record.analysis, record.mechanism)[:HASH]


def strands(
    record: Study, call: int, function: Callable[..., dict[str, Any]], cells: Sequence[dict[str, Any]]
) -> list[Cell]:
    """The cells that an analysis hands out in one call, the first being number 0."""
    begin, end = f"{head(record)}{call:0{CALL}x}", f"{len(cells):0{NUMBER}x}"
    return [Cell(function, each, f"{begin}{i:0{NUMBER}x}{end}") for i, each in enumerate(cells)]


def total(keys: Iterable[str]) -> int:
    """How many cells there are in the calls that these keys are of; 0 where there is no key."""
    each = {key[HASH : HASH + CALL]: int(key[-NUMBER:], 16) for key in keys}
    return sum(each.values())


class Inside:
    """The cells of an analysis that has not run, looked at without running them.

    Raises
    ------
    InputError
        When the analysis hands out none.
    """

    def __init__(self, record: Study) -> None:
        try:
            with cells_run_by(_refuse):
                analysed(record)
        except _HandedOut as handed:
            self.strands = strands(record, 0, *handed.args)
            return
        raise InputError([Problem("study", record.name, "a study with cells is accepted; this has none")])

    @property
    def shape(self) -> dict[str, int]:
        """How many they are."""
        return {"inside one analysis": len(self.strands)}

    def warm(self) -> None:
        """The analysis has compiled what they need."""


class _HandedOut(Exception):
    """A function and the keywords of its calls."""


def _refuse(function: Callable[..., Any], cells: Sequence[dict[str, Any]], _: Any) -> list[dict[str, Any]]:
    raise _HandedOut(function, cells)
