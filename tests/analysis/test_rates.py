"""Recorded quantities against a run at 1e-12: accelerations too, where the motion steps over fast decays."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import jointplay as jp
from jointplay.analysis.quantities import BALANCE, LINKAGE, recorded
from jointplay.solver.equations.parameters import parameter_names
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.parts.joints import Friction
from tests.support.belt import contact
from tests.support.linkages import jointed

RTOL, REFERENCE = 1e-8, 1e-12
A_TURN = 1000  # tolerated errors of a speed in a turn: the tolerated error of its acceleration
OF_RANGE = 1000  # rtol: what the tolerance of the states makes of any quantity, in units of its range
STEPS = 10  # tolerated errors of a step that a recorded speed may have
AWAY = 20  # times the largest difference of an event's time: nearer, a sample may lie on its other side


def paper(**changes):
    return jp.catalog.chunmei2002(**{"clearance": 2.9e-5, "gear_ratio": 15.0} | changes)


def smoothed():
    return jointed(paper(), friction=Friction(law="tanh", coefficient=0.01, velocity=1e-3))


RIGID = {
    "stiff motor": (paper, {}, {"transient": 1, "turns": 1}),
    "from the start": (paper, {}, {"turns": 0.3}),
    "softer motor": (paper, {"gear_ratio": 3.0}, {"turns": 1}),
    "more play": (paper, {"clearance": 2.9e-4}, {"transient": 1, "turns": 1}),
    "more friction": (paper, {"friction": 0.3}, {"transient": 1, "turns": 1}),
    "ideal": (paper, {"clearance": 0}, {"transient": 0.2, "turns": 1}),
}
OTHERS = {
    "no tension": (paper, {"tension": False}, {"transient": 0.5, "turns": 1}),
    "two joints": (paper, {"clearance": {"B": 2.9e-5, "C": 2.9e-5}}, {"transient": 0.5, "turns": 1}),
    "smoothed friction": (smoothed, {}, {"transient": 0.5, "turns": 0.5}),
    "elastic coupler": (paper, {"elastic": ("coupler",)}, {"transient": 0.2, "turns": 0.5}),
}


def scales(mechanism) -> dict[str, float]:
    """Times rtol: the tolerated error of what is small beside the motion that it is part of."""
    model, speed = assemble(mechanism), math.tau / assemble(mechanism).period
    named = dict(zip(parameter_names(model.structure), model.numbers, strict=True))
    sliding = speed * max(link.length for link in mechanism.links)
    return {
        "angular_velocity": STEPS * speed,
        "angular_acceleration": A_TURN * speed / model.period,
        "normal_velocity": STEPS * sliding,
        "tangential_velocity": STEPS * sliding,
        "drive_torque": STEPS * named["a"],
    }


def differences(mechanism, found, true, rtol: float) -> dict[str, float]:
    """Largest difference of every recorded quantity, in units of what is tolerated."""
    scale, away = scales(mechanism), np.full(true.sizes["time"], np.inf)
    if true.sizes["event"]:
        events = true.event_time.values
        assert found.sizes["event"] == len(events)
        unsure = AWAY * np.abs(events - found.event_time.values).max() + 1e-12
        away = np.abs(true.time.values[:, None] - events).min(axis=1) - unsure
    result = {}
    for name in set(LINKAGE) & set(true) - {"mode"}:
        one, other = found[name].values[away > 0], true[name].values[away > 0]
        tolerated = rtol * (OF_RANGE * np.ptp(other, axis=0) + scale.get(name, 0.0))
        result[name] = float(np.max(np.abs(one - other) / np.maximum(tolerated, 1e-300)))
    return result


def wrong(model, rtol: float = RTOL) -> dict[str, float]:
    """What differs by more than is tolerated between runs at a tolerance and at 1e-12."""
    make, changes, span = model
    mechanism = make(**changes)
    found, true = (jp.simulate(mechanism, rtol=each, **span) for each in (rtol, REFERENCE))
    return {k: v for k, v in differences(mechanism, found, true, rtol).items() if not v <= 1.0}


@pytest.mark.parametrize("model", RIGID.values(), ids=RIGID)
def test_every_recorded_quantity_is_right_within_the_tolerance(model):
    assert wrong(model) == {}


@pytest.mark.long
@pytest.mark.parametrize("model", OTHERS.values(), ids=OTHERS)
def test_every_recorded_quantity_is_right_in_other_scenes(model):
    assert wrong(model) == {}


@pytest.mark.long
@pytest.mark.parametrize("rtol", [1e-6, 1e-7, 1e-9])
@pytest.mark.parametrize("model", RIGID.values(), ids=RIGID)
def test_every_recorded_quantity_is_right_at_other_tolerances(model, rtol):
    assert wrong(model, rtol) == {}


@pytest.mark.nightly
def test_what_holds_a_journal_in_a_rigid_bearing_is_right_as_the_accelerations_are_that_it_follows_from():
    mechanism = jointed(paper(clearance=2.9e-4), contact=contact("restitution", restitution=0.0))
    span = {"transient": 0.5, "turns": 0.5, "record": ["normal_force", "mode"]}
    found, true = (jp.simulate(mechanism, rtol=each, **span).sel(joint="B") for each in (RTOL, REFERENCE))
    assert found.sizes["event"] >= 5
    rests = (found.mode > 0) & (found.mode == true.mode)
    assert rests.sum() > 300
    error = float(abs(found.normal_force - true.normal_force).where(rests).max())
    assert error < RTOL * OF_RANGE * float(np.ptp(true.normal_force.values)) / 10


def test_a_smooth_motion_s_accelerations_are_the_slopes_of_its_speeds():
    mechanism = paper(clearance=0)
    run = jp.simulate(mechanism, transient=0.2, turns=1, record=["angular_velocity", "angular_acceleration"])
    slopes = CubicSpline(run.time, run.angular_velocity)(run.time, 1)[5:-5]
    error = np.abs(run.angular_acceleration.values[5:-5] - slopes)[:, 0]
    assert error.max() < RTOL * scales(mechanism)["angular_acceleration"]


@pytest.fixture(scope="module")
def linkage():
    return paper()


@pytest.fixture(scope="module")
def plain(linkage):
    """A run without accelerations: its last turn holds three slip reversals or more."""
    run = jp.simulate(linkage, transient=1, turns=1, record=["angle", "angular_velocity"])
    assert np.sum(run.event_kind.values == 3) >= 3
    return run


def test_asking_for_accelerations_changes_nothing_else(linkage, plain):
    more = jp.simulate(linkage, transient=1, turns=1)
    for name in ("angle", "angular_velocity", "event_time", "n_steps", "n_evaluations"):
        np.testing.assert_array_equal(more[name], plain[name])


def test_an_acceleration_does_not_depend_on_what_else_is_sampled(linkage, plain):
    names = ["angular_acceleration", "reaction"]
    every = jp.simulate(linkage, transient=1, turns=1, record=names)
    chosen = [*range(5, 721, 7), *(np.searchsorted(plain.time, plain.event_time.values) % 721)]
    chosen = np.unique(chosen)
    some = jp.simulate(linkage, turns=2, at=plain.time.values[chosen], record=names)
    for name in names:
        np.testing.assert_array_equal(some[name], every[name][chosen])


def test_accelerations_are_right_at_the_integrator_s_own_points(linkage):
    own = jp.simulate(linkage, transient=1, turns=1, steps=True, record=["angular_acceleration", "mode"])
    times, first = np.unique(own.time.values, return_index=True)
    true = jp.simulate(linkage, turns=2, at=times, rtol=REFERENCE, record=["angular_acceleration"])
    away = np.abs(times[:, None] - own.event_time.values).min(axis=1) > 1e-9
    error = np.abs(own.angular_acceleration.values[first] - true.angular_acceleration.values)[away]
    tolerated = RTOL * scales(linkage)["angular_acceleration"]
    assert np.sum(away) > 100
    assert error[:, 0].max() < tolerated


def test_accelerations_are_right_at_section_points_soon_after_an_event(linkage, plain):
    reversal = plain.event_time.values[-1]
    places = np.interp(reversal + np.array([2e-5, 2e-4]), plain.time, plain.angle[:, 0])
    for place in places:
        cut = jp.CrankAngle(angle=float(place % math.tau))
        found, true = (
            jp.poincare(linkage, cut, turns=1, transient=1, rtol=rtol, record=["angular_acceleration"])
            for rtol in (RTOL, REFERENCE)
        )
        error = np.abs(found.angular_acceleration.values - true.angular_acceleration.values)[:, 0]
        assert error.max() < RTOL * scales(linkage)["angular_acceleration"]


OFF = np.array([-1e-4, -1e-5, -3e-6, -1e-6, -3e-7, 3e-7, 1e-6, 3e-6, 1e-5, 1e-4])  # s, from an event


def largest_miss(clearance: float, turns: float = 2.0) -> float:
    """Of the crank's acceleration at the default tolerance, at even times and beside every event.

    In units of the largest after a thousandth of a turn; in these turns chaos has not begun to tell.
    """
    mechanism, words = paper(clearance=clearance), ["angular_acceleration"]
    true = jp.simulate(mechanism, turns=turns, rtol=REFERENCE, record=words, samples_per_turn=1)
    period, end = float(true.turn_period_nominal), float(true.time[-1])
    at = np.concatenate([np.linspace(0.0, end, 6001), (true.event_time.values[:, None] + OFF).ravel()])
    asked = {"turns": turns, "record": words, "at": np.sort(at[(at > 1e-3 * period) & (at < end)])}
    one, other = (
        jp.simulate(mechanism, rtol=rtol, **asked).angular_acceleration.sel(link="crank").values
        for rtol in (RTOL, REFERENCE)
    )
    return float(np.abs(one - other).max() / np.abs(other).max())


@pytest.mark.parametrize("clearance", PLAYS := [2e-6, 2.9e-5, 2.9e-4])
def test_samples_of_the_crank_s_acceleration_are_right_beside_events(clearance):
    assert largest_miss(clearance) < 0.02


@pytest.mark.nightly
def test_so_they_are_on_another_processor():
    """One without fused multiply-add, for which everything is compiled."""
    root = Path(__file__).parents[2]
    program = f"from {__name__} import PLAYS, largest_miss; print(max(map(largest_miss, PLAYS)))"
    chosen = os.environ | {"NUMBA_CPU_NAME": "x86-64", "NUMBA_CPU_FEATURES": ""}
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", program],
        env=chosen,
        cwd=root,
        capture_output=True,
        text=True,
        check=True,
    )
    assert 0.0 < float(done.stdout) < 0.02


def test_all_that_can_be_recorded_is_looked_at(linkage):
    assert {*recorded(None, linkage)} <= {*LINKAGE}
    assert not {*LINKAGE} & {*BALANCE}
