"""Every parameter of every preset: replaced, varied, differentiated and refused as the one object says."""

import re

import numpy as np
import pytest

import jointplay as jp
from jointplay.analysis.own_units import in_own_units
from jointplay.analysis.vary import axes
from jointplay.display.errors import InputError
from jointplay.display.number_text import typed
from jointplay.solver.codegen import cache
from jointplay.solver.equations.friction import FRICTIONS
from jointplay.solver.equations.laws import LAWS
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.parameters import NAMED, Parameter
from jointplay.solver.mechanism.paths import part_at
from jointplay.study import file
from tests.mechanism.test_catalog import LINKAGES, REQUIRED
from tests.support.wrong import refused

PRESETS = [*jp.catalog.NAMES]
EACH = 5  # so many of the parameters is differentiated
ALONE = (  # what is refused of numbers that mean nothing here, or go with others
    *(
        "with kind = 'prismatic' only",
        "is given by point",
        "the ends of the elastic",
        "slider greater than 0",
    ),
    *("needs a journal radius", "without a viscous part", "a finite speed"),
)


def preset(name):
    return jp.catalog.NAMES[name](**REQUIRED.get(name, {}))


def near(parameter):
    """A value beside the parameter's own that makes a mechanism; None where it is known why there is none."""
    own = parameter.value
    step = 1 if isinstance(own, int) else 1e-3 * abs(own) or 1e-5
    said = ""
    for value in (own + step, own - step):
        try:
            parameter.at(value)
        except InputError as error:
            said += str(error)
        else:
            return value
    assert any(words in said for words in ALONE), said
    return None


def numbers(mechanism):
    """Every number of a mechanism by its path."""
    every = (one for one in Parameter.of(mechanism) if len(one.paths) == 1)
    return {one.paths[0]: one.value for one in every}


def checked_study(name, table=(), vary=()):
    """A study file of a preset whose mechanism has other values, or whose values vary."""
    given = {"catalog": name} | REQUIRED.get(name, {}) | dict(table)
    more = {"vary": dict(vary)} if vary else {}
    return file.validate(
        {"kind": "response", "name": "a", "mechanism": given, "analysis": {"duration": 1e-3}} | more
    )


@pytest.mark.nightly
@pytest.mark.parametrize("name", PRESETS)
def test_each_can_be_replaced_and_varied(name):
    mechanism, alone = preset(name), []
    before = numbers(mechanism)
    listed = list(Parameter.of(mechanism))
    assert listed
    for one in listed:
        value = near(one)
        if value is None:
            alone.append(one)
            continue
        changed = one.at(value)
        assert changed == mechanism.replace(**{one.key: value}) != mechanism
        if not one.key.endswith(".order"):  # by which a harmonic is found
            assert {part_at(changed, path, "")[0] for path in one.paths} == {value}
            differing = {key for key, x in numbers(changed).items() if x != before[key]}
            assert differing == {*one.paths} or not one.uniform  # a bare clearance makes other joints ideal
            again = Parameter(changed, one.key)
            assert (again.value, again.units, again.noun) == (value, one.units, one.noun)
        loose = len(getattr(mechanism, "clearance_joints", ()))
        assert (one.at(one.value) == mechanism) == one.uniform == (one.key != "clearance" or loose < 2)
        (axis,) = axes(mechanism, {one.key: [value, one.value]})
        assert (axis.key, axis.long_name, {*axis.values}) == (one.key, one.noun, {value, one.value})
    assert {one.value for one in alone if "rod" not in one.key and one.key != "joints.B.journal.at"} <= {0.0}


@pytest.mark.parametrize("name", PRESETS)
def test_each_takes_its_unit_and_is_refused_beyond_its_bounds_in_one_voice(name):
    mechanism, linkage = preset(name), name in LINKAGES
    for one in [*Parameter.of(mechanism)][:: EACH if linkage else 1]:
        text = f"{one.value!r} {one.units}".removesuffix(" 1")
        if one.units != "1":
            assert in_own_units(mechanism, {"over": {one.key: [text]}}) == {"over": {one.key: [one.value]}}
            assert checked_study(name, vary={one.key: [text]}).vary == {one.key: (one.value,)}
            if near(one) is not None and one.uniform and "harmonics" not in one.key and linkage:
                assert checked_study(name, {one.key: text}).mechanism == one.at(one.value)
        if one.bounds:
            value, limit = beyond(one)
            (said,) = refused(one.at, value).values()
            assert limit in said
            assert refused(axes, mechanism, {one.key: [value]}) == {f"over.{one.key}[0]": said}
            assert refused(checked_study, name, {}, {one.key: [value]}) == {f"vary.{one.key}[0]": said}
            if linkage:
                assert refused(checked_study, name, {one.key: value}) == {f"mechanism.{one.key}": said}


def sides(parameter, h):
    """Models of the mechanism a little above and below the parameter's own value, where it has both."""
    try:
        return [assemble(parameter.at(parameter.value + step)) for step in (h, -h)]
    except InputError:
        return []


def beyond(one):
    """A value just beyond a bound of a parameter, and that bound as messages write it."""
    (name, limit), *_ = one.bounds.items()
    return {"gt": limit, "lt": limit, "ge": limit - 1.0, "le": limit + 1.0}[name], typed(limit)


@pytest.mark.parametrize("law", [*LAWS, *FRICTIONS])
def test_numbers_of_laws_have_the_bounds_that_their_laws_say(law):
    plain = jp.catalog.slider_crank(friction=0.0)
    numbers = {**LAWS, **FRICTIONS}[law].trial
    if law in LAWS:
        beside = {name: numbers.pop(name) for name in ("stiffness", "damping") if name in numbers}
        given = {"joints.B.contact": {"law": law, "parameters": numbers} | beside}
    else:
        given = {"joints.B.friction": {"law": law, "coefficient": 0.1} | numbers}
    mechanism, part = plain.replace(**given), next(iter(given))
    own = [one for one in Parameter.of(mechanism) if one.key.startswith(part)]
    assert {one.key.rpartition(".")[2] for one in own} >= {*numbers}
    for one in own:
        value, limit = beyond(one)
        assert limit in " ".join(refused(one.at, value).values())
        assert near(one) is not None


@pytest.mark.nightly
@pytest.mark.parametrize("name", PRESETS)
def test_each_has_the_derivative_of_its_numbers_or_none(name):
    mechanism, found = preset(name), []
    here = assemble(mechanism)
    names = cache.structure_module(here.structure).PARAMETERS
    smooth = [one for one in Parameter.of(mechanism) if one.smooth]
    for one in [one for one in smooth if one.uniform][::EACH]:
        h = 1e-4 * abs(one.value) or 1e-6
        beside = sides(one, h)
        try:
            directions = one.directions(assemble)
        except InputError:
            assert not beside or {each.structure for each in beside} != {here.structure}, one.key
            continue
        above, below = beside
        rates = dict(zip(directions.names[0], directions.rates, strict=True))
        got, expected = (
            np.array([rates.get(each, 0.0) for each in names]),
            (above.numbers - below.numbers) / 2 / h,
        )
        rounding = 1e-14 * np.abs(here.numbers) / h
        np.testing.assert_array_less(
            np.abs(got - expected), 1e-5 * np.abs(got) + 2 * rounding + 1e-300, one.key
        )
        moved = (above.state - below.state) / 2 / h
        rounding = 1e-13 * (1 + np.max(np.abs(here.state))) / h
        np.testing.assert_allclose(directions.starts[0], moved, rtol=1e-5, atol=rounding, err_msg=one.key)
        found.append(one.key)
    assert len(found) > len(smooth) / EACH / 3


@pytest.mark.parametrize("word", NAMED)
def test_a_word_is_an_alias_of_the_paths_at_which_its_value_stands(word):
    mechanism = jp.catalog.chunmei2002(elastic=("coupler", "rocker"))
    if word == "speed":
        mechanism = mechanism.replace(speed=30.0)
    value = {"elements": 3, "clearance": 1e-4}.get(word, 0.25)
    one, changed = Parameter.named(mechanism, word), mechanism.replace(**{word: value})
    assert one.paths
    assert {part_at(changed, path, "")[0] for path in one.paths} == {value}
    assert Parameter(changed, word).value == value


def test_a_word_without_one_value_is_not_differentiated():
    mechanism = jp.catalog.chunmei2002(clearance={"B": 2.9e-5, "C": 1e-5})
    (said,) = refused(lambda by: jp.gradient(mechanism, by=[by]), "clearance").values()
    assert "a parameter that has a single value here" in said


def test_several_change_by_the_same_amount_from_where_each_is():
    """A linkage that is moved as a whole moves as before; no start is where both pivots are at one place."""
    mechanism = jp.catalog.chunmei2002(clearance=0.0)
    pivots = [f"joints.{name}.bearing.point[0]" for name in ("C", "O")]
    moved = Parameter.named(mechanism, " + ".join(pivots)).at(0.25)
    assert [moved.joint(name).bearing.point[0] for name in "CO"] == pytest.approx([0.25, 0.05], rel=1e-15)
    found = jp.gradient(mechanism, of=["end:angle:rocker"], by=[*pivots, " + ".join(pivots)])
    one, other, both = found["derivative"].values[0]
    assert abs(one) > 1
    assert one + other == pytest.approx(both, abs=1e-8 * abs(one))
    assert both == pytest.approx(0.0, abs=1e-8 * abs(one))


def test_a_number_that_does_not_fit_to_another_one_is_told_with_it():
    both = "'links.coupler.length + joints.B.journal.at' changes both by as much"
    told = re.escape("links.coupler.length: got 0.17; joints.B.journal.at is 0.181, and there ")
    with pytest.raises(InputError, match=f"^{told}.* is accepted; {re.escape(both)}$"):
        jp.catalog.chunmei2002(clearance=1e-4).varied({"links.coupler.length": 0.17})


def test_a_bare_clearance_is_that_of_the_only_joint_that_can_have_one():
    guided = jp.catalog.flores2010(clearance=5e-4)
    assert guided == jp.catalog.flores2010(clearance={"G": 5e-4})
    assert Parameter(guided, "clearance").value == 5e-4


@pytest.mark.long
def test_several_that_change_alike_are_one_parameter_wherever_one_is_named():
    """A coupler cannot be longer than where its far joint sits, but both can be moved at once."""
    mechanism, key = (
        jp.catalog.chunmei2002(elastic=("coupler",)),
        "links.coupler.length + joints.B.journal.at",
    )
    longer = mechanism.replace(**{"links.coupler.length": 0.182, "joints.B.journal.at": 0.182})
    one = Parameter.named(mechanism, key)
    assert (one.value, one.units, one.noun, one.uniform) == (0.181, "m", "length of the coupler", True)
    assert one.at(0.182) == longer
    (axis,) = axes(mechanism, {key: [0.18, 0.182]})
    assert (axis.name, axis.key, axis.units) == ("length", key, "m")
    study = checked_study("chunmei2002", {"elastic": ["coupler"]}, {key: ["182 mm"]})
    assert study.vary == {key: (0.182,)}
    assert refused(axes, mechanism, {key: [0.18], "links.coupler.length": [0.18]}).keys() >= {f"over.{key}"}
    both = {key: (0.18, 0.19), "links.coupler.length": (0.18, 0.19)}
    assert (
        "each parameter once" in refused(lambda: jp.optimise(mechanism, by=both, least="time"))[f"by.{key}"]
    )
    duffing = jp.catalog.duffing()
    plane = {"amplitude + damping": (0.1, 0.5), "damping": (0.1, 0.5)}
    assert refused(lambda: jp.curve(duffing, plane=plane)).keys() == {f"plane.{key}" for key in plane}
    assert duffing.varied({"amplitude + damping": 0.8}) == jp.catalog.duffing(amplitude=0.8, damping=0.7)


def test_rough_places_are_angles_and_slides():
    fields = dict(jp.catalog.slider_crank(clearance=0.0)) | {"guess": {"rod": 0.1, "G": 0.15}}
    units = {each.key: each.units for each in Parameter.of(jp.Mechanism(**fields))}
    assert (units["guess.rod"], units["guess.G"]) == ("rad", "m")


def test_a_count_has_no_branch():
    bent = jp.catalog.chunmei2002(elastic=("coupler",), elements=2)
    found = refused(lambda: jp.continuation(bent, parameter="elements", range=(1.0, 3.0)))
    assert "elements is a whole number" in found["range"]


@pytest.mark.parametrize("name", PRESETS)
def test_a_wrong_name_is_told_of_parameters_that_there_are(name):
    mechanism = preset(name)
    (said,) = refused(Parameter.named, mechanism, "nothing_like_it").values()
    known = said.split("accepted: ")[-1].split(", ")
    there = {one.key for one in Parameter.of(mechanism) if "." not in one.key}
    assert {*filter(str.isidentifier, known)} <= there != set()
