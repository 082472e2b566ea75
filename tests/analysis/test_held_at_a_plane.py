"""Sections at a level at which a quantity is held, which it touches, or at which it lies: it passes none."""

import numpy as np
import pytest

import jointplay as jp

SHAKEN = {"states": {"x": 0.1, "v": 0.2}, "forcing": "2*pi/1.3"}


@pytest.mark.parametrize("rtol", [1e-6, 1e-8, 1e-10])
@pytest.mark.parametrize("direction", ["up", "down"])
def test_a_wall_is_touched_and_not_passed(rtol, direction):
    rates = {"x": "v", "v": "-x-0.2*v+1.6*cos(1.3*t)"}
    walls = [{"name": "w", "gap": "0.6-x", "restitution": "0.7"}]
    own = jp.System(name="s", rates=rates, impacts=walls, **SHAKEN)
    plane = jp.Plane(quantity="x", value=0.6, direction=direction)
    assert jp.simulate(own, transient=20, turns=40)["contacts_begun"] >= 40
    assert jp.poincare(own, section=plane, transient=20, turns=40, rtol=rtol).sizes["turn"] == 0


@pytest.mark.parametrize("rtol", [1e-6, 1e-8, 1e-10])
def test_what_sticks_passes_the_plane_as_often_as_it_turns_back(rtol):
    friction = [{"name": "f", "speed": "v", "normal": "1", "coefficient": "0.8"}]
    rates = {"x": "v", "v": "-x+A*cos(1.3*t)"}
    own = jp.System(name="s", rates=rates, friction=friction, parameters={"A": 0.9}, **SHAKEN)
    run = jp.words(jp.simulate(own, transient=40, turns=20))
    assert np.sum(run["event_kind"].values == "stick_onset") == 40
    for direction in ("up", "down"):
        plane = jp.Plane(quantity="v", value=0.0, direction=direction)
        assert jp.poincare(own, section=plane, transient=40, turns=20, rtol=rtol).sizes["turn"] == 20


@pytest.mark.parametrize("rtol", [1e-8, 1e-10])
def test_a_journal_at_rest_in_a_rigid_bearing_makes_no_points(rtol):
    bearing = jp.catalog.slider_crank(clearance={"B": 1e-4}, speed=60.0, gravity=9.8)
    rigid = jp.Contact(law="restitution", parameters={"restitution": 0.5})
    joints = [
        jp.Joint(**dict(each) | ({"contact": rigid} if each.name == "B" else {})) for each in bearing.joints
    ]
    hard = jp.Mechanism(**dict(bearing) | {"joints": joints})
    run = jp.words(jp.simulate(hard, transient=5, turns=10, rtol=rtol))
    hits = np.sum(run["event_kind"].values == "impact")
    assert "rest" in run["event_kind"].values
    for quantity, most in {"normal_velocity": hits + 1, "penetration": 1}.items():
        plane = jp.Plane(quantity=quantity, joint="B", value=0.0, direction="down")
        assert jp.poincare(hard, section=plane, transient=5, turns=10, rtol=rtol).sizes["turn"] <= most


def test_a_speed_that_is_imposed_never_passes_itself():
    own = jp.catalog.slider_crank(clearance={"B": 1e-4}, speed=60.0)
    plane = jp.Plane(quantity="angular_velocity", link="crank", value=60.0, direction="up")
    assert jp.poincare(own, section=plane, turns=5).sizes["turn"] == 0
