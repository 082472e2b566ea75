"""Newton's iteration of a step: what it may leave undone, seen by the sizes of its updates."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from jointplay.numerics import step


@pytest.fixture(autouse=True)
def plain(monkeypatch):
    """The verdict as plain Python: what is inlined has no address of its own to be called at."""
    for name in ("converged", "error_ratio"):
        function = getattr(step, name)
        monkeypatch.setattr(step, name, getattr(function, "py_func", function))


def updates(first, ratio, tolerance, contraction=1e-12):
    """Whether an iteration with updates that shrink by a ratio ends well, and their sizes."""
    sizes = []

    def newton(*_):
        sizes.append(first * ratio ** len(sizes))
        return sizes[-1]

    f = SimpleNamespace(rate=lambda *_: None, newton=newton)
    k = SimpleNamespace(w=None, J=None, weight=None)
    x = SimpleNamespace(s=None, p=None, m=None, count=np.zeros(40, dtype=int))
    converge = getattr(step.converge, "py_func", step.converge)
    solved, _ = converge(f, 0, k, x, 1.0, tolerance, contraction)
    return solved, sizes


@pytest.mark.parametrize("ratio", [1e-3, 1e-6])
@pytest.mark.parametrize("first", [0.9, 0.3, 30.0])
def test_guards_are_never_those_of_an_iterate_far_from_the_answer(first, ratio):
    """However fast it converges: the guards lag one update behind, which is small before it ends."""
    solved, sizes = updates(first, ratio, tolerance=1.0)
    assert solved
    assert len(sizes) == 2
    assert sizes[-1] < 0.2


def test_an_update_small_enough_is_the_last():
    assert updates(1e-3, 1e-3, tolerance=1.0) == (True, [1e-3])


def test_what_is_left_is_within_the_tolerance():
    """Of updates that halve, the rest is as large as the last."""
    for tolerance in (1e-2, 1e-3):
        solved, sizes = updates(0.05, 0.5, tolerance, contraction=1.0)
        assert solved
        assert sizes[-2] > tolerance >= sizes[-1]
