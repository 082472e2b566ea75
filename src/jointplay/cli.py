"""The command line. What is heavy is imported inside the verbs, so that help answers at once."""

import _thread
import argparse
import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from jointplay.errors import InputError, Problem
from jointplay.terminal import harmless_output

DONE, FAILED, WRONG_INPUT, INTERRUPTED = 0, 1, 2, 130
BACKENDS = ("loky", "threading", "dask")


@harmless_output()
def main(argv: list[str] | None = None) -> int:
    """Run one verb.

    Parameters
    ----------
    argv : list of str, optional
        The words after ``jointplay``; the process's own by default.

    Returns
    -------
    int
        0 done, 1 numerical failure or a result that could not be stored, 2 wrong input, 130 interrupted.
    """
    _open_streams()
    arguments = _parser().parse_args(argv)
    with _interrupts() as pressed:
        try:
            code = arguments.verb(arguments)
            if sys.stdout is not None:
                sys.stdout.flush()  # what cannot be written is told here, and not as Python ends
            return code
        except KeyboardInterrupt as error:
            return _interrupted(*error.args[:1])
        except BrokenPipeError:  # the reader of a pipe has left, such as `| head`
            _drop_output()
            return DONE
        except OSError as error:
            print(f"not done: {error}", file=sys.stderr)
            _drop_output()
            return FAILED
        except InputError as error:
            return _refused(error)
        except MemoryError as error:
            print(f"not enough memory: {error}; ask for fewer turns, samples or cells", file=sys.stderr)
            return FAILED
        except Exception:
            if pressed:  # the compiler turns an interrupt into errors of its own
                return _interrupted()
            raise


def _open_streams() -> None:
    """Have somewhere to write, and no character that cannot be written.

    A stream that the caller has closed would else lend its number to the next file that is opened, for others
    to write into.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest number that is free
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")


def _drop_output() -> None:
    """Leave aside what cannot be written, which Python would try once more as it ends."""
    try:
        sys.stdout.flush()
    except (OSError, AttributeError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _refused(error: InputError) -> int:
    print("wrong input:" if error.count == 1 else f"wrong input, {error.count} problems:", file=sys.stderr)
    print("\n".join(f"  {line}" for line in str(error).splitlines()), file=sys.stderr)
    return WRONG_INPUT


def _interrupted(how: str = "start over") -> int:
    exec("")  # Python ends as if killed when the interrupt came inside another exec: this clears its mark
    print(f"interrupted: run the same command again to {how}", file=sys.stderr)
    return INTERRUPTED


@contextmanager
def _interrupts() -> Iterator[list[bool]]:
    """Note that Ctrl-C was pressed, beside raising KeyboardInterrupt as always.

    What keeps what it has so far (analysis.looks) is asked to end first, and interrupted by a second Ctrl-C.
    """
    pressed: list[bool] = []

    def note(*_: object) -> None:
        pressed.append(True)
        looks = sys.modules.get("jointplay.analysis.looks")
        if looks is None or not looks.stop():
            raise KeyboardInterrupt

    def again(lost) -> None:  # an interrupt that a callback of the compiler could not pass on
        if issubclass(lost.exc_type, KeyboardInterrupt):
            _thread.interrupt_main()
        else:
            sys.__unraisablehook__(lost)

    try:
        before, hook = signal.signal(signal.SIGINT, note), sys.unraisablehook
    except ValueError:  # only a main thread takes signals
        yield pressed
        return
    sys.unraisablehook = again
    try:
        yield pressed
    finally:
        sys.unraisablehook = hook
        signal.signal(signal.SIGINT, before)


def run(arguments: argparse.Namespace) -> int:
    """Compute a study, store the result and draw its figure."""
    from jointplay.jobs.pool import Pool, share_of
    from jointplay.study.execute import complete, going_on, writable
    from jointplay.study.file import load
    from jointplay.study.progress import Progress

    study, share = load(arguments.study, arguments.set), share_of(arguments.part)
    pool = Pool.checked(arguments.jobs, arguments.backend, arguments.scheduler)
    out = writable(study, arguments.out, share, not arguments.no_figure)
    print(f"{study.record.name}: {study.record.heading}", flush=True)
    try:
        with Progress(study.record.name) as progress:
            options = {"fresh": arguments.fresh, "share": share, "say": _say}
            outcome = complete(study, out, pool, progress, **options)
    except KeyboardInterrupt:
        raise KeyboardInterrupt(*going_on(study, out, share)) from None
    if outcome.dataset is None:
        print(f"part    {outcome.journal}; when all are there: jointplay merge {arguments.study}")
        return DONE
    return _finished(outcome, study.record.figure, arguments.no_figure)


def _say(line: str) -> None:
    print(line, flush=True)


def _finished(outcome, options: dict, no_figure: bool) -> int:
    """Tell what came of a run, and draw it."""
    from jointplay.results.outcome import explain, summary, write_table

    dataset, path = outcome.dataset, outcome.path
    print(f"result  {path}", flush=True)
    for table in write_table(dataset, path.with_suffix(".txt")):
        print(f"table   {table}", flush=True)
    if text := summary(dataset):
        _say(text)
    if "warning" in dataset.attrs:
        print(f"warning {dataset.attrs['warning']}", file=sys.stderr)
    failure = explain(dataset)
    if failure:
        print(f"stopped early; what was computed is stored\n  {failure}", file=sys.stderr)
    options = None if no_figure else _pictured(dataset, options)
    if options is not None:
        try:
            _draw(dataset, options, [path.with_suffix(".pdf"), path.with_suffix(".png")])
        except InputError as error:
            if not failure:
                raise
            print(f"  no figure: {error}", file=sys.stderr)  # too little was computed to draw
    return FAILED if failure else DONE


def _pictured(dataset, options: dict) -> dict | None:
    """Options of the picture that a run draws; None, and a line, where a whole sweep has none."""
    from jointplay import figures

    if "swept" not in dataset.attrs:
        return options
    if (whole := figures.of_sweep(dataset, options)) is None:
        _say("figure  none of the whole sweep; one cell: jointplay.figure(jointplay.cell(result, ...))")
    elif not options.get("quantity"):
        shown = figures.drawing.cell_quantity.usual(dataset).name
        _say(f"figure  {shown} of each cell; others by kind = 'sweep' and quantity in [figure]")
    return whole


def merge(arguments: argparse.Namespace) -> int:
    """Put the parts of a study together that `run --part` computed, store the result and draw its figure."""
    from jointplay.study.execute import merge as merge_parts
    from jointplay.study.execute import writable
    from jointplay.study.file import load

    study = load(arguments.study, arguments.set)
    outcome = merge_parts(study, writable(study, arguments.out, drawn=not arguments.no_figure), _say)
    return _finished(outcome, study.record.figure, arguments.no_figure)


def plan(arguments: argparse.Namespace) -> int:
    """Say what a study with cells would compute: how many, side by side or not, how long, how much."""
    from jointplay.jobs.pool import check_jobs
    from jointplay.study.file import load
    from jointplay.study.plan import plan as lines

    check_jobs(arguments.jobs)
    for line in lines(load(arguments.study, arguments.set), Path(arguments.out), arguments.jobs):
        _say(line)
    return DONE


def status(arguments: argparse.Namespace) -> int:
    """Say where a study with cells stands: what is finished, what failed, whether it runs."""
    from jointplay.study.file import load
    from jointplay.study.plan import status as lines

    for line in lines(load(arguments.study, arguments.set), Path(arguments.out)):
        _say(line)
    return DONE


def reproduce(arguments: argparse.Namespace) -> int:
    """Compute and draw every figure of the paper, or those named, and grade its conclusions."""
    from functools import partial

    from jointplay.lab.reproduce import reproduce as reproduce_studies

    say = partial(print, flush=True)
    try:
        outcomes = reproduce_studies(
            arguments.names, arguments.jobs, arguments.out, fresh=arguments.fresh, say=say
        )
    except KeyboardInterrupt:
        kept = any(Path(arguments.out).glob("*.journal"))
        raise KeyboardInterrupt(*["go on; finished cells are kept"] * kept) from None
    failed = [outcome for outcome in outcomes if outcome.failure]
    print(f"{len(outcomes) - len(failed)} of {len(outcomes)} studies done; results in {arguments.out}")
    for outcome in failed:
        print(f"failed: {outcome.name}: {outcome.failure}", file=sys.stderr)
    return FAILED if failed else DONE


def check(arguments: argparse.Namespace) -> int:
    """Validate a study file and say what it asks for; compute nothing."""
    from jointplay.study.file import load

    print(load(arguments.study, arguments.set).record.summary())
    return DONE


def figure(arguments: argparse.Namespace) -> int:
    """Draw a stored result again."""
    from jointplay.results.store import check_writable, open_result
    from jointplay.study.file import figure_options

    dataset = open_result(arguments.result)
    options = figure_options(dataset, arguments.kind, arguments.set)
    if arguments.over:
        options["over"] = open_result(arguments.over)
    targets = _targets(arguments.out, Path(arguments.result))
    check_writable(targets[0].parent, files=[target.name for target in targets])
    _draw(dataset, options, targets)
    return DONE


def _targets(out: str | None, result: Path) -> list[Path]:
    """Files of a picture: as told, or PDF and PNG."""
    stem = result if out is None else Path(out)
    if stem.name in ("", ".."):
        raise InputError([Problem("--out", out, "the name of a file is accepted")])
    return [stem] if out and stem.suffix else [stem.with_suffix(end) for end in (".pdf", ".png")]


def export(arguments: argparse.Namespace) -> int:
    """Write a stored result for other programs: MATLAB (.mat) or a table (.csv)."""
    from jointplay.results.export import export as write
    from jointplay.results.store import open_result

    target = Path(arguments.result).with_suffix(".mat") if arguments.out is None else arguments.out
    print(f"written {write(open_result(arguments.result), target, arguments.over)}")
    return DONE


def list_studies(arguments: argparse.Namespace) -> int:
    """List the study files of a folder, and which of them have a result."""
    from jointplay.study.listing import rows

    for row in rows(arguments.folder, arguments.out):
        print("  ".join(row).rstrip())
    return DONE


def schema(arguments: argparse.Namespace) -> int:
    """Print the JSON schema of study files, for editors."""
    import json

    from jointplay.study.schema import schema as study_schema

    print(json.dumps(study_schema(), indent=2))
    return DONE


def cache(arguments: argparse.Namespace) -> int:
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
    for target in targets:
        print(f"figure  {write_figure(picture, target)}")


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="jointplay", description="Dynamics of linkages with play in their joints."
    )
    parser.add_argument("--version", action=_Version, nargs=0, help="print the version")
    verbs = parser.add_subparsers(title="verbs", required=True, metavar="VERB")

    one = _verb(verbs, "run", run)
    one.add_argument("study", metavar="STUDY.toml")
    one.add_argument("--out", default="results", metavar="DIR", help="where results go (default: results)")
    one.add_argument("--no-figure", action="store_true", help="store the result only")
    _add_jobs(one)
    one.add_argument("--backend", default="loky", choices=BACKENDS, help="processes, threads or a cluster")
    one.add_argument("--scheduler", metavar="ADDRESS", help="of a dask cluster, such as tcp://host:8786")
    one.add_argument("--part", metavar="I/N", help="compute part I of N only, to be put together by merge")
    _add_fresh(one)
    _add_set(one)

    for name, function in (("plan", plan), ("status", status), ("merge", merge)):
        one = _verb(verbs, name, function)
        one.add_argument("study", metavar="STUDY.toml")
        one.add_argument(
            "--out", default="results", metavar="DIR", help="where results go (default: results)"
        )
        if name == "plan":
            _add_jobs(one)
        if name == "merge":
            one.add_argument("--no-figure", action="store_true", help="store the result only")
        _add_set(one)

    one = _verb(verbs, "reproduce", reproduce)
    one.add_argument(
        "names", nargs="*", metavar="NAME", help="studies of studies/paper, such as fig05b; all if none"
    )
    _add_jobs(one)
    one.add_argument(
        "--out", default="results/paper", metavar="DIR", help="where results go (default: results/paper)"
    )
    _add_fresh(one)

    one = _verb(verbs, "check", check)
    one.add_argument("study", metavar="STUDY.toml")
    _add_set(one)

    one = _verb(verbs, "figure", figure)
    one.add_argument("result", metavar="RESULT.nc")
    one.add_argument("--kind", help="another kind of figure than the study asked for")
    one.add_argument("--over", metavar="DIAGRAM.nc", help="draw branches over this bifurcation diagram")
    one.add_argument("--out", metavar="FILE", help="default: PDF and PNG beside the result")
    _add_set(one, "an option of the figure, such as joint=B")

    one = _verb(verbs, "export", export)
    one.add_argument("result", metavar="RESULT.nc")
    one.add_argument("--out", metavar="FILE", help="ends in .mat or .csv (default: .mat beside the result)")
    one.add_argument("--over", nargs="+", metavar="DIM", help="dimensions of a table's rows, such as time")

    one = _verb(verbs, "list", list_studies)
    one.add_argument("folder", nargs="?", default="studies", metavar="DIR")
    one.add_argument("--out", default="results", metavar="DIR", help="where results are (default: results)")

    _verb(verbs, "schema", schema)
    one = _verb(verbs, "cache", cache)
    one.add_argument("action", nargs="?", choices=["list", "prune", "verify"], default="list")
    one.add_argument("--all", action="store_true", help="prune: remove the kernels in use as well")
    return parser


def _verb(verbs, name: str, function) -> argparse.ArgumentParser:
    text = function.__doc__
    parser = verbs.add_parser(name, help=text[0].lower() + text[1:].rstrip("."), description=text)
    parser.set_defaults(verb=function)
    return parser


def _add_jobs(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--jobs", type=int, default=2, metavar="N", help="worker processes (default: 2)")


def _add_fresh(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--fresh", action="store_true", help="drop the cells that an earlier run finished")


def _add_set(
    parser: argparse.ArgumentParser,
    text: str = "change one value of the study, such as mechanism.clearance=1e-4",
):
    # `extend` lets one --set take several changes, and be given again
    parser.add_argument("--set", nargs="+", action="extend", default=[], metavar="KEY=VALUE", help=text)


class _Version(argparse.Action):
    """Look the version up only when it is asked for."""

    def __call__(self, parser, *_):
        from importlib.metadata import version

        parser.exit(message=f"jointplay {version('jointplay')}\n")
