"""Compute and draw all studies of the paper in parallel, and print the grades of its conclusions."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from jointplay import figures
from jointplay.display.errors import InputError, Problem, raise_any, strangers
from jointplay.jobs.parallel import BrokenProcessPool, side_by_side
from jointplay.jobs.pool import Pool, check_jobs
from jointplay.kinds import KINDS
from jointplay.study.execute import complete
from jointplay.study.file import load
from jointplay.study.results.outcome import explain, write_table
from jointplay.study.results.store import check_writable, open_result, write_figure
from jointplay.study.run import compile_for
from jointplay.study.toml_text import parse, read_text

FOLDER = Path("studies") / "paper"
DIED = "a worker process died, as when memory runs out; try --jobs 1"


@dataclass(frozen=True)
class Sheet:
    """Studies whose figures are compared: what their figures and the sheet take beside."""

    parts: tuple[str, ...]
    options: dict[str, Any] = field(default_factory=dict)
    layout: dict[str, Any] = field(default_factory=dict)


SHEETS = {
    "fig03": Sheet(("fig03a", "fig03b")),
    "fig05": Sheet(("fig05a", "fig05b")),
    "fig06": Sheet(("fig06a", "fig06b")),
    "fig05_06": Sheet(
        ("fig05a", "fig05b", "fig06a", "fig06b"),
        {"turns": [20, 22], "axis": ["turns", "time"]},
        {"columns": 2},
    ),
    # the vibration of the start, and what damping has left of it
    "fig08_09b": Sheet(("fig08", "fig09b"), layout={"windows": [(0.0, 0.01), (0.01, 0.02)]}),
    "fig12": Sheet(("fig12a", "fig12b", "fig12c")),
}


@dataclass(frozen=True)
class Outcome:
    """Outcome of one study: files written, failure if any, run time in s."""

    name: str
    files: tuple[Path, ...] = ()
    failure: str = ""
    seconds: float = 0.0

    def __str__(self) -> str:
        return (
            f"{self.name:<20} {f'FAILED: {self.failure}' if self.failure else 'done'} ({self.seconds:.1f} s)"
        )


def find_folder(start: Path | None = None) -> Path:
    """Find the paper's studies: below the folder `start` (the current one), or in the package's checkout.

    Raises
    ------
    jointplay.display.errors.InputError
        When there are none: an installed package comes without them.
    """
    start = Path.cwd() if start is None else start
    places = [start / FOLDER, Path(__file__).resolve().parents[2] / FOLDER]
    for place in places:
        if any(place.glob("*.toml")):
            return place
    expected = f"a folder {FOLDER} with study files; run this in a checkout of the project"
    raise InputError([Problem("studies", str(places[0]), f"{expected}: there is none here")])


def choose(folder: Path, names: Sequence[str] = ()) -> list[Path]:
    """Choose study files by name, all of them if none is named; the longest come first.

    Raises
    ------
    jointplay.display.errors.InputError
        Naming every study that there is not.
    """
    known = {path.stem: path for path in sorted(folder.glob("*.toml"))}
    raise_any(strangers((("NAME", name) for name in names), known, "study of the paper"))
    chosen = [known[name] for name in dict.fromkeys(names)] or list(known.values())
    return sorted(chosen, key=_rank)


def _rank(path: Path) -> int:
    """Sort key: studies that take longest come first."""
    try:
        kind = parse(read_text(path)).get("kind")
    except InputError:  # it says so itself when its turn comes
        kind = None
    return -KINDS[kind].slow if kind in list(KINDS) else 0


def reproduce(
    names: Sequence[str] = (),
    jobs: int = 2,
    out: Path | str = "results/reproduced",
    folder: Path | None = None,
    fresh: bool = False,
    say: Callable[[str], None] = lambda line: None,
) -> list[Outcome]:
    """Compute, store and draw studies of the paper in worker processes; finished cells are kept as by `run`.

    Parameters
    ----------
    names : sequence of str
        Names of studies; all if empty.
    jobs : int
        Worker processes.
    out : path-like
        Where results, figures and tables go, and the sheets of figures that are compared.
    folder : path-like, optional
        Where the studies are; found by `find_folder` if left out.
    fresh : bool
        Drop the cells that an earlier run finished.
    say : callable
        Called with a line as each study ends, and with the table of conclusions at the end.

    Returns
    -------
    list of Outcome
        One a study, in the order in which they ended. A study that failed does not stop the others.

    Raises
    ------
    jointplay.display.errors.InputError
        When a name, the number of jobs or a folder is wrong.
    """
    check_jobs(jobs)
    paths = choose(find_folder() if folder is None else Path(folder), names)
    out = check_writable(out, files=[path.stem + each for path in paths for each in (".nc", ".pdf", ".png")])
    alone = jobs == 1 or len(paths) == 1
    _compile(paths)
    outcomes: list[Outcome] = []

    def take(outcome: Outcome) -> None:
        outcomes.append(outcome)
        say(f"{len(outcomes):>3} of {len(paths)}  {outcome}")

    calls = (partial(one_study, path, out, jobs if alone else 1, fresh) for path in paths)
    try:
        side_by_side(calls, take, min(jobs, len(paths)), "here" if alone else "loky")
    except BrokenProcessPool:
        done = {outcome.name for outcome in outcomes}
        outcomes += [Outcome(path.stem, failure=DIED) for path in paths if path.stem not in done]
    anew = [outcome.name for outcome in outcomes if not outcome.failure]
    for sheet in write_sheets(paths[0].parent, Path(out), anew):
        say(f"compared in {sheet}")
    for table in (file for outcome in outcomes for file in outcome.files if file.name == "claims.txt"):
        say("\n" + table.read_text(encoding="utf-8"))
    return outcomes


def _compile(paths: Sequence[Path]) -> None:
    """Compile in this process the code that several studies share."""
    for path in paths:
        with suppress(InputError):  # it says so itself when its turn comes
            compile_for(load(path).record)


def one_study(path: Path, out: Path, jobs: int = 1, fresh: bool = False) -> Outcome:
    """Compute, store and draw one study; any failure is in the outcome."""
    began, files, failure = time.perf_counter(), [], ""
    try:
        study = load(path)
        found = complete(study, out, Pool(jobs), fresh=fresh)
        dataset, name = found.dataset, study.record.name
        failure = explain(dataset) or ""
        files += [found.path, *write_table(dataset, out / f"{name}.txt")]
        picture = figures.draw(dataset, study.record.figure)
        files += [write_figure(picture, out / f"{name}.{ending}") for ending in ("pdf", "png")]
    except InputError as error:
        failure = failure or "; ".join(str(error).splitlines())
    except Exception as error:
        failure = failure or f"{type(error).__name__}: {error}"
    return Outcome(path.stem, tuple(files), failure, time.perf_counter() - began)


def write_sheets(folder: Path, out: Path, anew: Collection[str]) -> list[Path]:
    """Draw the sheets with a result that was computed `anew`, where their other results are stored as well.

    Parameters
    ----------
    folder, out : Path
        Where the studies are, and their results.
    anew : collection of str
        Names of studies.

    Returns
    -------
    list of Path
        The files written.
    """
    files = []
    for name, sheet in SHEETS.items():
        parts = sheet.parts
        there = all((out / f"{part}.nc").exists() and (folder / f"{part}.toml").exists() for part in parts)
        if there and not set(parts).isdisjoint(anew):
            each = [(open_result(out / f"{p}.nc"), load(folder / f"{p}.toml").record.figure) for p in parts]
            drawn = figures.sheet_of([(one, own | sheet.options) for one, own in each], **sheet.layout)
            files += [write_figure(drawn, out / f"{name}.{ending}") for ending in ("pdf", "png")]
    return files
