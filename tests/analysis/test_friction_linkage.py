"""Laws of friction in a linkage: forces by the formula, what sticks, energy, tangents through contact."""

from __future__ import annotations

import numpy as np
import pytest

import jointplay as jp
from jointplay import catalog
from jointplay.analysis.quantities import EVENTS
from jointplay.solver.equations.friction import FRICTIONS
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.motion import ensemble_runs
from jointplay.solver.motion.eligibility import exclusion
from jointplay.solver.motion.trajectory import follow
from tests.support.belt import LAWS, STICKING, ratio
from tests.support.linkages import jointed

from ..method.test_tangent import NEAR, compare
from .sweeps.test_ensemble import apart, asked

ROUGH = {"clearance": 2.9e-4, "gear_ratio": 3.0}
STATES = ["normal_force", "tangential_force", "tangential_velocity", "mode", "energy", "energy_residual"]


def rubbing(name, **changes):
    """The paper's mechanism with another law of friction, which sticks where the law does."""
    return jointed(catalog.chunmei2002(**ROUGH | changes), friction=LAWS[name])


@pytest.mark.nightly
@pytest.mark.parametrize("elastic", [(), ("coupler",)])
@pytest.mark.parametrize("name", LAWS)
def test_forces_and_energy(name, elastic):
    found = jp.simulate(rubbing(name, elastic=elastic), turns=0.5, rtol=1e-9, record=STATES)
    assert int(found.status) == 0
    F_n, F_t, v_t, mode = (found[word].values.ravel() for word in STATES[:4])
    words = dict(zip(found.mode.flag_values, found.mode.flag_meanings.split(), strict=True))
    kind = np.array([words[each] for each in mode])
    slips, sticks = np.isin(kind, ("slip_positive", "slip_negative", "contact")), kind == "stick"
    sign = np.where(kind == "slip_negative", -1.0, 1.0)
    assert slips.sum() > 20
    errors = (F_t - sign * F_n * ratio(LAWS[name], v_t))[slips]
    assert np.abs(errors).max() < 1e-7 * np.abs(F_n).max()
    assert sticks.any() == (name in STICKING)
    if name in STICKING:
        limit = getattr(LAWS[name], FRICTIONS[name].limit)
        assert (np.abs(F_t[sticks]) <= limit * F_n[sticks] * (1 + 1e-6)).all()
        assert np.abs(v_t[sticks]).max() < 1e-6
    scale = np.abs(found.energy.values).max()
    assert np.abs(found.energy_residual.values).max() < 1e-9 * scale


@pytest.mark.nightly
def test_tangent_map():
    compare(rubbing("stribeck"), 0.4, NEAR, {"stick_onset", "slip_onset"}, True)


@pytest.mark.nightly
@pytest.mark.parametrize("name", [name for name in LAWS if FRICTIONS[name].rises])
def test_lanes_follow_the_same_motion(name):
    scenes, kinds, worst = [], set(), []
    for clearance in np.geomspace(2.9e-5, 1e-4, 5):
        scenes.append(assemble(rubbing(name, clearance=float(clearance)), section="angle:crank"))
    found = ensemble_runs.follow_ensemble(scenes, [asked(each, 1, 1e-6) for each in scenes])
    for each, records in zip(scenes, found, strict=True):
        assert not exclusion(each, asked(each, 1, 1e-6))
        truth = follow(each, asked(each, 1, 1e-11, at=np.array([each.period])))
        assert records.status == 0
        assert records.events[:, 1].tolist() == truth.events[:, 1].tolist()
        worst.append(apart(each, records.samples[:, 1:7], truth.samples[:, 1:7]).max())
        kinds |= {EVENTS[int(kind)] for kind in records.events[:, 1]}
    assert np.median(worst) < 5e-6
    assert name not in STICKING or {"stick_onset", "slip_onset"} <= kinds
