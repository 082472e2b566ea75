"""Order of convergence by regression, on a smooth stretch and across events.

The gear pair's forces are piecewise linear: Newton's iteration costs no accuracy at any step, so that steps
can be long enough for the error to rise above rounding. The fit takes errors between FLOOR, thirty times
the rounding of some tens of steps, and CEILING: above it, where h omega reaches 3, terms beyond the leading
one bend the line.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm

from jointplay.solver.mechanism import catalog

from .fixed import follow

FLOOR, CEILING = 3e-13, 1e-8
ORDER = 13
DURATION = 20.0
STEPS = range(6, 19)


def order(errors):
    """Slope of log error over log h."""
    h, error = np.array(list(errors)).T
    within = (error > FLOOR) & (error < CEILING)
    assert within.sum() >= 6
    return np.polyfit(np.log(h[within]), np.log(error[within]), 1)[0]


def smooth():
    """In contact throughout: x'' + 2 zeta x' + x - 1 = F_m, against the exact solution."""
    system = catalog.gear_backlash(mean_load=1.0, amplitude=0.0, frequency=0.1, damping=0.05)
    start = np.array([1.8, 0.3])
    exact = [2.0, 0.0] + expm(DURATION * np.array([[0.0, 1.0], [-1.0, -0.1]])) @ (start - [2.0, 0.0])
    for n in STEPS:
        state, counts = follow(system, DURATION, DURATION / n, start)
        assert counts == [n, 0, 0, counts[3], 0]
        yield DURATION / n, np.abs(state - exact).max()


def across_events():
    """Five contacts and separations, against steps a hundred times smaller."""
    system = catalog.gear_backlash(mean_load=0.1, amplitude=50.0, frequency=0.1, damping=0.05)
    reference, counts = follow(system, DURATION, 0.02)
    assert counts[4] == 5
    for n in STEPS:
        state, counts = follow(system, DURATION, DURATION / n)
        assert counts[4] == 5
        yield DURATION / n, np.abs(state - reference).max()


@pytest.mark.parametrize("errors", [smooth, across_events])
def test_order(errors):
    assert order(errors()) == pytest.approx(ORDER, abs=0.7)


def test_events_cost_no_order():
    assert abs(order(smooth()) - order(across_events())) < 0.6
