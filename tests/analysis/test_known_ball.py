"""The bouncing ball: one bounce a period between its two closed-form limits, twice that beyond the second."""

import math

import numpy as np
import pytest

import jointplay as jp
from jointplay import catalog
from jointplay.analysis.quantities import EVENTS

from .exact_maps import TAU, distinct

RESTITUTION = 0.5
GAMMA_SN = math.pi * (1 - RESTITUTION) / (1 + RESTITUTION)
GAMMA_PD = math.hypot(GAMMA_SN, 2 * (1 + RESTITUTION**2) / (1 + RESTITUTION) ** 2)
OK = 0


class Bounce:
    """The motion with impacts at t0 + 2 pi n, each leaving the table at pi / Gamma in the fixed frame."""

    def __init__(self, acceleration):
        self.gamma = acceleration
        self.t0 = math.acos(GAMMA_SN / acceleration)

    @property
    def at_zero(self):
        """State at time 0."""
        flown = TAU - self.t0
        height = math.sin(self.t0) + flown * math.pi / self.gamma - flown**2 / (2 * self.gamma)
        return height, (math.pi - flown) / self.gamma


def test_limits():
    assert pytest.approx((1.0471975511966, 1.5268237005191), rel=1e-12) == (GAMMA_SN, GAMMA_PD)


@pytest.mark.parametrize("acceleration", [1.06, 1.2, 1.35, 1.5])
def test_one_bounce_a_period(acceleration):
    exact = Bounce(acceleration)
    found = jp.simulate(
        catalog.bouncing_ball(acceleration, RESTITUTION),
        turns=20,
        initial=exact.at_zero,
        rtol=1e-12,
        at=TAU * np.arange(1, 21),
    )
    assert int(found.status) == OK
    assert found.event_time.values == pytest.approx(exact.t0 + TAU * np.arange(20), abs=1e-10)
    assert found.state_value.values == pytest.approx(np.tile(exact.at_zero, (20, 1)), abs=1e-10)


def test_restitution_is_relative_to_the_table():
    found = jp.simulate(catalog.bouncing_ball(1.4, RESTITUTION), turns=20, steps=True)
    time, (y, v) = found.time.values, found.state_value.values.T
    at = np.flatnonzero(np.diff(time) == 0)
    assert len(at) == found.sizes["event"] > 15
    table = np.cos(time[at])
    assert v[at + 1] - table == pytest.approx(-RESTITUTION * (v[at] - table), rel=1e-14)
    assert y[at] == pytest.approx(np.sin(time[at]), abs=1e-12)


def settled(acceleration):
    height, speed = Bounce(acceleration).at_zero
    ball = catalog.bouncing_ball(acceleration, RESTITUTION)
    return jp.poincare(ball, turns=24, transient=400, initial=(height + 0.01, speed))


@pytest.mark.parametrize(("share", "points"), [(0.02, 1), (0.5, 1), (0.97, 1), (1.1, 2)])
def test_period_doubles_at_its_limit(share, points):
    acceleration = GAMMA_SN + share * (GAMMA_PD - GAMMA_SN)
    section = settled(acceleration)
    assert int(section.status) == OK
    assert distinct(section) == points
    if points == 1:
        assert section.state_value.values[-1] == pytest.approx(Bounce(acceleration).at_zero, abs=1e-8)


def test_below_the_first_limit_the_ball_comes_to_rest():
    """Where the table's acceleration does not exceed gravity, impacts accumulate from any start."""
    found = jp.simulate(catalog.bouncing_ball(0.9, RESTITUTION), turns=50, initial=(3.0, 0.0))
    assert int(found.status) == OK
    assert EVENTS[int(found.event_kind[-1])] == "rest"
    assert found.sizes["event"] < 100


def test_section_at_the_impacts():
    ball = catalog.bouncing_ball(1.2, RESTITUTION)
    section = jp.poincare(ball, jp.ContactSection(), turns=5, initial=Bounce(1.2).at_zero, rtol=1e-12)
    assert section.time.values == pytest.approx(Bounce(1.2).t0 + TAU * np.arange(5), abs=1e-10)
    assert section.state_value.sel(state="v").values == pytest.approx(math.pi / 1.2, abs=1e-10)
