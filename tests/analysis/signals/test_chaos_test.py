"""The 0-1 test: maps of known character, its defining sums written out, motions through contacts."""

import math

import numpy as np
import pytest

import jointplay as jp
from jointplay import catalog
from jointplay.analysis.signals import chaos_test

C = chaos_test.drawn_frequencies(100, 0)


def logistic(r, count, x=0.3):
    """An orbit of x -> r x (1 - x), after 1000 steps."""
    found = np.empty(count)
    for i in range(-1000, count):
        x = r * x * (1 - x)
        if i >= 0:
            found[i] = x
    return found


def judged(series):
    quartiles = np.quantile(chaos_test.indicators(series, C), (0.25, 0.5, 0.75))
    return quartiles, chaos_test.VERDICTS[chaos_test.verdict(quartiles)]


@pytest.mark.parametrize(
    ("r", "known", "verdict"),
    [(3.55, 0.0, "regular"), (3.97, 1.0, "chaotic"), (3.82, 1.0, "chaotic"), (3.5, 0.0, "regular")],
)
def test_logistic_map(r, known, verdict):
    """Period 8 at 3.55, 4 at 3.5; chaos at 3.97 and, with long laminar stretches nearby, at 3.82."""
    quartiles, found = judged(logistic(r, 2000))
    assert quartiles[1] == pytest.approx(known, abs=0.02)
    assert found == verdict


def test_between_the_limits_it_does_not_decide():
    """Just beyond the accumulation of period doublings, bands are narrow and the walk is slow."""
    quartiles, found = judged(logistic(3.58, 500))
    assert 0.1 < quartiles[1] < 0.5
    assert found == "undecided"


def written_out(phi, c, longest):
    """K by the sums of Gottwald and Melbourne (2009), with the oscillation subtracted as there."""
    p, q, ps, qs = 0.0, 0.0, [], []
    for j, value in enumerate(phi, 1):
        p, q = p + value * math.cos(j * c), q + value * math.sin(j * c)
        ps.append(p)
        qs.append(q)
    kept, mean, D = len(phi) - longest, float(np.mean(phi)), []
    for n in range(1, longest + 1):
        M = sum((ps[j + n] - ps[j]) ** 2 + (qs[j + n] - qs[j]) ** 2 for j in range(kept)) / kept
        D.append(M - mean**2 * (1 - math.cos(n * c)) / (1 - math.cos(c)))
    return np.corrcoef(np.arange(1, longest + 1), D)[0, 1]


@pytest.mark.parametrize(("r", "error"), [(3.97, 0.005), (3.58, 0.1)])
def test_its_sums_written_out(r, error):
    """The mean taken off the series before, instead of its oscillation after: the same but for 1/N."""
    phi, c = logistic(r, 1000), np.array([0.9, 1.3, 2.1])
    slow = [written_out(phi, each, 100) for each in c]
    assert chaos_test.indicators(phi, c) == pytest.approx(slow, abs=error)
    centred = phi - phi.mean()
    exact = [written_out(centred, each, 100) for each in c]
    assert chaos_test.indicators(phi, c) == pytest.approx(exact, abs=1e-9)


def test_a_mean_changes_nothing():
    phi = logistic(3.58, 500)
    assert chaos_test.indicators(phi + 1e3, C) == pytest.approx(chaos_test.indicators(phi, C), abs=1e-6)


def test_noise_walks_as_brownian_motion():
    """Mean square displacement over n samples of independent noise: n times its variance."""
    noise = 3.0 * np.random.default_rng(1).standard_normal(2000)
    grown = chaos_test.displacement(chaos_test.walk(noise, C))
    lags = np.arange(1, 201)
    assert grown.mean(axis=0) == pytest.approx(9.0 * lags, rel=0.1)
    assert judged(noise)[1] == "chaotic"


def test_a_smooth_series_sampled_too_closely_looks_regular():
    """Lorenz's chaos, a hundred samples in a unit of time: the test is for section points."""
    found = jp.simulate(catalog.lorenz(), duration=20, at=np.arange(0, 20, 0.01), transient=0)
    assert judged(found.state_value.values[:, 0])[0][1] < 0.3


PAIR = {"initial": (0.05, 0.7), "transient": 200, "turns": 600}


@pytest.mark.parametrize(
    ("gap", "verdict"), [(0.4, "chaotic"), (0.6, "regular"), (1.4, "regular"), (3.6, "regular")]
)
def test_impact_pair(gap, verdict):
    found = jp.chaos_test(catalog.impact_pair(gap, 0.8), **PAIR)
    assert chaos_test.VERDICTS[int(found.verdict)] == verdict
    assert (float(found.sample_spread) > 1e-4) == (gap < 2)
    assert np.all(found.chaos_indicator == 0) == (gap == 3.6)  # one point: nothing to correlate
    low, median, high = found.chaos_indicator_quartile.values
    assert low <= median <= high
    assert float(found.chaos_indicator_half) == pytest.approx(median, abs=0.1)


@pytest.mark.parametrize(
    ("clearance", "ratio", "transient", "verdict"),
    [(2.9e-5, 15.0, 150, "regular"), (2.9e-5, 3.0, 50, "regular"), (2.9e-4, 3.0, 50, "chaotic")],
)
def test_the_linkage(clearance, ratio, transient, verdict):
    """Panels a, b and c of the paper's Figure 12."""
    mechanism = catalog.chunmei2002(clearance, ratio)
    found = jp.chaos_test(mechanism, turns=200, transient=transient)
    assert int(found.status) == 0
    assert chaos_test.VERDICTS[int(found.verdict)] == verdict
    assert found.sample.attrs["units"] == "m"
    assert found.square_displacement.attrs["units"] == "m2"


def test_what_is_stored_is_what_is_judged():
    found = jp.chaos_test(catalog.impact_pair(0.4, 0.8), quantity="v", **PAIR)
    c, K = found.test_frequency.values, found.chaos_indicator.values
    assert chaos_test.indicators(found.sample.values, c) == pytest.approx(K, abs=1e-12)
    typical = int(np.argmin(np.abs(K - np.median(K))))
    assert float(found.walk_frequency) == c[typical]
    path = np.cumsum((found.sample - found.sample.mean()) * np.exp(1j * c[typical] * np.arange(1, 601)))
    assert found.walk_x.values == pytest.approx(path.real.values, abs=1e-10)
    assert found.sizes["lag"] == 60


def test_section_points_kept():
    whole = jp.chaos_test(catalog.duffing(), turns=400, transient=20)
    some = jp.chaos_test(catalog.duffing(), turns=400, transient=20, every=4)
    assert np.array_equal(some.sample, whole.sample[::4])
    assert some.turn.values.tolist() == whole.turn.values[::4].tolist()


def test_seeds():
    values = [
        jp.chaos_test(catalog.duffing(), turns=100, seed=seed).test_frequency.values for seed in (0, 0, 1)
    ]
    assert np.array_equal(values[0], values[1])
    assert not np.array_equal(values[0], values[2])
    assert np.all((values[0] > math.pi / 5) & (values[0] < 4 * math.pi / 5))


@pytest.mark.parametrize(("keywords", "status"), [({"max_steps": 50}, 2), ({"turns": 40}, 0)])
def test_too_little_is_undecided(keywords, status):
    found = jp.chaos_test(catalog.duffing(), **{"turns": 200} | keywords)
    assert int(found.status) == status
    assert int(found.verdict) == 0
    assert np.all(np.isnan(found.chaos_indicator))


def test_every_variable_says_what_it_is():
    found = jp.chaos_test(catalog.chunmei2002(2.9e-4, 3.0), turns=100, quantity="angle:rocker")
    assert all({"units", "long_name"} <= variable.attrs.keys() for variable in found.variables.values())
    assert found.sample.attrs["long_name"] == "link angle, rocker"


def test_every_mistake_at_once():
    with pytest.raises(jp.InputError) as caught:
        jp.chaos_test(
            catalog.chunmei2002(), turns=0, every=0, frequencies=1.5, seed=-1, tolerance=1.0, quantity="angel"
        )
    keys = {problem.key for problem in caught.value.problems}
    assert keys == {"turns", "every", "frequencies", "seed", "tolerance", "quantity"}


@pytest.mark.parametrize(
    ("system", "quantity"),
    [
        (catalog.duffing(), "w"),
        (catalog.chunmei2002(), "normal_force:A"),
        (catalog.chunmei2002(), "drive_torque:crank"),
        (catalog.chunmei2002(), 3),
    ],
)
def test_a_quantity_that_is_not_there(system, quantity):
    with pytest.raises(jp.InputError, match="quantity"):
        jp.chaos_test(system, quantity=quantity)


def test_too_few_samples_are_why_nothing_is_known():
    found = jp.chaos_test(catalog.duffing(), turns=5)
    assert jp.summary(found).lines == ("K of the 0-1 test is not known: 5 samples, at least 100 are needed",)
