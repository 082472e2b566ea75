"""Verbs that compute studies. Heavy modules are imported inside them, so that help answers at once."""

import sys
from argparse import Namespace
from functools import partial
from pathlib import Path

from jointplay.cli.results import draw, targets
from jointplay.cli.verb import (
    CHANGE,
    DONE,
    FAILED,
    FRESH,
    JOBS,
    NO_FIGURE,
    OUT,
    STUDY,
    changes,
    option,
    say,
    verb,
)
from jointplay.display.errors import InputError
from jointplay.display.terminal import Progress

BACKENDS = ("loky", "threading", "dask")
LINKAGE = option("study", metavar="STUDY.toml", help="a study of any kind, or a table [mechanism] alone")
SWEEP = "studies/bifurcation/bifurcation_clearance.toml"


@verb(
    "run",
    *(STUDY, OUT, NO_FIGURE, JOBS),
    option("--backend", default="loky", choices=BACKENDS, help="processes, threads or a cluster"),
    option("--scheduler", metavar="ADDRESS", help="of a dask cluster, such as tcp://host:8786"),
    option("--part", metavar="I/N", help="compute part I of N only, to be put together by merge"),
    *(FRESH, CHANGE),
    example="studies/quickstart.toml --set mechanism.clearance=1e-4 --out other",
)
def run_study(arguments: Namespace) -> int:
    """Compute a study, store the result and draw its figure."""
    from jointplay.jobs.pool import Pool, share_of

    study, share = loaded(arguments), share_of(arguments.part)
    pool = Pool.checked(arguments.jobs, arguments.backend, arguments.scheduler)
    out = _free(study, arguments, share, arguments.fresh)
    say(f"{study.record.name}: {study.record.heading}")
    outcome = _completed(study, out, pool, share, arguments.fresh)
    if outcome.dataset is None:
        say(f"part    {outcome.journal}; when all are there: jointplay merge {arguments.study}")
        return DONE
    return _finished(outcome, study.record.figure, arguments.no_figure)


def _free(study, arguments: Namespace, share=None, fresh: bool = False) -> Path:
    """Give the folder for results, where the study can be written and no other study's result is lost."""
    from jointplay.study.execute import writable
    from jointplay.study.result_state import refuse_other

    out = writable(study, arguments.out, share, not arguments.no_figure)
    if not (fresh or share):
        refuse_other(study.record, out / f"{study.record.name}.nc")
    return out


def _completed(study, out: Path, pool, share=None, fresh: bool = False, note=say, text=None):
    """Compute a study with a bar of its progress; an interruption prints the way to go on.

    `note` takes lines of the report; `text` makes one of a part of the answer, printed when it is known.
    """
    from jointplay.study.execute import Undrawn, complete, resume_hint

    try:
        with Progress(study.record.name) as progress:
            show = text and partial(_print_part, text, progress, {})
            return complete(study, out, pool, progress, fresh=fresh, share=share, say=note, show=show)
    except Undrawn:
        raise
    except KeyboardInterrupt:
        raise KeyboardInterrupt(*resume_hint(study, out, share)) from None


def _print_part(text, progress: Progress, printed: dict[int, str], dataset, number: int) -> None:
    """Print a part of an answer above the bar, unless it stands there already."""
    if printed.get(number) != (made := text(dataset, number)):
        with progress.aside():
            say(made)
    printed[number] = made


def _finished(outcome, options: dict, no_figure: bool, table=None) -> int:
    """Print the files of a stored result, draw its figure, print its answer, and give the exit code."""
    from jointplay.study.execute import Undrawn
    from jointplay.study.results.outcome import explain, write_table
    from jointplay.study.results.summary import answer

    dataset, path = outcome.dataset, outcome.path
    say(f"result  {path}")
    for file in write_table(dataset, path.with_suffix(".txt"), table):
        say(f"table   {file}")
    if "warning" in dataset.attrs:
        print(f"warning {dataset.attrs['warning']}", file=sys.stderr)
    failure = explain(dataset)
    if failure:
        print(f"stopped early; what was computed is stored\n  {failure}", file=sys.stderr)
    options = None if no_figure else _figure_of_run(dataset, options)
    if options is not None:
        try:
            draw(dataset, options, targets(None, path))
        except KeyboardInterrupt:
            raise Undrawn(path) from None
        except InputError as error:
            if not failure:
                raise
            print(f"  no figure: {error}", file=sys.stderr)  # too little was computed to draw
    for line in answer(dataset):
        say(line)
    return FAILED if failure else DONE


@verb(
    "assess",
    *(LINKAGE, OUT, NO_FIGURE, JOBS, FRESH),
    changes("change one value, such as mechanism.clearance=1e-4 or analysis.reach=3"),
    example="studies/quickstart.toml --set analysis.reach=1.5",
)
def assess_mechanism(arguments: Namespace) -> int:
    """Assess a linkage with clearance: a page on its forces, its contacts, and where its motion changes."""
    from jointplay.analysis.assessment.page import page, part

    whole, each = (partial(text, source=arguments.study) for text in (page, part))
    return _of_mechanism(arguments, "assess", each, whole)


@verb(
    "tolerances",
    *(LINKAGE, OUT, NO_FIGURE, JOBS, FRESH),
    changes("change one value, such as analysis.samples=10000"),
    example="studies/assess/slider_crank_tolerances.toml --set analysis.samples=64",
)
def share_of_mechanisms(arguments: Namespace) -> int:
    """Tell how many made by one drawing lose contact or exceed limits, by the file's table [tolerances]."""
    return _of_mechanism(arguments, "tolerances")


def _of_mechanism(arguments: Namespace, kind: str, text=None, table=None) -> int:
    """Run a study of one kind on the mechanism of a file, of whatever kind that is; texts name the file."""
    from jointplay.jobs.pool import Pool
    from jointplay.study.file import load

    study = _doubted(load(arguments.study, arguments.set, kind=kind))
    out = _free(study, arguments, fresh=arguments.fresh)
    pool, notes = Pool.checked(arguments.jobs, "loky", None), list[str]()
    outcome = _completed(study, out, pool, fresh=arguments.fresh, note=notes.append, text=text)
    for line in notes:
        say(line)
    return _finished(outcome, study.record.figure, arguments.no_figure, table)


def _figure_of_run(dataset, options: dict) -> dict | None:
    """Options of the picture that a run draws; None, and a line, where a whole sweep has none."""
    from jointplay import figures

    if "swept" not in dataset.attrs:
        return options
    if (whole := figures.of_sweep(dataset, options)) is None:
        one = "jointplay.figure(jointplay.cell(result, ...))"
        say(f"figure  there is none of the whole sweep; of one cell: {one}")
    elif not options.get("quantity"):
        shown = figures.drawing.cell_quantity.usual(dataset)
        say(f"figure  {shown} of each cell; kind = 'sweep' and quantity in [figure] choose another")
    return whole


@verb("merge", STUDY, OUT, NO_FIGURE, CHANGE, example=f"{SWEEP} --out shared")
def merge_study(arguments: Namespace) -> int:
    """Put the parts of a study together that `run --part` computed, store the result and draw its figure."""
    from jointplay.study.execute import merge
    from jointplay.study.file import load

    study = load(arguments.study, arguments.set)
    return _finished(merge(study, _free(study, arguments), say), study.record.figure, arguments.no_figure)


@verb("plan", STUDY, OUT, JOBS, CHANGE, example=f"{SWEEP} --jobs 8")
def plan_study(arguments: Namespace) -> int:
    """Estimate a study without running it: number of cells, parallel work, duration, size of the result."""
    from jointplay.jobs.pool import check_jobs
    from jointplay.study.plan import plan

    check_jobs(arguments.jobs)
    for line in plan(loaded(arguments), Path(arguments.out), arguments.jobs):
        say(line)
    return DONE


@verb("status", STUDY, OUT, CHANGE, example=SWEEP)
def show_status(arguments: Namespace) -> int:
    """Show the state of a study: finished and failed cells, whether it runs, and the stored result."""
    from jointplay.study.file import load
    from jointplay.study.plan import status
    from jointplay.study.toml_text import kinds_there

    path, out = Path(arguments.study), Path(arguments.out)
    for kind in kinds_there(path, out, arguments.set) or [None]:
        for line in status(load(path, arguments.set, kind), out):
            say(line)
    return DONE


def loaded(arguments: Namespace):
    """Load the study of the arguments; print doubts about it on standard error."""
    from jointplay.study.file import load

    return _doubted(load(arguments.study, arguments.set))


def _doubted(study):
    """Print doubts about a study on standard error, and give it back."""
    for doubt in study.record.doubts():
        print(f"warning {doubt}", file=sys.stderr)
    return study
