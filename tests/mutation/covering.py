"""A pytest plugin for runs under coverage: which test, or shared fixture, ran a line, and what tests took.

Shared fixtures are contexts of their own: what they ran serves all tests that take them, not only the first.
"""

from __future__ import annotations

import json
import os
from contextlib import contextmanager
from pathlib import Path

import coverage
import pytest

TABLE = "JOINTPLAY_COVERING"  # variable that names the file of the tests' times
CONTEXT = "JOINTPLAY_TEST"  # variable that tells processes which a test starts whose they are
REPORTS = pytest.StashKey[list]()


@contextmanager
def context(name):
    """All lines that run inside, in this process and in those it starts, belong to `name`."""
    before = os.environ.get(CONTEXT, "")
    _switch(name)
    yield
    _switch(before)


def _switch(name):
    os.environ[CONTEXT] = name
    if coverage.Coverage.current():
        coverage.Coverage.current().switch_context(name)


def shared(definition, index):
    """Name of a fixture that several tests share; None for one that each makes anew."""
    if definition.scope == "function":
        return None
    return f"fixture {definition.baseid}::{definition.argname}[{index}]"


def fixtures(item):
    """Names of the shared fixtures that a test takes."""
    indices = getattr(getattr(item, "callspec", None), "indices", {})
    known = item._fixtureinfo.name2fixturedefs
    return [
        key for name, found in known.items() if (key := shared(found[-1], indices.get(name, 0))) is not None
    ]


@pytest.hookimpl(wrapper=True)
def pytest_fixture_setup(fixturedef, request):
    name = shared(fixturedef, getattr(request, "param_index", 0))
    if name is None:
        return (yield)
    with context(name):
        return (yield)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item):
    with context(item.nodeid):
        return (yield)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item, call):
    report = yield
    kept = item.stash.setdefault(REPORTS, [])
    kept.append(report)
    if call.when == "teardown":
        _write(item, kept)
    return report


def _write(item, reports):
    row = {
        "test": item.nodeid,
        "seconds": round(sum(report.duration for report in reports), 2),
        "passed": all(report.passed for report in reports),
        "long": any(item.get_closest_marker(name) for name in ("long", "nightly")),
        "interpreted": os.environ.get("NUMBA_DISABLE_JIT") == "1",
        "fixtures": fixtures(item),
    }
    with Path(os.environ[TABLE]).open("a") as file:
        file.write(json.dumps(row) + "\n")
