"""Analyses that divide their work: they hand out cells, and make their dataset of the answers.

Where it needs answers, such an analysis calls `handed_out`, or `answered` with `Work` of its own. The work is
done by whoever drives the analysis (`driven`), as a study that keeps what is finished; where nobody does, by
this process and its workers.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from contextlib import nullcontext
from contextvars import ContextVar
from dataclasses import dataclass
from functools import partial
from itertools import zip_longest
from tempfile import TemporaryDirectory
from typing import Any, ClassVar, TypeVar

from jointplay.analysis.exponents.frame_growth import followed_together
from jointplay.display.errors import InputError
from jointplay.display.terminal import held
from jointplay.jobs.job import CRASHED, Entry, Job, Kept, Notes, key_of, remaining
from jointplay.jobs.journal import Journal
from jointplay.jobs.worker import in_tasks
from jointplay.solver.mechanism.model import Model
from jointplay.solver.method.codes import Status
from jointplay.solver.motion.eligibility import batch
from jointplay.solver.motion.ensemble_runs import follow_ensemble
from jointplay.solver.motion.progress import from_progress, heard, tick
from jointplay.solver.motion.trajectory import Request, follow

T = TypeVar("T")
F = TypeVar("F", bound=Callable[..., Any])
JOBS = 2
DIGITS = 7  # of a number in the key of a numbered cell
Read = Callable[[], Iterable[tuple[str, Entry]]]  # goes through the answers by their keys, in any order


@dataclass(frozen=True)
class Work:
    """Work that an analysis hands out.

    Parameters
    ----------
    jobs : sequence of Job
        To be run in any order.
    shape : dict of str to int
        Numbers of cells along each dimension.
    progress : callable, optional
        To be called with the fraction done.
    warm : callable
        Compiles the functions that cells need, so that other processes find them on the disk.
    numbered : bool
        Whether keys are numbers of cells, which are unique only within a study.
    possible : sequence of str
        Keys of all cells that may be handed out, where these and later ones depend on answers; else empty.
    """

    jobs: Sequence[Job]
    shape: dict[str, int]
    progress: Callable[[float], None] | None = None
    warm: Callable[[], None] = lambda: None
    numbered: bool = False
    possible: Sequence[str] = ()


Show = Callable[[Any, int], None]  # takes a dataset of which the part of a number is final


_run: ContextVar[Callable[[Work], Read] | None] = ContextVar("run", default=None)


_show: ContextVar[Show | None] = ContextVar("show", default=None)


@dataclass(frozen=True)
class Cell:
    """A job of one cell: a call of a function that workers import by name."""

    function: Callable[..., Entry]
    keywords: dict[str, Any]
    key: str
    chains: ClassVar[tuple] = ()

    @property
    def keys(self) -> tuple[str, ...]:
        """The key, as the only one."""
        return (self.key,)

    def run(self, notes: Notes) -> None:
        """Call the function; an error is an answer too."""
        notes.begin(self.key)
        notes.put(self.key, guarded(self.function, self.keywords))

    def only(self, _: str) -> Cell:
        """The cell itself: it is the only one."""
        return self

    def sample(self) -> Cell:
        """The cell itself."""
        return self

    def left(self, done: Container[str], _: Mapping[str, Entry]) -> Cell | None:
        """The cell itself, if it is not finished."""
        return None if self.key in done else self


@dataclass(frozen=True)
class Batch:
    """A job of several that run side by side, as if each were alone: their motions share lanes."""

    own: tuple[Any, ...]

    @property
    def keys(self) -> tuple[str, ...]:
        """Keys of all cells: the first of each job, then the second, …"""
        rows = zip_longest(*(job.keys for job in self.own))
        return tuple(key for row in rows for key in row if key is not None)

    @property
    def chains(self) -> tuple[tuple[str, ...], ...]:
        """Keys of each chain."""
        return tuple(chain for job in self.own for chain in job.chains)

    def run(self, notes: Notes) -> None:
        """Call the functions of all cells; an error is an answer too."""
        notes.begin(self.keys[0])
        calls = [partial(guarded, cell.function, cell.keywords) for cell in self.own]
        with warnings.catch_warnings():  # what each sets for itself may end in another order
            answers = batch(calls, followed_together)
        for key, answer in zip(self.keys, answers, strict=True):
            notes.put(key, answer)

    def only(self, key: str) -> Batch:
        """Give the job of a cell, up to that."""
        return type(self)(tuple(job.only(key) for job in self.own if key in job.keys))

    def sample(self) -> Batch:
        """Give the first of each job: the cost is that of cells side by side."""
        return type(self)(tuple(job.sample() for job in self.own))

    def left(self, done: Container[str], answers: Mapping[str, Entry]) -> Batch | None:
        """Give the unfinished jobs; None if all are finished."""
        rest = tuple(remaining(self.own, done, answers))
        return type(self)(rest) if rest else None


def handed_out(
    function: Callable[..., Entry],
    cells: Sequence[dict[str, Any]],
    progress: Callable[[float], None] | None = None,
    n_jobs: int | None = None,
    *,
    lasting: str = "",
    ready: Callable[[], None] = lambda: None,
    before: int = 0,
    possible: int = 0,
) -> list[Entry]:
    """Hand out a call of a function for each cell, by the call's keywords.

    The function gives back a dict with the key ``status``; workers, which are processes, import it by name.
    Cells are known by their numbers, after so many `before`; those that are to last when others are added, by
    all that decides their answers, and `lasting` says what they are. `ready` compiles what they need. Where
    answers decide which cells follow, so many are `possible`. `n_jobs` is as in `answered`.

    Returns
    -------
    list of dict
        In the order of the cells. A cell that raised has only a ``status`` (``bad_parameters`` where its
        input was refused, ``crashed`` else) and ``trouble``, the error's text.
    """
    last = before + len(cells)
    keys = [f"{i:0{DIGITS}x}{last:0{DIGITS}x}" for i in range(before, last)]
    if lasting:
        keys = [key_of(function.__name__, cell) for cell in cells]
    made = [Cell(function, each, key) for each, key in zip(cells, keys, strict=True)]
    shape = {lasting or "inside one analysis": len(cells)}
    more = [f"{i:0{2 * DIGITS}x}" for i in range(possible)]
    answers = dict(answered(Work(made, shape, progress, ready, not lasting, more), n_jobs)())
    return [answers[key] for key in keys]


def first_bad(answers: Iterable[Mapping[str, Any]]) -> int:
    """The first status of several answers that is not ok; 0 where all are."""
    return next((int(each["status"]) for each in answers if each.get("status")), 0)


def answered(work: Work, n_jobs: int | None = None) -> Read:
    """Have work done by whoever drives the analysis; where nobody does, in memory by `n_jobs` processes."""
    run = _run.get()
    return in_memory(n_jobs, work) if run is None else driven(partial(run, work), None)


def driven(call: Callable[[], T], run: Callable[[Work], Read] | None, show: Show | None = None) -> T:
    """Call an analysis whose work is done by `run`; that of analyses in its cells is none of it.

    `show` is called with parts of the answer as they become final, where an analysis has such (`shown`).
    """
    with held(_run, run), held(_show, show):
        return call()


def shown(dataset: Callable[[], Any], part: int) -> None:
    """Show the part of this number of an answer that is made so far; once more where it has changed."""
    if (show := _show.get()) is not None:
        show(dataset(), part)


class _HandedOut(BaseException):
    """Ends an analysis of which only the first work is wanted."""


def first_work(call: Callable[[], Any]) -> Work | None:
    """The first work of an analysis, which goes no further; None where it has none."""

    def taken(work: Work) -> Read:
        raise _HandedOut(work)

    try:
        driven(call, taken)
    except _HandedOut as end:
        return end.args[0]
    return None


def growing(analysis: F) -> F:
    """Mark an analysis whose later cells follow from the answers of its first ones."""
    analysis.growing = True  # type: ignore[attr-defined]
    return analysis


def in_memory(n_jobs: int | None, work: Work) -> Read:
    """Do work with `n_jobs` processes, `JOBS` if None, and keep the answers in memory."""
    total, report = sum(len(job.keys) for job in work.jobs), work.progress or (lambda _: None)

    def tell(begun: float = 0.0) -> None:
        """Report the finished cells, and the others by the parts that are done."""
        report(min(1.0, (len(kept.answers) + begun) / total))

    kept = Kept(lambda _: tell())
    workers = min(JOBS if n_jobs is None else n_jobs, len(work.jobs))
    if workers <= 1:
        with heard(lambda done, _: tell(done)) if work.progress else nullcontext():
            for job in work.jobs:
                job.run(kept)
        return kept.answers.items
    work.warm()
    with TemporaryDirectory(ignore_cleanup_errors=True) as marks:

        def look() -> None:
            tick()
            tell(sum(done for done, _ in Journal(marks).places()))

        in_tasks(work.jobs, workers, take=lambda done: kept.add(done.answers), tick=look, marks=marks)
    return kept.answers.items


def guarded(function: Callable[..., Entry], cell: dict[str, Any]) -> Entry:
    """Call a function with a cell's keywords; an error becomes a ``status`` with ``trouble``, its text."""
    try:
        return function(**cell)
    except InputError as error:
        return {"status": int(Status.BAD_PARAMETERS), "trouble": str(error)}
    except Exception as error:
        if from_progress(error):
            raise
        return {"status": CRASHED, "trouble": f"{type(error).__name__}: {error}"}


def warm(models: Iterable[Model], ensemble: bool = False) -> None:
    """Compile the functions of models, once a structure, so that workers find them on the disk."""
    for model in {model.structure: model for model in models}.values():
        brief = Request(duration=1e-9 * model.period, max_steps=1)
        if ensemble:
            follow_ensemble([model], [brief])
        else:
            follow(model, brief)
