"""Tangents that parameters drive: against closed forms, and against differences of the motion itself."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from jointplay import catalog
from jointplay.mechanism.assemble import assemble
from tests.support import driven

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


@pytest.mark.parametrize("name", driven.SCENES)
def test_differences(interpreted, name):
    error, events = interpreted[name]
    assert error < 5e-9
    assert events >= 2


@pytest.mark.parametrize("name", driven.MAPS)
def test_section_maps(interpreted, name):
    assert interpreted[name] < 1e-9


@pytest.mark.parametrize("name", driven.EXACT)
def test_closed_forms(interpreted, name):
    assert interpreted[name] < 1e-10


@pytest.mark.long
@pytest.mark.parametrize("key", KEYS)
def test_linkage_with_works(key):
    """Sticking, slip reversals and contacts of the paper's four-bar; the smaller error of two differences."""
    system = catalog.chunmei2002(**RUBBING)
    model = assemble(system, powers=True)
    duration = 0.5 * model.period
    exact = driven.by_tangents(system, {key: KEYS[key]}, duration, powers=True)[0]
    tried = [
        driven.by_differences(system, key, KEYS[key], duration, share, powers=True) for share in (1e-5, 1e-4)
    ]
    errors = [driven.distance(exact, each, model) for each in tried if each is not None]
    assert min(errors) < 1e-6
