"""LuGre friction: a block against closed forms of its bristles, and a linkage that forgets them in flight."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import jointplay as jp
from jointplay import catalog
from jointplay.analysis import tangents
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.parts.friction import Friction
from jointplay.solver.motion.eligibility import exclusion
from jointplay.solver.motion.trajectory import Request, follow
from tests.support.belt import LAWS, LUGRE, belt, ratio
from tests.support.linkages import jointed
from tests.support.plain import Point, plain
from tests.support.tangent_map import tangent_map

M, N = 2.0, 20.0  # of the block
DAHL = Friction(**LUGRE.model_dump() | {"static_coefficient": 0.3, "bristle_damping": 0.0})


def motion(friction, state, times, **numbers):
    """States of the block (x, v, z) at times."""
    found = follow(belt(friction, state, **numbers), Request(times[-1], 1e-11, at=np.array(times)))
    assert found.status == 0
    return found.samples[:, 1:4]


@pytest.mark.parametrize("v", [1e-3, 0.05, 0.7, -0.05, -0.7])
def test_steady_slip_is_stribecks_curve(v):
    mu = math.copysign(ratio(LAWS["stribeck"], v), v)
    model = belt(LUGRE, (0.0, v, mu / LUGRE.bristle_stiffness), V=0.0)
    here = Point(plain(model.structure), model.numbers, model.state, ["contact"])
    assert here.rate()[1, 0] == pytest.approx(0.0, abs=1e-14)
    assert here.contacts()[0, 4] == pytest.approx(mu * N, rel=1e-13)


def test_at_rest_bristles_are_a_spring_of_their_stiffness():
    """A block let go under a small load swings about where they hold it; their damping dies away with s_1."""
    stiff, load = LUGRE.bristle_stiffness * N, 1e-4
    w = math.sqrt(stiff / M)
    zeta = LUGRE.bristle_damping * N / (2 * math.sqrt(stiff * M))
    times = np.linspace(0.0, 4 / w, 9)[1:]
    x = motion(LUGRE, (0.0, 0.0, 0.0), times, k=0.0, V=0.0, load=load)[:, 0]
    wd = w * math.sqrt(1 - zeta**2)
    decay = np.exp(-zeta * w * times)
    swung = load / stiff * (1 - decay * (np.cos(wd * times) + zeta * w / wd * np.sin(wd * times)))
    assert np.allclose(x, swung, rtol=1e-4)


def test_dragged_one_way_the_force_follows_the_distance_alone():
    """Dahl's case: one coefficient, no bristle damping: mu = f (1 - exp(-s_0 x/f)), however fast."""
    f, s_0 = DAHL.coefficient, DAHL.bristle_stiffness
    for load in (8.0, 30.0):
        x, v, z = motion(DAHL, (0.0, 0.1, 0.0), [2e-4, 5e-4, 2e-3], k=0.0, V=0.0, load=load).T
        assert (v > 0).all()
        assert np.allclose(s_0 * z, f * -np.expm1(-s_0 * x / f), rtol=1e-9)


@pytest.mark.long
def test_break_away_takes_less_the_faster_the_load_grows():
    """The most that bristles bend when a spring pulls a block off a belt, beside another solver."""
    peaks, stiff = [], LUGRE.bristle_stiffness
    for V in (1e-3, 1e-1):
        times = np.linspace(0.0, 0.03 / V, 10)[1:]

        def rate(_, y, V=V):
            x, v, z = y
            bend = (v - V) - stiff * abs(v - V) / ratio(LAWS["stribeck"], v - V) * z
            return v, (-50 * x - N * (stiff * z + LUGRE.bristle_damping * bend)) / M, bend

        x, _, z = motion(LUGRE, (0.0, V, 0.0), times, V=V).T
        other = solve_ivp(rate, (0, times[-1]), (0.0, V, 0.0), "Radau", times, rtol=1e-9, atol=1e-13).y
        assert np.allclose(x, other[0], rtol=1e-6)
        assert np.allclose(z, other[2], rtol=1e-5)
        longer = np.linspace(0, 0.6 / V, 4000)[1:]
        peaks.append(np.abs(motion(LUGRE, (0.0, V, 0.0), longer, V=V)[:, 2]).max() * stiff)
    assert 0.4999 < peaks[0] < 0.5
    assert peaks[1] < peaks[0] - 3e-4


def test_tangents_through_zero_speed():
    model = belt(LUGRE, (0.25, 0.03, 0.0), V=0.0)
    exact, scale = tangent_map(model, 1.0, 1e-13), tangents.scales(model)
    columns = []
    for shift in 1e-3 * np.diag(scale):  # of a tenth of it runs' errors show: 1e-14 over 1e-8 of bristles
        ends = [
            follow(belt(LUGRE, model.state + i * shift, V=0.0), Request(1.0, 1e-13, at=np.array([1.0])))
            for i in (1, -1, 2, -2)
        ]
        a, b, c, d = (end.samples[0, 1:4] for end in ends)
        columns.append((8 * (a - b) - (c - d)) / (12 * shift.max()))
    assert np.abs(np.array(columns).T - exact).max() < 1e-6 * np.abs(exact).max()


@pytest.fixture(scope="module")
def mechanism():
    return jointed(catalog.chunmei2002(clearance=2.9e-4, gear_ratio=3.0), friction=LUGRE)


@pytest.mark.nightly
def test_bristles_are_straight_in_flight_and_from_each_contact_on(mechanism):
    model = assemble(mechanism)
    times = np.linspace(0.0, 0.5 * model.period, 2000)
    found = follow(model, Request(times[-1], 1e-9, at=times, events=True, log_from=-1.0))
    z, mode = found.samples[:, len(model.state)], found.samples[:, 1 + len(model.state)]
    assert found.status == 0
    assert (z[mode == 0] == 0.0).all()
    assert (np.abs(z[mode > 1]) > 0.0).mean() > 0.95
    assert np.abs(z).max() <= LUGRE.static_coefficient / LUGRE.bristle_stiffness * (1 + 1e-6)
    met = found.events[:, 1]
    assert (found.events[met == 0, 3 + len(model.state) - 1] == 0.0).all()  # before contacts
    assert (found.events[met == 1, 3 + len(model.state) - 1] != 0.0).any()  # before separations


@pytest.mark.nightly
def test_forces_and_energy_in_a_linkage(mechanism):
    record = ["normal_force", "tangential_force", "tangential_velocity", "mode", "energy", "energy_residual"]
    found = jp.simulate(mechanism, turns=0.5, rtol=1e-9, record=record)
    assert int(found.status) == 0
    assert np.abs(found.energy_residual).max() < 1e-9 * np.abs(found.energy).max()
    touching = found.mode.values > 1
    F_t, F_n = found.tangential_force.values[touching], found.normal_force.values[touching]
    share = np.abs(F_t / F_n)
    assert 0.2 < np.median(share) < 0.6
    assert exclusion(assemble(mechanism), Request(1.0, 1e-6)) == "bristles"
