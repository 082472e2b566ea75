"""The stub of the package, which type checkers read, offers what the package does; mypy does the rest."""

import ast
from importlib import import_module
from pathlib import Path

import jointplay

STUB = ast.parse(Path(jointplay.__file__).with_name("__init__.pyi").read_text(encoding="utf-8"))


def test_names_of_the_stub_are_the_packages_own_from_the_same_places():
    places = {}
    for node in STUB.body:
        if isinstance(node, ast.ImportFrom):
            home = f"jointplay.{node.module}" if node.level else node.module
            places |= {alias.asname: (home, alias.name) for alias in node.names}
        elif isinstance(node, ast.Assign):
            places[node.targets[0].id] = places.pop(node.value.id)
    assert {"__version__", *places} == {*dir(jointplay)} == {*jointplay.__all__}
    for name, (home, attribute) in places.items():
        module = import_module(home)
        there = getattr(module, attribute, None) or import_module(f"{home}.{attribute}")
        assert getattr(jointplay, name) is there, name
