"""Derivatives through rest on a rigid wall, and its end, against differences of the motion itself."""

from __future__ import annotations

import pytest

import jointplay as jp
from jointplay.analysis.gradients.gradient_dataset import VERDICTS
from jointplay.analysis.quantities import EVENTS
from jointplay.mechanism.assemble import assemble
from tests.support import driven
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
        pytest.param(r, 0.3, 30.0, 0.1, each, marks=pytest.mark.long)
        for r, each in (
            (0.0, {"impact", "rest", "slip_onset"}),
            (0.5, {"impact", "rest"}),
        )
    ),
]


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


@pytest.mark.parametrize("restitution", [0.0, 0.8])
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
