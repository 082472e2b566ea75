"""Smooth test systems against an independent integration: SciPy's DOP853 at 1e-13."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import jointplay as jp
from jointplay import catalog


def lorenz(t, s):
    x, y, z = s
    return 10 * (y - x), x * (28 - z) - y, x * y - 8 / 3 * z


def rossler(t, s):
    x, y, z = s
    return -y - z, x + 0.2 * y, 0.2 + z * (x - 5.7)


def duffing(t, s):
    x, v = s
    return v, 0.3 * math.cos(t) - 0.2 * v + x - x**3


CASES = {"lorenz": (lorenz, 6.0, 40), "rossler": (rossler, 40.0, 4), "duffing": (duffing, 40.0, 4)}


@pytest.fixture(scope="module", params=CASES)
def case(request):
    rates, duration, growth = CASES[request.param]
    system, at = getattr(catalog, request.param)(), np.linspace(0, duration, 101)
    solved = solve_ivp(rates, (0, duration), system.initial, "DOP853", at, rtol=1e-13, atol=1e-14)
    return system, at, solved.y.T, growth


def trajectory(system, at, rtol):
    found = jp.simulate(system, duration=at[-1], at=at, rtol=rtol)
    assert int(found.status) == 0
    assert np.array_equal(found.time, at)
    return found.state_value.values


def test_trajectory(case):
    system, at, truth, growth = case
    error = np.abs(trajectory(system, at, 1e-12) - truth).max()
    assert error < 1e-10 * growth


def test_error_follows_the_tolerance(case):
    system, at, truth, growth = case
    for rtol in (1e-5, 1e-7, 1e-9):
        assert np.abs(trajectory(system, at, rtol) - truth).max() < 100 * growth * rtol


def test_parameters_by_name():
    system = catalog.duffing(frequency=1.3)
    swapped = dict(reversed(system.parameters.items()))
    ends = [
        jp.simulate(jp.TestSystem(**dict(system) | {"parameters": p}), turns=3).state_value.values
        for p in (system.parameters, swapped)
    ]
    assert np.array_equal(*ends)


@pytest.mark.parametrize("initial", [(1.0,), (1.0, math.inf), ("a", 0.0), 3.0, {"y": 1.0}])
def test_wrong_start(initial):
    with pytest.raises(jp.InputError, match="initial"):
        jp.simulate(catalog.duffing(), turns=1, initial=initial)


@pytest.mark.parametrize(("system", "start"), [("impact_pair", (2.0, 0.0)), ("bouncing_ball", (-0.1, 0.0))])
def test_start_beyond_a_wall(system, start):
    made = {
        "impact_pair": lambda: catalog.impact_pair(3.6, 0.8),
        "bouncing_ball": lambda: catalog.bouncing_ball(1.2, 0.5),
    }
    with pytest.raises(jp.InputError, match="inner side"):
        jp.simulate(made[system](), turns=1, initial=start)
