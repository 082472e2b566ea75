"""Slider-crank and six-bar with play against Exudyn: impact times and forces, as far as its fixed step goes.

Exudyn's contact begins and ends at the end of a step, wherever in the step it should, so its error is at most
of the step's order but does not fall smoothly: C h, with C from the change between three steps. What is
computed here has to be within that of the finest run.
"""

import numpy as np
import pytest

import jointplay as jp

from .exudyn_twin import follow, free

pytestmark = pytest.mark.peer
pytest.importorskip("exudyn")
STEPS = (1e-6, 4e-7, 2e-7)  # s
SPARE = 2.0
NEAR = 2e-6  # s of an event, where a force that jumps is not compared
SCENES = {
    "slider_crank": (jp.catalog.slider_crank(clearance={"B": 1e-4}, gravity=9.8, damping=500.0), 0.006),
    "stephenson": (jp.catalog.stephenson(clearance={"B": 1e-4, "D": 1e-4}), 0.008),
}
START = {"crank_angle": 0.3, "crank_speed": 60.0}


@pytest.mark.nightly
@pytest.mark.parametrize("name", SCENES)
def test_impacts_and_forces_are_exudyn_s(name):
    mechanism, end = free(SCENES[name][0]), SCENES[name][1]
    at = np.linspace(0.0, end, 1001)
    run = {"initial": START, "rtol": 1e-11, "at": at, "record": ["normal_force", "penetration"]}
    ours = jp.simulate(mechanism, duration=end, **run)
    twins = [follow(mechanism, START, end, h) for h in STEPS]
    assert jp.words(ours).event_kind.values[0] == "contact"
    for i, joint in enumerate(mechanism.clearance_joints):
        mine = (ours.event_joint.values == i) & (ours.event_kind.values == 0)
        begins, force = ours.event_time.values[mine], ours.normal_force.values[:, i]
        assert len(begins) > 0
        found = [
            (
                twin.begins(joint),
                np.interp(at, twin.t, twin.force(joint)),
                np.interp(at, twin.t, twin.penetration(joint)),
            )
            for twin in twins
        ]
        depth = ours.penetration.values[:, i]
        calm = (np.abs(at[:, None] - ours.event_time.values) > NEAR).all(axis=1)
        for k, exact in enumerate((begins, force, depth)):
            rows = [each[k] for each in found]
            if k == 1:
                rows, exact = [row[calm] for row in rows], exact[calm]
            assert all(len(row) == len(exact) for row in rows)
            changes = [np.abs(row - rows[-1]).max() / h for row, h in zip(rows[:-1], STEPS, strict=False)]
            bound = SPARE * max(changes) * STEPS[-1]
            assert np.abs(rows[-1] - exact).max() < bound, (joint.name, k)
            assert np.abs(rows[-1] - exact).max() < (2e-6, 0.01 * force.max(), 0.01 * depth.max())[k]
