"""Branches drawn by their tangents: near the exact branch of the impact pair where its chords are far."""

import math

import numpy as np
import pytest

import jointplay as jp
from jointplay import catalog, figures
from jointplay.figures.analyses.continuation import smooth
from tests.analysis.exact_maps import Symmetric

R = 0.8
TOP = Symmetric(1.0, R).fold
TANGENTS = ("gap_tangent", "state_value_tangent", "smallest_impact_speed_tangent")


FOLDED = math.atan2(2, math.pi * (1 + R) / (1 - R))  # the time of impact at the fold


def exact(t0):
    """Gap, state at time 0 and speed of impact of the symmetric motion that meets the lower wall at t0."""
    motion = Symmetric(0.5 * TOP, R)
    motion.gap, motion.t0, motion.speed = TOP * math.cos(FOLDED - t0), t0, 2 * math.cos(t0) / (1 - R)
    return np.array([motion.gap, *motion.at_zero, motion.speed])


@pytest.fixture(scope="module")
def coarse():
    motion = Symmetric(0.6 * TOP, R)
    return jp.continuation(
        catalog.impact_pair(motion.gap, R),
        parameter="gap",
        range=(0.4 * TOP, 1.05 * TOP),
        initial=list(motion.at_zero),
        transient=0,
        step=0.4,
        branch_switching=False,
        max_points=40,
    )


def impact_times(found):
    """The time of impact of each point, from its impact speed: before the jump at time 0 and beyond it."""
    count = int(found.n_points[0])
    sizes = np.arccos(found.smallest_impact_speed.values[0, :count] * (1 - R) / 2)
    times = np.where(np.cumsum(found.section_jump.values[0, :count]) > 0, sizes, -sizes)
    gaps = TOP * np.cos(FOLDED - times)
    assert found.gap.values[0, :count] == pytest.approx(gaps, rel=1e-7)
    return times


@pytest.mark.nightly
def test_tangents_are_derivatives_along_the_exact_branch(coarse):
    h, times = 1e-5, impact_times(coarse)
    assert len(times) > 8
    assert np.abs(times).min() > h  # at 0 the state jumps
    for point, t0 in enumerate(times):
        one = coarse.isel(branch=0, point=point, turn=0)
        gap, *rest = (exact(t0 + h) - exact(t0 - h)) / (2 * h)
        length = math.hypot(gap / (0.65 * TOP), *(rest[:2] / coarse.arc_scale.values))
        given = [one.gap_tangent, *one.state_value_tangent, one.smallest_impact_speed_tangent]
        assert np.array(given) == pytest.approx(np.array([gap, *rest]) / length, rel=1e-5, abs=1e-5)
        assert one.orbit_state_tangent.values == pytest.approx(one.state_value_tangent.values, rel=1e-12)


def drawn(data, quantity):
    """Points of the branch as drawn, stable or not."""
    (ax,) = figures.draw(data, quantity=quantity).axes
    lines = [np.array(line.get_data(), dtype=float) for line in ax.lines if line.get_marker() == "None"]
    return np.concatenate([line[:, np.isfinite(line[1])] for line in lines], axis=1)


def middles(data, quantity):
    """The middles of the chords, but for the one across the jump."""
    count = int(data.n_points[0])
    array = data[quantity] if quantity in data else data.state_value.sel(state=quantity).isel(turn=0)
    points = np.stack([data.gap.values[0, :count], array.values[0, :count]])
    pieces = np.flatnonzero(data.section_jump.values[0, 1:count] == 0)
    return (points[:, pieces] + points[:, pieces + 1]) / 2


@pytest.mark.long
@pytest.mark.parametrize(("quantity", "place"), [("y", 1), ("v", 2), ("smallest_impact_speed", 3)])
def test_the_curve_is_near_the_exact_branch_where_chords_are_far(coarse, quantity, place):
    """Around the fold too; farthest distances in units of the branch's width and height."""
    times = impact_times(coarse)
    table = np.array([exact(t)[[0, place]] for t in np.linspace(times.min(), times.max(), 5001)]).T
    spans = np.ptp(table, axis=1)[:, None]
    ways = np.gradient(table / spans, axis=1)
    ways /= np.hypot(*ways)

    def away(points):
        offsets = (points[:, :, None] - table[:, None]) / spans[:, :, None]
        nearest = np.argmin(np.sum(offsets**2, axis=0), axis=1)
        (x, y), (a, b) = offsets[:, np.arange(points.shape[1]), nearest], ways[:, nearest]
        return np.abs(a * y - b * x).max()

    path, chords = away(drawn(coarse, quantity)), away(middles(coarse, quantity))
    assert path < 5e-5
    assert path < chords / 10


@pytest.mark.nightly
def test_old_results_are_drawn_as_they_were(coarse):
    old = drawn(coarse.drop_vars(TANGENTS), "v")
    assert old.shape[1] < 2 * int(coarse.n_points[0]) < drawn(coarse, "v").shape[1]


@pytest.mark.parametrize("x", [[-3.0, -1.0, 2.0, 3.0], [-3.0, -1e-9, 1e-9, 3.0]])
def test_a_kink_is_not_overshot(x):
    """|x| + x^2 / 9 with its own slopes: an event within a piece, or between the two points of a grazing."""
    x, none = np.array(x), np.zeros(0, dtype=int)
    points = np.stack([x, np.abs(x) + x**2 / 9], -1)
    slopes = np.stack([np.ones(4), np.sign(x) + 2 * x / 9], -1)
    path, _ = smooth(points, slopes, np.ones(4, bool), np.array([False, True, False]), none)
    beside = (path[:, 0] <= x[1]) | (path[:, 0] >= x[2])
    assert path[beside, 1] == pytest.approx(np.abs(path[beside, 0]) + path[beside, 0] ** 2 / 9, abs=1e-12)
    within = path[8:17]
    assert within[:, 1] == pytest.approx(np.interp(within[:, 0], *points[1:3].T), abs=1e-12)


def test_a_line_is_solid_between_stable_points_only():
    points = np.stack([np.arange(4.0), np.zeros(4)], -1)
    stable = np.array([True, True, False, False])
    straight = np.zeros(3, bool)
    path, solid = smooth(points, np.tile([1.0, 0.0], (4, 1)), stable, straight, np.array([3]))
    assert path[solid, 0].max() == 1.0
    assert np.array_equal(np.flatnonzero(np.isnan(path[:, 0])), np.arange(17, 24))
