"""What a sweep varies: names and key paths, their units, and everything that is wrong with them."""

import math

import numpy as np
import pytest

from jointplay import catalog
from jointplay.analysis.vary import axes
from jointplay.display.errors import InputError
from jointplay.display.number_text import cf_units
from tests.support.wrong import refused

LINKAGE = catalog.chunmei2002(clearance={"B": 2.9e-5, "C": 1e-5}, gear_ratio=3.0)
PAIR = catalog.impact_pair(3.0, 0.8)


def problems(mechanism, over, root="over"):
    """Key and message of each problem."""
    return refused(axes, mechanism, over, root)


def differences(one, other, path=""):
    """Key paths at which two records differ."""
    if hasattr(type(one), "model_fields"):
        pairs = [
            (f"{path}.{name}", getattr(one, name), getattr(other, name)) for name in type(one).model_fields
        ]
    elif isinstance(one, tuple) and one and hasattr(one[0], "name"):
        pairs = [(f"{path}.{a.name}", a, b) for a, b in zip(one, other, strict=True)]
    else:
        return [] if one == other else [path.removeprefix(".")]
    return [found for place, a, b in pairs for found in differences(a, b, place)]


def test_a_number_in_a_path_counts_parts():
    by_number, by_name = ({path: 3e-5} for path in ("joints[3].clearance", "joints.C.clearance"))
    assert LINKAGE.varied(by_number) == LINKAGE.varied(by_name) == LINKAGE.replace(**by_name)
    (numbered,), (named,) = (axes(LINKAGE, {key: [3e-5] for key in each}) for each in (by_number, by_name))
    assert (numbered.name, numbered.units, numbered.long_name) == (named.name, named.units, named.long_name)
    (ground,) = axes(LINKAGE, {"joints.C.bearing.point[0]": [0.21]})
    assert (ground.name, ground.units) == ("joints_C_bearing_point_0", "m")
    moved = LINKAGE.varied({ground.key: 0.21})
    assert differences(LINKAGE, moved) == ["joints.C.bearing.point"]
    assert moved.joint("C").bearing.point == (0.21, 0.0)
    assert (
        "accepted: O, A, B, C" in problems(LINKAGE, {"joints[4].clearance": [0]})["over.joints[4].clearance"]
    )


def test_names_are_the_changes_of_replace_and_go_together_with_paths():
    found = LINKAGE.varied({"clearance": 1e-4, "gear_ratio": 5.0, "links.crank.mass": 0.4})
    expected = LINKAGE.replace(clearance=1e-4, gear_ratio=5.0)
    assert differences(expected, found) == ["links.crank.mass"]
    assert PAIR.varied({"gap": 2.0}) == catalog.impact_pair(2.0, 0.8)
    assert LINKAGE.varied({}) == LINKAGE


def test_axes_rise_and_know_their_units():
    over = {
        "joints.B.contact.stiffness": (7e6, 1e6),
        "gear_ratio": np.array([3, 1, 2]),
        "elements": range(1, 3),
    }
    elastic = LINKAGE.replace(elastic=("coupler",))
    stiffness, ratio, elements = axes(elastic, over)
    assert stiffness.values == (1e6, 7e6)
    assert (stiffness.name, stiffness.units) == ("stiffness", "N m-1")
    assert stiffness.long_name == "contact stiffness of joint B"
    assert (ratio.name, ratio.values, ratio.units, ratio.long_name) == (
        "gear_ratio",
        (1, 2, 3),
        "1",
        "gear ratio",
    )
    assert elements.values == (1, 2)  # whole numbers stay whole
    (gap,) = axes(PAIR, {"gap": [1.0]})
    assert (gap.name, gap.units, gap.long_name) == ("gap", "1", "gap")


def test_dimensions_with_one_name_or_one_that_is_taken_get_the_whole_path():
    two = axes(LINKAGE, {"joints.B.clearance": [1e-5], "joints.C.clearance": [1e-5]})
    assert [axis.name for axis in two] == ["joints_B_clearance", "joints_C_clearance"]


@pytest.mark.parametrize(
    ("units", "expected"),
    [
        ("m", "m"),
        ("N/m", "N m-1"),
        ("N s/m", "N s m-1"),
        ("kg m²", "kg m2"),
        ("m/s²", "m s-2"),
        ("rad/s", "rad s-1"),
    ],
)
def test_units_are_those_of_datasets(units, expected):
    assert cf_units(units) == expected


def test_every_wrong_key_and_value_is_told():
    found = problems(
        LINKAGE,
        {
            "clearence": [1e-5],
            "tension": [1.0],
            "joints.D.clearance": [1e-5],
            "joints.B.contact": [1.0],
            "joints.B.contact.law": [1.0],
            "links.coupler.mass": [0.1, -1.0, True, "x", math.inf, 0.1],
            "drive.efficiency": [0.5, 1.5],
            "gear_ratio": 3.0,
            "friction": [],
        },
        "vary",
    )
    assert set(found) == {
        *("vary.clearence", "vary.tension", "vary.joints.D.clearance", "vary.joints.B.contact"),
        *("vary.joints.B.contact.law", "vary.drive.efficiency[1]", "vary.gear_ratio", "vary.friction"),
        *(f"vary.links.coupler.mass[{i}]" for i in range(1, 6)),
    }
    assert "accepted: joints.B.clearance, joints.C.clearance, " in found["vary.clearence"]
    assert "joints.B.contact.stiffness" in found["vary.clearence"]
    assert "accepted: O, A, B, C" in found["vary.joints.D.clearance"]
    assert found["vary.links.coupler.mass[1]"] == "a mass greater than 0 kg is accepted"
    assert "already" in found["vary.links.coupler.mass[5]"]
    assert problems(catalog.soft_impact_pair(1.0, 100.0, 1.0), {"tension": [1.0]}).keys() == {"over.tension"}
    assert problems(LINKAGE, {}).keys() == {"over"}


def test_paths_that_lead_nowhere_are_refused_by_changed_too():
    with pytest.raises(InputError, match="no such part"):
        LINKAGE.varied({"joints.B.contact.stifness": 1.0})
    with pytest.raises(InputError, match="clearance"):
        LINKAGE.varied({"clearence": 1.0})


def test_what_counts_can_be_varied_though_axes_hold_floats():
    elastic = LINKAGE.replace(elastic=("coupler",))
    (axis,) = axes(elastic, {"elements": [2.0, 1.0]})
    assert axis.values == (1, 2)
    found = elastic.varied({"elements": 2.0}).link("coupler").beam
    assert (found.shapes, found.elements) == ("hermite", 2)
    assert elastic.varied({"links.coupler.beam.modes": 3.0}).link("coupler").beam.modes == 3
    assert "a whole number of elements" in problems(elastic, {"elements": [2.5]})["over.elements[0]"]
