"""The references agree with each other: two derivations, and stored motions recomputed."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from .bodies import Bodies, Parameters
from .scenes import SCENES
from .twin import run

TRUTH = json.loads(Path(__file__).with_name("truth.json").read_text())


def scattered(system, seed):
    """A state near the start with every joint displaced by about its clearance and moving."""
    random, size = np.random.default_rng(seed), np.repeat([1e-3, 5.0], system.n)
    return system.start() + size * random.standard_normal(2 * system.n)


@pytest.mark.peer
@pytest.mark.parametrize("drive", ["motor", "speed", "none"])
@pytest.mark.parametrize("mode", ["free", "slip+", "slip-", "stick"])
@pytest.mark.parametrize("joints", ["O", "A", "B", "C", "BC", "AC", "OABC"])
def test_free_bodies_and_virtual_work_agree(joints, mode, drive):
    hy = pytest.importorskip("heyoka")
    from .taylor import Series

    parameters = Parameters(i=3.0, f=0.1, C_t=2.0, drive=drive)
    system, modes = Bodies(parameters, dict.fromkeys(joints, 2.9e-4)), dict.fromkeys(joints, mode)
    series = Series(system, real=np.float64)
    accelerations, held = series.equations(modes)
    function = hy.cfunc([*accelerations, *held.values()], series.q + series.v, compact_mode=True)
    sign = np.full(function.nparams, -1.0 if mode == "slip-" else 1.0)
    y = scattered(system, seed=3)
    other = function(y, pars=sign) if len(sign) else function(y)
    mine = np.array([*system.rate(y, modes)[system.n :], *system.solve(y, modes)[1].values()])
    assert np.max(np.abs(mine - other)) < 1e-10 * np.max(np.abs(mine))


def test_undamped_motion_keeps_its_energy():
    scene = SCENES["conservative_at_BC"]
    system = Bodies(scene.parameters, scene.clearance)
    result = run(scene.parameters, scene.clearance, turns=0.03, rtol=1e-11)
    assert len(result.events) > 3
    assert system.energy(result.y) == pytest.approx(system.energy(system.start()), rel=1e-10)


@pytest.mark.nightly
@pytest.mark.parametrize("name", ["B", "B_sticking", "damped_at_BC"])
def test_stored_truth_is_found_again(name):
    scene, stored = SCENES[name], TRUTH[name]
    result = run(scene.parameters, scene.clearance, turns=scene.turns, rtol=1e-11)
    assert [[event.joint, event.kind] for event in result.events] == [row[1:3] for row in stored["events"]]
    assert result.angles == pytest.approx(stored["angles"], rel=0, abs=1e-11)
    assert result.speeds == pytest.approx(stored["speeds"], rel=0, abs=1e-11 * scene.parameters.w0)
