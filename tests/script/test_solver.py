"""The solver in Node: the same motions as compiled, from the same text of equations and method."""

import numpy as np
import pytest

import jointplay as jp
from jointplay.analysis.quantities import EVENTS
from jointplay.script.solver import solver

from .in_node import needs_node, ran

pytestmark = needs_node
RTOL = 1e-10
PAPER = jp.catalog.chunmei2002
TWO_JOINTS = {"B": 2.9e-5, "C": 2.9e-5}
TURNS = """
const solver = makeSolver(data);
const found = solver.run(2, { samples: 8 });
return { ...found, state: solver.state() };
"""
STATES = ("angle", "angular_velocity", "state_value", "slide_position")
SCENES = {  # the paper's cases by their letters; those in `LONG` compile a structure that no other test needs
    "A": lambda: PAPER(),
    "B": lambda: PAPER(gear_ratio=3.0),
    "C": lambda: PAPER(gear_ratio=3.0, clearance=2.9e-4),
    "sticking": lambda: PAPER(gear_ratio=3.0, friction=0.3),
    "no tension": lambda: PAPER(gear_ratio=3.0, tension=False),
    "two joints": lambda: PAPER(gear_ratio=3.0, clearance=TWO_JOINTS),
    "slider-crank": lambda: jp.catalog.slider_crank(clearance={"B": 1e-4}, speed=200.0),
    "elastic": lambda: PAPER(gear_ratio=3.0, elastic=["coupler"]),
    "soft impacts": lambda: jp.catalog.soft_impact_pair(gap=0.4, stiffness=100.0, damping=1.0, tension=False),
    "impacts": lambda: jp.catalog.impact_pair(gap=0.4, restitution=0.8),
    "rests": lambda: jp.catalog.impact_pair(gap=0.4, restitution=0.6),
}
LONG = {"no tension", "two joints", "slider-crank", "elastic"}
NAMES = [pytest.param(name, marks=pytest.mark.long) if name in LONG else name for name in SCENES]


def events(motion):
    """Times, and names with kinds, of a motion's events."""
    joints = motion.event_joint.attrs["flag_meanings"].split()
    kinds = [EVENTS[kind] for kind in motion.event_kind.values]
    return motion.event_time.values, [
        (joints[j + 1], k) for j, k in zip(motion.event_joint.values, kinds, strict=True)
    ]


@pytest.mark.parametrize("name", NAMES)
def test_two_turns_are_the_compiled_ones(name, tmp_path):
    mechanism = SCENES[name]()
    section = jp.CrankAngle()
    script = solver(mechanism, rtol=RTOL, section=section)
    found = ran(script.text, script.data, TURNS, tmp_path)
    names = list(dict.fromkeys(q["name"] for q in script.data["quantities"]))
    motion = jp.simulate(mechanism, turns=2, rtol=RTOL, record=names, samples_per_turn=4, section=section)
    times, kinds = events(motion)
    assert found["status"] == "ok"
    assert [(each["joint"], each["kind"]) for each in found["events"]] == kinds
    np.testing.assert_allclose(
        [each["time"] for each in found["events"]], times, rtol=0, atol=1e-9 * times[-1:].max(initial=1)
    )
    assert found["turns_done"] == pytest.approx(2, rel=1e-15)
    np.testing.assert_allclose(found["time"], motion.time.values[1:], rtol=1e-14)
    for quantity in names:
        here, there = found[quantity], motion[quantity]
        share = 1e-9 if quantity in STATES else 1e-6  # differences of what is far larger
        for label, series in here.items():
            expected = (there.sel({there.dims[1]: label}) if label else there).values[1:]
            most = share * max(float(np.abs(there).max()), 1e-300)
            np.testing.assert_allclose(series, expected, rtol=0, atol=most, err_msg=f"{quantity} {label}")


CHANGED = {"clearance.B": 1e-4, "gear_ratio": 5.0, "friction.B": 0.02, "stiffness.B": 2e7, "damping.B": 100.0}
SET = """
const solver = makeSolver(data.solver);
solver.run(0.3);
const said = Object.entries(data.values).map(([key, value]) => solver.set(key, value));
solver.reset();
const found = solver.run(1, { samples: 4 });
const refused = [solver.set("gear_ratio", 1e9), solver.set("clearance.B", NaN), solver.set("mass", 1)];
return { ...found, state: solver.state(), said, refused, period: solver.period() };
"""


def test_numbers_follow_the_sliders_as_they_follow_a_study(tmp_path):
    script = solver(SCENES["C"](), rtol=RTOL, section=jp.CrankAngle())
    found = ran(script.text, {"solver": script.data, "values": CHANGED}, SET, tmp_path)
    parts = {"clearance.B": "joints.B.clearance", "friction.B": "joints.B.friction.coefficient"}
    parts |= {f"{word}.B": f"joints.B.contact.{word}" for word in ("stiffness", "damping")}
    changed = SCENES["C"]().replace(**{parts.get(key, key): value for key, value in CHANGED.items()})
    motion = jp.simulate(changed, turns=1, rtol=RTOL, samples_per_turn=4, section=jp.CrankAngle())
    assert found["said"] == [""] * len(CHANGED)
    assert found["status"] == "ok"
    assert found["period"] == pytest.approx(float(motion.turn_period_nominal), rel=1e-14)
    times, kinds = events(motion)
    assert [(each["joint"], each["kind"]) for each in found["events"]] == kinds
    np.testing.assert_allclose([each["time"] for each in found["events"]], times, rtol=1e-9)
    for link, angles in found["angle"].items():
        np.testing.assert_allclose(angles, motion.angle.sel(link=link).values[1:], atol=1e-9)
    assert found["refused"] == [
        "gear ratio: from 0.6 to 9 is accepted",
        "radial clearance of joint B: from 29 to 2900 µm is accepted",
        "there is no slider mass",
    ]
