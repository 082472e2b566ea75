"""Motions in lanes against motions one by one: laws at bearings with play, ideal loops, own equations."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from functools import partial
from itertools import takewhile
from pathlib import Path

import numpy as np
import pytest

import jointplay as jp
from jointplay import catalog
from jointplay.solver.codegen.lanes import EXCLUSIONS
from jointplay.solver.mechanism.assemble import assemble, linkage
from jointplay.solver.method.codes import Event
from jointplay.solver.motion.eligibility import IN_LANES, ROUTES, exclusion, structure_exclusion
from jointplay.solver.motion.ensemble_runs import follow_ensemble
from jointplay.solver.motion.trajectory import Request, _excites, follow
from tests.support.laws_grid import PAIRS, mechanism

TORQUE = {"kind": "torque", "link": "crank", "constant": 0.5, "nominal_speed": 100.0}
HINGE = {"name": "h", "kind": "torsion", "from": "coupler", "to": "rocker", "stiffness": 0.4}
PULL = {"name": "p", "kind": "force", "on": {"link": "rocker", "at": 0.1}, "constant": 5.0, "direction": 0.3}
paper = partial(catalog.chunmei2002, gear_ratio=3.0)
SCENES = {
    "B, C": lambda: paper(clearance={"B": 4e-5, "C": 3e-5}, friction=0.3),
    "A, B, smooth": lambda: paper(clearance={"A": 4e-5, "B": 3e-5}, friction=0.0),
    "A, B, C": lambda: paper(clearance={"A": 4e-5, "B": 3e-5, "C": 4e-5}, friction=0.1),
    "tilted": lambda: paper(clearance=4e-5, gravity_direction=0.3),
    "sprung": lambda: paper(clearance=4e-5, springs=[HINGE], loads=[PULL]),
    "slider": lambda: catalog.slider_crank(clearance=1e-4, gravity=9.81).replace(drive=TORQUE),
    "given speed": lambda: catalog.slider_crank(clearance=1e-4, gravity=9.81),
    "loops": lambda: catalog.watt(clearance={"F": 1e-4}),
    "guide": lambda: catalog.slider_crank(clearance={"G": 1e-4}, gravity=9.81),
    "shaken": lambda: paper(clearance=4e-5, loads=[SHAKE | {"constant": 0.1}]),
    "elastic": lambda: mechanism("four_bar", "kelvin_voigt", "coulomb", True),
}
STARTS, TURNS = 12, 2.0
SLACK = 5  # times the error of one by one: another method at the same tolerance
FALLING = ("stribeck", "andersson", "brown_mcphee")
LANES = [
    (law, "tanh" if friction in FALLING else friction)
    for law, friction in PAIRS
    if (law, friction) not in (("restitution", "none"), ("liu", "lugre"))
]


def starts(model):
    """Scenes with the journals about their bearings' centres, at speeds of their own."""
    random, n = np.random.default_rng(3), len(model.turning)
    unit = np.concatenate(
        [np.zeros(n), 0.02 * model.absolute[n : 2 * n] * model.turning, np.zeros(model.memories)]
    )
    for _ in range(STARTS):
        yield replace(model, state=model.state + unit * random.uniform(-1, 1, len(unit)))


def shared(records, truth):
    """How many events a run has in common with a sharp one, before the first that differs."""
    pairs = zip(records.events[:, :2].tolist(), truth.events[:, :2].tolist(), strict=False)
    return sum(takewhile(bool, (one == other for one, other in pairs)))


def as_one_by_one(model):
    """Over two turns lanes go along with a sharp run for as long as motions one by one do at their tolerance.

    These motions lose it themselves, some after a turn: with much sticking a small difference grows fast. Up
    to half of what they meet, no event may be another nor much farther off in time; all in all lanes may meet
    a twentieth fewer.
    """
    scenes = list(starts(model))
    cut = {"level": model.crank_angle + 1.0, "period": math.tau, "direction": 1}
    request = Request(TURNS * model.period, 1e-7, events=True, misses=True, log_from=-1.0, **cut)
    assert not any(exclusion(each, request) for each in scenes)
    found, counts, late = follow_ensemble(scenes, [request] * STARTS), [], []
    for each, records in zip(scenes, found, strict=True):
        truth, alone = (follow(each, replace(request, rtol=rtol)) for rtol in (1e-11, 1e-7))
        assert (records.status, truth.status, records.route) == (0, 0, IN_LANES)
        counts.append([shared(run, truth) for run in (records, alone)])
        half = counts[-1][1] // 2
        assert counts[-1][0] >= half
        off = [
            np.abs(run.events[:half, 2] - truth.events[:half, 2]).max(initial=0.0) for run in (records, alone)
        ]
        late.append(np.array(off) / model.period)
        if counts[-1][0] == len(truth.events) == len(records.events):
            assert records.sections.shape == truth.sections.shape
    assert min(len(each.events) for each in found) > 1
    lanes, one_by_one = np.sum(counts, axis=0)
    assert lanes >= 0.95 * one_by_one
    ours, theirs = np.median(late, axis=0)
    assert ours < min(1e-5, SLACK * theirs + request.rtol)


def met_by(contacts):
    """Events in order of contacts, and of times: corners of a slider may meet their face together."""
    return contacts[np.lexsort((contacts[:, 2], contacts[:, 0]))]


def compared(model):
    """Share of motions in lanes that have a sharp run's events, and how far these are off, in turns."""
    scenes = list(starts(model))
    cut = {"level": model.crank_angle + 1.0, "period": math.tau, "direction": 1}
    request = Request(TURNS * model.period, 1e-8, events=True, misses=True, log_from=-1.0, **cut)
    assert not any(exclusion(each, request) for each in scenes)
    found, met, late = follow_ensemble(scenes, [request] * STARTS), 0, []
    for each, records in zip(scenes, found, strict=True):
        truth = follow(each, replace(request, rtol=1e-11))
        assert (records.status, truth.status, records.route) == (0, 0, IN_LANES)
        ours, own = met_by(records.events), met_by(truth.events)
        same = ours[:, :2].tolist() == own[:, :2].tolist()
        met += same
        if same:
            late.append(np.abs(ours[:, 2] - own[:, 2]).max() / model.period)
            assert records.sections.shape == truth.sections.shape
    assert min(len(each.events) for each in found) > 1
    back = follow_ensemble(scenes[::-1], [request] * STARTS)[::-1]
    alone = follow_ensemble(scenes[:1], [request])
    for one, other in [*zip(found, back, strict=True), *zip(found[:1], alone, strict=True)]:
        assert one.events.tobytes() == other.events.tobytes()
        assert one.sections.tobytes() == other.sections.tobytes()
    return met / STARTS, late


@pytest.mark.nightly
@pytest.mark.parametrize(("normal", "friction"), LANES)
def test_each_law_is_as_one_by_one(normal, friction):
    as_one_by_one(assemble(mechanism("four_bar", normal, friction, False), section="angle:crank"))


@pytest.mark.nightly
@pytest.mark.parametrize("name", SCENES)
def test_several_joints_springs_and_loads_are_as_one_by_one(name):
    share, late = compared(assemble(SCENES[name](), section="angle:crank"))
    assert share == 1.0
    assert np.median(late) < 1e-5


SHAKE = {"name": "s", "kind": "torque", "link": "coupler", "frequency": 50.0}
SHAKE |= {"harmonics": [{"order": 1, "sine": 0.2}]}


@pytest.mark.long
@pytest.mark.parametrize(
    "changes", [{"speed": 60.0}, {"loads": [SHAKE | {"constant": 0.1}]}], ids=["speed", "loads"]
)
def test_a_law_remembers_beside_a_phase(changes):
    """A crank at a given speed, and a load over time: phases, which a trajectory's own state has not."""
    made = mechanism("four_bar", "flores", "none", False).replace(**changes)
    how = {"turns": 1, "rtol": 1e-8, "record": ["angular_velocity"]}
    lanes, alone = (jp.poincare(made, jp.CrankAngle(angle=0.6), **how, ensemble=way) for way in (True, False))
    assert int(lanes.followed) == IN_LANES
    assert lanes.angular_velocity.values == pytest.approx(alone.angular_velocity.values, rel=1e-5, abs=1e-5)


PROFILE = {"kind": "profile", "link": "crank", "start": 0.0, "end": -60.0, "time": 0.2}
SLIDING = {"states": {"x": 0.3}, "rates": {"x": "1 - 2*up"}, "parameters": {}}
SLIDING |= {"switches": [{"name": "up", "on": "x", "slides": True}]}


def grouped():
    """A structure two of whose loops close together."""
    plain = linkage(catalog.watt(clearance={"F": 1e-4}))
    (closure,) = plain.closures
    return replace(plain, closures=(closure, replace(closure, name="other")))


HINDERED = {
    "no_clearance": lambda: linkage(paper(clearance=0.0)),
    "rigid_impacts": lambda: linkage(mechanism("four_bar", "restitution", "none", False)),
    "bristles": lambda: linkage(mechanism("four_bar", "liu", "lugre", False)),
    "falling_friction": lambda: linkage(mechanism("four_bar", "hertz", "stribeck", False)),
    "imposed_motion": lambda: linkage(catalog.chunmei2002(drive=PROFILE)),
    "driven_link": lambda: linkage(catalog.chunmei2002(drive=TORQUE | {"link": "rocker"})),
    "work": lambda: linkage(paper(clearance=4e-5), powers=True),
    "section": lambda: linkage(paper(clearance=4e-5), section="angle:rocker"),
    "loop_groups": grouped,
    "sliding_switch": lambda: jp.System(**SLIDING).structure(),
    "bending_guard": lambda: jp.System(
        **JUMPING | {"jumps": [JUMPING["jumps"][0] | {"guard": "2-exp(u)"}]}
    ).structure(),
    "size": lambda: linkage(paper(clearance=dict.fromkeys("OABC", 4e-5))),
}


@pytest.mark.parametrize("friction", FALLING)
def test_what_friction_may_excite_is_looked_for_or_not_in_lanes(friction):
    """Steps that are long for a vibration that grows would damp it, and lanes do not look for such."""
    structure = linkage(mechanism("four_bar", "hertz", friction, False))
    assert _excites(structure)
    assert structure_exclusion(structure) == "falling_friction"


@pytest.mark.parametrize("word", EXCLUSIONS)
def test_what_lanes_do_not_take_has_a_word(word):
    assert structure_exclusion(HINDERED[word]()) == word


def test_each_word_is_explained():
    page = (Path(__file__).parents[2] / "docs" / "integrator.md").read_text(encoding="utf-8")
    table = page.partition("\n| `followed` |")[2].partition("\n\n")[0]
    assert re.findall(r"^\| `(\w+)` \| \S", table, re.M) == [*ROUTES]


TWO_PHASES = {
    "states": {"x": 0.1, "v": 0.0, "w": 0.2},
    "rates": {"x": "v", "v": "w - x*abs(x) - 0.3*v + cos(t)", "w": "sin(1.5*t + 0.4) - w"},
    "parameters": {},
    "forcing": "4*pi",
}
JUMPING = {
    "states": {"x": 0.5, "v": 0.0, "u": 0.0},
    "rates": {"x": "v", "v": "-x - 0.1*v", "u": "1"},
    "parameters": {},
    "jumps": [{"name": "kick", "guard": "1.7 - u", "jump": {"u": "0", "v": "v + 0.4"}}],
}
SYSTEMS = {
    "Duffing": catalog.duffing,
    "impact pair": lambda: catalog.impact_pair(gap=0.4, restitution=0.8),
    "soft pair": lambda: catalog.soft_impact_pair(gap=0.6, stiffness=100.0, damping=1.0),
    "no tension": lambda: catalog.soft_impact_pair(gap=0.6, stiffness=100.0, damping=1.0, tension=False),
    "gear": lambda: catalog.gear_backlash(0.1, 0.2, 1.6, 0.05),
    "ball": lambda: catalog.bouncing_ball(1.3, 0.5),
    "Lorenz": catalog.lorenz,
    "jerk": catalog.jerk,
    "two phases": lambda: jp.System(**TWO_PHASES),
    "jumps": lambda: jp.System(**JUMPING),
}
MANY, SAME = 1000, 1e-7


def sorts(name):
    """A system, many starts about its own, and two turns of each, cut once a turn."""
    base = SYSTEMS[name]()
    model, random = assemble(base, section="phase" if base.period else None), np.random.default_rng(7)
    scenes = [
        replace(model, state=model.state + random.uniform(-0.05, 0.05, len(model.state))) for _ in range(MANY)
    ]
    cut = {"at": model.period * np.arange(1, 3)}
    if base.period:
        cut = {"level": 1.0, "period": math.tau, "direction": 1}
    request = Request(TURNS * model.period, 1e-8, events=True, misses=True, log_from=-1.0, **cut)
    return scenes, request


@pytest.mark.nightly
@pytest.mark.parametrize("name", SYSTEMS)
def test_own_equations_are_as_one_by_one(name):
    scenes, request = sorts(name)
    assert not any(exclusion(each, request) for each in scenes)
    found, met, late = follow_ensemble(scenes, [request] * MANY), [], []
    for each, records in zip(scenes, found, strict=True):
        truth = follow(each, request)
        assert (records.status, truth.status) == (0, 0)
        same = records.events[:, :2].tolist() == truth.events[:, :2].tolist()
        met.append(same and len(records.misses) == len(truth.misses))
        if same:
            assert records.samples.shape[0] == max(len(request.at), 1)
            assert records.sections.shape == truth.sections.shape
            pairs = [(records.sections, truth.sections), (records.events, truth.events)]
            pairs += [(records.samples, truth.samples)] * bool(len(request.at))
            late.append(max(np.abs(a - b).max(initial=0.0) for a, b in pairs))
    assert np.mean(met) >= 0.999
    assert np.mean([each.route == IN_LANES for each in found]) >= 0.9
    assert np.median(late) < SAME


def test_own_equations_do_not_depend_on_company_or_order():
    scenes, request = sorts("impact pair")
    scenes = scenes[:40]
    found = follow_ensemble(scenes, [request] * 40)
    back = follow_ensemble(scenes[::-1], [request] * 40)[::-1]
    alone = [follow_ensemble([each], [request])[0] for each in scenes[:3]]
    for one, other in [*zip(found, back, strict=True), *zip(found[:3], alone, strict=True)]:
        assert all(
            getattr(one, name).tobytes() == getattr(other, name).tobytes()
            for name in ("events", "sections", "samples", "misses")
        )


def test_what_comes_to_rest_on_a_wall_steps_aside():
    model = assemble(catalog.impact_pair(gap=0.2, restitution=0.6), section="phase")
    scenes = [replace(model, state=np.array([0.0, speed])) for speed in (-1.3, -0.2, 0.5, 1.3)]
    request = Request(6 * model.period, 1e-8, events=True, log_from=-1.0)
    rested = []
    for each, records in zip(scenes, follow_ensemble(scenes, [request] * len(scenes)), strict=True):
        truth = follow(each, request)
        rested.append(Event.REST in truth.events[:, 1])
        assert ROUTES[records.route] == ("left_lanes" if rested[-1] else "in_lanes")
        assert records.route == IN_LANES or records.events.tobytes() == truth.events.tobytes()
        assert records.events[:, :2].tolist() == truth.events[:, :2].tolist()
    assert any(rested)
