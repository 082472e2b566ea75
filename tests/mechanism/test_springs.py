"""Records of springs, point masses and inertias: what is accepted, and where it goes."""

import pytest

import jointplay as jp
from jointplay.analysis.rules import unlike_turns
from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.parts.beam import modal
from jointplay.solver.mechanism.records import Link, Mechanism
from tests.support.wrong import listed, only, problems_of

STRAIGHT = {
    "name": "return",
    "from": {"link": "rocker", "at": 0.06},
    "to": {"link": "ground", "point": (0.25, 0.1)},
    "stiffness": 500.0,
    "free_length": 0.08,
}
TORSION = {"name": "hinge", "kind": "torsion", "from": "coupler", "to": "rocker", "stiffness": 0.4}


def test_a_catalog_entry_takes_springs_and_gravity():
    given = catalog.chunmei2002(springs=[STRAIGHT, TORSION], gravity_direction=0.5)
    assert [spring.twists for spring in given.springs] == [False, True]
    again = Mechanism(**listed(given.model_dump()))
    assert again == given
    text = given.summary()
    assert "spring return: rocker to ground, 500 N/m, free length 80 mm" in text
    assert "spring hinge: torsion, coupler against rocker, 0.4 N m/rad, free at 0 deg" in text
    assert "towards 28.65 deg" in text


def test_numbers_are_found_by_their_paths():
    given = catalog.chunmei2002(springs=[STRAIGHT, TORSION])
    assert given.varied({"springs.return.stiffness": 9.0}).springs[0].stiffness == 9.0
    assert given.varied({"springs.hinge.angle": 0.2}).springs[1].angle == 0.2
    weighted = given.link("crank").model_copy(
        update={"masses": (jp.PointMass(at=-0.01, mass=0.1, name="counterweight"),)}
    )
    fields = dict(given) | {"links": (weighted, *given.links[1:])}
    heavier = Mechanism(**fields).varied({"links.crank.masses.counterweight.mass": 0.4})
    assert heavier.link("crank").total.mass == pytest.approx(0.4489 + 0.4)


WRONG = [
    ({"from": {"link": "rokker"}}, "springs[0].from.link", "did you mean 'rocker'"),
    ({"from": {"link": "rocker", "at": 2.0}}, "springs[0].from.at", "rocker's length of 0.1175 m"),
    ({"to": {"link": "rocker"}}, "springs[0].to.link", "a link other than"),
    ({"free_length": -1.0}, "springs[0].free_length", "a free length of at least 0 m"),
    ({"kind": "bent"}, "springs[0].kind", "extension, torsion"),
    ({"lenght": 1.0}, "springs[0].lenght", "no such key"),
    ({"from": {"link": "coupler", "at": 0.1}}, "springs[0].from.at", "the ends of the elastic coupler"),
    (TORSION, "springs[0].from", "would bend it"),
    (TORSION | {"to": "coupler"}, "springs[0].to", "a link other than"),
]


@pytest.mark.parametrize(("change", "key", "expected"), WRONG)
def test_wrong_springs(change, key, expected):
    spring = change if change.get("kind") == "torsion" else STRAIGHT | change
    given = listed(catalog.chunmei2002(elastic=["coupler"]).model_dump()) | {"springs": [spring]}
    assert expected in str(only(problems_of(Mechanism, **given), f"mechanism.{key}").expected)


def test_names_are_of_one_spring_each():
    given = listed(catalog.chunmei2002().model_dump()) | {"springs": [STRAIGHT, STRAIGHT]}
    only(problems_of(Mechanism, **given), "mechanism.springs[1].name")


def test_a_torsion_spring_needs_counted_turns():
    found = problems_of(assemble, catalog.chunmei2002(clearance={}, springs=[TORSION]))
    assert list(found) == ["mechanism.springs[0].from", "mechanism.springs[0].to"]
    assemble(catalog.chunmei2002(clearance={}, springs=[TORSION | {"from": "crank", "to": "ground"}]))


def test_growth_refuses_a_torsion_spring_on_the_crank():
    given = catalog.chunmei2002(springs=[TORSION | {"from": "crank"}])
    only(problems_of(jp.growth, given), "mechanism.springs[0]")
    assert not list(unlike_turns(catalog.chunmei2002(springs=[TORSION])))


@pytest.mark.nightly
def test_analyses_of_turns_refuse_a_torsion_spring_on_the_crank():
    given = catalog.chunmei2002(springs=[TORSION | {"from": "crank"}])
    calls = [
        (jp.periodic_orbit, {}),
        (jp.lyapunov, {"turns": 3, "twin_turns": 2}),
        (jp.bifurcation, {"over": {"clearance": [1e-5, 2e-5]}}),
        (jp.continuation, {"parameter": "clearance", "range": [1e-5, 3e-5]}),
        (jp.basins, {"plane": {"eccentricity_ratio_x": [0.0, 0.5], "eccentricity_ratio_y": [0.0, 0.5]}}),
        (jp.sensitivity, {"neighbours": 2}),
    ]
    for analysis, keywords in calls:
        only(problems_of(analysis, given, **keywords), "mechanism.springs[0]")


BAR = {"name": "bar", "length": 1.0, "mass": 1.0}


@pytest.mark.parametrize("given", [{}, {"inertia": 0.5, "inertia_centre": 0.2}])
def test_one_moment_of_inertia_of_two(given):
    problem = only(problems_of(Link, **BAR, **given), "link.inertia")
    assert "one of the two, inertia (about the link's origin) and inertia_centre" in problem.expected


def test_a_small_inertia_is_told_of_the_other_key():
    problem = only(problems_of(Link, **BAR, inertia=0.1), "link.inertia")
    assert "one about the mass centre is given as inertia_centre" in problem.expected


def test_totals():
    point = {"at": -0.5, "mass": 0.5}
    link = Link(**BAR, inertia_centre=0.1, masses=[point])
    total = link.total
    assert (total.mass, total.centre, total.inertia) == pytest.approx((1.5, 0.25 / 1.5, 0.35 + 0.125))
    plain = Link(**BAR, inertia=0.5)
    assert plain.total is plain


def test_a_beam_is_of_the_link_s_own_mass():
    bent = Link(**BAR, inertia=0.4, elastic=True, masses=[{"at": 1.0, "mass": 3.0}])
    alone = Link(**BAR, inertia=0.4, elastic=True)
    assert modal(bent.total).frequency == pytest.approx(modal(alone).frequency, rel=1e-14)
    wrong = problems_of(Link, **BAR, inertia=0.4, elastic=True, masses=[{"at": 0.5, "mass": 3.0}])
    only(wrong, "link.masses[0].at")


def test_a_torsion_spring_needs_an_angle_that_is_followed():
    coil = {"kind": "torsion", "name": "coil", "from": "output", "to": "ground", "stiffness": 3.0}
    mechanism = Mechanism(**dict(catalog.watt()) | {"springs": [coil]})
    problem = only(problems_of(assemble, mechanism), "mechanism.springs[0].from")
    assert "known up to whole turns only" in problem.expected
    assert assemble(catalog.watt(springs=[coil | {"from": "crank"}]))
