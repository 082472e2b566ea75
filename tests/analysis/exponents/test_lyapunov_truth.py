"""Exponents of maps and motions that are known exactly: through the frame's own algebra, and by monodromy."""

import math

import numpy as np
import pytest
from scipy.linalg import expm

import jointplay as jp
from jointplay import catalog
from jointplay.analysis.quantities import EVENTS
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.method.tangents.tangent import orthonormalise
from tests.analysis.exact_maps import TAU, Symmetric, distinct, strobed, symmetry_lost
from tests.support.tangent_map import tangent_map

GEAR = {"mean_load": 0.1, "amplitude": 0.2, "damping": 0.05}


def henon_exponents(steps, weight=(1.0, 1.0)):
    """Mean logarithms of a frame that the Jacobian of (1 - 1.4 x² + y, 0.3 x) moves, step by step."""
    x, y = 0.1, 0.1
    d, logs, norms = np.array([0.0, 1.0, 0.3, 0.0, -0.2, 1.0]), np.zeros(2), np.zeros(2)
    alive, weight = np.ones(2, dtype=np.int64), np.asarray(weight)
    for step in range(-100, steps):
        if step == 0:
            logs[:] = 0.0
        d[1], d[2], d[4], d[5] = -2.8 * x * d[1] + d[2], 0.3 * d[1], -2.8 * x * d[4] + d[5], 0.3 * d[4]
        orthonormalise(d, 3, weight, alive, norms, logs, 0.0)
        x, y = 1 - 1.4 * x * x + y, 0.3 * x
    return logs / steps


@pytest.mark.nightly
@pytest.mark.parametrize("weight", [(1.0, 1.0), (1.0, 40.0)])
def test_henon(weight):
    """0.41922 and -1.62319, whatever units the frame is measured in; their sum is ln 0.3."""
    found = henon_exponents(60_000, weight)
    assert found == pytest.approx([0.41922, -1.62319], abs=3e-3)
    assert found.sum() == pytest.approx(math.log(0.3), abs=1e-12)


def test_limits_of_the_symmetric_motion():
    """The closed forms that the tests lean on, against their published values."""
    for restitution, lost, fold in (
        (0.8, 2.891098576536364, 28.3449811516649),
        (0.6, 2.731718453347995, 12.724530263134657),
    ):
        assert symmetry_lost(restitution) == pytest.approx(lost, rel=1e-14)
        assert Symmetric(1.0, restitution).fold == pytest.approx(fold, rel=1e-14)


GAPS = [(2.9, 0.8), (3.6, 0.8), (10.0, 0.8), (20.0, 0.8), (28.3, 0.8), (2.75, 0.6), (8.0, 0.6), (12.7, 0.6)]


@pytest.mark.parametrize(("gap", "restitution"), GAPS)
def test_half_period_map(gap, restitution):
    """Half a period on, the motion is its mirror image: minus the tangent map has the closed form's roots."""
    exact = Symmetric(gap, restitution)
    trace, determinant = exact.half_map
    half = -tangent_map(assemble(catalog.impact_pair(gap, restitution), exact.at_zero), math.pi, 1e-13)
    assert np.trace(half) == pytest.approx(trace, abs=1e-12)
    assert np.linalg.det(half) == pytest.approx(determinant, abs=1e-12)
    expected = np.sort_complex(np.roots([1, -trace, determinant]))
    assert np.sort_complex(np.linalg.eigvals(half)) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("restitution", [0.8, 0.6])
def test_a_root_crosses_at_the_limits(restitution):
    """-1 where symmetry is lost, +1 at the fold: the tangent map knows both."""
    for gap, root, h in (
        (symmetry_lost(restitution), -1.0, 1e-6),
        (Symmetric(1.0, restitution).fold * (1 - 1e-12), 1.0, 1e-5),
    ):
        model = assemble(catalog.impact_pair(gap, restitution), Symmetric(gap, restitution).at_zero)
        roots = np.linalg.eigvals(-tangent_map(model, math.pi, 1e-13))
        assert np.abs(roots - root).min() < h


def test_a_bend_in_the_rate_makes_no_jump():
    """The jerk with |x|: the rate is continuous at x = 0, its Jacobian is not; S is the identity."""
    keywords = {"exponents": "all", "duration": 300, "initial": (0.1, 0.1, 0.1)}
    right, without = (jp.lyapunov(catalog.jerk(), saltation=on, **keywords) for on in (True, False))
    assert int(right.n_events) > 50
    assert right.lyapunov_exponent.values == pytest.approx(without.lyapunov_exponent.values, abs=1e-9)
    assert float(right.lyapunov_exponent.sum()) == pytest.approx(-0.6, rel=1e-9)


def settled(system, turns, **start):
    """Section point at rtol 1e-12."""
    return jp.poincare(system, turns=1, transient=turns, rtol=1e-12, **start).state_value.values[-1]


def monodromy(system, place, periods):
    """Exponents of a periodic motion from its multipliers, the largest first."""
    duration = periods * system.period
    multipliers = np.abs(np.linalg.eigvals(tangent_map(assemble(system, place), duration, 1e-12)))
    return np.sort(np.log(multipliers) / duration)[::-1]


WINDOWS = {  # system, start, period, largest exponent
    "impacts 0.6": (catalog.impact_pair(0.6, 0.8), {"initial": (0.05, 0.7)}, 4, -0.02902),
    "impacts 1.4": (catalog.impact_pair(1.4, 0.8), {"initial": (0.05, 0.7)}, 4, -0.01137),
    "gears 0.8": (catalog.gear_backlash(frequency=0.8, **GEAR), {}, 2, -0.01242),
    "gears 1.0": (catalog.gear_backlash(frequency=1.0, **GEAR), {}, 4, -0.02903),
}


@pytest.mark.parametrize("name", WINDOWS)
def test_periodic_windows(name):
    system, start, periods, known = WINDOWS[name]
    place = settled(system, 1500, **start)
    exact = monodromy(system, place, periods)
    assert exact[0] == pytest.approx(known, abs=1e-5)
    found = jp.lyapunov(system, exponents=2, turns=400, initial=place, transient=200)
    assert found.lyapunov_exponent.values == pytest.approx(exact, abs=1e-5)
    assert abs(float(found.lyapunov_exponent[0]) - known) < 2e-5


def test_coexisting_motions():
    """One place with λ₁ = ln(0.8)/π, three with the same: complex multipliers, so volume says it all."""
    pair = catalog.impact_pair(3.6, 0.8)
    for time, speed, places in ((2.0, 0.5, 1), (1.0, 1.3, 3)):
        place = settled(pair, 400, initial=strobed(3.6, 0.8, (time, -1.8, speed), 1))
        again = jp.poincare(pair, turns=12, initial=place)
        assert distinct(again) == places
        exponents = monodromy(pair, place, places)
        impacts = jp.simulate(pair, turns=places, initial=place).sizes["event"]
        assert exponents.sum() == pytest.approx(2 * impacts * math.log(0.8) / (places * TAU), abs=1e-10)
        if places == 1:
            assert exponents == pytest.approx([math.log(0.8) / math.pi] * 2, abs=1e-10)


def jump(system, start, kind):
    """The tangents' jump at the first event of a kind: what the linear flows around it leave of their map."""
    K, C = (system.parameters[name] for name in ("stiffness", "damping"))
    events = jp.simulate(system, turns=1, initial=start, rtol=1e-13)
    times = events.event_time.values
    place = [EVENTS[each] for each in events.event_kind.values].index(kind)
    edges = np.r_[0.0, times]
    before, after = (edges[place] + edges[place + 1]) / 2, (times[place] + times[place + 1]) / 2
    maps = [tangent_map(assemble(system, start), end, 1e-13) for end in (before, after)]
    free, touching = np.array([[0.0, 1], [0, 0]]), np.array([[0.0, 1], [-K, -C]])
    first, second = (free, touching) if kind == "contact" else (touching, free)
    across = maps[1] @ np.linalg.inv(maps[0])
    return expm(-second * (after - times[place])) @ across @ expm(-first * (times[place] - before)), C


@pytest.mark.parametrize("speed", [0.7, -0.7])
@pytest.mark.parametrize("tension", [True, False])
def test_entry_into_a_wall_with_damping(speed, tension):
    """With p = v + (c/m) penetration, whose rate does not jump at entry: δp = δv, and δy stays."""
    system = catalog.soft_impact_pair(0.5, 50.0, 2.0, tension=tension)
    S, C = jump(system, (0.0, speed), "contact")
    assert S[0] == pytest.approx([1, 0], abs=1e-10)
    assert np.array([C, 1.0]) @ S == pytest.approx([0, 1], abs=1e-9)


@pytest.mark.parametrize(("tension", "back"), [(True, 1.0), (False, 0.0)])
def test_exit_from_a_wall_with_damping(tension, back):
    """A wall that pulls lets go with the jump undone; one that does not, at no force, without any."""
    system = catalog.soft_impact_pair(0.5, 50.0, 2.0, tension=tension)
    S, C = jump(system, (0.0, 0.7), "separation")
    assert pytest.approx(np.array([[1, 0], [back * C, 1]]), abs=1e-9) == S
