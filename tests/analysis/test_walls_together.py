"""An impact at one rigid wall while a body rests on another, and impacts at two at once: impulses by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

import jointplay as jp
from jointplay.analysis.quantities import EVENTS, STATUS
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.motion import trajectory
from tests.analysis.test_rigid_bearing import E, rigid
from tests.method.test_tangent import differences, scaled
from tests.support.multibody_records import from_mechanism

M, A, R = 1.5, 0.4, 0.5
RESTS = 6
BAR = jp.System(
    name="bar on two supports",
    states={"y": 0.0, "angle": 0.0, "v": 0.0, "w": 0.0},
    parameters={"m": M, "J": 0.1, "a": A, "left": 0.0, "right": R, "g": 1.0},
    rates={"y": "v", "angle": "w", "v": "-m*g", "w": "0"},
    mass={"v": {"v": "m"}, "w": {"w": "J"}},
    impacts=[
        {"name": "l", "gap": "y - a*angle", "restitution": "left"},
        {"name": "r", "gap": "y + a*angle", "restitution": "right"},
    ],
)


def bar(start, **numbers):
    """The bar (y, angle, v, w), its supports at 0."""
    return assemble(BAR.replace(**numbers), start)


def run(model, duration):
    """State at the end, and the events as (kind, wall, time)."""
    request = trajectory.Request(duration, 1e-11, events=True, log_from=0.0, at=np.array([duration]))
    found = trajectory.follow(model, request)
    assert found.status == 0
    return found.samples[-1, 1:5], [
        (EVENTS[int(kind)], int(wall), t) for wall, kind, t in found.events[:, :3]
    ]


TILTED = (0.01, 0.01 / A, 0.0, 0.0)  # the left end on its support, the right one 0.02 above


@pytest.mark.parametrize("J", [0.1, 0.7])
def test_a_bar_that_rests_on_one_end_and_lands_on_the_other(J):
    """Of J > m a^2 the resting end is thrown off; of less it is pressed, and takes part in the impulse."""
    turning = M * A / (J + M * A * A)  # angular acceleration about the left end
    falls = math.sqrt(2 * 0.02 / (2 * A * turning))
    state, events = run(bar(TILTED, J=J), falls + 1e-3)
    closing = 2 * A * turning * falls
    push = np.array([[1.0, -A], [1.0, A]])
    matrix = push @ np.diag([1 / M, 1 / J]) @ push.T
    if J > M * A * A:
        impulse = np.array([0.0, (1 + R) * closing / matrix[1, 1]])
    else:
        impulse = np.linalg.solve(matrix, [0.0, (1 + R) * closing])
    assert impulse.min() >= 0.0
    v, w = -closing / 2 + impulse.sum() / M, -closing / (2 * A) + A * (impulse[1] - impulse[0]) / J
    kinds = [each[:2] for each in events]
    assert kinds == [("impact", 1)]
    assert events[0][2] == pytest.approx(falls, rel=1e-9)
    left, right = v - A * w, v + A * w
    assert right == pytest.approx(R * closing)
    assert left == pytest.approx(0.0, abs=1e-12) or left > 0.1 * closing
    if left > 0.1 * closing:
        change = np.array([-1e-3, 0.0])
    else:
        change = np.array([-A, -1.0]) * turning * 1e-3
    assert state[2:] == pytest.approx(np.array([v, w]) + change, abs=1e-9)


def test_a_bar_that_lands_flat_rebounds_flat_and_rests():
    """Two at one instant, again and again: the sum of a geometric series, on both ends."""
    height = 0.05
    falls = math.sqrt(2 * height)
    ends = falls * (1 + 2 * R / (1 - R))
    state, events = run(bar((height, 0.0, 0.0, 0.0), left=R), 1.2 * ends)
    assert [each[:2] for each in events[:2]] == [("impact", 0), ("impact", 1)]
    assert events[0][2] == events[1][2] == pytest.approx(falls, rel=1e-12)
    rests = {wall: time for kind, wall, time in events if kind == "rest"}
    assert set(rests) == {0, 1}
    assert list(rests.values()) == pytest.approx([ends] * 2, rel=1e-6)
    assert np.abs(state).max() < 1e-12


@pytest.mark.long
@pytest.mark.parametrize("J", [0.1, 0.7])
def test_tangents_are_those_of_neighbours(J):
    """The left end lands and stays; then the right one lands."""
    model, apart = bar((0.011, 0.01 / A, 0.0, 0.0), J=J), []
    exact = scaled(model, 0.35)
    for size in (1e-8, 1e-7, 1e-6):
        found, events, same = differences(model, 0.35, size, exact)
        if same:
            assert [EVENTS[kind] for _, kind in events][:3] == ["impact", "rest", "impact"]
            apart.append(np.abs(found - exact).max() / np.abs(exact).max())
    assert min(apart) < 1e-6


@pytest.mark.long
def test_two_landings_at_one_instant_have_no_derivative():
    found = jp.lyapunov(BAR.replace(left=R), duration=1.0, initial=(0.05, 0.0, 0.0, 0.0), exponents=1)
    assert STATUS[int(found.status)] == "no_derivative"


def bodies(mechanism, state):
    """Places and speeds of all mass centres and links in full coordinates; coupler on crank, rocker free."""
    (crank, coupler, rocker), (angles, origin, speeds, rate) = mechanism.links, np.split(state, [3, 5, 8])
    pin = crank.length * np.exp(1j * angles[0])
    origins = 0j, pin, complex(*origin)
    moves = 0j, 1j * speeds[0] * pin, complex(*rate)
    place, moving = [], []
    for link, angle, speed, at, going in zip(
        (crank, coupler, rocker), angles, speeds, origins, moves, strict=True
    ):
        along = link.centre * np.exp(1j * angle)
        for full, value, turned in ((place, at + along, angle), (moving, going + 1j * speed * along, speed)):
            full += [value.real, value.imag, turned]
    return np.array(place + moving)


@pytest.mark.nightly
def test_an_impact_while_another_journal_rests_is_that_of_rigid_bodies():
    """Speeds of all links after it, by multipliers in full coordinates; the resting one pushes or lets go."""
    given, restitution = {"B": E, "C": E}, 0.3
    mechanism, met = rigid(restitution, given), {True: 0, False: 0}
    twin = from_mechanism(jp.catalog.chunmei2002(clearance=given, gear_ratio=3.0, friction=0.0))
    model = assemble(mechanism)
    request = trajectory.Request(3 * model.period, 1e-11, steps=True, events=True, log_from=0.0)
    found = trajectory.follow(model, request)
    assert found.status == 0
    for row in (row for row in found.events if EVENTS[int(row[1])] == "impact"):
        wall, other = int(row[0]), 1 - int(row[0])
        after = found.steps[found.steps[:, 2] == row[2]][-1]
        if row[13 + other] != RESTS or after[13 + wall] == RESTS:
            continue
        now = twin.solve(row[2], bodies(mechanism, row[3:13]), [False, False]).now
        G = twin.constraints(now, twin.ideal)[1]
        W = np.array([touch.W_n for _, touch in twin.touches(now)])
        n, m = now.n, len(G)
        matrix = np.zeros((n + m, n + m))
        matrix[range(n), range(n)], matrix[:n, n:], matrix[n:, :n] = twin.mass, G.T, G
        ways = np.linalg.solve(matrix, np.concatenate([W.T, np.zeros((m, 2))]))[:n]
        A, rates, push = W @ ways, W @ now.v, np.zeros(2)
        push[wall] = (1 + restitution) * rates[wall] / A[wall, wall]
        presses = rates[other] - A[other] @ push > 0.0
        if presses:
            push = np.linalg.solve(A, np.where(np.arange(2) == wall, 1 + restitution, 1.0) * rates)
        wanted = now.v - ways @ push
        if not presses and after[13 + other] == RESTS:  # what rebounds less than is tolerated stays
            continue
        assert push.min() >= 0.0
        assert bodies(mechanism, after[3:13])[n:] == pytest.approx(wanted, rel=1e-6, abs=1e-6)
        assert presses == (after[13 + other] == RESTS)
        met[bool(presses)] += 1
    assert min(met.values()) > 0


@pytest.mark.nightly
@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_two_rigid_bearings_only_lose_energy(friction):
    """The balance closes through impacts beside resting journals; none makes energy."""
    mechanism = rigid(0.5, {"B": E, "C": E}, friction, drive=None, gravity=0.0)
    start = {"crank_angle": 0.0, "crank_speed": 20.0}
    words = ["energy", "energy_residual", "joint_work", "penetration", "mode"]
    found = jp.simulate(mechanism, duration=0.6, rtol=1e-10, initial=start, record=words, steps=True)
    assert found.status == 0
    energy = found.energy.values
    assert np.diff(energy).max() < 1e-9 * energy[0]
    assert np.abs(found.energy_residual).max() < 1e-8 * energy[0]
    assert found.penetration.max() < 1e-11
    both = (found["mode"].values > 1).all(1)
    assert 0 < both.sum() < len(both)


@pytest.mark.parametrize(("walls", "status"), [(6, "ok"), (7, "jammed")])
def test_more_contacts_at_once_than_are_solved_for_are_told(walls, status):
    """A body that falls on so many walls in one place."""
    impacts = [{"name": f"wall{i}", "gap": "y", "restitution": 0.5} for i in range(walls)]
    body = jp.System(states={"y": 1.0, "v": 0.0}, rates={"y": "v", "v": "-1"}, impacts=impacts)
    found = jp.simulate(body, duration=2.0)
    assert jp.words(found).status == status
    assert ("more than six met at once" in str(jp.summary(found))) == (walls == 7)
    if walls == 6:
        assert float(found.state_value[-1, 0]) == pytest.approx(
            0.5 * (2 - 2**0.5) * 2**0.5 - (2 - 2**0.5) ** 2 / 2
        )
