"""The verbs of the command line. What is heavy is imported inside them, so that help answers at once."""

import json
import os
import sys
import warnings
from argparse import Namespace
from functools import partial
from pathlib import Path

from jointplay.errors import InputError, Problem
from jointplay.terminal import Progress, one_line

DONE, FAILED = 0, 1  # exit codes
say = partial(print, flush=True)


def run_study(arguments: Namespace) -> int:
    """Compute a study, store the result and draw its figure."""
    from jointplay.jobs.pool import Pool, share_of
    from jointplay.study.execute import complete, resume_hint, writable
    from jointplay.study.standing import refuse_other

    study, share = _loaded(arguments), share_of(arguments.part)
    pool = Pool.checked(arguments.jobs, arguments.backend, arguments.scheduler)
    out = writable(study, arguments.out, share, not arguments.no_figure)
    if not (arguments.fresh or share):
        refuse_other(study.record, out / f"{study.record.name}.nc")
    say(f"{study.record.name}: {study.record.heading}")
    try:
        with Progress(study.record.name) as progress:
            outcome = complete(study, out, pool, progress, fresh=arguments.fresh, share=share, say=say)
    except KeyboardInterrupt:
        raise KeyboardInterrupt(*resume_hint(study, out, share)) from None
    if outcome.dataset is None:
        say(f"part    {outcome.journal}; when all are there: jointplay merge {arguments.study}")
        return DONE
    return _finished(outcome, study.record.figure, arguments.no_figure)


def _finished(outcome, options: dict, no_figure: bool) -> int:
    """Print the files of a stored result, draw its figure, print its answer, and give the exit code."""
    from jointplay.results.outcome import explain, write_table
    from jointplay.results.summary import answer

    dataset, path = outcome.dataset, outcome.path
    say(f"result  {path}")
    for table in write_table(dataset, path.with_suffix(".txt")):
        say(f"table   {table}")
    if "warning" in dataset.attrs:
        print(f"warning {dataset.attrs['warning']}", file=sys.stderr)
    failure = explain(dataset)
    if failure:
        print(f"stopped early; what was computed is stored\n  {failure}", file=sys.stderr)
    options = None if no_figure else _figure_of_run(dataset, options)
    if options is not None:
        try:
            _draw(dataset, options, _targets(None, path))
        except InputError as error:
            if not failure:
                raise
            print(f"  no figure: {error}", file=sys.stderr)  # too little was computed to draw
    for line in answer(dataset):
        say(line)
    return FAILED if failure else DONE


def assess_mechanism(arguments: Namespace) -> int:
    """Assess a linkage with clearance: a page on its forces, its contacts, and where its motion changes."""
    from jointplay.jobs.pool import Pool
    from jointplay.results.answers.assessment import page
    from jointplay.study.execute import complete, resume_hint, writable
    from jointplay.study.file import load_as

    study = load_as("assess", arguments.study, arguments.set)
    for doubt in study.record.doubts():
        print(f"warning {doubt}", file=sys.stderr)
    out = writable(study, arguments.out, drawn=not arguments.no_figure)
    try:
        with Progress(study.record.name) as progress:
            outcome = complete(study, out, Pool.checked(arguments.jobs, "loky", None), progress, say=say)
    except KeyboardInterrupt:
        raise KeyboardInterrupt(*resume_hint(study, out)) from None
    say(page(outcome.dataset, arguments.study))
    return _finished(outcome, study.record.figure, arguments.no_figure)


def _figure_of_run(dataset, options: dict) -> dict | None:
    """Options of the picture that a run draws; None, and a line, where a whole sweep has none."""
    from jointplay import figures

    if "swept" not in dataset.attrs:
        return options
    if (whole := figures.of_sweep(dataset, options)) is None:
        say("figure  none of the whole sweep; one cell: jointplay.figure(jointplay.cell(result, ...))")
    elif not options.get("quantity"):
        shown = figures.drawing.cell_quantity.usual(dataset).name
        say(f"figure  {shown} of each cell; others by kind = 'sweep' and quantity in [figure]")
    return whole


def merge_study(arguments: Namespace) -> int:
    """Put the parts of a study together that `run --part` computed, store the result and draw its figure."""
    from jointplay.study.execute import merge, writable
    from jointplay.study.file import load
    from jointplay.study.standing import refuse_other

    study = load(arguments.study, arguments.set)
    out = writable(study, arguments.out, drawn=not arguments.no_figure)
    refuse_other(study.record, out / f"{study.record.name}.nc")
    outcome = merge(study, out, say)
    return _finished(outcome, study.record.figure, arguments.no_figure)


def plan_study(arguments: Namespace) -> int:
    """Say what a study would compute: how many cells, side by side or not, how long, how much."""
    from jointplay.jobs.pool import check_jobs
    from jointplay.study.plan import plan

    check_jobs(arguments.jobs)
    for line in plan(_loaded(arguments), Path(arguments.out), arguments.jobs):
        say(line)
    return DONE


def show_status(arguments: Namespace) -> int:
    """Say where a study stands: what is finished, what failed, whether it runs, whose result there is."""
    from jointplay.study.file import load
    from jointplay.study.plan import status

    for line in status(load(arguments.study, arguments.set), Path(arguments.out)):
        say(line)
    return DONE


def reproduce_paper(arguments: Namespace) -> int:
    """Compute and draw every figure of the paper, or those named, and grade its conclusions."""
    from jointplay.lab.reproduce import reproduce

    try:
        outcomes = reproduce(arguments.names, arguments.jobs, arguments.out, fresh=arguments.fresh, say=say)
    except KeyboardInterrupt:
        kept = any(Path(arguments.out).glob("*.journal"))
        raise KeyboardInterrupt(*["go on; finished cells are kept"] * kept) from None
    failed = [outcome for outcome in outcomes if outcome.failure]
    print(f"{len(outcomes) - len(failed)} of {len(outcomes)} studies done; results in {arguments.out}")
    for outcome in failed:
        print(f"failed: {outcome.name}: {outcome.failure}", file=sys.stderr)
    return FAILED if failed else DONE


def check_study(arguments: Namespace) -> int:
    """Validate a study file and say what it asks for; compute nothing."""
    print(_loaded(arguments).record.summary())
    return DONE


def _loaded(arguments: Namespace):
    """The study of the arguments; what is probably meant otherwise is said on standard error."""
    from jointplay.study.file import load

    study = load(arguments.study, arguments.set)
    for doubt in study.record.doubts():
        print(f"warning {doubt}", file=sys.stderr)
    return study


def cite_study(arguments: Namespace) -> int:
    """Print references of the mechanism, laws and methods that a study, or the study of a result, uses."""
    from jointplay.study import cite
    from jointplay.study.file import load

    record = load(arguments.study).record
    print(cite.as_bibtex(record) if arguments.bibtex else cite.as_text(record))
    return DONE


def import_linkage(arguments: Namespace) -> int:
    """Write the study file of a linkage that another program stored: pylinkage's JSON, or a table (CSV)."""
    from jointplay.study.import_file import imported

    text, missing = imported(arguments.file, arguments.unit, arguments.bar)
    target = Path(arguments.out) if arguments.out else Path(arguments.file).with_suffix(".toml")
    _write_new(target, text, "--out")
    for key in missing:
        print(f"fill in {key}")
    return DONE


def new_study(arguments: Namespace) -> int:
    """Write a study of one kind to begin with: it runs, and has a comment on every key."""
    from jointplay.study.new import new

    target = Path(arguments.file or f"{arguments.kind}.toml")
    if target.suffix != ".toml":
        raise InputError([Problem("file", str(target), "a name that ends in .toml is accepted")])
    _write_new(target, new(arguments.kind, target.stem, arguments.mechanism), "file")
    return DONE


def _write_new(target: Path, text: str, key: str) -> None:
    """Write a file that is not there yet."""
    from jointplay.results.store import check_writable

    check_writable(target.parent, key, files=[target.name])
    try:
        with target.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError:
        expected = "the name of a file that is not there yet is accepted"
        raise InputError([Problem(key, str(target), expected)]) from None
    print(f"written {target}")


def draw_result(arguments: Namespace) -> int:
    """Draw a stored result again; or the mechanism of a study file."""
    from jointplay.results.store import check_writable, open_result
    from jointplay.study.file import figure_options, mechanism_of

    whole = arguments.kind == "mechanism" or Path(arguments.result).suffix == ".toml"
    dataset = (mechanism_of if whole else open_result)(arguments.result)
    options = figure_options(dataset, arguments.kind, arguments.set)
    if arguments.over:
        options["over"] = open_result(arguments.over)
    targets = _targets(arguments.out, Path(arguments.result))
    check_writable(targets[0].parent, files=[target.name for target in targets])
    _draw(dataset, options, targets)
    return DONE


def _targets(out: str | None, result: Path) -> list[Path]:
    """Files of a figure: the one asked for, or a PDF and a PNG file named after the result."""
    stem = result if out is None else Path(out)
    if stem.name in ("", ".."):
        raise InputError([Problem("--out", out, "the name of a file is accepted")])
    return [stem] if out and stem.suffix else [stem.with_suffix(end) for end in (".pdf", ".png")]


def report_result(arguments: Namespace) -> int:
    """Write a stored result as one HTML page that opens without a network, and a PNG file beside it."""
    from jointplay.pages.report import report
    from jointplay.results.store import open_result

    target = arguments.out or Path(arguments.result).with_suffix(".html")
    for path in report(open_result(arguments.result), target):
        print(f"written {path}")
    return DONE


def export_result(arguments: Namespace) -> int:
    """Write a stored result for other programs: MATLAB (.mat) or a table (.csv)."""
    from jointplay.results.export import export
    from jointplay.results.store import open_result

    target = Path(arguments.result).with_suffix(".mat") if arguments.out is None else arguments.out
    with warnings.catch_warnings(record=True) as doubts:
        print(f"written {export(open_result(arguments.result), target, arguments.over)}")
    for doubt in doubts:
        print(f"warning {doubt.message}", file=sys.stderr)
    return DONE


def list_studies(arguments: Namespace) -> int:
    """List the study files of a folder, and which of them have a result."""
    folder, out = Path(arguments.folder), Path(arguments.out)
    if not os.path.isdir(folder):
        expected = "a folder with study files; there is no such folder"
        raise InputError([Problem("folder", str(folder), expected)])
    rows = [_row(path, out, path.parent.relative_to(folder)) for path in sorted(folder.rglob("*.toml"))]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        print("  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip())
    return DONE


def _row(path: Path, out: Path, inside: Path) -> tuple[str, str, str, str]:
    """File, kind, state of the result, and title of a study, which is validated only where there is one."""
    from jointplay.study.toml_text import parse, read_text

    try:
        table = parse(read_text(path))
    except InputError:
        return str(path), "?", "", "not a readable study file: see `jointplay check`"
    name = str(table.get("name", path.stem))
    results = [at for folder in (out, out / inside) if os.path.isfile(at := folder / f"{name}.nc")]
    kind, title = (one_line(str(table.get(key, default))) for key, default in (("kind", "?"), ("title", "")))
    return str(path), kind, _state(path, results[0]) if results else "", title


def _state(path: Path, result: Path) -> str:
    """State of a study's result in a word or two."""
    from jointplay.study.file import load
    from jointplay.study.standing import standing

    try:
        return standing(load(path).record, result).partition(" (")[0]
    except InputError:
        return "not valid"


def print_schema(arguments: Namespace) -> int:
    """Print the JSON schema of study files, for editors."""
    from jointplay.study.file import schema

    print(json.dumps(schema(), indent=2))
    return DONE


def keep_cache(arguments: Namespace) -> int:
    """List the compiled kernels on the disk, verify those in use, or remove those of older sources."""
    from jointplay.codegen import upkeep

    if arguments.all and arguments.action != "prune":
        raise InputError([Problem("--all", arguments.action, "accepted beside prune only")])
    if arguments.action == "verify":
        sound, removed = upkeep.verify()
        print(f"{sound} files of the kernels in use are sound, {removed} were not and are removed")
        return FAILED if removed else DONE
    if arguments.action == "prune":
        print(f"removed {len(upkeep.prune(arguments.all))} of the cached kernel folders")
    for entry in upkeep.entries():
        print(entry)
    return DONE


def _draw(dataset, options: dict, targets: list[Path]) -> None:
    from jointplay import figures
    from jointplay.results.store import write_figure

    picture = figures.draw(dataset, options)
    picture.set_layout_engine("none")  # it is laid out; each file would take as long again
    for target in targets:
        print(f"figure  {write_figure(picture, target)}")
