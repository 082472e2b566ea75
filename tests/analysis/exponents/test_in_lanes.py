"""Tangents beside each motion of an ensemble: growth, jumps and exponents against the flow of one motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import jointplay as jp
from jointplay import catalog
from jointplay.analysis.exponents.frame_growth import Stretch, grown, grown_together
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.motion.eligibility import ROUTES
from jointplay.solver.motion.trajectory import Request
from tests.support.laws_grid import mechanism

CLEARANCES = np.geomspace(2.9e-5, 1e-4, 10)
TIME, TRACE, VOLUME, UNRESOLVED, RATE, TANGENT = range(6)  # columns of a row


def model(clearance, friction=0.01, gear=3.0, **changes):
    """The linkage, whose crank's angle is watched, as in analysis.sweeps.test_ensemble."""
    changes |= {"clearance": float(clearance), "gear_ratio": gear, "friction": friction}
    return assemble(catalog.chunmei2002(**changes), section="angle:crank")


def asked(each, turns, rtol=1e-6, begin=0.0, count=1):
    """Exponents over so many turns."""
    return Stretch(Request(turns * each.period, rtol), count, begin * each.period)


def gains(run):
    """What the columns of a run gain from its first row to its last."""
    return run.rows[-1] - run.rows[0]


@pytest.mark.nightly
@pytest.mark.parametrize(("friction", "gear", "turns"), [(0.01, 3.0, 2), (0.3, 3.0, 2), (0.3, 15.0, 0.5)])
def test_tangents_are_those_of_one_motion(friction, gear, turns):
    scenes = [model(e, friction, gear) for e in CLEARANCES]
    found = grown_together(scenes, [asked(each, turns) for each in scenes])
    errors, apart = [], []
    for each, run in zip(scenes, found, strict=True):
        truth, alone = (grown(each, asked(each, turns, rtol)) for rtol in (1e-12, 1e-6))
        assert (run.status, ROUTES[run.route]) == (0, "in_lanes")
        assert run.rows[-1, TIME] == truth.rows[-1, TIME]
        assert run.neutral
        ours, theirs, true = gains(run), gains(alone), gains(truth)
        assert run.rows[-1, RATE] == pytest.approx(truth.rows[-1, RATE], abs=1e-3)
        assert ours[TRACE] == pytest.approx(true[TRACE], rel=1e-5)
        errors.append(abs(ours[TANGENT] - true[TANGENT]))
        apart.append(abs(theirs[TANGENT] - true[TANGENT]))
        lost = np.isneginf([ours[VOLUME], true[VOLUME]])
        assert lost[0] == lost[1], "both stick, or neither"
        if not lost[0]:
            doubt = 1e-3 + 3e-7 / truth.grazing  # the jump at a graze is the less certain, the closer that is
            assert ours[VOLUME] == pytest.approx(true[VOLUME], abs=doubt)
    assert np.median(errors) < max(1e-4, 5 * np.median(apart))
    assert max(errors) < max(2e-2, 10 * max(apart))


@pytest.mark.nightly
@pytest.mark.parametrize(("friction", "count"), [(0.01, 2), (0.3, 3), (0.01, 6), (0.3, 6)])
def test_several_tangents_are_those_of_one_motion(friction, count):
    """Those that a step shrinks beyond its tolerance are known by the volume alone, of a whole frame."""
    scenes = [model(e, friction) for e in CLEARANCES[::3]]
    found = grown_together(scenes, [asked(each, 2, count=count) for each in scenes])
    for each, run in zip(scenes, found, strict=True):
        assert (run.status, ROUTES[run.route]) == (0, "in_lanes")
        truth, alone = (grown(each, asked(each, 2, rtol, count=count)) for rtol in (1e-11, 1e-6))
        assert run.logs == truth.logs == slice(RATE, RATE + min(1 + count, len(each.state)))
        ours, theirs, true = gains(run), gains(alone), gains(truth)
        for m in (TANGENT, TANGENT + 1):
            doubt = 5e-4 * max(1.0, abs(true[m])) + 3e-7 / truth.grazing
            assert abs(ours[m] - true[m]) < max(doubt, 5 * abs(theirs[m] - true[m]))
        whole = count == len(each.state)
        assert ours[UNRESOLVED] == pytest.approx(true[UNRESOLVED] * whole, rel=3e-2)
        lost = np.isneginf([run.rows[-1, run.logs].min(), truth.rows[-1, truth.logs].min()])
        assert lost[0] == lost[1], "both lose a direction where they stick, or neither"
        if whole and not lost[0]:
            sums = ours[run.logs].sum(), ours[TRACE] + ours[VOLUME]
            assert sums[0] == pytest.approx(sums[1], abs=2 * abs(true[run.logs].sum() - sum(true[1:3])) + 2.0)


def test_parts_of_a_frame_are_the_frame():
    """The directions that grow fastest do not know how many are carried behind them."""
    each = model(1e-4)
    few, more = grown_together([each] * 2, [asked(each, 1, count=count) for count in (2, 4)])
    assert np.allclose(gains(few)[TANGENT : TANGENT + 2], gains(more)[TANGENT : TANGENT + 2], atol=2e-3)


@pytest.mark.nightly
@pytest.mark.parametrize("number", [9, 10])
def test_what_sticking_takes_of_a_whole_frame_is_not_what_rounding_leaves(number):
    """The slip ends slowly there: the last tangent keeps 3e-9 of its length by rounding alone."""
    each = model(np.geomspace(2.9e-5, 2.9e-4, 20)[number])
    (run,) = grown_together([each], [asked(each, 30, count=6)])
    last = run.rows[:, run.logs.stop - 1]
    assert ROUTES[run.route] == "in_lanes"
    assert np.isneginf(run.rows[-1, VOLUME])
    assert np.array_equal(np.isneginf(run.rows[:, VOLUME]), np.isneginf(last))


TORQUE = {"kind": "torque", "link": "crank", "constant": 0.5, "nominal_speed": 100.0}
OTHERS = {
    "loops": lambda: catalog.watt(clearance={"F": 6e-5}).replace(drive=TORQUE),
    "guide": lambda: catalog.slider_crank(clearance={"G": 6e-5}, gravity=9.81).replace(drive=TORQUE),
    "elastic": lambda: mechanism("four_bar", "kelvin_voigt", "coulomb", True),
}


@pytest.mark.nightly
@pytest.mark.parametrize("count", [1, 2])
@pytest.mark.parametrize("name", OTHERS)
def test_tangents_of_loops_guides_and_elastic_links_are_those_of_one_motion(name, count):
    each = assemble(OTHERS[name](), section="angle:crank")
    (run,) = grown_together([each], [asked(each, 1.5, count=count)])
    alone, truth = (grown(each, asked(each, 1.5, rtol, count=count)) for rtol in (1e-6, 1e-11))
    assert (run.status, ROUTES[run.route]) == (0, "in_lanes")
    ours, theirs, true = gains(run), gains(alone), gains(truth)
    assert ours[TRACE] == pytest.approx(true[TRACE], rel=1e-4)
    for m in range(TANGENT, TANGENT + count):
        assert abs(ours[m] - true[m]) < max(5e-4, 5 * abs(theirs[m] - true[m])), (ours[m], theirs[m], true[m])


@pytest.mark.nightly
def test_an_exponent_is_that_of_one_motion_within_their_errors():
    scenes = [model(e) for e in np.geomspace(2.9e-5, 2.9e-4, 6)]
    requests = [asked(each, 70, begin=20) for each in scenes]
    found, away = grown_together(scenes, requests), []
    for each, request, run in zip(scenes, requests, found, strict=True):
        ours, theirs = run.leading(1), grown(each, request).leading(1)
        for name in ("section_exponent_per_turn", "lyapunov_exponent_per_turn"):
            error = name.replace("exponent", "standard_error")
            spread = np.hypot(ours[error][0], theirs[error][0])
            away.append(abs(ours[name][0] - theirs[name][0]) / max(spread, 1e-3))
        assert run.turn_period == pytest.approx(each.period, rel=0.1)
    assert np.mean(away) < 1.5
    assert max(away) < 4


@pytest.mark.nightly
def test_the_exponent_of_a_periodic_motion_is_its_multiplier():
    each = model(2.9e-5)
    orbit = jp.periodic_orbit(catalog.chunmei2002(clearance=2.9e-5, gear_ratio=3.0))
    size = np.hypot(*orbit.floquet_multiplier.transpose("part", "multiplier").values).max()
    (run,) = grown_together([each], [asked(each, 120, 1e-7, begin=60)])
    found = run.leading(1)["section_exponent_per_turn"][0]
    assert found == pytest.approx(np.log(size) / int(orbit.period), abs=1e-3)


@pytest.fixture(scope="module", params=[1, 3, 6])
def company(request):
    """Motions that fly, slip and stick, of different lengths and tolerances."""
    rng = np.random.default_rng(3)
    drawn = [(10 ** rng.uniform(-4.6, -3.5), rng.choice([0.01, 0.3]), rng.uniform(2, 15)) for _ in range(24)]
    scenes = [model(*each) for each in drawn]
    asks = [asked(s, rng.uniform(0.3, 1.2), 10 ** rng.uniform(-6, -4)) for s in scenes]
    asks = [replace(each, count=request.param) for each in asks]
    return scenes, asks, grown_together(scenes, asks)


def same(a, b):
    """Whether two runs are equal to the last bit."""
    return a.rows.tobytes() == b.rows.tobytes() and (a.counts, a.grazing) == (b.counts, b.grazing)


@pytest.mark.long
def test_order_does_not_matter(company):
    scenes, asks, runs = company
    assert all(run.route == 1 for run in runs)
    order = np.random.default_rng(4).permutation(len(scenes))
    shuffled = grown_together([scenes[n] for n in order], [asks[n] for n in order])
    assert all(same(runs[n], other) for n, other in zip(order, shuffled, strict=True))


@pytest.mark.long
def test_company_does_not_matter(company):
    scenes, asks, runs = company
    for n in range(len(scenes)):
        assert same(grown_together([scenes[n]], [asks[n]])[0], runs[n])
        assert same(grown_together([scenes[0], scenes[n]], [asks[0], asks[n]])[1], runs[n])


@pytest.mark.nightly
def test_what_lanes_do_not_take_goes_one_by_one():
    each = model(4e-5)
    remembers = assemble(mechanism("four_bar", "flores", "coulomb", False), section="angle:crank")
    scenes, asks = [each, remembers, each], [asked(each, 0.5), asked(remembers, 0.5), asked(each, 0.5, 1e-9)]
    kept, alone, sharper = grown_together(scenes, asks)
    assert [ROUTES[run.route] for run in (kept, alone, sharper)] == ["in_lanes", "exponents", "tolerance"]
    assert same(alone, grown(remembers, asks[1]))
