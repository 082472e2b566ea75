"""Windows: where samples lie, that they are those of a plain run, and what is refused."""

from __future__ import annotations

import math

import numpy as np
import pytest

import jointplay as jp
from jointplay.analysis.simulate import sample_times
from jointplay.display.errors import InputError
from tests.support.wrong import problems_of

WORDS = ["angle", "journal_x", "normal_force", "mode", "drive_work"]
WINDOWS = [[0.25, 0.75], [2, 3.5]]


@pytest.fixture(scope="module")
def linkage():
    return jp.catalog.chunmei2002(clearance=2.9e-4, gear_ratio=3.0)


@pytest.fixture(scope="module")
def cut(linkage):
    return jp.simulate(linkage, windows=WINDOWS, samples_per_turn=100, record=WORDS)


def test_samples_are_evenly_spaced_in_each_window(cut):
    period, window = float(cut.turn_period_nominal), cut.window.values
    assert window.dtype == np.int8
    assert list(np.bincount(window)) == [51, 151]
    for number, (first, last) in enumerate(WINDOWS):
        times = cut.time.values[window == number]
        assert (times[0], times[-1]) == (first * period, last * period)
        np.testing.assert_allclose(np.diff(times), period / 100, rtol=1e-9)


def test_samples_are_those_of_a_plain_run_bit_for_bit(linkage, cut):
    plain = jp.simulate(linkage, turns=3.5, at=cut.time.values, record=WORDS)
    for word in ("time", *WORDS):
        np.testing.assert_array_equal(cut[word].values, plain[word].values)
    whole = jp.simulate(linkage, turns=5, at=cut.time.values, record=WORDS)  # where it ends changes steps
    longer = jp.simulate(linkage, turns=5, windows=WINDOWS, samples_per_turn=100, record=WORDS)
    np.testing.assert_array_equal(longer.journal_x.values, whole.journal_x.values)


def test_events_are_listed_in_windows_only(linkage, cut):
    period = float(cut.turn_period_nominal)
    plain = jp.simulate(linkage, turns=3.5, record=WORDS)
    turns = plain.event_time.values / period
    inside = np.any([(a <= turns) & (turns <= b) for a, b in WINDOWS], axis=0)
    assert 0 < inside.sum() < inside.size
    for word in ("event_time", "event_kind", "event_normal_velocity"):
        np.testing.assert_array_equal(cut[word].values, plain[word].values[inside])
    assert int(cut.n_events) == int(plain.n_events)


def test_a_run_that_stops_early_has_the_samples_that_it_reached(linkage):
    short = jp.simulate(linkage, windows=WINDOWS, record=WORDS, max_steps=200)
    assert int(short.status) == 2
    assert short.sizes["time"] == short.window.size
    assert 0 < short.sizes["time"] < 361 + 1081


def test_a_test_system_counts_forcing_periods():
    found = jp.simulate(jp.catalog.duffing(), windows=[(1, 2)], samples_per_turn=4)
    np.testing.assert_allclose(found.time.values, math.tau * np.array([1, 1.25, 1.5, 1.75, 2]))


@pytest.mark.parametrize(("first", "last", "count"), [(0, 0.3, 2), (0, 0.01, 1), (0, 1, 5), (7.1, 7.9, 4)])
def test_there_are_at_least_as_many_samples_as_asked_for(first, last, count):
    times, number = sample_times([(first, last)], 2.0, 5)
    assert (times.size, times[0], times[-1]) == (count + 1, 2.0 * first, 2.0 * last)
    assert not number.any()


@pytest.mark.parametrize(
    "windows",
    [
        [],
        3,
        "01",
        [0, 1],
        [[0, 1, 2]],
        [[1, 0]],
        [[0, 0]],
        [[0, 1], [1, 2]],
        [[2, 3], [0, 1]],
        [[-1, 1]],
        [[0, math.inf]],
        [[0, math.nan]],
        [[0, True]],
        [["0", 1]],
        [[2 * i, 2 * i + 1] for i in range(101)],
    ],
)
def test_windows_that_make_no_sense_are_refused(linkage, windows):
    with pytest.raises(InputError) as caught:
        jp.simulate(linkage, windows=windows)
    assert {problem.key.partition("[")[0] for problem in caught.value.problems} == {"windows"}
    assert all("pairs of turns" in problem.expected for problem in caught.value.problems)


@pytest.mark.parametrize(
    "beside",
    [
        {"transient": 2},
        {"duration": 1.0},
        {"at": [0.1]},
        {"steps": True},
        {"section": jp.CrankAngle()},
        {"turns": 3},
        {"transient": 1, "steps": True, "turns": 1},
    ],
)
def test_what_contradicts_windows_is_refused_by_its_name(linkage, beside):
    assert problems_of(jp.simulate, linkage, windows=WINDOWS, **beside).keys() == set(beside)


def test_what_leaves_windows_alone_is_accepted(linkage):
    jp.simulate(linkage, windows=[[0, 0.01]], transient=0, steps=False, turns=1, record=["angle"])
