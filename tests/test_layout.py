"""Files of the package import each other in no circle; one is named like another where it mirrors that."""

import ast
from collections import defaultdict
from functools import cache
from graphlib import CycleError, TopologicalSorter

from tests.test_docstrings import FILES

# folders in which files of one name stand for one thing
MIRRORS = (
    {"jointplay.solver.mechanism", "jointplay.solver.equations"},
    {"jointplay.analysis", "jointplay.figures"},
    {"jointplay_lab", "jointplay_lab.figures"},
    {"jointplay", "jointplay_lab", "jointplay_page"},
    {
        *("jointplay.solver.codegen", "jointplay.solver.codegen.lanes"),
        *("jointplay.solver.method", "jointplay.solver.method.lanes"),
    },
    {"jointplay.display", "jointplay.solver.method"},
)
MODULES = {name.removesuffix(".__init__"): name for name in FILES}


@cache
def statements(text):
    """All statements of a program; other nodes, which are many more, are not walked through."""
    left, found = [ast.parse(text)], []
    while left:
        node = left.pop()
        for field in ("body", "orelse", "finalbody", "handlers", "cases"):
            left += getattr(node, field, [])
        found.append(node)
    return found


def imported(module, name):
    """Files of the package that one of them imports, wherever in it."""
    folder = module.split(".")[: None if name.endswith("__init__") else -1]
    for node in statements(FILES[name].read_text(encoding="utf-8")):
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


def home(name):
    """Folder of a file, as `MIRRORS` names it."""
    known = {each for mirrors in MIRRORS for each in mirrors if name.startswith(f"{each}.")}
    return max(known, key=len, default=".".join(name.split(".")[:2]))


def test_a_file_has_the_name_of_another_where_it_mirrors_it():
    places = defaultdict(list)
    for name in FILES:
        places[name.rpartition(".")[2]].append(name)
    several = {stem: each for stem, each in places.items() if len(each) > 1 and not stem.startswith("__")}
    assert len(several) > 30
    for stem, names in several.items():
        homes = [home(name) for name in names]
        assert len({*homes}) == len(homes), (stem, names)
        assert any({*homes} <= mirrors for mirrors in MIRRORS), (stem, names)
