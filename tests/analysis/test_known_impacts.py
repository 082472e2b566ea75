"""Walls with restitution: the impact pair and the bouncing ball against closed forms and exact event maps."""

import math

import numpy as np
import pytest

import jointplay as jp
from jointplay import catalog

from .exact_maps import TAU, Flight, Symmetric, distinct, impacts, strobed, symmetry_lost

PAIRS = [(3.6, 0.8), (20.0, 0.8), (8.0, 0.6)]
OK = 0


def pair(gap, restitution, start, **length):
    """A response of the rattling mass at rtol 1e-12."""
    options = {"rtol": 1e-12} | length
    if not {"at", "steps"} & length.keys():
        options["samples_per_turn"] = 20
    return jp.simulate(catalog.impact_pair(gap, restitution), initial=start, **options)


def sides(response):
    """States before and after each impact, (impact, 2, state), with their time."""
    time, state = response.time.values, response.state_value.values
    first = np.flatnonzero(np.diff(time) == 0)
    return time[first], np.stack([state[first], state[first + 1]], axis=1)


@pytest.mark.parametrize(("gap", "restitution"), PAIRS)
def test_symmetric_motion_stays(gap, restitution):
    exact = Symmetric(gap, restitution)
    found = pair(gap, restitution, exact.at_zero, turns=20, at=TAU * np.arange(1, 21))
    assert int(found.status) == OK
    assert found.state_value.values == pytest.approx(np.tile(exact.at_zero, (20, 1)), abs=1e-10)
    times = exact.t0 + math.pi * np.arange(1, 41)
    assert found.event_time.values == pytest.approx(times, abs=1e-10)
    assert found.event_joint.values.tolist() == [0, 1] * 20
    assert (found.event_kind == 6).all()


@pytest.mark.parametrize(("gap", "restitution"), PAIRS)
def test_incoming_speed(gap, restitution):
    exact = Symmetric(gap, restitution)
    _, states = sides(pair(gap, restitution, exact.at_zero, turns=20, steps=True))
    assert np.abs(states[:, 0, 1]) == pytest.approx(exact.speed, abs=1e-10)
    assert states[:, 1, 1] == pytest.approx(-restitution * states[:, 0, 1], rel=1e-15)
    assert np.abs(states[:, :, 0]) == pytest.approx(gap / 2, abs=1e-12)


@pytest.mark.parametrize(("gap", "restitution"), PAIRS)
def test_half_period_map(gap, restitution):
    """Trace and determinant of the map from impact to impact, from differences of whole motions."""
    exact, h = Symmetric(gap, restitution), 1e-5

    def two_impacts(dy, dv):
        start = np.add(exact.at_zero, (dy, dv))
        time, states = sides(pair(gap, restitution, start, duration=6.0, steps=True))
        outgoing = states[:2, 1, 1] * (-1, 1)
        return np.column_stack([time[:2], outgoing])

    columns = [(two_impacts(*d) - two_impacts(*(-d))) / (2 * h) for d in h * np.eye(2)]
    first, second = (np.column_stack([column[i] for column in columns]) for i in (0, 1))
    half = second @ np.linalg.inv(first)
    trace, determinant = exact.half_map
    assert np.trace(half) == pytest.approx(trace, abs=2e-5)
    assert np.linalg.det(half) == pytest.approx(determinant, abs=2e-5)


def after_a_disturbance(gap, restitution, turns, size=1e-7):
    exact = Symmetric(gap, restitution)
    start = np.add(exact.at_zero, (size, 0))
    found = pair(gap, restitution, start, turns=turns, at=[turns * TAU])
    return np.abs(found.state_value.values[-1] - exact.at_zero).max() / size


@pytest.mark.parametrize("restitution", [0.8, 0.6])
def test_limits_of_existence(restitution):
    fold, lost = Symmetric(1.0, restitution).fold, symmetry_lost(restitution)
    assert after_a_disturbance(0.99 * fold, restitution, 40) < 1e-3
    assert after_a_disturbance(1.03 * lost, restitution, 60) < 1e-2
    assert after_a_disturbance(0.97 * lost, restitution, 60) > 100
    beyond = pair(1.005 * fold, restitution, Symmetric(fold * (1 - 1e-9), restitution).at_zero, turns=200)
    assert not np.allclose(np.diff(beyond.event_time.values)[-20:], math.pi, atol=0.1)


@pytest.mark.parametrize(("time", "speed", "points"), [(2.0, 0.5, 1), (1.0, 1.3, 3)])
def test_coexisting_motions(time, speed, points):
    start = strobed(3.6, 0.8, (time, -1.8, speed), 1)
    section = jp.poincare(catalog.impact_pair(3.6, 0.8), turns=24, transient=400, initial=start)
    assert distinct(section) == points
    if points == 1:
        assert section.state_value.values[-1] == pytest.approx(Symmetric(3.6, 0.8).at_zero, abs=1e-8)


@pytest.mark.parametrize(("gap", "restitution", "count"), [(0.4, 0.8, 30), (0.6, 0.6, 30), (1.4, 0.8, 20)])
def test_impacts_of_an_irregular_motion(gap, restitution, count):
    truth = impacts(gap, restitution, (0.0, 0.05, 0.7), count)
    found = pair(gap, restitution, (0.05, 0.7), duration=truth[-1][0] + 1e-6, rtol=1e-13)
    assert found.sizes["event"] == count
    assert found.event_time.values == pytest.approx([t for t, _, _ in truth], abs=1e-9)
    assert found.event_joint.values.tolist() == [0 if side > 0 else 1 for _, side, _ in truth]


@pytest.mark.parametrize("rtol", [1e-4, 1e-8, 1e-12])
def test_restitution_and_energy(rtol):
    _, states = sides(pair(0.4, 0.8, (0.05, 0.7), turns=20, steps=True, rtol=rtol))
    before, after = states[:, 0], states[:, 1]
    assert len(states) > 40
    assert np.array_equal(after[:, 0], before[:, 0])
    assert after[:, 1] == pytest.approx(-0.8 * before[:, 1], rel=1e-15)
    assert (np.sign(before[:, 1]) == np.sign(before[:, 0])).all()
    assert (np.abs(after[:, 1]) <= np.abs(before[:, 1])).all()


def test_elastic_walls_give_no_energy():
    """With r = 1, v^2/2 changes by the work of the forcing alone."""
    found = pair(1.0, 1.0, (0.0, 1.0), turns=30, steps=True)
    time, (y, v) = found.time.values, found.state_value.values.T
    work = np.zeros(len(time))
    for i in np.flatnonzero(np.diff(time) > 0):
        flight = Flight(time[i], y[i], v[i])
        work[i + 1] = (flight.at(time[i + 1])[1] ** 2 - v[i] ** 2) / 2
    assert v**2 / 2 - v[0] ** 2 / 2 == pytest.approx(np.cumsum(work), abs=1e-9)


@pytest.mark.parametrize(
    ("start", "first", "after"),
    [((1.8, -0.5), None, -0.5), ((1.8, 0.5), 0.0, -0.4), ((-1.8, -0.5), 0.0, 0.4)],
)
def test_start_on_a_wall(start, first, after):
    found = pair(3.6, 0.8, start, turns=1, steps=True)
    flight = Flight(0.0, start[0], after)
    time, _ = flight.leaves(1.8)
    events = found.event_time.values.tolist()
    assert int(found.status) == OK
    if first is not None:
        assert events.pop(0) == first
    assert events[0] == pytest.approx(time, abs=1e-10)


@pytest.mark.parametrize("rtol", [1e-5, 1e-8, 1e-12])
@pytest.mark.parametrize("beyond", [-1e-3, -1e-9, -1e-14, 0.0, 1e-14, 1e-9, 1e-6, 1e-4, 1e-2])
def test_grazing(beyond, rtol):
    """A flight that comes to rest at t = 4.5, `beyond` the wall: one touch or none, and no chatter."""
    touch = 4.5
    start = 1.5 - touch * math.cos(touch) + math.sin(touch) + beyond, math.cos(touch) - 1
    found = pair(3.0, 0.8, start, duration=9.0, at=np.linspace(0, 9, 181), rtol=rtol)
    assert int(found.status) == OK
    assert found.sizes["event"] <= (1 if beyond < 1e-3 else 3)
    deep = max(beyond, 1e-13, 1e-4 * rtol)  # or as deep as the run's error makes it
    speed = math.sqrt(2 * abs(math.sin(touch)) * deep)
    missed = 2 * speed * 4.5  # what the path may differ by if the touch is passed over, or taken for one
    exact = np.array([Flight(0.0, *start).at(t) for t in found.time.values])
    if beyond < -1e-12:
        assert found.sizes["event"] == 0
        assert found.state_value.values == pytest.approx(exact, abs=1e-9)
    elif beyond > 10 * rtol:
        assert found.event_time.values[0] == pytest.approx(Flight(0.0, *start).leaves(1.5)[0], abs=1e-7)
    else:
        assert found.state_value.values == pytest.approx(exact, abs=missed)


def test_a_clock_beside_a_wall_changes_nothing_that_is_said_of_the_wall():
    """Its jump is recorded as an impact, but no gap closes: no contact begins, at no speed."""
    keys = {
        "name": "oscillator at a wall",
        "states": {"x": 0.3, "v": 0.0},
        "parameters": {"a": 1.2, "r": 0.7},
        "rates": {"x": "v", "v": "a*cos(1.3*t) - x - 0.2*v"},
        "forcing": "2*pi/1.3",
        "impacts": [{"name": "wall", "gap": "0.5 - x", "restitution": "r"}],
    }
    clock = {
        "states": keys["states"] | {"c": 0.55},
        "rates": keys["rates"] | {"c": "-1.3/(2*pi)"},
        "jumps": [{"name": "clock", "guard": "c", "jump": {"c": "c + 1"}}],
    }

    def said(system):
        run, slopes = jp.simulate(system, turns=4.0), jp.gradient(system, turns=2)
        orbit = jp.periodic_orbit(system)
        points = jp.bifurcation(system, over={"a": [1.2]}, turns=20, transient=20)
        of_all = ("impacts", "contact_fraction", "smallest_impact_speed")
        return [
            *(run["contacts_begun"], slopes["derivative_status"], slopes["grazing"]),
            *(orbit["impacts"], orbit["smallest_impact_speed"]),
            *(points[name].squeeze() for name in of_all),
        ]

    systems = jp.System(**keys), jp.System(**keys | clock)
    known, told = ([float(each) for each in said(system)] for system in systems)
    assert known[0] == 4
    assert known[-1] == pytest.approx(2.097, abs=1e-3)
    assert told == pytest.approx(known, rel=1e-6)
    found = jp.gradient(systems[1], orbit=True, transient=20)  # at any time of the clock there is another one
    assert jp.words(found)["derivative_status"] == "neutral"
    assert np.isnan(found["derivative"]).all()
