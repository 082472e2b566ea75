"""Fixed steps of Runge and Kutta's method: order, stability, loads, contact decided at the stages."""

from __future__ import annotations

import math

import numpy as np
import pytest

import jointplay as jp
from jointplay.analysis.evaluate import Quantities
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.method import runge_kutta
from jointplay_lab.paper.fixed_steps import March, step_bound

PAPER = jp.catalog.chunmei2002(gear_ratio=3.0)
TIGHT = 1e-13


def end(mechanism, duration, count):
    """State after `count` steps."""
    model = assemble(mechanism)
    rows = March.of(model)(np.concatenate([[0.0], model.state]), duration / count, count)
    return rows[-1, 1 : 1 + len(model.state)]


def exact(mechanism, duration):
    """The same state by the implicit method with located events."""
    found = jp.simulate(mechanism, duration=duration, at=[duration], rtol=TIGHT)
    names = ["angle", "angular_velocity"] if "angle" in found else ["state_value"]
    return np.concatenate([found[name].values[0] for name in names])


def order(mechanism, duration, counts):
    """Slope of log error over log step, by regression."""
    truth = exact(mechanism, duration)
    errors = [np.abs(end(mechanism, duration, count) - truth).max() for count in counts]
    return -np.polyfit(np.log(counts), np.log(errors), 1)[0]


def flight():
    """Nine tenths of the time until the first contact, s."""
    return 0.9 * float(jp.simulate(PAPER, turns=1, rtol=1e-10).event_time[0])


def test_order_on_a_test_system():
    counts = (280, 400, 560, 800, 1120, 1600)
    assert order(jp.catalog.lorenz(), 1.0, counts) == pytest.approx(4.0, abs=0.2)


def test_order_of_a_linkage_in_flight():
    assert order(PAPER, flight(), (24, 32, 48, 64, 96)) == pytest.approx(4.2, abs=0.3)


def test_order_across_contacts_is_first():
    counts = np.round(1500 * 1.25 ** np.arange(20)).astype(int)
    period = assemble(PAPER).period
    assert order(PAPER, period, counts) == pytest.approx(1.0, abs=0.35)


def test_a_turn_agrees_with_the_implicit_method():
    period = assemble(PAPER).period
    found, truth = end(PAPER, period, 40_000), exact(PAPER, period)
    assert np.abs(found - truth)[:3].max() < 1e-7
    assert np.abs(found - truth)[3:].max() < 1e-3


def test_loads_are_linear_between_the_steps_ends():
    """x'' = F(t) in the dead zone, F linear: the method is exact."""
    system = jp.catalog.gear_backlash(mean_load=0.0, amplitude=0.0, frequency=1.0, damping=0.0)
    model = assemble(system.replace(initial=(0.1, -0.2)))
    t = 0.05 * np.arange(21)
    rows = March.of(model, ("mean_load",))(np.array([0.0, 0.1, -0.2]), 0.05, 20, (0.3 + 0.6 * t)[:, None])
    assert rows[:, 0] == pytest.approx(t, abs=1e-15)
    assert rows[:, 1] == pytest.approx(0.1 - 0.2 * t + 0.15 * t**2 + 0.1 * t**3, abs=1e-15)
    assert rows[:, 2] == pytest.approx(-0.2 + 0.3 * t + 0.3 * t**2, abs=1e-15)


@pytest.mark.parametrize("tension", [True, False])
def test_contact_and_slip_follow_the_state(tension):
    mechanism = PAPER.replace(clearance=2.9e-4, tension=tension, friction=0.3)
    model = assemble(mechanism)
    rows = March.of(model)(np.concatenate([[0.0], model.state]), 1e-5, 7500)
    names = ("penetration", "normal_velocity", "tangential_velocity", "normal_force", "mode")
    found = Quantities(model, rows, rows[0]).variables(names, "time")
    u, v_n, v_t, force, mode = (found[name][1][:, 0] for name in names)
    law = 7.15e6 * u + 228.0 * v_n
    touching = (u >= 0) & (tension | (law > 0))
    assert 0.1 < touching.mean() < 0.95
    assert np.array_equal(mode > 1, touching)
    assert np.array_equal(mode == 1, (u >= 0) & ~touching)
    assert np.array_equal((mode == 2)[touching], (v_t > 0)[touching])
    assert np.array_equal((mode == 3)[touching], (v_t < 0)[touching])
    assert force == pytest.approx(np.where(touching, law, 0.0), rel=1e-9, abs=1e-6)
    assert (force.min() < 0) == tension


def test_going_on_changes_no_bit():
    model = assemble(PAPER)
    start = np.concatenate([[0.0], model.state])
    whole = March.of(model)(start, 1e-5, 2000)
    first = March.of(model)(start, 1e-5, 700)
    second = March.of(model)(first[-1, : len(start)], 1e-5, 1300)
    assert np.array_equal(whole[:, 1:], np.concatenate([first, second[1:]])[:, 1:])


def test_edge_of_stability():
    steps = runge_kutta.longest_steps(np.array([-1.0, 2j, -1e6, 0.0, 1.0, 0.5 + 2j, -1.0 + 1j]))
    assert steps[:3] == pytest.approx([2.785293563405, math.sqrt(2), 2.785293563405e-6], rel=1e-11)
    assert np.all(np.isinf(steps[3:5]))
    assert steps[5] == pytest.approx(math.sqrt(2), rel=1e-11)  # growth is the system's own
    z = steps[6] * (-1.0 + 1j)
    assert abs(1 + z + z**2 / 2 + z**3 / 6 + z**4 / 24) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize(("share", "stable"), [(0.99, True), (1.01, False)])
def test_the_bound_is_where_steps_blow_up(share, stable):
    """Out of contact x'' = -2 zeta x', in contact x'' = -2 zeta x' - (x - 1)."""
    system = jp.catalog.gear_backlash(mean_load=1.0, amplitude=0.0, frequency=0.1, damping=50.0)
    model = assemble(system.replace(initial=(1.5, 0.3)))
    bound = step_bound(model)
    assert bound.eigenvalue == pytest.approx(-100.0, rel=1e-6)
    assert bound.step == pytest.approx(2.785293563405e-2, rel=1e-6)
    rows = March.of(model)(np.array([0.0, 1.5, 0.3]), share * bound.step, 400)
    assert (abs(rows[-1, 2]) < 0.3) == stable


def test_the_bound_of_an_undamped_contact():
    system = jp.catalog.gear_backlash(mean_load=1.0, amplitude=0.0, frequency=0.1, damping=0.0)
    bound = step_bound(assemble(system.replace(initial=(1.5, 0.0))))
    assert abs(bound.eigenvalue) == pytest.approx(1.0, rel=1e-6)
    assert bound.step == pytest.approx(2 * math.sqrt(2), rel=1e-6)
    assert bound.cause == "the contact's stiffness"


def test_the_motor_s_slope_bounds_the_paper_s_mechanism():
    bounds = [step_bound(assemble(PAPER.replace(gear_ratio=ratio))) for ratio in (3.0, 15.0)]
    assert [bound.step for bound in bounds] == pytest.approx([5.885e-5, 2.36e-6], rel=2e-3)
    assert {bound.cause for bound in bounds} == {"the motor's slope"}
    assert str(bounds[1]) == (
        "2.36e-06 s, where RK4 is stable with the motor's slope (eigenvalue -1.18e+06 1/s)"
    )


def test_growth_beyond_measure_leaves_nan_behind():
    model = assemble(PAPER)
    rows = March.of(model)(np.concatenate([[0.0], model.state]), 3e-4, 4000)
    broken = np.isnan(rows[:, 1])
    assert broken[-1]
    assert not broken[:2].any()
    assert np.all(np.diff(broken.astype(int)) >= 0)
