"""Laws at bearings with play, one to three of them: motions in lanes against motions one by one."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from jointplay import catalog
from jointplay.analysis.ensemble_runs import follow_ensemble, suits
from jointplay.analysis.trajectory import Request, follow
from jointplay.codegen.ensemble import known
from jointplay.mechanism.assemble import assemble
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
}
STARTS, TURNS = 12, 2.0
LANES = [pair for pair in PAIRS if pair not in (("restitution", "none"), ("liu", "lugre"))]


def starts(model):
    """Scenes with the journals about their bearings' centres, at speeds of their own."""
    random, n = np.random.default_rng(3), len(model.turning)
    unit = np.concatenate(
        [np.zeros(n), 0.02 * model.absolute[n : 2 * n] * model.turning, np.zeros(model.memories)]
    )
    for _ in range(STARTS):
        yield replace(model, state=model.state + unit * random.uniform(-1, 1, len(unit)))


def compared(model):
    """Share of motions in lanes that have a sharp run's events, and how far these are off, in turns."""
    scenes = list(starts(model))
    cut = {"level": model.crank_angle + 1.0, "period": math.tau, "direction": 1}
    request = Request(TURNS * model.period, 1e-7, events=True, misses=True, log_from=-1.0, **cut)
    assert all(suits(each, request) for each in scenes)
    found, met, late = follow_ensemble(scenes, [request] * STARTS), 0, []
    for each, records in zip(scenes, found, strict=True):
        truth = follow(each, replace(request, rtol=1e-11))
        assert (records.status, truth.status, records.way) == (0, 0, 1)
        same = records.events[:, :2].tolist() == truth.events[:, :2].tolist()
        met += same
        if same:
            late.append(np.abs(records.events[:, 2] - truth.events[:, 2]).max() / model.period)
            assert records.sections.shape == truth.sections.shape
    assert min(len(each.events) for each in found) > 1
    return met / STARTS, late


@pytest.mark.long
@pytest.mark.parametrize(("normal", "friction"), LANES)
def test_each_law_is_as_one_by_one(normal, friction):
    share, late = compared(assemble(mechanism("four_bar", normal, friction, False), section="angle:crank"))
    assert share == 1.0
    assert np.median(late) < 1e-5


@pytest.mark.long
@pytest.mark.parametrize("name", SCENES)
def test_several_joints_springs_and_loads_are_as_one_by_one(name):
    share, late = compared(assemble(SCENES[name](), section="angle:crank"))
    assert share == 1.0
    assert np.median(late) < 1e-5


@pytest.mark.parametrize(("normal", "friction"), [("restitution", "none"), ("liu", "lugre")])
def test_impacts_and_bristles_go_one_by_one(normal, friction):
    assert not known(assemble(mechanism("four_bar", normal, friction, False)).structure)
