"""How the parts of a mechanism fit, and every problem at once."""

import pickle
import re

import numpy as np
import pytest
from pydantic import BaseModel

from jointplay.display.accepted import from_pydantic
from jointplay.display.errors import InputError
from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.records import Drive, Joint, Link, Mechanism, Pin, Section
from tests.support.wrong import only, problems_of

# Bad input in how the parts fit


def test_links_that_cannot_close(plain):
    plain["joints"][3]["bearing"]["point"] = [0.5, 0.0]
    problem = only(problems_of(Mechanism, **plain), "mechanism.links")
    assert problem.given == {"crank": 0.03, "coupler": 0.181, "rocker": 0.1175, "ground": 0.5}
    assert "longest shorter than the other three together" in problem.expected


def test_a_loop_that_only_lies_flat_cannot_close(plain):
    plain["joints"][3]["bearing"]["point"] = [0.03 + 0.181 + 0.1175, 0.0]
    only(problems_of(Mechanism, **plain), "mechanism.links")


def test_links_that_cannot_close_are_found_beside_a_wrong_mass(plain):
    plain["joints"][3]["bearing"]["point"] = [0.5, 0.0]
    plain["links"][0]["mass"] = -1
    assert set(problems_of(Mechanism, **plain)) == {"mechanism.links", "mechanism.links[0].mass"}


def test_a_loose_link(plain):
    plain["links"].append({"name": "spare", "length": 1, "mass": 1, "inertia": 1})
    problem = only(problems_of(Mechanism, **plain), "mechanism.links[3].name")
    assert problem.given == "spare"
    assert "ground" in problem.expected


def test_a_locked_linkage(plain):
    place = {"link": "ground", "point": [0.1, 0]}
    plain["joints"].append({"name": "D", "journal": {"link": "coupler", "at": 0.1}, "bearing": place})
    plain["joints"][2]["clearance"] = 0.0
    problem = only(problems_of(Mechanism, **plain), "mechanism.joints")
    assert problem.given == ["O", "A", "B", "C", "D"]
    assert "at most 4 ideal joints" in problem.expected
    plain["joints"][2]["clearance"] = 1e-5
    assert len(Mechanism(**plain).joints) == 5


def test_a_pendulum_is_a_mechanism():
    joint = Joint(name="O", journal=Pin(link="arm"), bearing=Pin(link="ground", point=(0, 0)))
    arm = Link(name="arm", length=1, mass=1, inertia=1)
    assert Mechanism(links=(arm,), joints=(joint,)).crank == "arm"


# Every problem at once


def test_every_problem_at_once(plain):
    plain["links"][0]["mass"] = -1.0
    plain["links"][1]["lenght"] = 0.2
    plain["links"][2]["inertia"] = 1e-3
    plain["joints"][0]["journal"]["link"] = "cranck"
    plain["joints"][2]["contact"]["stiffness"] = "stiff"
    plain["drive"]["efficiency"] = float("nan")
    plain["branch"] = "sideways"
    assert list(problems_of(Mechanism, **plain)) == [
        "mechanism.links[0].mass",
        "mechanism.links[1].lenght",
        "mechanism.links[2].inertia",
        "mechanism.joints[2].contact.stiffness",
        "mechanism.drive.efficiency",
        "mechanism.branch",
        "mechanism.joints[0].journal.link",
    ]


def test_a_wrong_link_is_not_called_missing_elsewhere(plain):
    plain["links"][0]["mass"] = -1
    only(problems_of(Mechanism, **plain), "mechanism.links[0].mass")
    plain["links"][0] |= {"mass": 0.4, "name": 7}
    only(problems_of(Mechanism, **plain), "mechanism.links[0].name")


def test_the_message_reads_as_documented(plain):
    plain["links"][0]["mass"] = -1.0
    text = "mechanism.links[0].mass: got -1.0; a mass greater than 0 kg is accepted"
    with pytest.raises(InputError, match=f"^{re.escape(text)}$"):
        Mechanism(**plain)


def test_numpy_numbers_are_numbers_and_shown_as_such():
    assert catalog.chunmei2002(clearance=np.float32(0.005), gear_ratio=np.int64(3)).drive.gear_ratio == 3.0
    with pytest.raises(InputError, match=re.escape("clearance: got -1e-5; ")):
        catalog.chunmei2002(clearance=np.float64(-1e-5))


def test_problems_keep_their_keys_inside_another_model(plain):
    class Study(BaseModel):
        mechanism: Mechanism
        section: Section
        drives: dict[str, Drive] = {}

    plain["links"][0]["mass"] = -1.0
    plain["joints"][3]["bearing"]["point"] = [0.5, 0.0]
    section = {"kind": "contact", "jont": "B"}
    drives = {"slow": {"kind": "speed", "link": "crank", "speed": 0}}
    with pytest.raises(ValueError, match="validation error") as caught:
        Study(mechanism=plain, section=section, drives=drives)
    error = from_pydantic(caught.value, Study)
    keys = [problem.key for problem in error.problems]
    assert keys == ["mechanism.links[0].mass", "mechanism.links", "section.jont", "drives.slow.speed"]
    assert "did you mean 'joint'?" in error.problems[2].expected


def test_an_error_can_be_moved_under_another_key_and_pickled(plain):
    plain["links"][0]["mass"] = -1.0
    with pytest.raises(InputError) as caught:
        Mechanism(**plain)
    moved = caught.value.under("study.mechanism")
    assert moved.problems[0].key == "study.mechanism.links[0].mass"
    again = pickle.loads(pickle.dumps(moved))
    assert str(again) == str(moved)
    assert again.under("m").problems[0].key == "m.links[0].mass"
