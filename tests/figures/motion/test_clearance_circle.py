"""Orbits and sections in the clearance circle: positions in clearances, and nothing lost without a word."""

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from jointplay import figures
from tests.figures.support.synthetic import CLEARANCE, response, section


def headings(figure) -> list[str]:
    return [ax.get_title(loc="left").replace("\n", " ") for ax in figure.axes]


def sentences(figure) -> list[str]:
    return [text.get_text().replace("\n", " ") for ax in figure.axes for text in ax.texts]


def lightness(colour: str) -> float:
    return float(np.dot(to_rgb(colour), (0.299, 0.587, 0.114)))


def test_orbit_is_in_clearances_with_equal_scales():
    data = response()
    (ax,) = figures.draw(data, {"kind": "journal_orbit"}).axes
    contact = next(line for line in ax.lines if line.get_label() == "contact")
    x, y = contact.get_data()
    samples = np.isin(x, data.journal_x.values[:, 0] / CLEARANCE)  # the path is smooth in between
    there, touching = np.isfinite(y), data["mode"].values[:, 0] > 0
    np.testing.assert_array_equal(there[samples], touching)
    np.testing.assert_array_equal(y[samples & there], data.journal_y.values[touching, 0] / CLEARANCE)
    assert np.all(np.hypot(x, y)[there & ~samples] > 0.999)
    assert ax.get_aspect() == 1
    assert ax.get_xlim() == ax.get_ylim()
    assert ax.get_xlim()[1] > data.eccentricity_ratio.max()
    (circle,) = ax.patches
    assert circle.get_radius() == 1


def test_contact_and_flight_differ_in_grey():
    (ax,) = figures.draw(response(), {"kind": "journal_orbit"}).axes
    flight, contact = ax.lines
    assert lightness(flight.get_color()) - lightness(contact.get_color()) > 0.4
    assert contact.get_linewidth() > 1.5 * flight.get_linewidth()


def test_released_is_not_contact():
    data = response()
    data["mode"][:] = 1
    (ax,) = figures.draw(data, {"kind": "journal_orbit"}).axes
    assert not np.isfinite(ax.lines[1].get_ydata()).any()


def test_orbit_without_modes_is_plain():
    (ax,) = figures.draw(response().drop_vars("mode"), {"kind": "journal_orbit"}).axes
    assert [line.get_label() for line in ax.lines] == ["path (modes not recorded)"]


def test_missing_samples_are_counted():
    data = response()
    data["journal_y"][10:30] = np.nan
    assert headings(figures.draw(data, {"kind": "journal_orbit"})) == ["no value at 20 of 4321 samples"]


def test_one_of_two_joints_is_named():
    (ax,) = figures.draw(response(joints=("B", "C")), {"kind": "journal_orbit", "joint": "C"}).axes
    assert "at C" in ax.get_xlabel()


def test_section_points_are_those_of_the_dataset():
    data = section(500)
    first, second = figures.draw(data).axes
    (points,) = first.lines
    np.testing.assert_allclose(points.get_xdata(), data.journal_x.values[:, 0] / CLEARANCE)
    np.testing.assert_allclose(points.get_ydata(), data.journal_y.values[:, 0] / CLEARANCE)
    (points,) = second.lines
    np.testing.assert_allclose(points.get_xdata(), 1e6 * data.eccentricity.values[:, 0])
    np.testing.assert_allclose(points.get_ydata(), 1e3 * data.normal_velocity.values[:, 0])
    assert points.get_rasterized()
    assert second.get_xlabel() == "Eccentricity (µm)"


def test_section_of_other_variables_and_windows():
    data = section(500)
    options = {"x": "contact_angle", "y": "tangential_velocity", "turns": 100, "zoom": True}
    first, second = figures.draw(data, options).axes
    np.testing.assert_allclose(second.lines[0].get_xdata(), np.degrees(data.contact_angle.values[-100:, 0]))
    assert second.get_xlabel() == "Contact angle (deg)"
    assert first.get_xlim()[1] - first.get_xlim()[0] < 2
    assert headings(figures.draw(data, {"turns": [0, 9]}))[0] == "(a) 10 crossings"


def test_section_kept_in_a_response():
    data = response()
    _, second = figures.draw(data, {"kind": "poincare_section"}).axes
    np.testing.assert_allclose(second.lines[0].get_xdata(), 1e6 * data.section_eccentricity.values[:, 0])


def test_no_crossings_is_said_in_every_panel():
    figure = figures.draw(section(0))
    assert sentences(figure) == ["The run never crossed the section"] * 2
    assert headings(figure)[0] == "(a) 0 crossings"


def test_missing_crossings_are_counted():
    data = section(50)
    data["journal_x"][3] = np.nan
    assert headings(figures.draw(data))[0] == "(a) no value at 1 of 50 crossings"


def test_a_periodic_motion_is_one_point_and_not_magnified_noise():
    first, second = figures.draw(section(200, spread=1e-12), {"zoom": True}).axes
    for ax in (first, second):
        low, high = ax.get_xlim()
        assert high - low > 0.01 * abs(low)


@pytest.mark.nightly
def test_overview_has_no_empty_panel_and_shows_every_joint():
    bare = figures.draw(response(section=False))
    assert headings(bare) == ["(a)", "(b)", "(c)"]
    assert sentences(bare) == []
    figure = figures.draw(response(joints=("B", "C")))
    assert len(figure.axes) == 7
    assert [text.get_text() for text in figure.axes[0].get_legend().get_texts()] == ["B", "C"]
    assert [ax.get_xlabel() for ax in figure.axes[1::3]] == [
        f"Journal centre at {name}, $r_x/e$" for name in "BC"
    ]
    assert len(figures.draw(response(joints=("B", "C")), joint="C").axes) == 4


def test_overview_shows_the_last_turns_and_the_whole_section():
    data = response()
    force, orbit, _, points = figures.draw(data, {"turns": 2}).axes
    assert force.lines[0].get_xdata()[0] == pytest.approx(300, abs=1)
    assert orbit.lines[0].get_xdata()[0] == data.journal_x.sel(time=0.3, method="nearest") / CLEARANCE
    assert points.lines[0].get_xdata().size == data.sizes["turn"]
