"""Motions against stored truth (tests/reference): end states, event times and kinds."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import jointplay as jp
from jointplay.analysis.quantities import EVENTS
from tests.support.linkages import mechanism, start

from ..reference.four_bar import LINKS
from ..reference.scenes import SCENES

TRUTH = json.loads((Path(__file__).parents[1] / "reference" / "truth.json").read_text())
WORDS = ["angle", "angular_velocity", "journal_x", "journal_y", "mode"]
OWN_STRUCTURE = {  # each costs ten seconds of compilation and shows little that the others do not
    *("B_viscous", "damped_at_A", "damped_at_C", "damped_at_O", "damped_at_BC", "damped_at_OABC"),
    "damped_at_BC_constant_speed",
}
NAMES = [pytest.param(n, marks=pytest.mark.nightly) if n in OWN_STRUCTURE else n for n in SCENES]
# Without a pulling contact the force vanishes before the gap opens: two events of a pair of names each.
OTHER_NAMES = {"release": "separation", "separation": "reopening"}


def motion(name, rtol, **keywords):
    """The package's motion of a stored model."""
    model = SCENES[name]
    p = model.parameters
    begin = start(p) if p.drive == "none" else None
    keywords = {"duration": TRUTH[name]["t_end"], "at": [TRUTH[name]["t_end"]], "record": WORDS} | keywords
    return jp.simulate(mechanism(p, model.clearance), rtol=rtol, initial=begin, **keywords)


def apart(found, name):
    """Largest difference from the stored end state, in units of 1 rad and the no-load speed."""
    stored, w0 = TRUTH[name], SCENES[name].parameters.w0
    angle = found.angle.isel(time=-1).sel(link=list(LINKS)).values
    speed = found.angular_velocity.isel(time=-1).sel(link=list(LINKS)).values
    return max(
        np.abs(angle - [stored["angles"][k] for k in LINKS]).max(),
        np.abs(speed - [stored["speeds"][k] for k in LINKS]).max() / w0,
    )


def stored_events(name):
    """Times and (joint, kind) of the stored events, kinds in the package's words."""
    other = {} if SCENES[name].parameters.tension else OTHER_NAMES
    rows = TRUTH[name]["events"]
    return np.array([row[0] for row in rows]), [(row[1], other.get(row[2], row[2])) for row in rows]


def found_events(found):
    """Times and (joint, kind) of a motion's events."""
    joints = found.joint.values[found.event_joint.values]
    return found.event_time.values, [
        (str(joint), EVENTS[kind]) for joint, kind in zip(joints, found.event_kind.values, strict=True)
    ]


@pytest.mark.parametrize("name", NAMES)
def test_end_state_and_events(name):
    found = motion(name, 1e-10)
    times, kinds = stored_events(name)
    ours, words = found_events(found)
    assert found.status == 0
    assert words == kinds
    assert np.abs(ours - times).max(initial=0.0) < 1e-10 * float(found.turn_period_nominal)
    assert apart(found, name) < 1e-10


@pytest.mark.parametrize("name", ["A", "B", "C", "B_sticking"])
def test_a_tighter_run_is_nearer(name):
    assert apart(motion(name, 1e-13), name) < 2e-12


@pytest.mark.parametrize("name", ["B", "C"])
def test_speeds_at_events(name):
    found, rows = motion(name, 1e-11), TRUTH[name]["events"]
    ours = np.stack([found.event_normal_velocity, found.event_tangential_velocity], 1)
    assert np.abs(ours - [row[3:] for row in rows]).max() < 1e-9


@pytest.mark.parametrize("name", ["B", "C_constant_speed", "conservative_at_BC"])
def test_journal_at_the_end(name):
    found = motion(name, 1e-11)
    for joint, (r, _) in TRUTH[name]["joints"].items():
        end = found.isel(time=-1).sel(joint=joint)
        assert (float(end.journal_x), float(end.journal_y)) == pytest.approx(r, abs=1e-11)


def test_a_long_regular_motion_forgets_no_digit():
    """Case B is regular: after 200 turns a run at 1e-10 is still within 1e-8 of a tight one."""
    ends = []
    for rtol in (1e-10, 1e-13):
        period = TRUTH["B"]["t_end"]
        end = motion("B", rtol, duration=200 * period, at=[200 * period], record=WORDS[:2])
        assert end.status == 0
        ends.append(end)
    w0 = SCENES["B"].parameters.w0
    assert float(np.abs(ends[0].angle - ends[1].angle).max()) < 1e-8
    assert float(np.abs(ends[0].angular_velocity - ends[1].angular_velocity).max()) < 1e-8 * w0
