"""The paper's scheme: what its passes converge to, and where they do not."""

from __future__ import annotations

import numpy as np
import pytest

import jointplay as jp
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.parts.joints import Friction
from jointplay_lab.paper.fixed_steps import March
from jointplay_lab.paper.reading_list import coarse_section
from jointplay_lab.scheme.scheme import Scheme
from jointplay_lab.scheme.scheme_comparison import Case, Truth
from tests.support.linkages import jointed

IDEAL = jp.catalog.chunmei2002(gear_ratio=3.0, clearance=0, elastic=("coupler",), elements=2, order="paper")
LOOSE = jp.catalog.chunmei2002(gear_ratio=3.0, elastic=("coupler",), elements=2, order="paper")
RIGID = jp.catalog.chunmei2002(gear_ratio=3.0)


def error(mechanism, found, quantity="deflection"):
    """Largest error against all unknowns at once, relative to the quantity's largest value."""
    times = found.time.values
    truth = jp.simulate(mechanism, duration=times[-1], at=times, rtol=1e-12, record=[quantity])[quantity]
    return float(np.abs(found[quantity].values - truth.values).max() / np.abs(truth).max())


@pytest.fixture(scope="module")
def ideal():
    """Two turns of the ideal mechanism, at two steps."""
    return [jp.waveform(IDEAL, turns=2, step=step, passes=40, tolerance=1e-10) for step in (1e-5, 5e-6)]


@pytest.mark.long
def test_with_ideal_joints_whole_turns_converge_to_the_monolithic_answer(ideal):
    coarse, fine = (error(IDEAL, each) for each in ideal)
    assert fine < 1e-4
    assert np.log2(coarse / fine) == pytest.approx(2.0, abs=0.2)


@pytest.mark.parametrize("quantity", ["angle", "angular_velocity", "reaction"])
def test_every_quantity_is_that_of_the_last_pass(ideal, quantity):
    assert error(IDEAL, ideal[1], quantity) < 1e-4


def test_what_is_told_of_the_passes(ideal):
    found = ideal[0]
    assert found.status == 0
    assert found.converged.values.tolist() == [1, 1]
    assert np.all(found.last_change <= 1e-10)
    for turn in range(2):
        done = int(found.passes[turn])
        change = found.change.values[turn]
        assert 5 < done < 40
        assert np.isnan(change[0])
        assert change[done - 2] > 1e-10 >= change[done - 1]
        assert np.all(change[done - 1 :] == found.last_change[turn].item())
    assert found.change[1, 1] < found.change[0, 1]  # the second turn starts from the first's end, not anew


def test_one_turn_whose_passes_do_not_agree_shows_in_the_status(ideal):
    before = ideal[0].change.values[:, 3]  # the second turn starts closer to its answer
    between = float(np.sqrt(before.prod()))
    told = []
    found = jp.waveform(IDEAL, turns=2, step=1e-5, passes=4, tolerance=between, progress=told.append)
    assert [share for share in told if 0 < share < 1] == [0.5]  # once a turn
    assert found.converged.values.tolist() == [0, 1]
    assert found.status == 4


@pytest.mark.long
def test_the_first_pass_is_the_rigid_motion():
    found = jp.waveform(LOOSE, step=2e-5, passes=1)
    model = assemble(RIGID)
    h = float(found.step)
    rows = March.of(model)(np.concatenate([[0.0], model.state]), h, round(model.period / h))
    every = (len(rows) - 1) // (found.sizes["time"] - 1)
    assert found.angular_velocity.values == pytest.approx(rows[::every, 4:7], rel=1e-9, abs=1e-9)
    assert found.status == 4  # one pass agrees with nothing
    assert found.deflection.sel(link="coupler").max() > 1e-6
    assert np.all(found.deflection.sel(link="crank") == 0)


def test_with_clearance_whole_turns_diverge():
    found = jp.waveform(LOOSE, step=1e-5, passes=30)
    assert found.status == 1
    assert found.converged.values.tolist() == [0]
    change = found.change.values[0]
    grown = change[np.isfinite(change)]
    assert np.all(np.diff(np.log10(grown[:5])) > 0.5)
    assert np.isinf(change[-1])
    assert found.sizes["time"] == 0


@pytest.mark.nightly
def test_with_clearance_short_windows_converge():
    for step, most in ((1e-5, 0.04), (2e-6, 0.01)):
        found = jp.waveform(LOOSE, step=step, passes=40, tolerance=2e-4, windows_per_turn=144)
        assert found.mean_passes < 12
        assert np.diff(found.time) == pytest.approx(found.turn_period_nominal.item() / 720, rel=1e-9)
        assert error(LOOSE, found) < most


def rubbing(**friction):
    """The mechanism with other friction at joint B."""
    return jointed(LOOSE, friction=Friction(**friction))


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("mechanism", "angle", "turn", "duration"),
    [
        (LOOSE, 0.0, 0, 4.9e-4),
        (rubbing(coefficient=0.3), 1.0, 2, 3e-4),
        (rubbing(law="tanh", velocity=0.5, coefficient=0.3), 1.0, 2, 3e-4),
    ],
    ids=["flight", "contact", "friction that follows the speed"],
)
def test_where_nothing_switches_it_is_of_second_order(mechanism, angle, turn, duration):
    """Friction bends the coupler by its moment, and the coupler's end slope turns the journal."""
    case = Case.of(mechanism, 2.9e-5, turn, 1e-12, {"crank_angle": angle})
    times = np.linspace(0.0, duration, 21)
    records = case.follow(times, 1e-13)
    assert records.counts["n_events"] == 0
    truth = Truth.of(case.monolithic, records.samples)
    errors = []
    for count in (100, 200, 400):
        scheme = Scheme(case.relaxed, duration / count)
        *_, last = scheme.relax(case.start(scheme), count, 1, 60, 1e-10)
        errors.append(truth.deflection_error(last.done.deflection[:: count // 20]))
    assert errors[-1] < 1e-5
    assert np.diff(np.log2(errors)) == pytest.approx([-2.0, -2.0], abs=0.2)


def test_steps_are_at_most_what_is_asked_for_and_fit_the_windows():
    for windows in (1, 7):
        found = jp.waveform(IDEAL, step=2.3e-5, passes=1, windows_per_turn=windows)
        count = found.turn_period_nominal.item() / windows / float(found.step)
        assert count == pytest.approx(round(count), abs=1e-6)
        assert 1.5e-5 < found.step <= 2.3e-5
    assert 2e-5 < jp.waveform(IDEAL, passes=1).step < 0.5 * 5.95e-5


def test_a_step_too_large_is_refused_with_the_bound():
    stiff = LOOSE.replace(gear_ratio=15.0)
    with pytest.raises(jp.InputError) as caught:
        jp.waveform(stiff, step=1e-5)
    (problem,) = caught.value.problems
    assert (problem.key, problem.given) == ("step", 1e-5)
    assert "at most 2.36e-06 s" in problem.expected
    assert "the motor's slope (eigenvalue -1.18e+06 1/s)" in problem.expected


def test_everything_wrong_is_told_at_once():
    with pytest.raises(jp.InputError) as caught:
        jp.waveform(RIGID, turns=0, step=-1.0, passes=2.5, tolerance=0.0, windows_per_turn=True)
    keys = {problem.key for problem in caught.value.problems}
    assert keys == {"mechanism.elastic", "turns", "step", "passes", "tolerance", "windows_per_turn"}


def test_coarse_section_points():
    found = coarse_section(RIGID, 2e-5, turns=30, transient=30)
    turns = found["angle"][:, 0] / (2 * np.pi)
    assert turns == pytest.approx(np.arange(31, 61), abs=1e-12)
    truth = jp.poincare(RIGID, turns=30, transient=30)
    assert np.abs(found["journal_x"] - truth.journal_x.values).max() < 0.02 * 2.9e-5
    events = jp.simulate(RIGID, turns=30, transient=31)
    assert found["separations"].sum() == pytest.approx(float((events.event_kind == 1).sum()), abs=1)
    assert np.all(np.diff(found["time"]) == pytest.approx(0.075, rel=1e-3))


def test_coarse_section_of_a_forced_system():
    found = coarse_section(jp.catalog.duffing(), 1e-3, turns=5)
    truth = jp.poincare(jp.catalog.duffing(), turns=5)
    assert found["state"] == pytest.approx(truth.state_value.values, abs=1e-8)


def test_coarse_steps_are_bounded_and_jumps_refused():
    with pytest.raises(jp.InputError, match=r"step: got 0\.0001; at most 5\.89e-05 s"):
        coarse_section(RIGID, 1e-4, turns=1)
    with pytest.raises(jp.InputError, match="mechanism"):
        coarse_section(jp.catalog.impact_pair(gap=1.0, restitution=0.8), 1e-3, turns=1)
