"""Numbers probably meant in another unit: refused where nobody can mean them, else doubted."""

import math

import pytest

import jointplay as jp
from jointplay.errors import InputError, ModelWarning
from jointplay.mechanism import catalog
from jointplay.mechanism.closure import ideal_state
from jointplay.mechanism.misreadings import FAST, HURRY, MAINS, SUNK, WIDE, doubts
from jointplay.mechanism.records import CrankAngle, Mechanism, Plane

USUAL = catalog.chunmei2002()
CRANK, RADIUS, NO_LOAD = 0.03, 0.015, USUAL.drive.nominal_speed


def found(mechanism=USUAL, initial=None, section=None):
    return {problem.key: problem.expected for problem in doubts(mechanism, initial, section)}


def refusal(call, *values, **given):
    with pytest.raises(InputError) as caught:
        call(*values, **given)
    return {problem.key: problem.expected for problem in caught.value.problems}


def geared(speed):
    return USUAL.replace(drive=USUAL.drive.model_copy(update={"synchronous_speed": speed}))


def test_a_clearance_as_long_as_a_link_is_refused():
    said = refusal(catalog.chunmei2002, clearance=0.29)["clearance.B"]
    assert said.startswith("a clearance less than 0.03 m is accepted, the length of crank")
    assert said.endswith("did you mean 0.29 mm = 0.00029 m?")
    assert "mm" not in refusal(catalog.chunmei2002, clearance=40.0)["clearance.B"]  # nor is 40 mm any better
    table = USUAL.model_dump()
    table["joints"][2]["clearance"] = CRANK
    assert set(refusal(Mechanism, **table)) == {"mechanism.joints[2].clearance"}
    table["joints"][2]["clearance"] = 0.99 * CRANK
    assert Mechanism(**table)


@pytest.mark.parametrize("angle", [180, -90.0, 6.2832])
def test_an_angle_beyond_a_turn_is_refused(angle):
    start = refusal(jp.simulate, USUAL, turns=1, initial={"crank_angle": angle})
    section = refusal(CrankAngle, angle=angle)
    assert set(start) == {"initial.crank_angle"}
    assert set(section) == {"crank_angle.angle"}
    for text in (*start.values(), *section.values()):
        assert f"if degrees are meant, write '{angle:g} deg' or {math.radians(angle):.6g}" in text
    assert CrankAngle(angle="-360 deg").angle == -math.tau


def test_nothing_usual_is_doubted():
    angles, speeds = ideal_state(USUAL, 0.5)
    assert found() == {}
    assert found(USUAL, {"crank_angle": math.tau, "crank_speed": HURRY * NO_LOAD}) == {}
    assert (
        found(USUAL, {"angle": angles, "angular_velocity": speeds}, Plane(quantity="angle", value=6.28)) == {}
    )
    assert found(geared(MAINS)) == found(USUAL.replace(speed=-FAST)) == {}
    assert found(USUAL.replace(clearance=WIDE * CRANK)) == found(catalog.duffing(), [1e6, 0.0]) == {}


def test_a_wide_clearance_is_doubted():
    said = found(USUAL.replace(clearance=1.01 * WIDE * CRANK))["mechanism.joints[2].clearance"]
    assert (
        said == "that is 0.1 of the shortest link and 0.2 of the journal's radius; "
        "did you mean 0.00303 mm = 3.03e-06 m?"
    )
    thin = USUAL.joints[2].model_copy(update={"radius": 1e-4, "clearance": 1.1e-4})
    narrow = USUAL.model_copy(update={"joints": (*USUAL.joints[:2], thin, USUAL.joints[3])})
    assert "1.1 of the journal's radius" in found(narrow)["mechanism.joints[2].clearance"]


def test_a_motor_in_rpm_is_doubted():
    said = found(geared(1500.0))["mechanism.drive.synchronous_speed"]
    assert said.startswith("1500 rad/s are 14324 rpm, faster than any motor on the mains")
    assert said.endswith("if 1500 rpm are meant, write '1500 rpm' or 157.08")
    assert "write '-1500 rpm' or -157.08" in found(USUAL.replace(speed=-1500.0))["mechanism.drive.speed"]
    assert (
        "6 times what the drive turns at"
        in found(USUAL, {"crank_speed": -6 * NO_LOAD})["initial.crank_speed"]
    )


def test_a_start_in_degrees_or_with_few_digits_is_doubted():
    angles, speeds = ideal_state(USUAL, 0.5)
    turned = {"angle": angles | {"crank": angles["crank"] + 2 * math.tau}, "angular_velocity": speeds}
    assert set(found(USUAL, turned)) == {"initial.angle.crank"}

    def deep(depth):  # the rocker's pin, 0.1175 m from its pivot, moved by so many clearances and one
        shift = (depth + 1) * 2.9e-5 / 0.1175
        start = {"angle": angles | {"rocker": angles["rocker"] + shift}, "angular_velocity": speeds}
        return found(USUAL, start)

    assert deep(0.99 * SUNK) == {}
    assert "the journal of B starts 3 clearances deep" in deep(3.0)["initial.angle"]
    assert (
        "if degrees are meant, write '180 deg'"
        in found(section=Plane(quantity="angle", value=180))["section.value"]
    )


def test_an_analysis_warns_of_a_doubt_its_caller():
    with pytest.warns(
        ModelWarning, match=r"^initial.crank_speed: got 200.0; 200 rad/s are 1909.9 rpm"
    ) as caught:
        jp.simulate(USUAL, turns=0.01, initial={"crank_speed": 200.0})
    assert [warning.filename for warning in caught] == [__file__]
