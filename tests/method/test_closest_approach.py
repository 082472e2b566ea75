"""Closest approaches in flight against the turning points of a finely sampled motion."""

import numpy as np

from jointplay import catalog
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.motion.trajectory import Request, follow

BEGIN, END, SAMPLES = 20.0, 150.0, 130_001


def test_every_turning_point_in_flight_is_logged():
    """Gears with backlash: within the dead zone the motion turns back short of either side."""
    model = assemble(catalog.gear_backlash(0.1, 0.2, 0.9, 0.05))
    at = np.linspace(BEGIN, END, SAMPLES)
    records = follow(model, Request(END, 1e-11, misses=True, log_from=BEGIN, at=at))
    y, velocity = records.samples[:, 1], records.samples[:, 2]
    turns = np.flatnonzero((velocity[1:] * velocity[:-1] < 0) & (np.abs(y[1:]) < 1))
    drive = velocity[turns] > 0  # turns back short of +1, else short of -1
    gaps = 1 - np.where(drive, 1, -1) * y[turns]
    logged = records.misses[np.abs(records.misses[:, 3]) < 1]
    assert len(logged) == len(turns) > 10
    assert logged[:, 0].tolist() == np.where(drive, 0, 1).tolist()
    assert np.max(np.abs(logged[:, 2] - at[turns])) < 2 * (at[1] - at[0])
    assert np.max(np.abs(logged[:, 1] - gaps)) < 1e-5
    assert np.max(np.abs(logged[:, 4])) < 1e-7  # at rest


def test_looking_changes_nothing():
    model = assemble(catalog.chunmei2002(2.9e-4, gear_ratio=3.0))
    ends = [
        follow(
            model, Request(3 * model.period, at=np.array([3 * model.period]), misses=looking, log_from=0.0)
        )
        for looking in (False, True)
    ]
    assert np.array_equal(ends[0].samples, ends[1].samples)
    assert len(ends[0].misses) == 0
