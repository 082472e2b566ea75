"""Run a study so that no result is lost: cells in a pool, a journal, one dataset at the end.

The journal ``NAME.journal`` lies beside the result and stays after it, as one file, so that a study with
further values only runs those. The dataset depends on the cells' answers alone: not on workers, batches,
order or interruptions. The cells are those of a sweep, or those that one analysis hands out; an
analysis that hands out none has no journal.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

from jointplay.analysis.cells import Read, Show, Work, in_memory
from jointplay.analysis.evaluate import RUN
from jointplay.analysis.labels import xr
from jointplay.display.errors import InputError, Problem
from jointplay.jobs import interrupts
from jointplay.jobs.job import Entry, Job, part, redone
from jointplay.jobs.journal import Journal, refuse_lost
from jointplay.jobs.origin import mixed, processor
from jointplay.jobs.pool import Pool
from jointplay.solver.method.codes import Status
from jointplay.solver.motion.progress import stoppable
from jointplay.study.file import Loaded
from jointplay.study.models import Study
from jointplay.study.results import store
from jointplay.study.results.outcome import name_of
from jointplay.study.run import (
    computed,
    first_work,
    has_cells,
    with_journal_keys,
    with_provenance,
    with_title,
)

LOOK, RARELY = 0.5, 200  # s between readings of the progress, and at least times what a reading takes


class Undrawn(KeyboardInterrupt):
    """An interrupt that came when the result was stored, or about to be: a picture can be drawn of it."""

    def __init__(self, path: Path | None) -> None:
        super().__init__(f"the result is stored; `jointplay figure {path}` draws it")


@dataclass(frozen=True)
class Outcome:
    """Result of a run: the dataset and its file; of one part of a study its journal alone."""

    dataset: xr.Dataset | None
    path: Path | None
    journal: Path | None = None


def journal_of(out: Path | str, name: str, share: tuple[int, int] | None = None) -> Journal:
    """The journal of a study, or of one part of it."""
    part_of = f".part{share[0]}of{share[1]}" if share else ""
    return Journal(Path(out) / f"{name}{part_of}.journal")


def resume_hint(study: Loaded, out: Path | str, share: tuple[int, int] | None = None) -> tuple[str, ...]:
    """Message on resuming by the same command after Ctrl-C; empty where it starts over."""
    kept = has_cells(study.record) and journal_of(out, study.record.name, share).folder.exists()
    return ("run the same command again to go on; what is finished is kept",) if kept else ()


def writable(
    study: Loaded, out: Path | str, share: tuple[int, int] | None = None, drawn: bool = True
) -> Path:
    """The folder of a run, made if needed, where all that it writes can be written; else `InputError`."""
    record, name = study.record, study.record.name
    journal = journal_of(out, name, share).folder.name
    endings = [
        ".nc",
        *[".partial.nc"] * record.row.kept,
        *[".txt"] * bool(record.row.outputs.table),
        *[".pdf", ".png"] * drawn,
    ]
    files = ["probe"] if share else [f"{name}{ending}" for ending in endings]
    return store.check_writable(out, files=files, folders=[journal] * has_cells(record))


def complete(
    study: Loaded,
    out: Path,
    pool: Pool,
    progress: Callable[[float], None] | None = None,
    *,
    fresh: bool = False,
    share: tuple[int, int] | None = None,
    say: Callable[[str], None] = lambda line: None,
    show: Show | None = None,
) -> Outcome:
    """Run the missing part of a study, and store its result.

    Parameters
    ----------
    study : Loaded
        A study of any kind.
    out : Path
        Where journal and result lie.
    pool : Pool
        Workers that run its cells.
    progress : callable, optional
        Called with the fraction done of what was missing.
    fresh : bool
        Drop what the journal holds.
    share : pair of int, optional
        Run part I of N only, as (I, N), into a journal of its own; `merge` puts the parts together.
    say : callable
        Called with each line of the report.
    show : callable, optional
        Called with the dataset so far and the number of a part that is final, as in `cells.driven`.

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
    record, name = study.record, study.record.name
    if share and not has_cells(record):
        expected = (
            "this is accepted of a study with cells, such as one with [vary]; this one is a single analysis"
        )
        raise InputError([Problem("--part", name, expected)])
    with ExitStack() as held:
        place = getattr(progress, "place", lambda _: None)
        kept = _Journaled(record, journal_of(out, name, share), pool, say, place, held, fresh, share)
        if share:
            kept(replace(_divisible(record), progress=progress))
            kept.tell_others()
            kept.journal.compact()
            return Outcome(None, None, kept.journal.folder)
        alone = not has_cells(record)
        with stoppable(record.row.kept and alone):
            titled = show and (lambda dataset, part: show(with_title(study, dataset), part))
            dataset = computed(record, kept, progress, titled)
            if alone:  # no journal keeps it: from here on Ctrl-C waits until it is stored
                pressed = held.enter_context(interrupts.held())
        kept.tell_others()
        unfinished = out / f"{name}.partial.nc"
        if name_of(dataset) == "interrupted":
            _say_partial(dataset, unfinished, say)
            raise KeyboardInterrupt
        try:
            done = _stored(study, dataset, kept.journal if kept.works else None, kept.keys, out, say)
        except KeyboardInterrupt:  # the whole result would take too long
            if record.row.kept and alone:
                _say_partial(dataset, unfinished, say)
            raise
        unfinished.unlink(missing_ok=True)
        if alone and pressed():
            raise Undrawn(done.path)
        return done


def _say_partial(dataset: xr.Dataset, path: Path, say: Callable[[str], None]) -> None:
    """Store the partial result of an interrupted run, and report its path."""
    stored = dataset.assign(status=RUN["status"].variable(Status.INTERRUPTED))
    say(f"partial  {store.write_partial(stored, path)}: what was computed up to here")


@dataclass
class _Journaled:
    """Runs the work of an analysis, and keeps its answers in a journal, which is locked from the first on."""

    record: Study
    journal: Journal
    pool: Pool
    say: Callable[[str], None]
    place: Callable[[str], None]  # called with where the cell stands that has farthest to go
    held: ExitStack
    fresh: bool
    share: tuple[int, int] | None
    works: int = 0
    keys: set[str] = field(default_factory=set)
    others: set[str] = field(default_factory=set)  # found in the journal, and not asked for so far

    def __call__(self, work: Work) -> Read:
        if not self.works:
            self.held.enter_context(self.journal.held(self.fresh))
        index = self.journal.index()
        self.others |= set() if self.works else index.keys()
        jobs, before = with_journal_keys(self.record, work, self.works)
        jobs = part(jobs, self.share)
        self.works += 1
        if missing := _missing(jobs, index, self.journal, self.say):
            if self.pool.workers:
                work.warm()
            cells = sum(len(job.keys) for job in missing)
            with _watched(self.journal, cells, work.progress, self.place):
                self.pool.run(missing, self.journal, self.say)
        keys = {key for job in jobs for key in job.keys}
        self.keys |= keys
        self.others -= keys.union(work.possible)
        return partial(_read, self.journal, keys, before)

    def tell_others(self) -> None:
        """Print the number of cells of the journal that no work needs."""
        if self.others:
            others = f"{len(self.others)} cells of other values or settings"
            self.say(f"journal  {others} are kept; --fresh drops them")


def _read(journal: Journal, keys: set[str], before: int = 0) -> Iterator[tuple[str, Entry]]:
    """Answers by their keys without the first `before` letters; `OSError` where one is missing."""
    left = len(keys)
    for key, answer in journal.answers(keys):
        left -= 1
        yield key[before:], answer
    refuse_lost(left)


def _missing(
    jobs: Sequence[Job], index: dict[str, int], journal: Journal, say: Callable[[str], None]
) -> list[Job]:
    """Jobs missing in a journal, by its index; cells that crashed are taken out of it."""
    keys = [key for job in jobs for key in job.keys]
    if again := redone(jobs, index) & {*keys}:  # those of earlier works are answers of this run
        journal.keep_only(index.keys() - again)
        index = {key: status for key, status in index.items() if key not in again}
    _report(journal, keys, index, say)
    return journal.remaining(jobs, index)


def _report(journal: Journal, keys: list[str], index: Mapping[str, int], say: Callable[[str], None]) -> None:
    there = sum(key in index for key in keys)
    for line in journal.notes(keys):
        say(f"journal  {line}")
    if there:
        say(f"journal  {there} of {len(keys)} cells are there already")
    if there < len(keys) and (kinds := journal.kinds(keys)) and kinds != {processor()}:
        say(f"journal  this is another kind of processor ({processor()}) than theirs: {', '.join(kinds)}")


def _stored(
    study: Loaded, dataset: xr.Dataset, journal: Journal | None, keys: set[str], out: Path, say
) -> Outcome:
    """Write a result with its provenance, and join the parts of its journal."""
    kinds = journal.kinds(keys) if journal else set()
    if line := mixed(kinds):
        say(f"result  computed on {line}")
    dataset = with_provenance(study, dataset, kinds)
    path = store.write_result(dataset, out / f"{study.record.name}.nc")
    if journal is None:
        return Outcome(dataset, path)
    journal.compact()
    return Outcome(dataset, path, journal.folder)


@contextmanager
def _watched(
    journal: Journal, cells: int, progress: Callable[[float], None] | None, place: Callable[[str], None]
) -> Iterator[None]:
    """Report progress, by the cells in the journal and by what is done of those that workers are at."""
    if progress is None:
        yield
        return
    before, over = journal.count(), threading.Event()

    def look() -> None:
        took = 0.0
        while not over.wait(max(LOOK, RARELY * took)):
            began = time.perf_counter()
            at = [*journal.places()]
            place(min(at, default=(0.0, ""))[1])
            progress(min(1.0, (journal.count() - before + sum(done for done, _ in at)) / cells))
            took = time.perf_counter() - began

    watcher = threading.Thread(target=look, daemon=True)
    watcher.start()
    try:
        yield
    finally:
        over.set()
        watcher.join()
        place("")


def _divisible(record: Study) -> Work:
    """The cells of a study that are known before any is computed; `InputError` where others follow."""
    work = first_work(record)
    if work.possible:
        expected = (
            "a study whose cells are known before it runs is accepted; with refine, answers decide: "
            "run it whole with --jobs N, or on many machines with --backend dask, or in parts with refine = 0"
        )
        raise InputError([Problem("--part", record.name, expected)])
    return work


def merge(study: Loaded, out: Path, say: Callable[[str], None] = lambda line: None) -> Outcome:
    """Put the parts of a study together, each of which ran by itself, and store the result.

    `say` is called with each line of the report. `InputError` where cells are missing, or other code wrote a
    journal.
    """
    record, name = study.record, study.record.name
    jobs, before = with_journal_keys(record, _divisible(record))
    keys = {key for job in jobs for key in job.keys}
    with journal_of(out, name).held() as whole:
        _take_parts(whole, out, name, keys, say)
        first = iter([partial(_read, whole, keys, before)])  # what follows from it is computed here
        dataset = computed(record, lambda work: next(first, None) or in_memory(1, work))
        return _stored(study, dataset, whole, keys, out, say)


def part_journals(out: Path, name: str) -> list[Journal]:
    """The journals of a study's parts that are there."""
    return [Journal(folder) for folder in sorted(Path(out).glob(f"{name}.part*of*.journal"))]


def _take_parts(whole: Journal, out: Path, name: str, keys: set[str], say: Callable[[str], None]) -> None:
    """Add the cells with these keys from the journals of parts; refuse where some are in none."""
    left = keys - whole.index().keys()
    others = part_journals(out, name)
    for other in others:
        other.check_code()
        left -= whole.take(other, left)
    for journal in (whole, *others):
        for line in journal.notes(()):
            say(f"journal  {journal.folder.name}: {line}")
    if missing := len(left):
        expected = f"parts with all {len(keys)} cells are needed; {missing} are missing"
        raise InputError([Problem("parts", str(out / f"{name}.part*of*.journal"), expected)])
