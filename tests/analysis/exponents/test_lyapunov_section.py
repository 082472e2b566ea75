"""Exponents of a flow against those of its section map, against multipliers, twins and mirror images."""

import math
from dataclasses import replace

import numpy as np
import pytest

import jointplay as jp
from jointplay import catalog
from jointplay.analysis import tangents
from jointplay.analysis.exponents.frame_growth import frame, framed, has_no_clock
from jointplay.analysis.exponents.growth import Turn
from jointplay.analysis.rules import quantity
from jointplay.solver.codegen import cache
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.records import CrankAngle
from jointplay.solver.motion.trajectory import Request
from tests.support.driven_scenes import pinned
from tests.support.tangent_map import tangent_map

LOOSE = {"clearance": 2.9e-4, "gear_ratio": 3.0}
TIGHT = {"clearance": 2.9e-5, "gear_ratio": 3.0}
SHAKEN = {
    "name": "shake",
    "kind": "torque",
    "link": "rocker",
    "frequency": 50.0,
    "table": [0.0, 1.0, 2.0, 3.0, 2.0, 1.0],
}
RTOL = 1e-10


def turning(mechanism, rtol=RTOL):
    return Turn(assemble(mechanism, None, quantity(CrankAngle(), mechanism)), rtol)


def rate(mechanism, model, state):
    """Derivative of a linkage's state, in the order of its angles and speeds, from its outputs."""
    links = [link.name for link in mechanism.links]
    start = {
        "angle": dict(zip(links, state[: len(links)], strict=True)),
        "angular_velocity": dict(zip(links, state[len(links) :], strict=True)),
    }
    words = ["angular_velocity", "angular_acceleration"]
    found = jp.simulate(mechanism, duration=1e-9 * model.period, at=[0.0], initial=start, record=words)
    return np.concatenate([found[word].values[0] for word in words])


def map_derivative(mechanism, turn, state):
    """Derivative of a linkage's section map in units of its scales, the next section point, the time."""
    after, time, status = turn(state)
    assert status == 0
    M = tangent_map(replace(turn.model, state=state), time, turn.rtol)
    F, crank = rate(mechanism, turn.model, after), turn.crank
    P = M - np.outer(F, M[crank]) / F[crank]
    free = [i for i in range(len(state)) if i != crank]
    size = turn.scale[free]
    return P[np.ix_(free, free)] * size / size[:, None], after, time


def test_map_and_flow_of_a_forced_system():
    """Tangent maps from phase to phase, QR by NumPy, from the same frame: the flow's growth, a turn."""
    system, turns, state = catalog.duffing(), 8, np.array((0.3, 0.2))
    turn, logs = turning(system, 1e-12), np.zeros(2)
    size = tangents.scales(turn.model)
    Q = (frame(2, size) / size).T
    flow = jp.lyapunov(system, exponents="all", turns=turns, initial=tuple(state), rtol=1e-12)
    for _ in range(turns):
        M = tangent_map(replace(turn.model, state=state), turn.model.period, 1e-12)
        Q, R = np.linalg.qr(M * size / size[:, None] @ Q)
        logs += np.log(np.abs(np.diag(R)))
        state = turn(state)[0]
    assert logs / turns == pytest.approx(flow.lyapunov_exponent_per_turn.values, rel=1e-6)


@pytest.mark.nightly
def test_map_and_flow_of_the_chaotic_linkage():
    """Crank angle 0 as the section: its map has the flow's exponents times the turn, without the zero."""
    mechanism, turns = catalog.chunmei2002(**LOOSE), 400
    turn = turning(mechanism)
    state, logs, duration = turn(turn.model.state, 20)[0], [], 0.0
    Q = np.linalg.qr(np.random.default_rng(1).normal(size=(5, 2)))[0]
    for _ in range(turns):
        P, state, time = map_derivative(mechanism, turn, state)
        Q, R = np.linalg.qr(P @ Q)
        logs.append(np.log(np.abs(np.diag(R))))
        duration += time
    flow = jp.lyapunov(mechanism, exponents=3, turns=600, transient=20)
    own = np.std(np.reshape(logs, (20, -1, 2)).mean(axis=1), axis=0, ddof=1) / math.sqrt(20)
    values, errors = (
        flow[f"lyapunov_{name}_per_turn"].values[[0, 2]] for name in ("exponent", "standard_error")
    )
    # a wide bound: which motion it is depends on the processor, and errors of few blocks are themselves rough
    assert np.all(np.abs(np.mean(logs, axis=0) - values) < 5 * np.hypot(own, errors))
    assert duration / turns == pytest.approx(float(flow.turn_period), rel=1e-4)


@pytest.mark.parametrize("changes", [TIGHT, TIGHT | {"friction": 0.3}])
def test_multipliers_of_a_periodic_motion(changes):
    """λ = ln|multiplier|/T, of the section map and of the monodromy, which has a multiplier 1 besides."""
    mechanism = catalog.chunmei2002(**changes)
    turn = turning(mechanism, 1e-12)
    state = turn(turn.model.state, 60)[0]
    P, after, time = map_derivative(mechanism, turn, state)
    assert after == pytest.approx(state, rel=1e-8)
    M = tangent_map(replace(turn.model, state=state), time, 1e-12)
    whole, section = (np.sort(np.abs(np.linalg.eigvals(each)))[::-1] for each in (M, P))
    assert whole[0] == pytest.approx(1.0, abs=1e-6)
    assert section[:2] == pytest.approx(whole[1:3], rel=1e-4)
    for count in (1, 2):
        found = jp.lyapunov(mechanism, exponents=count, turns=100, transient=60)
        values = found.section_exponent_per_turn.values
        assert abs(float(found.lyapunov_exponent[0])) * time < 1e-4
        assert values == pytest.approx(np.log(section[:count]), rel=3e-3, abs=2e-4)


@pytest.mark.nightly
def test_both_estimates_of_the_chaotic_linkage():
    """Tangents with saltation, and twins without any Jacobian: within three combined standard errors."""
    found = jp.lyapunov(catalog.chunmei2002(**LOOSE), exponents=2, turns=500, transient=20, twin_turns=200)
    assert int(found.status) == int(found.growth_status) == 0
    value, error = (float(found[f"section_{name}_per_turn"][0]) for name in ("exponent", "standard_error"))
    combined = math.hypot(error, float(found.growth_standard_error))
    assert float(found.growth_difference) == pytest.approx((float(found.growth) - value) / combined)
    assert abs(float(found.growth_difference)) < 3
    assert combined < 0.15 < value
    assert abs(float(found.lyapunov_exponent[1])) < 0.05  # the one that is zero


@pytest.mark.nightly
@pytest.mark.parametrize("angle", [0.0, 1.0, 2.0, 3.0])
def test_both_estimates_where_a_journal_comes_to_rest_at_once(angle):
    """A plastic rigid bearing, of which each landing takes two directions."""
    run = {"turns": 300, "transient": 20, "twin_turns": 300, "initial": {"crank_angle": angle}}
    found = jp.lyapunov(pinned(0.0, speed=60.0), **run)
    assert int(found.status) == int(found.growth_status) == 0
    assert abs(float(found.growth_difference)) < 3
    assert float(found.growth_standard_error) < 0.15
    assert float(found.section_standard_error_per_turn[0]) < 0.15
    assert float(found.growth) > 2


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("system", "keywords"),
    [
        (catalog.impact_pair(0.4, 0.8), {"initial": (0.05, 0.7)}),
        (catalog.duffing(), {}),
        (catalog.gear_backlash(0.1, 0.2, 1.6, 0.05), {}),
        (catalog.soft_impact_pair(1.0, 50.0, 2.0, tension=False), {}),
    ],
)
def test_both_estimates_of_test_systems(system, keywords):
    found = jp.lyapunov(system, exponents=1, turns=1500, transient=50, twin_turns=800, **keywords)
    assert abs(float(found.growth_difference)) < 3
    assert np.array_equal(found.section_exponent_per_turn, found.lyapunov_exponent_per_turn)


def test_the_loop_of_twins_is_compiled_beside_that_of_tangents(monkeypatch):
    """Both are asked for before the motion is followed."""
    asked, followed = [], []

    def follow(*_):
        followed.extend(asked)
        raise InterruptedError

    monkeypatch.setattr(cache, "prepare", asked.append)
    monkeypatch.setattr("jointplay.analysis.exponents.lyapunov.grown", follow)
    with pytest.raises(InterruptedError):
        jp.lyapunov(catalog.duffing(), exponents=1, turns=2, twin_turns=1)
    assert followed == ["tangents.tangent_flow", "flow"]


def test_both_estimates_of_a_periodic_motion():
    """The flow's largest exponent is 0, and says nothing of the map's: twins tell that it is this one."""
    found = jp.lyapunov(catalog.chunmei2002(**TIGHT), turns=80, transient=30, twin_turns=40)
    assert found.sizes["multiplier"] == found.sizes["exponent"] == 1
    assert float(found.section_exponent_per_turn[0]) == pytest.approx(float(found.growth), abs=2e-3)
    assert float(found.growth) < -1
    assert abs(float(found.lyapunov_exponent_per_turn[0])) < 1e-4


@pytest.mark.parametrize(
    ("system", "known", "duration"),
    [(catalog.lorenz(), (0.9056, -14.5723), 500), (catalog.rossler(), (0.0714, -5.3943), 2000)],
)
def test_without_the_zero_of_a_system_that_nothing_forces(system, known, duration):
    found = jp.lyapunov(system, exponents=2, duration=duration, transient=20)
    away = np.abs(found.section_exponent.values - known)
    assert np.all(away < 3 * found.section_standard_error.values)
    assert np.all(away < [0.01, 0.03])
    whole = jp.lyapunov(system, exponents="all", duration=10)
    assert whole.sizes["multiplier"] == 2


def test_a_window_of_rossler_system():
    """At c = 4 the motion has period 4: stable, though the flow's largest exponent is 0."""
    found = jp.lyapunov(catalog.rossler(c=4.0), duration=1500, transient=300)
    assert abs(float(found.lyapunov_exponent[0])) < 1e-3
    plane = jp.Plane(quantity="y", value=0.0)
    orbit = jp.periodic_orbit(catalog.rossler(c=4.0), period=4, transient=50, section=plane)
    assert float(found.section_exponent[0]) == pytest.approx(float(orbit.lyapunov_exponent[0]), rel=0.02)


def test_a_motion_that_comes_to_rest_has_no_section():
    found = jp.lyapunov(catalog.lorenz(rho=0.5), duration=100)
    assert float(found.lyapunov_exponent[0]) < -0.1
    assert np.all(np.isnan(found.section_exponent))
    still = jp.lyapunov(catalog.lorenz(), duration=2, initial=(0.0, 0.0, 0.0))
    assert float(still.lyapunov_exponent[0]) > 10  # of the unstable equilibrium
    assert np.all(np.isnan(still.section_exponent))


@pytest.mark.parametrize(
    ("mechanism", "expected"),
    [
        (catalog.chunmei2002(**LOOSE), True),
        (catalog.chunmei2002(2.9e-4, speed=80.0, friction=0), False),
        (catalog.watt(clearance={"D": 5e-5}), False),  # beyond D the crank is felt in contact alone
        (catalog.chunmei2002(**LOOSE, loads=[SHAKEN]), False),
        (catalog.siconos_four_bar(), False),  # a servo follows the time
        (catalog.lorenz(), True),
        (catalog.impact_pair(1.0, 0.8), False),
        (catalog.bouncing_ball(1.2, 0.5), False),
    ],
)
def test_who_keeps_the_time(mechanism, expected):
    assert has_no_clock(assemble(mechanism)) is expected


@pytest.mark.parametrize("changes", [LOOSE, TIGHT | {"friction": 0.3}])
def test_the_map_s_growth_is_that_of_volumes_that_hold_the_rate(changes):
    """Of frames that know nothing of F, those that have it as a tangent: ln(volume of all) less ln|F|."""
    mechanism = catalog.chunmei2002(**changes)
    model, ends = assemble(mechanism), (10.0, 22.0)
    request = Request(ends[1] * model.period, 1e-10)
    grown = []
    for neutral in (False, True):
        bundle, logs = framed(model, request, 2 + (not neutral), neutral=neutral), []
        for end in ends:
            assert bundle.advance(end * model.period) == 0
            speed = math.log(np.linalg.norm(bundle.rate() / tangents.scales(model)))
            sums = np.cumsum(bundle.tangents.logs)
            logs.append(sums[1:] - (sums[0] if neutral else speed))
            if neutral:
                assert bundle.tangents.logs[0] == pytest.approx(speed, rel=1e-9)
        grown.append(logs[1] - logs[0])
    assert grown[1] == pytest.approx(grown[0], abs=1e-3, rel=1e-4)


def test_a_mirror_image_has_the_same_exponents():
    """All angles and speeds change their sign, and so does the frame: nothing else."""
    upper = catalog.chunmei2002(2.9e-4, speed=80.0, friction=0)
    lower = upper.replace(speed=-80.0, gravity=-upper.gravity, branch="lower")
    found, image = (jp.lyapunov(m, exponents="all", turns=3, rtol=1e-10) for m in (upper, lower))
    assert image.lyapunov_exponent.values == pytest.approx(found.lyapunov_exponent.values, rel=1e-5)
    assert np.ptp(found.lyapunov_exponent.values) > 1


@pytest.mark.parametrize("changes", [TIGHT, {"clearance": 2.9e-5}, LOOSE | {"friction": 0}])
def test_exponents_add_up_to_the_divergence(changes):
    """To 1e-6 of it, or one of them is minus infinity, for a dimension lost in sticking."""
    found = jp.lyapunov(catalog.chunmei2002(**changes), exponents="all", turns=40, transient=20)
    assert np.all(np.isfinite(found.lyapunov_exponent))
    assert float(found.sum_residual) < 1e-6 * abs(float(found.mean_divergence))
    zero = np.abs(found.lyapunov_exponent * found.turn_period) < 0.05
    assert int(zero.sum()) == 1
