"""Presets against the second program and closed forms: slider-crank, six-bars, quick return."""

from __future__ import annotations

import numpy as np
import pytest

import jointplay as jp
from tests.reference.test_multibody_package import FORCES, MOTION, TOUCH, agree, both, same_motion
from tests.support.multibody import Now
from tests.support.second_run import lasting

ANGLE = 0.4  # rad, of the crank at the start
PRESETS = ("slider_crank", "watt", "stephenson", "quick_return")


def preset(name, **changes):
    return getattr(jp.catalog, name)(**changes)


@pytest.mark.nightly
@pytest.mark.parametrize("name", PRESETS)
def test_the_ideal_preset_moves_and_is_held_as_the_second_program_says(name):
    mechanism = preset(name, clearance=0)
    found, system, states, solved, _ = both(mechanism, ANGLE, 0.3, MOTION + FORCES)
    same_motion(found, system, states, solved, 1e-9)
    if mechanism.drive.imposed_speed:
        agree(found.drive_torque.values, [-x.reactions["drive"][2] for x in solved], 1e-9, "torque")


@pytest.mark.long
@pytest.mark.parametrize("name", PRESETS)
def test_the_moment_of_every_guide(name):
    """About the journal's point, where the force acts."""
    mechanism = preset(name, clearance=0)
    guides = [joint.name for joint in mechanism.joints if joint.kind == "prismatic"]
    if not guides:
        pytest.skip("no guide")
    found, _, _, solved, _ = both(mechanism, ANGLE, 0.3, ["angle", "reaction_moment", "reaction"])
    for guide in guides:
        mine = np.array([x.reactions[guide][2] for x in solved])
        size = np.abs(found.reaction.values).max() * 0.1
        assert np.abs(found.reaction_moment.sel(pin=guide).values - mine).max() < 1e-9 * size


@pytest.mark.nightly
@pytest.mark.parametrize("name", PRESETS)
@pytest.mark.parametrize("tension", [True, False])
def test_the_preset_with_play(name, tension):
    joint = "D" if name == "quick_return" else "B"
    mechanism = preset(name, clearance={joint: 1e-4}, friction=0.0).replace(tension=tension)
    found, system, states, solved, events = both(mechanism, ANGLE, 0.1, [*MOTION, *FORCES, *TOUCH])
    kept = lasting([(event.kind, event.time) for event in events])
    assert len(kept) >= 2
    same_motion(found, system, states, solved, 3e-8)
    rows = [[[x.u, x.v_n, x.v_t, F_n, F_t] for _, x, F_n, F_t in row.touches] for row in solved]
    for word, mine in zip(TOUCH, np.moveaxis(np.array(rows), 2, 0), strict=True):
        if np.abs(found[word]).max() > 0:
            agree(found[word].values[1:], mine[1:], 1e-8, word)
    assert found.event_time.values == pytest.approx([time for _, time in kept], abs=1e-10)


@pytest.mark.parametrize("offset", [0.0, 0.011])
def test_the_slider_crank_s_closed_form(offset):
    r, l, w = 0.05, 0.12, 200.0
    mechanism = preset("slider_crank", crank=r, rod=l, offset=offset, speed=w, clearance=0)
    words = [*MOTION, "slide_position", "slide_velocity"]
    found = jp.simulate(mechanism, turns=1, rtol=1e-11, record=words, samples_per_turn=60)
    theta = w * found.time.values
    phi = np.arcsin((offset - r * np.sin(theta)) / l)
    d1 = -r * np.cos(theta) / (l * np.cos(phi))
    d2 = (r * np.sin(theta) / l + np.sin(phi) * d1**2) / np.cos(phi)
    x, x1 = r * np.cos(theta) + l * np.cos(phi), -r * np.sin(theta) - l * np.sin(phi) * d1
    assert found.angle.sel(link="rod").values == pytest.approx(phi, abs=1e-12)
    assert found.angular_velocity.sel(link="rod").values == pytest.approx(d1 * w, abs=1e-12 * w)
    assert found.angular_acceleration.sel(link="rod").values == pytest.approx(d2 * w**2, abs=1e-11 * w**2)
    assert found.slide_position.sel(joint="G").values == pytest.approx(x, abs=1e-13)
    assert found.slide_velocity.sel(joint="G").values == pytest.approx(x1 * w, abs=1e-12 * w)


@pytest.mark.long
def test_slides_are_what_the_second_program_measures():
    mechanism = preset("quick_return", clearance=0)
    guides = [joint.name for joint in mechanism.joints if joint.kind == "prismatic"]
    found, system, states, _, _ = both(mechanism, ANGLE, 0.3, ["angle", "slide_position", "slide_velocity"])
    for guide in guides:
        part = next(joint for joint in system.joints if joint.name == guide)
        rows = zip(found.time.values, states, strict=True)
        seen = [Now(system, t, y).along(part.journal, part.bearing) for t, y in rows]
        agree(found.slide_position.sel(joint=guide).values, [x.slide for x in seen], 1e-12, guide)
        agree(found.slide_velocity.sel(joint=guide).values, [x.slide_rate for x in seen], 1e-11, guide)


@pytest.mark.nightly
def test_virtual_work_of_the_drive():
    """At constant speed the torque's work is the change of energy, which the second program has too."""
    for name in PRESETS:
        mechanism = preset(name, clearance=0)
        found, system, states, _, _ = both(mechanism, ANGLE, 0.3, ["angle", "energy", "drive_work"])
        mine = [system.energy(t, y) for t, y in zip(found.time.values, states, strict=True)]
        grown = np.array(mine) - mine[0]
        agree(found.energy.values - float(found.energy[0]), grown, 1e-9, name)
        if mechanism.drive.imposed_speed:
            agree(found.drive_work.values, grown, 3e-8, name)
