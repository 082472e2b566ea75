"""The page of an assessment: every number of it, in units and words; the commands on it run."""

import re
import shlex

import numpy as np
import pytest

import jointplay as jp
from jointplay.analysis.assessment.assess import OUTPUTS, assembled, first_change
from jointplay.analysis.assessment.curves import ratios
from jointplay.analysis.assessment.page import BY, GRADES, answer, commands, grade, over_ideal, page
from jointplay.analysis.labels import ended
from jointplay.analysis.quantities import STATUS
from jointplay.display.number_text import measure
from jointplay.study.file import load
from tests.figures.support.synthetic_assessment import (
    KEYS,
    LOOSE,
    NAMES,
    NAN,
    SIDES,
    assessment,
    motion,
    side,
)

QUIET = {"traits": np.array([0, 0, 0]), "separations": np.array([0.0]), "impact_speed": np.array([0.0])}


def test_forces_stand_by_their_joints_though_the_answers_order_them_otherwise():
    found = assessment()
    assert found["joint"].values.tolist() == ["O", "A", "B", "C"]
    assert found["peak_force"].values.tolist() == [22.0, 24.0, 20.0, 26.0]  # of B, O, A, C
    assert found["ideal_peak_force"].values.tolist() == [10.0, 11.0, 12.0, 13.0]
    assert found["force_ratio"].values == pytest.approx([2.2, 24 / 11, 20 / 12, 2.0])
    assert np.isnan(found["separations"].values).tolist() == [True, True, False, True]


def test_the_page_says_each_number_with_its_error():
    text = page(assessment().assign_attrs(title="My press"), "press.toml")
    lines = [re.sub(" +", " ", line.strip()) for line in text.splitlines()]
    assert lines[0] == "My press"
    worked = "joint O carries up to 22 N, 2.2 times as much as with ideal joints"
    assert f"Rattles: joint B loses contact twice a turn and hits at 50 mm/s; {worked}." in lines
    repeats = "the motion repeats every turn, contact is lost in each."
    assert f"The crank turns at 62.83 rad/s (600 rpm); {repeats}" in lines
    kept = "at a radial clearance of joint B below 150 µm, or at a gear ratio above 5"
    assert f"Loss of contact stops {kept}." in lines
    assert "Largest joint forces (±: numerical error)" in lines
    assert "O ideal 22.00 ± 0.10 10.00 ± 0.10 2.2" in lines
    assert "B 200 µm 20.00 ± 0.10 12.00 ± 0.10 1.67" in lines
    assert "B 2 90 % 50 mm/s 10.00 ± 0.10 20.00 ± 0.10 400.00 ± 0.10" in lines
    rest = "(the difference is stored, or goes elsewhere)"
    assert f"check: losses together 30.00 ± 0.14 mJ; the drive gives 31 mJ {rest}" in lines
    assert "jointplay assess press.toml" in lines


def test_every_joint_that_loses_contact_is_named():
    found = assessment()
    found["separations"][:], found["impact_speed"][:] = [0.0, 1.0, 2.0, 1.5], [np.nan, 0.02, 0.05, np.nan]
    said = "joint B loses contact twice a turn and hits at 50 mm/s, joint A once a turn and at 20 mm/s, "
    assert f"Rattles: {said}joint C 1.5 times a turn; joint O carries up to 22 N" in answer(found)


def test_the_commands_of_a_page_name_the_file_of_its_study():
    assert "  jointplay assess press.toml\n" in page(assessment().assign_attrs(study="press"))
    assert "  jointplay assess STUDY.toml\n" in page(assessment())


def test_the_page_says_where_the_motion_changes_and_where_not():
    lines = [re.sub(" +", " ", line.strip()) for line in page(assessment()).splitlines()]
    grazing = "150.00 ± 0.15 µm 25 % 148.5 µm and 151.5 µm grazing of the orbit"
    assert f"contact is kept: radial clearance of joint B, below {grazing}" in lines
    assert "below: not met down to 100 µm: period 1 is lost, chaos begins" in lines
    doubled = "260.00 ± 0.26 µm 30 % 257.4 µm and 262.6 µm period doubling"
    assert f"period 1 is lost: radial clearance of joint B, above {doubled}" in lines
    assert "above: not met up to 300 µm, where it stopped: step_limit: contact is kept" in lines
    assert any(line.startswith("chaos begins: gear ratio, above 4.5000 ± 0.0045 (") for line in lines)
    jump = next(line for line in lines if line.endswith("rpm) 33.3 % 3.96 and 4.04 fold of the orbit"))
    assert jump.startswith("the motion ends in a fold and jumps to another: gear ratio, above 4.0")
    assert any(line.endswith("settled motions; back to the present behaviour by 5.5") for line in lines)
    assert (
        "motions looked at: 50 values below, 1.4 % apart on average; 50 values above, 0.81 % apart on average"
        in lines
    )
    assert "What begins and ends between two neighbouring values is not seen." in lines


def test_changes_stand_by_what_they_change_and_the_nearest_first():
    lines = [re.sub(" +", " ", line.strip()) for line in page(assessment()).splitlines()]
    heads = ("contact is kept: ", "period 1 is lost: ", "the motion ends in a fold", "chaos begins: ")
    found = [(i, line) for line in lines for i, head in enumerate(heads) if line.startswith(head)]
    assert [i for i, _ in found] == [0, 0, 1, 2, 3, 3]
    away = [float(re.search(r"([0-9.]+) % ", line)[1]) for _, line in found]
    assert away[0] < away[1]
    assert away[4] < away[5]
    rows = [line for line in lines if "not met" in line or "→" in line][:4]
    assert ["not met" in row for row in rows] == [False, False, True, True]


def test_a_force_that_is_rounding_beside_the_others_has_no_ratio():
    ratio = over_ideal(np.array([[20.0, 2e-5, 3e-14, 5.0]]), np.array([[10.0, 1e-5, 1e-14, 0.0]]))
    assert ratio[0] == pytest.approx([2.0, 2.0, NAN, NAN], nan_ok=True)
    found = assessment()
    found["force_ratio"] = found["force_ratio"].where(found["joint"] == "A")
    text = re.sub(" +", " ", page(found))
    assert "O ideal 22.00 ± 0.10 10.00 ± 0.10 \N{EN DASH}" in text
    assert "joint A carries up to 24 N, 2.18 times as much as with ideal joints" in text


def test_windows_are_counted_and_warn_of_others():
    lines = [re.sub(" +", " ", line.strip()) for line in page(assessment()).splitlines()]
    told = "2 windows narrower than 1 % in the result; others may have been missed"
    assert [line for line in lines if "window" in line] == [f"below: {told}"]


def test_the_page_says_what_the_verdict_hangs_on():
    """The force at B is 20 N, and 2 N more with each variant; contact is lost from the third one on."""
    lines = [re.sub(" +", " ", line.strip()) for line in page(assessment()).splitlines()]
    told = lines.index("joint B: kelvin voigt, 7.15 × 10⁶ N/m, 228 N s/m; friction 0.01")
    assert lines[told + 1] == "given: stiffness, damping, friction"
    assert "as given rattles 20 1.67 2.2 (O) 2 50 mm/s 1" in lines
    assert "stiffness ×10 quiet 22 1.83 2.2 (O) 0 \N{EN DASH} 1" in lines
    assert "friction ×2 hammers 30 2.5 3 (O) 1 20 mm/s 1" in lines
    band = (
        "With other contact data the largest force at B is 20 N to 30 N and the grade from quiet to hammers"
    )
    assert f"{band}; friction matters most" in lines


@pytest.mark.parametrize(
    ("load", "told"),
    [
        (None, "too stiff: that is its stiffness at 900 N"),
        ("35 N", None),
        ("3 N", "too soft: that is its stiffness at 3 N"),
        ("5 N", None),
    ],
)
def test_a_stiffness_at_another_force_than_the_joint_carries_is_named(load, told):
    """Ideal joint B carries 12 N; a pressure of 5 MPa on its bush is 900 N."""
    contact = {"pin": "steel", "bush": "bronze", "length": "12 mm"} | ({"load": load} if load else {})
    mechanism = jp.catalog.chunmei2002(clearance=2e-4, gear_ratio=3.0)
    mechanism = mechanism.varied({"joints.B.radius": 0.0075, "joints.B.contact": contact})
    found = assessment(mechanism=mechanism)
    lines = [line.strip() for line in page(found).splitlines()]
    rest = ', an ideal joint carries 12 N at most; write load = "12 N" beside pin and bush'
    assert [line for line in lines if line.startswith("too ")] == ([told + rest] if told else [])


def test_the_page_says_what_to_do():
    lines = [re.sub(" +", " ", line.strip()) for line in page(assessment()).splitlines()]
    assert "radial clearance of joint B, below not met down to 20 µm" in lines
    change = "about 280 µm 40 % touches → hammers B → O 20 N → 30 N 1.6 → 3.1 50 mm/s → 120 mm/s"
    assert f"radial clearance of joint B, above {change}" in lines
    best = "Of single changes, half the radial clearance of joint B helps most"
    assert (at := lines.index(f"{best}: it lowers the largest ratio"))
    assert lines[at + 1] == "to ideal forces from 2.2 to 1"
    assert lines[at + 2].endswith("twice the friction: 3)")


def test_a_curve_says_where_contact_is_kept_beyond_a_harder_grade():
    """The grade changes to a harder one first, and no edge of contact is known."""
    found = assessment(sides=[side(1e-4), side(3e-4), side(1.5), side(6.0)])
    found["curve_grade"][:] = GRADES.index("hammers")
    found["grade_change_grade"][:] = GRADES.index("hammers")
    assert "Contact is lost at all values that were looked at" in page(found)
    found["curve_grade"][0, 2] = GRADES.index("quiet")
    value = found["curve_ratio"].values[0, 2] * 200
    assert re.search(rf"Loss of contact stops at .* below about {value:.3g}", page(found))


def test_a_curve_that_was_cut_short_says_of_how_many_values_it_is():
    found = assessment()
    count = found.sizes["value"]
    assert f"among the {count} values of the curve" in page(found)
    found["curve_status"][0, 5:] = STATUS.index("not_run")
    assert f"among the 5 to {count} of {count} values of the curve" in page(found)
    found["curve_status"][1, 5:] = STATUS.index("not_run")
    assert f"among the 5 of {count} values of the curve" in page(found)
    assert "(the same command goes on with what was not looked at)" in page(found)


def test_a_curve_that_failed_as_a_whole_says_how_it_ended():
    found = assessment()
    found["curve_status"][0] = STATUS.index("crashed")
    lines = page(found).splitlines()
    assert "  radial clearance of joint B: stopped: crashed" in lines
    assert not any(re.match(r"  radial clearance of joint B, (below|above) +not met", line) for line in lines)


def test_what_has_not_settled_is_counted_and_helps_nothing():
    found = assessment()
    assert "are not known" not in page(found)
    assert "half the radial clearance of joint B" in page(found)
    found["variant_peak_force"][1:3] = np.nan
    found["curve_grade"][0] = (*GRADES, "unknown").index("unknown")
    text = page(found)
    assert "matters most; 2 of 6 are not known" in text
    assert "half the radial clearance of joint B" not in text


def test_where_forces_are_those_of_ideal_joints_nothing_helps():
    found = assessment(**QUIET)
    found["force_ratio"] = found["force_ratio"] * 0 + 1.001
    assert "  Forces are those of ideal joints: there is nothing to lower\n" in page(found)
    found["force_ratio"] = found["force_ratio"] * 0 + 0.5
    assert "0.5 times as much as with ideal joints" in answer(found)
    assert "nothing to lower" not in page(found)


def test_without_ideal_forces_there_are_no_ratios_and_the_speed_decides_the_grade():
    found = assessment()
    for name in ("force_ratio", "ideal_peak_force", "curve_ideal_peak_force"):
        found[name] = found[name] * np.nan
    assert "joint B loses contact" in answer(found)
    assert "ideal joints" not in answer(found).splitlines()[0]
    assert "Single changes: with ideal joints there are no forces to compare with" in page(found)
    assert [GRADES[grade(True, np.nan, speed)] for speed in (0.005, 0.05, 0.2)] == [
        "touches",
        "rattles",
        "hammers",
    ]


def edge_at(ratio, before, after):
    """Places beside the edge of contact, as a change of the grade."""
    return np.array([[ratio, mark, 0, 10.0, 1.2, 0.001, BY.index("edge")] for mark in (before, after)])


@pytest.mark.parametrize(("edge", "nearer"), [(1.2, True), (1.5, False), (1.4, True), (1.409, True)])
def test_the_grade_changes_at_the_nearer_one_of_an_edge_and_what_is_found_among_values(edge, nearer):
    """Among values it is found between 1.39 and 1.4 times the present one; what lies so close is the same."""
    coarse = np.array([[1.39, 0, 0, 10.0, 1.2, 0.0, 1], [1.4, 1, 0, 11.0, 1.3, 0.002, 1]])
    found, missing = edge_at(edge, 0, 1), np.array([coarse[0], np.full(7, np.nan)])
    assert first_change(coarse, found) is (found if nearer else coarse)
    below = coarse ** np.array([-1, *[1] * 6])
    assert first_change(below, edge_at(1 / edge, 0, 1))[1, 0] == (1 / edge if nearer else 1 / 1.4)
    assert first_change(missing, found) is found
    assert first_change(coarse, None) is coarse


def test_both_parts_of_the_page_say_one_value():
    """Among values the grade changes at 280 µm; the edge, at which it does, lies nearer."""
    near = side(3e-4, (2.1e-4, NAN, NAN), ("grazing", "not_met", "not_met"))
    near["beside"] = edge_at(1.05, 0, 1)
    text = page(assessment(sides=[SIDES[2], near, *SIDES[2:]], **QUIET))
    lines = [re.sub(" +", " ", line.strip()) for line in text.splitlines()]
    change = "210 µm 5 % quiet → touches B 10 N 1.2 1 mm/s"
    assert f"radial clearance of joint B, above {change}" in lines
    lost = "Contact is first lost at a radial clearance of joint B above 210 µm, or at a gear ratio"
    assert any(line.startswith(lost) for line in lines)


def test_what_is_found_among_values_alone_says_so():
    text = page(assessment(sides=4 * [{"status": 7}], settled=0, **QUIET))
    told = "a radial clearance of joint B above about 280 µm, not settled, or at a gear ratio above about 6"
    found = "about: among the 49 values of the curve and some more, not refined as edges are"
    assert f"Contact is first lost at {told} ({found})." in text
    assert f"about, not met{found.removeprefix('about')}; a narrow range" in text
    assert "not settled" not in page(assessment())


def test_a_result_of_a_version_that_knew_less_is_told_too():
    """Of 0.1.0: all changes of the grade were among values, and no force of a stiffness was stored."""
    older = assessment(**QUIET).drop_vars(["grade_change_by", "stiffness_load", "contact_sources"])
    assert answer(older)
    assert "about" in page(older)
    assert "write load" not in page(older)


def test_a_harder_grade_farther_on_is_named():
    found = assessment()
    assert "hammers at" not in page(found)
    found["curve_grade"][1, 10] = 3
    told = f"gear ratio, below: hammers at {3 * ratios(KEYS[1])[10]:.3f}"
    assert f"{told}\n" in page(found)
    found["curve_period"][1, 10] = 0
    assert f"{told}, not seen to repeat\n" in page(found)


def test_contact_lost_in_another_motion_than_the_one_followed_is_named():
    text = page(assessment(sides=[SIDES[2], side(3e-4), side(1.5), side(6.0)], **QUIET))
    told = "above: contact is lost at about 280 µm in a motion begun anew"
    assert f"{told}: in a narrow range, or beside the one followed" in text


def test_it_says_how_slowly_a_motion_settles_and_why():
    """A multiplier of 0.99: to 1/e in 99.5 turns of 0.1 s."""
    found = assessment(motion={"radius": 0.99})
    found["friction_coefficient"] = found["friction_coefficient"] * 0.0
    lines = [line.strip() for line in page(found).splitlines()]
    assert "It settles slowly: what disturbs it shrinks by 1 % a turn," in lines
    assert "to a third in 99 turns (9.95 s)." in lines
    assert any(
        line.startswith("There is no friction at joint B: only normal contact damps") for line in lines
    )
    assert "slowly" not in page(assessment())


def test_sides_of_a_negative_value_are_those_of_the_number_not_of_its_size():
    """Of a gear ratio of -3: what is looked at below it in size lies above it, up to -1.5."""
    found = assessment(motion={"radius": 0.99})
    found["present_value"] *= np.where(found["parameter"] == "gear_ratio", -1, 1)
    found["crank_speed"] *= -1
    lines = [re.sub(" +", " ", line.strip()) for line in page(found).splitlines()]
    kept = "at a radial clearance of joint B below 150 µm, or at a gear ratio below \N{MINUS SIGN}5"
    assert f"Loss of contact stops {kept}." in lines
    told = lines.index("gear ratio, now \N{MINUS SIGN}3")
    unmet = "contact is kept, period 1 is lost, chaos begins"
    assert lines[told + 1] == f"above: not met up to \N{MINUS SIGN}1.5: {unmet}"
    assert lines[told + 2].startswith("above: 2 windows")
    assert lines[told + 3].startswith("below: period 1 at 5 of 30 values from there to \N{MINUS SIGN}6")
    assert re.fullmatch("motions looked at: 50 values above, .*; 50 values below, .*", lines[told + 4])
    assert "gear ratio, above not met up to \N{MINUS SIGN}1" in lines
    assert any(line.startswith("gear ratio, below about \N{MINUS SIGN}6 100 %") for line in lines)
    edges = [line for line in lines if re.search("gear ratio, below \N{MINUS SIGN}[45]", line)]
    assert len(edges) == 3
    assert "to a third in 99 turns (9.95 s)." in lines
    found["curve_grade"][1, 10] = 3
    assert "gear ratio, above: hammers at \N{MINUS SIGN}" in page(found)


def test_what_the_budget_did_not_reach_is_named():
    skipped = {"status": 7}
    over, sides = [skipped, skipped], 4 * [skipped]
    mechanism = jp.catalog.chunmei2002(clearance=2e-4, gear_ratio=3.0)
    now = motion(NAMES, 2.0, **({"motion": {"radius": 0.5}} | LOOSE))
    made = assembled(mechanism, KEYS, now, motion(NAMES), skipped, over, sides)
    told = {"step": 0.01, "lasting_turns": 400, "lasting_share": 0.01} | ended(0, 0.0)
    text = page(made.assign(OUTPUTS.variables_of(told)[0]))
    assert "Rattles: joint B loses contact twice a turn" in text
    assert "other contact data: not looked at" in text
    assert "gear ratio: not looked at" in text
    assert text.count("below: not looked at") == text.count("above: not looked at") == 2
    assert "(the same command goes on with what was not looked at)" in text
    assert "goes on" not in page(assessment())


def test_a_side_that_was_cut_short_says_how_far_it_came():
    text = page(assessment(sides=[side(1.5e-4, status=7), *SIDES[1:]]))
    assert "below: not met down to 150 µm (not looked at beyond): contact is kept, period 1 is lost" in text
    assert "(the same command goes on with what was not looked at)" in text


def test_six_lines_say_verdict_motion_wear_what_it_hangs_on_where_it_changes_and_what_to_do():
    found = assessment()
    first, second, worn, band, third, last = answer(found).splitlines()
    hourly = 0.4 * 3600 * float(found["crank_speed"]) / (2 * np.pi)
    assert worn == f"Joint B: sliding work 0.4 J a turn, {measure(hourly, 'J', 3)} an hour"
    pressed = found.assign(contact_pressure=found["contact_pressure"].fillna(3.2e6))
    assert "Joint B: pressure 3.2 MPa at the peak, sliding work" in answer(pressed)
    assert f"  {worn}\n" in page(found)
    assert first.startswith(
        "Rattles: joint B loses contact twice a turn and hits at 50 mm/s; joint O carries up to 22 N"
    )
    assert second.endswith("the motion repeats every turn, contact is lost in each")
    kept = "a radial clearance of joint B below 150 µm, or at a gear ratio above 5"
    assert third == f"Loss of contact stops at {kept}"
    assert band.startswith("With other contact data the largest force at B is 20 N to 30 N")
    best = "Of single changes, half the radial clearance of joint B helps most: it lowers the largest ratio"
    assert last == f"{best} to ideal forces from 2.2 to 1"
    assert str(jp.summary(assessment())) == answer(assessment())


def test_a_chaotic_motion_is_told_by_its_exponent():
    more = {"section_exponent_per_turn": 1.5, "section_standard_error_per_turn": 0.07}
    text = page(assessment(period=0, traits=np.array([1, 1, 1]), **more))
    assert "the motion is chaotic, largest exponent of the section map +1.500 ± 0.070 per turn" in text
    assert "below: chaotic at each of the 50 values down to 100 µm, 400 turns later too" in text
    assert "below: chaotic at 48 of the 50 values down to 1.5, 400 turns later too" in text
    assert "chaos ends: " in text
    assert "chaos begins" not in text
    assert "not known to be chaotic" in page(assessment(period=0, traits=np.array([1, 1, 0]), **more))
    unknown = dict.fromkeys(more, np.nan)
    assert "numbers are of a few turns" in page(assessment(period=0, traits=np.array([1, 1, 0]), **unknown))


def test_a_page_of_a_motion_that_failed_says_so():
    found = assessment({"status": 2, "trouble": "step_limit"})
    assert answer(found) == "no forces known"
    assert "stopped early: step_limit" in str(jp.summary(found))
    assert "\N{EN DASH}" in page(found)


def test_the_commands_on_the_page_are_studies(tmp_path):
    source = tmp_path / "crank.toml"
    source.write_text(
        'kind = "assess"\n[mechanism]\ncatalog = "chunmei2002"\nclearance = 2e-4\n[analysis]\nreach = 3\n'
    )
    given = commands(assessment(), str(source))
    assert len(given) == 3
    for command in given:
        words = shlex.split(command)
        assert words[:2] == ["jointplay", "run"]
        study = load(words[2], words[4:]).record
        (values,) = ([*each] for each in study.keywords()["over"].values())
        assert study.kind == "bifurcation"
        assert len(values) == 41
    below = load(str(source), shlex.split(given[0])[4:]).record.keywords()
    (values,) = below["over"].values()
    assert below["direction"] == ("down",)
    assert min(values) < 1.5e-4 < max(values) == pytest.approx(2e-4)


def test_a_narrow_bracket_is_one_value_and_none_looked_at_is_said_so():
    found = assessment()
    found["values_looked_at"][:] = 0
    found["bracket_high"] = found["bracket_low"]
    lines = [re.sub(" +", " ", line.strip()) for line in page(found).splitlines()]
    assert "motions looked at: none" in lines
    assert any(line.endswith("25 % 148.5 µm grazing of the orbit") for line in lines)
