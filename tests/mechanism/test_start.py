"""Starts of a linkage: what is taken, and what a closed loop refuses because it would contradict it."""

import math

import numpy as np
import pytest

from jointplay.analysis.starts import placed
from jointplay.analysis.sweeps.bifurcation import bifurcation
from jointplay.display.errors import InputError
from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.loops.ideal import ideal_state
from jointplay.solver.mechanism.start import start
from tests.support.wrong import problems_of, refused

LOOSE = catalog.chunmei2002()
CLOSED = catalog.chunmei2002(clearance=0)
STEADY = catalog.chunmei2002(clearance=0, speed=40.0)
ANGLES = {"crank": 0.1, "coupler": 0.7, "rocker": 1.9}
SPEEDS = dict.fromkeys(ANGLES, 2.0)


@pytest.mark.parametrize("mechanism", [LOOSE, CLOSED, STEADY], ids=["play", "closed", "steady"])
@pytest.mark.parametrize(
    "initial", [None, {}, {"crank_angle": 1.2}, {"crank_angle": np.float64(1.2)}], ids=str
)
def test_the_ideal_mechanism_is_the_default_start(mechanism, initial):
    angle = (initial or {}).get("crank_angle", 0.0)
    assert start(mechanism, initial)[:2] == ideal_state(mechanism, crank_angle=angle)[:2]


def test_play_takes_any_start():
    assert (
        start(LOOSE, {"crank_speed": -3.0, "branch": "lower"})[:2]
        == ideal_state(LOOSE, 0.0, -3.0, "lower")[:2]
    )
    assert start(LOOSE, {"angle": ANGLES, "angular_velocity": SPEEDS})[:2] == (ANGLES, SPEEDS)


@pytest.mark.parametrize(("clearances", "taken"), [(9.9, True), (10.1, False)])
def test_a_journal_starts_at_most_ten_clearances_off(clearances, taken):
    """As docs/study-files.md says. The rocker is turned by as much as puts its pin off by such a chord."""
    angles, speeds, _ = ideal_state(LOOSE)
    joint, rocker = LOOSE.clearance_joints[0], LOOSE.joint("B").bearing
    turn = 2 * math.asin(clearances * joint.clearance / (2 * rocker.at))
    given = {"angle": angles | {rocker.link: angles[rocker.link] + turn}, "angular_velocity": speeds}
    if taken:
        assert assemble(LOOSE, given).links
    else:
        assert set(problems_of(assemble, LOOSE, given)) == {"initial.angle"}


@pytest.mark.parametrize("mechanism", [CLOSED, STEADY], ids=["motor", "steady"])
@pytest.mark.parametrize("key", ["angle", "angular_velocity"])
def test_a_closed_loop_takes_no_angles_of_its_links(mechanism, key):
    found = refused(start, mechanism, {key: ANGLES})
    assert set(found) == {f"initial.{key}"}
    assert "crank_angle, crank_speed, branch" in found[f"initial.{key}"]
    assert "links determine each other" in found[f"initial.{key}"]


def test_a_closed_loop_keeps_its_branch():
    assert start(CLOSED, {"branch": "upper"})[:2] == ideal_state(CLOSED)[:2]
    found = refused(start, CLOSED, {"branch": "lower"})
    assert set(found) == {"initial.branch"}
    assert "'upper', the mechanism's own, is accepted here" in found["initial.branch"]
    lower = CLOSED.replace(branch="lower")
    assert start(lower, None)[:2] == ideal_state(lower, branch="lower")[:2]


def test_a_closed_loop_at_constant_speed_starts_with_it():
    assert start(STEADY, {"crank_speed": 40.0, "crank_angle": 1.0})[:2] == ideal_state(STEADY, 1.0)[:2]
    assert set(refused(start, STEADY, {"crank_speed": 41.0})) == {"initial.crank_speed"}
    assert start(CLOSED, {"crank_speed": 41.0})[1]["crank"] == 41.0


@pytest.mark.parametrize("clearance", [0, 2.9e-5], ids=["closed", "play"])
def test_an_imposed_speed_is_that_of_the_start(clearance):
    """Of the crank in particular: else all other links would start as for another one."""
    steady = catalog.chunmei2002(clearance=clearance, speed=40.0)
    assert set(refused(start, steady, {"crank_speed": 10.0})) == {"initial.crank_speed"}
    assert start(steady, {"crank_speed": 40.0})[:2] == ideal_state(steady, 0.0)[:2]
    if clearance:
        found = refused(start, steady, {"angle": ANGLES, "angular_velocity": SPEEDS})
        assert set(found) == {"initial.angular_velocity.crank"}
        assert "40" in found["initial.angular_velocity.crank"]
        given = {"angle": ANGLES, "angular_velocity": SPEEDS | {"crank": 40.0}}
        assert start(steady, given)[1] == given["angular_velocity"]
        with pytest.raises(InputError, match=r"starts\[1\]\.crank_speed: got 10"):
            bifurcation(
                steady, over={"drive.speed": [40.0]}, starts=[{"crank_angle": 1.0}, {"crank_speed": 10.0}]
            )


def test_a_state_vector_has_the_speed_that_a_drive_imposes():
    """Where the driven link's speed is one of the states."""
    profile = LOOSE.replace(
        drive={"kind": "profile", "link": "crank", "start": 30.0, "end": 40.0, "time": 1.0}
    )
    state = assemble(profile).state
    assert placed(profile, state).state == pytest.approx(state, abs=0)
    with pytest.raises(InputError, match=r"w_crank = 30.0, at which the drive starts"):
        placed(profile, np.where(state == 30.0, 31.0, state))


def test_a_speed_is_the_imposed_one_but_for_rounding():
    """As a start in other units comes. What is accepted is the drive's own; a message shows all digits."""
    driven = LOOSE.replace(drive={"kind": "speed", "link": "crank", "speed": 10 / 3})
    nearly, rounded = (SPEEDS | {"crank": speed} for speed in (10 / 3 * (1 + 4e-16), 3.33333))
    assert start(driven, {"angle": ANGLES, "angular_velocity": nearly}).speeds["crank"] == 10 / 3
    assert start(driven, {"crank_speed": nearly["crank"]}).speeds["crank"] == 10 / 3
    accepted = refused(start, driven, {"angle": ANGLES, "angular_velocity": rounded})
    assert str(10 / 3) in accepted["initial.angular_velocity.crank"]


def test_a_branch_of_none_is_none_also_where_loops_have_no_branch():
    mechanism = catalog.watt(clearance=0)
    assert start(mechanism, {"branch": None, "crank_speed": None})[:2] == start(mechanism, None)[:2]


def test_every_contradiction_is_named_at_once():
    given = {"crank_speed": 1.0, "branch": "lower", "crank_angel": 0.0}
    assert set(refused(start, STEADY, {k: given[k] for k in ("crank_speed", "branch")})) == {
        "initial.crank_speed",
        "initial.branch",
    }
    assert set(refused(start, STEADY, given)) >= {"initial.crank_angel"}


@pytest.mark.parametrize("initial", [3.0, "upper", [0.0, 1.0]], ids=str)
def test_something_else_than_a_table(initial):
    assert set(refused(start, CLOSED, initial)) == {"initial"}


@pytest.mark.parametrize(
    "change",
    [
        {"angle": {}},
        {"angle": ANGLES | {"rod": 1.0}},
        {"angular_velocity": SPEEDS | {"crank": math.nan}},
    ],
    ids=str,
)
def test_angles_and_speeds_of_every_link_are_needed(change):
    with pytest.raises(InputError):
        start(LOOSE, {"angle": ANGLES, "angular_velocity": SPEEDS} | change)


@pytest.mark.parametrize("key", ["angle", "angular_velocity"])
def test_neither_angles_nor_speeds_do_alone(key):
    (other,) = {"angle", "angular_velocity"} - {key}
    assert set(refused(start, LOOSE, {key: ANGLES})) == {f"initial.{other}"}


@pytest.mark.parametrize("mechanism", [CLOSED, STEADY], ids=["motor", "steady"])
@pytest.mark.parametrize("elastic", [(), ("coupler", "rocker")], ids=str)
def test_a_closed_loop_has_one_freedom_and_straight_beams(mechanism, elastic):
    model = assemble(mechanism.replace(elastic=elastic), {"crank_angle": 0.5})
    modes, half = 4 * len(elastic), len(model.state) // 2
    assert half == modes + 1
    assert model.state[modes] == 0.5
    assert model.state[half + modes] == mechanism.drive.nominal_speed
    assert not np.delete(model.state, [modes, half + modes]).any()
    assert list(model.turning) == [0.0] * modes + [1.0]


def test_a_dead_centre_has_no_start():
    """Coupler and rocker in one line: where the crank can turn that far."""
    links = [
        link.model_copy(update={"length": 0.25, "centre": 0.125, "inertia": 0.1})
        if link.name == "crank"
        else link
        for link in CLOSED.links
    ]
    joints = [
        joint.model_copy(update={"journal": joint.journal.model_copy(update={"at": 0.25})})
        if joint.name == "A"
        else joint
        for joint in CLOSED.joints
    ]
    long = type(CLOSED)(**dict(CLOSED) | {"links": links, "joints": joints})
    reach = 0.181 + 0.1175
    dead = math.acos((0.25**2 + 0.2**2 - reach**2) / (2 * 0.25 * 0.2))
    with pytest.raises(InputError, match="dead centre"):
        start(long, {"crank_angle": dead})
    with pytest.raises(InputError, match="crank_angle"):
        start(long, {"crank_angle": dead + 0.1})
    assert start(long, {"crank_angle": dead - 0.1})
