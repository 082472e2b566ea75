"""The second program's joints with play meet closed forms: bounces in bearings and on faces, friction."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.support import multibody_run
from tests.support.multibody import GROUND, Body, Marker, Now, Play, Prismatic, Revolute, System
from tests.support.multibody_beams import Row
from tests.support.multibody_loads import kelvin_voigt, tanh_friction
from tests.support.multibody_run import assemble, closed, follow


def bounce(K, C, m, tension):
    """Restitution by Kelvin and Voigt's law, and time of contact; without tension until the force is gone."""
    zeta, w = C / (2 * math.sqrt(K * m)), math.sqrt(K / m)
    root = math.sqrt(1 - zeta**2)
    turned = math.pi if tension else 2 * math.acos(zeta)
    return math.exp(-zeta * turned / root), turned / (w * root)


@pytest.mark.parametrize("tension", [True, False])
def test_a_body_bounces_in_its_bearing_as_the_law_s_integral(tension):
    K, C, m, e, v = 1e6, 300.0, 0.25, 1e-3, 2.0
    joint = Revolute("B", Marker("ball"), Marker(GROUND), Play(e, kelvin_voigt(K, C), None, tension, 0.01))
    system = System([Body("ball", m, 1.0)], [joint], gravity=0.0)
    y = np.array([0.0, 0.0, 0.0, 0.6 * v, 0.8 * v, 0.0])
    e_r, lasting = bounce(K, C, m, tension)
    (state,), _, events = follow(system, y, [2.0 * e / v + lasting], rtol=1e-12)
    kinds = ["contact", "separation"] if tension else ["contact", "release", "separation"]
    assert [event.kind for event in events] == kinds
    assert events[0].time == pytest.approx(e / v, rel=1e-12)
    assert events[1].time - events[0].time == pytest.approx(lasting, rel=1e-10)
    assert state[3:5] == pytest.approx([-0.6 * v * e_r, -0.8 * v * e_r], rel=1e-10)


@pytest.mark.nightly
@pytest.mark.parametrize("kind", [Revolute, Prismatic])
def test_two_bodies_that_rattle_keep_energy_and_momentum(kind):
    """Journal and bearing, or slider and guide, both moving and off their bodies' lines, without damping."""
    K = 1e6
    play = Play(1e-3, lambda u, v_n: K * u, None, True, 0.01, 0.03, 0.02, lambda u: 0.5 * K * u * u)
    p, q = Marker("one", (0.11, 0.03), 0.4), Marker("two", (0.07, -0.05), -0.3)
    bodies = [Body("one", 1.2, 0.03, 0.02), Body("two", 0.7, 0.01)]
    y = assemble(System(bodies, [kind("P", p, q)]), {"one": 0.3, "two": 1.0}, speeds={"one": 3.0, "two": 2.0})
    y[6:] += [0.2, 0.1, 0.5, -0.1, 0.3, -0.4]
    system = System(bodies, [kind("P", p, q, play)], gravity=0.0)
    times = np.linspace(0.0, 0.08, 9)
    states, modes, events = follow(system, y, times, rtol=1e-11)
    assert {event.touch for event in events} >= ({0} if kind is Revolute else {0, 3})
    assert any("closed" in row for row in modes)
    energy = [system.energy(t, x, closed(row)) for t, x, row in zip(times, states, modes, strict=True)]
    assert energy == pytest.approx([energy[0]] * 9, rel=1e-9)
    m = system.mass[[0, 3]]
    assert states[:, [6, 9]] @ m == pytest.approx([y[[6, 9]] @ m] * 9, rel=1e-9)
    spin = [system.mass @ (x[:6] * _quarter(x[6:]) + [0, 0, x[8], 0, 0, x[11]]) for x in states]
    assert spin == pytest.approx([spin[0]] * 9, rel=1e-9)


def _quarter(v):
    """(v_y, −v_x, 0) of every body, whose product with (x, y, θ) is its moment of speed."""
    return np.array([v[1], -v[0], 0.0, v[4], -v[3], 0.0])


@pytest.mark.nightly
@pytest.mark.parametrize("side", [1, -1])
def test_a_slider_lands_flat_on_either_face_with_two_corners(side):
    K, C, m, c, v = 1e6, 100.0, 0.5, 1e-3, 0.2
    play = Play(c, kelvin_voigt(K, C), None, False, half_length=0.05, half_height=0.02)
    joint = Prismatic("G", Marker("block", (0.0, 0.0), 0.1), Marker(GROUND, (0.0, 0.0), 0.3), play)
    system = System([Body("block", m, 1e-4)], [joint], gravity=0.0)
    n = np.array([-math.sin(0.3), math.cos(0.3)])
    y = np.array([0.0, 0.0, 0.2, *(side * v * n), 0.0])
    e_r, lasting = bounce(2 * K, 2 * C, m, False)
    (_, hit, state), modes, events = follow(
        system, y, [0.5 * c / v, c / v + lasting / 2, c / v + 2 * lasting], rtol=1e-12
    )
    assert modes[:2] == [["free"] * 4, ["closed" if (k < 2) == (side > 0) else "free" for k in range(4)]]
    assert [event.time for event in events[:2]] == pytest.approx([c / v] * 2, rel=1e-11)
    assert np.sum(n * hit[:2]) * side > c
    assert state[3:5] == pytest.approx(-side * v * e_r * n, rel=1e-9)
    assert abs(state[5]) < 1e-9


@pytest.mark.nightly
def test_a_block_slides_down_a_guide_with_friction():
    """After it has settled: corners carry the weight by levers, speed grows by g (sin − f cos)."""
    slope, f, m, g = 0.5, 0.2, 0.5, 9.8
    play = Play(
        1e-4, kelvin_voigt(1e6, 700.0), tanh_friction(f, 1e-5), False, half_length=0.05, half_height=0.02
    )
    joint = Prismatic("G", Marker("block"), Marker(GROUND, (0.0, 0.0), -slope), play)
    system = System([Body("block", m, 1e-3)], [joint], gravity=g)
    low = np.array([-math.sin(slope), -math.cos(slope)]) * 1.02e-4
    y = np.array([*low, -slope, math.cos(slope), -math.sin(slope), 0.0])
    (state,), (modes,), _ = follow(system, y, [0.2], rtol=1e-8)
    solved = system.solve(0.2, state, closed(modes))
    fore, aft = (solved.touches[k][2] for k in (2, 3))
    lever = f * 0.02 / 0.05  # friction at the lower face tips the block forwards
    weight = m * g * math.cos(slope) / 2
    assert [fore, aft] == pytest.approx([weight * (1 + lever), weight * (1 - lever)], rel=1e-4)
    d = np.array([math.cos(slope), -math.sin(slope)])
    assert solved.acceleration[:2] @ d == pytest.approx(g * (math.sin(slope) - f * math.cos(slope)), rel=1e-6)


RIGID = {"law": None, "restitution": 0.6}


def ball(play, inertia=1e-3):
    """A ball in its bearing, without weight."""
    joint = Revolute("B", Marker("ball"), Marker(GROUND), play)
    return System([Body("ball", 0.25, inertia)], [joint], gravity=0.0)


@pytest.mark.parametrize("f", [0.0, 0.05, 2.0])
def test_a_rigid_ball_rebounds_by_newton_s_and_coulomb_s_laws(f):
    """Spinning, it slips by f times the impulse, or comes to roll; a chord of its bearing later again."""
    e, R, m, J, v, w, r = 1e-3, 0.01, 0.25, 1e-3, 2.0, -30.0, 0.6
    play = Play(e, radius=R, dry=(lambda v: f) if f else None, **RIGID)
    y = np.array([0.0, 0.0, 0.0, v, 0.0, w])
    (state,), _, events = follow(ball(play, J), y, [1.5 * e / v], rtol=1e-11)
    assert [event.kind for event in events] == ["impact"]
    assert events[0].time == pytest.approx(e / v, rel=1e-12)
    push = (1 + r) * m * v
    whole = 1 / (1 / m + R * R / J)  # stops the sliding w R
    across = min(f * push, whole * abs(w * R))  # against the sliding, which is along -y
    assert state[3:6] == pytest.approx([-r * v, across / m, w + R * across / J], rel=1e-11, abs=1e-14)


@pytest.mark.parametrize("far", [0.0, 0.3])
def test_rebounds_end_at_rest_when_their_series_does(far, monkeypatch):
    """The last of them are lower than the rounding of where the ball is, so far from the origin."""
    monkeypatch.setattr(multibody_run, "MOST", 60)
    e, g, v, r, place = 1e-3, 1000.0, 1e-3, 0.6, np.array([far, -far])
    joint = Revolute("B", Marker("ball"), Marker(GROUND, tuple(place)), Play(e, radius=0.01, **RIGID))
    system = System([Body("ball", 0.25, 1e-3)], [joint], gravity=g)
    y = np.array([*(place - (0.0, e - 1e-12)), 0.0, 0.0, v, 0.0])
    series = 2 * v / g / (1 - r)
    _, (modes,), events = follow(system, y, [1.1 * series], rtol=1e-11)
    assert modes == ["rest"]
    assert [event.kind for event in events] == ["impact"] * (len(events) - 1) + ["rest"]
    assert len(events) - 1 == pytest.approx(math.log(multibody_run.STILL / v) / math.log(r), abs=3)
    assert events[-1].time == pytest.approx(series, rel=1e-3)


@pytest.mark.nightly
@pytest.mark.parametrize("rigid", [False, True])
def test_a_block_that_goes_up_a_slope_turns_back(rigid):
    """By dry friction: it stops by g (sin + f cos), and goes down by g (sin − f cos)."""
    f, m, g, v, slope = 0.2, 0.5, 9.8, 0.02, 0.5
    law = RIGID | {"restitution": 0.0} if rigid else {"law": kelvin_voigt(1e7, 2000.0), "tension": False}
    play = Play(1e-4, dry=lambda v: f, half_length=0.05, half_height=1e-9, **law)
    joint = Prismatic("G", Marker("block"), Marker(GROUND, (0.0, 0.0), -slope), play)
    system = System([Body("block", m, 1e-3)], [joint], gravity=g)
    d = np.array([math.cos(slope), -math.sin(slope)])
    low = np.array([-math.sin(slope), -math.cos(slope)])
    sunk = -1e-12 if rigid else m * g * math.cos(slope) / 2e7  # rigid, it lands at once
    y = np.array([*(low * (1e-4 + sunk)), -slope, *(-v * d), 0.0])
    (state,), (modes,), events = follow(system, y, [0.02], rtol=1e-9)
    stop = v / (g * (math.sin(slope) + f * math.cos(slope)))
    late = [event for event in events if event.time > 0.5 * stop]
    assert {event.kind for event in late} == {"slip_reversal"}
    assert [event.time for event in late] == pytest.approx([stop] * 2, rel=1e-4)
    down = g * (math.sin(slope) - f * math.cos(slope)) * (0.02 - stop)
    assert state[3:5] @ d == pytest.approx(down, rel=1e-3)
    assert modes[2:] == [("rest" if rigid else "slip") + "+"] * 2


@pytest.mark.nightly
@pytest.mark.parametrize("axial", [False, True])
def test_a_bent_body_that_tumbles_keeps_energy_and_moment_of_momentum(axial):
    """Free, bent and stretched at the start, without damping; its modes are those of a pinned beam."""
    l, m, EI, EA = 0.3, 0.2, 0.4, 3e3
    row = Row(l, m, EI, EA, 0.0, "sine", 2, axial)
    M = row.across.T @ (row.weight[:, None] * row.across)
    squares = np.diag(row.stiffness)[:2] / np.diag(M)[:2]
    assert squares == pytest.approx([(k * math.pi / l) ** 4 * EI * l / m for k in (1, 2)], rel=1e-12)
    system = System([Body("bar", 0.5, 0.02, 0.11, row)], [], gravity=0.0)
    n = system.n
    y = np.zeros(2 * n)
    y[3:5], y[n : n + 5] = (0.01, -0.004), (0.4, -0.3, 9.0, 0.2, 0.1)
    y[5:n] = [1e-3, -4e-4][: n - 5]

    def kept(y):
        momentum = system.inertia(Now(system, 0.0, y))[0] @ y[n:]
        across = np.array([-y[1], y[0], 1.0, *np.zeros(n - 3)])  # turning all about the origin
        return [system.energy(0.0, y), *momentum[:2], across @ momentum]

    states, _, _ = follow(system, y, [0.05, 0.1], rtol=1e-11)
    assert np.abs(states[1][3:n]).max() > 1e-4
    for state in states:
        assert kept(state) == pytest.approx(kept(y), rel=1e-8)


def test_a_slider_between_faces_reaches_its_first_impact():
    """Flores, Leine and Glocker (2010): a slider in a guide with play, until it touches the upper face.

    Up to there the slider, held at its centre, does not turn, so both upper corners arrive at once. The
    numbers are those of the two angles' own equations, by Taylor series with 34 digits.
    """
    bodies = [
        Body("crank", 0.038, 7.4e-5, 0.0765),
        Body("rod", 0.038, 5.9e-4, 0.153),
        Body("slider", 0.076, 2.7e-6),
    ]
    play = Play(0.001, kelvin_voigt(1e8, 0.0), half_length=0.05, half_height=0.025)
    joints = [
        Revolute("O", Marker("crank"), Marker()),
        Revolute("A", Marker("rod"), Marker("crank", (0.153, 0.0))),
        Revolute("B", Marker("slider"), Marker("rod", (0.306, 0.0))),
        Prismatic("G", Marker("slider"), Marker(), play),
    ]
    system = System(bodies, joints, gravity=9.81)
    held = {"crank": (0.0, 150.0), "rod": (0.0, -75.0), "slider": (0.0, 0.0)}
    y = assemble(System(bodies, joints[:3]), {"crank": 0.0, "rod": 0.0, "slider": 0.0}, held)
    _, _, events = follow(system, y, [0.0027], rtol=1e-13)
    assert {(event.kind, event.touch) for event in events[:2]} == {("contact", 0), ("contact", 1)}
    assert [event.time for event in events[:2]] == pytest.approx([0.00269250275202121] * 2, rel=1e-11)
    first = events[0].y
    assert first[[2, 5]] == pytest.approx([0.355304455027745, -0.171509540940174], rel=1e-11)
    assert first[[11, 14]] == pytest.approx([109.557681543150, -49.3307899619314], rel=1e-11)
    assert first[[6, 15, 16]] == pytest.approx(
        [0.444954161274559, -8.40750818651036, 0.841612322032869], rel=1e-11
    )
    assert np.abs(first[[8, 17]]).max() < 1e-9
