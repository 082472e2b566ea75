"""Positions of links from their angles: those of Newton's method, and joints as far open as recorded."""

import numpy as np
import pytest

from jointplay import catalog
from jointplay.display.errors import InputError
from jointplay.solver.mechanism.loops.ideal import Closure, ideal_configuration
from jointplay.solver.mechanism.loops.positions import origins, pin_positions
from jointplay.solver.mechanism.records import Mechanism


@pytest.mark.parametrize("slides", [True, False])
def test_a_slider_crank_s_links_are_where_newton_s_method_puts_them(slides):
    mechanism = catalog.slider_crank(offset=0.01)
    states = [ideal_configuration(mechanism, angle, 1.0) for angle in np.linspace(0.1, 6.0, 7)]
    angles = {name: np.array([state.angles[name] for state in states]) for name in states[0].angles}
    closure, guide = Closure(mechanism), mechanism.joint("G")
    coordinates = [closure.rough(state.angles, {}) for state in states]
    along = np.array([closure.slide(x, guide)[0] for x in coordinates])
    found = origins(mechanism, angles, slides={"G": along} if slides else None)
    for name, places in found.items():
        np.testing.assert_allclose(places, [state.points[name][0] for state in states], atol=1e-12)


def test_a_journal_is_as_far_from_its_bearing_as_recorded():
    mechanism = catalog.quick_return()
    state = ideal_configuration(mechanism, 1.0, 1.0)
    angles = {name: np.array([angle]) for name, angle in state.angles.items()}
    places = origins(mechanism, angles)
    for joint in mechanism.joints:
        ends = (pin_positions(pin, angles, places) for pin in (joint.journal, joint.bearing))
        if not joint.prismatic:
            np.testing.assert_allclose(np.subtract(*ends), 0.0, atol=1e-12)
    loose = catalog.slider_crank(clearance={"B": 1e-4})
    away = np.array([[3e-5, -4e-5]])
    state = ideal_configuration(loose, 0.7, 1.0)
    angles = {name: np.array([angle]) for name, angle in state.angles.items()}
    slide = {"G": np.array([state.points["slider"][0][0] - 3e-5])}
    moved = origins(loose, angles, {"B": away}, slide)
    joint = loose.joint("B")
    ends = [pin_positions(pin, angles, moved) for pin in (joint.journal, joint.bearing)]
    np.testing.assert_allclose(
        moved["slider"][:, 0], slide["G"] + loose.joint("G").bearing.point[0], atol=2e-5
    )
    np.testing.assert_allclose(ends[0] - ends[1], away, atol=4e-5)


def test_a_place_that_hangs_on_a_slide_needs_it():
    links = [{"name": "cart", "length": 0.1, "mass": 1.0, "inertia_centre": 1e-3, "centre": 0}]
    guide = {
        "name": "G",
        "kind": "prismatic",
        "journal": {"link": "cart"},
        "bearing": {"link": "ground", "point": [0, 0]},
    }
    mechanism = Mechanism(name="cart", links=links, joints=[guide])
    angles = {"cart": np.zeros(2)}
    assert origins(mechanism, angles, slides={"G": np.array([0.1, 0.2])})["cart"][:, 0] == pytest.approx(
        [0.1, 0.2]
    )
    with pytest.raises(InputError, match="no slide_position'; a response that records slide_position is"):
        origins(mechanism, angles)
