"""The solver in Node: the same motions as compiled, from the same text of equations and method."""

from itertools import product

import numpy as np
import pytest

import jointplay as jp
from jointplay.analysis.quantities import EVENTS
from jointplay.solver.codegen.reader import RefusedError
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.loops.positions import origins
from jointplay_page import live
from jointplay_page.script import solver as solver_module
from jointplay_page.script.sliders import WITHIN, followed
from jointplay_page.script.solver import RECORDED, solver, solver_text
from tests.support.driven_scenes import written
from tests.support.laws_grid import mechanism as grid

from .in_node import needs_node, ran

pytestmark = needs_node
RTOL = 1e-10
PAPER = jp.catalog.chunmei2002
TWO_JOINTS = {"B": 2.9e-5, "C": 2.9e-5}
TURNS = """
const solver = makeSolver(data);
const found = solver.run(2, { samples: 8 });
return { ...found, state: solver.state() };
"""


STATES = ("angle", "angular_velocity", "state_value", "slide_position")
SCENES = {  # the paper's cases by their letters
    "A": lambda: PAPER(),
    "B": lambda: PAPER(gear_ratio=3.0),
    "C": lambda: PAPER(gear_ratio=3.0, clearance=2.9e-4),
    "sticking": lambda: PAPER(gear_ratio=3.0, friction=0.3),
    "no tension": lambda: PAPER(gear_ratio=3.0, tension=False),
    "two joints": lambda: PAPER(gear_ratio=3.0, clearance=TWO_JOINTS),
    "slider-crank": lambda: jp.catalog.slider_crank(clearance={"B": 1e-4}),
    "elastic": lambda: PAPER(gear_ratio=3.0, elastic=["coupler"]),
    "remembered speeds": lambda: grid("four_bar", "flores", "stribeck", False),
    "implicit law": lambda: grid("four_bar", "johnson", "lugre", False),
    "guide": lambda: jp.catalog.slider_crank(clearance={"G": 1e-4}),
    "rigid bearing": lambda: grid("four_bar", "restitution", "none", False),
    "soft impacts": lambda: jp.catalog.soft_impact_pair(gap=0.4, stiffness=100.0, damping=1.0, tension=False),
    "impacts": lambda: jp.catalog.impact_pair(gap=0.4, restitution=0.8),
    "rests": lambda: jp.catalog.impact_pair(gap=0.4, restitution=0.6),
    "own equations": lambda: written("impact_oscillator"),
}
FINE = {"implicit law": 1e-12}  # where one contact ends so slowly that its time is known no better at RTOL
CUT = {"A", "C"}  # by a section


def events(motion):
    """Times, and names with kinds, of a motion's events."""
    joints = motion.event_joint.attrs["flag_meanings"].split()
    kinds = [EVENTS[kind] for kind in motion.event_kind.values]
    return motion.event_time.values, [
        (joints[j + 1], k) for j, k in zip(motion.event_joint.values, kinds, strict=True)
    ]


@pytest.mark.nightly
@pytest.mark.parametrize("name", SCENES)
def test_two_turns_are_the_compiled_ones(name, tmp_path):
    mechanism = SCENES[name]()
    section = jp.CrankAngle() if name in CUT else None
    rtol = FINE.get(name, RTOL)
    names = (*RECORDED, "eccentricity_ratio", "normal_velocity", "deflection")
    script = solver(mechanism, rtol=rtol, section=section, names=names)
    found = ran(script.text, script.data, TURNS, tmp_path)
    names = list(dict.fromkeys(q["name"] for q in script.data["quantities"]))
    motion = jp.simulate(mechanism, turns=2, rtol=rtol, record=names, samples_per_turn=4, section=section)
    times, kinds = events(motion)
    assert found["status"] == "ok"
    assert [(each["joint"], each["kind"]) for each in found["events"]] == kinds
    np.testing.assert_allclose(
        [each["time"] for each in found["events"]], times, rtol=0, atol=1e-9 * times[-1:].max(initial=1)
    )
    assert found["turns_done"] == pytest.approx(2, rel=1e-15)
    np.testing.assert_allclose(found["time"], motion.time.values[1:], rtol=1e-14)
    for quantity in names:
        here, there = found[quantity], motion[quantity]
        share = 1e-9 if quantity in STATES else 1e-6  # differences of what is far larger
        for label, series in here.items():
            expected = (there.sel({there.dims[1]: label}) if label else there).values[1:]
            most = share * max(float(np.abs(there).max()), 1e-300)
            np.testing.assert_allclose(series, expected, rtol=0, atol=most, err_msg=f"{quantity} {label}")


LARGEST = """
const solver = makeSolver(data);
return solver.run(3, { closely: true, extremes: true }).largest;
"""


@pytest.mark.nightly
@pytest.mark.parametrize("name", ["sticking", "C", "slow", "two joints"])
def test_largest_forces_and_impact_speeds_are_those_of_the_program(name, tmp_path):
    """As pages look for them, against samples sixteen times as dense, which meet events by the way."""
    mechanism = PAPER(gear_ratio=14.0) if name == "slow" else SCENES[name]()
    script = solver(mechanism, rtol=live.RTOL)
    found = ran(script.text, script.data, LARGEST, tmp_path)
    record = ["normal_force", "tangential_force", "reaction", "normal_velocity"]
    motion = jp.simulate(mechanism, turns=3, rtol=RTOL, record=record, samples_per_turn=16384)
    size = np.hypot(motion.normal_force, motion.tangential_force).max("time")
    wanted = {str(joint): float(size.sel(joint=joint)) for joint in motion.joint.values}
    wanted |= {str(pin): float(motion.reaction.sel(pin=pin).max()) for pin in motion.pin.values}
    assert found["force"] == pytest.approx(wanted, rel=1e-2)
    times, kinds = events(motion)
    for joint, speed in found["speed"].items():
        begins = times[[each == (joint, "contact") for each in kinds]]
        series = np.abs(motion.normal_velocity.sel(joint=joint).values)
        fastest = np.interp(begins, motion.time.values, series).max(initial=0.0)
        assert speed == pytest.approx(fastest, rel=1e-2)
    assert max(found["speed"].values()) > 0 or name in ("sticking", "slow")


AFTER = """
const solver = makeSolver(data);
solver.run(60);
return solver.run(1, { closely: true, extremes: true }).largest.force;
"""


def stiff_rocker():
    """A crank-rocker of steel bars with a pin of steel in a bush of plastic, whose play is 14 µm."""
    shape = {"bar": {"width": "20 mm", "thickness": "6 mm"}, "material": "steel"}
    lengths = {"crank": "40 mm", "coupler": "160 mm", "rocker": "110 mm"}
    ends = {"O": ("crank", 0, [0, 0]), "A": ("crank", 0.04, "coupler"), "B": ("coupler", 0.16, "rocker")}
    joints = [_pinned(name, *end) for name, end in (ends | {"C": ("rocker", 0, [0.17, 0])}).items()]
    contact = {"pin": "steel", "bush": "POM", "length": "10 mm"}
    joints[2] |= {"fit": "F8/h6", "radius": "5 mm", "contact": contact}
    joints[2]["bearing"]["at"] = 0.11
    links = [{"name": name, "length": length, "shape": shape} for name, length in lengths.items()]
    drive = {"kind": "speed", "link": "crank", "speed": "300 rpm"}
    return jp.Mechanism(name="stiff rocker", drive=drive, links=links, joints=joints)


def _pinned(name, link, at, other):
    fixed = {"link": "ground", "point": other} if isinstance(other, list) else {"link": other}
    return {"name": name, "journal": {"link": link, "at": at}, "bearing": fixed}


def test_a_peak_of_a_vibration_that_is_faster_than_a_thousandth_of_a_turn_is_found(tmp_path):
    mechanism = stiff_rocker()
    script = solver(mechanism, rtol=live.RTOL, section=jp.CrankAngle())
    found = ran(script.text, script.data, AFTER, tmp_path)
    record = ["normal_force", "tangential_force"]
    motion = jp.simulate(mechanism, turns=1, transient=60, rtol=RTOL, record=record, samples_per_turn=65536)
    size = np.hypot(motion.normal_force, motion.tangential_force).sel(joint="B").values
    assert found["B"] == pytest.approx(size.max(), rel=1e-3)
    assert size[::64].max() < 0.98 * size.max()  # a thousandth of a turn apart


GROWTH = """
const solver = makeSolver(data);
solver.run(300);
const before = solver.run(40, { tangent: true }).exponent.sum;
return (solver.run(64, { tangent: true }).exponent.sum - before) / 64;
"""


@pytest.mark.nightly
@pytest.mark.parametrize(
    "mechanism",
    [
        pytest.param(PAPER(gear_ratio=20.0), id="gear ratio 20"),
        pytest.param(PAPER(gear_ratio=3.0), id="gear ratio 3"),
        pytest.param(PAPER(gear_ratio=3.0, clearance=6e-5), id="60 µm"),
    ],
)
def test_exponents_of_orbits_are_as_exact_as_pages_state(mechanism, tmp_path):
    """At a tolerance of 1e-6 the first is 1.3e-4 off."""
    made = [solver(mechanism, section=jp.CrankAngle(), rtol=rtol) for rtol in (live.RTOL, RTOL)]
    found, exact = (ran(each.text, each.data, GROWTH, tmp_path) for each in made)
    assert found == pytest.approx(exact, abs=1e-4)


CHANGED = {"clearance.B": 1e-4, "gear_ratio": 5.0, "friction.B": 0.02, "stiffness.B": 2e7, "damping.B": 100.0}
CHANGED |= {"length.crank": 0.028, "length.coupler": 0.19, "length.rocker": 0.13, "mass.coupler": 0.2}
CHANGED |= {"inertia.rocker": 0.0015, "rated_torque": 20.0, "efficiency": 0.7, "gravity": 9.0}
SET = """
const solver = makeSolver(data.solver);
solver.run(0.3);
const said = Object.entries(data.values).map(([key, value]) => solver.set(key, value));
solver.reset();
const found = solver.run(1, { samples: 4 });
return { ...found, state: solver.state(), said, period: solver.period() };
"""


SLID = {"clearance.B": 5e-5, "speed": 150.0, "length.crank": 0.04, "length.rod": 0.13, "mass.slider": 0.2}
SLOPED = {"clearance.G": 5e-5, "length.crank": 0.06, "length.rod": 0.14, "mass.rod": 0.2, "mass.slider": 0.2}
BENT = {"clearance.B": 1e-4, "length.crank": 0.028, "length.coupler": 0.19, "mass.coupler": 0.2}


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("C", CHANGED),
        ("slider-crank", SLID),
        ("guide", SLOPED),
        ("elastic", BENT),
    ],
)
def test_numbers_follow_the_sliders_as_they_follow_a_study(name, values, tmp_path):
    script = solver(SCENES[name](), rtol=RTOL, section=jp.CrankAngle())
    found = ran(script.text, {"solver": script.data, "values": values}, SET, tmp_path)
    paths = {each["key"]: each["paths"] for each in script.data["parameters"]}
    changed = SCENES[name]().replace(**{path: value for key, value in values.items() for path in paths[key]})
    motion = jp.simulate(changed, turns=1, rtol=RTOL, samples_per_turn=4, section=jp.CrankAngle())
    assert found["said"] == [""] * len(values)
    assert found["status"] == "ok"
    assert found["period"] == pytest.approx(float(motion.turn_period_nominal), rel=1e-14)
    times, kinds = events(motion)
    assert [(each["joint"], each["kind"]) for each in found["events"]] == kinds
    np.testing.assert_allclose([each["time"] for each in found["events"]], times, rtol=1e-9)
    for link, angles in found["angle"].items():
        np.testing.assert_allclose(angles, motion.angle.sel(link=link).values[1:], atol=1e-9)


REFUSED = """
const solver = makeSolver(data);
solver.run(0.3);
const refused = [solver.set("gear_ratio", 1e9), solver.set("clearance.B", NaN), solver.set("mass", 1)];
const together = [solver.set("length.coupler", 0.12), solver.set("length.rocker", 0.06)];
solver.set("length.coupler", 0.181);
const after = solver.set("length.rocker", 0.06);
return { refused, together, after, rocker: solver.along("rocker", 0.1175) };
"""


@pytest.mark.long
def test_what_is_refused_is_told_in_words(tmp_path):
    script = solver(SCENES["C"](), rtol=RTOL, section=jp.CrankAngle())
    found = ran(script.text, script.data, REFUSED, tmp_path)
    assert found["refused"] == [
        "gear ratio: from 0.6 to 21 is accepted",
        "radial clearance of joint B: from 29 to 2900 µm is accepted",
        "there is no slider mass",
    ]
    closes = "with the other lengths as they are, the links do not close over the whole turn"
    assert found["together"] == ["", f"length of the rocker: {closes}"]
    assert found["after"] == ""  # the same length, where the coupler is long enough
    assert found["rocker"] == 0.06


@pytest.mark.nightly
def test_sliders_of_a_drawing_move_one_number_each():
    """Stiffness follows the clearance by no form that a page could have: there it stays, as masses do."""
    base = jp.catalog.slider_crank()
    parts = {"pin": "steel", "bush": "bronze", "length": 0.012}
    bar = {"bar": {"width": 0.03, "thickness": 0.004}, "material": "steel"}
    drawn = base.replace(**{"joints.B.contact": parts})
    rod = jp.Link(name="rod", length=0.12, shape=bar)
    data = solver(jp.Mechanism(**dict(drawn) | {"links": (drawn.links[0], rod, drawn.links[2])})).data
    assert {"clearance.B", "mass.rod", "inertia.rod"} <= {each["key"] for each in data["parameters"]}


@pytest.mark.nightly
def test_a_stiffness_by_a_power_of_the_depth_has_its_unit():
    data = solver(jp.catalog.slider_crank(clearance={"B": 1e-4})).data
    units = {each["key"]: each["unit"] for each in data["parameters"] + data["fixed"]}
    assert units["stiffness.B"] == "N m⁻¹"
    data = solver(grid("four_bar", "flores", "none", False)).data
    units = {each["key"]: each["unit"] for each in data["parameters"] + data["fixed"]}
    assert units["stiffness.B"] == "N/m^1.5"


def test_a_number_is_shown_as_its_field_has_room(tmp_path):
    wide = [8.6727600e10, 259311000.0, -1234567.0, 123.456, 0.123456789, 0.00123456, 1.234567e-5, 0.0, 290.0]
    found = ran(live.own("sliders.js"), wide, "return data.map(sliders.typed);", tmp_path)
    assert found == [
        "8.673e10",
        "2.593e8",
        "-1.235e6",
        "123.456",
        "0.123457",
        "0.001235",
        "1.235e-5",
        "0",
        "290",
    ]


@pytest.mark.nightly
def test_lengths_end_where_the_crank_can_no_longer_turn():
    """Grashof: the crank is the shortest, and with the longest no longer than the other two together."""
    given = {each["key"]: each for each in solver(SCENES["C"]()).data["parameters"]}
    joints = {joint.name: joint for joint in SCENES["C"]().joints}
    ground = float(np.hypot(*np.subtract(joints["O"].bearing.point, joints["C"].bearing.point)))
    lengths = {name: given[f"length.{name}"]["value"] for name in ("crank", "coupler", "rocker")}

    def beyond(name, length):
        crank, *others = (lengths | {name: length}).values()
        sides = sorted([*others, ground])
        return (crank + sides[2]) / (sides[0] + sides[1])

    for name, end in product(lengths, ("min", "max")):
        last = given[f"length.{name}"][end]
        assert beyond(name, last) < 1
        if last / lengths[name] not in (pytest.approx(0.3), pytest.approx(3.0)):  # what a slider is made for
            first = lengths[name] + (last - lengths[name]) / WITHIN
            assert beyond(name, first) == pytest.approx(1, rel=2e-3)


def test_a_text_is_translated_once_for_a_structure(monkeypatch):
    structure = assemble(SCENES["C"]()).structure
    first = solver_text(structure, ("angle:crank",))
    monkeypatch.setattr(solver_module, "_translated", lambda *_: pytest.fail("it is translated"))
    assert solver_text(structure, ("angle:crank",)) == first
    with pytest.raises(pytest.fail.Exception):
        solver_text(structure, ("angle:rocker",))


@pytest.mark.nightly
@pytest.mark.parametrize("name", ["C", "slider-crank"])
def test_places_of_links_are_those_of_the_package(name, tmp_path):
    mechanism = SCENES[name]()
    script = solver(mechanism, section=jp.CrankAngle())
    program = """
    const solver = makeSolver(data);
    const found = solver.run(0.7, { samples: 3 });
    return { ...found, places: [0, 1, 2].map(solver.places) };
    """
    found = ran(script.text, script.data, program, tmp_path)
    angles = {link: np.array(series) for link, series in found["angle"].items()}
    loose = [joint.name for joint in mechanism.clearance_joints]
    apart = {each: np.stack([found["journal_x"][each], found["journal_y"][each]], -1) for each in loose}
    slides = {each: np.array(series) for each, series in found.get("slide_position", {}).items()}
    expected = origins(mechanism, angles, apart, slides)
    for link, places in expected.items():
        rows = [each[link] for each in found["places"]]
        np.testing.assert_allclose(rows, np.column_stack([places, angles[link]]), atol=1e-12)


TANGENT = """
const solver = makeSolver(data);
solver.run(20, { tangent: true });
const blocks = [];
for (let i = 0; i < 20; i += 1) {
  const before = solver.run(0, { tangent: true }).exponent;
  const after = solver.run(15, { tangent: true }).exponent;
  blocks.push((after.sum - before.sum) / (after.turns - before.turns));
}
return blocks;
"""


@pytest.mark.nightly
def test_the_exponent_is_the_compiled_one_within_errors(tmp_path):
    script = solver(SCENES["C"]())
    blocks = np.array(ran(script.text, script.data, TANGENT, tmp_path))
    native = jp.lyapunov(SCENES["C"](), transient=20, turns=300)
    found, error = blocks.mean(), blocks.std(ddof=1) / len(blocks) ** 0.5
    expected = float(native.section_exponent_per_turn[0])
    both = np.hypot(error, float(native.section_standard_error_per_turn[0]))
    assert 0 < both < 0.2
    assert abs(found - expected) < 3 * both


STAYS = """
const solver = makeSolver(data);
solver.run(2.6);
const state = solver.state(), later = solver.run(0.25).turns_done;
solver.reset();
let done = 0, calls = 0;
while (done < 2.6 - 1e-12) {
  done += solver.run(2.6 - done, { budget_ms: 0.05 }).turns_done;
  calls += 1;
}
const pieces = solver.state();
solver.reset();
solver.setState(state);
const begun = solver.time();
const on = solver.run(1, { samples: 1 });
const section = on.section.map((row) => row[0] - begun);
return { state, pieces, later, calls, done, events: on.events.length, section };
"""


@pytest.mark.nightly
def test_a_run_goes_on_after_its_budget_and_from_a_given_state(tmp_path):
    script = solver(SCENES["C"](), section=jp.CrankAngle())
    found = ran(script.text, script.data, STAYS, tmp_path)
    assert found["calls"] > 3
    np.testing.assert_allclose(found["pieces"], found["state"], rtol=1e-9, atol=1e-9)
    assert found["later"] == pytest.approx(0.25, rel=1e-12)
    assert found["events"] > 0
    assert len(found["section"]) == 1  # the crank passes its angle once in a turn, from wherever it begins


@pytest.mark.long
def test_equations_without_a_translation_are_refused_as_input(monkeypatch):
    def none(*_):
        raise RefusedError("structure.py:7 in rate: the function gamma is not in the subset")

    monkeypatch.setattr(solver_module, "solver_text", none)
    with pytest.raises(
        jp.InputError, match=r"mechanism: .*JavaScript.* structure.py:7 in rate: the function gamma"
    ):
        solver(SCENES["A"]())


def test_a_number_that_follows_in_no_simple_form_is_fixed_and_says_why():
    pair = jp.catalog.impact_pair(gap=0.4, restitution=0.8)

    def numbers(mechanism):
        gap, r = mechanism.parameters["gap"], mechanism.parameters["restitution"]
        return {("p", 0): abs(gap - 0.47), ("p", 1): r} if r < 0.95 else None

    found = followed(pair, numbers)
    fixed = {each["key"]: each["why"] for each in found["fixed"]}
    assert fixed["gap"] == "a number of the equations follows it in no simple form"
    (given,) = found["parameters"]
    assert (given["key"], given["refused"]) == ("restitution", (False, True))
    assert given["min"] == 0.08
    assert 0.94 < given["max"] < 0.95
    assert given["max"] == float(f"{given['max']:.4g}")  # what is shown is accepted


def test_ends_of_a_negative_number_are_in_order():
    gears = jp.catalog.gear_backlash(mean_load=-0.1, amplitude=0.2, frequency=0.5, damping=0.05)

    def numbers(mechanism):
        load = mechanism.parameters["mean_load"]
        return {("p", 0): load} if load > -0.2 else None

    (given,) = followed(gears, numbers)["parameters"]
    assert -0.2 < given["min"] < -0.19
    assert (given["max"], given["refused"]) == (-0.02, (True, False))
