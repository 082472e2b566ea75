"""Values written with their unit: what they come to, in which records, and what is refused in which words."""

import math
import subprocess
import sys
from dataclasses import replace

import pytest

from jointplay.display.errors import InputError
from jointplay.solver.equations.laws import LAWS
from jointplay.solver.equations.quantity import Quantity
from jointplay.solver.mechanism import catalog, measures
from jointplay.solver.mechanism.measures import in_si
from jointplay.solver.mechanism.records import Contact, CrankAngle, Link, MotorLine, Pin

INCH, POUND, STANDARD_GRAVITY = 0.0254, 0.45359237, 9.80665  # exact by definition


@pytest.mark.parametrize(
    ("text", "units", "value"),
    [
        ("0.29 mm", "m", 2.9e-4),
        ("0.29mm", "m", 2.9e-4),
        ("29 µm", "m", 2.9e-5),
        ("-1 inch", "m", -INCH),
        ("1500 rpm", "rad/s", 50 * math.pi),
        ("1 turn/s", "rad/s", math.tau),
        ("30 deg", "rad", math.pi / 6),
        ("180°", "rad", math.pi),
        ("2.2 kgf*m", "N m", 2.2 * STANDARD_GRAVITY),
        ("1 lbf inch", "N m", POUND * STANDARD_GRAVITY * INCH),
        ("3 kNm", "N m", 3e3),
        ("7.15 kN/mm", "N/m", 7.15e6),
        ("228 N s/m", "N s/m", 228.0),
        ("210 GPa", "Pa", 2.1e11),
        ("7.8 g/cm^3", "kg/m³", 7800.0),
        ("150 kg mm²", "kg m²", 1.5e-4),
        ("2 cm^4", "m⁴", 2e-8),
        ("1e3 mm/s²", "m/s²", 1.0),
        ("1 N/mm^1.5", "N/m^1.5", 1000**1.5),
        ("5 %", "1", 0.05),
        ("0 mm", "m", 0.0),
    ],
)
def test_a_text_with_a_unit_is_the_number_in_the_fields_unit(text, units, value):
    assert in_si(text, units) == pytest.approx(value, rel=1e-15)


def test_texts_inside_lists_and_tables():
    assert in_si(["1 cm", 2.0], "m") == [0.01, 2.0]
    assert in_si({"B": "1 mm", "C": 0}, "m") == {"B": 1e-3, "C": 0}
    assert in_si([{"a": "1 mm", "b": "1 ms", "c": "1 mm"}], {"a": "m", "b": "s"}) == [
        {"a": 1e-3, "b": 1e-3, "c": "1 mm"}
    ]


@pytest.mark.parametrize(
    "text", ["0.29", "mm", "1,5 mm", "mm 3", "1 mm; 2", "two mm", "", "1_0 mm", "x" * 99]
)
def test_what_is_no_number_with_a_unit_stays_a_text(text):
    assert in_si(text, "m") is text


@pytest.mark.parametrize(
    ("text", "units", "said"),
    [
        ("0.29 kg", "m", "a number, or one with a unit such as m, is accepted; kg does not convert to m"),
        ("1 N m/rad", "N m", "N m/rad does not convert to N m"),
        ("50 Hz", "rad/s", "Hz does not convert to rad/s"),
        ("30 deg", "1", "a pure number, or a share in %, is accepted; deg does not convert to a pure number"),
        ("0.29 furlongs/", "m", "'furlongs/' is not a known unit"),
        ("1 m^m", "m", "'m^m' is not a known unit"),
        ("1 __import__('os')", "m", None),
        ("1e-60 m", "m", "a number between 1e-50 and 1e50 m in size is accepted"),
        ("1e999 mm", "m", "a number between 1e-50 and 1e50 m in size is accepted"),
    ],
)
def test_a_unit_of_something_else(text, units, said):
    if said is None:  # not even read as a unit
        assert in_si(text, units) == text
        return
    with pytest.raises(InputError) as caught:
        in_si(text, units)
    (problem,) = caught.value.problems
    assert (problem.key, problem.given) == ("", text)
    assert said in problem.expected


def test_records_take_them():
    motor = MotorLine(
        link="crank",
        gear_ratio=3,
        efficiency="80 %",
        synchronous_speed="3000 rpm",
        rated_speed="2825 rpm",
        rated_torque="2.2 kgf m",
    )
    assert motor.no_load_speed == pytest.approx(0.8 * 100 * math.pi / 3)
    assert motor.synchronous_speed == pytest.approx(100 * math.pi, rel=1e-15)
    link = Link(name="a", length="3 cm", mass="200 g", inertia="1 kg cm²", beam={"modulus": "70 GPa"})
    assert (link.length, link.centre, link.mass, link.inertia) == (0.03, 0.015, 0.2, 1e-4)
    assert link.beam.modulus == 7e10
    assert Pin(link="ground", point=["30 mm", 0]).point == (0.03, 0)
    assert CrankAngle(angle="-90 deg").angle == -math.pi / 2
    assert Contact(stiffness="7.15 kN/mm", damping=228.0).stiffness == 7.15e6
    several = catalog.chunmei2002(clearance={"B": "0.29 mm", "C": 2.9e-5})
    assert [joint.clearance for joint in several.clearance_joints] == [2.9e-4, 2.9e-5]


def test_every_wrong_unit_is_named_at_once_with_its_key():
    with pytest.raises(InputError) as caught:
        Link(name="a", length="3 kg", mass="two kg", inertia="1 kg cm", beam={"area": "3 mm"})
    found = {problem.key: problem for problem in caught.value.problems}
    assert set(found) == {"link.length", "link.mass", "link.inertia", "link.beam.area"}
    assert found["link.length"].given == "3 kg"
    assert "as a number or a text with its unit such as '3 kg', is accepted" in found["link.mass"].expected
    with pytest.raises(InputError, match=r"^pin.point\[1\]: got '1 s'"):
        Pin(link="ground", point=["30 mm", "1 s"])


def test_a_law_says_the_units_of_its_own_numbers(monkeypatch):
    bare = LAWS["kelvin_voigt"]
    further = {"speed": Quantity("v", "m/s"), "power": Quantity("n", "1")}
    monkeypatch.setitem(LAWS, "powered", replace(bare, numbers=bare.numbers | further))
    contact = {"law": "powered", "stiffness": 1.0, "damping": 0.0}
    parameters = Contact(**contact, parameters={"speed": "2 mm/s", "power": 1.5}).parameters
    assert parameters == {"speed": 2e-3, "power": 1.5}
    with pytest.raises(
        InputError, match=r"^contact.parameters.speed: got '2 mm'.* mm does not convert to m/s$"
    ):
        Contact(**contact, parameters={"speed": "2 mm", "power": 1.5})


def test_the_units_library_is_loaded_by_the_first_such_text_alone():
    code = (
        "import sys, jointplay.study.file as f, jointplay as jp\n"
        "m = {'catalog': 'chunmei2002', 'clearance': 1e-4}\n"
        "s = {'kind': 'response', 'name': 'a', 'title': '2 mm', 'mechanism': m, 'analysis': {'turns': 1}}\n"
        "f.validate(s); print('pint' in sys.modules)\n"
        "f.validate(s | {'mechanism': m | {'clearance': '0.1 mm'}}); print('pint' in sys.modules)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["False", "True"]


def test_a_units_library_that_does_not_load_is_no_fault_of_the_unit(monkeypatch):
    monkeypatch.setitem(sys.modules, "pint", None)
    for kept in (measures._registry, measures._base):
        kept.cache_clear()
    with pytest.raises(ImportError):
        in_si("2 rad/s", "rad/s")
