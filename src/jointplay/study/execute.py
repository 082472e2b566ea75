"""Run a study so that nothing computed is lost: cells in a pool, a journal, one dataset at the end.

The journal ``NAME.journal`` lies beside the result and stays after it, as one file, so that a study with
further values only runs those. What is put together depends on the cells' answers alone: not on workers,
batches, order or interruptions. The cells are those of a sweep, or those that one analysis hands out; an
analysis that hands out none has no journal.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import partial
from itertools import count
from pathlib import Path
from typing import Any

import xarray as xr

from jointplay.analysis.cells import cells_run_by
from jointplay.errors import InputError, Problem
from jointplay.study import inside, store
from jointplay.study.cells import CellSweep, ChainSweep, Strand, part, redone, remaining, swept
from jointplay.study.file import Loaded
from jointplay.study.journal import Journal, refuse_lost
from jointplay.study.pool import Pool
from jointplay.study.run import named, run

LOOK, RARELY = 0.5, 200  # s between looks at how far it is, and at least times what a look takes
PARTS = "accepted for studies with [vary]; this is one analysis, and only itself can put its cells together"


@dataclass(frozen=True)
class Outcome:
    """What a run gave: the dataset and its file; neither, of one part of several."""

    dataset: xr.Dataset | None
    path: Path | None
    journal: Path | None = None


def complete(
    study: Loaded,
    out: Path,
    pool: Pool,
    progress: Callable[[float], None] | None = None,
    **options: Any,
) -> Outcome:
    """Run a study of any kind and store its result; `options` are those of `execute`."""
    suited = execute if study.record.has_cells else _one_analysis
    return suited(study, out, pool, progress, **options)


def journal_of(out: Path | str, name: str, share: tuple[int, int] | None = None) -> Journal:
    """The journal of a study, or of one part of it."""
    part_of = f".part{share[0]}of{share[1]}" if share else ""
    return Journal(Path(out) / f"{name}{part_of}.journal")


def going_on(study: Loaded, out: Path | str, share: tuple[int, int] | None = None) -> tuple[str, ...]:
    """What the same command does after Ctrl-C, where it does not start over."""
    kept = study.record.has_cells or inside.divided(study.record)
    there = kept and journal_of(out, study.record.name, share).folder.exists()
    return ("go on; what is finished is kept",) if there else ()


def execute(
    study: Loaded,
    out: Path,
    pool: Pool,
    progress: Callable[[float], None] | None = None,
    *,
    fresh: bool = False,
    share: tuple[int, int] | None = None,
    say: Callable[[str], None] = lambda line: None,
) -> Outcome:
    """Run what is missing of a study with cells, and store its result.

    Parameters
    ----------
    study : Loaded
        A study whose `[vary]` says what its cells are.
    out : Path
        Where journal and result lie.
    pool : Pool
        What runs the cells.
    progress : callable, optional
        Called with the fraction done of what was missing.
    fresh : bool
        Drop what the journal holds.
    share : pair of int, optional
        Run part I of N only, as (I, N), into a journal of its own; `merge` puts the parts together.
    say : callable
        Called with a line where there is something to tell.

    Returns
    -------
    Outcome

    Raises
    ------
    InputError
        When another run is at the same study, or the journal was written by other code.
    OSError
        When something cannot be written.
    """
    sweep = swept(study.record)
    assert sweep is not None
    with journal_of(out, study.record.name, share).held(fresh) as journal:
        missing = _missing(part(sweep.strands, share), journal, say)
        if missing and pool.workers:
            sweep.warm()
        _run(missing, journal, pool, progress, say)
        outcome = (
            _stored(study, sweep, journal, out) if share is None else Outcome(None, None, journal.folder)
        )
        journal.compact()
        return outcome


def _missing(strands: Sequence[Strand], journal: Journal, say: Callable[[str], None]) -> list[Strand]:
    """What a journal lacks; cells that crashed are taken out of it."""
    index = journal.index()
    if again := redone(strands, index):
        journal.keep_only(index.keys() - again)
        index = {key: status for key, status in index.items() if key not in again}
    keys = [key for strand in strands for key in strand.keys]
    _tell(journal, keys, index, say)
    chained = any(len(strand.keys) > 1 for strand in strands)
    return remaining(strands, index, journal.load(keys) if chained else {})


def _run(missing: Sequence[Strand], journal: Journal, pool: Pool, progress, say) -> None:
    if missing:
        with _watched(journal, sum(len(strand.keys) for strand in missing), progress):
            pool.run(missing, journal, say)


def _one_analysis(
    study: Loaded,
    out: Path,
    pool: Pool,
    progress: Callable[[float], None] | None,
    *,
    fresh: bool = False,
    share: tuple[int, int] | None = None,
    say: Callable[[str], None] = lambda line: None,
) -> Outcome:
    """Run an analysis; the cells that it hands out go to a journal, which is held from the first on."""
    name, journal, calls = study.record.name, journal_of(out, study.record.name), count()
    if share:
        raise InputError([Problem("--part", name, PARTS)])
    with ExitStack() as held:

        def keep(function, cells, progress) -> list[dict[str, Any]]:
            call = next(calls)
            if not call:
                held.enter_context(journal.held(fresh))
            strands = inside.strands(study.record, call, function, cells)
            _run(_missing(strands, journal, say), journal, pool, progress, say)
            answers = journal.load(strand.key for strand in strands)
            refuse_lost(len(strands) - len(answers))
            return [answers[strand.key] for strand in strands]

        with cells_run_by(keep):
            dataset = run(study, progress, pool.jobs)
        path = store.write_result(dataset, out / f"{name}.nc")
        if not next(calls):  # none was handed out
            return Outcome(dataset, path)
        journal.compact()
        return Outcome(dataset, path, journal.folder)


def _tell(journal: Journal, keys: list[str], index: Mapping[str, int], say: Callable[[str], None]) -> None:
    there = sum(key in index for key in keys)
    if journal.damaged:
        names = ", ".join(sorted(journal.damaged))
        say(f"journal  {len(journal.damaged)} damaged part(s) left aside, their cells run again: {names}")
    if there:
        say(f"journal  {there} of {len(keys)} cells are there already")
    if others := len(index.keys() - set(keys)):
        say(f"journal  {others} cells of other values or settings are kept; --fresh drops them")


def _stored(study: Loaded, sweep: CellSweep | ChainSweep, journal: Journal, out: Path) -> Outcome:
    keys = {key for strand in sweep.strands for key in strand.keys}
    dataset = named(study, sweep.assemble(partial(journal.answers, keys)))
    return Outcome(dataset, store.write_result(dataset, out / f"{study.record.name}.nc"), journal.folder)


@contextmanager
def _watched(journal: Journal, cells: int, progress: Callable[[float], None] | None) -> Iterator[None]:
    """Tell how far it is, by what the journal holds."""
    if progress is None:
        yield
        return
    before, over = journal.count(), threading.Event()

    def look() -> None:
        took = 0.0
        while not over.wait(max(LOOK, RARELY * took)):
            began = time.perf_counter()
            progress(min(1.0, (journal.count() - before) / cells))
            took = time.perf_counter() - began

    watcher = threading.Thread(target=look, daemon=True)
    watcher.start()
    try:
        yield
    finally:
        over.set()
        watcher.join()


def merge(study: Loaded, out: Path) -> Outcome:
    """Put the parts of a study together, each of which ran by itself, and store the result.

    Raises
    ------
    InputError
        When cells are missing, or a journal was written by other code.
    """
    sweep, name = swept(study.record), study.record.name
    if sweep is None:
        raise InputError([Problem("study", name, "a study with cells, by its [vary], has parts to merge")])
    keys = [key for strand in sweep.strands for key in strand.keys]
    with journal_of(out, name).held() as whole:
        left = set(keys) - whole.index().keys()
        for folder in sorted(out.glob(f"{name}.part*of*.journal")):
            other = Journal(folder)
            other.check_code()
            left -= whole.take(other, left)
        if missing := len(left):
            expected = f"parts with all {len(keys)} cells are needed; {missing} are missing"
            raise InputError([Problem("parts", str(out / f"{name}.part*of*.journal"), expected)])
        outcome = _stored(study, sweep, whole, out)
        whole.compact()
        return outcome
