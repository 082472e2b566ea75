"""The verdict of a page, in Node: its rules on series whose answers are known, grades as the program's."""

import math

import numpy as np
import pytest

from jointplay.analysis.assessment.page import GRADES, grade
from jointplay_page import live
from jointplay_page.live import LIMITS
from tests.script.in_node import needs_node, ran

pytestmark = needs_node
PROGRAM = """
const growth = Float64Array.from(data.growth, (each) => (each === null ? NaN : Number(each)));
const counts = { turns: 50 + growth.length, counted: growth.length };
const seen = { ...counts, status: "", separations: {}, force: {}, speed: {}, ideal: null, tolerance: 1e-6 };
return verdict.words({ ...seen, ...data, growth }, data.limits);
"""


def words(tmp_path, growth, points=(), **more):
    given = [str(each).replace("inf", "Infinity") if math.isinf(each) else each for each in growth]
    given = [None if isinstance(each, float) and math.isnan(each) else each for each in given]
    data = {"growth": given, "points": [*map(list, points)], "limits": LIMITS, **more}
    return ran(live.own("verdict.js"), data, PROGRAM, tmp_path)


def test_chaos_is_growth_beyond_three_errors(tmp_path):
    rng = np.random.default_rng(3)
    points = rng.random((100, 2))
    found = words(tmp_path, rng.normal(0.5, 0.1, 400), points, separations={"B": 800})
    assert found.startswith(
        "Joint B loses contact twice a turn. The motion is chaotic; largest exponent +0.5"
    )
    found = words(tmp_path, rng.normal(0.0, 0.1, 400), points)
    assert found.startswith("Whether the motion repeats is undecided: follow more turns")


@pytest.mark.parametrize(("mean", "said"), [(2.0, "The motion is chaotic"), (0.35, "Whether the motion")])
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
    found = words(tmp_path, [-0.5] * 400, points)
    assert found.startswith(f"The motion repeats {often}; largest exponent −0.5")


def test_a_tangent_that_sticking_takes_away_is_told_in_words(tmp_path):
    vanished = "largest exponent −∞: where the joint sticks, every small difference vanishes"
    for growth in ([-0.1] * 10 + [-math.inf] + [math.nan] * 389, [math.nan] * 400):
        found = words(tmp_path, growth, [(0.0, 0.0)] * 100)
        assert found.startswith(f"The motion repeats every turn; {vanished}. 400 turns")
        irregular = np.random.default_rng(3).random((100, 2))
        assert words(tmp_path, growth, irregular).startswith(f"The motion is still settling; {vanished}")


def test_trouble_is_told_before_all_else(tmp_path):
    assert words(tmp_path, [0.1] * 400, status="not converged") == "Stopped: not converged."


def worked(tmp_path, **more):
    """The first sentence on a motion of joint B in 400 turns, 10 N at most in the ideal joints."""
    found = words(tmp_path, [-0.5] * 400, [(0.0, 0.0)] * 100, **{"ideal": {"B": 10, "O": 10}} | more)
    return found.partition(". The motion")[0]


def test_a_motion_is_told_as_an_assessment_tells_it(tmp_path):
    found = worked(tmp_path, separations={"B": 3600}, speed={"B": 0.046}, force={"B": 45, "O": 30})
    most = "joint B carries up to 45 N, 4.5 times as much as with ideal joints"
    assert found == f"Hammers: joint B loses contact 9 times a turn and hits at 46 mm/s; {most}"
    two = {"separations": {"B": 3600, "C": 400}, "speed": {"B": 0.046, "C": 0.02}}
    found = worked(tmp_path, force={"B": 45, "O": 30}, **two)
    both = "joint B loses contact 9 times a turn and hits at 46 mm/s, joint C once a turn and at 20 mm/s"
    assert found == f"Hammers: {both}; {most}"
    found = worked(tmp_path, separations={"B": 0}, force={"B": 10.05, "O": 9})
    assert found == "Quiet: contact is never lost; forces are those of ideal joints, within 1 %"
    sliding = {"separations": {"G_upper_front": 400}, "speed": {"G_upper_front": 0.046}}
    corners = LIMITS | {"corners": {"G_upper_front": "upper front corner of G"}}
    corner = worked(tmp_path, force={"O": 30}, **sliding, limits=corners)
    assert corner.startswith("Hammers: the upper front corner of G loses contact once a turn and hits")
    slight = {"ideal": {"B": 1e-8, "O": 10}, "force": {"B": 1e-7, "O": 9.99}}  # rounding has no ratio
    assert worked(tmp_path, separations={"B": 0}, **slight) == found
    walls = words(tmp_path, [-0.5] * 9, separations={"upper": 9}, limits=LIMITS | {"body": "wall"})
    assert walls.startswith("Wall upper loses contact once a turn. ")
    unknown = words(tmp_path, [-0.5] * 9, ideal=None, separations={"B": 9}, speed={"B": 0.3}, force={"B": 1})
    assert unknown.startswith(
        "Joint B loses contact once a turn and hits at 0.3 m/s; forces of ideal joints "
    )


def test_the_first_turns_are_told_as_such(tmp_path):
    found = worked(tmp_path, turns=12, counted=2, separations={"B": 2}, speed={"B": 0.02}, force={"B": 12})
    assert found.startswith("Settling, 12 of 50 turns. Rattles: joint B loses contact once a turn and hits ")


def test_grades_are_those_of_an_assessment(tmp_path):
    cases = [
        (lost, ratio, speed)
        for lost in (False, True)
        for ratio in (0.9, 1.5, 2.9, 3.0)
        for speed in (0.0, 0.0099, 0.01, 0.0999, 0.1)
    ]
    program = """return data.cases.map(([lost, ratio, speed]) => verdict.graded(
      { separations: { B: Number(lost) }, force: { B: 10 * ratio }, speed: { B: speed }, ideal: { B: 10 } },
      data.limits).grade);"""
    found = ran(live.own("verdict.js"), {"cases": cases, "limits": LIMITS}, program, tmp_path)
    assert found == [GRADES[grade(*case)] for case in cases]
