"""What public functions say of their arguments: in the words of study files, and all at once."""

import inspect
import math
from decimal import Decimal

import numpy as np
import pytest
import xarray as xr

import jointplay as jp
from jointplay import catalog
from jointplay.analysis import evaluate
from jointplay.analysis.quantities import STATUS
from jointplay.solver.mechanism.loops.ideal import ideal_state
from jointplay.study.file import validate
from jointplay_lab.paper import claims
from tests.support.wrong import refused

PAIR = catalog.impact_pair(3.0, 0.8)
LOOSE = catalog.chunmei2002(clearance=2.9e-4, gear_ratio=3.0)
HUGE = 10**400
STUDY = {
    "kind": "response",
    "name": "n",
    "mechanism": {"catalog": "impact_pair", "gap": 3.0, "restitution": 0.8},
    "analysis": {"turns": 1},
}
FUNCTIONS = [name for name in jp.__all__ if inspect.isfunction(getattr(jp, name))]


def in_a_file(**analysis):
    """What is said of a study's keywords, by key."""
    found = refused(validate, STUDY | {"analysis": STUDY["analysis"] | analysis})
    return {key.removeprefix("analysis."): expected for key, expected in found.items()}


@pytest.mark.parametrize("value", [0, -5, 1.5, True, 10**10, "a", math.nan, [1]], ids=repr)
def test_a_count_that_is_none_is_refused_in_the_same_words_as_in_a_study_file(value):
    said = refused(jp.simulate, PAIR, turns=1, samples_per_turn=value)
    assert said == {"samples_per_turn": "a whole number of at least 1 and at most 1e9 is accepted"}
    assert in_a_file(samples_per_turn=value) == said


@pytest.mark.parametrize(("key", "value"), [("rtol", 1.0), ("rtol", 0), ("max_steps", 0)])
def test_the_integrator_is_refused_in_the_same_words_as_in_a_study_file(key, value):
    said = refused(jp.simulate, PAIR, turns=1, **{key: value})
    assert refused(validate, STUDY | {"integrator": {key: value}}) == {f"integrator.{key}": said[key]}


SPREAD = {"joints.B.clearance": {"normal": [1e-4, 1e-6]}}
WORDS = {  # keywords that are one of some words, with what the call needs beside and the words
    ("optimise", "keep"): ({"by": {"clearance": [1e-5, 1e-3]}}, {}, "'contact' is accepted"),
    ("tolerances", "sequence"): ({}, {"tolerances": SPREAD}, "one of 'sobol', 'random' is accepted"),
}


@pytest.mark.parametrize("value", ["contat", 7, True, ["contact"]], ids=repr)
@pytest.mark.parametrize(("kind", "key"), WORDS)
def test_a_word_that_is_none_of_the_choice_is_refused_with_those_that_are(kind, key, value):
    given, table, accepted = WORDS[kind, key]
    spreads = {"spreads": table["tolerances"]} if table else {}
    assert refused(getattr(jp, kind), LOOSE, **given, **spreads, **{key: value}) == {key: accepted}
    study = {"kind": kind, "name": "n", "mechanism": {"catalog": "chunmei2002", "clearance": 2.9e-4}}
    study |= table | {"analysis": given | {key: value}}
    assert refused(validate, study) == {f"analysis.{key}": accepted}


@pytest.mark.parametrize("function", FUNCTIONS)
def test_every_public_function_names_an_argument_that_it_does_not_know_or_lacks(function):
    """Most by keyword; those that take any keyword refuse a value in a wrong place."""
    called = getattr(jp, function)
    parameters = inspect.signature(called).parameters
    if any(each.kind is each.VAR_KEYWORD for each in parameters.values()):
        assert next(iter(parameters)) in refused(called, 3)
    else:
        assert "no such key" in refused(called, turms=3)["turms"]
    assert refused(called, *"abcdef")


def test_what_is_wrong_by_itself_and_what_does_not_fit_are_told_together():
    said = refused(jp.lyapunov, PAIR, exponents=9, twin_turns=-1, rtol=True, progress=5, turns=np.float32(-1))
    assert set(said) == {"exponents", "twin_turns", "rtol", "progress", "turns"}
    assert said["progress"] == "true, false, or a function of the fraction done is accepted"
    said = refused(jp.simulate, PAIR, windows=[[0, 1]], duration=3.0, steps=5, section=PAIR)
    assert set(said) == {"duration", "steps", "section"}


def test_a_start_and_a_section_that_a_system_cannot_have_are_refused_together():
    nowhere = jp.Plane(quantity="w", value=0.0)
    for function in (jp.simulate, jp.poincare):
        said = refused(function, catalog.lorenz(), turns=1, section=nowhere, initial=[1.0, 2.0])
        assert set(said) == {"section.quantity", "initial"}


def test_a_wrong_value_has_one_reason_alone():
    """The rules look at what is left as usual in its place, and what they say of that is not said."""
    assert len(refused(jp.sensitivity, catalog.duffing(), rtol=1e-6, distance=-1.0)) == 1


def test_no_more_exponents_than_states():
    said = refused(jp.bifurcation, PAIR, over={"gap": [3.0]}, exponents=7)
    assert said == {"exponents": "a whole number from 0 to 2 is accepted"}


def test_numbers_of_numpy_are_numbers():
    one = jp.simulate(PAIR, turns=1, samples_per_turn=8, rtol=1e-6, steps=False)
    other = jp.simulate(
        PAIR, turns=np.int8(1), samples_per_turn=np.uint64(8), rtol=np.float64(1e-6), steps=np.bool_(False)
    )
    assert np.array_equal(one.state_value, other.state_value)
    assert catalog.impact_pair(np.int64(3), np.float16(0.5)) == catalog.impact_pair(3.0, 0.5)
    assert LOOSE.replace(clearance={"B": np.float64(1e-4)}, elastic=np.array(["coupler"])).elastic_links
    assert jp.Pin(link="ground", point=np.array([0.0, np.float64(1)])).point == (0.0, 1.0)
    given = {key: np.float32(0.0) for key in ("crank_angle", "crank_speed")}
    assert refused(jp.simulate, LOOSE, turns=1, initial=given | {"crank_angle": np.str_("a")}) == refused(
        jp.simulate, LOOSE, turns=1, initial={"crank_angle": "a"}
    )


@pytest.mark.parametrize("value", [HUGE, -HUGE, 10**5000], ids=["above", "below", "too long to write"])
def test_a_number_beyond_a_float_is_refused_wherever_it_stands(value):
    assert "clearance" in refused(LOOSE.replace, clearance=value)
    assert "gap" in refused(catalog.impact_pair, gap=value, restitution=0.5)
    assert "link.length" in refused(jp.Link, name="a", length=value, mass=1.0, inertia=1.0)
    assert "initial[0]" in refused(jp.simulate, PAIR, turns=1, initial=[value, 0])
    assert "initial.crank_angle" in refused(jp.simulate, LOOSE, turns=1, initial={"crank_angle": value})
    assert "over.gap[0]" in refused(jp.bifurcation, PAIR, over={"gap": [value]})
    assert "windows[0][1]" in refused(jp.simulate, PAIR, windows=[[0, value]])
    assert "plane.y[1]" in refused(jp.sensitivity, catalog.duffing(), plane={"y": [0, value], "v": [0, 1]})
    assert "range[1]" in refused(jp.continuation, PAIR, parameter="gap", range=[0, value])


def test_an_argument_is_given_once():
    assert "once is accepted" in refused(jp.poincare, PAIR, mechanism=LOOSE, turns=1)["mechanism"]
    assert "once is accepted" in refused(LOOSE.replace, self=3)["self"]
    assert "nothing by position" in refused(PAIR.replace, 3)["replace"]
    assert LOOSE.replace(speed=5.0).drive.speed == 5.0


def test_records_take_keywords_and_say_which():
    assert "name, length, shape, mass" in refused(jp.Link, "a", 0.2)["link"]


@pytest.mark.parametrize("given", ["contact", PAIR, 3, None, jp.ContactSection])
def test_a_section_is_one_of_its_records_or_their_tables(given):
    said = refused(jp.poincare, PAIR, given, turns=1)["section"]
    assert "crank_angle, contact, separation or plane (in Python also CrankAngle()" in said
    if given is not None:  # in a response, no section is none
        assert refused(jp.simulate, PAIR, turns=1, section=given) == {"section": said}
        assert not isinstance(given, str | int) or in_a_file(section=given) == {"section": said}
    assert jp.poincare(PAIR, {"kind": "contact"}, turns=1).sizes["turn"] > 0


def test_a_contact_that_a_test_system_has_not_is_refused_by_check_as_by_run():
    said = refused(jp.poincare, PAIR, jp.ContactSection(joint="middle"), turns=1)
    assert said == {"section.joint": "there is no such contact; these are accepted: upper, lower"}
    assert in_a_file(section={"kind": "contact", "joint": "middle"}) == said
    assert in_a_file(section={"kind": "separation"})


@pytest.mark.parametrize("length", [{"turns": 10**8}, {"duration": 1e9}])
def test_more_samples_than_a_run_can_keep_are_refused_at_both_doors(length):
    (key,) = length
    said = refused(jp.simulate, PAIR, **length)
    assert "together with samples_per_turn at most 20,000,000 samples are accepted" in said[key]
    assert refused(validate, STUDY | {"analysis": length}) == {f"analysis.{key}": said[key]}
    assert key in refused(jp.spectrum, PAIR, **length)
    assert "turns" in refused(jp.sensitivity, catalog.duffing(), turns=10**8, references=10**3)


@pytest.mark.parametrize("rtol", [1e-6, 1e-10])
def test_a_distance_that_the_runs_do_not_resolve_is_refused(rtol):
    """The motion is periodic: what starts nearer shows the errors of the runs, which do not shrink."""
    for function in (jp.growth, jp.sensitivity):
        assert "at least 100 times rtol" in refused(function, PAIR, distance=50 * rtol, rtol=rtol)["distance"]
    steady = catalog.duffing(amplitude=0.1)
    near = jp.growth(steady, turns=40, rtol=rtol, distance=100 * rtol)
    far = jp.growth(steady, turns=40, rtol=rtol, distance=1e5 * rtol)
    assert float(near.growth) == pytest.approx(float(far.growth), abs=0.02)


def test_a_growth_that_cannot_be_told_is_not_ok():
    found = jp.sensitivity(catalog.duffing(), turns=4, neighbours=2)
    assert np.isnan(found.growth)
    assert STATUS[int(found.status)] == "not_converged"
    assert np.all(found.neighbour_status == 0)


def test_angles_of_many_turns_are_refused():
    names = ("crank", "coupler", "rocker")
    far = {"angle": dict.fromkeys(names, 1e12), "angular_velocity": dict.fromkeys(names, 0.0)}
    for start in ({"crank_angle": 1e12}, far, {"crank_angle": -6284.0}):
        said = refused(jp.simulate, LOOSE, turns=1, initial=start)
        assert all("take off whole turns" in expected for expected in said.values())
    assert "take off whole turns" in refused(jp.CrankAngle, angle=1e12)["crank_angle.angle"]
    state = [1e12, *[0.0] * 5]
    assert "take off whole turns" in refused(jp.periodic_orbit, LOOSE, initial=state)["initial"]
    assert int(jp.simulate(LOOSE, turns=0.01, initial={"crank_angle": -6.28}).status) == 0


@pytest.mark.parametrize(
    "clearance", [2.9e-4, pytest.param({"A": 1e-4, "B": 2.9e-4}, marks=pytest.mark.nightly)]
)
def test_a_start_far_outside_a_bearing_is_refused(clearance):
    """With clearance at two joints a link floats: its place is that of the ideal mechanism."""
    mechanism = LOOSE.replace(clearance=clearance)
    angles, speeds, _ = ideal_state(mechanism, 0.5)
    assert (
        int(jp.simulate(mechanism, turns=0.01, initial={"angle": angles, "angular_velocity": speeds}).status)
        == 0
    )
    start = {"angle": angles | {"rocker": angles["rocker"] + 0.1}, "angular_velocity": speeds}
    assert "clearances" in refused(jp.simulate, mechanism, turns=1, initial=start)["initial.angle"]


def test_a_state_far_outside_a_bearing_is_refused():
    angles, speeds, _ = ideal_state(LOOSE, 0.5)
    state = [*angles.values(), *speeds.values()]
    state[2] += 0.1
    assert "clearances" in refused(jp.periodic_orbit, LOOSE, initial=state)["initial"]


def test_a_journal_deep_in_its_bearing_is_told(monkeypatch):
    assert "warning" not in jp.simulate(LOOSE, turns=0.3).attrs
    monkeypatch.setattr(evaluate, "DEEP", 1e-4)
    for function in (jp.simulate, jp.poincare):
        with pytest.warns(
            jp.ModelWarning, match="the journal of B goes .* clearances into its bearing"
        ) as told:
            found = function(LOOSE, turns=1)
        assert found.attrs["warning"] == str(told[0].message)
        assert told[0].filename == __file__


@pytest.mark.parametrize(
    ("function", "given", "key"),
    [
        (jp.basins, {"progress": Decimal(1)}, "progress"),
        (jp.scheme_comparison, {"steps": xr.Dataset()}, "steps"),
        (jp.Joint, {"name": "B", "contact": {None: None}}, "joint.contact.None"),
    ],
)
def test_values_that_only_look_right_are_refused(function, given, key):
    """A number equal to true, a dataset in place of an array, a key that is no text."""
    assert any(each.startswith(key) for each in refused(function, **given))


def test_claims_of_a_mechanism_whose_links_bend_are_of_the_same_cases():
    bent = jp.catalog.chunmei2002(clearance=2.9e-4, elastic=("coupler",))
    assert claims._panel(bent, "c", "clearance") == claims._panel(jp.catalog.chunmei2002(), "c", "clearance")
