"""A mechanism as a picture: where its parts are, how much bearings are enlarged, names that can be read."""

from itertools import combinations

import numpy as np
import pytest
from matplotlib.patches import Circle
from matplotlib.path import Path

from jointplay import catalog, figures
from jointplay.display.errors import InputError
from jointplay.solver.mechanism.records import Mechanism
from jointplay.solver.mechanism.start import start_pose


def linkage(lengths, joints, **more):
    """Links of lengths in mm, pins or guides between two of them at places in mm; the crank turns."""
    links = [
        {"name": name, "length": 1e-3 * size, "mass": 0.1, "inertia_centre": 1e-5}
        for name, size in lengths.items()
    ]

    def end(link, at, **direction):
        place = {"point": [1e-3 * each for each in at]} if link == "ground" else {"at": 1e-3 * at}
        return {"link": link} | place | direction

    parts = [
        {"name": name, "journal": end(*journal), "bearing": end(*bearing)}
        for name, journal, bearing in joints
    ]
    for name, angle in more.pop("guides").items():
        part = next(each for each in parts if each["name"] == name)
        part["kind"] = "prismatic"
        part["bearing"]["direction"] = angle
    drive = {"kind": "speed", "link": "crank", "speed": 10.0}
    return Mechanism(name="own", links=links, joints=parts, drive=drive, **more)


def yoke():
    joints = [("O", ("crank", 0), ("ground", (0, 0))), ("P", ("crank", 25), ("block", 0))]
    joints += [("S", ("block", 0), ("yoke", 0)), ("G", ("yoke", 0), ("ground", (0, 0)))]
    guides, guess = (
        {"S": "-90 deg", "G": "90 deg"},
        {"crank": 0, "block": 0, "yoke": "90 deg", "S": 0, "G": 0},
    )
    return linkage({"crank": 25, "block": 20, "yoke": 100}, joints, guides=guides, guess=guess)


def toggle():
    joints = [("O", ("crank", 0), ("ground", (0, 0))), ("A", ("crank", 30), ("rod", 0))]
    joints += [("K", ("rod", 180), ("upper", 120)), ("U", ("upper", 0), ("ground", (210, 110)))]
    joints += [("L", ("upper", 120), ("lower", 0)), ("R", ("lower", 120), ("ram", 0))]
    joints += [("G", ("ram", 0), ("ground", (210, 0)))]
    guess = {"crank": 0, "rod": 0, "upper": "-100 deg", "lower": "-80 deg", "ram": "90 deg"}
    lengths = {"crank": 30, "rod": 180, "upper": 120, "lower": 120, "ram": 60}
    return linkage(lengths, joints, guides={"G": "90 deg"}, guess=guess)


SCENES = {
    "four-bar": lambda: catalog.chunmei2002(clearance={"B": 2.9e-4, "C": 2.9e-5}, elastic=("coupler",)),
    "slider-crank": lambda: catalog.slider_crank(clearance={"B": 1e-4}),
    "six-bar": lambda: catalog.stephenson(),
    "quick return": lambda: catalog.quick_return(),
    "Scotch yoke": yoke,
    "toggle press": toggle,
}
SPRINGS = [
    {
        "name": "return",
        "from": {"link": "rocker", "at": 0.06},
        "to": {"link": "ground", "point": [0.25, 0.1]},
        "stiffness": 500.0,
        "free_length": 0.08,
    },
    {"name": "hinge", "kind": "torsion", "from": "coupler", "to": "rocker", "stiffness": 0.4},
]
PUSH = {
    "name": "push",
    "kind": "force",
    "on": {"link": "rocker", "at": 0.1},
    "direction": 0.0,
    "constant": 9.0,
}


@pytest.mark.parametrize("scene", SCENES)
def test_joints_of_the_pose_are_closed(scene):
    mechanism: Mechanism = SCENES[scene]()
    pose = start_pose(mechanism, {"crank_angle": 0.7})
    for joint in mechanism.joints:
        gap = pose.point(joint.journal) - pose.point(joint.bearing)
        if joint.prismatic:
            angle = pose.direction(joint.bearing)
            gap = gap @ [-np.sin(angle), np.cos(angle)]
            assert pose.direction(joint.journal) == pytest.approx(angle, abs=1e-12)
        assert np.abs(gap).max() < 1e-12
    assert pose.angles[mechanism.crank] == 0.7


@pytest.mark.parametrize("scene", SCENES)
def test_everything_is_named_and_no_name_lies_on_another(scene):
    mechanism = SCENES[scene]()
    figure = figures.draw(mechanism)
    boxes = {each.get_text(): each.get_window_extent() for each in figure.axes[0].texts}
    assert {*boxes} >= {part.name for part in (*mechanism.links, *mechanism.joints)}
    for (one, a), (other, b) in combinations(boxes.items(), 2):
        assert not a.shrunk(0.7, 0.7).overlaps(b.shrunk(0.7, 0.7)), (one, other)


@pytest.mark.parametrize("scene", SCENES)
def test_no_name_lies_on_what_is_drawn(scene):
    ax = figures.draw(SCENES[scene]()).axes[0]
    drawn = [
        Path(line)
        for each in (*ax.lines, *ax.patches)
        for line in each.get_path().to_polygons(each.get_transform(), closed_only=False)
    ]
    for text in ax.texts:
        if text.get_rotation() == 0.0:
            box = text.get_window_extent()
            box = box.shrunk(0.8, 0.6).translated(0.1 * box.width, 0.2 * box.height)
            assert not any(path.intersects_bbox(box, filled=False) for path in drawn), text.get_text()


def test_springs_loads_and_what_drives_are_told():
    figure = figures.draw(catalog.chunmei2002(springs=SPRINGS, loads=[PUSH]))
    assert {"return", "hinge", "push", "$g$"} <= {each.get_text() for each in figure.axes[0].texts}
    assert [line.split(":")[0] for line in figure.get_supxlabel().split("\n")] == [
        "Drive",
        "return",
        "hinge",
        "push",
    ]


@pytest.mark.parametrize("width", [100.0, 146.0])
def test_bearings_are_as_much_enlarged_as_is_told(width):
    mechanism = SCENES["four-bar"]()
    figure = figures.draw(mechanism, width=width)
    assert len(figure.axes) == 3
    for ax, joint in zip(figure.axes[1:], mechanism.clearance_joints, strict=True):
        clearance = next(patch for patch in ax.patches if isinstance(patch, Circle))
        drawn = clearance.get_window_extent().width / 2 / figure.dpi * 25.4e-3
        told = float(ax.texts[0].get_text().split(", ")[1].removesuffix(" : 1"))
        assert told == pytest.approx(drawn / joint.clearance, rel=0.06)


def test_a_mechanism_has_no_other_figures_and_a_result_not_this_one():
    mechanism = SCENES["six-bar"]()
    for options in ({"kind": "journal_orbit"}, {"crank_angle": "x"}, {"names": 1}, {"joint": "B"}):
        with pytest.raises(InputError):
            figures.draw(mechanism, options)
    with pytest.raises(InputError, match="or a mechanism is accepted"):
        figures.draw("r.nc")


def test_names_are_left_out():
    texts = [each.get_text() for each in figures.draw(SCENES["six-bar"](), names=False).axes[0].texts]
    assert texts == ["$g$"]


def test_a_guide_with_clearance_has_its_block_and_faces_to_scale():
    mechanism = catalog.slider_crank(clearance={"G": 1e-3}, offset=0.02)
    guide, angle = mechanism.joint("G"), 0.6
    ax, inset = figures.draw(mechanism, crank_angle=angle).axes
    lean = np.arcsin((0.02 - 0.05 * np.sin(angle)) / 0.12)
    B = 1e3 * np.array([0.05 * np.cos(angle) + 0.12 * np.cos(lean), 0.02])
    around = 1e3 * np.array(
        [(s * guide.half_length, t * guide.half_height) for s in (1, -1) for t in (1, -1)]
    )
    assert any(
        {tuple(p) for p in np.round(each.get_xy(), 6)} == {tuple(p) for p in np.round(B + around, 6)}
        for each in ax.patches
        if hasattr(each, "get_xy")
    )
    level = [line.get_ydata() for line in ax.lines if np.ptp(line.get_xdata()) > 2e3 * guide.half_length]
    faces = [y[0] for y in level if len(y) == 2 and np.ptp(y) == 0]
    away = 1e3 * (guide.half_height + guide.clearance)
    assert sorted(faces) == pytest.approx([20.0 - away, 20.0 + away])
    assert inset.get_title() == "G: slider on ground"


@pytest.mark.parametrize("width", [100.0, 146.0])
def test_a_guide_is_as_much_enlarged_as_is_told(width):
    mechanism = catalog.slider_crank(clearance={"G": 1e-4})
    guide = mechanism.joint("G")
    ax = figures.draw(mechanism, width=width).axes[1]
    block = next(each for each in ax.patches if len(each.get_xy()) == 5).get_window_extent()
    low, high = sorted(line.get_window_extent().y0 for line in ax.lines if np.ptp(line.get_ydata()) == 0)
    paper = 25.4e-3 / ax.figure.dpi
    told = [float(each.split()[1]) for each in ax.texts[0].get_text().split("\n")[1].split(", ")]
    assert told[0] == pytest.approx((high - block.y1) * paper / guide.clearance, rel=0.06)
    assert told[0] == pytest.approx((block.y0 - low) * paper / guide.clearance, rel=0.06)
    assert told[1] == pytest.approx(block.width / 2 * paper / guide.half_length, rel=0.06)
