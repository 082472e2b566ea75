"""Verbs of the command line: functions of their arguments, with options and an example."""

from argparse import Namespace
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

from jointplay.solver.extensions import Table

DONE, FAILED = 0, 1  # exit codes
say = partial(print, flush=True)

Option = tuple[tuple[str, ...], dict[str, Any]]


@dataclass(frozen=True)
class Verb:
    """A verb: its function, its options as arguments of `add_argument`, and an example of them."""

    name: str
    function: Callable[[Namespace], int]
    options: tuple[Option, ...]
    example: str


VERBS: Table[Verb] = Table("jointplay.verbs", Verb)


def verb(name: str, *options: Option, example: str) -> Callable[[Callable], Callable]:
    """Make a function a verb; its docstring is the help."""

    def add(function: Callable[[Namespace], int]) -> Callable[[Namespace], int]:
        VERBS[name] = Verb(name, function, options, example)
        return function

    return add


def option(*names: str, **keywords: Any) -> Option:
    """The arguments of `add_argument`."""
    return names, keywords


def folder(default: str, text: str = "where results go") -> Option:
    """The option --out of a folder."""
    return option("--out", default=default, metavar="DIR", help=f"{text} (default: {default})")


def changes(text: str) -> Option:
    """The option --set: it takes several changes, and can be given again."""
    return option("--set", nargs="+", action="extend", default=[], metavar="KEY=VALUE", help=text)


STUDY, RESULT = option("study", metavar="STUDY.toml"), option("result", metavar="RESULT.nc")
OUT = folder("results")
CHANGE = changes("change one value of the study, such as mechanism.clearance=1e-4")
NO_FIGURE = option("--no-figure", action="store_true", help="store the result only")
JOBS = option("--jobs", type=int, default=2, metavar="N", help="worker processes (default: 2)")
FRESH = option(
    "--fresh", action="store_true", help="discard what an earlier run finished, even with other settings"
)
