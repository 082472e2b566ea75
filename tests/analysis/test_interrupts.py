"""Every analysis answers while it runs: to Ctrl-C, to who asks how far it is; its numbers do not show it.

Requests here would last minutes or days. Most follow a soft impact pair, whose turn takes some 30 µs.
"""

from __future__ import annotations

import os
import signal
import time

import numpy as np
import pytest

import jointplay as jp
from jointplay.analysis.coexisting.attractors import SHARES
from jointplay.analysis.exponents.growth import growth
from jointplay.analysis.signals.dimension import correlation_sum
from jointplay.analysis.states.basins import basins
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.motion import ensemble_runs, trajectory
from jointplay_lab.paper import fixed_steps
from jointplay_lab.paper.fixed_steps import March
from jointplay_lab.scheme.waveform import waveform

LONG = 3_000_000  # turns
SOFT = jp.catalog.soft_impact_pair(gap=1.0, stiffness=50.0, damping=1.0)
LOOSE = jp.catalog.chunmei2002(clearance=2.9e-4, gear_ratio=3.0)
PLANE = {"y": (0.0, 0.5, 2), "v": (0.0, 0.5, 2)}
REGION = {"y": (0.0, 0.5), "v": (0.0, 0.5)}
WIDE = {"y": (0.0, 0.5, 9), "v": (0.0, 0.5, 9)}  # two cells
RANGE = {"parameter": "gap", "range": (0.9, 1.1), "max_points": 4, "max_branches": 1}
BENT = LOOSE.replace(elastic=("coupler",), elements=1)
CALLS = {
    "simulate": lambda n, **to: jp.simulate(SOFT, turns=1, transient=n, **to),
    "poincare": lambda n, **to: jp.poincare(SOFT, turns=1, transient=n, **to),
    "bifurcation": lambda n, **to: jp.bifurcation(SOFT, over={"gap": [1.0]}, transient=n, n_jobs=1, **to),
    "bifurcation, exponents": lambda n, **to: jp.bifurcation(
        SOFT, over={"gap": [1.0]}, turns=9, transient=0, exponents=1, lyapunov_turns=n, n_jobs=1, **to
    ),
    "lyapunov, transient": lambda n, **to: jp.lyapunov(SOFT, turns=1, transient=n, **to),
    "lyapunov, block": lambda n, **to: jp.lyapunov(SOFT, turns=300 * n, **to),
    "lyapunov, twin": lambda n, **to: jp.lyapunov(SOFT, turns=1, twin_turns=n, **to),
    "sensitivity": lambda n, **to: jp.sensitivity(SOFT, transient=n, turns=1, **to),
    "sensitivity, plane": lambda n, **to: jp.sensitivity(SOFT, plane=PLANE, turns=n, n_jobs=1, **to),
    "basins": lambda n, **to: basins(SOFT, plane=PLANE, transient=n, n_jobs=1, **to),
    "periodic_orbit": lambda n, **to: jp.periodic_orbit(SOFT, transient=n, **to),
    "periodic_orbit, period": lambda n, **to: jp.periodic_orbit(SOFT, period=n, transient=0, **to),
    "continuation": lambda n, **to: jp.continuation(SOFT, transient=n, **RANGE, **to),
    "chaos_test": lambda n, **to: jp.chaos_test(SOFT, turns=100, transient=n, **to),
    "spectrum": lambda n, **to: jp.spectrum(SOFT, turns=100, transient=n, **to),
    "dimension": lambda n, **to: jp.dimension(SOFT, turns=100, transient=n, **to),
    "growth": lambda n, **to: growth(SOFT, transient=n, **to),
    "work_precision": lambda n, **to: jp.work_precision(
        SOFT, turns=n, peers=[], tolerances=[1e-8], rounds=1, **to
    ),
    "readings": lambda n, **to: jp.readings(
        transient=n, panels=["a"], readings=["as_printed"], n_jobs=1, **to
    ),
    "claims": lambda n, **to: jp.claims(transient=n, growth_turns=n, n_jobs=1, **to),
    "assess": lambda n, **to: jp.assess(LOOSE, transient=n, n_jobs=1, **to),
    "stress": lambda n, **to: jp.stress(scenes=1, turns=n, max_steps=10**9, n_jobs=1, **to),
    "basins of an ensemble": lambda n, **to: basins(
        LOOSE,
        plane={"eccentricity_ratio_x": (-0.5, 0.5, 8), "eccentricity_ratio_y": (-0.5, 0.5, 8)},
        transient=n,
        ensemble=True,
        uncertainty=False,
        n_jobs=1,
        **to,
    ),
    "covariant": lambda n, **to: jp.covariant(SOFT, turns=n, **to),
    "gradient": lambda n, **to: jp.gradient(SOFT, turns=n, **to),
    "gradient, orbit": lambda n, **to: jp.gradient(SOFT, orbit=True, transient=n, **to),
    "optimise": lambda n, **to: jp.optimise(
        SOFT, by={"gap": (0.9, 1.1)}, most="largest:state:v", transient=n, **to
    ),
    "curve": lambda n, **to: jp.curve(
        SOFT, plane={"gap": (0.9, 1.1), "stiffness": (40.0, 60.0)}, transient=n, **to
    ),
    "attractors": lambda n, **to: jp.attractors(
        SOFT, over={"gap": [1.0]}, region=REGION, starts=2, transient=n, ensemble=False, n_jobs=1, **to
    ),
    "tipping": lambda n, **to: jp.tipping(
        SOFT, region=REGION, starts=2, transient=n, ensemble=False, n_jobs=1, **to
    ),
    "basins in workers": lambda n, **to: basins(SOFT, plane=WIDE, transient=n, n_jobs=2, **to),
}
ELASTIC = {
    "waveform": lambda n, **to: waveform(BENT, turns=n, **to),
    "scheme_comparison": lambda n, **to: jp.scheme_comparison(BENT, start_turn=[n], **to),
}
DEAR = {"assess", "stress", "basins of an ensemble", *ELASTIC}  # these compile structures of their own
DEAR |= {"curve", "tipping"}  # and these go on for some 20 s
SOON = 30.0  # s: a generous limit for a machine that does much else


def walk(value, name, longest=()):
    """A parameter under its name."""
    marks = [pytest.mark.nightly] if name in longest else [pytest.mark.long] if name in DEAR else []
    return pytest.param(value, id=name, marks=marks)


DEAREST = ("stress", "waveform")


class Enough(Exception):
    """What a user's `progress` may raise."""


@pytest.mark.long
@pytest.mark.parametrize("call", [walk(call, name, DEAREST) for name, call in (CALLS | ELASTIC).items()])
def test_an_analysis_answers_while_it_runs(call):
    """It tells how far it is, goes on doing so, and ends where it is interrupted."""
    told, sent = [], []

    def progress(fraction):
        told.append(fraction)
        if len(told) == 3:
            sent.append(time.monotonic())
            os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        call(LONG, progress=progress)
    assert time.monotonic() - sent[0] < SOON
    assert told == sorted(told)
    assert told[-1] < 1.0


@pytest.mark.parametrize("name", ["lyapunov, block", "sensitivity, plane", "basins", "work_precision"])
def test_what_progress_raises_is_raised(name):
    def progress(fraction):
        raise Enough

    with pytest.raises(Enough):
        CALLS[name](LONG, progress=progress)


ENDED = [name for name in CALLS if name not in ("claims", "readings")]


@pytest.mark.nightly
@pytest.mark.parametrize("name", [walk(name, name, ("assess", "tipping")) for name in ENDED])
def test_progress_never_falls_and_ends_at_one(name):
    told = []
    CALLS[name](30, progress=told.append)
    assert told == sorted(told)
    assert told[0] >= 0.0
    assert told[-1] == 1.0


@pytest.mark.parametrize("name", ["spectrum", "chaos_test", "dimension"])
def test_most_of_the_progress_is_told_while_a_motion_is_followed(name):
    told = []
    CALLS[name](30, progress=told.append)
    assert max(share for share in told if share < 1.0) > 0.5


def test_following_starts_is_the_largest_stage_of_attractors_and_ends_at_its_share():
    told = []
    CALLS["attractors"](30, progress=told.append)
    assert SHARES[1] == max(np.diff(SHARES))
    assert told[:2] == [0.0, SHARES[1]]


def fixed(attempts):
    """What stands for `trajectory.pace`: pieces of so many attempts, however long they take."""

    def pace(*_):
        found = trajectory.Pace()
        found.size, found.learn = attempts, lambda made, seconds: None
        return found

    return pace


def test_the_pace_is_learnt_from_each_piece_alone(monkeypatch):
    done, learnt, pace = [0], [], trajectory.Pace()
    monkeypatch.setattr(pace, "learn", lambda made, seconds: learnt.append(made))

    def call(limit):
        done[0] = limit
        return 1

    assert trajectory.in_pieces(call, lambda: done[0], pace, 1, 3 * pace.size + 8) == 1
    assert learnt == [pace.size, pace.size, pace.size, 8]


def values(dataset):
    """All that a dataset holds but for times of the machine."""
    return {name: each.values for name, each in dataset.variables.items() if name != "wall_time"}


WITH_TANGENTS = {
    "exponents": lambda: jp.lyapunov(LOOSE, turns=3, transient=1, exponents=2),
    "no neighbours": lambda: jp.lyapunov(SOFT, turns=5, exponents="all"),
    "an orbit": lambda: jp.periodic_orbit(SOFT, transient=20),
    "a branch": lambda: jp.continuation(SOFT, transient=20, **RANGE),
    "a field": lambda: jp.sensitivity(SOFT, plane=PLANE, turns=3, n_jobs=1),
}


@pytest.mark.parametrize("call", WITH_TANGENTS.values(), ids=WITH_TANGENTS)
def test_tangents_in_short_pieces_are_the_same_to_the_last_bit(monkeypatch, call):
    monkeypatch.setattr(trajectory, "pace", fixed(10**9))
    whole = values(call())
    monkeypatch.setattr(trajectory, "pace", fixed(7))
    cut = values(call())
    assert whole.keys() == cut.keys()
    for name, each in whole.items():
        np.testing.assert_array_equal(cut[name], each, err_msg=str(name))


@pytest.mark.long
def test_ensembles_in_short_pieces_are_the_same_to_the_last_bit(monkeypatch):
    scenes = [
        assemble(LOOSE.replace(clearance=e), section="angle:crank") for e in np.geomspace(1e-5, 3e-4, 11)
    ]
    cut = {"level": scenes[0].crank_angle + 1.0, "period": 2 * np.pi, "direction": 1, "stop_after": 2}
    asked = [trajectory.Request(1.0, 1e-6, events=True, log_from=-1.0, **cut) for _ in scenes]
    found = []
    for attempts in (10**9, 3):
        monkeypatch.setattr(ensemble_runs, "pace", fixed(attempts))
        found.append(ensemble_runs.follow_ensemble(scenes, asked))
    for one, other in zip(*found, strict=True):
        assert one.counts == other.counts
        for name in ("samples", "events", "sections", "start"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


@pytest.mark.nightly
def test_fixed_steps_in_short_pieces_are_the_same_to_the_last_bit(monkeypatch):
    model = assemble(LOOSE)
    found = []
    for attempts in (10**9, 7):
        monkeypatch.setattr(fixed_steps, "Pace", fixed(attempts))
        start = np.concatenate([[0.0], model.state])
        found.append(March.of(model)(start, 1e-5, 500))
    np.testing.assert_array_equal(*found)


def test_pieces_take_about_a_tenth_of_a_second_whatever_an_attempt_costs():
    for cost in (1e-6, 1e-3, 0.02):
        pace = trajectory.Pace()
        for _ in range(10):
            pace.learn(pace.size, pace.size * cost)
        assert pace.size * cost == pytest.approx(trajectory.PIECE, rel=0.2)
        pace.learn(3, 3 * cost)  # a run that soon ended teaches nothing
        assert pace.size * cost == pytest.approx(trajectory.PIECE, rel=0.2)


def test_pairs_counted_block_by_block_are_all_pairs():
    points = np.random.default_rng(1).normal(size=(1500, 2))
    at = np.array([0.1, 0.5, 2.0])
    apart = np.linalg.norm(points[:, None] - points[None], axis=2)
    lags = np.abs(np.subtract.outer(np.arange(1500), np.arange(1500)))
    expected = [np.mean(apart[lags >= 3] <= r) for r in at]
    np.testing.assert_allclose(correlation_sum(points, at, 3), expected, rtol=1e-12)
