"""Shares, means, Sobol' shares and edges of functions whose answers are known."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
from scipy import stats

from jointplay.analysis.tolerances import estimates
from jointplay.analysis.tolerances import estimates as edges
from jointplay.analysis.tolerances.outcomes import NO, UNDECIDED, YES
from jointplay.analysis.tolerances.spreads import Design, Spread

WINDOW = np.array([110.361e-6, 111.123e-6])  # clearances between which the slider-crank loses contact
CLEARANCE = stats.norm(109e-6, 1e-6)
REPEATS = 200


def design(**given):
    return Design({"clearance": Spread(normal=(109e-6, 1e-6))}, **given)


def lost(clearance):
    return ((clearance > WINDOW[0]) & (clearance < WINDOW[1])).astype(int)


def looked(one, scores):
    return lost(one.values(scores)[:, 0])


def sampled(one, count):
    scores = one.scores(one.drawn(count)[:, : len(one.factors)])
    return scores, one.values(scores)


def coverage(intervals, truth):
    return np.mean([low <= truth <= high for _, low, high in intervals])


@pytest.mark.long
@pytest.mark.parametrize(("sequence", "count"), [("random", 256), ("sobol", 2048)])
def test_intervals_contain_the_share_as_often_as_they_say(sequence, count):
    truth, every = np.diff(CLEARANCE.cdf(WINDOW))[0], []
    for seed in range(REPEATS):
        _, values = sampled(design(sequence=sequence, seed=seed), count)
        every.append(estimates.share(lost(values[:, 0]), sequence == "sobol"))
    assert 0.93 <= coverage(every, truth) <= 0.97


@pytest.mark.nightly
def test_intervals_by_the_edge_contain_it_as_often_with_a_tenth_of_the_runs(monkeypatch):
    monkeypatch.setattr(edges, "POPULATION", 2**13)
    truth, every, runs = np.diff(CLEARANCE.cdf(WINDOW))[0], [], 64
    first = design()
    status, found, count = edges.located(partial(looked, first), 1, 0)
    assert status == edges.LOCATED
    assert first.values(found.places[:, None])[:, 0] == pytest.approx(WINDOW, abs=edges.RESOLUTION * 1e-6)
    for seed in range(REPEATS):
        one = design(seed=seed)
        scores, values = sampled(one, 64)
        look = partial(looked, one)
        every.append(edges.by_edges(found, one, scores, lost(values[:, 0]), look, runs).share)
    assert 0.93 <= coverage(every, truth) <= 0.97
    half = np.mean([high - low for _, low, high in every]) / 2
    crude = truth * (1 - truth) * (stats.norm.ppf(0.975) / half) ** 2
    assert 64 + count + runs < crude / 10


def test_the_exceptions_that_samples_can_have_missed():
    """None of 100: below 1 - 0.05^(1/100), with 95 %."""
    assert estimates.most_exceptions(0, 100) == pytest.approx(1 - 0.05**0.01, rel=1e-12)


def test_an_edge_over_two_numbers_that_bends():
    one = Design({"a": Spread(normal=(0, 1)), "b": Spread(normal=(0, 1))})

    def look(z):
        return (z[:, 0] > 1 + 0.3 * z[:, 1] + 0.1 * z[:, 1] ** 2).astype(int)

    status, found, _ = edges.located(look, 2, 0)
    assert status == edges.LOCATED
    assert found.slopes[0] == pytest.approx([0, 0.3], abs=0.02)
    assert found.bends[0] == pytest.approx([0, 0.1], abs=0.02)
    scores, _ = sampled(one, 128)
    by = edges.by_edges(found, one, scores, look(scores), look, 100)
    truth = np.mean(look(np.random.default_rng(0).normal(size=(10**6, 2))))
    assert by.share[1] <= truth <= by.share[2]
    assert by.share[2] - by.share[1] < 0.03


def test_no_edge_and_edges_that_samples_contradict():
    def ring(z):
        return (np.hypot(z[:, 0], z[:, 1]) < 1).astype(int)  # along the first number two edges, which meet

    assert edges.located(lambda z: np.zeros(len(z), dtype=int), 1, 0)[0] == edges.NO_EDGE
    assert edges.located(lambda z: np.where(z[:, 0] > 3, UNDECIDED, NO), 1, 0)[0] == edges.OPEN
    assert edges.located(ring, 2, 0)[0] == edges.UNCLEAR
    one = Design({"a": Spread(normal=(0, 1)), "b": Spread(normal=(0, 1))})
    line = edges.located(lambda z: (z[:, 0] > 1).astype(int), 2, 0)[1]
    scores, _ = sampled(one, 64)
    dice = np.random.default_rng(1).integers(2, size=64)
    assert edges.by_edges(line, one, scores, dice, ring, 10) is None


def test_what_is_undecided_beyond_the_band_widens_the_interval_by_the_edge():
    one = design()
    _, found, _ = edges.located(partial(looked, one), 1, 0)
    scores, values = sampled(one, 128)
    outcome = lost(values[:, 0])
    outcome[:8] = np.where(found.distance(scores[:8]) > 0.5, UNDECIDED, outcome[:8])
    count = np.sum(outcome == UNDECIDED)
    assert count > 3
    sure, less = (
        edges.by_edges(found, one, scores, each, partial(looked, one), 64).share
        for each in (lost(values[:, 0]), outcome)
    )
    assert less[2] - sure[2] == pytest.approx(count / 128)
    assert less[0] == sure[0]


def test_undecided_samples_widen_the_interval_and_count_in_no_share():
    outcome = np.array([YES] * 20 + [NO] * 60 + [UNDECIDED] * 20)
    value, low, high = estimates.share(outcome, replicated=False)
    assert value == 0.25
    assert low == estimates.share(np.array([YES] * 20 + [NO] * 80), replicated=False)[1]
    assert high == estimates.share(np.array([YES] * 40 + [NO] * 60), replicated=False)[2]


def ishigami(u):
    x = 2 * np.pi * u - np.pi
    return np.sin(x[:, 0]) + 7 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])


def sobol_g(u):
    return np.prod((np.abs(4 * u - 2) + (a := np.array([0.0, 1.0, 4.5]))) / (1 + a), axis=1)


def parts(function, count):
    one = Design({key: Spread(uniform=(0, 1)) for key in "abc"})
    first, second = np.split(one.drawn(count), 2, axis=1)
    mixed = [np.where(np.arange(3) == i, second, first) for i in range(3)]
    return function(first), function(second), np.stack([function(each) for each in mixed])


def g_shares():
    own = 1 / (3 * (1 + np.array([0.0, 1.0, 4.5])) ** 2)
    whole = np.prod(1 + own) - 1
    return own / whole, [own[i] * np.prod(np.delete(1 + own, i)) / whole for i in range(3)]


@pytest.mark.parametrize(
    ("function", "first", "total"),
    [(ishigami, [0.3139, 0.4424, 0.0], [0.5576, 0.4424, 0.2437]), (sobol_g, *g_shares())],
)
def test_sobol_shares_lie_in_their_intervals(function, first, total):
    """Ishigami's with a = 7, b = 0.1, and those of Sobol's G function (closed forms)."""
    found = estimates.sobol(*parts(function, 2048), seed=0)
    for (value, low, high), truth in zip(found, (first, total), strict=True):
        assert np.all((low <= truth) & (truth <= high))
        assert value == pytest.approx(truth, abs=0.02)


def test_sobol_shares_are_those_of_scipy():
    f_a, f_b, f_ab = parts(ishigami, 1024)
    found = estimates.sobol(f_a, f_b, f_ab, seed=0)[:, 0]
    given = {"f_A": f_a[None], "f_B": f_b[None], "f_AB": f_ab[:, None]}
    theirs = stats.sobol_indices(func=given, n=1024)
    assert found[0] == pytest.approx(theirs.first_order, rel=1e-9)
    assert found[1] == pytest.approx(theirs.total_order, rel=1e-9)


def test_rows_that_are_not_known_are_left_out_of_sobol_shares():
    f_a, f_b, f_ab = parts(ishigami, 512)
    holed = f_ab.copy()
    holed[1, 7] = np.nan
    kept = np.delete(np.arange(512), 7)
    assert np.array_equal(
        estimates.sobol(f_a, f_b, holed, 0), estimates.sobol(f_a[kept], f_b[kept], f_ab[:, kept], 0)
    )
    assert np.isnan(estimates.sobol(np.ones(8), np.ones(8), np.ones((3, 8)), 0)).all()


def test_narrowed_shares_are_those_of_narrower_samples():
    one = Design({"clearance": Spread(normal=(109e-6, 1e-6))}, sequence="random")
    _, values = sampled(one, 20_000)
    ratio = one.laws[0].narrowed(values[:, 0], 0.5)
    value, low, high = estimates.weighed((values[:, 0] > WINDOW[0]).astype(int), ratio)
    truth = stats.norm(109e-6, 0.5e-6).sf(WINDOW[0])
    assert low <= truth <= high
    assert value == pytest.approx(truth, rel=0.1)
    assert np.isnan(estimates.weighed(np.ones(20, dtype=int), np.ones(20))).all()


def test_the_cheapest_set():
    """Within limits where |a| + |b| stays small: narrowing both is needed, or the first alone at less."""
    rng = np.random.default_rng(2)
    x = rng.normal(size=(20_000, 2)) * [2.0, 1.0]
    laws = [Design({"a": Spread(normal=(0, s))}).laws[0] for s in (2.0, 1.0)]
    ratios = np.stack([law.narrowed(x[:, i], 0.5) for i, law in enumerate(laws)], axis=1)
    inside = (np.abs(x[:, 0] + x[:, 1]) < 3).astype(int)

    def share(a, b):
        return 2 * stats.norm.cdf(3 / np.hypot(a, b)) - 1

    assert share(2, 0.5) < 0.9 < share(1, 1) < 0.98 < share(1, 0.5)
    chosen, found = estimates.cheapest(inside, ratios, [5.0, 1.0], 0.9)
    assert (chosen.tolist(), found[0]) == ([True, False], pytest.approx(share(1, 1), abs=0.01))
    assert estimates.cheapest(inside, ratios, [5.0, 1.0], 0.98)[0].tolist() == [True, True]
    assert estimates.cheapest(inside, ratios, [5.0, 1.0], 0.1)[0].tolist() == [False, False]
    chosen, found = estimates.cheapest(inside, ratios, [np.nan, 1.0], 0.9)
    assert not chosen.any()
    assert np.isnan(found).all()


def test_quantiles_and_means_of_known_values():
    values = np.r_[np.arange(1.0, 101.0), np.nan]
    assert estimates.quantile(values, 0.5) == (50.5, 40.0, 61.0)
    assert np.isnan(estimates.quantile(values[:3], 0.99)[2])
    value, low, high = estimates.mean(values, replicated=False)
    half = stats.t.ppf(0.975, 99) * np.std(values[:-1], ddof=1) / 10
    assert (value, low, high) == pytest.approx((50.5, 50.5 - half, 50.5 + half))
