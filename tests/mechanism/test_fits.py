"""Fits of ISO 286 against printed tables; clearances are radial here and of diameters there."""

import pytest

import jointplay as jp
from jointplay.analysis.keywords import doubts
from jointplay.solver.mechanism.parts.fits import deviations
from tests.support.wrong import only, problems_of

# ANSI B4.2-1978 (R1994), table 12, "Preferred hole basis metric clearance fits", as in Machinery's Handbook:
# basic size in mm, fit, largest and least clearance of the diameters in mm.
HOLE_BASIS = [
    (1, "H11/c11", 0.180, 0.060),
    (1, "H9/d9", 0.070, 0.020),
    (1, "H8/f7", 0.030, 0.006),
    (1, "H7/g6", 0.018, 0.002),
    (3, "H7/h6", 0.016, 0.000),
    (4, "H11/c11", 0.220, 0.070),
    (4, "H9/d9", 0.090, 0.030),
    (5, "H8/f7", 0.040, 0.010),
    (6, "H7/g6", 0.024, 0.004),
    (6, "H7/h6", 0.020, 0.000),
]
# ANSI B4.2, "Preferred shaft basis transition and interference fits": largest and least clearance
SHAFT_BASIS = [
    (7, "K7/h6", 0.014, -0.010),
    (10, "N7/h6", 0.005, -0.019),
    (9, "P7/h6", 0.000, -0.024),
    (11, "K7/h6", 0.017, -0.012),
    (12, "N7/h6", 0.006, -0.023),
    (14, "P7/h6", 0.000, -0.029),
]
# DME, "Tables for determining metric tolerances", table 6, inside dimensions: size, class, limits in µm
HOLES = [
    (2, "K7", -10, 0), (2, "N8", -18, -4), (2, "M6", -8, -2), (5, "K8", -13, 5), (5, "N6", -13, -5),
    (25, "K6", -11, 2), (25, "K7", -15, 6), (25, "K8", -23, 10), (25, "M6", -17, -4), (25, "M8", -29, 4),
    (25, "N7", -28, -7), (25, "N8", -36, -3), (25, "JS7", -10.5, 10.5), (25, "H12", 0, 210),
    (25, "H13", 0, 330), (40, "K7", -18, 7), (40, "N6", -28, -12), (150, "K8", -43, 20), (150, "M7", -40, 0),
    (150, "N8", -67, -4), (220, "K6", -24, 5), (220, "M8", -63, 9), (220, "N7", -60, -14),
]  # fmt: skip
# K. L. Narayana, Machine Drawing, tables 15.2 and 15.3, fundamental deviations, µm: limits nearer to zero
NEARER = [
    (45, "n6", 17), (70, "p6", 32), (110, "m6", 13), (170, "n5", 27), (190, "C11", 240),
    (220, "c11", -260), (290, "D9", 190), (290, "E8", 110), (300, "f7", -56), (300, "G7", 17),
    (330, "C11", 360), (380, "d9", -210), (390, "k6", 4), (490, "c11", -480), (460, "e8", -135),
    (300, "M6", -9), (25, "P7", -14), (150, "N9", 0), (150, "M9", -15), (220, "P8", -50),
]  # fmt: skip
# Precise Metal, "Tolerance tables, round bars": the widths, in µm, of h6 to h12
WIDTHS = {
    3: (6, 10, 14, 25, 40, 60, 100), 10: (9, 15, 22, 36, 58, 90, 150), 18: (11, 18, 27, 43, 70, 110, 180),
    50: (16, 25, 39, 62, 100, 160, 250), 120: (22, 35, 54, 87, 140, 220, 350),
    300: (32, 52, 81, 130, 210, 320, 520),
}  # fmt: skip


def split(name):
    letter = name.rstrip("0123456789")
    return letter, int(name[len(letter) :])


@pytest.mark.parametrize(("size", "name", "most", "least"), HOLE_BASIS + SHAFT_BASIS)
def test_fits_leave_the_printed_clearances(size, name, most, least):
    (hole, hole_grade), (shaft, shaft_grade) = map(split, name.split("/"))
    low, high = deviations(hole, hole_grade, size)
    under, over = deviations(shaft, shaft_grade, size)
    assert (high - under, low - over) == pytest.approx((1e3 * most, 1e3 * least), abs=1e-9)
    if most + least > 0:
        found = jp.fit(name, f"{size} mm")
        assert (found.most, found.least) == pytest.approx((most / 2000, least / 2000), abs=1e-12)  # radial, m
        assert found.clearance == pytest.approx((most + least) / 4000, abs=1e-12)


@pytest.mark.parametrize(("size", "name", "low", "high"), HOLES)
def test_limits_of_holes_are_the_printed_ones(size, name, low, high):
    assert deviations(*split(name), size) == (low, high)


@pytest.mark.parametrize(("size", "name", "nearer"), NEARER)
def test_fundamental_deviations_are_the_printed_ones(size, name, nearer):
    assert min(deviations(*split(name), size), key=abs) == nearer


def test_widths_are_the_printed_ones_up_to_the_end_of_each_range():
    for size, widths in WIDTHS.items():
        assert [-deviations("h", grade, size)[0] for grade in range(6, 13)] == list(widths)
    assert deviations("h", 7, 18) != deviations("h", 7, 18.001)


def joint(**more):
    side = {"journal": {"link": "rod", "at": 0.12}, "bearing": {"link": "slider"}}
    contact = {"stiffness": 1e7, "damping": 200.0}
    return jp.Joint(**{"name": "B", "radius": "7.5 mm", "contact": contact, **side, **more})


def test_a_joint_has_half_the_difference_of_the_diameters_as_its_clearance():
    """H7 is 0 to +18 µm at 15 mm, f7 is -34 to -16 µm: the diameters differ by 16 to 52 µm, 34 on average."""
    made = joint(fit="H7/f7")
    assert made.clearance == 17e-6
    assert (made.limits.least, made.limits.most) == (8e-6, 26e-6)
    assert "(H7/f7)" in made.description
    assert joint(clearance=1e-5).limits is None
    for copy in (jp.Joint(**made.model_dump()), jp.Joint.model_validate_json(made.model_dump_json())):
        assert copy == made


def test_a_clearance_takes_the_place_of_the_fit_and_a_radius_changes_it():
    base = jp.catalog.slider_crank(clearance={"A": 1e-5})
    joints = tuple(joint(fit="H7/f7") if each.name == "B" else each for each in base.joints)
    whole = jp.Mechanism(**dict(base) | {"joints": joints})

    def changed(**changes):
        made = whole.replace(**changes)
        return made.joint("B").fit, made.joint("B").clearance

    assert changed(**{"joints.B.radius": 0.02}) == ("H7/f7", 25e-6)  # at 40 mm, 25 to 75 µm
    assert changed(**{"joints.B.fit": "H8/e8"}) == ("H8/e8", 29.5e-6)
    assert changed(**{"joints.B.clearance": 3e-5}) == (None, 3e-5)
    assert changed(clearance={"B": 3e-5, "A": 1e-5}) == (None, 3e-5)
    assert changed(clearance=0) == (None, 0.0)
    assert changed(friction=0.2) == ("H7/f7", 17e-6)
    assert whole.varied({"joints.B.clearance": 3e-5}).joint("B").clearance == 3e-5
    assert whole.varied({"joints.B.clearance": 17e-6}) == whole  # its own value changes nothing


def test_wrong_fits_are_named_with_what_would_be_accepted():
    side = {"name": "B", "journal": {"link": "rod"}, "bearing": {"link": "slider"}}
    contact = {"stiffness": 1e7, "damping": 200.0}
    for name in ("H7", "f7/H7", "H7/q6", "H4/f7", "K9/h6", "seven"):
        problem = only(problems_of(jp.Joint, **side, radius=0.01, contact=contact, fit=name), "joint.fit")
        assert problem.given == name
        assert "H7/f7" in problem.expected
        assert "grades 5 to 13" in problem.expected
    problem = only(problems_of(joint, fit="H7/p6"), "joint.fit")
    assert "differ by -29 to 0 µm" in problem.expected
    assert "500 mm" in only(problems_of(joint, fit="H7/f7", radius=0.3), "joint.radius").expected
    problem = only(problems_of(joint, fit="H7/f7", clearance="30 um"), "joint.clearance")
    assert "not both" in problem.expected
    assert "17 µm of radial clearance" in problem.expected
    found = problems_of(jp.Joint, **side, fit="H7/q6")
    assert set(found) == {"joint.fit", "joint.radius", "joint.contact"}
    assert set(problems_of(joint, fit="H7/f7", clearance="3 kg")) == {"joint.clearance"}
    guide = {"kind": "prismatic", "radius": None, "half_length": 0.01, "half_height": 0.01}
    assert "revolute" in only(problems_of(joint, fit="H7/f7", **guide), "joint.fit").expected
    assert set(problems_of(jp.fit, "H7/q6", 0.02)) == {"name"}


def test_a_fit_that_may_have_no_clearance_is_doubted():
    base = jp.catalog.slider_crank()

    def found(fit):
        joints = tuple(joint(fit=fit) if each.name == "B" else each for each in base.joints)
        return [each.key for each in doubts(jp.Mechanism(**dict(base) | {"joints": joints}), None, None)]

    assert found("H7/k6") == ["mechanism.joints[2].fit"]
    assert found("H7/g6") == []
