"""The cells of a study: those of a `[vary]`, and the keys of those that one analysis hands out.

A cell of a `[vary]` is the analysis of its kind by itself, on a changed mechanism. It is known by the hash of
all that decides its answer. What one analysis hands out belongs to all of the study's settings: such a key
says in so many hexadecimal digits the hash of the study, which work of the analysis it is of, the cell's
number, and how many there are; so a journal tells how much of a study is finished.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from jointplay.analysis.cells import DIGITS, Cell, Steps, Work, warm
from jointplay.analysis.rules import quantity
from jointplay.analysis.sweeps import gather
from jointplay.analysis.tangents import warm_tangents
from jointplay.analysis.vary import changed
from jointplay.errors import InputError
from jointplay.jobs.job import KEY, Entry, Strand, key_of
from jointplay.mechanism.assemble import assemble
from jointplay.study.models import Study
from jointplay.study.vary_table import points

LOOKED = 32  # cells that are looked through for structures to compile
WORK = 2  # digits of which work of an analysis it is
HASH = KEY - WORK - 2 * DIGITS


def varied(
    record: Study, answer: Callable[..., Entry], progress: Callable[[float], None] | None = None
) -> Steps:
    """Hand out the cells of a `[vary]`, calls of `answer` with a study and changes, and stack them."""
    grid, alone = points(record.mechanism, record.vary), record.model_copy(update={"vary": {}, "figure": {}})
    keys = [_key(record, change) for change in grid.changes]
    cells = [
        Cell(answer, {"record": alone, "changes": change}, key)
        for change, key in zip(grid.changes, keys, strict=True)
    ]
    shape = dict(zip(grid.dims, grid.shape, strict=True))
    read = yield Work(cells, shape, progress, partial(compile_for, record, grid.changes))
    return gather.dataset(record.kind, grid, keys, read)


def _key(record: Study, change: Mapping[str, float]) -> str:
    told: tuple[Any, ...] = (record.kind, record.integrator, record.analysis)
    try:
        return key_of(*told, changed(record.mechanism, change))
    except InputError:  # the cell will say so
        return key_of(*told, record.mechanism, change)


def compile_for(record: Study, changes: Sequence[Mapping[str, float]] = ({},)) -> None:
    """Compile what a study with these changes needs, so that workers find it on the disk."""
    for change in (*changes[:: max(1, len(changes) // LOOKED)], changes[-1]):
        try:
            mechanism = changed(record.mechanism, change)
            section = getattr(record.analysis, "section", None)
            model = assemble(mechanism, None, quantity(section, mechanism))
        except InputError:
            continue
        warm([model])
        if record.row.tangents:
            warm_tangents(model)


def head(record: Study) -> str:
    """How the keys of the cells begin that the analysis of a study hands out by number."""
    return key_of(record.kind, record.integrator, record.analysis, record.mechanism)[:HASH]


def keyed(record: Study, work: Work, number: int = 0) -> tuple[list[Strand], int]:
    """The strands of an analysis's work under the keys of a journal, and how many letters were put before."""
    if not work.numbered:
        return list(work.strands), 0
    begin = f"{head(record)}{number:0{WORK}x}"
    return [replace(cell, key=begin + cell.key) for cell in work.strands], len(begin)


def counted(keys: Iterable[str]) -> int:
    """How many cells there are in the works that these keys, by number, are of; 0 where there is no key."""
    each = {key[HASH : HASH + WORK]: int(key[-DIGITS:], 16) for key in keys}
    return sum(each.values())
