"""Verbs that compute nothing: study files, references, the cache. Heavy modules are imported inside them."""

import json
import os
from argparse import Namespace
from collections.abc import Iterator
from pathlib import Path

from jointplay.cli.studies import loaded
from jointplay.cli.verb import CHANGE, DONE, FAILED, STUDY, folder, option, verb
from jointplay.display.errors import InputError, Problem
from jointplay.display.terminal import one_line
from jointplay.kinds import KINDS

STUDIES, UNKNOWN = "studies", "?"


@verb(
    "new",
    option("kind", metavar="KIND", help=", ".join(KINDS)),
    option("file", nargs="?", metavar="NAME.toml", help="default: KIND.toml"),
    option("--mechanism", metavar="NAME", help="write a linkage out, such as four_bar or slider_crank"),
    example="response own.toml --mechanism four_bar",
)
def new_study(arguments: Namespace) -> int:
    """Write a study of one kind to begin with: it runs, and has a comment on every key."""
    from jointplay.study.new import new

    kind, file = arguments.kind, arguments.file
    if file and Path(kind).suffix == ".toml":
        kind, file = file, kind
    target = Path(file or f"{kind}.toml")
    if target.suffix != ".toml":
        raise InputError([Problem("file", str(target), "a name that ends in .toml is accepted")])
    _write_new(target, new(kind, target.stem, arguments.mechanism), "file")
    return DONE


@verb("check", STUDY, CHANGE, example="studies/quickstart.toml")
def check_study(arguments: Namespace) -> int:
    """Validate a study file and summarise it; compute nothing."""
    print(loaded(arguments).record.summary())
    return DONE


@verb(
    "list",
    option("folder", nargs="?", metavar="DIR", help="default: studies, or this folder where that is missing"),
    folder("results", "where results are"),
    example="studies",
)
def list_studies(arguments: Namespace) -> int:
    """List the study files of a folder, and which of them have a result."""
    here = arguments.folder is None and not os.path.isdir(STUDIES)  # where other files of the name are too
    folder, out = Path("." if here else arguments.folder or STUDIES), Path(arguments.out)
    if not os.path.isdir(folder):
        raise _no_studies(folder, "there is no such folder")
    paths = sorted(folder.glob("*.toml") if here else folder.rglob("*.toml"))
    rows = [row for path in paths for row in _rows(path, out, path.parent.relative_to(folder))]
    rows = [row for row in rows if not here or row[1] != UNKNOWN or row[3]]
    if not rows:
        raise _no_studies(folder, "`jointplay new` writes one")
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        print("  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip())
    return DONE


def _no_studies(folder: Path, why: str) -> InputError:
    return InputError([Problem("folder", str(folder), f"a folder with study files is accepted; {why}")])


def _rows(path: Path, out: Path, inside: Path) -> Iterator[tuple[str, str, str, str]]:
    """File, kind, state of the result, and title of a study, which is validated only where there is one.

    A file that names no kind has a row for each as which it has a result.
    """
    from jointplay.study.toml_text import kinds_there, parse, read_text

    try:
        table = parse(read_text(path))
    except InputError:
        yield str(path), UNKNOWN, "", "not a readable study file: see `jointplay check`"
        return
    title, name = one_line(str(table.get("title", ""))), str(table.get("name", path.stem))
    places = list(dict.fromkeys((out, out / inside)))
    found = [(kind, at) for at in places for kind in kinds_there(path, at)]
    for kind, at in found:
        yield str(path), kind, _state(path, at / f"{path.stem}_{kind}.nc", kind), title
    results = [at for place in places if os.path.isfile(at := place / f"{name}.nc")]
    if results or not found:
        kind = one_line(str(table.get("kind", UNKNOWN)))
        yield str(path), kind, _state(path, results[0]) if results else "", title


def _state(path: Path, result: Path, kind: str | None = None) -> str:
    """State of a study's result in a word or two."""
    from jointplay.study.file import load
    from jointplay.study.result_state import result_state

    try:
        return result_state(load(path, kind=kind).record, result).partition(" (")[0]
    except InputError:
        return "not valid"


@verb(
    "import",
    option("file", metavar="FILE", help="a table of links and joints (ends in .csv)"),
    option("--out", metavar="STUDY.toml", help="default: beside the file"),
    option("--bar", metavar="MASS/LENGTH", help="take links as uniform bars, such as '0.8 kg/m'"),
    example="linkage.csv --bar '0.8 kg/m' --out linkage.toml",
)
def import_linkage(arguments: Namespace) -> int:
    """Write the study file of a linkage from a table (CSV) of its links and joints."""
    from jointplay.study.import_file import imported

    text, missing = imported(arguments.file, arguments.bar)
    target = Path(arguments.out) if arguments.out else Path(arguments.file).with_suffix(".toml")
    _write_new(target, text, "--out")
    for key in missing:
        print(f"fill in {key}")
    return DONE


def _write_new(target: Path, text: str, key: str) -> None:
    """Write a file that is not there yet."""
    from jointplay.study.results.store import check_writable

    check_writable(target.parent, key, files=[target.name])
    try:
        with target.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError:
        expected = "the name of a file that is not there yet is accepted"
        raise InputError([Problem(key, str(target), expected)]) from None
    print(f"written {target}")


@verb(
    "cite",
    option("study", metavar="STUDY.toml|RESULT.nc"),
    option("--bibtex", action="store_true", help="as BibTeX entries"),
    example="studies/quickstart.toml --bibtex",
)
def cite_study(arguments: Namespace) -> int:
    """Print references of the mechanism, laws and methods that a study, or the study of a result, uses."""
    from jointplay.study import cite
    from jointplay.study.file import load

    record = load(arguments.study).record
    print(cite.as_bibtex(record) if arguments.bibtex else cite.as_text(record))
    return DONE


@verb("schema", example="> study.schema.json")
def print_schema(arguments: Namespace) -> int:
    """Print the JSON schema of study files, for editors."""
    from jointplay.study.file import schema

    print(json.dumps(schema(), indent=2))
    return DONE


@verb(
    "cache",
    option("action", nargs="?", choices=["list", "prune", "verify"], default="list"),
    option("--all", action="store_true", help="prune: remove the kernels in use as well"),
    example="verify",
)
def keep_cache(arguments: Namespace) -> int:
    """List the compiled kernels on the disk, verify the ones in use, or remove the ones of older sources."""
    from jointplay.solver.codegen import place

    if arguments.all and arguments.action != "prune":
        raise InputError([Problem("--all", arguments.action, "accepted beside prune only")])
    if arguments.action == "verify":
        sound, removed = place.verify()
        print(f"{sound} files of the kernels in use are sound; {removed} were damaged and have been removed")
        return FAILED if removed else DONE
    if arguments.action == "prune":
        print(f"removed {len(place.prune(arguments.all))} of the cached kernel folders")
    for entry in place.entries():
        print(entry)
    return DONE
