"""jointplay: nonlinear dynamics of linkages whose joints have play.

    import jointplay as jp

`jp.catalog`, and the records `jp.Mechanism`, `jp.Link`, `jp.Joint`, … say what is simulated; `jp.simulate`
gives time histories and `jp.poincare` section points, each as an `xarray.Dataset`; `jp.open` reads a stored
result, `jp.figure` draws one; wrong input raises `jp.InputError`. SI units throughout; angles in rad.

Public names load on first use, so that the command line starts fast.
"""

import os
import sys
from functools import cache
from importlib import import_module
from pathlib import Path

# `python -m jointplay` has put the current folder first on the path: what lies beside a study is no library
if sys.argv[:1] == ["-m"] and sys.orig_argv[-len(sys.argv)].removeprefix("-m") == __name__:
    try:
        sys.path.remove(here := os.getcwd())
        if os.path.samefile(here, os.path.dirname(__path__[0])):
            sys.path.insert(sys.path.index(os.path.dirname(os.__file__)) + 2, here)  # behind Python's own
    except (OSError, ValueError):  # the folder is gone, or was kept off the path
        pass

from jointplay.display.errors import no_attribute

__version__ = "0.2.0"


@cache
def _offered() -> dict[str, str]:
    """Places of our public names, as the stub beside this file has them for type checkers."""
    import ast

    found = {}
    for node in ast.parse(Path(__file__).with_name("__init__.pyi").read_text("utf-8")).body:
        if isinstance(node, ast.ImportFrom) and node.level:  # other packages are found by entry points
            found |= {alias.asname: f".{node.module}:{alias.name}" for alias in node.names}
        elif isinstance(node, ast.Assign):  # a name that differs from the one at home
            found[node.targets[0].id] = found.pop(node.value.id)
    return found


@cache
def _homes() -> dict[str, str]:
    """Places of the public names: those that packages publish, analyses by their kinds, and our own."""
    from jointplay.kinds import KINDS
    from jointplay.solver.extensions import published

    of_others = {point.name: point.value for point in published("jointplay.names")}
    return of_others | {row.home.partition(":")[2]: row.home for row in KINDS.values()} | _offered()


def __getattr__(name: str):
    if name == "__all__":
        return ["__version__", *_homes()]
    place = _offered().get(name) or _homes().get(name)
    if place is None:
        raise no_attribute("module 'jointplay'", name, ["__version__", *_homes()])
    home, _, attribute = place.partition(":")
    module = import_module(home, __name__)
    value = getattr(module, attribute, None) or import_module(f"{home}.{attribute}", __name__)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(["__version__", *_homes()])
