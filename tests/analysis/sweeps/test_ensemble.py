"""Many motions at once against the one-trajectory kernel: events, ends, sections, statuses, counts."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from jointplay.analysis.quantities import STATUS
from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.motion import ensemble_runs
from jointplay.solver.motion.eligibility import exclusion
from jointplay.solver.motion.trajectory import Request, follow
from jointplay_lab.stress.scenes import draw

OTHERS = [
    pytest.param(number, marks=pytest.mark.nightly) for number in (258, 356, 972, 1266)
]  # two structures
STATE = slice(3, 9)  # of a row of events or sections: contact, kind, time, angles, speeds, mode


def model(clearance, gear, friction, **changes):
    """The linkage whose crank's angle is watched."""
    changes |= {"clearance": float(clearance), "gear_ratio": gear, "friction": friction}
    return assemble(catalog.chunmei2002(**changes), section="angle:crank")


def asked(model, turns, rtol=1e-5, **fields):
    """A run with events, cut a radian from the start and each turn on."""
    cut = {"level": model.crank_angle + 1.0, "period": math.tau, "direction": 1}
    return Request(turns * model.period, rtol, events=True, log_from=-1.0, **cut | fields)


def apart(model, a, b):
    """Largest difference of states in rad and nominal speeds, row by row."""
    return np.abs(a - b) / np.repeat([1.0, math.tau / model.period], 3)


@pytest.mark.parametrize(
    ("gear", "friction", "turns"),
    [pytest.param(3.0, 0.01, 3, marks=pytest.mark.long), (15.0, 0.01, 1), (3.0, 0.3, 2), (15.0, 0.3, 1)],
)
def test_events_ends_and_sections_are_those_of_one_trajectory(gear, friction, turns):
    scenes = [model(e, gear, friction) for e in np.geomspace(2.9e-5, 1e-4, 10)]
    found = ensemble_runs.follow_ensemble(scenes, [asked(each, turns, 1e-6) for each in scenes])
    kinds, worst = set(), []
    for each, records in zip(scenes, found, strict=True):
        end = np.array([turns * each.period])
        truth = follow(each, asked(each, turns, 1e-11, at=end))
        assert records.status == 0
        assert records.events[:, 1].tolist() == truth.events[:, 1].tolist()
        assert records.events[:, -1].tolist() == truth.events[:, -1].tolist()
        assert np.abs(records.events[:, 2] - truth.events[:, 2]).max() < 1e-5 * each.period
        assert records.samples[0, 0] == end[0]
        assert records.sections.shape == truth.sections.shape
        assert np.abs(records.sections[:, 3] - truth.sections[:, 3]).max() < 1e-14 * 30  # on it, to rounding
        worst.append(apart(each, records.samples[:, 1:7], truth.samples[:, 1:7]).max())
        worst.append(apart(each, records.sections[:, STATE], truth.sections[:, STATE]).max())
        kinds |= {*records.events[:, 1]}
    assert np.median(worst) < 2e-6
    assert max(worst) < 2e-4
    assert friction < 0.1 or {4.0, 5.0} <= kinds, "some stick, and slip again"


def test_looking_does_not_change_a_motion():
    each = model(4e-5, 3.0, 0.3)
    plain = ensemble_runs.follow_ensemble([each], [asked(each, 2, direction=0)])[0]
    cut = ensemble_runs.follow_ensemble([each], [asked(each, 2)])[0]
    assert cut.events.tobytes() == plain.events.tobytes()
    assert cut.samples.tobytes() == plain.samples.tobytes()
    assert len(cut.sections) == 2
    assert len(plain.sections) == 0


def test_sections_are_skipped_and_end_a_run():
    each = model(4e-5, 3.0, 0.01)
    whole = ensemble_runs.follow_ensemble([each], [asked(each, 6)])[0]
    found = ensemble_runs.follow_ensemble([each], [asked(each, 6, skip=2, stop_after=4)])[0]
    assert found.sections.tobytes() == whole.sections[2:4].tobytes()
    assert whole.sections[3, 2] <= found.samples[0, 0] < whole.sections[4, 2]


def test_a_crank_that_turns_backwards_is_cut():
    each = replace(model(4e-5, 3.0, 0.01), crank_speed=-1.0)
    each = replace(each, state=each.state * np.repeat([1.0, -1.0], 3))
    back = {"level": each.crank_angle - 1e-5, "direction": -1}
    found = ensemble_runs.follow_ensemble([each], [asked(each, 0.02, **back)])[0]
    truth = follow(each, asked(each, 0.02, 1e-10, **back))
    assert len(truth.sections) == 1
    assert apart(each, found.sections[:, STATE], truth.sections[:, STATE]).max() < 1e-5


@pytest.mark.parametrize("limit", [1, 7, 50])
def test_step_limit(limit):
    scenes = [model(e, 3.0, 0.01) for e in (3e-5, 5e-5)]
    for records in ensemble_runs.follow_ensemble(
        scenes, [asked(each, 2, max_steps=limit) for each in scenes]
    ):
        assert STATUS[records.status] == "step_limit"
        assert sum(records.counts[name] for name in ("n_steps", "n_rejected", "n_failed")) == limit


def test_chatter_and_divergence_are_those_of_one_trajectory():
    good = model(3e-5, 3.0, 0.01)
    crowded = replace(good, period=1e7)  # events within a second count as chatter
    request = asked(good, 6)
    lost = replace(good, state=np.array([*good.state[:3], 1e200, 0.0, 0.0]))
    unknown = replace(good, state=np.array([*good.state[:3], np.nan, 0.0, 0.0]))
    found = ensemble_runs.follow_ensemble([good, crowded, lost, unknown, good], [request] * 5)
    words = [STATUS[each.status] for each in found]
    assert words == [STATUS[follow(each, request).status] for each in (good, crowded, lost, unknown, good)]
    assert words[:3] == ["ok", "chatter", "diverged"]
    assert found[0].samples.tobytes() == found[-1].samples.tobytes()


def test_what_lanes_cannot_do_is_followed_alone():
    good = model(3e-5, 3.0, 0.01)
    sampled = asked(good, 1, at=np.array([0.5 * good.period]))
    ideal = assemble(catalog.chunmei2002(clearance=0.0))
    assert exclusion(good, sampled) == "records"
    assert exclusion(good, asked(good, 1, 1e-9)) == "tolerance"
    found = ensemble_runs.follow_ensemble([ideal, good, good], [Request(1.0), asked(good, 1), sampled])
    alone = follow(good, sampled)
    assert found[2].samples.tobytes() == alone.samples.tobytes()
    assert found[2].events.tobytes() == alone.events.tobytes()
    assert found[0].counts == follow(ideal, Request(1.0)).counts


def hard(number, *variants):
    """A model of the stress series."""
    case = draw(catalog.chunmei2002(), number, 0, variants or ("rigid", "no_tension", "frictionless"))
    return assemble(case.mechanism, case.initial)


@pytest.mark.nightly
def test_closest_approaches_are_those_of_one_trajectory():
    scenes = [hard(number, "rigid") for number in (74, 75, 79, 82, 92, 103, 106, 108, 174)]
    asks = [Request(each.period, 1e-7, events=True, misses=True, log_from=-1.0) for each in scenes]
    found = ensemble_runs.follow_ensemble(scenes, asks)
    unasked = ensemble_runs.follow_ensemble(scenes, [replace(ask, misses=False) for ask in asks])
    count = 0
    for each, ask, records, plain in zip(scenes, asks, found, unasked, strict=True):
        tight = follow(each, replace(ask, rtol=1e-11))
        ours, truth, scale = records.misses, tight.misses, each.clearances[0] ** 2
        # after roundings of the start in the middle, before small differences have grown, and no graze
        begin, end = 1e-4 * each.period, tight.events[:20, 2].max()
        ours, truth = (rows[(begin < rows[:, 2]) & (rows[:, 2] < end)] for rows in (ours, truth))
        ours, truth = (rows[rows[:, 1] > 1e-6 * scale] for rows in (ours, truth))
        assert len(ours) == len(truth)
        assert np.abs(ours[:, 2] - truth[:, 2]).max(initial=0) < 1e-4 * each.period
        assert np.abs(ours[:, 1] - truth[:, 1]).max(initial=0) < 1e-3 * scale
        assert apart(each, ours[:, STATE], truth[:, STATE]).max(initial=0) < 1e-3
        assert plain.events.tobytes() == records.events.tobytes()
        assert len(plain.misses) == 0
        count += len(ours)
    assert count >= 3


@pytest.mark.parametrize("before", [False, True])
@pytest.mark.parametrize("number", [pytest.param(92, marks=pytest.mark.long), 103, 110])
def test_a_section_beside_a_closest_approach_changes_nothing(number, before):
    each = hard(number, "rigid")
    ask = Request(each.period, 1e-7, events=True, misses=True, log_from=-1.0)
    (plain,) = ensemble_runs.follow_ensemble([each], [ask])
    miss = plain.misses[plain.misses[:, 2] > 1e-4 * each.period][0]
    level = float(miss[3]) + (-1e-9 if before else 1e-9)  # of the crank, in the same step
    (cut,) = ensemble_runs.follow_ensemble([each], [replace(ask, level=level, period=math.tau, direction=1)])
    assert cut.misses.tobytes() == plain.misses.tobytes()
    assert cut.events.tobytes() == plain.events.tobytes()
    assert abs(cut.sections[0, 2] - miss[2]) < 1e-8 * each.period
    assert np.abs(cut.sections[0, 3:6] - miss[3:6]).max() < 1e-7


@pytest.mark.parametrize("ahead", [-1e-9, 0.0, 1e-16, 1e-13, 1e-9])
def test_a_section_at_the_start_is_met_as_by_one_trajectory(ahead):
    each = model(4e-5, 3.0, 0.01)
    ask = asked(each, 0.1, level=each.crank_angle + ahead)
    (found,), alone = ensemble_runs.follow_ensemble([each], [ask]), follow(each, ask)
    assert (found.status, len(found.sections)) == (alone.status, len(alone.sections)) == (0, 1)
    assert np.abs(found.sections[0] - alone.sections[0]).max() < 1e-12


@pytest.mark.parametrize("number", [59, 84, 108, 109, 187, 440, 944, 4019, *OTHERS])
def test_hard_scenes_lose_no_event(number):
    """Scenes of analysis.test_hard_scenes: as many events in a row as the one-trajectory kernel has."""
    each = hard(number)
    request = Request(2 * each.period, 1e-6, events=True, log_from=-1.0, max_steps=10_000)
    assert not exclusion(each, request)
    (found,), truth = (
        ensemble_runs.follow_ensemble([each], [request]),
        follow(each, replace(request, rtol=1e-10)),
    )
    few = min(len(truth.events), 40)  # before small differences have grown
    assert few > 0
    assert found.events[:few, 1].tolist() == truth.events[:few, 1].tolist()
    assert np.abs(found.events[:few, 2] - truth.events[:few, 2]).max() < 1e-3 * each.period


@pytest.mark.long
def test_structures_do_not_mix():
    scenes = [model(3e-5, 3.0, 0.1), model(3e-5, 3.0, 0.0), model(4e-5, 3.0, 0.1)]
    assert scenes[0].structure != scenes[1].structure
    requests = [asked(each, 0.3) for each in scenes]
    for each, request, found in zip(
        scenes, requests, ensemble_runs.follow_ensemble(scenes, requests), strict=True
    ):
        (alone,) = ensemble_runs.follow_ensemble([each], [request])
        assert found.events.tobytes() == alone.events.tobytes()
        assert found.samples.tobytes() == alone.samples.tobytes()
