"""Scenes under stress are drawn as they are said to be, each by its number alone."""

import math
import tomllib
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from jointplay import catalog
from jointplay.solver.equations.friction import FRICTIONS
from jointplay.solver.equations.laws import FACTORS
from jointplay.solver.equations.laws import LAWS as EQUATIONS
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.parts.loads import Force, Spring, Torque, TorsionSpring
from jointplay.solver.mechanism.records import Mechanism
from jointplay.study.file import validate
from jointplay_lab.stress import ranges
from jointplay_lab.stress.others import ROWS, pairs, preset
from jointplay_lab.stress.scenes import CORNERS, FOUR_BARS, STARTS, VARIANTS, draw, not_drawable
from jointplay_lab.stress.stress import study_text

PRINTED = catalog.chunmei2002()
DRIVES = {"motor", "speed", "torque", "profile", "cycle"}


def journal(case):
    """The journal's place in its bearing, by the vector loop, m."""
    angle, link, joint = case.initial["angle"], case.mechanism.link, case.mechanism.joint
    ends = {name: link(name).length * np.exp(1j * angle[name]) for name in ("crank", "coupler", "rocker")}
    return ends["crank"] + ends["coupler"] - ends["rocker"] - complex(*joint("C").bearing.point)


def test_a_scene_depends_on_seed_and_number_alone():
    alone = draw(PRINTED, 77, seed=3)
    assert [draw(PRINTED, k, seed=3) for k in range(75, 79)][2] == alone
    assert draw(PRINTED, 77, seed=4) != alone
    assert draw(PRINTED, 78, seed=3).mechanism != alone.mechanism


def test_the_numbers_of_a_scene_do_not_depend_on_which_variants_there_are():
    one, other = draw(PRINTED, 90, 0, ("rigid",)), draw(PRINTED, 90, 0, ("no_tension",))
    assert one.initial == other.initial
    assert other.mechanism == one.mechanism.replace(tension=False)


def test_a_four_bar_without_contact_data_is_refused():
    table = PRINTED.model_dump()
    for joint in table["joints"]:
        joint |= {"contact": None, "friction": None, "clearance": 0.0}
    assert not_drawable(PRINTED) == []
    assert [problem.key for problem in not_drawable(Mechanism(**table))] == ["mechanism"]


def test_corners_are_every_combination_of_ends():
    seen = set()
    for k in range(CORNERS):
        joint = (drawn := draw(PRINTED, k, 0, ("rigid",)).mechanism).joint("B")
        friction = joint.friction.coefficient if joint.friction else 0.0
        seen.add(
            (
                joint.contact.stiffness,
                joint.contact.damping,
                joint.clearance,
                drawn.drive.gear_ratio,
                friction,
            )
        )
    ends = (ranges.STIFFNESS, (0.0, ranges.DAMPING[1]), ranges.CLEARANCE, ranges.GEAR_RATIO, ranges.FRICTION)
    assert len(seen) == 32
    assert all({one[i] for one in seen} == set(span) for i, span in enumerate(ends))
    beyond = draw(PRINTED, 64, 0, ("rigid",)).mechanism
    assert beyond.joint("B").clearance not in ranges.CLEARANCE
    assert beyond.drive.gear_ratio not in ranges.GEAR_RATIO


@pytest.fixture(scope="module")
def cases():
    return [draw(PRINTED, k, seed=1) for k in range(CORNERS, CORNERS + 300)]


@pytest.mark.nightly
def test_random_scenes_fill_their_ranges(cases):
    joints = [case.mechanism.joint("B") for case in cases]
    for values, span in (
        ([joint.contact.stiffness for joint in joints], ranges.STIFFNESS),
        ([joint.clearance for joint in joints], ranges.CLEARANCE),
        ([case.mechanism.drive.gear_ratio for case in cases], ranges.GEAR_RATIO),
    ):
        places = (np.log(values) - math.log(span[0])) / math.log(span[1] / span[0])
        assert 0 <= places.min() < 0.03
        assert 0.97 < places.max() <= 1
        assert places.mean() == pytest.approx(0.5, abs=0.06)
    assert {case.variant for case in cases} == set(FOUR_BARS)
    assert 0.15 < np.mean([joint.contact.damping == 0 for joint in joints]) < 0.35


@pytest.mark.long
def test_the_journal_lies_as_drawn(cases):
    for case in cases:
        r, clearance = abs(journal(case)), case.mechanism.joint("B").clearance
        inside = {
            "centre": r < 1e-15,
            "inside": r < clearance,
            "edge": math.isclose(r, clearance, rel_tol=1e-8),
        }
        assert (inside | {"deep": r > clearance})[case.start], case.number


@pytest.mark.long
def test_special_places_are_special(cases):
    for case in cases:
        crank, coupler, rocker = (case.initial["angle"][name] for name in ("crank", "coupler", "rocker"))
        if case.geometry.endswith("dead_centre"):
            away = abs(math.remainder(coupler - rocker, math.pi))
            assert away < 1e-12 if case.geometry == "dead_centre" else 1e-10 < away < 0.02
        if case.geometry == "change_point":
            p, q, s = (case.mechanism.link(name).length for name in ("crank", "coupler", "rocker"))
            g = abs(p * np.exp(1j * crank) + q * np.exp(1j * coupler) - s * np.exp(1j * rocker))
            sides = sorted([p, q, s, g])
            assert sides[0] + sides[3] == pytest.approx(sides[1] + sides[2], rel=1e-9) or p > min(q, s)


def test_change_points_lie_at_both_ends_of_the_grounds_range(cases):
    ends = []
    for case in cases:
        if case.geometry == "change_point":
            p, q, s = (case.mechanism.link(name).length for name in ("crank", "coupler", "rocker"))
            angles = [case.initial["angle"][name] for name in ("crank", "coupler", "rocker")]
            g = abs(np.exp(1j * np.array(angles)) @ [p, q, -s])
            ends += [k for k, end in enumerate((p + abs(q - s), q + s - p)) if math.isclose(g, end)]
    assert 0.3 < np.mean(ends) < 0.7


@pytest.mark.nightly
@pytest.mark.parametrize("variant", ROWS)
def test_other_laws_and_mechanisms_are_drawn_and_written_down(variant):
    """Of few compiled structures, but for the laws' names; their study lines hold the whole scene."""
    drawn = [draw(PRINTED, k, 7, (variant,)) for k in range(20)]
    laws = {(case.contact_law, case.friction_law) for case in drawn}
    assert laws <= {*pairs(variant)}
    models = [assemble(case.mechanism, case.initial, powers=True) for case in drawn]
    compiled = {
        replace(model.structure, joints=tuple(replace(joint, law="") for joint in model.structure.joints))
        for model in models
    }
    assert len(compiled) <= len(ROWS[variant])
    assert len({case.mechanism for case in drawn}) == 20
    text = study_text(drawn[0], 7, 2, 1e-8, 1000)
    record = validate({"name": "again"} | tomllib.loads(text))
    assert record.mechanism == drawn[0].mechanism
    assert record.keywords()["initial"] == drawn[0].initial


@pytest.fixture(scope="module")
def all_sorts():
    return [draw(PRINTED, k, 0, tuple(VARIANTS)) for k in range(CORNERS, CORNERS + 500)]


@pytest.mark.nightly
def test_a_series_of_all_variants_has_every_law_and_every_kind_of_joint_drive_and_load(all_sorts):
    cases, loose = all_sorts, [joint for case in all_sorts for joint in case.mechanism.clearance_joints]
    assert {joint.contact.law for joint in loose} == {*EQUATIONS}
    assert {joint.friction.law for joint in loose if joint.friction} == {*FRICTIONS}
    assert {joint.kind for joint in loose} == {"revolute", "prismatic"}
    assert {len(case.mechanism.clearance_joints) for case in cases} == {1, 2, 3}
    drives = {case.mechanism.drive.kind if case.mechanism.drive else "none" for case in cases}
    assert drives == DRIVES | {"none"}
    carried = {type(each) for case in cases for each in (*case.mechanism.springs, *case.mechanism.loads)}
    assert carried == {Spring, TorsionSpring, Force, Torque}
    links = [link for case in cases for link in case.mechanism.links]
    assert any(link.masses for link in links)
    assert {(link.elastic, link.elastic and link.beam.axial) for link in links} == {
        *[(False, False), (True, False), (True, True)]
    }


@pytest.mark.nightly
def test_every_pair_of_laws_is_as_frequent_as_any_other(all_sorts):
    rows = [(variant, laws) for variant in VARIANTS for laws in pairs(variant)]
    found = Counter(case.contact_law for case in all_sorts)
    for law in ("flores", "johnson", "restitution"):
        share = sum(laws is not None and laws[0] == law for _, laws in rows) / len(rows)
        assert found[law] / 500 == pytest.approx(share, abs=4 * math.sqrt(share / 500))


@pytest.mark.long
def test_nothing_starts_deep_where_the_law_has_no_depth():
    cases = [draw(PRINTED, k, 5, ("laws",)) for k in range(CORNERS, CORNERS + 200)]
    for case in cases:
        if case.contact_law in ("restitution", "johnson", "dubowsky_freudenstein", "liu"):
            assert abs(journal(case)) < case.mechanism.joint("B").clearance
    assert {case.start for case in cases if case.contact_law in FACTORS} == {*STARTS}


@pytest.mark.parametrize("seed", range(20))
def test_a_speed_that_swings_never_turns_back_and_a_cut_is_harder_on_the_way_in(seed):
    laws = ("kelvin_voigt", "coulomb")
    made, _ = preset(np.random.default_rng(seed), "guide", laws)
    assert 0.0 < made.drive.harmonics[0].sine < 0.8 * made.drive.constant
    made, _ = preset(np.random.default_rng(seed), "quick_return", laws)
    assert made.loads[0].harmonics[0].sine == -made.loads[0].harmonics[0].cosine / 2


def test_a_series_named_by_no_variants_is_that_of_the_four_bars():
    assert {draw(PRINTED, k).variant for k in range(CORNERS, CORNERS + 60)} == set(FOUR_BARS)
