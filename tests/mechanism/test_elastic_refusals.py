"""Elastic links that cannot be, each refused with its key, what was given and what is accepted."""

import math
import re

import pytest

from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.records import Beam, Link, Mechanism
from tests.mechanism.bars import COUPLER, bar
from tests.support.wrong import only, problems_of

COUPLER_BENDS = {"elastic": ("coupler",)}


@pytest.mark.parametrize(
    ("beam", "key", "words"),
    [
        ({"elements": 0}, "elements", "from 1 to 20, each longer than 0"),
        ({"elements": 21}, "elements", "from 1 to 20"),
        ({"elements": 2.0}, "elements", "a whole number of elements"),
        ({"elements": True}, "elements", "a whole number of elements"),
        ({"elements": "two"}, "elements", "a whole number of elements"),
        ({"modes": 5}, "modes", "at most 4 modes, two an element"),
        ({"elements": 3, "modes": 7}, "modes", "at most 6 modes, two an element"),
        ({"modes": 0}, "modes", "a whole number of modes from 1 to 40"),
        ({"shapes": "sine", "modes": 41}, "modes", "a whole number of modes from 1 to 40"),
        ({"shapes": "sine", "elements": 2}, "elements", "elements are accepted with shapes = 'hermite'"),
        ({"shapes": "cosine"}, "shapes", "one of 'hermite', 'sine'"),
        ({"damping_ratio": 1.01}, "damping_ratio", "from 0 to 1 (critical"),
        ({"damping_ratio": -0.01}, "damping_ratio", "from 0 to 1 (critical"),
        ({"damping_ratio": math.nan}, "damping_ratio", "from 0 to 1 (critical"),
        ({"modulus": 0}, "modulus", "a Young's modulus greater than 0 Pa"),
        ({"density": -1.0}, "density", "a density greater than 0 kg/m³"),
        ({"area": 0.0}, "area", "an area of the section greater than 0 m²"),
        ({"second_moment": math.inf}, "second_moment", "second moment of area greater than 0 m⁴"),
        ({"section": "oval"}, "section", "one of 'round', 'square'"),
        ({"gauge": 0}, "gauge", "greater than 0 and less than 1"),
        ({"gauge": 1.0}, "gauge", "greater than 0 and less than 1"),
        ({"mode": 3}, "mode", "did you mean 'modes'?"),
    ],
)
def test_one_wrong_value_of_a_beam(plain, beam, key, words):
    given = beam[key]
    problem = only(problems_of(Beam, **beam), f"beam.{key}")
    assert words in problem.expected
    assert problem.given is given or math.isnan(given)
    plain["links"][2]["beam"] = beam  # wrong data are refused while they rest unused, too
    only(problems_of(Mechanism, **plain), f"mechanism.links[2].beam.{key}")


def test_a_beam_heavier_than_its_link():
    problem = only(problems_of(bar, area=2e-4), "link.beam.area")
    assert problem.given == 2e-4
    assert "this beam weighs 0.28236 kg, the whole link 0.1743 kg" in problem.expected
    limit = float(re.search(r"less than (\S+) m²", problem.expected)[1])
    assert bar(area=limit * (1 - 1e-5)).elastic
    assert "link.beam.area" in problems_of(bar, area=limit * (1 + 1e-5))
    assert "link.beam.area" in problems_of(bar, area=1.5 * limit, shapes="sine")


@pytest.mark.parametrize(
    "shapes", [{"elements": 2}, {"elements": 20}, {"shapes": "sine", "modes": 3}], ids=str
)
def test_inertia_too_small_for_its_beam(shapes):
    problem = only(problems_of(bar, COUPLER | {"inertia": 1.5e-3}, **shapes), "link.inertia")
    assert problem.given == 1.5e-3
    assert "mass matrix is not positive definite" in problem.expected
    limit = float(re.search(r"greater than (\S+) kg m²", problem.expected)[1])
    assert 1.5e-3 < limit < COUPLER["mass"] * COUPLER["length"] ** 2 / 3, "of a uniform bar it is enough"
    assert bar(COUPLER | {"inertia": limit * (1 + 1e-5)}, **shapes).elastic
    only(problems_of(bar, COUPLER | {"inertia": limit * (1 - 1e-5)}, **shapes), "link.inertia")
    assert Link(**COUPLER | {"inertia": 1.5e-3}).elastic is False, "a rigid link needs no more"


def test_a_mass_centre_too_far_out_for_its_beam():
    only(problems_of(bar, COUPLER | {"centre": 0.12}), "link.inertia")
    assert Link(**COUPLER | {"centre": 0.12}).centre == 0.12


@pytest.mark.parametrize(
    "beam",
    [
        {"modulus": 1e300, "second_moment": 1e10},
        {"second_moment": 1e-320, "modulus": 1e-300},
        {"density": 1e-300, "area": 1e-300},
    ],
    ids=str,
)
def test_frequencies_that_are_not_finite(beam):
    problem = only(problems_of(bar, **beam), "link.beam")
    assert "finite frequencies other than 0" in problem.expected
    assert problem.given.items() >= beam.items()


@pytest.mark.parametrize(
    ("joint", "side", "link"),
    [(1, "bearing", "coupler"), (2, "journal", "coupler"), (3, "journal", "rocker")],
)
def test_pins_of_an_elastic_link_sit_at_its_ends(plain, joint, side, link):
    plain["joints"][joint][side]["at"] = 0.05
    for bent in plain["links"]:
        bent["elastic"] = bent["name"] == link
    problem = only(problems_of(Mechanism, **plain), f"mechanism.joints[{joint}].{side}.at")
    assert problem.given == 0.05
    length = {"coupler": "0.181", "rocker": "0.1175"}[link]
    assert f"0 or {length} m, the ends of the elastic {link}," in problem.expected


def test_a_pin_beyond_an_elastic_link_is_named_once(plain):
    plain["links"][1]["elastic"] = True
    plain["joints"][2]["journal"]["at"] = 0.2
    only(problems_of(Mechanism, **plain), "mechanism.joints[2].journal.at")


@pytest.mark.parametrize(
    ("changes", "key", "words"),
    [
        (
            {"elastic": ("copler",)},
            "elastic[0]",
            "did you mean 'coupler'? These are accepted: crank, coupler, rocker",
        ),
        ({"elastic": ("coupler", "ground")}, "elastic[1]", "accepted: crank, coupler, rocker"),
        ({"elastic": ("coupler", 3)}, "elastic[1]", "a list of link names"),
        ({"elastic": "coupler"}, "elastic", "a list of link names"),
        ({"elastic": True, "elements": 3}, "elastic", "a list of link names"),
        ({"elastic": ("copler",), "elements": 3}, "elastic[0]", "no such link"),
        (COUPLER_BENDS | {"elements": 0}, "elements", "from 1 to 20, each longer than 0"),
        (COUPLER_BENDS | {"damping_ratio": 1.5}, "damping_ratio", "from 0 to 1 (critical"),
        (COUPLER_BENDS | {"order": "second"}, "order", "one of 'consistent', 'paper'"),
        ({"elements": 3}, "elements", "only where a link is elastic, and none is"),
        ({"damping_ratio": 0.1}, "damping_ratio", "only where a link is elastic, and none is"),
        ({"order": "paper"}, "order", "only where a link is elastic, and none is"),
        ({"elastic": (), "elements": 3}, "elements", "only where a link is elastic, and none is"),
    ],
)
def test_one_wrong_change(changes, key, words):
    problem = only(problems_of(catalog.chunmei2002, **changes), key)
    assert words in problem.expected


def test_a_change_that_a_beam_cannot_bear_names_its_place(plain):
    plain["links"][1] |= {"elastic": True, "beam": {"elements": 4, "modes": 7}, "inertia": 1.9e-3}
    problem = only(problems_of(Mechanism(**plain).replace, elements=3), "mechanism.links[1].beam.modes")
    assert (problem.given, "at most 6 modes" in problem.expected) == (7, True)
    plain["links"][2] |= {"inertia": 1.1e-3}
    problem = only(problems_of(Mechanism(**plain).replace, elastic=("rocker",)), "mechanism.links[2].inertia")
    assert problem.given == 1.1e-3


def test_everything_wrong_is_said_at_once(plain):
    plain["links"][0] |= {"elastic": True, "beam": {"elements": 0, "damping_ratio": 2}}
    plain["links"][1] |= {"elastic": True, "beam": {"area": 1e-3}}
    plain["links"][2] |= {"elastic": True}
    plain["joints"][3]["journal"]["at"] = 0.01
    plain["order"] = "third"
    assert set(problems_of(Mechanism, **plain)) == {
        "mechanism.links[0].beam.elements",
        "mechanism.links[0].beam.damping_ratio",
        "mechanism.links[1].beam.area",
        "mechanism.joints[3].journal.at",
        "mechanism.order",
    }


def test_a_wrong_name_hides_no_other_wrong_change():
    changes = {"elastic": ("coupler", 3), "clearance": {"Q": 1e-5}, "damping_ratio": 2}
    found = problems_of(catalog.chunmei2002, **changes)
    assert set(found) == {"elastic[1]", "clearance.Q", "damping_ratio"}


def test_pins_of_a_rigid_link_sit_anywhere(plain):
    plain["joints"][2]["journal"]["at"] = 0.15
    assert Mechanism(**plain).joint("B").journal.at == 0.15
