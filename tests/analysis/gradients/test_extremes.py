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


def test_a_step_that_ends_beside_the_top_does_not_bound_it():
    """Every second tolerance once found a place 0.6 microseconds before it: the derivative was 4 % off."""
    given = {"of": ["largest:normal_force:B"], "by": ["joints.B.clearance"], "turns": 1}
    linkage = catalog.chunmei2002(clearance={"B": 2e-4}, gear_ratio=3.0)
    times = np.linspace(1.593e-3, 1.595e-3, 2001)
    settings = {"duration": 2e-3, "at": times, "record": ["normal_force"], "rtol": 1e-12}
    forces = jp.simulate(linkage, **settings)["normal_force"]
    for rtol in (1e-8, 1e-9, 1e-10, 1e-11):
        found = jp.gradient(linkage, **given, rtol=rtol)
        assert found["value"].item() == pytest.approx(float(forces.max()), rel=1e-8)
        assert found["derivative"].item() == pytest.approx(581867.18, rel=1e-6)  # by differences of the above


STARTS = {  # at which something changes, and what moves off it
    "friction": (
        {"friction": [{"name": "f", "speed": "v", "normal": "1", "coefficient": "mu"}]},
        (0.0, 0.0),
        "v",
    ),
    "switch": ({"switches": [{"name": "s", "on": "x"}]}, (0.0, 0.5), "x"),
    "contact": ({"contacts": [{"name": "c", "depth": "x", "force": "2*depth+speed"}]}, (0.0, 0.5), "x"),
}


@pytest.mark.parametrize("part", STARTS)
def test_a_start_where_something_changes_has_no_derivative_to_both_sides(part):
    parts, (x, v), moved = STARTS[part]
    force = "a*cos(t)-0.2*x" + "-s" * (part == "switch")
    numbers = {"a": 1.0, "mu": 0.3}
    own = jp.System(
        name=part,
        states={"x": x, "v": v},
        parameters=numbers,
        rates={"x": "v", "v": force},
        forcing="2*pi",
        **parts,
    )
    with pytest.warns(jp.ModelWarning, match="differ by side"):
        found = jp.gradient(own, of=["end:state:x"], by=[f"initial.{moved}", "a"], turns=1)
    assert np.isnan(found["derivative"].values[0, 0])
    aside = 1e-5 * np.array([moved == "x", moved == "v"])
    starts = (np.array([x, v]) + k * aside for k in (-1, 0, 1))
    ends = [jp.simulate(own, turns=1, initial=[*each], rtol=1e-12)["end_state"].values[0] for each in starts]
    below, above = np.diff(ends) / 1e-5
    assert abs(above - below) > 0.05
    near = (own.replace(a=a) for a in (1.0001, 0.9999))
    more, less = (jp.simulate(each, turns=1, rtol=1e-12)["end_state"].values[0] for each in near)
    assert found["derivative"].values[0, 1] == pytest.approx((more - less) / 2e-4, rel=1e-3)


@pytest.mark.parametrize("asked", [jp.gradient, jp.optimise])
def test_a_transient_is_of_an_orbit_alone(asked):
    linkage = catalog.slider_crank(clearance={"B": 1e-4}, speed=60.0)
    peak = "largest:normal_force:B"
    given = {"of": [peak], "by": ["gravity"]}
    if asked is jp.optimise:
        given = {"least": peak, "by": {"gravity": (9.0, 10.0)}, "orbit": False}
    with pytest.raises(jp.InputError, match="begins at the start"):
        asked(linkage, transient=60, **given)


def test_tops_at_one_time_are_followed_together():
    linkage = catalog.chunmei2002(clearance={"B": 2e-4}, gear_ratio=3.0).replace(friction=0.1)
    names = ["largest:normal_force:B", "largest:tangential_force:B"]  # proportional
    both = jp.gradient(linkage, of=names, by=["gravity"], turns=1, rtol=1e-11)
    assert jp.words(both)["status"] == "ok"
    np.testing.assert_allclose(both["derivative"].values[1] / both["derivative"].values[0], 0.1, rtol=1e-6)
