"""Time histories and portraits show the dataset's own numbers in display units."""

import numpy as np
import pytest

from jointplay import figures
from tests.figures.support.synthetic import CLEARANCE, PERIOD, oscillator, response


def history(dataset, **options):
    return figures.draw(dataset, {"kind": "time_history", **options})


def test_values_and_units_of_a_force():
    data = response()
    (ax,) = history(data).axes
    (line,) = ax.lines
    np.testing.assert_allclose(line.get_xdata(), 1e3 * data.time.values, rtol=1e-12)
    np.testing.assert_array_equal(line.get_ydata(), data.normal_force.sel(joint="B").values)
    assert ax.get_xlabel() == "Time (ms)"
    assert ax.get_ylabel() == "Normal contact force (N)"


def test_every_link_has_a_named_curve():
    data = response()
    (ax,) = history(data, variables="angular_velocity").axes
    assert [line.get_label() for line in ax.lines] == ["crank", "coupler", "rocker"]
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["crank", "coupler", "rocker"]
    np.testing.assert_array_equal(ax.lines[2].get_ydata(), data.angular_velocity.sel(link="rocker").values)
    looks = {(line.get_color(), line.get_linestyle()) for line in ax.lines}
    assert len(looks) == 3


@pytest.mark.parametrize(("turns", "first", "last"), [(2, 4, 6), ([1, 3], 1, 3), ([5.5, 99], 5.5, 6)])
def test_window_in_turns(turns, first, last):
    (ax,) = history(response(), turns=turns, axis=["turns", "time"]).axes
    x = ax.lines[0].get_xdata()
    assert (x[0], x[-1]) == pytest.approx((first, last), abs=2e-3)
    assert ax.get_xlabel() == "Crank turns"


def test_window_in_time():
    (ax,) = history(response(), time=[0.1, 0.2]).axes
    x = ax.lines[0].get_xdata()
    assert x[0] >= 100
    assert x[-1] <= 200
    assert x.size == pytest.approx(720 * 0.1 / PERIOD, abs=1)


def test_second_axis_follows_the_recorded_crank_angle():
    data = response()
    (ax,) = history(data, axis=["time", "angle"]).axes
    (second,) = ax.child_axes
    assert second.get_xlabel() == "Crank angle (deg)"
    ends = np.degrees(data.angle.sel(link="crank").values[[0, -1]])
    assert second.get_xlim() == pytest.approx(ends, abs=1e-9)


def test_without_a_crank_angle_turns_are_nominal():
    data = response().drop_vars("angle")
    (ax,) = history(data, axis="turns").axes
    assert ax.get_xlabel() == "Nominal crank turns"
    np.testing.assert_allclose(ax.lines[0].get_xdata(), data.time.values / PERIOD, rtol=1e-12)


def test_contact_angle_is_broken_where_it_wraps():
    data = response()
    (ax,) = history(data, variables="contact_angle").axes
    y = ax.lines[0].get_ydata()
    np.testing.assert_allclose(y[np.isfinite(y)], np.degrees(data.contact_angle.values[:, 0]))
    steps = np.abs(np.diff(y))
    assert np.nanmax(steps) <= 180


def test_events_are_ticks_in_rows_by_kind():
    data = response()
    strip = history(data, events=True, turns=2).axes[-1]
    assert [text.get_text() for text in strip.get_yticklabels()] == ["contact", "separation"]
    start = history(data, turns=2).axes[0].lines[0].get_xdata()[0] / 1e3
    for line, code in zip(strip.lines, (0, 1), strict=True):
        expected = data.event_time.values[
            (data.event_kind.values == code) & (data.event_time.values >= start)
        ]
        np.testing.assert_allclose(line.get_xdata(), 1e3 * expected)


def test_missing_values_are_hatched_and_named():
    data = response(joints=("B", "C"))
    data["normal_force"][1000:1500, 1] = np.nan
    (ax,) = history(data).axes
    (shade,) = ax.patches
    time = 1e3 * data.time.values
    assert (shade.get_x(), shade.get_x() + shade.get_width()) == pytest.approx((time[999], time[1500]))
    assert "no value (C)" in [text.get_text() for text in ax.get_legend().get_texts()]


def test_a_lone_sample_between_gaps_is_a_dot():
    data = response()
    data["normal_force"][100:200] = np.nan
    data["normal_force"][150] = 5.0
    (ax,) = history(data).axes
    assert list(ax.lines[0].get_markevery()) == [150]


def test_status_is_told():
    assert history(response()).get_suptitle() == ""
    assert "step_limit" in history(response(status="step_limit")).get_suptitle()
    assert "diverged" in figures.draw(response(status="diverged")).get_suptitle()


def test_states_of_a_test_system():
    data = oscillator()
    first, last = history(data).axes  # they may be of other units and sizes
    assert [ax.get_ylabel() for ax in (first, last)] == ["State x", "State v"]
    assert last.get_xlabel() == "Time"
    assert first.child_axes[0].get_xlabel() == "Forcing periods"
    (ax,) = history(data, variables="state_value").axes
    assert [line.get_label() for line in ax.lines] == ["x", "v"]
    assert history(data, variables=["x", "v"]).axes[1].get_ylabel() == "State v"
    (portrait,) = figures.draw(data, {"kind": "phase_portrait"}).axes
    np.testing.assert_array_equal(portrait.lines[0].get_xdata(), data.state_value.sel(state="x").values)
    np.testing.assert_array_equal(portrait.lines[0].get_ydata(), data.state_value.sel(state="v").values)


def test_an_autonomous_system_has_time_only():
    assert not any(ax.child_axes for ax in history(oscillator(period=np.nan)).axes)


def test_portrait_tells_contact_from_flight():
    data = response()
    (ax,) = figures.draw(data, {"kind": "phase_portrait"}).axes
    flight, contact, edge = ax.lines
    touching = data["mode"].values[:, 0] > 0
    samples = np.isin(contact.get_xdata(), 1e6 * data.eccentricity.values[:, 0])
    np.testing.assert_array_equal(np.isfinite(contact.get_ydata())[samples], touching)
    assert np.all(np.isfinite(flight.get_ydata())[samples] | touching)
    assert np.all(np.isfinite(flight.get_ydata()) | np.isfinite(contact.get_ydata()))
    assert edge.get_xdata()[0] == pytest.approx(1e6 * CLEARANCE)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("Eccentricity (µm)", "Normal velocity (mm/s)")


def test_portrait_names_the_link_it_chose():
    (ax,) = figures.draw(response(), {"kind": "phase_portrait", "x": "angle", "y": "angular_velocity"}).axes
    assert ax.get_xlabel() == "Link angle, crank (deg)"
