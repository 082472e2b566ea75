"""Events that another one brings about, at the same time, have its delays: closed forms."""

import math

import numpy as np
import pytest

import jointplay as jp

A, C, END = 3.0, 1.25, 2
WALLS = [
    {"name": "floor", "gap": "x", "restitution": "0.5"},
    {"name": "other", "gap": "y - c + 9", "restitution": "0.8"},
]
SWINGING, FALLING = {"y": "u", "u": "-c**2*y"}, {"y": "u", "u": "0"}
QUARTER, FALL = (math.pi / (2 * C), -math.pi / (2 * C**2)), (1.5, -1.0)
LIFTED = {  # force, start and rates of what turns it, switches; when it turns, and how much later by c
    "a place": ("2*up - 1", {"y": 1.0, "u": 0.0}, SWINGING, ["-y"], *QUARTER),
    "a speed": ("2*up - 1", {"y": 0.0, "u": 1.0}, SWINGING, ["-u"], *QUARTER),
    "an impact": ("2*up - 1", {"y": C - 7.5, "u": -1.0}, FALLING, ["u"], *FALL),
    "an impact, by a sign": ("sign(u)", {"y": C - 7.5, "u": -1.0}, FALLING, [], *FALL),
}


@pytest.mark.parametrize("rtol", [1e-6, 1e-9, 1e-12])
@pytest.mark.parametrize("by", LIFTED)
def test_what_rests_until_something_else_lets_it_go_has_its_delay(by, rtol):
    force, start, rates, switches, time, later = LIFTED[by]
    body = jp.System(
        name="lifted",
        parameters={"a": A, "c": C},
        states={"x": 0.0, "v": 0.0} | start,
        rates={"x": "v", "v": f"a*({force})"} | rates,
        impacts=WALLS,
        switches=[{"name": "up", "on": each} for each in switches],
        scales={"t": 1.0},
    )
    keys = {"of": ["end:state:x", "end:state:v"], "by": ["a", "c"]}
    found = jp.gradient(body, turns=END, rtol=rtol, **keys)
    flies = END - time
    assert found["value"].values == pytest.approx([A * flies**2 / 2, A * flies], rel=1e-7)
    expected = [[flies**2 / 2, -A * flies * later], [flies, -A * later]]
    assert jp.words(found)["derivative_status"].item() == "ok"
    assert found["derivative"].values == pytest.approx(np.array(expected), rel=1e-7)


def test_a_follower_that_a_bend_of_its_cam_lets_go_forgets_what_was_before():
    cam = jp.catalog.cam_follower(speed=14.0)
    found = jp.lyapunov(cam, turns=20, transient=5)
    assert jp.words(found)["status"] == "ok"
    assert found["section_exponent_per_turn"].values == -np.inf
