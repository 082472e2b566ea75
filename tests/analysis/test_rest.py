"""Impacts that come to rest: their limit and the release, against every single impact of exact motions."""

import math

import numpy as np
import pytest

import jointplay as jp
from jointplay import catalog
from jointplay.analysis.quantities import EVENTS
from jointplay.solver.codegen import cache
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.method.memory import LOGGED
from jointplay.solver.motion.trajectory import Request, functions, memory
from tests.support.tangent_map import tangent_map

from .exact_maps import TAU, bounce, distinct, rattle
from .test_imposed_impacts import four_bar

OK = 0
SLOW = 1e-4  # impacts below this speed are not compared one by one
SEPARATION, IMPACT, REST = (EVENTS.index(name) for name in ("separation", "impact", "rest"))


def events(system, start, end, rtol=1e-10, begin=0.0):
    """Events (time, wall, kind, speed before) of a motion that begins at the time `begin`."""
    model = assemble(system, start)
    work, motion, options = memory(model, Request(end, rtol, events=True, log_from=0.0))
    motion.s[0] = begin
    assert cache.method("flow").flow(functions(model.structure), work, motion, options, None, None) == OK
    rows = motion.log[: motion.count[LOGGED]]
    return [(row[3], int(row[1]), EVENTS[int(row[2])], abs(row[5])) for row in rows]


def compare(found, exact, within):
    """Rests and releases, and every impact but those whose speed is next to nothing."""
    found, exact = ([e[:3] for e in each if e[2] != "impact" or e[3] > SLOW] for each in (found, exact))
    assert [e[1:] for e in found] == [e[1:] for e in exact]
    assert [e[0] for e in found] == pytest.approx([e[0] for e in exact], abs=within)
    return [e for e in found if e[2] == "rest"]


@pytest.mark.parametrize("gap", [0.2, 0.4, 0.8, 1.0, 1.2])
def test_limit_of_the_impacts_and_release(gap):
    """From the lower wall at t = 1 with v = 1.3, restitution 0.6, and on for a period after the release."""
    exact = rattle(gap, 0.6, (1.0, -gap / 2, 1.3), 2 * TAU)
    found = events(catalog.impact_pair(gap, 0.6), (-gap / 2, 1.3), 2 * TAU, begin=1.0)
    assert len(compare(found, exact, 1e-9)) == 1
    assert [e[0] for e in found if e[2] == "separation"] == pytest.approx([TAU], abs=1e-13)


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-13])
def test_the_limit_does_not_depend_on_where_the_sum_begins(rtol):
    exact = rattle(0.2, 0.6, (0.0, 0.0, 0.4), TAU)
    found = events(catalog.impact_pair(0.2, 0.6), (0.0, 0.4), TAU, rtol)
    exact, found = ([e[0] for e in each if e[2] in ("rest", "separation")] for each in (exact, found))
    assert found == pytest.approx(exact, abs=max(1e-9, 1e-2 * rtol))


@pytest.mark.parametrize(("acceleration", "restitution"), [(1.5, 0.2), (5.0, 0.1), (1.03, 0.2), (0.9, 0.5)])
def test_a_ball_rests_on_the_table_until_that_falls_faster(acceleration, restitution):
    exact = bounce(acceleration, restitution, (0.0, 1.5, 0.0), 3 * TAU)
    found = events(catalog.bouncing_ball(acceleration, restitution), (1.5, 0.0), 3 * TAU)
    assert compare(
        [(*e[:3], 1.0) for e in found if e[2] != "impact"], [e for e in exact if e[2] != "impact"], 1e-9
    )
    released = [e[0] % TAU for e in found if e[2] == "separation"]
    assert released == pytest.approx([math.asin(min(1.0, 1 / acceleration))] * len(released), abs=1e-12)


def test_at_rest_the_ball_moves_with_the_table():
    found = jp.simulate(catalog.bouncing_ball(0.9, 0.5), turns=30, initial=(1.5, 0.0), rtol=1e-6)
    later = found.sel(time=slice(float(found.event_time[-1]), None))
    assert later.sizes["time"] > 1000
    y, v = later.state_value.values.T
    assert y == pytest.approx(np.sin(later.time.values), abs=1e-9)
    assert v == pytest.approx(np.cos(later.time.values), abs=1e-9)


@pytest.mark.parametrize(("gap", "speed"), [(0.4, 1.3), (3.0, 0.3)])
def test_a_wall_without_restitution_holds_at_once(gap, speed):
    exact = rattle(gap, 0.0, (0.0, 0.0, speed), 20.0)
    found = events(catalog.impact_pair(gap, 0.0), (0.0, speed), 20.0)
    assert compare(found, exact, 1e-9)


def test_random_starts_all_come_to_their_end():
    random, rested = np.random.default_rng(14), 0
    for gap in (0.2, 0.4):
        for start in random.uniform((-gap / 2, -2), (gap / 2, 2), (24, 2)):
            found = jp.simulate(catalog.impact_pair(gap, 0.6), turns=20, initial=start)
            assert int(found.status) == OK
            rested += int((found.event_kind == REST).any())
    assert rested > 10


@pytest.mark.parametrize(
    ("start", "expected"),
    [
        ((0.2, 0.0), [(math.pi, 0, "separation")]),  # pressed against the upper wall from t = 0 on
        ((-0.2, 0.0), []),  # the lower one lets go at once
    ],
)
def test_a_start_at_rest_on_a_wall(start, expected):
    """The force is zero then, at t = 0."""
    found = events(catalog.impact_pair(0.4, 0.6), start, 1.2 * math.pi)
    first = [e[:3] for e in found][: len(expected)]
    assert [e[1:] for e in first] == [e[1:] for e in expected]
    assert [e[0] for e in first] == pytest.approx([e[0] for e in expected], abs=1e-12)
    if not expected:
        flight = 0.4  # from -0.2 to 0.2: t - sin t = 0.4
        assert found[0][0] - math.sin(found[0][0]) == pytest.approx(flight, abs=1e-10)


def test_a_start_a_rounding_beyond_a_wall_is_on_it():
    """As the states are that a body at rest has been recorded with."""
    found = events(catalog.bouncing_ball(0.9, 0.5), (-1e-13, 1.0), TAU)
    assert found == []
    with pytest.raises(jp.InputError):
        jp.simulate(catalog.bouncing_ball(0.9, 0.5), turns=1, initial=(-1e-6, 1.0))


@pytest.mark.long
def test_what_rests_every_period_repeats_exactly():
    """Nothing is left of a start once the ball has lain on the table."""
    ball = catalog.bouncing_ball(1.5, 0.2)
    begin, end = (e[0] for e in bounce(1.5, 0.2, (0.0, 1.5, 0.0), 14.0) if e[2] != "impact" and e[0] > 8)
    for start in ((1.5, 0.0), (2.3, -0.4)):
        section = jp.poincare(ball, turns=5, transient=3, initial=start)
        assert distinct(section, 1e-11) == 1
        assert section.state_value.values == pytest.approx(np.tile([0.0, 1.0], (5, 1)), abs=1e-10)
    exponents = jp.lyapunov(ball, exponents=2, turns=10, initial=(1.5, 0.0))
    assert int(exponents.status) == OK
    assert (exponents.lyapunov_exponent.values == -np.inf).all()
    orbit = jp.periodic_orbit(ball, initial=(1.5, 0.0))
    assert (int(orbit.status), int(orbit.stable)) == (OK, 1)
    assert not orbit.floquet_multiplier.values.any()
    swept = jp.bifurcation(
        ball, over={"acceleration": [0.9, 1.5]}, direction=("up", "down"), turns=8, transient=20
    )
    assert not swept.cell_status.values.any()
    assert (swept.period.values == 1).all()
    share = swept.contact_fraction.sel(acceleration=[0.9, 1.5])
    assert share.values.ravel() == pytest.approx([1.0, 1.0, *[(end - begin) / TAU] * 2], abs=1e-6)


def test_the_tangent_map_through_a_rest_is_zero():
    model = assemble(catalog.impact_pair(0.2, 0.6), (0.0, 0.29))
    rest = next(e[0] for e in rattle(0.2, 0.6, (0.0, 0.0, 0.29), TAU) if e[2] == "rest")
    before, after = (tangent_map(model, rest + shift) for shift in (-1e-3, 1e-3))
    assert np.abs(before).max() > 1e-6
    assert not after.any()
    assert not tangent_map(model, rest + 2 * math.pi).any()


@pytest.fixture
def coupled():
    """Two masses with coupled inertia on a spring; the gap below them is a mixture of both positions."""
    impulse = "(1 + restitution)*(v + u/2)"
    jump = {"v": f"v - 3/4*{impulse}", "u": f"u - {impulse}/2"}  # along M^-1 N
    return jp.System(
        name="two masses",
        states={"y": 0.5, "x": 0.2, "v": 0.0, "u": 0.3},
        parameters={"restitution": 0.5},
        rates={"y": "v", "x": "u", "v": "sin(t) - 1 + 3*(x - y)", "u": "3*(y - x) - u/5 - x"},
        mass={"v": {"v": 2}, "u": {"v": "1/2", "u": 1}},
        forcing="2*pi",
        impacts=[{"name": "floor", "gap": "y + x/2", "jump": jump}],
    )


def test_a_part_that_goes_on_moving(coupled):
    """At rest in one direction only: where the sum began may show in neither the motion nor its tangents."""
    tight, loose = (jp.simulate(coupled, turns=1, rtol=rtol, samples_per_turn=60) for rtol in (1e-13, 1e-8))
    assert (tight.event_kind == REST).any()
    assert loose.state_value.values[-1] == pytest.approx(tight.state_value.values[-1], abs=3e-8)
    rest = float(tight.event_time[tight.event_kind == REST][0])
    released = tight.event_time[tight.event_kind == SEPARATION].values
    until = rest + 0.5 * (min([*released[released > rest], rest + 1.0]) - rest)
    model, h = assemble(coupled), 1e-5
    found = tangent_map(model, until, 1e-12)
    assert np.linalg.matrix_rank(found, 1e-9) == 2

    def end(state):
        response = jp.simulate(coupled, duration=until, initial=state, rtol=1e-13, at=[until])
        return response.state_value.values[-1]

    columns = [(end(model.state + d) - end(model.state - d)) / (2 * h) for d in h * np.eye(4)]
    assert np.transpose(columns) - found == pytest.approx(0, abs=1e-5)
    N, state = np.array([1.0, 0.5]), end(model.state)
    assert [N @ state[:2], N @ state[2:]] == pytest.approx([0.0, 0.0], abs=1e-12)
    exponents = jp.lyapunov(coupled, exponents=4, turns=20)
    assert np.isfinite(exponents.lyapunov_exponent.values).sum() == 2


@pytest.mark.parametrize(("restitution", "within"), [(0.8, 1e-7), (0.95, None)])
def test_a_body_pressed_weakly_comes_to_rest_at_any_tolerance(restitution, within):
    """The rounding of a gap does not keep rebounds up: their number and the times of rest converge."""
    steady = jp.ConstantSpeed(link="crank", speed=30.0)
    mechanism, impacts, rests = four_bar(steady, restitution, gravity=0.98, clearance=2e-4), [], []
    for rtol in (1e-9, 1e-10, 1e-11):
        words = ["eccentricity_ratio"]
        found = jp.simulate(mechanism, turns=1, rtol=rtol, record=words, max_steps=20_000)
        assert found.status == 0
        assert found.eccentricity_ratio.max() < 1 + 5 * max(rtol, 1e-10)
        impacts.append(int((found.event_kind == IMPACT).sum()))
        rests.append(found.event_time.values[found.event_kind.values == REST])
    assert max(impacts) < 400
    assert abs(impacts[2] - impacts[1]) <= (2 if within else 40)
    if within:
        assert len(rests[0]) == 8
        assert rests[1] == pytest.approx(rests[0], abs=within)
        assert rests[2] == pytest.approx(rests[1], abs=within)
