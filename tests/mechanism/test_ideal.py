"""Starts of any mechanism: found from rough angles, refused where nothing closes; refusals of loops."""

import math

import numpy as np
import pytest

from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.loops.ideal import ideal_configuration, ideal_state, placed
from jointplay.solver.mechanism.loops.kinematic_chains import Forest
from jointplay.solver.mechanism.records import Joint, Mechanism, Pin
from tests.support.wrong import only, problems_of

PAPER = catalog.chunmei2002(clearance=0, speed=40.0)


def told(mechanism, **changes):
    """The mechanism with other fields."""
    return Mechanism(**{name: getattr(mechanism, name) for name in Mechanism.model_fields} | changes)


@pytest.mark.parametrize(("branch", "coupler", "rocker"), [("upper", 0.7, 1.5), ("lower", -0.7, -1.5)])
def test_newton_finds_the_four_bar_s_closed_form(branch, coupler, rocker):
    guessed = told(PAPER, guess={"crank": 0.2, "coupler": coupler, "rocker": rocker})
    for angle in (-3.0, 0.0, 2.2, 12.0):
        found = ideal_configuration(guessed, angle, 40.0)
        angles, speeds, _ = ideal_state(PAPER, angle, 40.0, branch)
        for k in angles:
            assert found.angles[k] == pytest.approx(angles[k], abs=1e-12)
            assert found.speeds[k] == pytest.approx(speeds[k], rel=1e-11)


def test_a_mirrored_mechanism_starts_as_the_mirror_image():
    here = catalog.slider_crank(offset=0.02, clearance=0)
    there = told(catalog.slider_crank(offset=-0.02, clearance=0), drive=None)
    one = ideal_configuration(here, 0.8, 5.0)
    other = ideal_configuration(there, -0.8, -5.0)
    assert other.angles["rod"] == pytest.approx(-one.angles["rod"], abs=1e-13)
    assert other.speeds["rod"] == pytest.approx(-one.speeds["rod"], rel=1e-12)
    assert other.points["slider"] == pytest.approx(one.points["slider"] * [1, -1], abs=1e-12)


def test_clearance_moves_no_start():
    firm, loose = (assemble(catalog.slider_crank(clearance=e), {"crank_angle": 1.0}) for e in (0, 1e-4))
    assert loose.crank_angle == firm.crank_angle == 1.0
    assert len(loose.state) > len(firm.state)


def test_the_branch_that_is_guessed():
    mechanism = catalog.slider_crank(clearance=0)
    left = told(mechanism, guess={"crank": 0.0, "rod": math.pi})
    x = [ideal_configuration(each, 0.5, 1.0).points["slider"][0][0] for each in (mechanism, left)]
    middle, reach = 0.05 * math.cos(0.5), math.sqrt(0.12**2 - (0.05 * math.sin(0.5)) ** 2)
    assert x == pytest.approx([middle + reach, middle - reach], abs=1e-13)


def test_a_start_given_for_all_links_is_the_one_that_closes():
    """With angles and speeds of a mechanism that closes, points and their speeds are those of its loop."""
    here = catalog.slider_crank(offset=0.02, clearance=0)
    found = ideal_configuration(here, 0.8, 5.0)
    given = placed(here, found.angles, found.speeds)
    assert given.angles == pytest.approx(found.angles, abs=1e-12)
    assert given.speeds == pytest.approx(found.speeds, abs=1e-12)
    for link, (point, velocity) in found.points.items():
        assert given.points[link][0] == pytest.approx(point, abs=1e-12)
        assert given.points[link][1] == pytest.approx(velocity, abs=1e-11)


def test_what_does_not_close_says_how_far_it_misses():
    short = catalog.slider_crank(rod=0.04, clearance=0)
    found = only(problems_of(assemble, short, {"crank_angle": math.pi / 2}), "initial.crank_angle")
    assert "are 0.01 m apart" in found.expected
    far = catalog.slider_crank(rod=0.04, offset=0.1, clearance=0)
    found = only(problems_of(assemble, far), "mechanism.guess")
    assert "are 0.06 m apart" in found.expected


def test_a_dead_centre_is_no_start():
    dead = catalog.slider_crank(
        crank=0.05, rod=0.05 * math.sqrt(2), offset=-0.05 * (math.sqrt(2) - 1), clearance=0
    )
    found = problems_of(assemble, dead, {"crank_angle": math.pi / 2})
    assert set(found) == {"initial.crank_angle"}


def test_a_missing_guess_says_what_to_write():
    found = only(
        problems_of(assemble, told(catalog.watt(), guess={"crank": 0.0, "rod": 1.0})), "mechanism.guess"
    )
    assert "coupler, rocker, output" in found.expected
    assert "guess = { coupler = …, rocker = …, output = … }" in found.expected


def test_a_guess_of_nothing_there():
    found = problems_of(
        Mechanism, **dict(catalog.slider_crank()) | {"guess": {"road": 0.1, "G": 0.17, "B": 1.0}}
    )
    assert set(found) == {"mechanism.guess.road", "mechanism.guess.B"}
    assert "did you mean 'rod'" in found["mechanism.guess.road"].expected


def test_an_open_chain_starts_as_guessed_at_rest():
    """Two freedoms: the second link of a double pendulum stays where it was guessed."""
    arm = {"length": 1.0, "mass": 1.0, "inertia": 0.5}
    joints = [
        {"name": "O", "journal": {"link": "one"}, "bearing": {"link": "ground", "point": [0, 0]}},
        {"name": "A", "journal": {"link": "one", "at": 1.0}, "bearing": {"link": "two"}},
    ]
    double = Mechanism(links=[{"name": k} | arm for k in ("one", "two")], joints=joints, guess={"two": 0.4})
    model = assemble(double, {"crank_angle": 0.1, "crank_speed": 2.0})
    assert model.state == pytest.approx([0.1, 0.4, 2.0, 0.0], abs=1e-12)


def plate(height):
    """A driven link and a plate on three bars, one of which hangs at a height."""
    bar = {"length": 1.0, "mass": 1.0, "inertia": 0.5}
    ends = [("P", "one", None, 0.0), ("Q", "two", [2, 1], 0.5), ("R", "three", [0, height], 1.0)]
    joints = [{"name": "O", "journal": {"link": "crank"}, "bearing": {"link": "ground", "point": [0, 0]}}]
    for name, link, point, at in ends:
        base = {"link": "ground", "point": point} if point else {"link": "crank", "at": 0.3}
        joints.append({"name": name, "journal": {"link": link}, "bearing": base})
        far = {"link": "plate", "at": at}
        joints.append({"name": f"{name}2", "journal": {"link": link, "at": 1.0}, "bearing": far})
    names = ("one", "two", "three", "plate")
    links = [{"name": k} | bar for k in ("crank", *names)]
    return Mechanism(links=links, joints=joints, guess=dict.fromkeys(names, 0.5))


def test_a_plate_on_three_bars():
    """Class III: four links close together, or miss."""
    ((cut, unknowns),) = Forest.of(plate(2)).cuts
    assert {*unknowns} == {"one", "two", "three", "plate"}
    assert len(cut) == 2
    model = assemble(plate(2), {"crank_angle": 0.1})
    assert len(model.state) == 2 + model.memories == 2 + 2 * 4
    found = only(problems_of(assemble, plate(9)), "mechanism.guess")
    assert "its joints are" in found.expected


def held_twice(rockers):
    """A four-bar with more rockers than it can have, and pendulums that move instead."""
    names = [f"{word}_{i}" for word in ("rocker", "pendulum") for i in range(rockers)]
    links = [PAPER.links[2].model_copy(update={"name": name}) for name in names]
    joints = []
    for i in range(rockers):
        base, free = ({"link": "ground", "point": [x + 0.1 * i, 0.1]} for x in (0.3, 0.9))
        end = {"link": f"rocker_{i}", "at": 0.1}
        joints += [
            {"name": f"D{i}", "journal": {"link": f"rocker_{i}"}, "bearing": base},
            {"name": f"E{i}", "journal": end, "bearing": {"link": "coupler", "at": 0.05}},
            {"name": f"F{i}", "journal": {"link": f"pendulum_{i}"}, "bearing": free},
        ]
    return told(PAPER, links=(*PAPER.links, *links), joints=(*PAPER.joints, *joints))


def test_links_that_are_held_twice():
    """One more rocker and nothing is left to drive; with two, joints are superfluous."""
    found = only(problems_of(assemble, held_twice(1)), "mechanism.drive.link")
    assert "no ideal loop determines" in found.expected
    found = only(problems_of(assemble, held_twice(2)), "mechanism.joints")
    assert "hold links twice" in found.expected
    assert {*found.given} == {*"OABC", "D0", "E0", "D1", "E1"}


def test_a_driven_link_that_a_loop_determines():
    coupler = told(PAPER, drive={"kind": "speed", "link": "coupler", "speed": 1.0})
    found = only(problems_of(assemble, coupler), "mechanism.drive.link")
    assert "no ideal loop determines" in found.expected


def test_what_a_prismatic_joint_refuses():
    slider, guide = {"link": "slider"}, {"link": "ground", "point": (0.0, 0.0)}
    loose = {"name": "G", "kind": "prismatic", "journal": slider, "bearing": guide, "clearance": 1e-4}
    found = problems_of(Joint, **loose)
    assert "half length of a slider greater than 0 m" in found["joint.half_length"].expected
    assert "half height of a slider greater than 0 m" in found["joint.half_height"].expected
    assert "contact data" in found["joint.contact"].expected
    round_one = problems_of(Joint, **loose | {"clearance": 0.0, "radius": 0.01})
    assert "kind = 'revolute' only" in round_one["joint.radius"].expected
    flat = {"name": "B", "journal": slider, "bearing": guide, "half_height": 0.01}
    assert "kind = 'prismatic' only" in problems_of(Joint, **flat)["joint.half_height"].expected
    line = {"name": "G", "journal": slider | {"direction": 0.3}, "bearing": guide}
    assert "'prismatic' only" in problems_of(Joint, **line)["joint.journal.direction"].expected
    round = {"half_length": 0.02, "half_height": 0.01}
    round["contact"] = {"law": "liu", "parameters": {"length": 0.02}}
    assert "whose faces are flat" in problems_of(Joint, **loose | round)["joint.contact.law"].expected
    assert Pin(link="slider", direction=0.3).direction == 0.3


def test_a_guide_needs_rigid_links_and_with_clearance_names_of_its_own():
    plain = catalog.slider_crank(clearance={"G": 1e-4})
    fields = dict(plain)
    for clearance in ({"S": 1e-4}, {}):
        bent = problems_of(catalog.quick_return, clearance=clearance, elastic=("arm",))
        assert "a rigid link is accepted" in only(bent, "mechanism.joints[2].bearing.link").expected
    rod = plain.replace(elastic=("rod",))
    assert rod.contacts == plain.contacts
    names = {"A": "G_upper_rear"}
    joints = tuple(j.model_copy(update={"name": names.get(j.name, j.name)}) for j in plain.joints)
    found = problems_of(Mechanism, **fields | {"joints": joints})
    assert "another joint, G_upper_rear" in found["mechanism.joints[3].name"].expected


def test_a_slider_that_starts_far_from_its_guide_is_refused():
    """By the corner that is farthest out; in the middle nothing is."""
    mechanism = catalog.slider_crank(clearance={"G": 1e-4})
    words, still = ("crank", "rod", "slider"), dict.fromkeys(("crank", "rod", "slider"), 0.0)
    start = {"angle": still, "angular_velocity": still | {"crank": 200.0}}
    assert np.all(assemble(mechanism, start).state[:2] == 0.0)
    tilted = start | {"angle": dict(zip(words, (0.0, 0.0, 0.06), strict=True))}
    found = problems_of(assemble, mechanism, tilted)
    apart = 0.02 * math.sin(0.06) - 0.01 * (1 - math.cos(0.06))
    assert f"here {apart / 1e-4:.3g} clearances" in found["initial.angle"].expected


def test_the_state_of_a_slider_crank_with_play():
    """Crank given, rod free, slider free on its guide: each from the ideal mechanism."""
    model = assemble(catalog.slider_crank(), {"crank_angle": 0.6})
    angle = -math.asin(0.05 * math.sin(0.6) / 0.12)
    reach = 0.05 * math.cos(0.6) + 0.12 * math.cos(angle)
    assert model.state[:2] == pytest.approx([angle, reach], abs=1e-13)
    assert np.array_equal(model.turning, [1, 0])
