"""Numbers probably meant in another unit: refused where nobody can mean them, else doubted."""

import math
import tomllib
from pathlib import Path

import pytest

import jointplay as jp
from jointplay.analysis.keywords import doubts
from jointplay.cli import main
from jointplay.display.errors import InputError, ModelWarning
from jointplay.solver.mechanism import catalog, plausible
from jointplay.solver.mechanism.catalog.presets import four_bar_pins
from jointplay.solver.mechanism.loops import ideal
from jointplay.solver.mechanism.loops.ideal import ideal_state
from jointplay.solver.mechanism.plausible import BRISK, FAST, HURRY, MAINS, SUNK, WIDE
from jointplay.solver.mechanism.records import (
    ConstantSpeed,
    Contact,
    CrankAngle,
    Force,
    Friction,
    Joint,
    Link,
    Mechanism,
    Pin,
    Plane,
    PrescribedTorque,
    Servo,
    Spring,
    System,
    TorsionSpring,
)
from jointplay.study.file import load
from jointplay.study.models import build_mechanism
from tests.docs.pages import PAGES, blocks
from tests.support.wrong import refused

USUAL = catalog.chunmei2002()
CRANK, RADIUS, NO_LOAD = 0.03, 0.015, USUAL.drive.nominal_speed


def found(mechanism=USUAL, initial=None, section=None):
    return {problem.key: problem.expected for problem in doubts(mechanism, initial, section)}


def geared(speed):
    return USUAL.replace(drive=USUAL.drive.model_copy(update={"synchronous_speed": speed}))


def test_what_fields_accept_is_read_once_for_each_kind_of_record(monkeypatch):
    """A sweep or a curve makes thousands of copies: types are not read anew for every number of each."""
    plain = catalog.chunmei2002(clearance=2e-5)

    def again(field):
        raise AssertionError("read again")

    monkeypatch.setattr(plausible, "units_of", again)
    monkeypatch.setattr(plausible, "bounds_of", again)
    assert plain.replace(clearance=3.1e-5).clearance_joints[0].clearance == 3.1e-5
    with pytest.raises(InputError, match="mass"):
        plain.replace(**{"links.coupler.mass": 1e-200})


def test_a_clearance_as_long_as_a_link_is_refused():
    said = refused(catalog.chunmei2002, clearance=0.29)["clearance.B"]
    assert said.startswith("a clearance less than 0.03 m is accepted, the length of crank")
    assert said.endswith("did you mean 0.29 mm = 0.00029 m?")
    assert "mm" not in refused(catalog.chunmei2002, clearance=40.0)["clearance.B"]  # nor is 40 mm any better
    table = USUAL.model_dump()
    table["joints"][2]["clearance"] = CRANK
    assert set(refused(Mechanism, **table)) == {"mechanism.joints[2].clearance"}
    table["joints"][2]["clearance"] = 0.99 * CRANK
    assert Mechanism(**table)


@pytest.mark.parametrize("angle", [180, -90.0, 6.2832])
def test_an_angle_beyond_a_turn_is_refused(angle):
    start = refused(jp.simulate, USUAL, turns=1, initial={"crank_angle": angle})
    section = refused(CrankAngle, angle=angle)
    assert set(start) == {"initial.crank_angle"}
    assert set(section) == {"crank_angle.angle"}
    for text in (*start.values(), *section.values()):
        assert f"if degrees are meant, write '{angle:g} deg' or {math.radians(angle):.6g}" in text
    assert CrankAngle(angle="-360 deg").angle == -math.tau


def test_nothing_usual_is_doubted():
    angles, speeds, _ = ideal_state(USUAL, 0.5)
    assert found() == {}
    assert found(USUAL, {"crank_angle": math.tau, "crank_speed": HURRY * NO_LOAD}) == {}
    assert (
        found(USUAL, {"angle": angles, "angular_velocity": speeds}, Plane(quantity="angle", value=6.28)) == {}
    )
    usual_speeds = (BRISK - 10, 2 * BRISK + 3.2, FAST - 0.5)
    assert found(geared(MAINS)) == {}
    assert [found(USUAL.replace(speed=-speed)) for speed in usual_speeds] == [{}] * 3
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
    angles, speeds, _ = ideal_state(USUAL, 0.5)
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
    told = [warning for warning in caught if "rpm" in str(warning.message)]
    assert [warning.filename for warning in told] == [__file__]


def four_bar(coupler, crank, rocker, ground, clearance=0.0, drive=None, **more):
    """A four-bar of 1 kg links, in m, which a constant speed drives if nothing else does."""
    lengths = {"crank": crank, "coupler": coupler, "rocker": rocker}
    links = tuple(
        Link(name=name, length=length, mass=1.0, inertia_centre=length**2 / 12)
        for name, length in lengths.items()
    )
    pins = four_bar_pins(crank, coupler, rocker, ground)
    play = {"clearance": clearance, "radius": 0.01, "contact": Contact(stiffness=1e7, damping=300.0)}
    joints = tuple(
        Joint(name=name, journal=one, bearing=two, **(play if name == "B" else {}))
        for name, (one, two) in pins.items()
    )
    drive = drive or ConstantSpeed(link="crank", speed=30.0)
    return Mechanism(links=links, joints=joints, drive=drive, **more)


STUCK = (0.05, 0.04, 0.11, 0.17)  # coupler, crank, rocker, ground: b + c = 0.16 m are short of 0.21 m
LIMIT = math.acos((0.04**2 + 0.17**2 - 0.16**2) / (2 * 0.04 * 0.17))  # by the cosine rule


@pytest.mark.parametrize("clearance", [0.0, 1e-4])
def test_a_crank_that_is_driven_where_it_cannot_turn_is_refused(clearance):
    linkage = four_bar(*STUCK, clearance)
    for analysis in (jp.simulate, jp.poincare, jp.lyapunov):
        said = refused(analysis, linkage, turns=1)["mechanism.links"]
        assert f"from {LIMIT:.4g} to {math.tau - LIMIT:.4g} rad" in said
        assert f"({math.degrees(LIMIT):.4g} to {360 - math.degrees(LIMIT):.4g} deg)" in said
    assert "mechanism.links" in refused(jp.periodic_orbit, linkage)
    start = {"crank_angle": LIMIT - 0.4}
    assert "mechanism.links" in refused(jp.simulate, linkage, duration=0.41 / 30, initial=start)
    assert jp.simulate(linkage, duration=0.39 / 30, initial=start, samples_per_turn=40).sizes["time"]
    back = four_bar(*STUCK, clearance, drive=ConstantSpeed(link="crank", speed=-30.0))
    assert "mechanism.links" in refused(jp.simulate, back, turns=0.5)


def test_a_crank_turns_where_its_joints_clearances_make_up_for_what_lacks():
    almost = (0.05, 0.04, 0.11995, 0.13)  # 0.16995 of 0.17 m
    assert "mechanism.links" in refused(jp.simulate, four_bar(*almost), turns=1)
    assert jp.simulate(four_bar(*almost, 1e-4), turns=0.01).sizes["time"]


def test_a_linkage_that_goes_flat_is_no_open_one():
    assert 0.1 + 0.2 > 0.3  # in floats: crank and ground against coupler and rocker
    flat = four_bar(0.1, 0.1, 0.2, 0.2)
    assert not list(ideal.cannot_turn(flat, 0.0, math.tau))
    assert not list(ideal.cannot_turn(four_bar(0.15, 0.1, 0.15, 0.2), 0.0, math.tau))
    assert list(ideal.cannot_turn(four_bar(0.15, 0.1, 0.15 - 1e-9, 0.2), 0.0, math.tau))


def test_a_slider_crank_and_a_motor_that_cannot_turn_are_told():
    short = catalog.slider_crank(crank=0.1, rod=0.08, clearance=0)
    said = refused(jp.simulate, short, turns=1)["mechanism.links"]
    for edge in (
        math.asin(0.8),
        math.pi - math.asin(0.8),
        math.pi + math.asin(0.8),
        math.tau - math.asin(0.8),
    ):
        assert f"{edge:.4g}" in said
    stuck = four_bar(*STUCK, drive=USUAL.drive)
    assert "does not close" in found(stuck)["mechanism.links"]  # it may rock


@pytest.mark.parametrize("drive", ["torque", "servo"])
def test_a_crank_that_a_torque_or_a_servo_drives_round_and_that_cannot_turn_is_doubted(drive):
    """A servo whose mean speed is 0 swings where it is meant to."""
    torque = PrescribedTorque(link="crank", constant=1.0, nominal_speed=10.0)
    round_, swinging = (
        Servo(link="crank", stiffness=10.0, damping=1.0, speed=speed, nominal_speed=10.0) for speed in (10, 0)
    )
    driven = four_bar(0.05, 0.04, 0.11, 0.17, 1e-4, torque if drive == "torque" else round_)
    assert "the loop does not close at angles of crank from 1.2" in found(driven)["mechanism.links"]
    assert found(four_bar(0.05, 0.04, 0.11, 0.17, 1e-4, swinging)) == {}


def test_grams_taken_as_kilograms_are_doubted_of_a_long_link_too():
    links = [link.model_copy(update={"mass": 1743.0, "inertia": 60.0}) for link in USUAL.links]
    heavy = USUAL.model_copy(update={"links": tuple(links)})
    said = found(heavy)["mechanism.links[1].mass"]
    assert said.endswith(
        "as long, wide and high as the longest link, 0.181 m; did you mean 1743 g? Then write "
        "'1743 g' or 1.743"
    )


def test_millimetres_are_asked_for_where_the_inertia_is_in_metres():
    told = refused(Link, name="rocker", length=117.5, mass=0.3, centre=58.75, inertia=1.34e-3)
    assert told["link.inertia"].endswith("; did you mean 117.5 mm = 0.1175 m?")


def test_millimetres_taken_as_metres_are_refused_or_doubted():
    said = refused(four_bar, 120.0, 40.0, 80.0, 120.0)
    assert said["mechanism.links[1].length"].endswith("did you mean 120 mm = 0.12 m?")
    assert len(said) == 3
    heavy = [each.model_copy(update={"mass": 1e4}) for each in USUAL.links]
    rod = heavy[1].model_copy(update={"length": 11.0, "inertia": 1e6})
    odd = USUAL.model_copy(update={"links": (heavy[0], rod, heavy[2])})
    assert found(odd)["mechanism.links[1].length"].endswith("did you mean 11 mm = 0.011 m?")
    spring = Spring(
        name="S", **{"from": Pin(link="crank", at=0.03), "to": Pin(link="ground", point=(0, 0.1))},
        stiffness=1.0, free_length=80.0,
    )  # fmt: skip
    assert found(USUAL.replace(springs=[spring]))["mechanism.springs[0].free_length"].endswith(
        "did you mean 80 mm = 0.08 m?"
    )


@pytest.mark.parametrize("speed", [300.0, -500.0, 1500.0])
def test_a_round_fast_speed_is_doubted_as_rpm(speed):
    assert f"write '{speed:g} rpm'" in found(USUAL.replace(speed=speed))["mechanism.drive.speed"]
    assert found(USUAL.replace(speed=f"{speed:g} rpm")) == {}


def with_crank(**changes):
    """The usual linkage with another crank, by way of its table."""
    table = USUAL.model_dump(mode="json")
    table["links"][0] |= changes
    return Mechanism(**table)


DOUBTED = {  # of a crank of 30 mm and 0.4489 kg: key, value, unit
    "inertia_centre": (2.0, "kg cm²"),
    "mass": (448.9, "g"),
    "centre": (0.15, ""),
}
REFUSED = {"inertia_centre": (150.0, "kg mm²"), "mass": (1e300, ""), "centre": (15.0, "mm")}


@pytest.mark.parametrize("key", [*DOUBTED])
def test_inertia_mass_and_centre_of_no_link_are_refused_or_doubted(key):
    more = {} if key == "inertia_centre" else {"inertia_centre": 1e-4}
    value, unit = DOUBTED[key]
    told = found(with_crank(**{"inertia": None} | more | {key: value}))
    assert set(told) == {f"mechanism.links[0].{key}"}
    assert not unit or f"write '{value:g} {unit}'" in told[f"mechanism.links[0].{key}"]
    assert (
        found(
            with_crank(
                **{"inertia": None} | more | {key: value},
            ).replace(as_meant=True)
        )
        == {}
    )
    value, unit = REFUSED[key]
    said = refused(with_crank, **{"inertia": None} | more | {key: value})
    assert set(said) == {f"mechanism.links[0].{key}"}
    assert not unit or f"write '{value:g} {unit}'" in said[f"mechanism.links[0].{key}"]


def test_the_unit_is_asked_for_where_a_link_has_its_mass_far_out():
    """The radius of gyration that is meant is 1.2 lengths, as of a crank with a flywheel beyond its end."""
    said = refused(with_crank, inertia=None, inertia_centre=6.0)
    assert "write '6 kg cm²'" in said["mechanism.links[0].inertia_centre"]


@pytest.mark.parametrize("gravity", [9810.0, -9810.0])
def test_gravity_in_millimetres_is_doubted(gravity):
    said = found(USUAL.replace(gravity=gravity))["mechanism.gravity"]
    assert "1000 times that of the Earth, 9.81 m/s²" in said
    assert said.endswith(f"write '{gravity:g} mm/s²' or {gravity / 1000:g}")
    assert found(USUAL.replace(gravity=f"{gravity:g} mm/s²")) == {}
    assert found(USUAL.replace(gravity=gravity, as_meant=True)) == {}
    assert found(USUAL.replace(gravity=24.8)) == {}  # of Jupiter


LOOSE = USUAL.replace(clearance=4e-5)
(AT,) = (i for i, joint in enumerate(LOOSE.joints) if not joint.ideal)


def test_a_coefficient_of_friction_in_percent_is_doubted():
    rubbed = {name: LOOSE.replace(friction=value) for name, value in (("40", 40.0), ("1.5", 1.5))}
    said = found(rubbed["40"])[f"mechanism.joints[{AT}].friction.coefficient"]
    assert said.endswith("did you mean 40 %? Then write '40 %' or 0.4")
    assert found(rubbed["40"].replace(as_meant=True)) == found(rubbed["1.5"]) == {}
    assert found(LOOSE.replace(friction="40 %")) == {}


@pytest.mark.parametrize(("stiffness", "unit"), [(20.0, "N/µm"), (300.0, "N/µm"), (9e2, "N/µm")])
def test_a_contact_into_which_the_links_weight_sinks_is_doubted(stiffness, unit):
    key = f"mechanism.joints[{AT}].contact.stiffness"
    soft = LOOSE.replace(**{key.removeprefix("mechanism."): stiffness})
    said = found(soft)[key]
    assert said.startswith("the weight of the links, ")
    assert said.endswith(f"write '{stiffness:g} {unit}' or {stiffness * 1e6:.6g}")
    assert found(soft.replace(as_meant=True)) == found(soft.replace(gravity=0)) == {}


def test_a_pin_longer_than_every_link_is_doubted():
    key = f"mechanism.joints[{AT}].radius"
    wide = LOOSE.replace(**{key.removeprefix("mechanism."): 10.0})
    assert found(wide)[key].endswith("did you mean 10 mm = 0.01 m?")
    assert found(wide.replace(as_meant=True)) == {}


def test_a_whole_turn_is_an_angle_in_radians():
    table = USUAL.model_dump(mode="json")
    assert found(Mechanism(**table | {"guess": {"crank": math.tau}})) == {}
    beyond = found(Mechanism(**table | {"guess": {"crank": 1.001 * math.tau}}))
    assert set(beyond) == {"mechanism.guess.crank"}


def test_a_link_lighter_than_air_is_doubted():
    said = found(with_crank(mass=1e-8, inertia=None, inertia_centre=1e-12))
    assert "lighter than the air" in said["mechanism.links[0].mass"]


@pytest.mark.parametrize("angle", [180, -90.0, 6.2832])
def test_directions_in_degrees_are_refused(angle):
    meant = f"if degrees are meant, write '{angle:g} deg' or {math.radians(angle):.6g}"
    on = {"name": "P", "on": Pin(link="crank", at=0.03), "constant": 5.0}
    assert meant in refused(Force, **on, direction=angle)["load.direction"]
    assert meant in refused(USUAL.replace, gravity_direction=angle)["gravity_direction"]
    assert meant in refused(Pin, link="ground", point=(0.0, 0.0), direction=angle)["pin.direction"]
    assert Force(**on, direction="180 deg").direction == math.pi
    rough = USUAL.model_copy(update={"guess": {"coupler": 30.0}})
    assert "if degrees are meant, write '30 deg'" in found(rough)["mechanism.guess.coupler"]


def test_parts_that_contradict_themselves_are_refused():
    bristles = {"bristle_stiffness": 1e5, "static_coefficient": 0.1, "stribeck_velocity": 1e-3}
    table = USUAL.model_dump()
    table["joints"][2]["friction"] = Friction(law="lugre", coefficient=0.0, **bristles).model_dump()
    assert set(refused(Mechanism, **table)) == {"mechanism.joints[2].friction.coefficient"}
    servo = {"link": "crank", "stiffness": 1.0, "damping": 0.1, "speed": 5.0}
    said = refused(USUAL.replace, drive=Servo(**servo, nominal_speed=-5.0))
    assert "of the sign of the mean wanted one (5 rad/s)" in said["mechanism.drive.nominal_speed"]
    assert USUAL.replace(drive=Servo(**servo, nominal_speed=5.0))


def test_a_state_that_grows_for_ever_is_doubted():
    swung = {"states": {"x": 1.0, "v": 0.0, "phi": 0.0}, "parameters": {"w": 2.0}}
    rates = {"x": "v", "v": "cos(phi) - x", "phi": "w"}
    said = found(System(**swung, rates=rates))["mechanism.rates.phi"]
    assert said.endswith("write w*t for it, and its period as forcing = '2*pi/w'")
    assert found(System(**swung, rates=rates, as_meant=True)) == {}
    clock = [{"name": "tick", "guard": "1 - phi", "jump": {"phi": "phi - 1"}}]
    assert found(System(**swung, rates=rates, jumps=clock)) == {}


def test_files_are_judged_as_python_is(tmp_path, capsys):
    path = tmp_path / "a.toml"
    head = 'kind = "response"\n[analysis]\nturns = 1\n[mechanism]\ncatalog = "slider_crank"\n'
    path.write_text(head + "crank = 0.1\nrod = 0.08\nclearance = 0\n")
    assert main(["check", str(path)]) == 2
    assert "mechanism.links: got {'crank': 0.1" in capsys.readouterr().err
    path.write_text(head + "speed = 300\n")
    assert main(["check", str(path)]) == 0
    assert "if 300 rpm are meant" in capsys.readouterr().err
    path.write_text(head + '[vary]\n"joints.B.journal.at" = [0.12, 0.04, 0.1]\n')
    assert main(["check", str(path)]) == 0
    assert "vary.joints.B.journal.at: got 0.04; its cells fail: lengths" in capsys.readouterr().err
    press = '[[mechanism.loads]]\nname = "press"\nkind = "force"\non = { link = "slider" }\ndirection = 0.0\n'
    press += 'angle = "%s"\nharmonics = [{ order = 1, sine = 9.0 }]\n'
    path.write_text(head + press % "slider")
    assert main(["check", str(path)]) == 0
    said = capsys.readouterr().err
    assert "loads[0].angle: got 'slider'; slider slides and does not turn" in said, said
    path.write_text(head + press % "crank")
    assert main(["check", str(path)]) == 0
    assert capsys.readouterr().err == ""
    path.write_text(head + "speed = 300\nas_meant = true\n")
    assert main(["check", str(path)]) == 0
    assert capsys.readouterr().err == ""


STUDIES = sorted((Path(__file__).parents[2] / "studies").rglob("*.toml"))


@pytest.mark.parametrize(
    "path", [each for each in STUDIES if each.parent.name != "own"], ids=lambda path: path.stem
)
def test_nothing_is_doubted_in_a_shipped_study(path):
    assert load(path).record.doubts() == []


def tables():
    """Mechanisms of shipped systems, and of the pages where one is written out."""
    for path in STUDIES:
        if path.parent.name == "own":
            yield path.stem, tomllib.loads(path.read_text())["mechanism"]
    for page in PAGES:
        for i, block in enumerate(blocks(page)):
            table = tomllib.loads(block.text).get("mechanism", {}) if block.language == "toml" else {}
            if {"catalog", "links", "rates"} & table.keys():
                yield f"{page.stem}-{i}", table


@pytest.mark.parametrize(("name", "table"), [*tables()], ids=[name for name, _ in tables()])
def test_nothing_is_doubted_in_a_shipped_system_or_an_example(name, table):
    assert found(build_mechanism(table)) == {}


@pytest.mark.parametrize("name", [*catalog.NAMES])
def test_nothing_is_doubted_in_the_catalog(name):
    assert found(catalog.NAMES[name](**catalog.NAMES[name].trial)) == {}


@pytest.mark.parametrize(
    "wrong", [{"static_coefficient": 0.0}, {"bristle_stiffness": "1e5 N/m"}, {"stribeck_velocity": -1.0}]
)
def test_a_number_that_its_law_refuses_is_told_once(wrong):
    right = {"static_coefficient": 0.15, "bristle_stiffness": 1e5, "stribeck_velocity": 0.1}
    friction = {"law": "lugre", "coefficient": 0.1} | right | wrong
    with pytest.raises(InputError) as caught:
        Joint(name="O", journal=Pin(link="crank"), bearing=Pin(link="rod"), friction=friction)
    assert [problem.given for problem in caught.value.problems] == [*wrong.values()]


@pytest.mark.parametrize(
    ("changes", "key", "meant"),
    [
        ({"elastic": True, "beam": {"modulus": 210.0}}, "beam.modulus", "210 GPa"),
        ({"elastic": True, "beam": {"modulus": 70_000.0}}, "beam.modulus", "70000 MPa"),
        ({"elastic": True, "beam": {"density": 7.8}}, "beam.density", "7.8 g/cm³"),
        ({"masses": [{"at": 3.0, "mass": 0.1}]}, "masses[0].at", "3 cm"),
        ({"masses": [{"at": 0.02, "mass": 50.0}]}, "masses[0].mass", "50 g"),
    ],
)
def test_materials_and_point_masses_in_another_unit_are_doubted(changes, key, meant):
    crank = Link(**{"name": "crank", "length": 0.04, "mass": 0.25, "inertia": 1.4e-4} | changes)
    assert (
        f"did you mean {meant}?"
        in found(USUAL.model_copy(update={"links": (crank, *USUAL.links[1:])}))[f"mechanism.links[0].{key}"]
    )


def test_a_section_at_an_eccentricity_that_no_journal_reaches_is_doubted():
    far = Plane(quantity="eccentricity", joint="B", value=20.0, direction="up")
    assert "did you mean 20 µm?" in found(section=far)["section.value"]
    assert found(section=far.model_copy(update={"value": 2e-5})) == {}


def test_a_torsion_spring_that_starts_wound_by_a_turn_is_doubted():
    """Links' angles at the start lie within half a turn of 0: beyond it a turn is missed."""

    def doubted(angle, **more):
        spring = TorsionSpring(**{"from": "rocker"}, name="coil", to="ground", stiffness=2.0, angle=angle)
        sprung = four_bar(0.12, 0.04, 0.08, 0.12, 1e-4, springs=(spring,), **more)
        return [key for key in found(sprung) if "springs" in key]

    assert not doubted(1.0)
    assert doubted(1.0 + 2 * math.pi) == ["mechanism.springs[0].angle"]
    assert not doubted(1.0 + 2 * math.pi, as_meant=True)
