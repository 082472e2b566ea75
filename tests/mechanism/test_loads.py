"""Records of loads and drives: what is accepted, what they tell of themselves, what analyses refuse."""

import math

import numpy as np
import pytest

import jointplay as jp
from jointplay.analysis.rules import unlike_turns
from jointplay.analysis.vary import axes
from jointplay.display.errors import InputError
from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.assemble import assemble, linkage
from jointplay.solver.mechanism.parts.drive import PrescribedTorque, SpeedProfile
from jointplay.solver.mechanism.records import Mechanism
from jointplay.solver.motion.eligibility import structure_exclusion
from tests.support.wrong import listed, only, problems_of

FORCE = {"name": "press", "kind": "force", "on": {"link": "rocker", "at": 0.1}, "direction": 0.3}
FORCE |= {"constant": 5.0, "harmonics": [{"order": 2, "cosine": 3.0}], "angle": "crank"}
TORQUE = {"name": "shake", "kind": "torque", "link": "coupler", "frequency": 50.0}
TORQUE |= {"harmonics": [{"order": 1, "sine": 0.2}, {"order": 3, "cosine": 0.1}]}
SPRING = {"name": "hinge", "kind": "torsion", "from": "coupler", "to": "rocker", "stiffness": 0.4}
PROFILE = {"kind": "profile", "link": "crank", "start": 0.0, "end": -60.0, "time": 0.2}


def test_what_a_mechanism_tells_of_its_loads():
    given = catalog.chunmei2002(loads=[FORCE, TORQUE])
    assert Mechanism(**listed(given.model_dump())) == given
    text = given.summary()
    assert "press: force on rocker, 100 mm from its origin, towards 17.19 deg from +x, 5 N with harm" in text
    bent = catalog.chunmei2002(loads=[FORCE | {"on": {"link": "rocker"}, "fixed": "link"}]).summary()
    assert "press: force on rocker, at its origin, towards 17.19 deg from its line, 5 N" in bent
    assert "shake: torque on coupler, 0 N·m with harmonics 1, 3 over time at 50 rad/s" in text


def test_numbers_are_found_by_their_paths():
    given = catalog.chunmei2002(loads=[FORCE, TORQUE])
    assert given.varied({"loads.press.constant": 7.0}).loads[0].constant == 7.0
    assert given.varied({"loads.shake.harmonics.3.cosine": 7.0}).loads[1].harmonics[1].cosine == 7.0
    assert given.varied({"loads.shake.factor": 2.0}).loads[1].course_numbers("x")["b_x_1"] == 0.4


def test_units_of_what_varies():
    given = catalog.chunmei2002(loads=[FORCE, TORQUE], springs=[SPRING])
    keys = {
        "loads.press.constant": "N",
        "loads.press.harmonics.2.sine": "N",
        "loads.shake.harmonics.3.cosine": "N m",
        "loads.shake.frequency": "rad s-1",
        "springs.hinge.stiffness": "N m rad-1",
    }
    found = axes(given, {key: [1.0, 2.0] for key in keys})
    assert {axis.key: axis.units for axis in found} == keys
    assert found[0].long_name == "constant part of load press"


JUMP = [0.0] * 20 + [1.0] * 20
WRONG = [
    (FORCE | {"on": {"link": "ground", "point": [0.0, 0.0]}}, "loads[0].on.link", "a moving link"),
    (FORCE | {"on": {"link": "rocker", "at": 1.0}}, "loads[0].on.at", "rocker's length"),
    (FORCE | {"angle": "crank", "frequency": 3.0}, "loads[0].angle", "not both"),
    (FORCE | {"angle": "crank", "frequency": "2 Hz"}, "loads[0].angle", "not both"),
    (FORCE | {"angle": "cranck"}, "loads[0].angle", "did you mean 'crank'"),
    (
        FORCE | {"harmonics": 3},
        "loads[0].harmonics",
        "a list [a table of order, cosine, sine; …] is accepted",
    ),
    (FORCE | {"harmonics": []}, "loads[0].angle", "accepted beside harmonics or a table only"),
    (FORCE | {"table": [0.0, 1.0, 0.0]}, "loads[0].table", "either harmonics or a table"),
    (FORCE | {"harmonics": [], "table": [0.0, 1.0]}, "loads[0].table", "a list of 3 to 1000 finite numbers"),
    (FORCE | {"harmonics": [], "table": [2.0, 2.0, 2.0]}, "loads[0].table", "not all alike"),
    (FORCE | {"harmonics": [], "table": JUMP}, "loads[0].table", "differ by 0.0"),
    (TORQUE | {"frequency": None}, "loads[0].frequency", "what it varies with"),
    (TORQUE | {"frequency": 0.0}, "loads[0].frequency", "greater than 0 rad/s"),
    (TORQUE | {"link": "rod"}, "loads[0].link", "no such link"),
    (TORQUE | {"link": "ground"}, "loads[0].link", "accepted: crank, coupler, rocker"),
    (TORQUE | {"harmonics": [{"order": 1}] * 2}, "loads[0].harmonics[1].order", "no other of the harmonics"),
    (TORQUE | {"harmonics": [{"order": 25}]}, "loads[0].harmonics[0].order", "at most 24"),
    (TORQUE | {"harmonics": [], "frequency": None}, "loads[0].constant", "is needed"),
    (TORQUE | {"kind": "moment"}, "loads[0].kind", "force, torque"),
]


@pytest.mark.parametrize(("load", "key", "expected"), WRONG)
def test_wrong_loads(load, key, expected):
    load = {name: value for name, value in load.items() if value is not None}
    given = listed(catalog.chunmei2002().model_dump()) | {"loads": [load]}
    assert expected in str(only(problems_of(Mechanism, **given), f"mechanism.{key}").expected)


def test_a_torque_on_an_elastic_link_is_refused():
    found = problems_of(catalog.chunmei2002, elastic=["coupler"], loads=[TORQUE])
    assert "would bend it" in only(found, "mechanism.loads[0].link").expected


DRIVES = [
    (PrescribedTorque, {"nominal_speed": 0.0, "constant": 1.0}, "drive.nominal_speed"),
    (PrescribedTorque, {"nominal_speed": 9.0}, "drive.constant"),
    (SpeedProfile, {"start": 0.0, "end": 0.0, "time": 1.0}, "drive.end"),
    (SpeedProfile, {"start": 0.0, "end": 1.0, "time": 0.0}, "drive.time"),
]


@pytest.mark.parametrize(("kind", "given", "key"), DRIVES)
def test_wrong_drives(kind, given, key):
    only(problems_of(kind, link="crank", **given), key)


def test_a_start_is_the_profile_s_own():
    turned = catalog.chunmei2002(drive=PROFILE)
    model = assemble(turned)
    assert (model.crank_speed, model.forward) == (0.0, -1)
    assert model.period == pytest.approx(math.tau / 60.0)
    only(problems_of(jp.simulate, turned, turns=1, initial={"crank_speed": 5.0}), "initial.crank_speed")
    links = ("crank", "coupler", "rocker")
    start = {"angle": dict.fromkeys(links, 0.0), "angular_velocity": dict.fromkeys(links, 1.0)}
    only(problems_of(jp.simulate, turned, turns=1, initial=start), "initial.angular_velocity.crank")


def test_steps_do_not_pass_over_a_load():
    fast = TORQUE | {"harmonics": [{"order": 20, "sine": 1.0}]}
    assert assemble(catalog.chunmei2002(loads=[TORQUE])).h_max == pytest.approx(0.7 / 50.0)
    assert assemble(catalog.chunmei2002(loads=[fast])).h_max == pytest.approx(math.tau / 20 / 50.0)
    assert np.isinf(assemble(catalog.chunmei2002()).h_max)


def test_turns_alike():
    """A load over time is the same in every turn where its frequency is a multiple of a constant speed."""
    assert not list(unlike_turns(catalog.chunmei2002(loads=[TORQUE, FORCE], speed=25.0)))
    assert not list(unlike_turns(catalog.chunmei2002(loads=[FORCE])))
    closed = {"speed": 25.0, "clearance": {}}
    for changes in ({"speed": 30.0}, {"speed": 100.0}, {}, {"drive": None}, closed):
        (problem,) = unlike_turns(catalog.chunmei2002(loads=[FORCE, TORQUE], **changes))
        assert problem.key == "mechanism.loads[1].frequency"
    (problem,) = unlike_turns(catalog.chunmei2002(drive=PROFILE))
    assert problem.key == "mechanism.drive.kind"


def test_sweeps_look_at_every_value():
    """At 25 rad/s the load repeats with each turn, at 30 rad/s not."""
    given = catalog.chunmei2002(loads=[TORQUE], speed=25.0)
    found = problems_of(jp.bifurcation, given, over={"speed": [25.0, 30.0]})
    only(found, "mechanism.loads[0].frequency")


@pytest.mark.parametrize("key", ["speed", "loads[0].frequency"])
def test_what_is_built_on_orbits_refuses_what_would_part_turns_from_each_other(key):
    """At 25 rad/s the load repeats with each turn, beside that it does not."""
    given = catalog.chunmei2002(loads=[TORQUE], speed=25.0)
    value = 25.0 if key == "speed" else TORQUE["frequency"]
    only(problems_of(jp.assess, given, along=[key]), "along")
    only(problems_of(jp.gradient, given, orbit=True, by=[key]), "by")
    most = {"most": "largest:normal_force:B", "turns": 2}
    only(problems_of(jp.optimise, given, by={key: (0.9 * value, 1.1 * value)}, **most), "by")
    only(problems_of(jp.tolerances, given, spreads={key: {"normal": (value, 0.01)}}), f"spreads.{key}")


def test_samples_at_which_turns_stay_alike_are_accepted():
    given = catalog.chunmei2002(loads=[TORQUE], speed=25.0)
    spread = {"speed": {"values": [25.0, 12.5]}}
    how = {"samples": 2, "transient": 0, "turns": 2, "events": [], "of": ["turn_period"], "n_jobs": 1}
    assert jp.tolerances(given, spreads=spread, **how).sizes["sample"] == 2


def test_usual_parameters_of_an_orbit_leave_out_what_would_part_turns_and_say_so():
    given = catalog.chunmei2002(loads=[TORQUE], speed=25.0)
    with pytest.warns(jp.ModelWarning, match="speed is left out"):
        found = jp.gradient(given, orbit=True, transient=2, max_steps=100, of=["time"])
    assert "links.rocker.mass" in found.parameter
    assert "speed" not in found.parameter
    assert "speed is left out" in found.attrs["warning"]


def test_exponents_are_not_of_a_passing_motion():
    turned = catalog.chunmei2002(drive=PROFILE)
    only(problems_of(jp.lyapunov, turned, turns=3), "mechanism.drive.kind")


def test_loads_go_in_lanes_but_no_speed_that_varies():
    plain = catalog.chunmei2002()
    assert not structure_exclusion(linkage(plain))
    torque = {"kind": "torque", "link": "crank", "constant": 1.0, "nominal_speed": 9.0}
    steady = {"name": "pull", "kind": "force", "on": FORCE["on"], "constant": 5.0, "direction": 0.3}
    assert structure_exclusion(linkage(plain.replace(drive=PROFILE))) == "imposed_motion"
    for changes in (
        {"loads": [steady, FORCE, TORQUE]},
        {"springs": [SPRING]},
        {"gravity_direction": 0.0},
        {"drive": torque},
    ):
        assert not structure_exclusion(linkage(plain.replace(**changes)))


def test_a_load_without_a_kind_names_the_kinds():
    with pytest.raises(InputError, match=r"loads\[0\].kind: got nothing; .*one of 'force', 'torque'"):
        catalog.chunmei2002(loads=[{"name": "P", "link": "crank", "constant": 3.0}])


def test_a_table_that_harmonics_miss_names_the_tolerance():
    table = {"kind": "torque", "name": "P", "link": "crank", "angle": "crank", "table": JUMP}
    with pytest.raises(InputError, match=r"more than the key tolerance allows \(0.01"):
        catalog.chunmei2002(loads=[table])
    assert catalog.chunmei2002(loads=[table | {"tolerance": 0.9}])
