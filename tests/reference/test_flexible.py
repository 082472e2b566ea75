"""The package's motions of bending links against the stored ones of the particles."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import jointplay as jp
from tests.support.linkages import mechanism, start

from ..analysis.test_truth import OTHER_NAMES, found_events
from .four_bar import LINKS
from .scenes import BENT as SCENES

TRUTH = json.loads(Path(__file__).with_name("flexible_truth.json").read_text())
RECORD = ["angle", "angular_velocity", "angular_acceleration", "reaction_x", "reaction_y"]
BENDING, PLAYING = ["deflection"], ["normal_force", "tangential_force", "journal_x", "journal_y"]
OWN_STRUCTURE = {  # each costs ten seconds of compilation or more and shows little that the others do not
    *("ideal_rigid_constant_speed", "ideal_coupler_three_elements", "ideal_coupler_rocker_constant_speed"),
    *("B_coupler_paper", "B_coupler_without_tension", "A_coupler", "BC_coupler_rocker", "conservative"),
    *("B_coupler_rocker", "ideal_coupler_slowly"),
}


def among(names):
    """Cases of these scenes, the dear ones only when asked for."""
    return [pytest.param(n, marks=pytest.mark.nightly) if n in OWN_STRUCTURE else n for n in names]


def bending(scene):
    """The package's record of a stored scene."""
    plain = mechanism(scene.parameters, scene.clearance)
    if not scene.beams:
        return plain
    beam = next(iter(scene.beams.values()))
    data = {"elements": beam.elements, "damping_ratio": beam.xi, "order": scene.order}
    return plain.replace(elastic=tuple(scene.beams), **data)


@cache
def motion(name, rtol=1e-12):
    """The package's motion at the stored times."""
    scene, times = SCENES[name], TRUTH[name]["times"]
    words = RECORD + BENDING * bool(scene.beams) + PLAYING * bool(scene.clearance)
    begin = start(scene.parameters) if scene.parameters.drive == "none" else None
    keywords = {"duration": times[-1], "at": times, "record": words, "initial": begin}
    found = jp.simulate(bending(scene), rtol=rtol, **keywords)
    assert found.status == 0
    return found


def apart(found, stored):
    """Largest difference over all times, and largest stored value."""
    return np.max(np.abs(np.subtract(found, stored))), np.max(np.abs(stored))


def by_link(found, word):
    """Values over time and crank, coupler, rocker."""
    return found[word].transpose("time", "link").sel(link=list(LINKS)).values


def force_on_bearing(found, joint):
    """Force over time and (x, y), of an ideal joint or one with play."""
    if joint in found.get("pin", []):
        return np.stack([found[word].sel(pin=joint) for word in ("reaction_x", "reaction_y")], 1)
    normal, tangential, x, y = (found[word].sel(joint=joint).values for word in PLAYING)
    rho = np.hypot(x, y)
    return np.stack([normal * x - tangential * y, normal * y + tangential * x], 1) / rho[:, None]


@pytest.mark.parametrize("name", among(SCENES))
def test_angles_and_speeds(name):
    found, stored, w0 = motion(name), TRUTH[name], SCENES[name].parameters.w0
    assert apart(by_link(found, "angle"), stored["angle"])[0] < 1e-11
    assert apart(by_link(found, "angular_velocity"), stored["angular_velocity"])[0] < 1e-9 * w0


@pytest.mark.parametrize("name", among(name for name, scene in SCENES.items() if scene.beams))
def test_deflections(name):
    stored = np.array(TRUTH[name]["deflection"])
    for link in SCENES[name].beams:
        difference, largest = apart(motion(name).deflection.sel(link=link), stored[:, LINKS.index(link)])
        assert difference < 1e-7 * largest  # of the crank's 3e-11 m at rtol 1e-12: 1.5e-8


@pytest.mark.parametrize("name", among(SCENES))
def test_forces_in_the_joints(name):
    for joint, stored in TRUTH[name]["reaction"].items():
        difference, largest = apart(force_on_bearing(motion(name), joint), stored)
        assert difference < 1e-7 * largest, joint


@pytest.mark.parametrize("name", among(name for name, scene in SCENES.items() if scene.clearance))
def test_events(name):
    other = {} if SCENES[name].parameters.tension else OTHER_NAMES
    rows, found = TRUTH[name]["events"], motion(name)
    times, kinds = found_events(found)
    assert kinds == [(row[1], other.get(row[2], row[2])) for row in rows]
    assert np.abs(times - [row[0] for row in rows]).max() < 1e-9 * float(found.turn_period_nominal)
    speeds = np.stack([found.event_normal_velocity, found.event_tangential_velocity], 1)
    assert np.abs(speeds - [row[3:] for row in rows]).max() < 1e-8


@pytest.mark.parametrize("name", ["ideal_coupler"])
def test_the_two_orders_differ_little_but_visibly(name):
    """The terms that the paper drops are a thousandth of the deflection here, not a rounding error."""
    difference, largest = apart(TRUTH[name]["deflection"], TRUTH[f"{name}_paper"]["deflection"])
    assert 1e-5 < difference / largest < 1e-2
