"""No files of the package import each other in a circle: not inside functions, nor for types alone."""

import ast
from graphlib import CycleError, TopologicalSorter

from tests.test_docstrings import FILES

MODULES = {".".join(["jointplay", *name.split(".")]).removesuffix(".__init__"): name for name in FILES}


def imported(module, name):
    """Files of the package that one of them imports, wherever in it."""
    folder = module.split(".")[: None if name.endswith("__init__") else -1]
    for node in ast.walk(ast.parse(FILES[name].read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (MODULES[alias.name] for alias in node.names if alias.name in MODULES)
        elif isinstance(node, ast.ImportFrom):
            above = folder[: len(folder) + 1 - node.level] if node.level else []
            home = ".".join([*above, *filter(None, [node.module])])
            places = (f"{home}.{alias.name}" for alias in node.names)
            yield from (MODULES[place if place in MODULES else home] for place in places if home in MODULES)


def circle(files):
    """One circle of files that import each other, or none."""
    try:
        TopologicalSorter(files).prepare()
    except CycleError as error:
        return error.args[1]


def test_no_files_import_each_other_in_a_circle():
    arrows = {name: {*imported(module, name)} - {name} for module, name in MODULES.items()}
    assert sum(map(len, arrows.values())) > 1500
    assert not circle(arrows)
