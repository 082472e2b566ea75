"""A slider's corner is drawn in the gap of its guide: its way to the face over the slide, in clearances."""

import numpy as np
import pytest

from jointplay import figures
from tests.figures.support.synthetic import CLEARANCE, response


def of_a_guide(slides=True):
    """A response whose first joint is a corner."""
    data = response()
    names = ["G_lower_front", *map(str, data["joint"].values[1:])]
    data = data.assign_coords(joint=("joint", names, data["joint"].attrs))
    if slides:
        slide = np.broadcast_to(np.linspace(0.07, 0.17, data.sizes["time"])[:, None], data["journal_x"].shape)
        told = {"units": "m", "long_name": "distance of a slider along its guide"}
        data["slide_position"] = (("time", "joint"), slide, told)
    return data


def test_a_corner_is_on_its_way_to_its_face():
    data = of_a_guide()
    (ax,) = figures.draw(data, {"kind": "journal_orbit"}).axes
    contact = next(line for line in ax.lines if line.get_label() == "contact")
    x, y = contact.get_data()
    touching = data["mode"].values[:, 0] > 0
    recorded = np.isin(x, 1e3 * data["slide_position"].values[:, 0])  # the path is smooth in between
    ways = data["eccentricity"].values[touching, 0] / CLEARANCE
    np.testing.assert_array_equal(y[recorded & np.isfinite(y)], ways)
    faces = [line.get_ydata()[0] for line in ax.lines if np.ptp(line.get_ydata()) == 0]
    assert faces == [1.0, -1.0]
    assert ax.get_ylim()[1] > max(1.0, ways.max())
    assert ax.get_xlabel() == "Distance of a slider along its guide (mm)"
    assert not any(hasattr(patch, "radius") for patch in ax.patches)  # no clearance circle


def test_without_its_slide_a_corner_is_drawn_over_the_time():
    (ax,) = figures.draw(of_a_guide(slides=False), {"kind": "journal_orbit"}).axes
    assert ax.get_xlabel().startswith("Time")


@pytest.mark.parametrize("joint", ["G_lower_front", None])
def test_an_overview_has_the_gap(joint):
    sheet = figures.draw(of_a_guide(), {"kind": "overview"} | ({"joint": joint} if joint else {}))
    labels = [ax.get_ylabel().replace("\n", " ") for ax in sheet.axes]
    assert any("Distance of lower front corner of G" in label for label in labels)


def test_an_overview_names_what_it_has_no_room_for():
    joints = ["B", "G_upper_front", "G_upper_rear", "G_lower_front", "G_lower_rear"]
    data = of_a_guide().isel(joint=[0] * 5).assign_coords(joint=joints)
    titles = [ax.get_title(loc="left") for ax in figures.draw(data, {"kind": "overview"}).axes]
    assert titles[0].replace("\n", " ") == "(a) without lower rear corner of G"


def test_a_corner_has_words_in_legends():
    corners = ["G_lower_front", "G_upper_rear"]
    data = of_a_guide().isel(joint=[0, 0]).assign_coords(joint=corners)
    ax = figures.draw(data, {"kind": "time_history", "variables": "normal_force"}).axes[0]
    assert ax.get_legend_handles_labels()[1] == ["lower front corner of G", "upper rear corner of G"]
    given = {"kind": "time_history", "variables": "normal_force", "joint": "G_lower_front"}
    (ax, *_) = figures.draw(data, given).axes
    assert ax.get_ylabel().replace("\n", " ").startswith("Normal contact force, lower front")
