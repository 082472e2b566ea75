"""Newton's iteration of a step: what it may leave undone, seen by the sizes of its updates."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from jointplay.solver.method import step
from jointplay.solver.method.lanes import attempts, layout


def updates(first, ratio, tolerance, contraction=1e-12):
    """Whether an iteration with updates that shrink by a ratio ends well, and their sizes."""
    sizes = []

    def newton(*_):
        sizes.append(first * ratio ** len(sizes))
        return sizes[-1]

    f = SimpleNamespace(rate=lambda *_: None, newton=newton)
    k = SimpleNamespace(w=None, J=None, weight=None)
    x = SimpleNamespace(s=None, p=None, m=None, count=np.zeros(40, dtype=int))
    solved, _ = step.converge(f, 0, k, x, 1.0, tolerance, contraction)
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


DONE, GOES_ON, FAILED = 1, 0, -1


@pytest.mark.parametrize(
    ("before", "size", "turned", "verdict"),
    [
        (1.0, 1e-3, 0.0, DONE),
        (1e-9, 1e-7, 0.0, DONE),  # next to nothing
        (50.0, 5.0, 0.0, GOES_ON),  # three more such updates leave 5e-3
        (500.0, 50.0, 0.0, GOES_ON),
        (5000.0, 500.0, 0.0, FAILED),  # 0.5 would be left
        (6.0, 5.0, 0.0, FAILED),  # shrinks slowly
        (0.6, 0.5, 0.0, FAILED),  # likewise, though small
        (0.4, 0.4, 0.0, FAILED),
        (50.0, 5.0, 1e3, FAILED),  # an angle turned too far
        (1.0, 1e-3, 1e3, FAILED),
    ],
)
def test_an_iteration_of_one_lane_goes_on_while_three_more_updates_would_end_it(
    before, size, turned, verdict
):
    w, lane = np.zeros(8 * layout.NUMBERS), 3
    for row, value in ((layout.SIZE_BEFORE, before), (layout.SIZE, size), (layout.TURNED, turned)):
        w[8 * row + lane] = value
    assert attempts._verdict(w, lane) == verdict
    w[8 * layout.CONTINUED + lane] = 1.0  # it has had more already
    assert attempts._verdict(w, lane) == (DONE if verdict == DONE else FAILED)
