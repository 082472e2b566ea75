"""A mechanism alone runs: what is left out of a study follows from the mechanism, from both doors."""

import pytest
import xarray as xr

import jointplay as jp
from jointplay.display.errors import InputError
from jointplay.kinds import KINDS
from jointplay.study.file import schema, validate
from tests.support.wrong import problems_of

LINKAGE = {"catalog": "chunmei2002", "clearance": 2e-4}
BENT = {"catalog": "chunmei2002", "clearance": 2e-4, "elastic": ["coupler"]}
OWN = {"scheme_comparison": BENT, "benchmark": {"catalog": "ivp_crank"}}
ASKED = {
    "optimise": {"analysis.by", "analysis.least"},
    "tolerances": {"tolerances"},
}  # nobody can guess what is to be varied, and for what


def study(kind, mechanism=LINKAGE, **tables):
    return validate({"kind": kind, "name": "alone", "mechanism": mechanism, **tables})


@pytest.mark.parametrize("kind", KINDS)
def test_kind_and_mechanism_are_a_study(kind):
    if kind not in ASKED:
        study(kind, OWN.get(kind, LINKAGE))
        return
    assert problems_of(study, kind).keys() == ASKED[kind]


def test_a_range_is_half_and_twice_the_present_value():
    assert study("continuation").analysis.range == (1e-4, 4e-4)
    assert study("continuation", analysis={"parameter": "gear_ratio"}).analysis.range == (7.5, 30.0)
    assert study("continuation", analysis={"range": [1e-4, 2e-4]}).analysis.range == (1e-4, 2e-4)
    assert study("curve").keywords()["plane"] == {"clearance": (1e-4, 4e-4), "gear_ratio": (7.5, 30.0)}
    values = study("bifurcation").keywords()["over"]["clearance"]
    assert (values[0], values[-1], len(values)) == (pytest.approx(1e-4), pytest.approx(4e-4), 40)
    disc = ("eccentricity_ratio_x", "eccentricity_ratio_y")
    assert study("tipping").keywords()["region"] == dict.fromkeys(disc, (-0.7, 0.7))
    assert set(study("basins").keywords()["plane"]) == set(disc)


def test_a_length_follows_where_none_is_given():
    assert (study("response").analysis.turns, study("response").analysis.transient) == (5, 20)
    given = study("response", analysis={"duration": 0.1}).analysis
    assert (given.turns, given.duration, given.transient) == (None, 0.1, 0)
    assert study("response", analysis={"windows": [[1, 2]]}).analysis.turns is None
    assert study("lyapunov", analysis={"transient": 7}).analysis.transient == 7
    assert study("lyapunov", analysis={"transient": 7}).analysis.turns == 300
    pair = jp.catalog.impact_pair(gap=3.0, restitution=0.8)
    xr.testing.assert_equal(
        jp.simulate(pair).drop_vars("wall_time"),
        jp.simulate(pair, transient=20, turns=5).drop_vars("wall_time"),
    )


@pytest.mark.parametrize("kind", ["continuation", "curve", "basins", "tipping", "bifurcation"])
def test_what_does_not_follow_is_asked_for_by_its_key(kind):
    key = {"continuation": "range", "curve": "plane", "basins": "plane", "tipping": "region"}.get(kind)
    for mechanism in (LINKAGE | {"clearance": 0}, {"catalog": "impact_pair", "gap": 3, "restitution": 0.8}):
        with pytest.raises(InputError) as caught:
            study(kind, mechanism)
        (problem,) = (each for each in caught.value.problems if not each.key.startswith("mechanism"))
        assert problem.key == (f"analysis.{key}" if key else "vary")
        assert "got nothing" in str(problem)


def test_the_schema_asks_for_no_more():
    tables = schema()["$defs"]
    assert tables["ContinuationAnalysis"]["required"] == []
    assert tables["OptimiseAnalysis"]["required"] == ["by"]
    assert "analysis" not in tables["ResponseStudy"]["required"]
