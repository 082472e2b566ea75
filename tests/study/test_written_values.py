"""Values with units in studies and analyses, also where the mechanism decides the unit; records are SI."""

import json
import math

import pytest

import jointplay as jp
from jointplay.display.errors import InputError
from jointplay.study.file import load, schema, validate
from tests.support.wrong import refused

BASE = {
    "kind": "response",
    "name": "a",
    "mechanism": {"catalog": "chunmei2002", "clearance": "0.29 mm"},
    "analysis": {"turns": 2},
}
SECTION = {"kind": "plane", "quantity": "eccentricity", "joint": "B"}


def record(**changes):
    return validate(BASE | changes)


def said(**changes):
    return refused(validate, BASE | changes)


def test_a_file_keeps_its_text_and_its_record_is_si(tmp_path):
    path = tmp_path / "a.toml"
    path.write_text(
        'kind = "response"\n[mechanism]\ncatalog = "chunmei2002"\nclearance = "0.29 mm"\n'
        '[analysis]\nduration = "20 ms"\nat = ["1 ms", 0.002]\n'
        'initial = { crank_angle = "30 deg", crank_speed = "150 rpm" }\n'
    )
    study = load(path, ["mechanism.gravity=9.81 m/s^2"])
    resolved = json.loads(json.dumps(study.record.model_dump(mode="json")))
    assert '"0.29 mm"' in study.text
    assert resolved["mechanism"]["joints"][2]["clearance"] == 2.9e-4
    assert resolved["mechanism"]["gravity"] == 9.81
    assert resolved["analysis"]["duration"] == 0.02
    assert resolved["analysis"]["at"] == [1e-3, 2e-3]
    start = resolved["analysis"]["initial"]
    assert (start["crank_angle"], start["crank_speed"]) == pytest.approx((math.pi / 6, 5 * math.pi))


def test_what_varies_has_the_units_of_its_parameter():
    stiffness = {"start": "7 kN/mm", "stop": 8e6, "num": 3}
    vary = record(vary={"clearance": ["0.1 mm", 2e-4], "joints.B.contact.stiffness": stiffness}).vary
    assert vary["clearance"] == (1e-4, 2e-4)
    assert vary["joints.B.contact.stiffness"].values == (7e6, 7.5e6, 8e6)
    assert record(vary={"cases": [{"clearance": "1e-1 mm"}]}).vary["cases"] == ({"clearance": 1e-4},)
    diagram = record(kind="bifurcation", vary={"clearance": ["0.1 mm", "0.2 mm"]}, analysis={})
    assert diagram.keywords()["over"] == {"clearance": (1e-4, 2e-4)}


def test_sections_starts_and_branches_have_them_too():
    level = record(analysis={"turns": 2, "section": SECTION | {"value": "20 um"}}).analysis.section.value
    assert level == 2e-5
    plane = {
        "crank_angle": {"start": "0 deg", "stop": "90 deg", "num": 3},
        "crank_speed": ["1 rpm", "60 rpm"],
    }
    given = record(kind="basins", analysis={"plane": plane}).analysis.plane
    assert given["crank_angle"]["stop"] == math.pi / 2
    assert given["crank_speed"][1] == pytest.approx(math.tau, rel=1e-15)
    branch = record(kind="continuation", analysis={"range": ["0.1 mm", 2e-4], "start": "0.15 mm"}).analysis
    assert (branch.range, branch.start) == ((1e-4, 2e-4), 1.5e-4)


def test_a_unit_of_something_else_is_told_with_all_the_rest():
    found = said(
        vary={
            "clearance": ["0.1 kg"],
            "joints.B.contact.stiffness": {"start": "7 kN", "stop": 1.0, "num": 2},
        },
        analysis={"turns": -1, "section": SECTION | {"value": "20 s"}, "initial": {"crank_angle": "3 s"}},
    )
    assert "kg does not convert to m" in found["vary.clearance[0]"]
    assert "kN does not convert to N/m" in found["vary.joints.B.contact.stiffness.start"]
    assert "s does not convert to m" in found["analysis.section.value"]
    assert "s does not convert to rad" in found["analysis.initial.crank_angle"]
    assert "analysis.turns" in found
    assert (
        "s does not convert to m" in said(vary={"cases": [{"clearance": "1 s"}]})["vary.cases[0].clearance"]
    )


def test_python_says_the_same():
    mechanism = jp.catalog.chunmei2002(clearance="0.29 mm")
    with pytest.raises(InputError) as caught:
        jp.simulate(mechanism, turns=0, section=SECTION | {"value": "20 s"}, initial={"crank_angle": "3 s"})
    assert {problem.key for problem in caught.value.problems} == {
        "turns",
        "section.value",
        "initial.crank_angle",
    }
    with pytest.raises(InputError, match=r"^over.clearance\[0\]: got '0.1 kg'"):
        jp.bifurcation(mechanism, over={"clearance": ["0.1 kg"]})


@pytest.mark.nightly
def test_the_schema_lets_editors_take_them():
    joint = schema()["$defs"]["Joint"]["properties"]["clearance"]
    assert joint["type"] == ["number", "string"]
    assert joint["minimum"] == 0
    assert "pattern" in joint
    assert schema()["$defs"]["MotorLine"]["properties"]["gear_ratio"]["type"] == "number"


def test_a_wrong_mechanism_or_name_makes_no_value_with_a_unit_wrong():
    """One typo in `[mechanism]` called every value with a unit elsewhere wrong: there was no unit to know."""
    typo = BASE["mechanism"] | {"crnk": "1 mm"}
    assert said(mechanism=typo, vary={"speed": ["900 rpm", "800 rpm"]}).keys() == {"mechanism.crnk"}
    by = {
        "by": {"links.coupler.mass": ["0.1 kg", "9 kg"]},
        "subject": {"largest:normal_force:B": ["0 N", "9 kN"]},
    }
    assert said(kind="optimise", mechanism=typo, analysis=by).keys() == {"mechanism.crnk"}
    spread = {"joints.D.clearance": {"normal": ["50 um", "5 um"]}}
    assert said(kind="tolerances", mechanism=typo, analysis={}, tolerances=spread).keys() == {
        "mechanism.crnk"
    }
    lost = {"joints.X.clearance": {"normal": ["50 um", "5 um"]}}
    found = said(kind="tolerances", analysis={}, tolerances=lost)
    assert found.keys() == {"tolerances.joints.X.clearance"}
    assert "there is no such part" in found["tolerances.joints.X.clearance"]
    assert "'rpn' is not a known unit" in said(mechanism=typo, vary={"speed": ["1 rpn"]})["vary.speed[0]"]


def test_a_number_as_text_is_asked_for_its_unit():
    assert "with its unit, such as '900 rpm'" in said(vary={"speed": ["900 rpm", "800"]})["vary.speed[1]"]


def test_bounds_of_an_optimum_name_the_parameter_that_there_is_not():
    found = said(
        kind="optimise", analysis={"by": {"links.couplr.mass": ["1 kg", "2 kg"], "crank": [1, "2 m"]}}
    )
    assert "did you mean 'coupler'?" in found["analysis.by.links.couplr.mass"]
    assert "there is no such parameter" in found["analysis.by.crank"]
    shown = said(kind="optimise", analysis={"by": {"clearance": ["1", "2 mm"]}})["analysis.by.clearance[0]"]
    assert "coordinates" not in shown
    assert "with its unit" in shown


def test_spreads_name_what_was_given_and_the_distribution_that_is_meant():
    spreads = {"speed": {"gaussian": [150, 5]}}
    assert (
        "there is no such distribution; did you mean 'normal'?"
        in said(kind="tolerances", analysis={}, tolerances=spreads)["tolerances.speed.gaussian"]
    )
    with pytest.raises(
        InputError, match=r"got \{'normal': \(5e-6, 5e-6\)\}; .* is beyond −18.77 µm: above and"
    ):
        validate(
            BASE
            | {
                "kind": "tolerances",
                "analysis": {},
                "tolerances": {"clearance": {"normal": ["5 um", "5 um"]}},
            }
        )
