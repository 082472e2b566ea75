"""Verbs that show and write stored results. Heavy modules are imported inside them."""

import sys
import warnings
from argparse import Namespace
from pathlib import Path

from jointplay.cli.verb import DONE, RESULT, changes, option, say, verb
from jointplay.display.errors import InputError, Problem, of_a_result, raise_any, refuse, unknown
from jointplay.display.terminal import Progress

FILM = ("joint", "turns", "time", "seconds", "rate", "frames")  # options of a film


@verb(
    "figure",
    option("result", metavar="RESULT.nc|STUDY.toml"),
    option("--kind", help="another kind of figure than the study asked for"),
    option("--over", metavar="DIAGRAM.nc", help="draw branches over this bifurcation diagram"),
    option("--out", metavar="FILE", help="default: NAME.pdf, .png beside the result; of --kind, NAME_KIND"),
    changes("an option of the figure, such as joint=B"),
    example="results/quickstart.nc --kind journal_orbit --set joint=B --out orbit.pdf",
)
def draw_result(arguments: Namespace) -> int:
    """Draw a stored result again; or the mechanism of a study file."""
    from jointplay.study.file import figure_options, mechanism_of
    from jointplay.study.results.store import check_writable, open_result

    whole = arguments.kind == "mechanism" or Path(arguments.result).suffix == ".toml"
    dataset = (mechanism_of if whole else open_result)(arguments.result)
    options = figure_options(dataset, arguments.kind, arguments.set)
    if arguments.over:
        options["over"] = open_result(arguments.over)
    files = targets(arguments.out, picture_name(Path(arguments.result), arguments.kind))
    check_writable(files[0].parent, files=[file.name for file in files])
    draw(dataset, options, files)
    return DONE


def picture_name(result: Path, kind: str | None) -> Path:
    """The name from which that of a picture is made: one of another kind leaves the study's own as it is."""
    from jointplay.figures import KINDS

    return result.with_name(f"{result.stem}_{kind}.nc") if kind in KINDS else result


def targets(out: str | None, result: Path) -> list[Path]:
    """Files of a figure: the given one, or a PDF and a PNG file named after the result."""
    stem = result if out is None else Path(out)
    if stem.name in ("", ".."):
        raise InputError([Problem("--out", out, "the name of a file is accepted")])
    return [stem] if out and stem.suffix else [stem.with_suffix(end) for end in (".pdf", ".png")]


def draw(dataset, options: dict, files: list[Path]) -> None:
    """Draw a result, and write the picture into files."""
    from jointplay import figures
    from jointplay.study.results.store import write_figure

    picture = figures.draw(dataset, options)
    picture.set_layout_engine(None)  # it is laid out; "none" would stand for one, and be drawn for each file
    with of_a_result(dataset):
        for file in files:
            print(f"figure  {write_figure(picture, file)}")


@verb(
    "animate",
    RESULT,
    option("--out", metavar="FILE", help="a film, .mp4 or .gif, or a sheet of frames, .pdf or .png"),
    changes("an option: joint=B, turns=1, seconds=6 (of a turn), rate=16 (frames a second), frames=8"),
    example="results/quickstart.nc --out quickstart.gif",
)
def animate_result(arguments: Namespace) -> int:
    """Show the mechanism of a stored motion around its hardest impact: a film, or a sheet of frames."""
    from jointplay.study import toml_text
    from jointplay.study.results.animate import animate
    from jointplay.study.results.store import open_result

    options = toml_text.override({}, arguments.set)
    raise_any(
        unknown(f"--set {key}", options[key], key, FILM, "option") for key in options if key not in FILM
    )
    target = Path(arguments.out) if arguments.out else Path(arguments.result).with_suffix(".mp4")
    if not target.suffix:
        raise refuse(str(target), "a name that ends in .mp4, .gif, .pdf or .png is accepted", "--out")
    with Progress(target.name) as progress:
        path = animate(open_result(arguments.result), target, **options, progress=progress)
    say(f"written {path}, {path.stat().st_size / 1e6:.2g} MB")
    return DONE


@verb(
    "export",
    RESULT,
    option("--out", metavar="FILE", help="ends in .mat or .csv (default: .mat beside the result)"),
    option("--over", nargs="+", metavar="DIM", help="dimensions of a table's rows, such as time"),
    example="results/quickstart.nc --out quickstart.csv --over time",
)
def export_result(arguments: Namespace) -> int:
    """Write a stored result for other programs: MATLAB (.mat) or a table (.csv)."""
    from jointplay.study.results.export import export
    from jointplay.study.results.store import open_result

    target = Path(arguments.result).with_suffix(".mat") if arguments.out is None else arguments.out
    with warnings.catch_warnings(record=True) as doubts:
        print(f"written {export(open_result(arguments.result), target, arguments.over)}")
    for doubt in doubts:
        print(f"warning {doubt.message}", file=sys.stderr)
    return DONE
