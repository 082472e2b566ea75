"""The comparison of the paper's scheme with the monolithic method, on cases small enough to be quick."""

from __future__ import annotations

import numpy as np
import pytest

import jointplay as jp
from jointplay_lab.scheme.scheme import Scheme
from jointplay_lab.scheme.scheme_comparison import Case

ELASTIC = jp.catalog.chunmei2002(gear_ratio=3.0, elastic=("coupler",))
SHORT = {"steps": [2.5e-5, 1e-5], "tolerances": [1e-4, 1e-7], "repeats": 1}


@pytest.fixture(scope="module")
def ideal():
    """Ideal joints, whole turns."""
    return jp.scheme_comparison(ELASTIC, clearance=0.0, start_turn=[0, 3], windows_per_turn=1, **SHORT)


@pytest.mark.long
def test_errors_fall_with_the_passes_to_that_of_the_step(ideal):
    first = ideal.isel(case=0, windows_per_turn=0)
    assert ideal.status == 0
    assert first.converged == 1
    assert first.reached == 1.0
    done = int(first.mean_passes)
    for name in ("deflection", "angle", "force"):
        errors = first[f"pass_{name}_error"].values
        assert errors[0] > 30 * errors[-1] > 0
        assert np.all(errors[done - 1 :] == errors[-1])
    assert first.contraction == pytest.approx(0.28, abs=0.1)


@pytest.mark.long
def test_errors_are_those_of_the_scheme_s_own_dataset(ideal):
    paper = ELASTIC.replace(clearance=0.0, order="paper")
    found = jp.waveform(paper, step=1e-5, passes=30, tolerance=1e-4)
    times = found.time.values
    truth = jp.simulate(paper, duration=times[-1], at=times, rtol=1e-10)
    bent, turned, pulled = (found[name] - truth[name] for name in ("deflection", "angle", "reaction"))
    expected = {
        "deflection": np.abs(bent).max() / np.abs(truth.deflection).max(),
        "angle": np.abs(turned).max(),
        "force": np.sqrt((pulled**2).mean() / (truth.reaction**2).mean()),
    }
    for name, value in expected.items():
        assert ideal[f"pass_{name}_error"].values[0, 0, -1] == pytest.approx(float(value), rel=1e-6)


@pytest.mark.nightly
def test_work_and_precision(ideal):
    errors = ideal.scheme_error.values
    assert np.all(ideal.windows_used == 1)
    assert errors[0, 1] < errors[0, 0] < 3e-3
    assert errors[0, 1] == pytest.approx(ideal.pass_deflection_error.values[0, 0, -1], rel=1e-9)
    assert np.all(ideal.monolithic_error[:, 1] < 0.1 * ideal.monolithic_error[:, 0])
    assert np.all(ideal.scheme_run_time > 0)
    assert np.all(ideal.monolithic_run_time > 0)


@pytest.mark.long
def test_a_later_turn_starts_from_the_motion_there(ideal):
    """The vibration of the start has decayed: the rigid pass alone is nearly right."""
    assert ideal.pass_deflection_error.values[1, 0, 0] < 0.2 * ideal.pass_deflection_error.values[0, 0, 0]
    assert ideal.start_turn.values.tolist() == [0, 3]
    assert ideal.case.values.tolist() == ["ideal joints, turn 1", "ideal joints, turn 4"]


@pytest.mark.long
def test_the_paper_s_inertia_terms_are_close_to_all(ideal):
    assert np.all((ideal.order_difference > 1e-7) & (ideal.order_difference < 1e-3))


@pytest.mark.nightly
def test_a_case_starts_from_the_motion_s_own_state():
    case = Case.of(ELASTIC, 2.9e-5, 2, 1e-11, None)
    mechanism = ELASTIC.replace(order="paper", clearance=2.9e-5)
    found = jp.simulate(mechanism, turns=2, rtol=1e-11).isel(time=-1)
    scheme = Scheme(case.relaxed, 1e-5)
    start = case.start(scheme)
    assert start.rigid[0] == 0.0
    assert start.rigid[1:4] == pytest.approx(found.angle.values, abs=1e-9)
    assert start.rigid[4:] == pytest.approx(found.angular_velocity.values, abs=1e-6)
    assert start.eta @ scheme.modes.gauge == pytest.approx(found.deflection.values, abs=1e-13)
    assert case.consistent.state == pytest.approx(case.monolithic.state, rel=0, abs=0)


@pytest.mark.nightly
def test_with_clearance_only_short_windows_settle():
    found = jp.scheme_comparison(
        ELASTIC, clearance=2.9e-5, start_turn=0, windows_per_turn=[1, 24, 144], passes=8, **SHORT
    ).isel(case=0)
    errors = found.pass_deflection_error.values
    assert found.reached[0] == 0.0
    assert found.reached[1] < 1.0
    assert found.reached[2] == 1.0
    assert found.converged.values.tolist() == [0, 0, 0]
    assert found.contraction[0] > 3.0
    assert found.contraction[2] < 0.8
    assert np.all(errors[0, 1:] > 3 * errors[0, :-1])
    assert np.all(np.isinf(errors[1]))  # the turn's end was not reached
    assert found.windows_used == 144
    assert errors[2, -1] == pytest.approx(found.scheme_error[-1].item(), rel=1e-9)
    assert found.scheme_error[-1] < 0.2
    assert found.status == 0


@pytest.mark.nightly
def test_where_nothing_settles_the_status_says_so():
    found = jp.scheme_comparison(
        ELASTIC, clearance=2.9e-5, start_turn=0, windows_per_turn=1, passes=30, **SHORT
    ).isel(case=0)
    assert found.status == 4
    assert np.isinf(found.pass_deflection_error.values[0, -1])
    assert np.all(np.isinf(found.scheme_error))
    assert np.all(found.monolithic_error < 1e-3)


def test_everything_wrong_is_told_at_once():
    with pytest.raises(jp.InputError) as caught:
        jp.scheme_comparison(
            ELASTIC.replace(elastic=()),
            clearance=-1.0,
            start_turn=0.5,
            windows_per_turn=[4, 1],
            steps=[1e-6, 1e-5],
            tolerances=[],
            passes=0,
            repeats=True,
            rtol=1.0,
            tolerance=-1.0,
        )
    keys = [problem.key for problem in caught.value.problems]
    names = "clearance[0] start_turn[0] windows_per_turn steps tolerances rtol passes repeats tolerance"
    assert sorted(keys) == sorted(["mechanism.elastic", *names.split()])


@pytest.mark.long
def test_a_step_too_large_for_any_case_is_refused():
    with pytest.raises(jp.InputError, match=r"steps\[0\]: got 0\.0001; at most 5\.89e-05 s"):
        jp.scheme_comparison(ELASTIC, steps=[1e-4, 1e-5])
