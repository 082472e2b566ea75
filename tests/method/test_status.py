"""A status for every way to fail, in bounded time, with what was computed kept."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
import pytest

import jointplay as jp
from jointplay.solver.codegen import cache
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.method.codes import Status
from jointplay.solver.motion.trajectory import Request, follow, functions
from jointplay.solver.motion.trajectory import memory as run_memory
from tests.support.linkages import jointed

OK, DIVERGED, STEP_LIMIT, CHATTER, NOT_CONVERGED = list(Status)[:5]
PATIENCE = 20.0  # s, compilation included


@pytest.fixture(autouse=True)
def _soon():
    began = time.monotonic()
    yield
    assert time.monotonic() - began < 3 * PATIENCE


def run(mechanism, **keywords):
    """A run after its compilation, with its wall time."""
    keywords = {"rtol": 1e-8, "max_steps": 200_000} | keywords
    found = jp.simulate(mechanism, **keywords)
    assert float(found.wall_time) < PATIENCE
    return found


def stiff(stiffness, damping=228.0):
    """The paper's mechanism with another contact."""
    plain = jp.catalog.chunmei2002(gear_ratio=3.0)
    contact = jp.Contact(stiffness=stiffness, damping=damping)
    return jointed(plain, contact=contact)


def test_step_limit_keeps_what_was_computed():
    found = run(jp.catalog.lorenz(), duration=10.0, max_steps=50)
    assert found.status == STEP_LIMIT
    assert found.n_steps + found.n_rejected + found.n_failed == 50
    assert 1 < len(found.time) < 7200
    assert np.all(np.isfinite(found.state_value))


def test_attempts_without_an_answer_are_counted():
    """A stiff contact's first guesses are often too far off for Newton's method."""
    found = run(stiff(1e10), turns=0.2)
    assert found.n_failed > 0


@pytest.mark.parametrize(("acceleration", "restitution"), [(0.8, 0.5), (0.5, 0.3), (1.03, 0.2)])
def test_a_ball_that_comes_to_rest_is_no_trouble(acceleration, restitution):
    ball = jp.catalog.bouncing_ball(acceleration=acceleration, restitution=restitution)
    found = run(ball, turns=60, initial=(1.0, 0.0))
    assert found.status == OK
    assert 5 < found.n_events < 1000


def test_a_wall_that_swallows_all_speed_is_no_trouble():
    found = run(jp.catalog.impact_pair(gap=0.5, restitution=0.0), turns=20, initial=(0.0, 0.5))
    assert found.status == OK


def test_events_that_crowd_without_an_end_chatter():
    """Within 1e-7 of a period that is no period of the system."""
    pair = jp.catalog.impact_pair(gap=1.0, restitution=1.0)
    found = run(pair.model_copy(update={"forcing": "1e9"}), duration=100.0, initial=(0.0, 1.0))
    assert found.status == CHATTER


@pytest.mark.parametrize(("a", "state"), [(5.0, (1.0, 1.0, 0.0)), (0.2, (1e200, -1e200, 1e200))])
def test_a_motion_without_bound_diverges(a, state):
    found = run(jp.catalog.rossler(a=a, b=0.2, c=5.7), duration=1e5, samples_per_turn=1, initial=state)
    assert found.status == DIVERGED


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("stiffness", "turns", "attempts"),
    [(1e10, 1.0, 20_000), (1e14, 0.25, 20_000), (1e20, 1.0, 3_000), (1e50, 1.0, 20_000)],
)
def test_absurd_stiffness_ends(stiffness, turns, attempts):
    """A few doubtful steps are followed again in each; thousands of them would say no more in minutes."""
    found = run(stiff(stiffness), turns=turns, max_steps=attempts)
    assert found.status in (OK, STEP_LIMIT, CHATTER, NOT_CONVERGED)
    assert np.all(np.isfinite(found.angle))


def test_stiffness_that_no_mechanism_may_have_ends():
    """The method does not lean on what is refused before it."""
    with pytest.raises(jp.InputError, match=r"joints\[0\].contact.stiffness: got 1e300"):
        stiff(1e300)
    model = assemble(stiff(1e50))
    numbers = model.numbers.copy()
    numbers[cache.structure_module(model.structure).PARAMETERS.index("K_B")] *= 1e250
    assert np.max(numbers) > 1e299
    asked = Request(model.period, 1e-8, at=np.linspace(0.0, model.period, 100), max_steps=20_000)
    found = follow(replace(model, numbers=numbers), asked)
    assert found.status in (OK, STEP_LIMIT, CHATTER, NOT_CONVERGED)
    assert np.all(np.isfinite(found.samples))


@pytest.mark.parametrize("speed", [1e3, 1e6, 1e12, 1e200])
def test_absurd_speeds_end(speed):
    loose = jp.catalog.chunmei2002(gear_ratio=3.0)
    found = run(loose, duration=0.01, initial={"crank_angle": 0.3, "crank_speed": speed}, max_steps=20_000)
    assert found.status in range(5)
    assert (found.status == OK) <= bool(np.all(np.isfinite(found.angle)))


@pytest.mark.parametrize("rtol", [1e-14, 1e-8])
def test_a_motion_faster_than_the_clock_does_not_converge(rtol):
    """Its period, 1e-10 of the forcing's, is shorter than the shortest first step that is tried."""
    found = run(jp.catalog.duffing(), turns=1, rtol=rtol, initial=(1e10, 0.0))
    assert found.status == NOT_CONVERGED
    assert len(found.time) == 0


@pytest.mark.parametrize("gap", [1e-12, 1e-6, 1e-3])
def test_a_narrow_gap_ends(gap):
    pair = jp.catalog.impact_pair(gap=gap, restitution=0.8)
    found = run(pair, turns=2, initial=(0.0, 1.0), max_steps=50_000)
    assert found.status in (OK, CHATTER, STEP_LIMIT)


@pytest.mark.parametrize("start", [(1.8, 0.0), (1.8, 1.0), (-1.8, -1.0), (1.8, -1.0)])
def test_a_start_on_a_wall(start):
    for pair in (
        jp.catalog.impact_pair(3.6, 0.8),
        jp.catalog.soft_impact_pair(3.6, 400.0, 2.0, tension=False),
    ):
        found = run(pair, turns=3, initial=start)
        assert found.status in (OK, CHATTER)
        assert float(np.abs(found.state_value.sel(state="y")).max()) < 1.8 + 0.2


def test_a_run_ends_at_its_end():
    """A sum of step lengths may miss it by rounding: that is no step too short to take."""
    model, random = assemble(jp.catalog.impact_pair(3.0, 0.8)), np.random.default_rng(1)
    for begin, span in zip(random.uniform(0.0, 0.01, 300), random.uniform(0.1, 0.3, 300), strict=True):
        end = begin + span
        work, motion, options = run_memory(model, Request(end, 1e-6, at=np.array([end])))
        motion.s[0] = begin
        code = cache.method("flow").flow(functions(model.structure), work, motion, options, None, None)
        assert (code, motion.s[0], motion.samples[0, 0]) == (OK, end, end)
