"""Run a study: divide it into cells, and make a dataset of them that knows where it comes from.

A cell of a `[vary]` is the analysis of its kind by itself, on a changed mechanism. Its key is the hash of all
that decides its answer. The cells of one analysis belong to all of the study's settings: such a key says in
hexadecimal digits the hash of the study, which work of the analysis it belongs to, the cell's number, and how
many there are; so a journal tells how much of a study is finished.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from inspect import signature

from jointplay.analysis import cells
from jointplay.analysis.cells import DIGITS, Batch, Cell, Read, Show, Work, answered, driven, in_memory, warm
from jointplay.analysis.exponents.frame_growth import Stretch, followed_together
from jointplay.analysis.labels import xr
from jointplay.analysis.rules import quantity
from jointplay.analysis.sweeps import gather
from jointplay.analysis.sweeps.chains import TOGETHER, groups
from jointplay.analysis.tangents import warm_tangents
from jointplay.analysis.vary import largest
from jointplay.display.errors import InputError, ModelWarning, Problem
from jointplay.jobs.job import KEY, Entry, Job, key_of
from jointplay.jobs.pool import check_jobs
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.method.codes import Status
from jointplay.solver.motion.ensemble_runs import in_lanes
from jointplay.solver.motion.progress import reported
from jointplay.solver.motion.trajectory import Request
from jointplay.study.file import Loaded
from jointplay.study.models import Study, SweepStudy
from jointplay.study.results import provenance
from jointplay.study.vary_table import points

SAMPLED = 32  # cells whose mechanisms are assembled to find the structures to compile
WORK = 2  # digits that number the works of an analysis
HASH = KEY - WORK - 2 * DIGITS


def run(
    study: Loaded, progress: Callable[[float], None] | None = None, jobs: int | None = None
) -> xr.Dataset:
    """Compute a study, and keep nothing of it on the disk.

    Parameters
    ----------
    study : Loaded
        From `jointplay.study.file.load`.
    progress : callable, optional
        Called with the fraction done, 0 to 1.
    jobs : int, optional
        Worker processes, for studies that have cells; `InputError` where the number is wrong.

    Returns
    -------
    xarray.Dataset
        With the attributes ``study`` (its name), ``title``, ``source`` and ``provenance``. A numerical
        failure is in its ``status``.
    """
    check_jobs(jobs)
    return with_provenance(study, computed(study.record, partial(in_memory, jobs), progress))


def computed(
    record: Study,
    run_work: Callable[[Work], Read],
    progress: Callable[[float], None] | None = None,
    show: Show | None = None,
) -> xr.Dataset:
    """Dataset of a study without provenance; `run_work` runs its cells, `show` is as in `driven`."""
    # the result says it too, and the command repeats that
    with warnings.catch_warnings(action="ignore", category=ModelWarning):
        return driven(partial(_analysis(record), progress=progress), run_work, show)


def _analysis(record: Study) -> Callable[..., xr.Dataset]:
    """The analysis of a study, of which `progress` is left open."""
    if _varies(record):
        return partial(_varied, record)
    _, answer = record.checked
    return answer


def _varies(record: Study) -> bool:
    """Whether the cells of a study are of a `[vary]`, and not its analysis's own."""
    return bool(record.vary) and not isinstance(record, SweepStudy)


def has_cells(record: Study) -> bool:
    """Whether a study is divided into cells, each of which is kept when it is finished."""
    inside = "n_jobs" in signature(record.row.function).parameters
    return _varies(record) or (inside and getattr(record.analysis, "plane", ()) is not None)


def grows(record: Study) -> bool:
    """Whether later cells of a study follow from the answers of its first ones."""
    return not _varies(record) and getattr(record.row.function, "growing", False)


def first_work(record: Study) -> Work:
    """The first cells that a study hands out; `InputError` where it has none."""
    with warnings.catch_warnings(action="ignore", category=ModelWarning):
        work = cells.first_work(_analysis(record)) if has_cells(record) else None
    if work is None:
        expected = "a study with cells is accepted, such as one with [vary] or over a plane of starts"
        raise InputError([Problem("study", record.name, f"{expected}; this one is a single analysis")])
    return work


@reported
def _varied(record: Study, *, progress: Callable[[float], None] | None = None) -> xr.Dataset:
    """Hand out the cells of a `[vary]`, and stack their datasets."""
    grid, single = points(record.mechanism, record.vary), record.model_copy(update={"vary": {}, "figure": {}})
    together = _together(record, grid.changes)
    keys = [_key(record, change, together) for change in grid.changes]
    each = [
        Cell(answer, {"record": single, "changes": change}, key)
        for change, key in zip(grid.changes, keys, strict=True)
    ]
    size = -(-len(each) // groups(len(each), TOGETHER)) if together else 1
    jobs = [Batch(tuple(each[at : at + size])) for at in range(0, len(each), size)] if together else each
    shape = dict(zip(grid.dims, grid.shape, strict=True))
    read = answered(Work(jobs, shape, progress, partial(compile_for, record, grid.changes, together)))
    return gather.dataset(record.kind, grid, keys, read)


def _together(record: Study, changes: Sequence[Mapping[str, float]]) -> bool:
    """Whether the cells of a `[vary]` go side by side, in lanes."""
    given, function = record.keywords(), record.row.function
    wanted, known = getattr(function, "batchable", None), signature(function).parameters
    if wanted is None or any(given.get(key, known[key].default) != value for key, value in wanted.items()):
        return False
    over = {key: [change[key] for change in changes] for key in changes[0]}
    rtol = given.get("rtol", known["rtol"].default)
    return in_lanes(given.get("ensemble"), largest(record.mechanism, over), rtol, len(changes))


def _key(record: Study, change: Mapping[str, float], together: bool) -> str:
    settings = (record.kind, record.integrator, record.analysis, *["in lanes"] * together)
    try:
        return key_of(*settings, record.mechanism.known_by(change))
    except InputError:  # the cell will say so
        return key_of(*settings, record.mechanism, change)


def answer(record: Study, changes: Mapping[str, float]) -> Entry:
    """Answer of a cell of a `[vary]`: the study of one analysis with a changed mechanism."""
    single = record.model_copy(update={"mechanism": record.mechanism.varied(changes)})
    dataset = computed(single, partial(in_memory, 1))
    status, warning = Status(int(dataset.variables["status"])), dataset.attrs.pop("warning", "")
    dataset.attrs.pop("mechanism", None)  # each cell has its own, which the sweep's study tells
    trouble = dataset.attrs.pop("trouble", status.meaning) if status else warning
    return {"status": int(status), "trouble": trouble, "dataset": gather.plain(dataset)}


def compile_for(
    record: Study, changes: Sequence[Mapping[str, float]] = ({},), together: bool = False
) -> None:
    """Compile the code that a study with these changes needs, so that workers find it on the disk."""
    for change in (*changes[:: max(1, len(changes) // SAMPLED)], changes[-1]):
        try:
            mechanism = record.mechanism.varied(change)
            section = getattr(record.analysis, "section", None)
            model = assemble(mechanism, None, quantity(section, mechanism))
        except InputError:
            continue
        brief = Request(1e-9 * model.period, max_steps=1)
        if together:
            followed_together([(model, Stretch(brief, 1, 0.0) if record.row.tangents else brief)])
            continue
        warm([model])
        if record.row.tangents:
            warm_tangents(model)


def study_hash(record: Study) -> str:
    """The beginning of the keys of all cells that one analysis hands out by number."""
    settings = record.analysis.model_dump_json(exclude=record.bounds)
    return key_of(record.kind, record.integrator, settings, record.mechanism)[:HASH]


def with_journal_keys(record: Study, work: Work, number: int = 0) -> tuple[list[Job], int]:
    """The jobs of an analysis's work under the keys of a journal, and the length of the prefix added."""
    if not work.numbered:
        return list(work.jobs), 0
    begin = f"{study_hash(record)}{number:0{WORK}x}"
    return [replace(cell, key=begin + cell.key) for cell in work.jobs], len(begin)


def count_by_keys(keys: Iterable[str]) -> int:
    """Number of cells in the works to which these keys belong, as the keys say; 0 where there is no key."""
    return sum({key[HASH : HASH + WORK]: int(key[-DIGITS:], 16) for key in keys}.values())


def with_title(study: Loaded, dataset: xr.Dataset) -> xr.Dataset:
    """A copy that says which study it answers."""
    return dataset.assign_attrs(study=study.record.name, title=study.record.heading)


def with_provenance(study: Loaded, dataset: xr.Dataset, processors: Iterable[str] = ()) -> xr.Dataset:
    """A copy that says which study it answers, where it comes from, and which kinds of processors ran it."""
    record, titled = study.record, with_title(study, dataset)
    if doubts := record.doubts():
        titled = titled.assign_attrs(doubts="\n".join(doubts))
    return provenance.attach(titled, record.model_dump(mode="json"), study.text, processors)
