"""Records are not changed, and the catalog lists what it holds and nothing else."""

import pickle

import pytest
from pydantic import model_validator

import jointplay as jp
from jointplay.solver.mechanism.base import Record
from jointplay.solver.mechanism.catalog import NAMES


def test_a_record_that_is_set_says_what_to_do():
    mechanism = jp.catalog.chunmei2002()
    with pytest.raises(jp.InputError, match=r"clearance: got 3; .*replace\(\)"):
        mechanism.clearance = 3
    with pytest.raises(jp.InputError, match=r"mass: got 1\.0"):
        mechanism.links[0].mass = 1.0
    assert pickle.loads(pickle.dumps(mechanism)) == mechanism == mechanism.model_copy()


def test_a_record_lists_what_it_describes():
    mechanism = jp.catalog.chunmei2002()
    assert {"joints", "drive", "replace", "summary"} < set(dir(mechanism))
    assert not {"parse_raw", "model_dump", "copy", "validate"} & set(dir(mechanism))
    assert [name for name in dir(jp.CrankAngle()) if name[0] != "_"] == ["angle", "kind", "root"]


def test_the_catalog_lists_its_entries():
    assert dir(jp.catalog) == sorted(NAMES)


def own(*loose, named=str, with_data="OABC"):
    """The paper's linkage with other names and with clearance, and contact data, at some joints alone."""
    paper = jp.catalog.chunmei2002()
    data = {name: dict(paper.joint(name)) for name in "OABC"}
    joints = [
        {key: value for key, value in each.items() if name in with_data or key not in ("contact", "radius")}
        | {"name": named(name), "clearance": 1e-4 if name in loose else 0.0}
        for name, each in data.items()
    ]
    return jp.Mechanism(links=paper.links, joints=joints, drive=paper.drive)


def test_a_bare_clearance_is_that_of_the_joint_that_can_have_one():
    for mechanism, name in (
        (own("C", named=lambda name: f"J{name}"), "JC"),
        (own("C", with_data="C"), "C"),
        (own(named=lambda name: f"J{name}", with_data="A"), "JA"),
        (own("B", "C"), "B"),
    ):
        assert mechanism.replace(clearance=2e-4).joint(name).clearance == 2e-4, name


def test_where_several_can_the_paths_that_work_are_named():
    with pytest.raises(jp.InputError, match=r"joint B has no radius.*joints\.A\.clearance, joints\.C\.clear"):
        own("A", "C", with_data="AC").replace(clearance=2e-4)


@pytest.mark.parametrize("name", ["main crank", "crank-1", "a*b", " crank"])
def test_a_name_that_no_symbol_can_have_is_refused(name):
    link = dict(jp.catalog.chunmei2002().links[0]) | {"name": name}
    with pytest.raises(jp.InputError, match=r"link\.name: got .*letters, digits and _"):
        jp.Link(**link)
    assert jp.Link(**link | {"name": "Kurbel_ä1"}).name == "Kurbel_ä1"


@pytest.mark.parametrize(("kind", "shown"), [(3, "3"), (None, "None"), ("moter", "'moter'")])
def test_a_kind_is_told_as_it_was_given(kind, shown):
    with pytest.raises(jp.InputError, match=rf"drive\.kind: got {shown}; there is no such kind"):
        jp.catalog.chunmei2002().replace(drive={"kind": kind, "link": "crank"})


def test_what_a_record_says_of_all_its_fields_is_asked_once_by_either_door():
    """Where a class has an `__init__`, pydantic goes through the validators of a table twice."""
    asked = []

    class Asked(Record):
        number: int

        @model_validator(mode="after")
        def _noted(self):
            asked.append(self.number)
            return self

    assert Asked.model_validate({"number": 1}) == Asked(number=1)
    assert asked == [1, 1]
