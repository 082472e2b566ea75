"""Error bars of exponents, and what says whether to trust them: on records whose statistics are known."""

import math

import numpy as np
import pytest

import jointplay as jp
from jointplay import catalog
from jointplay.analysis.exponents import batch_means
from jointplay.analysis.exponents.frame_growth import Stretch, grown
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.motion.trajectory import Request

LOGS = slice(4, 6)


def record(memory, blocks=400, seed=0, rates=(0.3, -1.2), h=2.0):
    """Rows of two vectors whose growth in a block is their rate plus noise, correlated by `memory`, in s."""
    random = np.random.default_rng(seed)
    noise = random.standard_normal((blocks, 2))
    for i in range(1, blocks):
        noise[i] = memory * noise[i - 1] + math.sqrt(1 - memory**2) * noise[i]
    rows = np.zeros((blocks + 1, 6))
    rows[:, 0] = 5.0 + h * np.arange(blocks + 1)
    rows[1:, LOGS] = np.cumsum(h * (np.array(rates) + 0.1 * noise), axis=0)
    return rows


def repeated(of, memory, count=60):
    return np.array([of(record(memory, seed=seed), LOGS) for seed in range(count)])


def test_means():
    rows = record(0.0)
    found = batch_means.growth(rows, LOGS)
    assert found == pytest.approx(rows[-1, LOGS] / 800.0)
    assert found == pytest.approx([0.3, -1.2], abs=0.02)


@pytest.mark.parametrize(("memory", "tolerance"), [(0.0, 0.1), (0.5, 0.15)])
def test_the_error_is_that_of_repeated_records(memory, tolerance):
    """A mean of 400 correlated blocks: sqrt((1 + a)/(1 - a)/400) times their scatter."""
    expected = 0.1 * math.sqrt((1 + memory) / (1 - memory) / 400)
    assert repeated(batch_means.standard_error, memory).mean() == pytest.approx(expected, rel=tolerance)
    assert np.std(repeated(batch_means.growth, memory), axis=0).mean() == pytest.approx(expected, rel=0.2)


def test_a_long_memory_shows():
    """Batches of ten blocks are too short for a memory of fifty: the error is too small."""
    independent, long = (repeated(batch_means.batch_correlation, memory) for memory in (0.0, 0.98))
    assert abs(independent.mean()) < 0.06
    assert np.mean(np.abs(independent) < 2 / math.sqrt(batch_means.BATCHES)) > 0.9
    assert np.mean(long > 2 / math.sqrt(batch_means.BATCHES)) > 0.9
    true = np.std(repeated(batch_means.growth, 0.98), axis=0).mean()
    assert repeated(batch_means.standard_error, 0.98).mean() < 0.6 * true


@pytest.mark.parametrize(("memory", "blocks"), [(0.0, 400), (0.5, 400 / 3)])
def test_effective_number_of_blocks(memory, blocks):
    assert np.median(repeated(batch_means.effective_number, memory)) == pytest.approx(blocks, rel=0.3)


def test_it_settles_only_if_batches_do_not_follow_one_another():
    assert batch_means.settled(record(0.0), LOGS, 0.006)
    assert not batch_means.settled(record(0.0), LOGS, 0.004)
    assert not batch_means.settled(record(0.98), LOGS, 1.0)
    assert not batch_means.settled(record(0.0, 1), LOGS, 1.0)


def test_a_dimension_lost():
    """From the block on in which a vector vanishes, it is minus infinity; its error is unknown."""
    rows = record(0.0)
    rows[200:, 5] = -np.inf
    found = batch_means.values(rows, LOGS, 1.0, 2)
    assert found["lyapunov_exponent"][1] == -np.inf
    assert math.isnan(found["lyapunov_standard_error"][1])
    assert found["lyapunov_standard_error"][0] > 0
    trace = found["lyapunov_trace"]
    assert np.all(np.isfinite(trace[:198, 1]))
    assert np.all(trace[200:, 1] == -np.inf)
    assert math.isnan(found["sum_residual"]) or np.isinf(found["sum_residual"])


def test_trace():
    """Row by row what the record up to there gives; the largest exponent first."""
    rows = record(0.3, rates=(-1.0, 0.5))
    found = batch_means.values(rows, LOGS, 3.0, 2)
    assert found["lyapunov_exponent"][0] > found["lyapunov_exponent"][1]
    for block in (0, 57, 399):
        part = rows[: block + 2]
        assert found["lyapunov_trace"][block] == pytest.approx(batch_means.growth(part, LOGS)[::-1])
        assert found["lyapunov_trace_error"][block] == pytest.approx(
            batch_means.standard_error(part, LOGS)[::-1], nan_ok=True
        )
    assert found["lyapunov_trace_error"][-1] == pytest.approx(found["lyapunov_standard_error"])
    assert found["lyapunov_exponent_per_turn"] == pytest.approx(3 * found["lyapunov_exponent"])


def test_a_dimension_lost_before_the_record():
    rows = record(0.0)
    rows[:, 5] = -np.inf
    assert batch_means.growth(rows, LOGS)[1] == -np.inf
    assert math.isnan(batch_means.standard_error(rows, LOGS)[1])


@pytest.mark.parametrize("count", [0, 1, 2])
def test_records_too_short(count):
    rows = record(0.0)[:count]
    for name in ("growth", "standard_error", "batch_correlation", "effective_number"):
        found = getattr(batch_means, name)(rows, LOGS)
        assert found.shape == (2,)
        assert (name == "growth" and count == 2) or np.all(np.isnan(found))


@pytest.mark.parametrize("blocks", [2, 3])
def test_the_blocks_of_the_shortest_records_count_as_independent(blocks):
    found = batch_means.effective_number(record(0.0)[: blocks + 1], LOGS)
    assert found == pytest.approx([blocks, blocks])


def test_a_cell_is_what_the_function_gives():
    system = catalog.duffing()
    model = assemble(system)
    run = grown(model, Stretch(Request(60 * model.period, 1e-8), 2, 10 * model.period))
    cell = run.leading(2)
    found = jp.lyapunov(system, exponents=2, turns=50, transient=10)
    assert run.status == 0
    for name in ("lyapunov_exponent", "lyapunov_standard_error_per_turn", "batch_correlation"):
        np.testing.assert_allclose(cell[name], found[name].values, rtol=1e-13)
    assert run.turn_period == float(found.turn_period)
    assert cell["exponent_turns"] == pytest.approx(50) == float(found.exponent_turns)


@pytest.mark.nightly
def test_error_bars_of_a_chaotic_motion():
    """Runs from many starts scatter as each says."""
    starts = np.random.default_rng(6).uniform(-1, 1, (16, 2))
    runs = [jp.lyapunov(catalog.duffing(), turns=200, transient=30, initial=tuple(each)) for each in starts]
    values, errors = (
        np.array([float(run[f"lyapunov_{name}"][0]) for run in runs])
        for name in ("exponent", "standard_error")
    )
    assert 0.5 < errors.mean() / np.std(values, ddof=1) < 2
    assert np.mean(np.abs(values - values.mean()) < 3 * errors) > 0.9


def test_nothing_turns_in_lorenz_system():
    found = jp.lyapunov(catalog.lorenz(), duration=2)
    assert not [name for name in found.data_vars if name.endswith("_turn") or name == "turn_period"]
    with pytest.raises(jp.InputError, match="twin_turns"):
        jp.lyapunov(catalog.lorenz(), duration=2, twin_turns=10)


def test_twins_that_fail_say_so():
    """The first estimate stands on its own."""
    pair, limit = catalog.impact_pair(3.6, 0.8), {"max_steps": 20}
    found = jp.lyapunov(pair, turns=0.1, initial=(0.0, 0.0), twin_turns=5, **limit)
    assert int(found.status) == 0
    assert int(found.growth_status) == 2
    assert math.isnan(float(found.growth))
    assert math.isnan(float(found.growth_difference))


def test_a_run_that_fails_has_no_second_estimate_either():
    found = jp.lyapunov(catalog.chunmei2002(2.9e-4, 3.0), exponents=2, turns=5, max_steps=20, twin_turns=3)
    assert int(found.status) == int(found.growth_status) == 2
    assert np.all(np.isnan(found.lyapunov_exponent))
    assert np.all(np.isnan(found.section_exponent))


def test_every_mistake_at_once():
    with pytest.raises(jp.InputError) as caught:
        jp.lyapunov(catalog.duffing(), exponents=9, turns=-1, error=0, twin_turns=-1, saltation="no", rtol=1)
    keys = {problem.key for problem in caught.value.problems}
    assert keys == {"exponents", "turns", "error", "twin_turns", "saltation", "rtol"}
