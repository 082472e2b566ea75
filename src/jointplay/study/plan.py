"""The cost of a study before it runs, and its progress: cells, chains, time, size."""

from __future__ import annotations

import math
import os
import time
from collections import Counter
from collections.abc import Iterable, Iterator
from functools import partial
from math import prod
from pathlib import Path
from typing import Any

import numpy as np

from jointplay.analysis.cells import Work, in_memory
from jointplay.display.errors import InputError
from jointplay.display.number_text import duration
from jointplay.jobs.job import CRASHED, Job, Kept
from jointplay.jobs.journal import Journal
from jointplay.solver.method.codes import Status
from jointplay.study.execute import journal_of, part_journals
from jointplay.study.file import Loaded, validate
from jointplay.study.models import Study
from jointplay.study.result_state import result_state
from jointplay.study.results.store import open_result
from jointplay.study.results.summary import answer
from jointplay.study.run import (
    computed,
    count_by_keys,
    first_work,
    grows,
    has_cells,
    study_hash,
    with_journal_keys,
)

LENGTHS = ("turns", "transient")
FOLLOW = "more may follow from what these find"
NOTES = {
    Status.CRASHED.word: " (these run again)",
    Status.NOT_RUN.word: " (cut short by the budget; others go on with them)",
}
LEAST = 20  # turns of one analysis that are timed, beside twice as many


def plan(study: Loaded, out: Path, jobs: int) -> Iterator[str]:
    """Estimate a run: number of cells, parallel work, duration, and size of the result.

    One missing cell in the middle is computed and timed, of an ensemble as many as run at once; nothing is
    written.

    Parameters
    ----------
    study : Loaded
        The study.
    out : Path
        Where its journal would lie: finished cells are taken off.
    jobs : int
        Workers.

    Yields
    ------
    str
        A line.
    """
    if not has_cells(study.record):
        yield from _plan_of_one(study, out)
        return
    work = first_work(study.record)
    queue, _ = with_journal_keys(study.record, work)
    cells, journal = prod(work.shape.values()), journal_of(out, study.record.name)
    index = journal.index()
    yield f"cells    {cells}: " + " x ".join(f"{n} {dim}" for dim, n in work.shape.items())
    if work.possible:
        more = f"more follow, up to {len(work.possible)}"
        yield f"refine   where these differ {more}, which are not estimated here"
    if grows(study.record):
        yield f"follow   {FOLLOW}, which are not estimated here"
    chains = [keys for job in queue for keys in job.chains]
    if chains:
        longest = max(map(len, chains))
        yield f"chains   {len(chains)} of up to {longest} points, one after another; chains run side by side"
    left = [_left(job, index) for job in queue]
    missing, width = sum(left), sum(n > 0 for n in left)
    yield f"to do    {missing}; {cells - missing} are in the journal"
    yield from _journal_lines(journal, {key for job in queue for key in job.keys})
    if missing:
        yield f"parallel {min(jobs, width)} of {jobs} workers have something to do at once"
    todo = [i for i, n in enumerate(left) if n] or [0]
    seconds, size, status = _timed(work, queue[todo[len(todo) // 2]])
    yield f"one cell {seconds:.2g} s, {_bytes(size)}" + (f" ({Status(status).word})" if status else "")
    if missing:
        yield f"time     about {duration(_longest(left, jobs) * seconds)}"
    if not work.numbered:  # the size of an analysis's own dataset is not known before
        yield f"result   about {_bytes(size * cells)} before compression"


def _plan_of_one(study: Loaded, out: Path) -> Iterator[str]:
    """Estimate a study of one analysis, by a short run of it where it can be shortened."""
    record = study.record
    yield "cells    none: this is one analysis, which runs in one piece"
    yield f"result   {_result(study, out)}"
    given = dict(record.analysis)
    whole = {key: given[key] for key in LENGTHS if given.get(key)}
    total = sum(whole.values())
    parts = [{key: math.ceil(n * value / total) for key, value in whole.items()} for n in (LEAST, 2 * LEAST)]
    if (
        total <= 4 * LEAST
        or given.get("windows")
        or None in (taken := [_shortened(record, n) for n in parts])
    ):
        yield "time     not known before it runs"
        return
    first, second = (sum(part.values()) for part in parts)
    each = max(taken[1] - taken[0], 0.0) / (second - first)
    yield f"time     about {duration(taken[1] + each * (total - second))}, by {second} of {total:g} turns"


def _shortened(record: Study, lengths: dict[str, int]) -> float | None:
    """Seconds that a study takes with these lengths, compilation not counted; None where they do not suit."""
    try:
        checked = validate({**record.model_dump(), "analysis": {**dict(record.analysis), **lengths}})
    except InputError:
        return None
    for _ in range(2):  # the first compiles
        began = time.perf_counter()
        computed(checked, partial(in_memory, 1))
    return time.perf_counter() - began


def _left(job: Job, index: dict[str, int]) -> int:
    """Cells of a job that a run would compute."""
    rest = job.left({key for key in job.keys if index.get(key, CRASHED) != CRASHED}, {})
    return len(rest.keys) if rest else 0


def _longest(left: list[int], jobs: int) -> int:
    """Cells of the busiest worker, if jobs go one by one to the worker that has least."""
    busy = [0] * min(jobs, len(left))
    for n in left:
        busy[busy.index(min(busy))] += n
    return max(busy)


def _timed(work: Work, job: Job) -> tuple[float, int, int]:
    """Seconds and size of one cell, and its status; compilation is not counted."""
    work.warm()
    notes, began = Kept(), time.perf_counter()
    job.sample().run(notes)
    each = (time.perf_counter() - began) / len(notes.answers)
    answer = next(iter(notes.answers.values()))
    return each, _size(answer), int(answer["status"])


def _size(value: Any) -> int:
    """Bytes of the numbers in an answer."""
    if isinstance(value, dict):
        return sum(map(_size, value.values()))
    if isinstance(value, tuple | list):
        return sum(map(_size, value))
    return value.nbytes if isinstance(value, np.ndarray | np.generic) else 8 * isinstance(value, int | float)


def status(study: Loaded, out: Path) -> Iterator[str]:
    """Report the progress of a study, by its journal and its result.

    Yields
    ------
    str
        A line.
    """
    name, journal = study.record.name, journal_of(out, study.record.name)
    if not has_cells(study.record):
        yield "cells    none: this is one analysis, which runs in one piece"
        if os.path.exists(partial_result := out / f"{name}.partial.nc"):
            yield f"partial  {partial_result}: what an interrupted run had computed"
        yield f"result   {_result(study, out)}"
        yield from _answer(study, out / f"{name}.nc")
        return
    parts = part_journals(out, name)
    index, cells = _finished(study, indices := [each.index() for each in (*parts, journal)])
    more = f"; {FOLLOW}" if grows(study.record) and not _has_own(study, out / f"{name}.nc") else ""
    yield f"cells    {len(index)}" + (f" of {cells}" if cells else "") + f" finished{more}"
    ends = Counter(Status(code).word for code in index.values() if code)
    for word, n in sorted(ends.items()):
        yield f"{word:<8} {n}{NOTES.get(word, '')}"
    for each in (*parts, journal):
        yield from _journal_lines(each, index)
        if os.path.exists(each.folder) and (writer := each.writer()) is not None:
            yield f"running  process {writer}" + ("" if each is journal else f" ({each.folder.name})")
    if own := sum(bool(each.keys() & index.keys()) for each in indices[:-1]):
        yield f"parts    {own}, put together by `jointplay merge`"
    if others := len(parts) - own:
        yield f"parts    {others} without a finished cell of this study as it is now"
    yield f"result   {_result(study, out)}"
    if 0 < len(index) == cells:
        yield from _answer(study, out / f"{name}.nc")


def _answer(study: Loaded, path: Path) -> Iterator[str]:
    """The answer of a stored result, if it is this study's own."""
    if _has_own(study, path):
        yield from answer(open_result(path))


def _has_own(study: Loaded, path: Path) -> bool:
    """Whether a result is there that is this study's own."""
    return "other" not in (result_state(study.record, path) or "other")


def _journal_lines(journal: Journal, keys: Iterable[str]) -> Iterator[str]:
    """Lines on a journal that has been read, and on the cells with these keys."""
    other = journal.other_code()
    yield from (f"journal  {line}" for line in ([other] if other else journal.notes(keys)))


def _finished(study: Loaded, indices: Iterable[dict[str, int]]) -> tuple[dict[str, int], int]:
    """Status of each cell of a study that journals name, and the number of its cells; 0 if not known."""
    index = {key: status for each in indices for key, status in each.items()}
    if not study.record.vary:  # the analysis need not begin for that
        begin = study_hash(study.record)
        finished = {key: status for key, status in index.items() if key.startswith(begin)}
        if finished or not index:
            return finished, count_by_keys(finished)
    work = first_work(study.record)
    keys = {*work.possible} or {key for job in work.jobs for key in job.keys}
    found = {key: status for key, status in index.items() if key in keys}
    return found, 0 if work.possible else len(keys)


def _result(study: Loaded, out: Path) -> str:
    """The result of a study and whose it is."""
    path = out / f"{study.record.name}.nc"
    state = result_state(study.record, path)
    return f"{path}: {state}" if state else "none yet; `jointplay run` computes it"


def _bytes(n: float) -> str:
    for unit, size in (("GB", 1e9), ("MB", 1e6), ("kB", 1e3)):
        if n >= size:
            return f"{n / size:.3g} {unit}"
    return f"{n:.3g} B"
