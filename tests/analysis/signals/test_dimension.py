"""Correlation dimension: sets of known dimension, pairs counted one by one, sections of motions."""

import math

import numpy as np
import pytest
from scipy.stats import sem

import jointplay as jp
from jointplay import catalog
from jointplay.analysis.signals import dimension
from jointplay.analysis.signals.dimension import SHARES, scaled


def measured(points, shares=SHARES, window=1):
    at = dimension.radii(points)
    sums = dimension.correlation_sum(points, at, window)
    return at, sums, dimension.fit(points, at, sums, shares, window)


def henon(count):
    """The Hénon map's attractor, a = 1.4, b = 0.3."""
    x, y, found = 0.3, 0.1, np.empty((count, 2))
    for i in range(-100, count):
        x, y = 1 - 1.4 * x * x + y, 0.3 * x
        if i >= 0:
            found[i] = x, y
    return found


def uniform(count, coordinates):
    return np.random.default_rng(2).uniform(size=(count, coordinates))


@pytest.mark.parametrize("window", [1, 2, 7])
def test_pairs_counted_one_by_one(window):
    points, at = uniform(150, 2), np.array([0.01, 0.1, 0.5, 2.0])
    apart = np.linalg.norm(points[:, None] - points[None], axis=-1)
    far = np.abs(np.subtract.outer(np.arange(150), np.arange(150))) >= window
    expected = [np.mean(apart[far] <= r) for r in at]
    assert dimension.correlation_sum(points, at, window) == pytest.approx(expected, abs=1e-15)


def test_a_circle():
    angle = np.random.default_rng(3).uniform(0, 2 * math.pi, 4000)
    _, _, slope = measured(np.stack([np.cos(angle), np.sin(angle)], -1))
    assert slope.dimension == pytest.approx(1.0, abs=0.02)
    assert abs(slope.dimension - 1) < 3 * math.hypot(slope.spread, slope.standard_error)


def test_a_square_has_edges():
    """The share of pairs is π r² - (8/3) r³ + r⁴/2 for r < 1: the slope is below 2, by what this says."""
    at, sums, slope = measured(uniform(5000, 2))
    exact = math.pi * at**2 - 8 / 3 * at**3 + at**4 / 2
    used = (sums >= SHARES[0]) & (sums <= SHARES[1])
    assert sums[used] == pytest.approx(exact[used], rel=0.08)
    expected = np.polyfit(np.log(at[used]), np.log(exact[used]), 1)[0]
    assert expected == pytest.approx(1.975, abs=0.005)
    assert slope.dimension == pytest.approx(expected, abs=3 * slope.standard_error + 0.01)
    assert slope.standard_error < 0.03


@pytest.mark.nightly
def test_henon():
    """1.220: J. C. Sprott and G. Rowlands, Int. J. Bifurcation Chaos 11 (2001) 1865-1880."""
    _, _, slope = measured(henon(10_000), (1e-4, 1e-1), 10)
    assert slope.dimension == pytest.approx(1.22, abs=0.03)
    assert 0.005 < slope.spread < 0.06


def cantor(count):
    """Points of Cantor's set, digits by chance."""
    digits = 2 * np.random.default_rng(0).integers(0, 2, size=count + 40)
    return np.convolve(digits, 3.0 ** -np.arange(36, 0, -1), "valid")[:count, None]


def turning(count):
    """Places of a turn by the golden mean on a circle."""
    angle = np.arange(count) * math.pi * (math.sqrt(5) - 1)
    return np.stack([np.cos(angle), np.sin(angle)], -1)


@pytest.mark.parametrize(
    ("points", "dimension"), [(cantor(5000), math.log(2, 3)), (turning(5000), 1.0), (turning(1000), 1.0)]
)
def test_the_error_covers_what_the_series_alone_does_not_tell(points, dimension):
    """The standard error of the first is a quarter of its distance from the truth, that of the others 0."""
    _, _, slope = measured(points, window=10)
    assert abs(slope.dimension - dimension) > 3 * slope.standard_error
    assert abs(slope.dimension - dimension) < 1.5 * slope.error
    assert slope.error == max(slope.spread, slope.standard_error)


def test_neighbours_in_time_are_no_evidence():
    """Points of a square that each linger for five samples: as if they were pairs of a set of few places."""
    lingering = np.repeat(uniform(600, 2), 5, axis=0) + 1e-3 * np.random.default_rng(4).normal(size=(3000, 2))
    dimensions = [measured(lingering, (2e-4, 1e-2), window)[2].dimension for window in (1, 5)]
    assert dimensions[0] < 1.7
    assert dimensions[1] == pytest.approx(2.0, abs=0.2)


def test_few_places_have_no_dimension():
    places = np.array([[0.0, 0.0], [1.0, 0.0], [0.3, 0.7]])[np.arange(600) % 3]
    _, _, slope = measured(places + 1e-9 * uniform(600, 2))
    assert (slope.dimension, slope.spread) == (0.0, 0.0)


def test_too_many_dimensions_for_so_few_points():
    _, _, slope = measured(uniform(300, 40))
    assert math.isnan(slope.dimension)


def test_the_standard_error_covers_the_scatter_of_repeated_sets():
    random = np.random.default_rng(5)
    found = [measured(random.uniform(size=(800, 2)), (1e-3, 3e-2))[2] for _ in range(20)]
    scatter = np.std([one.dimension for one in found], ddof=1)
    assert 1 < np.mean([one.standard_error for one in found]) / scatter < 3


def test_the_standard_error_is_that_of_the_slopes_of_four_quarters():
    points = uniform(2000, 2)
    at, sums, slope = measured(points)
    used = at[(sums >= SHARES[0]) & (sums <= SHARES[1])]
    slopes = [
        np.polyfit(np.log(used), np.log(dimension.correlation_sum(part, used, 1)), 1)[0]
        for part in points.reshape(4, 500, 2)
    ]
    assert slope.standard_error == pytest.approx(sem(slopes))


@pytest.mark.parametrize(("count", "known"), [(11, math.nan), (12, 2.0)])
def test_twelve_radii_in_the_range_make_a_slope(count, known):
    at = np.geomspace(0.1, 1.0, count)
    slope = dimension.fit(uniform(100, 2), at, 0.1 * at**2, (1e-4, 0.2), 1)
    assert slope.dimension == pytest.approx(known, nan_ok=True)


def test_coordinates():
    """Each in its own standard deviation; those that hardly vary are left out."""
    points = uniform(500, 3) * [1.0, 1e3, 1e-7] + [0.0, 0.0, 1.0]
    found = scaled(points, 1e-4)
    assert found.shape == (500, 2)
    assert np.std(found, axis=0) == pytest.approx([1, 1])


def test_impact_pair():
    """Below the Kaplan-Yorke dimension of its exponents, 1 + 0.23792/0.58033."""
    found = jp.dimension(catalog.impact_pair(0.4, 0.8), turns=3000, transient=100, initial=(0.05, 0.7))
    assert int(found.status) == 0
    error = float(found.correlation_dimension_standard_error)
    assert 1.15 < float(found.correlation_dimension) < 1.41 + 3 * error
    assert int(found.n_coordinates) == 2
    low, high = found.fit_radius.values
    inside = (found.radius >= low) & (found.radius <= high)
    assert np.all(inside == ((found.correlation_sum >= SHARES[0]) & (found.correlation_sum <= SHARES[1])))
    local = found.local_slope[inside]
    assert float(local.mean()) == pytest.approx(float(found.correlation_dimension), abs=0.1)


@pytest.mark.parametrize(("gap", "coordinates"), [(0.6, 2), (3.6, 0)])
def test_periodic_motions(gap, coordinates):
    found = jp.dimension(catalog.impact_pair(gap, 0.8), turns=300, transient=600, initial=(0.05, 0.7))
    assert float(found.correlation_dimension) == 0.0
    assert int(found.n_coordinates) == coordinates


@pytest.mark.nightly
@pytest.mark.parametrize(("clearance", "low", "high"), [(2.9e-5, 0.0, 0.0), (2.9e-4, 1.1, 1.7)])
def test_the_linkage(clearance, low, high):
    """Panels b and c of the paper's Figure 12: a point, and a cloud of less than 1 + 1.74/2.93 dimensions."""
    found = jp.dimension(catalog.chunmei2002(clearance, 3.0), turns=1000, transient=50)
    assert low <= float(found.correlation_dimension) <= high
    assert int(found.n_coordinates) == (5 if high else 0)


@pytest.mark.parametrize(("keywords", "status"), [({"max_steps": 50}, 2), ({"turns": 40}, 0)])
def test_trouble_is_a_status(keywords, status):
    found = jp.dimension(catalog.duffing(), **{"turns": 200} | keywords)
    assert int(found.status) == status
    assert math.isnan(float(found.correlation_dimension))


def test_every_variable_says_what_it_is():
    found = jp.dimension(catalog.duffing(), turns=200, quantities=["v"])
    for name, variable in found.variables.items():
        assert "long_name" in variable.attrs, name
        assert ("units" in variable.attrs) == (name != "bound")


def test_every_mistake_at_once():
    with pytest.raises(jp.InputError) as caught:
        jp.dimension(
            catalog.duffing(), turns=-1, window=0, shares=(0.1, 0.01), tolerance="x", quantities=["y", "w"]
        )
    keys = {problem.key for problem in caught.value.problems}
    assert keys == {"turns", "window", "shares", "tolerance", "quantities[1]"}
