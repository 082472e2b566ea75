"""Spreads: moments of every form by their definitions, samples that go on, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

import jointplay as jp
from jointplay.analysis.tolerances.spreads import REPLICATES, Design, Distribution, Spread
from tests.support.wrong import texts_of

CRANK = jp.catalog.slider_crank(clearance=1e-4)
SPREADS = {"clearance": {"normal": ["0.1 mm", "3 um"]}, "speed": {"uniform": [190.0, 210.0]}}


@pytest.mark.parametrize(
    ("given", "median", "deviation"),
    [
        ({"normal": [5.0, 2.0]}, 5.0, 2.0),
        ({"lognormal": [3.0, 1.5]}, 3.0, 3.0 * np.sqrt((w := np.exp(np.log(1.5) ** 2)) * (w - 1))),
        ({"uniform": [1.0, 4.0]}, 2.5, 3 / np.sqrt(12)),
        ({"triangular": [0.0, 1.0, 2.0]}, 1.0, 1 / np.sqrt(6)),
        ({"values": [1.0, 2.0], "weights": [3.0, 1.0]}, 1.0, np.sqrt(3) / 4),
        (
            {"scipy": "gumbel_r", "parameters": {"loc": 1.0, "scale": 2.0}},
            stats.gumbel_r(1, 2).median(),
            None,
        ),
        ({"within": [0.0, 6.0], "cp": 2.0}, 3.0, 0.5),
        ({"within": [0.0, 6.0], "cp": 2.0, "cpk": 1.0}, 4.5, 0.5),
        ({"normal": [0.0, 1.0], "above": 0.0}, stats.norm.ppf(0.75), np.sqrt(1 - 2 / np.pi)),
    ],
)
def test_median_and_deviation(given, median, deviation):
    law = Distribution(Spread(**given))
    assert law.median == pytest.approx(median, rel=1e-3 if "cpk" in given else 1e-12)  # cut off to one side
    wanted = stats.gumbel_r(1, 2).std() if deviation is None else deviation
    assert law.deviation == pytest.approx(wanted, rel=1e-2 if "cpk" in given else 3e-3)


def test_a_fit_lies_between_its_least_and_its_largest_clearance():
    """H7/f7 at 20 mm: hole 0 to 21 µm, shaft -41 to -20 µm; sigma of the radius is 21 sqrt(2) / 12 µm."""
    law = Distribution(Spread(fit="H7/f7", diameter="20 mm"))
    ends = law.quantile(np.array([0.0, 0.5, 1.0]))
    assert ends[1] == pytest.approx(20.5e-6, rel=1e-9)
    assert law.deviation == pytest.approx(21e-6 * np.sqrt(2) / 12, rel=1e-3)
    assert 10e-6 <= ends[0] < ends[2] <= 31e-6


def test_quantiles_and_density_belong_together():
    for given in ({"lognormal": [3.0, 1.5], "below": 4.0}, {"within": [0.0, 6.0]}, {"triangular": [0, 1, 3]}):
        law = Distribution(Spread(**given))
        u = np.linspace(0.01, 0.99, 99)
        slope = (law.quantile(u + 1e-6) - law.quantile(u - 1e-6)) / 2e-6
        assert law.density(law.quantile(u)) * slope == pytest.approx(np.ones(99), rel=1e-4)


def test_narrowed_is_the_density_of_the_narrowed_spread():
    law, narrow = Distribution(Spread(normal=(5.0, 2.0))), stats.norm(5.0, 1.0)
    x = np.linspace(2.0, 8.0, 13)
    assert law.narrowed(x, 0.5) == pytest.approx(narrow.pdf(x) / stats.norm(5.0, 2.0).pdf(x), rel=1e-12)


@pytest.mark.parametrize("sequence", ["sobol", "random"])
@pytest.mark.parametrize("count", [1, 5, 100, 1000])
def test_samples_are_the_first_of_more(sequence, count):
    design = Design({"a": Spread(normal=(0, 1)), "b": Spread(uniform=(0, 1))}, sequence=sequence, seed=3)
    few, many = design.drawn(count), design.drawn(2500)
    assert np.array_equal(few, many[:count])
    assert not np.array_equal(few, Design(design.spreads, sequence=sequence, seed=4).drawn(count))


def test_every_scrambling_is_a_net():
    """Each scrambling has one point in every 1/64 of each axis."""
    points = Design({"a": Spread(uniform=(0, 1)), "b": Spread(uniform=(0, 1))}).drawn(64 * REPLICATES)
    for number in range(REPLICATES):
        cells = np.sort(np.floor(64 * points[number::REPLICATES]), axis=0)
        assert np.array_equal(cells, np.repeat(np.arange(64.0)[:, None], 4, axis=1))


def test_correlation_and_batches():
    """Of normals Pearson's coefficient is that of the matrix; of one batch all are high or low together."""
    spreads = {key: Spread(normal=(0.0, sigma)) for key, sigma in (("a", 1.0), ("b", 3.0))}
    design = Design(spreads, correlation=((1.0, 0.6), (0.6, 1.0)))
    values = design.values(design.scores(design.drawn(2**14)[:, :2]))
    assert np.corrcoef(values.T)[0, 1] == pytest.approx(0.6, abs=0.005)
    assert values.std(axis=0) == pytest.approx([1.0, 3.0], rel=0.01)
    batch = Design(spreads, together=(("b", "a"),))
    assert batch.factors == [[0, 1]]
    values = batch.values(batch.scores(batch.drawn(64)[:, :1]))
    assert values[:, 1] == pytest.approx(3 * values[:, 0])
    whole = Design(spreads, correlation=((1.0, 1.0), (1.0, 1.0)))
    values = whole.values(whole.scores(whole.drawn(64)[:, :2]))
    assert values[:, 1] == pytest.approx(3 * values[:, 0])


def refused(**given):
    return texts_of(jp.tolerances, CRANK, **{"spreads": SPREADS, "samples": 8} | given)


@pytest.mark.parametrize(
    ("given", "key", "words"),
    [
        ({"links.slider.mass": {"normal": [0.1, 0.05]}}, "spreads.links.slider.mass", "above and below"),
        ({"clearance": {"normal": ["20 um", "8 um"]}}, "spreads.clearance", "above and below"),
        ({"clearance": {"uniform": [1e-5, 20.0]}}, "spreads.clearance", "accepted"),
        ({"clearance": {"normal": ["0.1 mm", "3 kg"]}}, "spreads", "kg does not convert to m"),
        (
            {"clearance": {"normal": 5e-5}},
            "spreads.clearance",
            "a list [a finite number; a number greater than 0]",
        ),
        ({"clearance": {"normal": [1e-4, -1e-6]}}, "spreads.clearance.normal[1]", "a number greater than 0"),
        ({"clearance": {"values": 3}}, "spreads.clearance", "a list [a finite number; …]"),
        ({"clearence": {"normal": [1e-4, 1e-6]}}, "spreads.clearence", "clearance"),
        ({"clearance": {"normal": [1e-4, 1e-6], "uniform": [0, 1]}}, "spreads.clearance", "one of"),
        ({"clearance": {"fit": "H7/f7"}}, "spreads.clearance.diameter", "needed"),
        ({"clearance": {"fit": "H7/h6", "diameter": "0.9 m"}}, "spreads.clearance.diameter", "up to"),
        ({"clearance": {"fit": "H7/k6", "diameter": 0.02}}, "spreads.clearance.fit", "clearance"),
        ({"clearance": {"within": [2e-5, 1e-5]}}, "spreads.clearance.within", "rising"),
        ({"clearance": {"within": [1e-5, 2e-5], "cp": 1, "cpk": 2}}, "spreads.clearance.cpk", "at most 1"),
        ({"clearance": {"scipy": "weibull_min"}}, "spreads.clearance.parameters", "c of weibull_min"),
        ({"clearance": {"scipy": "norml"}}, "spreads.clearance.scipy", "norm"),
        ({"clearance": {"normal": [1e-4, 1e-6], "above": 1e-3}}, "spreads.clearance", "cut off"),
        ({"clearance": {"values": [1e-4, 1e-4]}}, "spreads.clearance.values", "each once"),
        ({"initial.crank_speed": {"normal": [1, 1]}}, "spreads.initial.crank_speed", "no linkage"),
        ({}, "spreads", "table of parameters"),
    ],
)
def test_refused_spreads(given, key, words):
    found = refused(spreads=given)
    assert any(each == key or each.startswith(f"{key}.") for each in found), found
    assert any(words in text for text in found.values()), found


@pytest.mark.parametrize(
    ("given", "key", "words"),
    [
        ({"correlation": ((1.0, 2.0), (2.0, 1.0))}, "correlation", "symmetric"),
        ({"correlation": ((1.0, 0.5),)}, "correlation", "2 rows"),
        ({"correlation": ((1.0, 0.5), (0.5, 1.0)), "shares": 8}, "shares", "independent"),
        ({"together": (("clearance",),)}, "together[0]", "two parameters"),
        ({"together": (("clearance", "mass"),)}, "together[0]", "parameter"),
        ({"events": ["rattles"]}, "events[0]", "contact_loss"),
        ({"of": ["force:X"]}, "of[0]", "force:B"),
        ({"of": ["pressure:B"]}, "of[0]", "length of the bearing"),
        ({"limits": {"force:B": "3 m"}}, "limits.force:B", "does not convert"),
        ({"edge": {"contact_loss": "mass"}}, "edge.contact_loss", "parameter with a spread"),
        ({"edge": {"hits": "clearance"}}, "edge.hits", "event"),
        ({"prices": {"clearance": 1.0}}, "wanted", "together"),
        ({"turns": 2}, "turns", "events = []"),
        ({"events": []}, "events", "quantity"),
    ],
)
def test_refused_questions(given, key, words):
    found = refused(**given)
    assert words in found.get(key, ""), found


def test_three_correlations_that_cannot_all_be():
    spreads = SPREADS | {"links.slider.mass": {"normal": [0.14, 0.001]}}
    found = refused(spreads=spreads, correlation=((1, 0.9, 0.9), (0.9, 1, -0.9), (0.9, -0.9, 1)))
    assert "negative eigenvalues" in found["correlation"]
