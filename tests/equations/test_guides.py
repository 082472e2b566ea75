"""Guides with clearance: equations at single states, against bodies with all their coordinates."""

from __future__ import annotations

import numpy as np
import pytest

from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.assemble import assemble
from tests.equations.test_ideal_loops import CRANK, joint, linkage, turned
from tests.support.motion import seen
from tests.support.multibody_records import at_state, marker
from tests.support.plain import Point, plain

SLOW = pytest.mark.nightly
MOTOR = {"kind": "motor", "link": "crank", "gear_ratio": 3.0, "efficiency": 1.0, "synchronous_speed": 314.0}
MOTOR |= {"rated_speed": 290.0, "rated_torque": 2.0}
PLAY = {"clearance": 1e-4, "half_length": 0.03, "half_height": 0.02}
PLAY |= {"contact": {"stiffness": 1e6, "damping": 300.0}}
PLAY |= {"friction": {"law": "tanh", "coefficient": 0.3, "velocity": 0.5, "viscous": 2.0}}
GUIDES = {
    "on the ground, inclined, the slider's line beside its link's": (
        "G",
        [
            CRANK,
            joint("A", ("crank", 0.3), ("rod", 0.1)),
            joint("B", ("rod", 0.9), ("slider", 0.2)),
            joint("G", ("slider", 0.05, 1.1), ((0.2, 0.3), 0.0, 0.5), "prismatic"),
        ],
        {"rod": 0.5},
    ),
    "on an arm that swings": (
        "S",
        [
            CRANK,
            joint("A", ("crank", 0.3), ("block", 0.1)),
            joint("S", ("block", 0.2, 0.4), ("arm", 0.15, -0.3), "prismatic"),
            joint("C", ("arm", 0.05), ((0.8, 0.1),)),
        ],
        {"arm": 2.9},
    ),
    "on the crank": (
        "S",
        [
            CRANK,
            joint("S", ("block", 0.1, 0.3), ("crank", 0.2, 1.2), "prismatic"),
            joint("B", ("block", 0.3), ("slider", 0.2)),
            joint("G", ("slider", 0.05, 0.7), ((0.5, -0.2), 0.0, 0.2), "prismatic"),
        ],
        {},
    ),
    "between links that both slide": (
        "S",
        [
            CRANK,
            joint("A", ("crank", 0.3), ("block", 0.1)),
            joint("S", ("block", 0.0, 0.2), ("yoke", 0.3, 1.4), "prismatic"),
            joint("G", ("yoke", 0.0, 0.3), ((0.0, 0.1), 0.0, 0.1), "prismatic"),
        ],
        {},
    ),
}


def scene(name, swapped, drive):
    """A mechanism with a guide with clearance, by its name; the joint's name."""
    loose, joints, guess = GUIDES[name]
    joints = [each | PLAY if each["name"] == loose else each for each in turned(joints, swapped * loose)]
    return linkage(joints, guess, MOTOR if drive == "motor" else None), loose


def off(mechanism, seed=3):
    """A state beside the ideal mechanism's, more than the clearance."""
    model, random = assemble(mechanism, {"crank_angle": 0.4}), np.random.default_rng(seed)
    n = len(model.turning)
    state = model.state + np.r_[5e-3 * random.standard_normal(n), 0.5 * random.standard_normal(n)]
    return model, state


@pytest.mark.parametrize(
    ("name", "swapped", "drive"),
    [
        pytest.param(name, swapped, drive, marks=() if fast else SLOW)
        for name in GUIDES
        for swapped in (False, True)
        for drive in ("speed", "motor")
        for fast in [(swapped, drive) == (name == "on the crank", "speed")]
    ],
)
def test_forces_and_accelerations(name, swapped, drive):
    mechanism, loose = scene(name, swapped, drive)
    model, state = off(mechanism)
    system, y = at_state(mechanism, model, state)
    found, theirs = seen(model, state, modes=["contact"] * 4), system.solve(0.0, y, ["closed"] * 4)
    scale = np.abs(theirs.acceleration).max()
    for i, link in enumerate(mechanism.links):
        a = theirs.acceleration[3 * i + 2]
        assert found[f"angular_acceleration:{link.name}"] == pytest.approx(a, abs=1e-10 * scale)
    forces = np.array([[F_n, F_t] for _, _, F_n, F_t in theirs.touches])
    size = np.abs(forces).max()
    assert np.abs(forces).min() > 1e-5 * size
    for corner, (_, touch, F_n, F_t) in zip(model.joints, theirs.touches, strict=True):
        words = ("penetration", "normal_velocity", "tangential_velocity")
        mine = [found[f"{word}:{corner}"] for word in words]
        assert mine == pytest.approx([touch.u, touch.v_n, touch.v_t], rel=1e-10, abs=1e-13)
        mine = [found[f"{word}:{corner}"] for word in ("normal_force", "tangential_force")]
        assert mine == pytest.approx([F_n, F_t], abs=1e-10 * size)
        facing = [np.cos(found[f"contact_angle:{corner}"]), np.sin(found[f"contact_angle:{corner}"])]
        assert facing == pytest.approx(touch.normal, abs=1e-13)
        apart = (touch.u + PLAY["clearance"]) * touch.normal
        assert [found[f"journal_{x}:{corner}"] for x in "xy"] == pytest.approx(apart, abs=1e-13)
    record = mechanism.joint(loose)
    along = theirs.now.along(*(marker(pin) for pin in (record.journal, record.bearing)))
    for corner in model.joints:
        assert found[f"slide_position:{corner}"] == pytest.approx(along.slide, abs=1e-13)
        assert found[f"slide_velocity:{corner}"] == pytest.approx(along.slide_rate, abs=1e-12)
    for pin, reaction in theirs.reactions.items():
        if pin == "drive":
            assert found["drive_torque"] == pytest.approx(-reaction[2], abs=1e-9 * size)
            continue
        assert [found[f"reaction_{x}:{pin}"] for x in "xy"] == pytest.approx(reaction[:2], abs=1e-9 * size)
        if mechanism.joint(pin).prismatic:
            assert found[f"reaction_moment:{pin}"] == pytest.approx(reaction[2], abs=1e-9 * size)


@pytest.mark.parametrize(
    "name", [GUIDE if i else pytest.param(GUIDE, marks=SLOW) for i, GUIDE in enumerate(GUIDES)]
)
def test_the_sliding_speeds_rate(name):
    """What decides on sticking, against the difference of the sliding speed along the flow."""
    model, state = off(scene(name, False, "speed")[0])
    functions, n = plain(model.structure), len(model.turning)

    def at(h):
        place = state + h * np.r_[state[n:], rate]
        return Point(functions, model.numbers, place, ["contact"] * 4, t=h).contacts()

    rate = Point(functions, model.numbers, state, ["contact"] * 4).rate()[:, 0]
    difference = (at(1e-7)[:, 2] - at(-1e-7)[:, 2]) / 2e-7
    assert at(0.0)[:, 5] == pytest.approx(difference, rel=1e-5)


def test_a_guide_with_clearance_leaves_other_equations_alone():
    """Numbers of a slider's contact data stand in the equations only where the guide has clearance."""
    names = plain(assemble(catalog.slider_crank()).structure).PARAMETERS
    assert not [name for name in names if name in ("K_G", "ha_G", "e_G")]
