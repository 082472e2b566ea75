"""Curves in two parameters against closed forms: the impact pair's and the ball's, all along."""

import math
import re

import numpy as np
import pytest

import jointplay as jp
from jointplay import catalog
from jointplay.analysis.curves.curve import BRANCH
from tests.analysis.exact_maps import Symmetric, symmetry_lost
from tests.support.wrong import problems_of


def ball_fold(a):
    return math.pi * (1 - a) / (1 + a)


def ball_doubling(a):
    return math.hypot(ball_fold(a), 2 * (1 + a**2) / (1 + a) ** 2)


def along(found, kind):
    """Parameters of the one curve of a kind, and why it ends."""
    words = jp.words(found)
    (number,) = np.flatnonzero(words["curve_kind"].values == kind)
    count = int(found["n_points"][number])
    values = [found[name].values[number, :count] for name in found.attrs["parameters"].split()]
    slopes = [found[f"{name}_tangent"].values[number, :count] for name in found.attrs["parameters"].split()]
    return *values, slopes, words["curve_end"].values[number].tolist()


def curves_of_the_pair(**how):
    r = 0.8
    motion = Symmetric(0.5 * Symmetric(1.0, r).fold, r)
    return jp.curve(
        catalog.impact_pair(motion.gap, r),
        plane={"gap": (1.2, 150.0), "restitution": (0.3, 0.95)},
        initial=list(motion.at_zero),
        transient=0,
        **how,
    )


@pytest.fixture(scope="module")
def pair():
    return curves_of_the_pair(step=0.1)


@pytest.mark.nightly
def test_progress_is_a_share_of_the_most_points_there_can_be():
    told = []
    curves_of_the_pair(max_points=6, max_curves=2, max_branches=1, progress=told.append)
    assert len(told) > 6
    assert np.diff(told)[1:6] == pytest.approx(1 / (BRANCH + 2 * 6))


BALL = catalog.bouncing_ball(1.3, 0.5)


@pytest.fixture(scope="module")
def branches():
    """Of the ball over Gamma alone: its fold and its doubling."""
    over = {"parameter": "acceleration", "range": (1.0, 1.6), "branch_switching": False, "record": ()}
    return jp.continuation(BALL, **over, step=0.1, max_points=60)


@pytest.fixture(scope="module")
def ball(branches):
    plane = {"acceleration": (0.2, 4.0), "restitution": (0.1, 0.9)}
    return jp.curve(BALL, plane=plane, branches=branches, step=0.1)


@pytest.mark.nightly
def test_limits_of_the_symmetric_motion(pair):
    assert int(pair.status) == 0
    exact = {"fold": lambda r: Symmetric(1.0, r).fold, "symmetry_breaking": symmetry_lost}
    for kind, limit in exact.items():
        gaps, restitutions, _, ends = along(pair, kind)
        assert gaps == pytest.approx([limit(r) for r in restitutions], rel=1e-9)
        assert [restitutions[0], restitutions[-1]] == [0.3, 0.95]
        assert ends == ["range", "range"]
    assert pair.sizes["meeting"] == 0


@pytest.mark.nightly
def test_the_ball_begins_to_bounce_and_doubles_its_period(ball):
    for kind, limit in (("fold", ball_fold), ("period_doubling", ball_doubling)):
        gammas, restitutions, slopes, ends = along(ball, kind)
        assert len(gammas) > 10
        assert gammas == pytest.approx([limit(a) for a in restitutions], rel=1e-9)
        assert ends == ["range", "range"]
        h = 1e-5
        for gamma_slope, a_slope, a in zip(*slopes, restitutions, strict=True):
            exact = (limit(a + h) - limit(a - h)) / (2 * h)
            assert gamma_slope / a_slope == pytest.approx(exact, rel=1e-3, abs=1e-3)
    gammas = along(ball, "fold")[0]
    edges = sorted((gammas[0], gammas[-1]))
    assert edges == pytest.approx([0.2, ball_fold(0.1)], rel=1e-9)


@pytest.mark.nightly
def test_multipliers_on_the_curves(pair, ball):
    """On each a multiplier is what its name says: of the whole turn, also where half of it was solved."""
    for found, kind, value in (
        (pair, "fold", 1),
        (pair, "symmetry_breaking", 1),
        (ball, "fold", 1),
        (ball, "period_doubling", -1),
    ):
        (number,) = np.flatnonzero(jp.words(found)["curve_kind"].values == kind)
        pairs = found["floquet_multiplier"].values[number, : int(found["n_points"][number])] @ [1, 1j]
        assert np.max(np.min(np.abs(pairs - value), axis=1)) < 1e-5


@pytest.mark.nightly
def test_kinds_that_are_asked_for_and_a_limit(branches):
    plane = {"acceleration": (1.0, 1.7), "restitution": (0.45, 0.55)}
    given = {"of": "period_doubling", "max_points": 12, "step": 0.02}
    found = jp.curve(BALL, plane=plane, branches=branches, **given)
    gammas, restitutions, _, ends = along(found, "period_doubling")
    assert found.sizes["curve"] == 1
    assert len(gammas) == 12
    assert ends == ["max_points", "max_points"]
    assert gammas == pytest.approx([ball_doubling(a) for a in restitutions], rel=1e-9)


@pytest.mark.parametrize(("step", "whole"), [(0.1, True), (0.001, False)])
def test_a_branch_that_ends_within_the_range_denies_no_bifurcation(step, whole):
    """A linear oscillator has none; steps of a thousandth get no farther than a tenth of the range."""
    linear = jp.System(
        name="linear",
        states={"x": 0.0, "v": 0.0},
        parameters={"F": 0.5, "w": 1.0},
        rates={"x": "v", "v": "F*cos(w*t) - v - x"},
        forcing="2*pi/w",
    )
    plane = {"w": (0.8, 1.2), "F": (0.2, 1.0)}
    found = jp.curve(linear, plane=plane, step=step, transient=20, max_points=2)
    told = str(jp.summary(found))
    assert ("it has no bifurcation on the branch" in told) == whole
    assert ("stopped" in found.attrs) != whole
    stopped = re.findall(r"(\d\.\d+) \(the limit on the number of points\)", told)
    low, high = map(float, stopped or (0.9, 1.1))
    assert 0.8 < low < 1 < high < 1.2
    assert len(stopped) == (0 if whole else 2)


def test_no_orbit_no_curve():
    plane = {"gap": (2.0, 3.0), "restitution": (0.7, 0.85)}
    found = jp.curve(catalog.impact_pair(2.5, 0.8), plane=plane, max_steps=3)
    assert int(found.status) == 2
    assert found.sizes["curve"] == 0
    assert "no curve was found" in str(jp.summary(found))


@pytest.mark.parametrize(
    ("keywords", "keys"),
    [
        ({"plane": {"gap": (2.0, 3.0)}}, ["plane"]),
        ({"plane": {"gap": (3.0, 2.0), "restitution": (0.7, 0.9)}}, ["plane.gap"]),
        ({"plane": {"gsp": (2.0, 3.0), "restitution": (0.7, 0.9)}}, ["plane.gsp"]),
        ({"plane": {"gap": (2.0, 3.0), "restitution": (0.7, 0.9)}}, ["start"]),
        ({"plane": {"gap": (2.0, 9.0), "restitution": (0.1, 0.2)}}, ["plane.restitution"]),
        ({"plane": {"gap": (2.0, 9.0), "restitution": (0.7, 0.9)}, "of": "flip"}, ["of[0]"]),
    ],
)
def test_wrong_keywords(keywords, keys):
    assert list(problems_of(jp.curve, catalog.impact_pair(5.0, 0.8), **keywords)) == keys


@pytest.mark.nightly
def test_one_special_point_by_its_label(branches):
    """The branches went over the one parameter, the plane names the other first."""
    kinds = jp.words(branches)["special_kind"].values.tolist()
    plane = {"restitution": (0.4, 0.6), "acceleration": (0.2, 4.0)}
    found = jp.curve(BALL, plane=plane, branches=branches, labels=kinds.index("fold"), step=0.2)
    assert jp.words(found)["curve_kind"].values.tolist() == ["fold"]
    restitutions, gammas, _, ends = along(found, "fold")
    assert gammas == pytest.approx([ball_fold(a) for a in restitutions], rel=1e-9)
    assert ends == ["range", "range"]
    with pytest.raises(jp.InputError) as caught:
        jp.curve(BALL, plane=plane, branches=branches, labels=[0, 9], start=0.5)
    assert [problem.key for problem in caught.value.problems] == ["start", "labels[1]"]
    with pytest.raises(jp.InputError, match="a result of continuation is accepted"):
        jp.curve(BALL, plane=plane, branches=found)
    for labels, key in ((None, "branches"), (kinds.index("fold"), "labels")):
        with pytest.raises(jp.InputError, match="a curve of neimark_sacker can start") as caught:
            jp.curve(BALL, plane=plane, branches=branches, labels=labels, of="neimark_sacker")
        assert [problem.key for problem in caught.value.problems] == [key]
    with pytest.raises(jp.InputError, match="max_branches"):
        jp.curve(BALL, plane=plane, branches=branches, max_branches=2)


@pytest.mark.nightly
def test_curves_start_on_the_branches_that_leave():
    """The ball's doubled motion doubles once more."""
    plane = {"acceleration": (1.0, 1.75), "restitution": (0.45, 0.55)}
    given = {"of": "period_doubling", "step": 0.1, "max_points": 30, "max_branches": 2}
    found = jp.curve(BALL, plane=plane, **given)
    counts = found["n_points"].values
    assert [set(found["period"].values[i, :n]) for i, n in enumerate(counts)] == [{1}, {2}]
    multipliers = found["floquet_multiplier"].values @ [1, 1j]
    for number, n in enumerate(counts):
        assert np.max(np.min(np.abs(multipliers[number, :n] + 1), axis=1)) < 1e-5
    last = found.isel(curve=1, point=slice(0, int(counts[1])))
    limits = [ball_doubling(a) for a in last["restitution"].values]
    assert np.all(last["acceleration"].values > limits)
