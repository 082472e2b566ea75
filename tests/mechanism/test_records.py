"""Records: what they hold, and each wrong value named by its key path."""

import os
import pickle
import subprocess
import sys

import pytest

from jointplay.display.errors import NOTHING
from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.assemble import linkage
from jointplay.solver.mechanism.records import Contact, Friction, Joint, Link, Mechanism, Pin, System
from tests.support.wrong import only, problems_of

# Round trips and what a record is


def test_written_out_and_read_back_is_the_same(plain):
    mechanism = catalog.chunmei2002()
    assert Mechanism.model_validate(plain) == mechanism
    assert Mechanism.model_validate_json(mechanism.model_dump_json()) == mechanism
    assert pickle.loads(pickle.dumps(mechanism)) == mechanism
    assert hash(Mechanism(**plain)) == hash(mechanism)


def test_records_are_frozen():
    mechanism = catalog.chunmei2002()
    with pytest.raises(ValueError, match="does not change"):
        mechanism.gravity = 0.0


def test_mass_centre_is_halfway_unless_given():
    assert Link(name="bar", length=0.4, mass=1, inertia=1).centre == 0.2
    assert Link(name="bar", length=0.4, mass=1, inertia=1, centre=-0.1).centre == -0.1


def test_all_mass_in_one_point_is_no_link():
    accepted = "greater than mass × centre² = 1 kg m²"
    problem = only(problems_of(Link, name="bar", length=2, mass=1, inertia=1), "link.inertia")
    assert accepted in problem.expected


def test_a_link_may_be_massive_beyond_its_pins_but_its_pins_lie_on_it(plain):
    plain["joints"][2]["journal"]["at"] = 0.182
    problem = only(problems_of(Mechanism, **plain), "mechanism.joints[2].journal.at")
    assert problem.given == 0.182
    assert "0.181 m" in problem.expected


def test_lookups_by_name():
    mechanism = catalog.chunmei2002()
    assert mechanism.link("rocker").length == 0.1175
    assert mechanism.joint("B").clearance == 2.9e-5
    assert [joint.name for joint in mechanism.clearance_joints] == ["B"]
    problem = only(problems_of(mechanism.link, "rockr"), "link")
    assert "did you mean 'rocker'?" in problem.expected


def test_text_forms_are_short_and_name_the_parts():
    mechanism = catalog.chunmei2002(clearance={"A": 1e-5, "C": 2e-5})
    assert repr(mechanism) == (
        "<Mechanism chunmei2002: crank, coupler, rocker; clearance: A 10 µm, C 20 µm; "
        "drive: motor, gear ratio 15, crank at 16.7552 rad/s without load>"
    )
    lines = mechanism.summary().splitlines()
    assert len(lines) == 10
    assert any("joint C" in line and "20 µm" in line and "friction 0.01" in line for line in lines)


# Bad input in one place


@pytest.mark.parametrize(
    ("path", "bad", "key", "words"),
    [
        (("links", 0, "mass"), -1.0, "links[0].mass", "a mass greater than 0 kg is accepted"),
        (("links", 0, "mass"), 0, "links[0].mass", "a mass greater than 0 kg is accepted"),
        (
            ("links", 0, "mass"),
            "heavy",
            "links[0].mass",
            "greater than 0 kg, as a number or a text with its unit such as '3 kg', is accepted",
        ),
        (("links", 0, "mass"), "0.4", "links[0].mass", "as a number"),
        (("links", 0, "mass"), True, "links[0].mass", "as a number"),
        (
            ("links", 1, "length"),
            float("inf"),
            "links[1].length",
            "a length greater than 0 and at most 1e9 m",
        ),
        (("links", 1, "inertia"), float("nan"), "links[1].inertia", "greater than 0 kg m²"),
        (
            ("links", 2, "centre"),
            float("nan"),
            "links[2].centre",
            "a distance of the mass centre of at least -1e9 and at most 1e9 m",
        ),
        (("links", 1, "inertia"), 1.4e-3, "links[1].inertia", r"mass × centre² = 0.00142756 kg m²"),
        (("links", 1, "name"), "ground", "links[1].name", "other than 'ground'"),
        (("links", 2, "name"), "crank", "links[2].name", "no other"),
        (("joints", 3, "name"), "B", "joints[3].name", "no other"),
        (("joints", 1, "journal", "link"), "cranc", "joints[1].journal.link", "did you mean 'crank'?"),
        (("joints", 1, "journal", "at"), -0.01, "joints[1].journal.at", "of at least 0 m"),
        (("joints", 0, "bearing", "at"), 0.1, "joints[0].bearing.at", "point = [x, y]"),
        (("joints", 0, "bearing", "point"), [0, "a"], "joints[0].bearing.point[1]", "finite numbers in m"),
        (("joints", 1, "bearing", "point"), [0, 0], "joints[1].bearing.point", "only link = 'ground'"),
        (("joints", 2, "bearing", "link"), "coupler", "joints[2].bearing.link", "other than the journal's"),
        (("joints", 2, "clearance"), -2.9e-5, "joints[2].clearance", "radial clearance of at least 0 m"),
        (("joints", 2, "radius"), 0.0, "joints[2].radius", "journal radius greater than 0 m"),
        (("joints", 2, "contact", "law"), "kelvin", "joints[2].contact.law", "'kelvin_voigt'"),
        (("joints", 2, "contact", "stiffness"), 0, "joints[2].contact.stiffness", "greater than 0 N/m"),
        (("joints", 2, "contact", "damping"), -1, "joints[2].contact.damping", "of at least 0 N s/m"),
        (("joints", 2, "contact", "tension"), "no", "joints[2].contact.tension", "true or false"),
        (("joints", 2, "friction", "coefficient"), -0.1, "joints[2].friction.coefficient", "at least 0"),
        (("drive", "kind"), "moter", "drive.kind", "did you mean 'motor'? These are accepted: motor, speed"),
        (("drive", "efficiency"), 1.5, "drive.efficiency", "greater than 0 and at most 1"),
        (("drive", "efficiency"), 0.0, "drive.efficiency", "greater than 0 and at most 1"),
        (("drive", "gear_ratio"), 0, "drive.gear_ratio", "a gear ratio greater than 0"),
        (("drive", "rated_speed"), 400.0, "drive.rated_speed", "less than the synchronous 314.159 rad/s"),
        (("drive", "link"), "rod", "drive.link", "accepted: crank, coupler, rocker"),
        (("drive",), 15.0, "drive", "a table of kind 'motor' or 'speed'"),
        (("gravity",), "9.8", "gravity", "a finite gravity in m/s²"),
        (("branch",), "uper", "branch", "one of 'upper', 'lower'"),
        (("links",), [], "links", "at least one"),
        (("links", 1), 3, "links[1]", "a table of name, length, shape, mass, centre, inertia_centre"),
        (("drive", "kind"), ["motor"], "drive.kind", "accepted: motor, speed"),
        (("links",), "crank", "links", "a list of at least one link"),
        (("joints",), [], "joints", "at least one"),
    ],
)
def test_one_wrong_value(plain, path, bad, key, words):
    place = plain
    for step in path[:-1]:
        place = place[step]
    place[path[-1]] = bad
    problem = only(problems_of(Mechanism, **plain), f"mechanism.{key}")
    if isinstance(bad, float):
        assert problem.given == pytest.approx(bad, nan_ok=True)
    assert words in problem.expected


@pytest.mark.parametrize(
    ("path", "wrong", "key", "right"),
    [
        ((), "gravty", "gravty", "gravity"),
        (("links", 1), "lenght", "links[1].lenght", "length"),
        (("joints", 2), "clearence", "joints[2].clearence", "clearance"),
        (("joints", 2, "contact"), "stifness", "joints[2].contact.stifness", "stiffness"),
        (("joints", 2, "bearing"), "lnk", "joints[2].bearing.lnk", "link"),
        (("drive",), "gear_ration", "drive.gear_ration", "gear_ratio"),
    ],
)
def test_unknown_key(plain, path, wrong, key, right):
    place = plain
    for step in path:
        place = place[step]
    place[wrong] = 3
    problem = only(problems_of(Mechanism, **plain), f"mechanism.{key}")
    assert problem.given == 3
    assert f"did you mean {right!r}?" in problem.expected


def test_missing_values(plain):
    del plain["links"][0]["mass"], plain["joints"][0]["bearing"]["point"], plain["drive"]["kind"]
    found = problems_of(Mechanism, **plain)
    assert set(found) == {
        "mechanism.links[0].mass",
        "mechanism.joints[0].bearing.point",
        "mechanism.drive.kind",
    }
    assert all(problem.given is NOTHING for problem in found.values())


def test_clearance_needs_radius_and_contact(plain):
    for key in ("radius", "contact"):
        del plain["joints"][2][key]
    found = problems_of(Mechanism, **plain)
    assert set(found) == {"mechanism.joints[2].radius", "mechanism.joints[2].contact"}
    plain["joints"][2]["clearance"] = 0
    assert Mechanism(**plain).clearance_joints == ()


def test_contact_data_with_clearance_0_is_an_ideal_joint():
    joint = Joint(
        name="J",
        journal=Pin(link="a"),
        bearing=Pin(link="b"),
        contact=Contact(stiffness=1e6, damping=0),
        friction=Friction(coefficient=0.1),
        clearance=0,
    )
    assert joint.clearance == 0


@pytest.mark.parametrize(
    ("friction", "law"),
    [
        (Friction(coefficient=0.0), "none"),
        (Friction(law="tanh", coefficient=0.0, velocity=1e-3), "none"),
        (
            Friction(law="stribeck", coefficient=0.0, static_coefficient=0.1, stribeck_velocity=1e-3),
            "stribeck",
        ),
    ],
)
def test_friction_without_a_coefficient_is_none_in_the_equations(friction, law):
    loose = catalog.chunmei2002(clearance=1e-4)
    joints = [each.model_copy(update={"friction": friction}) for each in loose.joints]
    (joint,) = linkage(loose.model_copy(update={"joints": tuple(joints)})).joints
    assert joint.friction == law


def test_wrong_test_system():
    found = problems_of(System, name="a", system=3, parameters={"x": "3"}, states={"x": True}, rates=0)
    assert set(found) == {f"system.{key}" for key in ("system", "parameters.x", "states.x", "rates")}


def test_records_load_nothing_heavy():
    def loaded(modules):
        run = [sys.executable, "-c", f"import sys, {modules}; print(*sys.modules)"]
        paths = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
        return set(subprocess.run(run, capture_output=True, text=True, check=True, env=paths).stdout.split())

    heavy = {"numba", "xarray", "matplotlib", "sympy", "scipy"}
    assert not heavy & loaded("jointplay.solver.mechanism.catalog, jointplay.solver.mechanism.loops.ideal")
    assert "pydantic" not in loaded("jointplay.display.errors, jointplay.solver.mechanism")
