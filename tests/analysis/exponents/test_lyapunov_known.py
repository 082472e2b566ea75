"""Exponents against closed forms, published values, and what must hold of every spectrum."""

import math

import numpy as np
import pytest

import jointplay as jp
from jointplay import catalog
from jointplay.solver.mechanism.assemble import assemble
from tests.analysis.exact_maps import TAU, Symmetric
from tests.support.driven_scenes import own
from tests.support.tangent_map import tangent_map

CHAOS = {  # system, keywords, exponents and their errors; published ones are rounded
    "lorenz": (catalog.lorenz(), {"duration": 1500, "transient": 50}, [0.9056, 0, -14.5723], 1e-4),
    "rossler": (catalog.rossler(), {"duration": 3000, "transient": 100}, [0.0714, 0, -5.3943], 1e-4),
    "jerk": (
        catalog.jerk(),
        *({"duration": 100_000, "transient": 500, "initial": (0.1, 0.1, 0.1)}, [0.0362, 0, -0.6362], 1e-4),
    ),
    "duffing": (catalog.duffing(), {"turns": 2000, "transient": 50}, [0.1589, -0.3589], 1e-4),
    "impacts": (
        catalog.impact_pair(0.4, 0.8),
        *({"turns": 2000, "transient": 50, "initial": (0.05, 0.7)}, [0.23792, -0.58033], 1.2e-4),
    ),
    "other_impacts": (
        catalog.impact_pair(0.6, 0.6),
        *({"turns": 2000, "transient": 50, "initial": (0.05, 0.7)}, [0.11341, -0.76381], 6e-5),
    ),
    "gears": (
        catalog.gear_backlash(0.1, 0.2, 1.6, 0.05),
        *({"turns": 4000, "transient": 100}, [0.110, -0.210], 1e-3),
    ),
    "slow_gears": (
        catalog.gear_backlash(0.1, 0.2, 0.9, 0.05),
        *({"turns": 4000, "transient": 100}, [0.0103, -0.1103], 3e-4),
    ),
}


def within(system, keywords, known, error):
    """Compare within three combined standard errors; the sum rule."""
    found = jp.lyapunov(system, exponents="all", **keywords)
    assert int(found.status) == 0
    combined = np.hypot(found.lyapunov_standard_error, error)
    assert np.all(np.abs(found.lyapunov_exponent - known) < 3 * combined)
    assert float(found.sum_residual) < 1e-6 * abs(float(found.mean_divergence))
    return found


@pytest.mark.long
@pytest.mark.parametrize("name", CHAOS)
def test_chaos(name):
    found = within(*CHAOS[name])
    assert np.all(found.lyapunov_standard_error < 0.03)
    assert np.all(np.diff(found.lyapunov_exponent) < 0)


@pytest.mark.nightly
@pytest.mark.parametrize("name", CHAOS)
def test_chaos_for_long(name):
    system, keywords, known, error = CHAOS[name]
    longer = {key: 20 * value for key, value in keywords.items() if key in ("turns", "duration")}
    found = within(system, keywords | longer, known, error)
    assert np.all(found.lyapunov_standard_error < 0.01)


def test_origin_of_lorenz():
    """A linear system's eigenvalues."""
    rho, transient = 0.5, 20
    found = jp.lyapunov(
        catalog.lorenz(rho=rho),
        exponents="all",
        duration=20,
        transient=transient,
        initial=(0, 0, 0),
        rtol=1e-14,
    )
    root = math.sqrt(121 - 40 * (1 - rho))
    expected = sorted([-8 / 3, (-11 + root) / 2, (-11 - root) / 2], reverse=True)
    assert float(found.lyapunov_exponent[0]) == pytest.approx(expected[0], rel=1e-10)
    assert found.lyapunov_exponent.values == pytest.approx(expected, rel=2e-9)


def test_a_stable_focus():
    """Its real part: Lorenz at rho = 20. Vectors turn about each other; means converge as 1/T."""
    found = jp.lyapunov(catalog.lorenz(rho=20.0), exponents="all", duration=2000, transient=200)
    assert found.lyapunov_exponent.values[:2] == pytest.approx(-0.1548, abs=2e-3)


@pytest.mark.parametrize("gap", [2.92, 28.3])
def test_symmetric_motion_with_real_multipliers(gap):
    motion = Symmetric(gap, 0.8)
    trace, determinant = motion.half_map
    roots = np.sort(np.abs(np.roots([1, -trace, determinant])))[::-1]
    assert roots[0] > 1.1 * roots[1]
    found = jp.lyapunov(
        catalog.impact_pair(gap, 0.8),
        exponents=2,
        turns=10,
        transient=150,
        initial=motion.at_zero,
        rtol=1e-13,
    )
    assert found.lyapunov_exponent.values == pytest.approx(np.log(roots) / math.pi, abs=1e-10)


@pytest.mark.parametrize("gap", [3.6, 10.0])
def test_symmetric_motion_by_its_monodromy(gap):
    """Complex multipliers turn the frame; over one period the tangent map has them exactly."""
    motion = Symmetric(gap, 0.8)
    trace, determinant = motion.half_map
    model = assemble(catalog.impact_pair(gap, 0.8), motion.at_zero)
    found = np.sort(np.abs(np.linalg.eigvals(tangent_map(model, TAU, rtol=1e-13))))
    expected = np.sort(np.abs(np.roots([1, -trace, determinant])) ** 2)
    assert found == pytest.approx(expected, abs=1e-10)
    mean = jp.lyapunov(catalog.impact_pair(gap, 0.8), exponents=2, turns=500, initial=motion.at_zero)
    assert mean.lyapunov_exponent.values == pytest.approx(np.log(expected) / TAU, abs=2e-3)


def test_gears_lose_volume_at_the_rate_of_their_damping():
    system = catalog.gear_backlash(0.1, 0.2, 1.6, 0.05)
    found = jp.lyapunov(system, exponents=2, turns=100, rtol=1e-11)
    assert float(found.lyapunov_exponent.sum()) == pytest.approx(-0.1, rel=1e-8)


def test_without_saltation_impacts_hide_chaos():
    """Flight and reset matrices alone are triangular: the largest exponent is 0, whatever the gap."""
    keywords = {"turns": 1000, "transient": 20, "initial": (0.05, 0.7)}
    found = jp.lyapunov(catalog.impact_pair(0.4, 0.8), saltation=False, **keywords)
    assert abs(float(found.lyapunov_exponent[0])) < 0.01


def test_a_pulling_wall_hides_a_missing_jump_but_a_pushing_one_does_not():
    right, wrong = (
        jp.lyapunov(
            catalog.soft_impact_pair(1.0, 50.0, 2.0, tension=False), turns=500, transient=50, saltation=on
        )
        for on in (True, False)
    )
    difference = abs(float((right.lyapunov_exponent - wrong.lyapunov_exponent)[0]))
    assert difference > 10 * float(right.lyapunov_standard_error[0])


def test_along_a_switch_the_exponent_is_that_of_what_moves_there():
    """x reaches 0 and slides there for good; y, which it drives no more, shrinks as exp(-c t)."""
    system = own(
        states={"x": 0.3, "y": 0.2},
        parameters={"w": 1.0, "c": 2.5},
        rates={"x": "1.5 - 3*above + 0.3*sin(w*t)", "y": "-c*y + cos(w*t) + 0.1*above"},
        switches=[{"name": "above", "on": "x", "slides": True}],
        forcing="2*pi/w",
    )
    found = jp.lyapunov(system, exponents=2, transient=10, turns=60)
    assert found.lyapunov_exponent.values[0] == pytest.approx(-2.5, rel=1e-6)
    assert math.isinf(found.lyapunov_exponent.values[1])
