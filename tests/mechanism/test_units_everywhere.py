"""Every field of a record, and every keyword of an analysis, that has a unit takes a text with one."""

import re

import pytest
from pydantic import create_model

import jointplay as jp
from jointplay.analysis.own_units import in_own_units
from jointplay.display.accepted import units_of
from jointplay.display.errors import InputError
from jointplay.kinds import KINDS
from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.base import Record
from jointplay.solver.mechanism.changes import Changes
from jointplay.solver.mechanism.parts.beam import Bar, Beam, Link, Plate, PointMass, Rod, Tube
from jointplay.solver.mechanism.parts.contact_data import PinInBush
from jointplay.solver.mechanism.parts.courses import FORCES, Course, Harmonic
from jointplay.solver.mechanism.parts.friction import Friction
from jointplay.solver.mechanism.parts.materials import Material
from jointplay.solver.mechanism.records import (
    ConstantSpeed,
    Contact,
    CrankAngle,
    Force,
    Joint,
    Mechanism,
    MotorLine,
    Pin,
    PrescribedTorque,
    Servo,
    SpeedCycle,
    SpeedProfile,
    Spring,
    System,
    Torque,
    TorsionSpring,
)

_TERM, _PIN = Harmonic(order=1, cosine=0.25, sine=0.125), Pin(link="crank", at=0.02)
_WAVE = {"constant": 3.0, "harmonics": [_TERM], "tolerance": 0.02, "factor": 1.5}
_SIDE = {"from": _PIN, "to": Pin(link="ground", point=(0.5, 0.25))}
_MECHANISM = catalog.slider_crank(gravity_direction=-1.0)
SAMPLES = [  # one of each record, with a number in each field that holds a quantity
    Beam(area=1e-4, second_moment=1e-9, damping_ratio=0.02),
    Link(name="crank", length=0.03, mass=0.4, inertia_centre=1e-4),
    Link(name="crank", length=0.03, mass=0.4, inertia=2e-4, centre=0.01),
    Bar(width=0.02, thickness=0.006, overhang=0.01),
    Rod(diameter=0.02, overhang=0.01),
    Tube(diameter=0.02, wall=0.002, overhang=0.01),
    Plate(width=0.02, thickness=0.006),
    Material(modulus=7e10, poisson_ratio=0.33, density=2700.0),
    PinInBush(pin="steel", bush="POM", length=0.012, wall=0.004, load=50.0, restitution=0.7),
    PointMass(at=0.01, mass=0.2),
    _PIN,
    Pin(link="ground", point=(0.5, 0.25), direction=0.5),
    Joint(
        name="B",
        journal=_PIN,
        bearing=Pin(link="rod"),
        clearance=1e-4,
        radius=0.01,
        contact=Contact(stiffness=1e7, damping=3.0),
    ),
    Joint(
        name="G", kind="prismatic", journal=_PIN, bearing=Pin(link="rod"), half_length=0.02, half_height=0.01
    ),
    Contact(stiffness=1e7, damping=3.0),
    Friction(coefficient=0.1, viscous=0.3),
    Friction(
        law="lugre",
        coefficient=0.1,
        static_coefficient=0.15,
        stribeck_velocity=0.01,
        bristle_stiffness=1e5,
        bristle_damping=2.0,
    ),
    MotorLine(
        link="crank",
        gear_ratio=3.0,
        efficiency=0.8,
        synchronous_speed=157.0,
        rated_speed=150.0,
        rated_torque=2.0,
    ),
    ConstantSpeed(link="crank", speed=30.0),
    SpeedProfile(link="crank", start=10.0, end=20.0, time=0.5),
    PrescribedTorque(link="crank", nominal_speed=30.0, **_WAVE),
    SpeedCycle(link="crank", frequency=5.0, **_WAVE),
    Servo(link="crank", stiffness=50.0, damping=2.0, speed=3.0, nominal_speed=3.0, frequency=5.0, **_WAVE),
    Force(name="P", on=_PIN, direction=0.5, frequency=7.0, **_WAVE),
    Torque(name="M", link="crank", frequency=7.0, **_WAVE),
    Spring(name="S", stiffness=10.0, damping=1.0, free_length=0.1, **_SIDE),
    TorsionSpring(name="T", stiffness=10.0, damping=1.0, angle=0.5, **{"from": "crank", "to": "ground"}),
    CrankAngle(angle=0.5),
    Changes(
        clearance=1e-4,
        gear_ratio=3.0,
        friction=0.1,
        damping_ratio=0.02,
        gravity=9.8,
        gravity_direction=-1.0,
        speed=30.0,
    ),
    _MECHANISM,
]
APART = {"Harmonic", "Course", "_Load"}  # whose units are those of the whole


def united(sample):
    """Names and units of the fields of a record that hold one number with a unit, or a share."""
    for name, field in type(sample).model_fields.items():
        units = units_of(field)
        if isinstance(getattr(sample, name), float) and units is not None:
            yield name, type(sample).units if units == FORCES else units
    if isinstance(sample, Friction):
        yield from (
            {"bristle_stiffness": "1/m", "bristle_damping": "s/m"}.items() if sample.law == "lugre" else ()
        )


def table(sample):
    return {name: getattr(sample, name) for name in sample.model_fields_set}


def refused(call, **given):
    """What a call is refused with; empty if it is not."""
    try:
        call(**given)
    except InputError as error:
        return str(error)
    return ""


CASES = [(each, *case) for each in SAMPLES for case in united(each)]
IDS = [f"{type(each).__name__}-{name}" for each, name, _ in CASES]


@pytest.mark.parametrize(("sample", "name", "units"), CASES, ids=IDS)
def test_a_field_takes_a_text_with_its_unit(sample, name, units):
    value = getattr(sample, name)
    text = f"{100 * value!r} %" if units == "1" else f"{value!r} {units}"
    made = type(sample)(**table(sample) | {name: text})
    assert getattr(made, name) == pytest.approx(value, rel=1e-15)
    with pytest.raises(InputError, match="A does not convert to"):
        type(sample)(**table(sample) | {name: "3 A"})


@pytest.mark.parametrize(("sample", "name", "units"), CASES, ids=IDS)
def test_the_form_that_a_message_names_is_accepted(sample, name, units):
    with pytest.raises(InputError) as caught:
        type(sample)(**table(sample) | {name: "much"})
    for example in re.findall("such as '([^']+)'", str(caught.value)):
        said = refused(type(sample), **table(sample) | {name: example})
        assert "does not convert" not in said  # where it is refused, then for its size
        assert "unit" not in said


def kinds_of(record):
    for each in record.__subclasses__():
        yield each
        yield from kinds_of(each)


def test_every_record_with_a_quantity_is_among_the_samples():
    known = {type(each).__name__ for each in SAMPLES} | APART
    with_units = {
        each.__name__
        for each in kinds_of(Record)
        if each.__module__.startswith("jointplay.solver.mechanism")
        and each.__module__ != "jointplay.solver.mechanism.signature"
        and any(units_of(field) not in (None, "1") for field in each.model_fields.values())
    }
    assert with_units <= known


@pytest.mark.parametrize(
    "sample", [each for each in SAMPLES if isinstance(each, Course)], ids=lambda s: s.kind
)
def test_harmonics_and_tables_have_the_units_of_the_whole(sample):
    units, own = type(sample).units, {**table(sample)}
    own.pop("harmonics")
    made = type(sample)(**own, harmonics=[{"order": 1, "cosine": f"250 m{units}", "sine": f"0.125 {units}"}])
    assert made.harmonics == sample.harmonics
    values = [0.0, 1.0, 0.0, -1.0]
    course = type(sample)(
        **own,
        table=[f"{value} {units}" for value in values],
    )
    assert course.table == tuple(values)
    with pytest.raises(InputError, match=r"harmonics\[0\].sine: .*A does not convert to"):
        type(sample)(**own, harmonics=[{"order": 1, "sine": "1 A"}])
    with pytest.raises(
        InputError, match=r"cosine: got '5 N'.*or in the table of a load or drive one with its unit"
    ):
        Harmonic(order=1, cosine="5 N")


def test_loads_and_speeds_as_anybody_writes_them():
    on = {"name": "P", "on": _PIN, "direction": "90 deg"}
    assert [Force(**on, constant=text).constant for text in ("5 N", "5 kN", "-2 lbf")] == [
        5.0,
        5e3,
        pytest.approx(-8.896443230521),
    ]
    assert PrescribedTorque(link="crank", constant="20 N m", nominal_speed="100 rpm").constant == 20.0
    swing = [{"order": 2, "cosine": "50 rpm"}]
    cycle = SpeedCycle(link="crank", constant="300 rpm", harmonics=swing, frequency="5 turn/s")
    assert cycle.harmonics[0].cosine == pytest.approx(50 * 3.141592653589793 / 30)
    with pytest.raises(InputError, match="such as N, is accepted; N m does not convert to"):
        Force(**on, constant="5 N m")


def test_units_that_another_number_decides():
    assert Contact(law="hertz", stiffness="2 GN/m^1.5").stiffness == 2e9
    assert Contact(law="hertz", stiffness="2 GN/m^2", parameters={"exponent": 2.0}).stiffness == 2e9
    with pytest.raises(InputError, match=r"N/m does not convert to"):
        Contact(law="hertz", stiffness="2 GN/m")
    fields = {name: getattr(_MECHANISM, name) for name in Mechanism.model_fields} | {
        "guess": {"rod": "10 deg", "G": "170 mm"}
    }
    assert Mechanism(**fields).guess == {"rod": pytest.approx(0.17453292519943295), "G": 0.17}
    system = System(
        states={"x": "2 mm"},
        rates={"x": "-x/T"},
        parameters={"T": "20 ms"},
        scales={"x": "1 mm", "t": "20 ms"},
    )
    assert system.scales == {"x": 1e-3, "t": 0.02}


KEYWORDS = {
    (name, units): annotation
    for kind in KINDS.values()
    for name, (annotation, _) in kind.function.fields().items()
    if (units := units_of(create_model("One", one=(annotation, ...)).model_fields["one"])) is not None
}


@pytest.mark.parametrize(("name", "units"), [*KEYWORDS])
def test_a_keyword_takes_a_text_with_its_unit(name, units):
    one = create_model("One", __base__=Record, one=(KEYWORDS[name, units], ...))
    for value in (0.05, 3, [0.05, 3]):
        try:
            expected = one(one=value).one
        except InputError:
            continue  # too large for it, a list, or none
        texts = [f"{100 * each!r} %" if units == "1" else f"{each} {units}" for each in flat(value)]
        assert one(one=texts if isinstance(value, list) else texts[0]).one == pytest.approx(expected)
        return
    pytest.fail("no number is accepted")


SPRUNG = System(
    states={"x": "1 mm", "v": "0 mm/s"},
    parameters={"k": "5 1/s^2", "c": "0.1 1/s"},
    rates={"x": "v", "v": "-k*x - c*v"},
)
USUAL = catalog.chunmei2002()
DECIDED = [  # mechanism, keyword, text, number in SI units, and what goes with it
    (SPRUNG, "initial", ["2 mm", "1 mm/s"], [2e-3, 1e-3], {}),
    (SPRUNG, "starts", [["2 mm", 0.0]], [[2e-3, 0.0]], {}),
    (
        SPRUNG,
        "plane",
        {"x": ["1 mm", "2 mm"], "v": {"start": "0 mm/s", "stop": "1 m/s", "num": 3}},
        {"x": [1e-3, 2e-3], "v": {"start": 0.0, "stop": 1.0, "num": 3}},
        {},
    ),
    (SPRUNG, "region", {"x": ["1 mm", "2 mm"]}, {"x": [1e-3, 2e-3]}, {}),
    (
        SPRUNG,
        "section",
        {"kind": "plane", "quantity": "x", "value": "1 mm"},
        {"kind": "plane", "quantity": "x", "value": 1e-3},
        {},
    ),
    (
        USUAL,
        "plane",
        {"clearance": ["10 µm", "0.1 mm"], "links.crank.mass": ["400 g", 0.5]},
        {"clearance": [1e-5, 1e-4], "links.crank.mass": [0.4, 0.5]},
        {},
    ),
    (USUAL, "start", "20 µm", 2e-5, {"plane": {"clearance": [1e-5, 1e-4], "gear_ratio": [2, 3]}}),
    (
        USUAL,
        "region",
        {"crank_speed": ["300 rpm", "3000 deg/s"], "w_coupler": ["10 deg/s", 1.0]},
        {"crank_speed": [31.41592653589793, 52.35987755982989], "w_coupler": [0.17453292519943295, 1.0]},
        {},
    ),
    (USUAL, "by", {"clearance": ["10 µm", "0.1 mm"]}, {"clearance": [1e-5, 1e-4]}, {}),
    (
        USUAL,
        "subject",
        {"largest:normal_force:B": ["0 N", "0.2 kN"]},
        {"largest:normal_force:B": [0.0, 200.0]},
        {},
    ),
    (SPRUNG, "subject", {"largest:state:x": ["0 mm", "2 mm"]}, {"largest:state:x": [0.0, 2e-3]}, {}),
    (SPRUNG, "limits", {"largest:state:x": "2 mm"}, {"largest:state:x": 2e-3}, {}),
    (
        USUAL,
        "limits",
        {"force:B": "2 kN", "impact_speed:B": "5 mm/s", "turn_period": "3 ms", "separations:B": 3},
        {"force:B": 2e3, "impact_speed:B": 5e-3, "turn_period": 3e-3, "separations:B": 3},
        {},
    ),
    (
        USUAL,
        "spreads",
        {"clearance": {"lognormal": ["10 µm", 1.2], "below": "0.1 mm"}, "mass": {"normal": [1, 2]}},
        {"clearance": {"lognormal": [1e-5, 1.2], "below": 1e-4}, "mass": {"normal": [1, 2]}},
        {},
    ),
]


def flat(value):
    if isinstance(value, dict):
        return [part for each in value.values() for part in flat(each)]
    if isinstance(value, list | tuple):
        return [part for each in value for part in flat(each)]
    return [value]


@pytest.mark.parametrize(
    ("mechanism", "name", "text", "value", "more"), DECIDED, ids=[f"{c[1]}-{c[0].name}" for c in DECIDED]
)
def test_a_keyword_whose_unit_the_mechanism_decides_takes_a_text(mechanism, name, text, value, more):
    found = in_own_units(mechanism, {name: text} | more)[name]
    assert (
        flat(found) == pytest.approx(flat(value))
        if not any(isinstance(v, str) for v in flat(value))
        else found == value
    )


def test_a_system_of_the_catalog_takes_its_shares_and_quantities_with_units():
    assert jp.catalog.impact_pair(3.0, "80 %") == jp.catalog.impact_pair(3.0, 0.8)
    asked = {"mean_load": 0.1, "amplitude": 0.2, "frequency": 1.6, "damping": 0.05}
    assert jp.catalog.gear_backlash(**asked, mesh="20 %") == jp.catalog.gear_backlash(**asked, mesh=0.2)
    texts = {"speed": "0.037 rad/ms", "mass": "1200 g", "stiffness": "1.4 N/mm", "damping": "2 N s/m"}
    cam = jp.catalog.cam_follower(**texts)
    assert cam == jp.catalog.cam_follower(speed=37.0, mass=1.2, stiffness=1400.0, damping=2.0)
    with pytest.raises(InputError, match="mm does not convert to a pure number"):
        jp.catalog.impact_pair(3.0, "80 mm")


def test_an_analysis_is_started_and_asked_in_units():
    moved = jp.simulate(SPRUNG, turns=0.1, initial=["2 mm", "1 mm/s"])
    assert moved["state_value"][0].values.tolist() == [2e-3, 1e-3]
    with pytest.raises(InputError, match=r"initial\[0\]: got '2 s'"):
        jp.simulate(SPRUNG, turns=0.1, initial=["2 s", 0.0])
