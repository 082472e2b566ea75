"""A block that lands flat in its guide and comes to rest on two corners, whose rows of friction are one."""

from __future__ import annotations

import math

import numpy as np
import pytest

import jointplay as jp
from jointplay.solver.mechanism.assemble import assemble
from tests.codegen.test_jacobian import agree
from tests.support.plain import Point, plain

MASS, PLAY, K = 0.5, 1e-4, 1e6
STILL = {"angle": {"block": 0.0}, "angular_velocity": {"block": 0.0}}
WORDS = ["normal_force", "tangential_force", "tangential_velocity", "slide_position", "mode"]
RESTS = [0, 0, 4, 4]  # both lower corners stick


def block(slope=0.0, centre=0.0):
    """A block in a guide on the ground; gravity leans by `slope`."""
    sizes = {"clearance": PLAY, "half_length": 0.02, "half_height": 0.01}
    guide = jp.Joint(
        name="G",
        kind="prismatic",
        journal={"link": "block"},
        bearing={"link": "ground", "point": (0.0, 0.0)},
        contact=jp.Contact(stiffness=K, damping=500.0),
        friction=jp.Friction(coefficient=0.3),
        **sizes,
    )
    link = jp.Link(name="block", length=0.04, mass=MASS, inertia_centre=2e-4, centre=centre)
    down = {"gravity": 9.81, "gravity_direction": slope - math.pi / 2}
    return jp.Mechanism(name="block", links=[link], joints=[guide], drive=None, **down)


@pytest.mark.parametrize(("tilt", "turning", "tolerance"), [(0.0, 0.0, 1e-11), (1e-7, 1e-6, 1e-6)])
def test_corners_in_line_share_friction_as_load(tilt, turning, tolerance):
    """Off its centre, so that loads differ: equal ratios, no sliding rate, and the exact Jacobian."""
    model = assemble(block(0.1, 0.003), STILL)
    functions, n = plain(model.structure), len(model.turning)
    place = {"theta_block": tilt, "x_0": 0.0, "y_0": -PLAY - 3e-6, "w_block": turning}
    state = np.array([place.get(name, 0.0) for name in functions.STATE[1:]])
    modes = ("free", "free", "stick", "stick")
    found = Point(functions, model.numbers, state, modes)
    rows, rates = found.contacts()[2:], found.rate()[:, 0]
    assert rows[:, 3].min() > 2.0
    left = 9.81 * math.sin(0.1) - rates[functions.STATE.index("vx_0") - 1 - n]
    assert rows[:, 4].sum() == pytest.approx(MASS * left, rel=1e-4)
    shares = rows[:, 4] / rows[:, 3]
    assert tilt or shares[0] == pytest.approx(shares[1], rel=1e-5)
    assert np.abs(rows[:, 5]).max() < 1e-13
    assert np.isfinite(rates).all()
    agree(lambda d: Point(functions, model.numbers, state + d, modes, complex), 2 * n, tolerance)


@pytest.mark.nightly
@pytest.mark.parametrize(("slope", "centre"), [(0.0, 0.0), (0.1, 0.0), (0.1, 0.003)])
def test_a_block_lands_flat_and_comes_to_rest(slope, centre):
    """Both corners stick in the end, and hold what gravity has along the guide."""
    run = {"at": np.linspace(0.0, 0.1, 101), "initial": STILL, "rtol": 1e-10, "duration": 0.1}
    found = jp.simulate(block(slope, centre), record=WORDS, **run)
    assert found.status == 0
    assert found.sizes["event"] < 60
    assert found["mode"].values[-1].tolist() == RESTS
    F_n, F_t = (found[word].values[-1, 2:] for word in WORDS[:2])
    assert F_n.sum() == pytest.approx(MASS * 9.81 * math.cos(slope), rel=1e-4)
    assert F_t.sum() == pytest.approx(MASS * 9.81 * math.sin(slope), rel=1e-4, abs=1e-9)
    assert F_t[0] / F_n[0] == pytest.approx(F_t[1] / F_n[1], rel=1e-3, abs=1e-9)
    assert np.abs(found.tangential_velocity.values[-40:, 2:]).max() < 1e-9
    assert np.ptp(found.slide_position.values[-40:]) < 1e-10
