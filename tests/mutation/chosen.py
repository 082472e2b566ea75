"""Which tests can notice a broken line: those that ran it, and those that take a shared fixture which did."""

from __future__ import annotations

import ast
import json
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from statistics import median

from coverage import CoverageData

CORE = "fixture ::"  # how pytest's own fixtures are named


@dataclass(frozen=True)
class Test:
    """A test as the map has it: how long it took, and the shared fixtures that it takes."""

    name: str
    seconds: float
    long: bool
    interpreted: bool  # whether the kernels were plain Python, so that coverage saw them
    fixtures: list[str]


def setups(tests: Iterable[Test]) -> dict[str, float]:
    """Seconds that shared fixtures took: what the test that had to wait for one took beyond the others."""
    times = defaultdict(list)
    for test in tests:
        for name in test.fixtures:
            times[name].append(test.seconds)
    return {name: max(some) - median(some) for name, some in times.items() if not name.startswith(CORE)}


class Map:
    """What the runs under coverage have found; a mutant gets so many seconds of tests, as they took there."""

    def __init__(self, folder: Path, budget: float):
        self.data, self.folder, self.budget = CoverageData(str(folder / "data")), folder, budget
        if (folder / "data").exists():
            self.data.read()
        rows = (folder / "tests.jsonl").read_text().splitlines() if (folder / "tests.jsonl").exists() else []
        known = [row for row in map(json.loads, rows) if row.pop("passed")]
        self.tests = {row["test"]: Test(row.pop("test"), **row) for row in known}
        self.setups = setups(self.tests.values())

    @lru_cache(maxsize=64)  # noqa: B019
    def _contexts(self, file: str) -> dict[int, set[str]]:
        """Contexts by line; those of import have no name."""
        names = [name for name in self.data.measured_files() if name.endswith(f"/{file}")]
        found = {}
        for name in names:
            for line, contexts in self.data.contexts_by_lineno(name).items():
                found.setdefault(line, set()).update(*(c.split("|") for c in contexts))
        return found

    def able(self, file: str, line: int, source: str, **kind: bool) -> list[Test]:
        """Tests of a kind (long, interpreted) that can notice a changed line: quick ones first."""
        contexts, lines = self._contexts(file), statement(source, line)
        names = set() if lines is None else set().union(*(contexts.get(n, set()) for n in lines))
        if lines is None or not self._taking(names):  # done at import, or in processes that coverage misses
            names = set().union(*contexts.values())
        place = Path(file).parts[2]
        own = (f"tests/{place}/", f"tests/test_{place}")
        found = [t for t in self._taking(names) if kind.items() <= vars(t).items()]
        found.sort(key=lambda t: (self._cost(t) + 0.05) * (1 if t.name.startswith(own) else 4))
        return self._affordable(found)

    def _cost(self, test: Test) -> float:
        return max([test.seconds, *(self.setups.get(name, 0.0) for name in test.fixtures)])

    def _affordable(self, tests: list[Test]) -> list[Test]:
        """As many from the beginning as the budget allows, one at least."""
        spent, taken, ready = 0.0, [], set()
        for test in tests:
            waits = not ready.issuperset(test.fixtures)
            spent += 0.02 + (self._cost(test) if waits else test.seconds)
            ready.update(test.fixtures)
            if taken and spent > self.budget:
                break
            taken.append(test)
        return taken

    def _taking(self, names: set[str]) -> list[Test]:
        return [t for t in self.tests.values() if t.name in names or names.intersection(t.fixtures)]


def statement(source: str, line: int) -> range | None:
    """Lines of the statement that a line belongs to; None for one that is done at import."""
    best, inside = None, False
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.stmt | ast.excepthandler) and node.lineno <= line <= node.end_lineno:
            body = getattr(node, "body", None)
            last = body[0].lineno - 1 if body else node.end_lineno
            if isinstance(node, ast.FunctionDef) and line >= body[0].lineno:
                inside = True
            if line <= max(last, node.lineno) or body is None:
                best = range(node.lineno, max(last, node.lineno) + 1)
    return best if inside else None
