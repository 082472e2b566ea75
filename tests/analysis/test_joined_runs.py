"""Two halves of a motion, the second from the `end_state` of the first, against the whole."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest

import jointplay as jp
from jointplay import catalog
from jointplay.analysis import tangents
from jointplay.analysis.starts import placed
from tests.support.driven_scenes import FOUR_BAR, PROFILE, RESTING, RUBBED, SOFT, bent, law, own, pinned
from tests.support.tangent_map import tangent_map

ROOM = 30.0  # errors of steps, as they are at the end
SCENES = {  # mechanism, first part and whole in turns
    "compliant": (partial(FOUR_BAR, clearance=2.9e-4, gear_ratio=3.0), 0.37, 1.0),
    "constant speed": (partial(FOUR_BAR, clearance=2.9e-4, speed=80.0), 0.37, 1.0),
    "rigid": (partial(pinned, 0.8), 0.5, 2.0),
    "rigid at rest": (partial(pinned, 0.0), 0.2, 2.0),
    "remembers the speed of impact": (law("flores", "none"), 0.21, 0.5),
    "bristles": (law("kelvin_voigt", "lugre"), 0.21, 0.5),
    "sticks": (partial(FOUR_BAR, clearance=2.9e-4, gear_ratio=3.0, friction=0.3), 0.21, 0.5),
    "elastic": (lambda: bent(FOUR_BAR(clearance=2.9e-4, speed=80.0), coupler=SOFT), 0.11, 0.3),
    "own, forced": (lambda: own(**RUBBED), 1.0, 2.0),
    "own, at rest": (lambda: own(**RESTING), 1.0, 2.0),
}
QUICK = ("compliant", "rigid", "own, forced", "own, at rest")


@pytest.mark.long
@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=[pytest.mark.nightly] * (n not in QUICK)) for n in SCENES]
)
@pytest.mark.parametrize("rtol", [1e-8, 1e-11])
def test_two_halves_are_the_whole(name, rtol):
    """To what a step may err, times the growth of an error until the end."""
    make, part, turns = SCENES[name]
    mechanism, run = make(), {"rtol": rtol, "samples_per_turn": 4}
    whole = jp.simulate(mechanism, turns=turns, **run)
    first = jp.simulate(mechanism, turns=part, **run)
    second = jp.simulate(mechanism, turns=turns - part, initial=first.end_state, **run)
    assert int(whole.status) == int(first.status) == int(second.status) == 0
    assert second.end_state.state.values.tolist() == whole.end_state.state.values.tolist()
    model = placed(mechanism, first.end_state.values.tolist())
    scale, n = tangents.scales(model), len(model.state)
    growth = tangent_map(model, (turns - part) * model.period) * scale / scale[:, None]
    apart = (second.end_state - whole.end_state).values[:n] / scale
    assert np.linalg.norm(apart) < ROOM * max(rtol, 1e-14) * (1 + np.linalg.norm(growth, 2))


@pytest.mark.nightly
@pytest.mark.parametrize("mechanism", [jp.catalog.chunmei2002(1e-4), jp.catalog.slider_crank(clearance=1e-4)])
def test_a_motion_goes_on_after_more_turns_than_a_start_may_have(mechanism):
    run = {"record": ["journal_x", "drive_torque"], "rtol": 1e-9}
    first = jp.simulate(mechanism, turns=1010, samples_per_turn=1, **run)
    second = jp.simulate(mechanism, turns=1, samples_per_turn=8, initial=first.end_state, **run)
    whole = jp.simulate(mechanism, turns=1011, samples_per_turn=8, **run)
    for name in run["record"]:
        assert second[name].values == pytest.approx(whole[name].values[-9:], rel=1e-6, abs=1e-12)


def test_an_end_of_a_constant_speed_has_the_angle_of_the_crank():
    mechanism = pinned(0.8)
    found = jp.simulate(mechanism, turns=0.25, samples_per_turn=4)
    assert found.end_state.sel(state="theta_crank") == pytest.approx(np.pi / 2)
    with pytest.raises(jp.InputError, match=r"theta_coupler, .*, w_rocker, theta_crank"):
        jp.simulate(mechanism, turns=0.25, initial=[1.0, 2.0])
    given = catalog.lorenz()
    assert jp.simulate(given, duration=1.0).end_state.state.values.tolist() == ["x", "y", "z"]


@pytest.mark.long
@pytest.mark.parametrize(
    ("mechanism", "duration"),
    [(own(**RUBBED), 1.0), (FOUR_BAR(clearance=2.9e-4, drive=PROFILE), 0.01)],
    ids=["forced", "profile"],
)
def test_an_end_from_which_no_start_goes_on_alike_is_none(mechanism, duration):
    """The phase, and the time, would begin anew."""
    found = jp.simulate(mechanism, duration=duration, samples_per_turn=4)
    assert np.isnan(found.end_state.values).all()
    with pytest.raises(jp.InputError, match="got nan"):
        jp.simulate(mechanism, duration=1.0, initial=found.end_state)


def test_outputs_beside_the_states_are_no_part_of_it():
    own = jp.System(
        states={"x": 1.0, "v": 0.0}, rates={"x": "v", "v": "-x"}, outputs={"energy": "(x**2 + v**2)/2"}
    )
    first = jp.simulate(own, duration=1.0, rtol=1e-10)
    assert first.state_value.state.values.tolist() == ["x", "v", "energy"]
    assert first.end_state.end.values.tolist() == ["x", "v"]
    second = jp.simulate(own, duration=0.5, rtol=1e-10, initial=first.end_state)
    assert second.end_state.values == pytest.approx([np.cos(1.5), -np.sin(1.5)], abs=1e-9)
