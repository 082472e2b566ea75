"""The direction of the journal three ways, from one stored angle; jumps of a branch are not drawn."""

import numpy as np
import pytest

from jointplay import figures
from jointplay.figures.drawing import timebase
from tests.figures.support.synthetic import response


def test_three_ways_tell_the_same_direction():
    truth = np.linspace(-500.0, 800.0, 5001)
    stored = timebase.within(truth, 360.0)
    assert np.all((stored >= -180) & (stored < 180))
    np.testing.assert_allclose(np.mod(stored - truth, 360.0) % 360.0, 0.0, atol=1e-9)
    np.testing.assert_allclose(timebase.unwrapped(stored) - stored[0], truth - truth[0], atol=1e-9)
    radians = np.radians(truth)
    arctan = np.degrees(np.arctan(np.sin(radians) / np.cos(radians)))
    inside = np.abs(np.abs(arctan) - 90) > 1e-6
    np.testing.assert_allclose(timebase.within(stored, 180.0)[inside], arctan[inside], atol=1e-9)


def test_a_third_of_a_turn_between_samples_is_followed():
    np.testing.assert_allclose(timebase.unwrapped(np.array([0.0, 120.0, -120.0, 0.0])), [0, 120, 240, 360])


def test_gaps_stay_gaps():
    truth = np.linspace(0.0, 700.0, 701)
    stored = timebase.within(truth, 360.0)
    stored[300:310] = np.nan
    found = timebase.unwrapped(stored)
    assert np.isnan(found[300:310]).all()
    np.testing.assert_allclose(found[310:], truth[310:])


def test_the_pen_is_lifted_at_jumps_and_nowhere_else():
    degrees = np.array([170.0, 179.0, -179.0, -170.0, -100.0])
    x = np.arange(5.0)
    xs, ys = timebase.broken(degrees, 360.0, x, degrees)
    np.testing.assert_array_equal(np.isnan(ys), [False, False, True, False, False, False])
    np.testing.assert_array_equal(xs, [0, 1, 2, 2, 3, 4])
    branch = timebase.within(degrees, 180.0)
    xs, ys = timebase.broken(branch, 180.0, x, branch)
    assert np.isnan(ys).sum() == 0  # the arctangent runs on through 180 deg


@pytest.fixture
def turning():
    """A response whose journal goes round three times, evenly."""
    data = response(section=False)
    angle = np.linspace(0, 6 * np.pi, data.sizes["time"])
    data["contact_angle"][:, 0] = (angle + np.pi) % (2 * np.pi) - np.pi
    return data


def rows(figure):
    """What is drawn as contact or flight, a row each: the angles where there is a line."""
    return [[line.get_ydata() for line in ax.lines] for ax in figure.axes]


def test_no_vertical_line_joins_the_ends_of_a_branch(turning):
    wrapped, unwrapped, branch = rows(figures.draw(turning, kind="contact_angle"))
    for lines, span, jumps in ((wrapped, 360, 3), (branch, 180, 6)):
        for y in lines:
            assert np.nanmax(np.abs(np.diff(y))) < span / 2
        assert lines[0].size == turning.sizes["time"] + jumps
        assert np.nanmin(lines[1]) >= -span / 2
        assert np.nanmax(lines[1]) <= span / 2
    there = turning["mode"].values[:, 0] > 0
    expected = np.linspace(0, 1080, turning.sizes["time"])
    np.testing.assert_allclose(unwrapped[1][there], expected[there], atol=1e-9)


def test_contact_is_told_from_flight_or_said_to_be_unknown(turning):
    figure = figures.draw(turning, kind="contact_angle")
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["free flight", "contact"]
    figure = figures.draw(turning.drop_vars("mode"), kind="contact_angle")
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["path (modes not recorded)"]


def test_scales_are_those_of_the_ranges(turning):
    wrapped, unwrapped, branch = figures.draw(turning, kind="contact_angle").axes
    assert set(np.diff(wrapped.get_yticks())) == {90}
    assert wrapped.get_ylim()[1] == pytest.approx(180, rel=0.1)
    assert branch.get_ylim()[0] == pytest.approx(-90, rel=0.1)
    assert unwrapped.get_ylim()[1] > 1080
    assert all(ax.get_ylabel().startswith("Contact angle,") for ax in (wrapped, unwrapped, branch))
    two = turning.isel(joint=[0, 0]).assign_coords(joint=["A", "B"])
    axes = figures.draw(two, kind="contact_angle", joint="B").axes
    assert all(ax.get_ylabel().startswith("Contact angle at B,") for ax in axes)


def test_windows_are_columns_unwrapped_from_their_own_start(turning):
    part = turning.isel(time=np.r_[0:721, 3600:4321])
    part = part.assign(window=("time", np.repeat(np.int8([0, 1]), 721)))
    figure = figures.draw(part, kind="contact_angle")
    assert len(figure.axes) == 6
    later = figure.axes[3].lines[1].get_ydata()
    assert -180 <= later[np.isfinite(later)][0] < 180
    assert figure.axes[0].get_title(loc="left") == "(a) start-up, turn 1"
    one = figures.draw(turning, kind="contact_angle")
    assert figure.get_layout_engine().get()["wspace"] > one.get_layout_engine().get()["wspace"]
