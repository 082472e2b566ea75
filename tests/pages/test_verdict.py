"""The verdict of a page, in Node: its rules on series whose answers are known."""

import math

import numpy as np
import pytest

from jointplay_page import template
from tests.script.in_node import needs_node, ran

pytestmark = needs_node
PROGRAM = """
const growth = Float64Array.from(data.growth, (each) => (each === null ? NaN : Number(each)));
const counts = { turns: 50 + growth.length, counted: growth.length };
const seen = { ...counts, status: "", separations: {}, tolerance: 1e-6 };
return verdict.words({ ...seen, ...data, growth });
"""


def words(tmp_path, growth, points=(), **more):
    given = [str(each).replace("inf", "Infinity") if math.isinf(each) else each for each in growth]
    given = [None if isinstance(each, float) and math.isnan(each) else each for each in given]
    data = {"growth": given, "points": [*map(list, points)], **more}
    return ran(template.own("verdict.js"), data, PROGRAM, tmp_path)


def test_chaos_is_growth_beyond_three_errors(tmp_path):
    rng = np.random.default_rng(3)
    points = rng.random((100, 2))
    found = words(tmp_path, rng.normal(0.5, 0.1, 400), points, separations={"B": 800})
    assert found.startswith("Chaotic; separations per turn at B: 2; largest exponent +0.5")
    assert words(tmp_path, rng.normal(0.0, 0.1, 400), points).startswith("Undecided: follow more turns")


@pytest.mark.parametrize(("mean", "said"), [(2.0, "Chaotic"), (0.35, "Undecided")])
def test_correlated_batches_widen_the_error(mean, said, tmp_path):
    """Batches of one growth each, correlated by 0.6 with the next: twice their error of 0.1 is right."""
    rng = np.random.default_rng(5)
    draws = rng.normal(0.0, 1.0, 40)
    for i in range(1, 40):
        draws[i] = 0.75 * draws[i - 1] + math.sqrt(1 - 0.75**2) * draws[i]
    draws = (draws - draws.mean()) / draws.std(ddof=1) * 0.1 * math.sqrt(40)
    found = words(tmp_path, np.repeat(mean + draws, 10), rng.random((100, 2)))
    assert "± 0.10 per turn" in found
    assert found.startswith(said)


@pytest.mark.parametrize("period", [1, 3])
def test_a_period_is_where_points_come_back(period, tmp_path):
    points = [(float(i % period), 0.0) for i in range(100)]
    often = {1: "every turn", 3: "every 3 turns"}[period]
    assert words(tmp_path, [-0.5] * 400, points).startswith(f"Repeats {often}; largest exponent −0.5")


def test_a_tangent_that_sticking_takes_away_is_told_in_words(tmp_path):
    vanished = "largest exponent −∞: where the joint sticks, every small difference vanishes"
    for growth in ([-0.1] * 10 + [-math.inf] + [math.nan] * 389, [math.nan] * 400):
        found = words(tmp_path, growth, [(0.0, 0.0)] * 100)
        assert found.startswith(f"Repeats every turn; {vanished}. 400 turns")
        irregular = np.random.default_rng(3).random((100, 2))
        assert words(tmp_path, growth, irregular).startswith(f"Still settling; {vanished}")


def test_trouble_is_told_before_all_else(tmp_path):
    assert words(tmp_path, [0.1] * 400, status="not converged") == "Stopped: not converged."
