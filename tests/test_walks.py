"""How far a mechanism and a model are handed around, held, so that their way can be read in one go.

Counted are calls of functions that are given them, and returns to files that they have left.
"""

import sys
from itertools import groupby
from pathlib import Path

import pytest

import jointplay as jp
from jointplay.solver import Request, assemble
from jointplay.solver.motion.trajectory import memory

ROOT = str(Path(jp.__file__).parent)
LOOSE = jp.catalog.chunmei2002(clearance=2.9e-5)


def given_to(thing, call):
    """Files and names of our functions that are called with a thing, in order."""
    found, frames = [], {}

    def look(frame, event, _):
        code = frame.f_code
        if event != "call" or id(frame) in frames or not code.co_filename.startswith(ROOT):
            return
        frames[id(frame)] = frame  # kept, since a generator is entered many times
        variadic = bool(code.co_flags & 4) + bool(code.co_flags & 8)
        names = code.co_varnames[: code.co_argcount + code.co_kwonlyargcount + variadic]
        for value in (frame.f_locals.get(name) for name in names):
            inner = [*value.values()] if isinstance(value, dict) else value
            inner = inner if type(inner) in (list, tuple) else []
            if any(each is thing for each in (value, *inner)):
                found.append((code.co_filename.removeprefix(ROOT), code.co_name))
                return

    sys.setprofile(look)
    try:
        call()
    finally:
        sys.setprofile(None)
    return found


def returns(walk):
    """How often a walk comes back to a file that it has left."""
    files = [name for name, _ in groupby(name for name, _ in walk)]
    return len(files) - len({*files})


@pytest.mark.parametrize(
    ("start", "calls", "back"), [("assemble", 26, 10), ("memory", 8, 1), ("simulate", 120, 32)]
)
def test_nothing_is_handed_around_farther_than_was_agreed(start, calls, back):
    model = assemble(LOOSE)
    scenes = {
        "assemble": (LOOSE, lambda: assemble(LOOSE)),
        "memory": (model, lambda: memory(model, Request(duration=model.period))),
        "simulate": (LOOSE, lambda: jp.simulate(LOOSE, turns=0.1)),
    }
    scenes[start][1]()  # else what is done once would count
    walk = given_to(*scenes[start])
    print(f"{start}: {len(walk)} calls (at most {calls}), {returns(walk)} returns (at most {back})")
    assert len(walk) <= calls
    assert returns(walk) <= back


def test_walks_are_counted_as_they_are():
    assert returns([("a", "f"), ("a", "g"), ("b", "f"), ("a", "f"), ("b", "g"), ("c", "f")]) == 2
