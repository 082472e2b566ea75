"""The period of a motion from its section points."""

import math

import numpy as np
import pytest

import jointplay as jp
from jointplay import catalog
from jointplay.analysis.period import period
from jointplay.display.errors import InputError

from .exact_maps import strobed

GEAR = {"mean_load": 0.1, "amplitude": 0.2, "damping": 0.05}
TOLERANCE = 1e-6


def section(system, **start):
    return jp.poincare(system, turns=48, transient=400, **start).state_value.values


@pytest.mark.parametrize(("frequency", "expected"), [(0.8, 2), (1.0, 4), (1.6, 0)])
def test_gear_pair(frequency, expected):
    assert period(section(catalog.gear_backlash(frequency=frequency, **GEAR)), TOLERANCE) == expected


@pytest.mark.parametrize(("time", "speed", "expected"), [(2.0, 0.5, 1), (1.0, 1.3, 3)])
def test_coexisting_motions_of_the_impact_pair(time, speed, expected):
    start = strobed(3.6, 0.8, (time, -1.8, speed), 1)
    assert period(section(catalog.impact_pair(3.6, 0.8), initial=start), TOLERANCE) == expected


def test_chaos_has_none():
    assert period(section(catalog.impact_pair(0.4, 0.8), initial=(0.05, 0.7)), TOLERANCE) == 0


@pytest.mark.parametrize(("amplitude", "expected"), [(0.1, 1), (0.3, 0)])
def test_duffing(amplitude, expected):
    assert period(section(catalog.duffing(amplitude=amplitude)), TOLERANCE) == expected


@pytest.mark.parametrize("p", [1, 2, 3, 5, 12])
def test_the_smallest_period_is_found_within_the_tolerance(p):
    rng = np.random.default_rng(p)
    places = rng.standard_normal((p, 2))
    points = np.tile(places, (60 // p, 1)) + rng.uniform(-0.5e-3, 0.5e-3, (60 // p * p, 2))
    assert period(points, 1e-3) == p
    assert period(points, 0.5e-3) == 0
    assert period(points, 1e-3, longest=p) == p
    assert period(points, 1e-3, longest=p - 1) == 0


def test_every_coordinate_must_repeat():
    points = np.stack([np.zeros(40), np.arange(40) % 2], axis=1)
    assert period(points, 1e-3) == 2
    assert period(points[:, 0], 1e-3) == 1


def test_a_slow_drift_is_no_period():
    """Neighbouring points agree, but the first and the last do not."""
    assert period(np.linspace(0, 1, 401), 0.01) == 0


@pytest.mark.parametrize("factor", [-0.98, -0.995, -0.998, -1.01])
def test_an_alternation_that_fades_or_grows_is_no_period_of_two(factor):
    """Within the tolerance the even points agree, and the odd ones: about a place that is neared or left."""
    points = 0.01 * (factor if factor < -1 else 1.0) ** -40.0 * factor ** np.arange(41)
    spread = max(np.ptp(points[rest::2]) for rest in (0, 1))
    assert period(points, 1.01 * spread) == 0
    assert period(points, 2.1 * np.abs(points).max()) == 1


@pytest.mark.parametrize("p", [2, 4, 6])
def test_places_that_are_still_neared_are_apart(p):
    """A motion that settles on p places has that period as soon as it is within the tolerance."""
    places = 1e-3 * np.cos(np.arange(p) * 2.4)
    points = np.tile(places, 20) + 2e-4 * 0.97 ** np.arange(20 * p) * np.tile((-1.0) ** np.arange(p), 20)
    assert period(points, 2.1e-4) == p


def test_a_quasiperiodic_motion_has_none():
    angle = np.arange(400) * math.tau * (math.sqrt(5) - 1) / 2
    assert period(np.stack([np.cos(angle), np.sin(angle)], axis=1), 0.01) == 0


def test_a_period_must_come_back_four_times():
    assert period(np.tile([0.0, 1.0, 2.0], 4), 1e-9) == 3
    assert period(np.tile([0.0, 1.0, 2.0], 3), 1e-9) == 0


def test_a_point_that_is_not_finite():
    assert period(np.array([0.0] * 8 + [math.nan]), 1e-3) == 0
    assert period(np.array([0.0, 1.0] * 7 + [0.0, math.nan]), 1e-3) == 0


@pytest.mark.parametrize("tolerance", [0.0, -1.0, math.nan])
def test_a_tolerance_that_is_none(tolerance):
    with pytest.raises(InputError, match="tolerance"):
        period(np.zeros(8), tolerance)
