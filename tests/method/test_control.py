"""Lengths of steps: what served in a mode is where the next step into that mode begins."""

import numpy as np
import pytest

from jointplay.solver.method import control
from jointplay.solver.method.memory import H_LIMIT, H_PAST, H_VARIANT, NUMBERS, SMOOTH, H


def lengths(variant, steps):
    """Numbers of a run after whole steps, each a length and its error."""
    real, count = np.zeros(NUMBERS), np.zeros(64, dtype=int)
    real[H_LIMIT] = np.inf
    for h, error in steps:
        control.after_whole(real, count, variant, h, error)
    return real, count


@pytest.mark.parametrize("variant", [0, 1, 2])
def test_a_step_after_an_event_begins_with_what_served_last_in_its_mode(variant):
    real, count = lengths(variant, [(1e-4, 0.2)])
    assert real[H] == pytest.approx(1e-4 * control.SAFETY * 0.2 ** (-1 / 8))
    assert [real[H_VARIANT + n] > 0 for n in range(3)] == [n == variant for n in range(3)]
    assert control.restarted(1.0, real[H_VARIANT + variant], 0.0) == real[H]
    assert control.restarted(1.0, real[H_VARIANT + (variant + 1) % 3], 0.0) == 1.0
    assert (real[H_PAST], count[SMOOTH]) == (1e-4, 1)


@pytest.mark.parametrize("error", [1.5, 1e3, 1e12, np.inf])
def test_a_rejected_step_is_tried_again_shorter_but_by_a_tenth_at_most(error):
    """Also where two errors of one step after the other have shown a high order."""
    real = np.zeros(NUMBERS)
    assert 0.1 <= control.shorter(real, 1.0, 1e15 * error) / 1.0 <= 0.5
    assert 0.1 <= control.shorter(real, 0.1, error) / 0.1 < 1.0


def test_what_was_kept_short_by_something_else_is_no_length_that_served():
    real, _ = lengths(1, [(1e-4, 0.2), (1e-9, 1e-10)])
    assert real[H] < 1e-8
    assert control.restarted(1.0, real[H_VARIANT + 1], 0.0) > 9e-5


def test_an_event_with_a_transient_has_its_own_length():
    assert control.restarted(1.0, 1e-4, 1e-6) == 1e-6
    assert control.restarted(1.0, 1e-6, 1e-4) == 1e-6
