"""A run that is left and taken up again is the run that was not, to the last bit."""

from __future__ import annotations

import numpy as np
import pytest

import jointplay as jp
from jointplay.solver.motion import trajectory

LOOSE = jp.catalog.chunmei2002(clearance=2.9e-4, gear_ratio=3.0)
SOFT = jp.catalog.soft_impact_pair(gap=1.0, stiffness=50.0, damping=1.0)


def fixed(attempts):
    """A pace of so many attempts a piece, however long they take."""
    found = trajectory.Pace()
    found.size, found.learn = attempts, lambda made, seconds: None
    return found


def records(mechanism, turns):
    """All that a run writes down."""
    found = jp.simulate(
        mechanism, turns=turns, rtol=1e-9, section=jp.CrankAngle(angle=0.5), samples_per_turn=97
    )
    stepped = jp.simulate(mechanism, turns=turns, rtol=1e-9, steps=True)
    return [
        dataset[name].values
        for dataset in (found, stepped)
        for name in sorted(dataset.variables)
        if name != "wall_time"
    ]


@pytest.mark.parametrize(("mechanism", "turns"), [(LOOSE, 2), (SOFT, 3)])
@pytest.mark.parametrize(("rows", "attempts"), [(40, 10**6), (4096, 1), (31, 7)])
def test_short_logs_and_short_pieces_change_no_bit(monkeypatch, mechanism, turns, rows, attempts):
    whole = records(mechanism, turns)
    monkeypatch.setattr(trajectory, "LOG_ROWS", rows)
    monkeypatch.setattr(trajectory, "pace", lambda *_: fixed(attempts))
    pieces = records(mechanism, turns)
    assert all(
        np.array_equal(a, b, equal_nan=a.dtype.kind == "f") for a, b in zip(whole, pieces, strict=True)
    )


def test_progress_rises_to_one():
    seen = []
    jp.simulate(LOOSE, turns=1, progress=seen.append)
    assert seen == sorted(seen)
    assert seen[-1] == 1.0
