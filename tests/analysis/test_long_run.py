"""A long run drifts nowhere: a hundred thousand turns of a periodic motion."""

from __future__ import annotations

import numpy as np
import pytest

import jointplay as jp

TURNS, RTOL = 100_000, 1e-8


@pytest.mark.nightly
def test_a_hundred_thousand_turns():
    """They end in the periodic state that shooting finds at 1e-12, and the energy balance is closed."""
    system = jp.catalog.chunmei2002(gear_ratio=3.0)
    flows = ["energy_residual", "drive_work", "joint_work"]
    found = jp.poincare(
        system, turns=1, transient=TURNS - 1, rtol=RTOL, record=["angle", "angular_velocity", *flows]
    ).isel(turn=-1)
    orbit = jp.periodic_orbit(system, rtol=1e-12).orbit_state.values
    assert found.status == 0
    assert float(found.angle.sel(link="crank")) == pytest.approx(2 * np.pi * TURNS, rel=1e-14)
    apart = found.angle.values - orbit[:3]
    assert np.abs(apart - 2 * np.pi * np.round(apart / (2 * np.pi))).max() < 1e-6
    assert found.angular_velocity.values == pytest.approx(orbit[3:], abs=1e-6 * system.drive.no_load_speed)
    turn = jp.simulate(system, turns=1, transient=50, rtol=RTOL, record=["drive_work"])
    flowed = TURNS * float(np.abs(np.diff(turn.drive_work)).sum())
    assert abs(found.energy_residual) < 1e-3 * RTOL * flowed
    assert 0.0 < float(found.joint_work) < float(found.drive_work)
