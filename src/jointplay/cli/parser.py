"""The parser of the command line: the options of each verb."""

from argparse import Action, ArgumentParser
from collections.abc import Callable
from typing import Any

from jointplay.cli import verbs
from jointplay.cli.animate import animate_result
from jointplay.kinds import KINDS

BACKENDS = ("loky", "threading", "dask")


class _Version(Action):
    """Look the version up only when it is asked for."""

    def __call__(self, parser, *_):
        from importlib.metadata import version

        parser.exit(message=f"jointplay {version('jointplay')}\n")


def _option(*names: str, **keywords: Any) -> tuple[tuple[str, ...], dict[str, Any]]:
    """The arguments of `add_argument`."""
    return names, keywords


def _folder(default: str, text: str = "where results go"):
    return _option("--out", default=default, metavar="DIR", help=f"{text} (default: {default})")


def _changes(text: str):
    # `extend` lets one --set take several changes, and be given again
    return _option("--set", nargs="+", action="extend", default=[], metavar="KEY=VALUE", help=text)


def build_parser() -> ArgumentParser:
    """Make the parser of all verbs."""
    parser = ArgumentParser(prog="jointplay", description="Dynamics of linkages with play in their joints.")
    parser.add_argument("--version", action=_Version, nargs=0, help="print the version")
    subparsers = parser.add_subparsers(title="verbs", required=True, metavar="VERB")

    def add(name: str, verb: Callable, *options, example: str) -> None:
        text = verb.__doc__
        own = subparsers.add_parser(
            name,
            help=text[0].lower() + text[1:].rstrip("."),
            description=text,
            epilog=f"example: jointplay {name} {example}".rstrip(),
        )
        own.set_defaults(verb=verb)
        for names, keywords in options:
            own.add_argument(*names, **keywords)

    study, result = _option("study", metavar="STUDY.toml"), _option("result", metavar="RESULT.nc")
    out = _folder("results")
    change = _changes("change one value of the study, such as mechanism.clearance=1e-4")
    no_figure = _option("--no-figure", action="store_true", help="store the result only")
    jobs = _option("--jobs", type=int, default=2, metavar="N", help="worker processes (default: 2)")
    fresh = _option(
        "--fresh", action="store_true", help="drop what an earlier run finished, also with other settings"
    )
    add(
        "new",
        verbs.new_study,
        _option("kind", metavar="KIND", help=", ".join(KINDS)),
        _option("file", nargs="?", metavar="NAME.toml", help="default: KIND.toml"),
        _option("--mechanism", metavar="NAME", help="write a linkage out, such as four_bar or slider_crank"),
        example="response own.toml --mechanism four_bar",
    )
    add(
        "run",
        verbs.run_study,
        *(study, out, no_figure, jobs),
        _option("--backend", default="loky", choices=BACKENDS, help="processes, threads or a cluster"),
        _option("--scheduler", metavar="ADDRESS", help="of a dask cluster, such as tcp://host:8786"),
        _option("--part", metavar="I/N", help="compute part I of N only, to be put together by merge"),
        *(fresh, change),
        example="studies/quickstart.toml --set mechanism.clearance=1e-4 --out other",
    )
    add(
        "assess",
        verbs.assess_mechanism,
        _option("study", metavar="MECHANISM.toml"),
        *(out, no_figure, jobs),
        _changes("change one value, such as mechanism.clearance=1e-4 or analysis.reach=3"),
        example="studies/quickstart.toml --set analysis.reach=1.5",
    )
    sweep = "studies/bifurcation/bifurcation_clearance.toml"
    add("plan", verbs.plan_study, study, out, jobs, change, example=f"{sweep} --jobs 8")
    add("status", verbs.show_status, study, out, change, example=sweep)
    add("merge", verbs.merge_study, study, out, no_figure, change, example=f"{sweep} --out shared")
    names = "studies of studies/paper, such as fig05b; all if none"
    add(
        "reproduce",
        verbs.reproduce_paper,
        _option("names", nargs="*", metavar="NAME", help=names),
        *(jobs, _folder("results/paper"), fresh),
        example="fig12c --out reproduced",
    )
    add("check", verbs.check_study, study, change, example="studies/quickstart.toml")
    add(
        "figure",
        verbs.draw_result,
        _option("result", metavar="RESULT.nc|STUDY.toml"),
        _option("--kind", help="another kind of figure than the study asked for"),
        _option("--over", metavar="DIAGRAM.nc", help="draw branches over this bifurcation diagram"),
        _option("--out", metavar="FILE", help="default: PDF and PNG beside the result"),
        _changes("an option of the figure, such as joint=B"),
        example="results/quickstart.nc --kind journal_orbit --set joint=B --out orbit.pdf",
    )
    add(
        "animate",
        animate_result,
        result,
        _option("--out", metavar="FILE", help="a film, .mp4 or .gif, or a sheet of frames, .pdf or .png"),
        _changes("an option: joint=B, turns=1, seconds=6 (of a turn), rate=25 (frames a second), frames=8"),
        example="results/quickstart.nc --out quickstart.gif --set turns=1",
    )
    page = _option("--out", metavar="PAGE.html", help="default: beside the result")
    add("report", verbs.report_result, result, page, example="results/quickstart.nc --out quickstart.html")
    add(
        "export",
        verbs.export_result,
        result,
        _option("--out", metavar="FILE", help="ends in .mat or .csv (default: .mat beside the result)"),
        _option("--over", nargs="+", metavar="DIM", help="dimensions of a table's rows, such as time"),
        example="results/quickstart.nc --out quickstart.csv --over time",
    )
    add(
        "cite",
        verbs.cite_study,
        _option("study", metavar="STUDY.toml|RESULT.nc"),
        _option("--bibtex", action="store_true", help="as BibTeX entries"),
        example="studies/quickstart.toml --bibtex",
    )
    add(
        "import",
        verbs.import_linkage,
        _option("file", metavar="FILE", help="ends in .json (of pylinkage) or .csv (links and joints)"),
        _option("--out", metavar="STUDY.toml", help="default: beside the file"),
        _option("--unit", help="of the lengths in a file of pylinkage, such as mm"),
        _option("--bar", metavar="MASS/LENGTH", help="take links as uniform bars, such as '0.8 kg/m'"),
        example="linkage.json --unit mm --bar '0.8 kg/m' --out linkage.toml",
    )
    folder = _option("folder", nargs="?", default="studies", metavar="DIR")
    add("list", verbs.list_studies, folder, _folder("results", "where results are"), example="studies")
    add("schema", verbs.print_schema, example="> study.schema.json")
    add(
        "cache",
        verbs.keep_cache,
        _option("action", nargs="?", choices=["list", "prune", "verify"], default="list"),
        _option("--all", action="store_true", help="prune: remove the kernels in use as well"),
        example="verify",
    )
    return parser
