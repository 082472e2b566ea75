"""The verb of pages of the command line. Heavy modules are imported inside it."""

from argparse import Namespace
from pathlib import Path

from jointplay.cli.verb import DONE, option, say, verb
from jointplay.display.terminal import Progress


@verb(
    "report",
    option("result", metavar="RESULT.nc|STUDY.toml", help="a result; or a study file, for its mechanism"),
    option("--out", metavar="PAGE.html", help="default: beside the result"),
    example="results/quickstart.nc --out quickstart.html",
)
def report_result(arguments: Namespace) -> int:
    """Write a stored result, or a mechanism, as one HTML page that computes, and needs no network."""
    from jointplay.study.file import moving_of, title_of
    from jointplay.study.results.store import open_result
    from jointplay_page.report import report

    given = Path(arguments.result)
    target = Path(arguments.out or given.with_suffix(".html"))
    with Progress(target.name):  # clicked points are computed: that may compile
        if given.suffix == ".toml":
            paths = report(moving_of(given), target, title=title_of(given))
        else:
            paths = report(open_result(given), target)
    for path in paths:
        say(f"written {path}")
    return DONE
