"""Extreme values at an impact, of whose two sides one has them; slopes of angles; starts of systems."""

import numpy as np
import pytest

import jointplay as jp
from jointplay import catalog
from jointplay.analysis.gradients.gradient import STEP, _atan2, _start
from tests.support import driven


def extreme(how, **numbers):
    system = catalog.impact_pair(**{"gap": 3.0, "restitution": 0.8} | numbers)
    run = {"turns": 3, "initial": [0.0, 0.3]}
    return jp.gradient(system, of=[f"{how}:state:v"], by=["gap", "restitution"], **run)


@pytest.mark.parametrize("how", ["largest", "smallest"])
def test_the_fastest_moment_is_just_before_or_after_an_impact(how):
    """Speeds jump there; against the values of systems beside it."""
    found = extreme(how)
    assert int(found["derivative_status"]) == 0
    assert 0.1 < found["grazing"] <= 1.0  # the slowest impact, over the fastest
    assert np.isnan(found["closest_approach"]) or found["closest_approach"] > 0
    for name, exact in zip(("gap", "restitution"), found["derivative"].values[0], strict=True):
        usual = {"gap": 3.0, "restitution": 0.8}[name]
        quotient = driven.quotient(
            lambda x, name=name: extreme(how, **{name: x})["value"].item(), usual, 1e-5
        )
        assert exact == pytest.approx(quotient, rel=1e-6)


def test_the_start_of_a_system_is_its_own_where_it_was_changed():
    usual = catalog.duffing()
    other = usual.replace(initial=[0.3, 0.1])
    assert _start(usual, None) is None
    assert [*_start(other, None)] == [0.3, 0.1]
    assert _start(other, [0.0, 0.0]) == [0.0, 0.0]


def test_the_slope_of_an_angle_by_a_complex_step_is_across_over_the_square_of_the_distance():
    angle = _atan2(np.array([3.0 + 0.5j * STEP]), np.array([4.0 + 0.25j * STEP]))
    assert angle.real == pytest.approx([np.arctan2(3, 4)])
    assert angle.imag / STEP == pytest.approx([(4 * 0.5 - 3 * 0.25) / 25])
