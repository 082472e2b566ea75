"""The relief valve against Boost odeint: section points on a cycle with impacts, by two steppers."""

import numpy as np
import pytest

import jointplay as jp

from .odeint_valve import STEPPERS, compiled, follow

pytestmark = pytest.mark.peer
SECTION = jp.Plane(quantity="v", value=0.0, direction="down")
DURATION, RTOL = 400.0, 1e-10


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    found = compiled(tmp_path_factory.mktemp("odeint"))
    return found or pytest.skip("needs g++ and Boost's headers")


@pytest.mark.parametrize("flow", [3.0, 5.0])
def test_section_points(program, flow):
    """On a stable cycle what is left is the time's error, which grows with it, at the tolerance asked for."""
    ours = jp.poincare(jp.catalog.relief_valve(flow=flow), section=SECTION, duration=DURATION, rtol=RTOL)
    last = ours.isel(turn=-1)
    expected = [float(last.time), *last.state_value.sel(state=["x", "p"]).values]
    for stepper in STEPPERS:
        theirs = follow(program, stepper, RTOL, DURATION, flow)
        assert theirs.points == ours.sizes["turn"]
        assert theirs.impacts > 100
        assert np.array(theirs.last) == pytest.approx(expected, rel=1e-8)
