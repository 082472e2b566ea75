"""Links made elastic and rigid again, what is said of them, and the coupler's mass models."""

import pickle

import numpy as np
import pytest

from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.parts.beam import modal
from jointplay.solver.mechanism.records import Beam, Mechanism
from tests.mechanism.bars import COUPLER, bar
from tests.support.wrong import listed

LENGTH, MASS = COUPLER["length"], COUPLER["mass"]


def area(mass):
    """Give the area of a steel bar of the coupler's length that weighs so much, m²."""
    return mass / (7800 * LENGTH)


MASS_MODELS = {  # beyond the bar: a rotary inertia, a point mass at B, two equal end bosses, nothing
    "M0": ({}, None),
    "M1": ({"centre": (0.13783 * LENGTH / 2 + 0.03647 * LENGTH) / MASS}, area(0.13783)),
    "M2": ({}, area(0.0284)),
    "M3": ({"inertia": MASS * LENGTH**2 / 3}, None),
}


def test_named_links_bend_and_the_others_become_rigid():
    rigid = catalog.chunmei2002()
    assert rigid.elastic_links == ()
    bent = rigid.replace(elastic=("coupler", "crank"))
    assert [link.name for link in bent.elastic_links] == ["crank", "coupler"]
    assert [link.name for link in bent.replace(elastic=["rocker"]).elastic_links] == ["rocker"]
    assert bent.replace(elastic=()) == rigid
    assert bent.replace(gravity=0).replace(gravity=9.8) == bent
    assert catalog.chunmei2002(elastic=("coupler", "crank")) == bent


def test_changes_of_beams_reach_every_elastic_link_and_no_other():
    after = catalog.chunmei2002(elastic=("crank", "rocker"), elements=5, damping_ratio=0.0, order="paper")
    beams = [link.beam for link in after.links]
    assert [(beam.elements, beam.damping_ratio) for beam in beams] == [(5, 0), (None, 0.01), (5, 0)]
    assert after.order == "paper"


def test_table_1_damps_every_link():
    assert {link.beam for link in catalog.chunmei2002().links} == {Beam(shapes="sine", damping_ratio=0.01)}
    assert Beam().damping_ratio == 0


def test_elements_make_every_elastic_link_one_of_hermite_elements(plain):
    plain["links"][0] |= {"elastic": True, "beam": {"shapes": "sine", "modes": 3}}
    plain["links"][1] |= {"elastic": True}
    after = Mechanism(**plain).replace(elements=np.int64(6), damping_ratio=0.5)
    assert [(link.beam.elements, link.beam.size) for link in after.elastic_links] == [(6, 3), (6, 12)]
    assert {link.beam.shapes for link in after.elastic_links} == {"hermite"}
    assert {link.beam.damping_ratio for link in after.elastic_links} == {0.5}


@pytest.mark.parametrize("beam", [{}, {"elements": 4, "modes": 3}, {"shapes": "sine"}], ids=str)
def test_written_out_and_read_back_is_the_same(plain, beam):
    plain["links"][1] |= {"elastic": True, "beam": beam}
    plain["order"] = "paper"
    mechanism = Mechanism(**plain)
    assert Mechanism.model_validate(listed(mechanism.model_dump())) == mechanism
    assert Mechanism.model_validate_json(mechanism.model_dump_json()) == mechanism
    assert pickle.loads(pickle.dumps(mechanism)) == mechanism
    assert hash(Mechanism(**plain)) == hash(mechanism)


def test_text_forms_name_what_bends(plain):
    mechanism = catalog.chunmei2002(elastic=("coupler",), order="paper")
    assert "; elastic: coupler; " in repr(mechanism)
    lines = mechanism.summary().splitlines()
    assert lines[2].endswith("kg m², elastic: sine shapes, 4 modes, damping ratio 0.01")
    assert lines[-1].endswith("upper branch, paper order")
    assert len(lines) == 10
    rigid = catalog.chunmei2002()
    assert "elastic" not in repr(rigid) + rigid.summary()
    assert "order" not in rigid.summary()
    plain["links"][2] |= {"elastic": True, "beam": {"shapes": "sine", "modes": 3}}
    assert "elastic: sine shapes, 3 modes, damping ratio 0" in Mechanism(**plain).summary()


@pytest.mark.parametrize(
    "shapes", [{"elements": 2}, {"elements": 20}, {"shapes": "sine", "modes": 40}], ids=str
)
@pytest.mark.parametrize("model", MASS_MODELS)
def test_every_mass_model_of_the_coupler_bends(plain, model, shapes):
    data, section = MASS_MODELS[model]
    plain["links"][1] |= data | {"elastic": True, "beam": {"area": section, **shapes}}
    link = Mechanism(**plain).link("coupler")
    assert link.elastic
    assert modal(link).force @ modal(link).force < MASS


def test_bosses_leave_a_bar_that_bends_more():
    """Reading M2 bends at about 2000 rad/s where the coupler's bar bends at 4900."""
    assert modal(bar(area=MASS_MODELS["M2"][1])).frequency[0] == pytest.approx(2000, rel=0.02)


@pytest.mark.parametrize("shapes", [{"elements": 20}, {"shapes": "sine", "modes": 40}], ids=str)
def test_every_link_of_the_paper_bends_with_as_many_modes_as_there_are(plain, shapes):
    for link in plain["links"]:
        link |= {"elastic": True, "beam": shapes}
    assert len(Mechanism(**plain).elastic_links) == 3
