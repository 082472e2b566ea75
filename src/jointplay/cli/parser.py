"""The parser of the command line, from its verbs."""

from argparse import Action, ArgumentParser

from jointplay.cli import files, results, studies
from jointplay.cli.verb import VERBS

GROUPS = [module.__name__ for module in (studies, results, files)]


class _Version(Action):
    """Look the version up only when it is asked for."""

    def __call__(self, parser, *_):
        from importlib.metadata import version

        parser.exit(message=f"jointplay {version('jointplay')}\n")


def build_parser() -> ArgumentParser:
    """Make the parser of all verbs."""
    parser = ArgumentParser(prog="jointplay", description="Dynamics of linkages with play in their joints.")
    parser.add_argument("--version", action=_Version, nargs=0, help="print the version")
    subparsers = parser.add_subparsers(title="verbs", required=True, metavar="VERB")
    for name, row in sorted(VERBS.items(), key=lambda each: GROUPS.index(each[1].function.__module__)):
        text = row.function.__doc__ or ""
        own = subparsers.add_parser(
            name,
            help=text[0].lower() + text[1:].rstrip("."),
            description=text,
            epilog=f"example: jointplay {name} {row.example}",
        )
        own.set_defaults(verb=row.function)
        for names, keywords in row.options:
            own.add_argument(*names, **keywords)
    return parser
