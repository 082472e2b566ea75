"""Normal laws in the method itself: a body that bounces about in its bearing."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import jointplay as jp
from jointplay.analysis.tangents import scales
from jointplay.solver.equations.laws import FACTORS
from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.method.codes import Event
from jointplay.solver.motion.trajectory import Request, follow
from tests.method.test_tangent import differences, distance, scaled
from tests.support.plain import Point, plain
from tests.support.tangent_map import agreed, tangent_map

sys.path.insert(0, str(Path(__file__).parents[2] / "docs"))
from pages import laws as page

from tests.support.linkages import jointed

CLEARANCE, K = 1e-3, 2e9
NUMBERS = {"hunt_crossley": {"dissipation": 0.3}, "flores": {"restitution": 0.5}}
FACTOR = {"hunt_crossley": lambda v_0: 0.3 * v_0, "flores": lambda v_0: FACTORS["flores"][0](0.5)}
EVENT, STATE = 1, 3  # columns of events: kind; the state


def body(law, centre=0.0, tension=True, **numbers):
    """A body with one pin in a bearing on the ground."""
    contact = jp.Contact(law=law, stiffness=K, parameters=NUMBERS[law] | numbers, tension=tension)
    link = jp.Link(name="body", length=0.1, mass=0.3, centre=centre, inertia=1e-3)
    ground = jp.Pin(link="ground", point=(0.0, 0.0))
    joint = jp.Joint(
        name="B",
        journal=jp.Pin(link="body"),
        bearing=ground,
        clearance=CLEARANCE,
        radius=0.01,
        contact=contact,
    )
    still = {"angle": {"body": 0.0}, "angular_velocity": {"body": 0.0}}
    return assemble(jp.Mechanism(links=(link,), joints=(joint,), gravity=0.0), still)


def at(model, x=0.0, y=0.0, **speeds):
    """The model that starts with its pin at (x, y), with speeds in the order of the equations."""
    state = model.state.copy()
    state[1:3] = x, y
    for place, name in enumerate(("w", "vx", "vy", "v_0"), 3):
        state[place : place + 1] = speeds.get(name, state[place : place + 1])
    return replace(model, state=state)


def events(model, duration, rtol=1e-12):
    """Events of a motion, and how it ended."""
    found = follow(model, Request(duration, rtol, events=True, log_from=-1.0))
    return found.events, found.status


@pytest.mark.parametrize("law", ["flores", pytest.param("hunt_crossley", marks=pytest.mark.nightly)])
@pytest.mark.parametrize("v_0", [1e-2, 1e-1, 1.0, 10.0])
def test_impacts_have_the_restitution_of_their_law(law, v_0):
    model = at(body(law), vx=0.6 * v_0, vy=0.8 * v_0)
    met, status = events(model, 1.1 * CLEARANCE / v_0 + 2e-3 * v_0**-0.2)
    speed = np.linalg.norm(met[:, STATE + 4 : STATE + 6], axis=1)
    assert status == 0
    assert met[:2, EVENT].tolist() == [Event.CONTACT, Event.SEPARATION]
    assert speed[0] == pytest.approx(v_0, rel=1e-12)
    assert speed[1] / speed[0] == pytest.approx(page.restitution(FACTOR[law](v_0)), abs=1e-9)


def test_what_is_remembered_is_set_by_each_entry_and_stays_until_separation():
    met, _ = events(at(body("flores"), vx=6.0, vy=8.0), 2.1e-3)
    entries = met[:, EVENT] == Event.CONTACT
    inwards = np.linalg.norm(met[entries, STATE + 4 : STATE + 6], axis=1)
    assert entries.sum() >= 3
    assert np.all(met[entries, STATE + 6] == 1e-3)  # an event shows the side before it
    assert np.allclose(met[~entries, STATE + 6], inwards[: (~entries).sum()], rtol=1e-12)


def test_slow_entries_count_as_those_of_the_smallest_speed():
    met, _ = events(at(body("flores", slowest=0.1), vx=0.01), 0.11)
    speed = np.abs(met[:2, STATE + 4])
    assert met[1, STATE + 6] == 0.1
    assert speed[1] / speed[0] == pytest.approx(page.restitution(0.1 * FACTOR["flores"](1.0)), abs=1e-9)


@pytest.mark.nightly
def test_a_force_that_may_not_pull_ends_and_comes_back_within_the_gap():
    def run(tension):
        model = at(body("flores", tension=tension), x=1.02e-3, vx=-2.0, vy=0.3, v_0=1.0)
        return events(model, 5e-3)

    held, status = run(False)
    assert status == 0
    assert held[0, EVENT] == Event.REOPENING  # torn away faster than 1 / chi
    assert run(True)[0][0, EVENT] == Event.SEPARATION
    assert held[1, EVENT] == Event.CONTACT


@pytest.mark.long
@pytest.mark.parametrize("law", ["flores", pytest.param("hunt_crossley", marks=pytest.mark.nightly)])
def test_tangents_through_entry_and_release_are_those_of_neighbours(law):
    start = at(body(law, centre=0.02), 2e-4, -3e-4, w=3.0, vx=1.0, vy=-0.8)
    times = np.array([0.0, 7.0e-4, 1.05e-3, 1.6e-3])
    rows = follow(start, Request(2e-3, 1e-13, at=times)).samples
    touched, entered = set(), 0
    for row in rows:
        model = replace(start, state=row[1 : 1 + len(start.state)])
        touched.add(bool(row[1 + len(start.state)]))
        for duration in (8e-4, 3.9e-3):
            exact = scaled(model, duration)
            best, kinds = _quotients(model, duration, exact)
            if best is not None:
                kept = np.any(best != 0.0, axis=0)
                assert np.array_equal(kept, np.any(exact != 0.0, axis=0))
                assert distance(exact[:, kept], best[:, kept]) < 1e-6
                entered += (0, Event.CONTACT) in kinds
    assert touched == {False, True}
    assert entered >= 4


def _quotients(model, duration, exact):
    """The best of the difference quotients, or None where they do not agree among themselves; the events."""
    found = [differences(model, duration, size, exact) for size in (1e-6, 3e-6, 1e-5)]
    return agreed(found, lambda a, b: np.linalg.norm(a - b), 5e-7 * np.linalg.norm(exact)), found[0][1]


def test_what_is_remembered_is_lost_at_the_next_entry_alone():
    model = at(body("flores"), vx=1.0)
    assert not np.any(tangent_map(model, 1.2e-3)[:, -1])
    assert tangent_map(model, 5e-4)[-1, -1] == 1.0
    inside = at(model, x=1.01e-3, vx=0.5, v_0=0.7)
    assert tangent_map(inside, 1e-5)[-1, -1] == 1.0


@pytest.mark.nightly
def test_exponents_leave_out_what_is_remembered():
    found = jp.lyapunov(_linkage(2.9e-4), exponents="all", turns=8, transient=2, rtol=1e-9)
    assert found.sizes["exponent"] == 6
    assert np.isfinite(found.lyapunov_exponent).all()
    with pytest.raises(jp.InputError, match="from 1 to 6"):
        jp.lyapunov(_linkage(2.9e-4), exponents=7, turns=1)


def _linkage(clearance):
    ideal = catalog.chunmei2002(clearance=clearance, gear_ratio=3.0, friction=0.0)
    contact = jp.Contact(law="flores", stiffness=K, parameters=NUMBERS["flores"])
    return jointed(ideal, contact=contact)


def test_a_start_in_contact_remembers_its_normal_speed():
    mechanism = _linkage(2.9e-5)
    ideal = assemble(mechanism)
    assert ideal.state[-1] == 1e-3
    names = ("crank", "coupler", "rocker")
    angles = dict(zip(names, ideal.state[:3] + np.array([0.0, 3e-4, 0.0]), strict=True))
    for turn in (1.0, -1.0):
        speeds = dict(zip(names, turn * ideal.state[3:6] + np.array([0.0, 4.0, 0.0]), strict=True))
        model = assemble(mechanism, {"angle": angles, "angular_velocity": speeds})
        u, v_n, *_ = Point(plain(model.structure), model.numbers, model.state, ("contact",)).contacts()[0]
        assert u > 0
        assert model.state[-1] == pytest.approx(abs(v_n), rel=1e-9)
    assert scales(ideal)[-1] == scales(model)[-1]
