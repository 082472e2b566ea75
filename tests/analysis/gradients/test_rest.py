"""Derivatives through rest on a rigid wall, and its end, against differences of the motion itself."""

from __future__ import annotations

import pytest

import jointplay as jp
from jointplay.analysis.gradients.gradient_dataset import VERDICTS
from jointplay.analysis.quantities import EVENTS
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.directions import along
from jointplay.solver.mechanism.records import Harmonic, SpeedCycle, SpeedProfile
from tests.support import driven, driven_table
from tests.support.driven_scenes import pinned

OK = VERDICTS.index("ok")
KEYS = ("clearance", "gravity", "links.coupler.mass")
BY = {"clearance": 1e-4, "gravity": 9.8, "links.coupler.mass": 1.0, "joints.B.friction.coefficient": 0.3}
SHARES = (1e-6, 1e-5, 1e-4)
CASES = [  # restitution, friction, speed, duration, events
    (0.0, 0.0, 30.0, 0.15, {"impact", "rest"}),
    (0.0, 0.0, 30.0, 0.2, {"impact", "rest", "separation"}),
    (0.8, 0.0, 30.0, 0.15, {"impact", "rest"}),
    (0.8, 0.0, 60.0, 0.1, {"impact", "rest", "separation"}),
    *(
        pytest.param(r, 0.3, 30.0, 0.1, each, marks=pytest.mark.nightly)
        for r, each in (
            (0.0, {"impact", "rest", "slip_onset"}),
            (0.5, {"impact", "rest"}),
        )
    ),
]
PROFILE = SpeedProfile(link="crank", start=30.0, end=60.0, time=0.1)
CYCLE = SpeedCycle(link="crank", constant=40.0, harmonics=(Harmonic(order=1, sine=6.0),), frequency=30.0)
IMPOSED = {  # mechanism, parameter, its value, duration
    "rebounds": (pinned(0.8), "clearance", 1e-4, 0.15),
    "plastic": (pinned(0.0), "clearance", 1e-4, 0.2),
    "rough": (pinned(0.0, 0.3).replace(drive=PROFILE), "joints.B.friction.coefficient", 0.3, 0.1),
    "profile": (pinned(0.5, 0.3).replace(drive=PROFILE), "drive.end", 60.0, 0.1),
    "cycle": (pinned(0.8).replace(drive=CYCLE), "drive.constant", 40.0, 0.1),
    "two bearings": (pinned(0.5, clearances={"B": 1e-4, "C": 2e-4}), "joints.C.clearance", 2e-4, 0.1),
}


@pytest.mark.parametrize(("restitution", "friction", "speed", "duration", "events"), CASES)
def test_derivatives_are_those_of_neighbours(restitution, friction, speed, duration, events):
    """A landing at once, and the end of a row of rebounds, whichever of them is the last."""
    mechanism = pinned(restitution, friction, speed)
    model, keys = assemble(mechanism), KEYS if not friction else tuple(BY)
    assert {EVENTS[int(kind)] for _, kind in driven.end(model, duration)[1]} == events
    tight, loose = (
        driven.by_tangents(mechanism, {key: BY[key] for key in keys}, duration, rtol=rtol)
        for rtol in (1e-12, 1e-8)
    )
    for key, exact, other in zip(keys, tight, loose, strict=True):
        tried = [driven.by_differences(mechanism, key, BY[key], duration, share) for share in SHARES]
        assert min(driven.distance(exact, one, model) for one in tried if one is not None) < 1e-6, key
        assert driven.distance(other, exact, model) < 1e-6, key


@pytest.mark.parametrize("restitution", [pytest.param(0.0, marks=pytest.mark.long), 0.8])
def test_the_error_that_is_told_is_met(restitution):
    """Over a turn, by differences of two motions."""
    mechanism, step = pinned(restitution, 0.0, 30.0), 1e-9
    found = jp.gradient(mechanism, of=["end:angle:rocker"], by=["clearance"])
    assert int(found["derivative_status"]) == OK

    def angle(clearance):
        run = {"turns": 1, "samples_per_turn": 2, "record": ["angle"], "rtol": 1e-13}
        return float(
            jp.simulate(mechanism.replace(clearance={"B": clearance}), **run).angle.sel(link="rocker")[-1]
        )

    derivative, error = (found[name].item() for name in ("derivative", "error"))
    quotient = driven.quotient(angle, 1e-4, step)
    assert abs(derivative - quotient) < 10 * error + 1e-5 * abs(quotient)


@pytest.mark.nightly
@pytest.mark.parametrize("name", IMPOSED)
def test_works_of_an_imposed_speed_are_those_of_neighbours(name):
    """The impulses of the drive do work, and their derivative goes with the tangents through every impact."""
    mechanism, key, value, duration = IMPOSED[name]
    model = assemble(mechanism, powers=True)
    direction = along(driven.models(mechanism, key, powers=True), value, key)
    exact = driven_table.by_tangents(model, direction, duration)
    works, errors = slice(len(model.state), None), []
    for share in (1e-6, 1e-5, 1e-4):
        found = driven.by_differences(mechanism, key, value, duration, share, powers=True)
        if found is not None:
            errors.append(max(abs(exact - found)[works] / abs(found)[works]))
    assert min(errors) < 1e-6
