"""Springs with dampers: closed forms, virtual work by differences, energy; and where their ends meet."""

from __future__ import annotations

import numpy as np
import pytest

from jointplay.solver.equations.structure import powers
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.parts.loads import Spring, TorsionSpring
from tests.reference.four_bar import Parameters
from tests.support.linkages import SOFT, bending, mechanism
from tests.support.motion import at, bar, double, follow, forces, pendulum, seen
from tests.support.plain import Point, plain


def straight(first, second, stiffness=800.0, damping=0.0, free_length=0.05, name="straight"):
    ends = {"from": first, "to": second}
    return Spring(name=name, stiffness=stiffness, damping=damping, free_length=free_length, **ends)


def twisted(first, second, stiffness=3.0, damping=0.0, angle=0.4):
    ends = {"from": first, "to": second}
    return TorsionSpring(name="twisted", stiffness=stiffness, damping=damping, angle=angle, **ends)


PEG = {"link": "ground", "point": (0.3, 0.25)}
OF_FOUR_BAR = (
    straight({"link": "coupler", "at": 0.06}, {"link": "rocker", "at": 0.05}),
    straight(PEG, {"link": "rocker", "at": 0.1}, name="peg"),
    straight({"link": "crank", "at": 0.02}, {"link": "coupler", "at": 0.1}, name="near"),
)
TWISTED = twisted("coupler", "rocker")
OBLIQUE = {"gravity": 9.8, "gravity_direction": 2.5}


def test_a_torsion_spring_swings_at_its_frequency():
    k, J = 3.0, 0.1
    sprung = pendulum(springs=(twisted("arm", "ground", k, angle=0.4),))
    times = np.linspace(0.0, 5.0, 11)
    _, states, _ = follow(sprung, at(sprung, [1.0], [0.0]), times)
    assert states[:, 0] == pytest.approx(0.4 + 0.6 * np.cos(np.sqrt(k / J) * times), abs=1e-10)


def test_a_damper_takes_the_swing_away():
    k, c, J = 3.0, 0.2, 0.1
    sprung = pendulum(springs=(twisted("ground", "arm", k, c, angle=0.0),))
    times = np.linspace(0.0, 3.0, 7)
    _, states, _ = follow(sprung, at(sprung, [1.0], [0.0]), times)
    decay, w = c / (2 * J), np.sqrt(k / J - (c / (2 * J)) ** 2)
    exact = np.exp(-decay * times) * (np.cos(w * times) + decay / w * np.sin(w * times))
    assert states[:, 0] == pytest.approx(exact, abs=1e-10)


LONG = {"marks": pytest.mark.nightly}
CASES = [  # joints with play, parts, what bends
    pytest.param("AB", OBLIQUE | {"springs": (*OF_FOUR_BAR, TWISTED)}, "", id="floating", **LONG),
    pytest.param("AB", OBLIQUE | {"springs": OF_FOUR_BAR}, "coupler", id="bent", **LONG),
    pytest.param("", OBLIQUE | {"springs": OF_FOUR_BAR}, "", id="loop", **LONG),
    pytest.param("", OBLIQUE | {"springs": OF_FOUR_BAR}, "coupler", id="bent_loop"),
]


@pytest.mark.nightly
@pytest.mark.parametrize(("joints", "parts", "soft"), CASES)
def test_forces_of_a_four_bar_are_slopes_of_the_energy(joints, parts, soft):
    if soft:
        parts = parts | {"springs": tuple(s for s in parts["springs"] if s.name == "peg")}
    p = Parameters(i=3.0, drive="none", gravity=0.0)
    rigid = mechanism(p, dict.fromkeys(joints, 2.9e-5)).replace(**parts)
    given = bending(rigid, {soft: SOFT[soft]} if soft else {})
    check_slopes(assemble(given, {"crank_angle": 0.7, "crank_speed": 0.0}))


def check_slopes(model):
    """Q = -dV/dq on every freedom of a linkage at rest, by central differences."""
    n_q, random = len(model.turning), np.random.default_rng(3)
    state = model.state + np.concatenate([1e-3 * random.standard_normal(n_q), np.zeros(n_q)])
    Q = forces(model, state)
    for i in range(n_q):
        step = 1e-6 * np.eye(2 * n_q)[i]
        energies = [seen(model, state + sign * step)["potential_energy"] for sign in (1, -1)]
        slope = (energies[0] - energies[1]) / 2e-6
        assert Q[i] == pytest.approx(-slope, rel=1e-6, abs=1e-6 * np.abs(Q).max())
    assert np.abs(Q).max() > 0.1


@pytest.mark.parametrize("clearance", [0.0, 1e-4])
def test_forces_are_slopes_of_the_energy(clearance):
    """Also of a chain that floats, where a spring within it does not feel where it is."""
    springs = (
        straight({"link": "hand", "at": 0.3}, PEG),
        straight({"link": "hand", "at": 0.4}, {"link": "arm", "at": 0.1}, name="within"),
        twisted("arm", "hand"),
    )
    given = double(springs=springs, clearance=clearance, **OBLIQUE)
    check_slopes(assemble(given, at(given, [0.3, -0.9], [0.0, 0.0])))


@pytest.mark.nightly
def test_the_balance_of_energy_closes():
    sprung = double(
        gravity=9.8,
        springs=(
            straight(PEG, {"link": "hand", "at": 0.4}, 60.0, 1.5, 0.1),
            straight({"link": "ground", "point": (0.1, 0.6)}, {"link": "arm", "at": 0.2}, name="arm"),
            twisted("hand", "arm", 2.0, 0.05),
        ),
    )
    model, states, work = follow(sprung, at(sprung, [0.3, -0.4], [1.0, 4.0]), np.linspace(0.0, 2.0, 9))
    found = [seen(model, state) for state in states]
    energy = np.array([each["kinetic_energy"] + each["potential_energy"] for each in found])
    lost = dict(zip(powers(model.structure), work.T, strict=True))["springs"]
    assert lost[-1] > 1.0
    assert energy - energy[0] == pytest.approx(-lost, abs=1e-9 * lost[-1])
    stored = [each["strain_energy"] for each in found]
    assert max(stored) > 0.1


@pytest.mark.parametrize("free_length", [0.0, 0.1])
def test_where_its_ends_meet_all_is_finite(free_length):
    sprung = double(springs=(straight({"link": "hand"}, {"link": "arm", "at": 0.4}, 60.0, 1.5, free_length),))
    model = assemble(sprung, at(sprung, [0.3, -0.4], [1.0, 4.0]))
    plain_one = assemble(double(), at(sprung, [0.3, -0.4], [1.0, 4.0]))
    assert seen(model, model.state)["angular_acceleration:hand"] == pytest.approx(
        seen(plain_one, plain_one.state)["angular_acceleration:hand"], rel=1e-12
    )
    assert np.all(np.isfinite(Point(plain(model.structure), model.numbers, model.state, []).jacobian()))


def test_pins_feel_a_spring():
    """A spring across a pin presses its two sides together: F along its line, the pendulum at rest."""
    hand = straight({"link": "arm", "at": 0.4}, {"link": "ground", "point": (0.1, 0.3)}, 100.0, 0.0, 0.0)
    model = assemble(pendulum(springs=(hand,)), at(pendulum(), [np.pi / 2], [0.0]))
    found = seen(model, model.state)
    assert (found["reaction_x:O"], found["reaction_y:O"]) == pytest.approx((0.0, 100.0 * 0.1), abs=1e-12)


# Masses, inertia, gravity


def rates(given, angles=(0.7,), speeds=(2.0,)):
    model = assemble(given, at(given, angles, speeds))
    return seen(model, model.state)


def test_a_point_mass_is_part_of_the_body():
    m, s, J, point, x = 1.5, 0.15, 0.1, 0.4, 0.35
    ours = bar("arm", masses=[{"at": x, "mass": point}])
    whole = bar("arm", mass=m + point, centre=(m * s + point * x) / (m + point), inertia=J + point * x**2)
    spring = (straight(PEG, {"link": "arm", "at": 0.4}),)
    one, other = (rates(pendulum(link, gravity=9.8, springs=spring)) for link in (ours, whole))
    assert one == pytest.approx(other, rel=1e-14)
    assert one["angular_acceleration:arm"] != rates(pendulum(gravity=9.8))["angular_acceleration:arm"]


def test_inertia_about_the_mass_centre():
    m, s, J = 1.5, 0.15, 0.1
    ours = bar("arm", inertia=None, inertia_centre=J - m * s**2)
    one, other = (rates(pendulum(link, gravity=9.8)) for link in (ours, bar("arm")))
    assert one == pytest.approx(other, rel=1e-14)


def test_gravity_aside_is_a_turned_mechanism():
    """Two links under gravity along +x, and the same turned by a quarter under gravity along -y."""
    quarter = np.pi / 2
    aside = double(gravity=9.8, gravity_direction=0.0)
    one = rates(aside, (0.7, -0.2), (2.0, -1.0))
    other = rates(double(gravity=9.8), (0.7 - quarter, -0.2 - quarter), (2.0, -1.0))
    for k in ("arm", "hand"):
        word = f"angular_acceleration:{k}"
        assert one[word] == pytest.approx(other[word], rel=1e-12)
    for name in "OA":
        assert one[f"reaction_x:{name}"] == pytest.approx(-other[f"reaction_y:{name}"], rel=1e-12)
        assert one[f"reaction_y:{name}"] == pytest.approx(other[f"reaction_x:{name}"], rel=1e-12)
    assert one["kinetic_energy"] == pytest.approx(other["kinetic_energy"], rel=1e-14)
    assert (
        abs(
            one["angular_acceleration:arm"]
            - rates(double(), (0.7, -0.2), (2.0, -1.0))["angular_acceleration:arm"]
        )
        > 1
    )
