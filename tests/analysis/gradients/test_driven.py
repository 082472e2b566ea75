"""Tangents that parameters drive: against closed forms, and against differences of the motion itself."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import jointplay as jp
from jointplay import catalog
from jointplay.analysis.gradients.gradient_dataset import VERDICTS, verdict
from jointplay.solver.mechanism.assemble import assemble
from tests.support import driven, driven_table
from tests.support.driven_scenes import LINKAGES, SYSTEMS, own, written

ROOT, WITHOUT = Path(__file__).parents[3], {"NUMBA_DISABLE_JIT": "1"}
RUBBING = {"clearance": 2.9e-4, "gear_ratio": 3.0, "friction": 0.1}
KEYS = {
    "clearance": 2.9e-4,
    "gear_ratio": 3.0,
    "friction": 0.1,
    "joints.B.contact.stiffness": 7.15e6,
    "joints.B.contact.damping": 228.0,
    "links.coupler.mass": 0.1743,
    "joints.B.radius": 0.015,
    "drive.rated_torque": 21.56,
}

SOONER = ("rigid_bearing", "rubbed")  # scenes that are tried with every change

ON_FLOOR = {  # at rest on a floor, and coupled to a mass that goes on along it
    "states": {"y": 0.0, "x": 0.2, "v": 0.0, "u": 0.3},
    "forcing": "2*pi/w",
    "parameters": {"w": 1.0, "r": 0.5, "k": 3.0, "weight": 1.0, "f": 0.3},
    "rates": {
        "y": "v",
        "x": "u",
        "v": "f*sin(w*t) - weight + k*(x - y)*y - u*x",
        "u": "k*(y - x) - u/5 - x + v",
    },
    "impacts": [{"name": "floor", "gap": "y", "restitution": "r"}],
}


@pytest.fixture(scope="module")
def interpreted(tmp_path_factory):
    """Errors of all scenes, computed by plain Python: nothing has to be compiled."""
    folder = {"JOINTPLAY_CACHE": str(tmp_path_factory.mktemp("cache"))}
    command = [sys.executable, "-m", "tests.support.driven"]
    done = subprocess.run(
        command, cwd=ROOT, env=os.environ | WITHOUT | folder, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.mark.nightly
@pytest.mark.parametrize("name", driven.SCENES)
def test_differences(interpreted, name):
    error, events = interpreted[name]
    assert error < 5e-9
    assert events >= 2


@pytest.mark.nightly
@pytest.mark.parametrize("name", driven.MAPS)
def test_section_maps(interpreted, name):
    assert interpreted[name] < 1e-9


@pytest.mark.nightly
@pytest.mark.parametrize("name", driven.EXACT)
def test_closed_forms(interpreted, name):
    assert interpreted[name] < 1e-10


@pytest.mark.nightly
@pytest.mark.parametrize("name", driven.ASKED)
def test_what_gradient_gives(interpreted, name):
    """Largest values within a piece and on either side of an impact, ends, and times."""
    error, code, told = interpreted[name]
    assert error < 1e-8
    assert told < 1e-8
    assert VERDICTS[code] == "ok"


@pytest.mark.nightly
def test_a_motion_that_nearly_touches_says_so(interpreted):
    assert [VERDICTS[code] for code in interpreted["touching"]] == ["nearly_touching", "ok"]


@pytest.mark.parametrize(
    ("near", "word"),
    [
        ((1e-7, 1.0, 1.0), "grazing"),
        ((1.0, 1e-10, 1.0), "simultaneous_events"),
        ((1.0, 1.0, 1e-7), "nearly_touching"),
        ((np.nan, np.nan, np.nan), "no_motion"),
        ((1.0, 1e-8, 1e-5), "ok"),
    ],
)
def test_verdicts(near, word):
    assert VERDICTS[verdict(near)] == word


@pytest.mark.parametrize(
    ("wrong", "key", "text"),
    [
        ({"of": ["largest:normal_force:D"]}, "of[0]", "normal_force"),
        ({"of": ["most:normal_force:B"]}, "of[0]", "largest:normal_force:B"),
        ({"by": ["clearence"]}, "by[0]", "clearance"),
        ({"by": ["links.coupler.color"]}, "by[0]", "mass"),
        ({"by": ["initial.theta_crank"], "orbit": True}, "by", "a periodic orbit has no start"),
        ({"by": ["joints.B.journal.at"]}, "by", "can change to both sides"),
    ],
)
def test_wrong_input_is_refused(wrong, key, text):
    with pytest.raises(jp.InputError) as caught:
        jp.gradient(catalog.chunmei2002(clearance=2.9e-5), **wrong)
    assert [problem.key for problem in caught.value.problems] == [key]
    assert text in str(caught.value)


@pytest.mark.nightly
@pytest.mark.parametrize("key", KEYS)
def test_linkage_with_works(key):
    """Sticking, slip reversals and contacts of the paper's four-bar; the smaller error of two differences."""
    system = catalog.chunmei2002(**RUBBING)
    model = assemble(system, powers=True)
    duration = 0.5 * model.period
    exact = driven.by_tangents(system, {key: KEYS[key]}, duration, powers=True)[0]
    tried = [
        driven.by_differences(system, key, KEYS[key], duration, share, powers=True)
        for share in (1e-5, 1e-4, 1e-3)
    ]
    errors = [driven.distance(exact, each, model) for each in tried if each is not None]
    assert min(errors) < 1e-6


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=pytest.mark.nightly) for name in (*SYSTEMS, *LINKAGES)],
)
def test_all_parameters_of_a_scene(name):
    """A hundred scenes: every law, drive, kind of joint, and own equations."""
    found = driven_table.scene(name)
    assert found.error < 1e-6
    assert found.moving >= 1


def test_a_start_that_sticks_forgets_its_sliding_speed():
    """A block at rest on its belt goes with it, whatever it came with: v = V, x = x0 + V t until it slips."""
    block = written("stick_slip")
    found = jp.gradient(
        block, of=["end:state:x", "end:state:v"], by=["belt", "initial.v", "initial.x"], initial=[0.0, 0.1]
    )
    assert found["derivative"].values == pytest.approx(np.array([[1.0, 0.0, 1.0], [1.0, 0.0, 0.0]]), abs=1e-9)


def test_a_start_at_rest_has_no_derivative_off_its_wall():
    """Neighbours above the floor fall on it first (difference -0.533 for u); there are none below."""
    floor = own(**ON_FLOOR)
    states = ["end:state:y", "end:state:x", "end:state:u"]
    found = jp.gradient(floor, of=states, by=["initial.y", "initial.v", "initial.x", "k"])
    assert VERDICTS[int(found["derivative_status"])] == "one_sided"
    assert np.isnan(found["derivative"].values[:, 0]).all()

    def ends(place, step):
        start = np.array([0.0, 0.2, 0.0, 0.3])
        start[place] += step
        return jp.gradient(floor, of=states, by=["k"], initial=start, rtol=1e-12)["value"].values

    for column, place in ((1, 2), (2, 1)):
        quotient = (ends(place, 1e-6) - ends(place, -1e-6)) / 2e-6
        assert found["derivative"].values[:, column] == pytest.approx(quotient, abs=1e-7)


def test_a_start_that_rests_on_a_wall_forgets_how_fast_it_came_there():
    """A ball on its table goes with it, y = sin t, whatever it came with."""
    names, ball = ["end:state:y", "end:state:v"], catalog.bouncing_ball(0.9, 0.5)
    found = jp.gradient(ball, of=names, by=["initial.v"], initial=[0.0, 1.0])
    assert found["value"].values == pytest.approx([0.0, 1.0], abs=1e-12)
    assert np.all(found["derivative"].values == 0.0)


@pytest.mark.nightly
def test_corners_that_touch_together():
    """Compliant ones have one derivative in either order; rigid ones none, which is said."""
    make, start, _ = LINKAGES["guide"]
    soft = jp.gradient(make(), of=["end:angle:rod"], by=["joints.G.clearance"], initial=start)
    assert VERDICTS[int(soft["derivative_status"])] == "ok"
    rigid = {"initial": {"crank_speed": 150.0}, "by": ["joints.G.clearance"]}
    with pytest.warns(jp.ModelWarning, match="two contacts change at the same instant"):
        hard = jp.gradient(catalog.flores2010(), of=["end:angle:rod"], **rigid)
    assert VERDICTS[int(hard["derivative_status"])] == "simultaneous_events"
    assert "same instant" in str(jp.summary(hard))


@pytest.mark.nightly
def test_a_motion_that_parts_from_its_neighbours_has_its_largest_value_and_no_derivative():
    """Stiff faces: a run at another tolerance has its hardest impact at another time, and misses this one."""
    changes = {"joints.B.contact.stiffness": 1e8, "joints.B.contact.damping": 10.0}
    stiff = catalog.slider_crank(clearance=5e-5).varied(changes)
    keywords = {"of": ["largest:normal_force:B"], "by": ["joints.B.clearance"], "turns": 2}
    with pytest.warns(jp.ModelWarning, match="part too fast"):
        found = jp.gradient(stiff, **keywords)
    assert VERDICTS[int(found["derivative_status"])] == "sensitive"
    same = jp.simulate(stiff, turns=2, rtol=1e-10, record=["normal_force"])
    assert float(found["value"][0]) == pytest.approx(float(same["largest_normal_force"].max()), rel=1e-3)
    assert "hardly exists" in str(jp.summary(found))
    soft = jp.gradient(stiff.varied({"joints.B.contact.stiffness": 1e7}), **keywords)
    assert VERDICTS[int(soft["derivative_status"])] == "ok"
