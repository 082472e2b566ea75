"""Tables of rows by name, to which other packages add by entry points.

There are six: laws, frictions, mechanisms, kinds, figures, verbs. In a package's own `pyproject.toml`,
``[project.entry-points."jointplay.laws"]`` and ``name = "module:object"`` publish a row under that name. The
object may also be several rows, as a mapping by name or a tuple of rows that have names, or a module, which
adds its rows itself when it is imported.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, MutableMapping
from functools import cache
from importlib.machinery import EXTENSION_SUFFIXES, SOURCE_SUFFIXES
from importlib.metadata import EntryPoint, EntryPoints, entry_points
from importlib.util import find_spec
from pathlib import Path
from traceback import extract_tb
from types import ModuleType
from typing import Any, TypeVar

T = TypeVar("T")
OWN = Path(__file__).resolve().parents[1]
CODE = (*SOURCE_SUFFIXES, *EXTENSION_SUFFIXES)
_found = cache(entry_points)


def published(group: str) -> EntryPoints:
    """Entry points of a group; those of all packages are read once, since that reads a file of each."""
    return _found().select(group=group)


def packages(*groups: str) -> dict[str, Path]:
    """Packages that publish in these groups, without importing them: a folder, or a single module's file."""
    modules = {point.module for group in groups for point in published(group)}
    return {name: place for name, place in map(_package, modules) if place and place != OWN}


def _package(module: str) -> tuple[str, Path | None]:
    """Name and place of a module's outermost package, which is not imported; None where there is none."""
    name, *rest = module.split(".")
    spec = find_spec(name)
    while spec and spec.origin is None and rest:  # a namespace, which many packages share
        name = f"{name}.{rest.pop(0)}"
        spec = find_spec(name)
    if spec is None or not spec.has_location:
        return name, None
    place = Path(str(spec.origin)).resolve()
    return name, place.parent if place.name == "__init__.py" else place


def outsider(error: BaseException) -> str:
    """Name the package of others in whose code an error arose, and the line; empty where it is in none's."""
    places = {
        _package(point.module)[1]: point.dist.name
        for group in _found().groups
        for point in published(group)
        if group.startswith("jointplay.") and point.dist and point.dist.name != "jointplay"
    }
    for frame in reversed(extract_tb(error.__traceback__)):
        for place, package in places.items():
            if place and Path(frame.filename).resolve().is_relative_to(place):
                return f"{package}: {frame.filename}, line {frame.lineno}, in {frame.name}"
    return ""


def code_files(place: Path) -> list[Path]:
    """Files of code in a folder; of a file, itself."""
    return sorted(path for path in (place, *place.rglob("*")) if path.is_file() and path.name.endswith(CODE))


class Table(MutableMapping[str, T]):
    """Rows by name: own ones, then rows of other packages, searched once a name is not an own one.

    An entry point that cannot be loaded is left out; `broken` says why, and so does the error of a name that
    is not known.

    Parameters
    ----------
    group : str
        Group of the entry points.
    of : type
        What a row must be.
    rows : mapping of str to object
        The own rows.
    """

    def __init__(self, group: str, of: Any, rows: Mapping[str, T] | None = None) -> None:
        self.group, self.of, self.own = group, of, dict(rows or {})
        self._loaded, self._broken, self._sources = False, dict[str, str](), dict[str, str]()

    @property
    def broken(self) -> dict[str, str]:
        """Reasons why entry points cannot be loaded, by their names."""
        self._ask()
        return self._broken

    def source(self, name: str) -> str:
        """Entry point by which a row came, in words; empty, of an own one."""
        return self._sources.get(name, "")

    def _ask(self) -> None:
        if self._loaded:
            return
        self._loaded = True  # first of all: what is loaded may look into the table itself
        for point in published(self.group):
            before, of = dict(self.own), f" of {point.dist.name}" if point.dist else ""
            source = f"entry point {point.name!r} ({point.value}){of} in {self.group}"
            try:
                self.own = before | self._checked(point) | self.own  # a module adds its own
                self._sources |= dict.fromkeys(self.own.keys() - before.keys(), source)
            except (Exception, SystemExit) as error:  # whatever a stranger's module does
                self.own = before
                self._broken[source] = " ".join(f"{type(error).__name__}: {error}".split())

    def _checked(self, point: EntryPoint) -> dict[str, T]:
        given = point.load()
        if isinstance(given, ModuleType):
            return {}
        if isinstance(given, tuple | list):
            given = {row.name: row for row in given}
        rows = dict(given) if isinstance(given, Mapping) else {getattr(given, "name", point.name): given}
        if wrong := [name for name, row in rows.items() if not isinstance(row, self.of)]:
            raise TypeError(f"{', '.join(wrong)} is no {self.of.__name__}")
        if taken := [name for name, row in rows.items() if self.own.get(name, row) is not row]:
            raise ValueError(f"there is another {', '.join(taken)} already")
        return rows

    def __getitem__(self, name: str) -> T:
        if name not in self.own:
            self._ask()
        return self.own[name]

    def __setitem__(self, name: str, row: T) -> None:
        self.own[name] = row

    def __delitem__(self, name: str) -> None:
        del self.own[name]

    def __iter__(self) -> Iterator[str]:
        self._ask()
        return iter(self.own)

    def __len__(self) -> int:
        self._ask()
        return len(self.own)
