"""Bifurcation diagrams against closed forms: limits in the gap, coexisting motions, period doubling."""

import math

import numpy as np
import pytest

import jointplay as jp
from jointplay import catalog
from tests.analysis.exact_maps import Symmetric, strobed, symmetry_lost

OK, CHATTER = 0, 3


def off(found, restitution):
    """Distance of each point's last section point from the symmetric motion; NaN where there is none."""
    fold = Symmetric(1.0, restitution).fold
    exact = [
        Symmetric(g, restitution).at_zero if g < fold else (math.nan, math.nan) for g in found.gap.values
    ]
    return np.abs(found.state_value.isel(point=-1, direction=0).values - exact).max(axis=1)


@pytest.mark.parametrize("restitution", [0.6, 0.8])
def test_the_symmetric_motion_is_left_at_its_limit(restitution):
    limit = symmetry_lost(restitution)
    gaps = limit + 0.02 * np.arange(-4.5, 5.0)
    begin = Symmetric(gaps[-1], restitution).at_zero
    found = jp.bifurcation(
        catalog.impact_pair(3.0, restitution),
        over={"gap": gaps},
        direction="down",
        initial=begin,
        transient=400,
        turns=20,
        n_jobs=1,
    )
    away = off(found, restitution)
    assert (found.cell_status == OK).all()
    assert (away[gaps > limit] < 1e-4).all()  # the nearest one settles slowly
    assert (away[gaps > limit][1:] < 1e-9).all()
    assert (away[gaps < limit] > 0.05).all()
    symmetric = found.isel(gap=slice(6, None), direction=0)
    assert (symmetric.period == 1).all()
    assert (symmetric.impacts == 2).all()
    assert (symmetric.separations == 2).all()
    assert set(symmetric.mode_word.values) <= {"ul", "lu"}
    speeds = [Symmetric(g, restitution).speed for g in symmetric.gap.values]
    assert symmetric.smallest_impact_speed.values == pytest.approx(speeds, rel=1e-8)
    assert (symmetric.contact_fraction == 0).all()


def test_the_symmetric_motion_ends_at_its_fold_and_the_way_back_is_another():
    fold = Symmetric(1.0, 0.6).fold
    gaps = fold + 0.05 * np.arange(-3.5, 3.0)
    found = jp.bifurcation(
        catalog.impact_pair(3.0, 0.6),
        over={"gap": gaps},
        direction=("up", "down"),
        initial=Symmetric(gaps[0], 0.6).at_zero,
        transient=100,
        turns=20,
        n_jobs=1,
    )
    up, down = (found.sel(direction=[way]) for way in ("up", "down"))
    there = gaps < fold
    assert (off(up, 0.6)[there] < 1e-9).all()
    assert (up.period.values[there] == 1).all()
    beyond = up.isel(gap=~there)
    assert not (np.isin(beyond.mode_word, ["ul", "lu"]) & (beyond.period == 1)).any()
    assert not (off(down, 0.6)[there] < 1e-3).any()


def test_motions_that_coexist_are_found_from_their_starts():
    starts = [strobed(3.6, 0.8, (time, -1.8, speed), 1) for time, speed in ((2.0, 0.5), (1.0, 1.3))]
    found = jp.bifurcation(
        catalog.impact_pair(1.0, 0.8),
        over={"gap": [3.6]},
        direction="reset",
        starts=starts,
        transient=400,
        turns=30,
        exponents=2,
        lyapunov_turns=400,
        rtol=1e-9,
        n_jobs=1,
    ).squeeze(("gap", "direction"))
    assert found.period.values.tolist() == [1, 3]
    assert found.sizes["start"] == 2
    one = found.isel(start=0)
    off = (one.lyapunov_exponent - math.log(0.8) / math.pi) / one.lyapunov_standard_error
    assert (np.abs(off) < 3).all()  # complex multipliers: both exponents are the same
    assert (one.lyapunov_standard_error < 2e-3).all()
    assert (
        found.isel(start=1).lyapunov_exponent.values > -0.02
    ).any()  # it is nearly lost: a motion of its own
    per_turn = one.lyapunov_exponent_per_turn / one.lyapunov_exponent
    assert per_turn.values == pytest.approx(2 * math.pi)


def test_the_period_of_the_bouncing_ball_doubles_where_it_should():
    a = 0.5
    saddle = math.pi * (1 - a) / (1 + a)
    doubling = math.sqrt(saddle**2 + (2 * (1 + a**2) / (1 + a) ** 2) ** 2)
    values = doubling + 0.012 * np.array([-6, -4, -2, -1, 1, 2, 4, 6])
    found = jp.bifurcation(
        catalog.bouncing_ball(1.2, a),
        over={"acceleration": values},
        direction=("up", "down"),
        transient=1500,
        turns=40,
        n_jobs=1,
    )
    assert found.period.transpose("direction", ...).values.tolist() == [[1] * 4 + [2] * 4] * 2
    assert (found.impacts == 1).all()
    assert found.mode_word.values[0, 0] == "t"
    assert found.mode_word.values[-1, 0] == "t t"
    closing = 2 * math.pi / (values[:4] * (1 + a))  # speed of one bounce a period, relative to the table
    assert found.smallest_impact_speed.values[:4, 0] == pytest.approx(closing, rel=1e-6)


def test_the_gear_pair_has_the_periods_that_it_should():
    found = jp.bifurcation(
        catalog.gear_backlash(0.1, 0.2, 0.8, 0.05),
        over={"frequency": [0.8, 1.0, 1.6]},
        direction="reset",
        transient=400,
        turns=60,
        n_jobs=1,
    ).isel(direction=0)
    assert found.period.values.tolist() == [2, 4, 0]
    assert found.turn_period.values == pytest.approx(2 * math.pi / found.frequency.values)
    assert (found.contact_fraction > 0.05).all()
    assert (found.contact_fraction < 0.95).all()
    assert found.mode_word.values[0].count(" ") == 1
    assert set(found.mode_word.values[0]) <= {"d", "c", " ", "."}


def test_a_period_is_that_of_all_states():
    """A forced one follows its forcing, two others turn about each other at half its frequency."""
    rates = {"x": "-x + sin(w*t)", "u": "w*v/2", "v": "-w*u/2"}
    states = {"x": 0.0, "u": 1.0, "v": 0.0}
    turning = jp.System(states=states, parameters={"w": 2.0}, rates=rates, forcing="2*pi/w")
    found = jp.bifurcation(turning, over={"w": [2.0, 3.0]}, transient=40, turns=12, n_jobs=1)
    assert (found.period == 2).all()
