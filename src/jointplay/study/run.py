"""Run a study: from its record to a dataset that knows where it comes from."""

import warnings
from collections.abc import Callable, Iterable, Mapping
from functools import partial

import xarray as xr

from jointplay.analysis.cells import Read, Steps, Work, driven, in_memory
from jointplay.analysis.sweeps import gather
from jointplay.analysis.vary import changed
from jointplay.errors import InputError, ModelWarning, Problem
from jointplay.jobs.job import Entry
from jointplay.jobs.pool import check_jobs
from jointplay.kinds import Kind
from jointplay.numerics.codes import Status
from jointplay.results import provenance
from jointplay.study.file import Loaded
from jointplay.study.keys import varied
from jointplay.study.models import Study, SweepStudy


def function_of(row: Kind) -> Callable[..., xr.Dataset]:
    """The analysis function of a kind of study."""
    return row.function


def run(
    study: Loaded, progress: Callable[[float], None] | None = None, jobs: int | None = None
) -> xr.Dataset:
    """Compute what a study asks for, and keep nothing of it on the disk.

    Parameters
    ----------
    study : Loaded
        From `jointplay.study.file.load`.
    progress : callable, optional
        Called with the fraction done, 0 to 1.
    jobs : int, optional
        Worker processes, for studies that have cells.

    Returns
    -------
    xarray.Dataset
        With the attributes ``study`` (its name), ``title``, ``source`` and ``provenance``. A numerical
        failure is in its ``status``.

    Raises
    ------
    jointplay.errors.InputError
        When the number of jobs is wrong.
    """
    check_jobs(jobs)
    return named(study, computed(study.record, partial(in_memory, jobs), progress))


def computed(
    record: Study, run_work: Callable[[Work], Read], progress: Callable[[float], None] | None = None
) -> xr.Dataset:
    """Compute what a study asks for; `run_work` runs the cells that are handed out."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ModelWarning)  # the result says it too, and the command repeats that
        if (steps := _steps(record)) is not None:
            return driven(steps, run_work, progress=progress)
        return function_of(record.row)(record.mechanism, **record.keywords(), progress=progress)


def _steps(record: Study) -> Callable[..., Steps] | None:
    """What hands out the cells of a study; None where there is no such thing."""
    if record.vary and not isinstance(record, SweepStudy):
        return partial(varied, record, answer)
    steps = getattr(function_of(record.row), "steps", None)
    return None if steps is None else partial(steps, record.mechanism, **record.keywords())


def answer(record: Study, changes: Mapping[str, float]) -> Entry:
    """What a study of one analysis gives with a changed mechanism: a cell of a `[vary]`."""
    one = record.model_copy(update={"mechanism": changed(record.mechanism, changes)})
    dataset = computed(one, partial(in_memory, 1))
    status, warned = Status(int(dataset.variables["status"])), dataset.attrs.pop("warning", "")
    trouble = status.meaning if status else warned
    return {"status": int(status), "trouble": trouble, "dataset": gather.plain(dataset)}


def hands_out(record: Study) -> bool:
    """Whether a study hands out cells, each of which is kept when it is finished.

    What can do without a plane of starts has cells only where there is one.
    """
    plane = getattr(record.analysis, "plane", ())
    return record.has_cells or (_steps(record) is not None and plane is not None)


def first_work(record: Study) -> Work:
    """What a study hands out first.

    Raises
    ------
    InputError
        When it hands out nothing.
    """
    if not hands_out(record):
        expected = (
            "a study with cells is accepted: with [vary], over a plane of starts, or of the paper as a whole"
        )
        raise InputError([Problem("study", record.name, f"{expected}; this is one analysis")])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ModelWarning)
        return next(_steps(record)())


def named(study: Loaded, dataset: xr.Dataset, processors: Iterable[str] = ()) -> xr.Dataset:
    """Give a copy that says which study it answers, and where it comes from, by which kinds of processors."""
    record = study.record
    titled = dataset.assign_attrs(study=record.name, title=record.heading)
    return provenance.attach(titled, record.model_dump(mode="json"), study.text, processors)
