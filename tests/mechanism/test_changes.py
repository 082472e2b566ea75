"""Changed copies of a mechanism, and sections that fit it."""

import numpy as np
import pytest

from jointplay.display.errors import InputError
from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.assemble import assemble, check_section
from jointplay.solver.mechanism.parameters import Parameter
from jointplay.solver.mechanism.records import (
    ConstantSpeed,
    Contact,
    ContactSection,
    CrankAngle,
    Friction,
    Mechanism,
    Plane,
    SeparationSection,
)
from jointplay.study.models import build_mechanism
from tests.support.wrong import only, problems_of

# Changes


def test_a_bare_clearance_is_joint_b_and_unnamed_joints_are_ideal():
    mechanism = catalog.chunmei2002(clearance={"A": 1e-5, "C": 2e-5})
    assert [joint.name for joint in mechanism.replace(clearance=3e-5).clearance_joints] == ["B"]
    assert mechanism.replace(clearance={"B": 0}).clearance_joints == ()
    assert mechanism.replace(clearance=0).clearance_joints == ()
    assert [joint.name for joint in mechanism.replace(gravity=0).clearance_joints] == ["A", "C"]


def test_each_change_changes_its_own_field_only():
    before = catalog.chunmei2002()
    after = before.replace(gear_ratio=3, efficiency_in_slope=True, branch="lower", gravity=0, tension=False)
    assert (after.drive.gear_ratio, after.drive.efficiency_in_slope) == (3.0, True)
    assert (after.branch, after.gravity) == ("lower", 0.0)
    assert {joint.contact.tension for joint in after.joints} == {False}
    back = after.replace(gear_ratio=15, efficiency_in_slope=False, branch="upper", gravity=9.8, tension=True)
    assert back == before
    assert before == catalog.chunmei2002()


def test_friction_is_set_everywhere_or_removed():
    mechanism = catalog.chunmei2002()
    assert {joint.friction.coefficient for joint in mechanism.replace(friction=0.2).joints} == {0.2}
    without = mechanism.replace(friction=0)
    assert {joint.friction for joint in without.joints} == {None}
    assert {joint.friction.coefficient for joint in without.replace(friction=0.3).joints} == {0.3}


def test_any_gravity_but_none_is_in_the_equations():
    mechanism = catalog.chunmei2002()
    assert assemble(mechanism.replace(gravity=1.0)).structure == assemble(mechanism).structure


def test_drive_can_be_another_one_or_none():
    mechanism = catalog.chunmei2002()
    assert mechanism.replace(speed=20).drive == ConstantSpeed(link="crank", speed=20)
    assert mechanism.replace(drive=None).drive is None
    assert mechanism.replace(drive=None).replace(speed=-5).drive.nominal_speed == -5
    assert mechanism.replace(speed=20).replace(drive=mechanism.drive, gear_ratio=3).drive.gear_ratio == 3
    assert mechanism.replace(drive={"kind": "speed", "link": "crank", "speed": 2}).drive.speed == 2


def test_a_varied_copy_is_made_once_and_is_nobody_elses():
    base = catalog.chunmei2002(clearance=1e-4)
    one = base.varied({"gear_ratio": 2.0})
    assert one == base.replace(gear_ratio=2.0)
    assert base.varied({"gear_ratio": 2.0}) is one
    assert base.varied({"gear_ratio": 3.0}) == base.replace(gear_ratio=3.0)
    assert base.varied({"gravity": 2.0}) == base.replace(gravity=2.0)
    assert base.varied({"gravity": 1}) is not base.varied({"gravity": 1.0})
    assert base.varied({"tension": True}) == base
    with pytest.raises(InputError):
        base.varied({"tension": 1})
    wider = base.replace(clearance=2e-4)
    assert wider.varied({"gear_ratio": 2.0}) == wider.replace(gear_ratio=2.0)


def test_a_count_may_be_varied_by_floats():
    bent = catalog.chunmei2002(elastic=("coupler",))
    assert bent.varied({"elements": 4.0}) == bent.replace(elements=4)
    with pytest.raises(InputError):
        bent.varied({"elements": 4.5})


def test_every_wrong_change_at_once():
    changes = {
        "clearence": 1e-5,
        "clearance": {"B": -1.0, "Q": 1e-5},
        "gear_ratio": "fast",
        "friction": -0.1,
        "tension": 1,
        "gravity": float("nan"),
        "branch": "left",
        "speed": 0,
    }
    found = problems_of(catalog.chunmei2002().replace, **changes)
    assert set(found) == {*changes, "clearance.B"} - {"clearance"}
    assert "did you mean 'clearance'?" in found["clearence"].expected


@pytest.mark.parametrize(
    ("changes", "key", "words"),
    [
        ({"clearance": -1e-5}, "clearance", "radial clearance of at least 0 m"),
        ({"clearance": "wide"}, "clearance", "as a number"),
        ({"clearance": float("nan")}, "clearance", "of at least 0 m"),
        ({"clearance": {"D": 1e-5}}, "clearance.D", "accepted: O, A, B, C"),
        (
            {"speed": 3, "gear_ratio": 3},
            "gear_ratio",
            "only for a motor drive, and this drive is of kind 'speed'",
        ),
        ({"drive": None, "efficiency_in_slope": True}, "efficiency_in_slope", "drive, and there is no drive"),
        ({"speed": 3, "drive": None}, "speed", "not both"),
        (
            {"joints.B.clearance": 1e-5, "joints[2].clearance": 2e-5},
            "joints[2].clearance",
            "either this or joints.B.clearance, which is the same, is accepted, not both",
        ),
        ({"speed": 0}, "speed", "other than 0"),
        ({"drive": {"kind": "speed", "link": "crank"}}, "drive.speed", "speed in rad/s"),
        ({"drive": {"kind": "speed", "link": "rod", "speed": 1}}, "mechanism.drive.link", "accepted: crank"),
        ({"elastick": ("coupler",)}, "elastick", "did you mean 'elastic'?"),
    ],
)
def test_one_wrong_change(changes, key, words):
    problem = only(problems_of(catalog.chunmei2002().replace, **changes), key)
    assert words in problem.expected


def test_a_part_without_a_name_is_known_by_its_number():
    plain = catalog.chunmei2002().model_dump(exclude_none=True)
    plain["links"][0]["masses"] = [{"mass": 0.1, "at": 0.02}, {"mass": 0.2, "at": 0.01}]
    mechanism = Mechanism(**plain)
    found = mechanism.replace(**{"links.crank.masses[0].mass": 0.3, "links[0].masses[1].mass": 0.4})
    assert [each.mass for each in found.link("crank").masses] == [0.3, 0.4]
    wrong = problems_of(
        mechanism.replace, **{"links.crank.masses[0].mass": 0.3, "links[0].masses[0].mass": 0.4}
    )
    assert "links.crank.masses[0].mass" in only(wrong, "links[0].masses[0].mass").expected


def test_changes_that_find_nothing_to_change(plain):
    for joint in plain["joints"]:
        del joint["contact"], joint["friction"]
        joint["clearance"] = 0
    mechanism = Mechanism(**plain)
    found = problems_of(mechanism.replace, friction=0.1, tension=False, clearance=1e-5)
    assert set(found) == {"friction", "tension", "clearance.B"}


def test_what_is_offered_is_what_is_then_accepted():
    """Of a slider-crank neither a motor's gear nor a beam's elements, and a link that it has."""
    found = problems_of(catalog.slider_crank, gear_rato=3.0, order="paper")
    assert not {"gear_ratio", "elements", "order"} & {*str(found["gear_rato"].expected).split(", ")}
    assert "elastic = ['rod']" in found["order"].expected
    assert "elements" in problems_of(catalog.slider_crank, elemnts=3, elastic=("rod",))["elemnts"].expected


def test_of_several_plays_each_is_offered_by_its_path():
    mechanism = catalog.chunmei2002(clearance={"B": 1e-4, "C": 1e-4})
    said = str(only(problems_of(Parameter.named, key="clearnce", mechanism=mechanism), "clearnce").expected)
    assert ".clearance'? These are accepted: joints.B.clearance, joints.C.clearance" in said


# Sections


@pytest.mark.parametrize(
    "section",
    [
        CrankAngle(),
        CrankAngle(angle=1),
        ContactSection(),
        ContactSection(joint="B"),
        SeparationSection(joint="B"),
        Plane(quantity="eccentricity", joint="B", value=1e-5, direction="down"),
        Plane(quantity="angle", link="rocker", value=1),
    ],
)
def test_sections_that_a_mechanism_has(section):
    check_section(section, catalog.chunmei2002())


@pytest.mark.parametrize(
    ("section", "clearance", "key", "words"),
    [
        (ContactSection(joint="B"), {"B": 0}, "section.joint", "joint B is ideal (clearance 0)"),
        (SeparationSection(joint="A"), 1e-5, "section.joint", "accepted: B"),
        (ContactSection(), 0, "section.joint", "every joint here is ideal"),
        (ContactSection(joint="D"), 1e-5, "section.joint", "accepted: O, A, B, C"),
        (Plane(quantity="eccentricity", joint="B", value=0), 0, "section.joint", "joint with clearance"),
        (Plane(quantity="angle", link="rokcer", value=0), 0, "section.link", "did you mean 'rocker'?"),
    ],
)
def test_sections_that_a_mechanism_cannot_have(section, clearance, key, words):
    mechanism = catalog.chunmei2002(clearance=clearance)
    problem = only(problems_of(check_section, section, mechanism), key)
    assert words in problem.expected


def test_several_that_change_alike_are_replaced_by_the_key_that_varies_them():
    key = "links.coupler.length + joints.B.journal.at"
    given = catalog.chunmei2002()
    assert given.replace(**{key: 0.19}) == given.varied({key: 0.19})
    with pytest.raises(InputError, match="a number in SI units is accepted for several together"):
        given.replace(**{key: "190 mm"})


def test_a_fit_and_another_clearance_at_once_are_refused():
    changes = {"joints.B.fit": "H7/f7", "joints.B.radius": "7.5 mm", "joints.B.clearance": "10 um"}
    with pytest.raises(InputError, match=r"clearance: got '10 um'; either fit or clearance is accepted"):
        catalog.slider_crank(clearance={"B": 1e-4}).replace(**changes)


@pytest.mark.parametrize("word", ["30 um", {"B": 3e-5}])
@pytest.mark.parametrize("path", ["joints.B.fit", "joints.B.clearance"])
@pytest.mark.parametrize("make", [catalog.slider_crank, catalog.slider_crank().replace, catalog.chunmei2002])
def test_a_clearance_by_word_and_by_path_is_refused(make, path, word):
    by_path = {path: "H7/f7" if path.endswith("fit") else 2e-5}
    problem = only(problems_of(make, clearance=word, **by_path), f"clearance{'.B' * isinstance(word, dict)}")
    assert f"either clearance or {path}" in problem.expected


def test_strange_keywords_and_values_are_wrong_ones():
    problems_of(catalog.stephenson, self=3)
    problems_of(catalog.slider_crank, clearance=1e-5, self=3)
    problems_of(catalog.slider_crank, clearance=np.array([1.0, 2.0]))


def test_an_entrys_own_clearance_gives_way_to_one_by_path():
    fitted = catalog.slider_crank(**{"joints.B.fit": "H7/f7"})
    assert fitted.joint("B").fit == "H7/f7"
    others = catalog.slider_crank(clearance={"A": 1e-5}, **{"joints.B.fit": "H7/f7"})
    assert (others.joint("A").clearance, others.joint("B").fit) == (1e-5, "H7/f7")


BAR = {"bar": {"width": "30 mm", "thickness": "6 mm"}, "material": "steel"}
MASS = 0.12 * 0.03 * 0.006 * 7850  # of it between two pins 120 mm apart


def test_a_shape_in_the_place_of_an_entrys_numbers_gives_all_that_it_says():
    rod = catalog.slider_crank(**{"links.rod.shape": BAR}).link("rod")
    assert rod.mass == pytest.approx(MASS)
    assert rod.centre == 0.06
    assert rod.inertia == pytest.approx(MASS * ((0.12**2 + 0.03**2) / 12 + 0.06**2), rel=1e-12)
    wide = BAR | {"bar": {"width": 0.04, "thickness": 0.006}}
    steel = catalog.chunmei2002(**{"links.coupler.shape": wide}).link("coupler")
    assert steel.beam.area == pytest.approx(0.04 * 0.006)
    assert steel.beam.density == 7850


@pytest.mark.parametrize("given", [{"mass": {"rod": 0.5}}, {"links.rod.mass": 0.5}])
def test_what_is_given_by_hand_beside_a_shape_stays(given):
    rod = catalog.slider_crank(**given, **{"links.rod.shape": BAR}).link("rod")
    assert rod.mass == 0.5
    assert rod.inertia == pytest.approx(0.5 * ((0.12**2 + 0.03**2) / 12 + 0.06**2), rel=1e-12)
    whole = catalog.slider_crank(**{"links.rod.shape": BAR})
    assert whole.replace(**{"links.rod.shape.bar.width": 0.04}).link("rod").mass == pytest.approx(
        MASS * 4 / 3
    )


def test_a_part_that_is_not_there_is_made_of_its_numbers():
    smooth = catalog.slider_crank(friction=0)
    rough = smooth.replace(**{"joints.B.friction.coefficient": 0.1})
    assert rough.joint("B").friction == Friction(coefficient=0.1)
    assert rough.joint("A").friction is None
    contact = {"joints.A.contact.stiffness": 1e7, "joints.A.contact.damping": "100 N s/m"}
    loose = catalog.flores2010().replace(**{"joints.A.radius": 0.01, "joints.A.clearance": 1e-5}, **contact)
    assert loose.joint("A").contact == Contact(stiffness=1e7, damping=100.0)
    wrong = {"joints.A.radius": 0.01, "joints.A.clearance": 1e-5, "joints.A.contact.stiffness": -1}
    problems = problems_of(catalog.flores2010().replace, **wrong)
    assert "joints.A.contact.stiffness" in problems


def test_another_law_with_its_numbers_takes_the_place_of_the_one_there_is():
    law = {"joints.B.contact.law": "flores", "joints.B.contact.stiffness": 1e9}
    law["joints.B.contact.parameters.restitution"] = 0.8
    found = catalog.slider_crank().replace(**law).joint("B").contact
    assert found == Contact(law="flores", stiffness=1e9, parameters={"restitution": 0.8})
    same = catalog.slider_crank().replace(
        **{"joints.B.contact.law": "kelvin_voigt", "joints.B.contact.stiffness": 1e8}
    )
    assert same.joint("B").contact == Contact(stiffness=1e8, damping=200.0)
    rubs = {"joints.B.friction.law": "stribeck", "joints.B.friction.coefficient": 0.1}
    problems = problems_of(catalog.slider_crank().replace, **rubs)
    assert {*problems} == {
        f"joints.B.friction.{name}" for name in ("static_coefficient", "stribeck_velocity")
    }


def test_a_fit_or_a_shape_that_is_taken_away_leaves_its_numbers():
    given = {"joints": {"B": {"fit": "H7/f7"}}, "links": {"rod": {"shape": BAR}}}
    drawn = catalog.slider_crank(**given)
    assert drawn == catalog.slider_crank().replace(**given)
    plain = drawn.replace(**{"joints.B.fit": None, "links.rod.shape": None})
    assert (plain.joint("B").fit, plain.link("rod").shape) == (None, None)
    assert plain.joint("B").clearance == drawn.joint("B").clearance
    assert plain.link("rod").mass == drawn.link("rod").mass
    assert plain.link("rod").inertia == drawn.link("rod").inertia


def test_tables_of_an_entry_take_whole_shapes_and_laws():
    table = {"catalog": "slider_crank", "links": {"rod": {"shape": BAR}}}
    table["joints"] = {"B": {"contact": {"law": "hertz", "stiffness": 1e9}, "fit": "H7/f7"}}
    found = build_mechanism(table)
    assert found.link("rod").mass == pytest.approx(MASS)
    assert found.joint("B").contact.law == "hertz"
    table["links"]["rod"]["shape"] = BAR | {"material": "stele"}
    problem = only(problems_of(build_mechanism, table), "links.rod.shape.material")
    assert "did you mean 'steel'" in problem.expected


@pytest.mark.parametrize("order", [1, -1])
def test_a_number_and_what_would_be_below_it_are_refused(order):
    keys = ["joints.B.friction.coefficient", "joints.B.friction.coefficient.law"]
    problems = problems_of(catalog.slider_crank(friction=0).replace, **dict.fromkeys(keys[::order], 0.1))
    assert [*problems] == keys[1:]


def test_a_path_through_what_is_not_there_says_so():
    key = "links.rod.shape.bar.width"
    problem = only(problems_of(Parameter.named, catalog.slider_crank(), key), key)
    assert problem.expected == "nothing is accepted: links.rod.shape has no parts here"
