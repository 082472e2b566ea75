"""Motions under springs and loads: the balance of energy as results tell it; orbits in step with a load."""

import numpy as np
import pytest

import jointplay as jp
from tests.support.motion import at, pendulum

BALANCE = ["energy_residual", "drive_work", "joint_work", "spring_work", "load_work", "kinetic_energy"]
PEG = {"name": "peg", "from": {"link": "rocker", "at": 0.05}, "to": {"link": "ground", "point": (0.3, 0.1)}}
PEG |= {"stiffness": 1000.0, "damping": 3.0, "free_length": 0.1}
HINGE = {"name": "hinge", "kind": "torsion", "from": "coupler", "to": "rocker", "stiffness": 2.0}
PRESS = {"name": "press", "kind": "force", "on": {"link": "rocker", "at": 0.1}, "direction": 0.3}
PRESS |= {"harmonics": [{"order": 2, "cosine": 30.0}], "angle": "crank"}
SHAKE = {"name": "shake", "kind": "torque", "link": "coupler", "table": [0.0, 1.0, 2.0, 3.0, 2.0, 1.0]}
SHAKE |= {"frequency": 50.0}
PROFILE = {"kind": "profile", "link": "crank", "start": 0.0, "end": 60.0, "time": 0.2}
TORQUE = {"kind": "torque", "link": "crank", "constant": 1.0, "nominal_speed": 50.0}


def test_results_tell_the_balance_of_a_pendulum():
    spring = {"name": "hinge", "kind": "torsion", "from": "arm", "to": "ground", "stiffness": 3.0}
    load = {"name": "shake", "kind": "torque", "link": "arm", "frequency": 6.0}
    load |= {"harmonics": [{"order": 1, "sine": 1.0}]}
    shaken = pendulum(springs=[spring | {"damping": 0.05}], loads=[load])
    found = jp.simulate(shaken, duration=5.0, rtol=1e-11, record=BALANCE, initial=at(shaken, [0.5], [0.0]))
    flow = np.abs(np.diff(found.load_work)).sum()
    assert flow > 1.0 < 10 * float(found.spring_work[-1])
    assert np.abs(found.energy_residual).max() < 1e-9 * flow


@pytest.mark.nightly
@pytest.mark.parametrize(
    "changes",
    [
        {"springs": [PEG, HINGE], "loads": [PRESS, SHAKE], "gravity_direction": 0.4, "gear_ratio": 3.0},
        {"springs": [PEG], "loads": [PRESS, SHAKE], "drive": PROFILE},
        {"clearance": {}, "springs": [PEG], "loads": [PRESS, SHAKE], "drive": TORQUE},
        {"clearance": {}, "springs": [PEG], "loads": [PRESS, SHAKE], "drive": PROFILE},
    ],
    ids=["motor", "profile", "torque_ideal", "profile_ideal"],
)
def test_results_tell_the_balance(changes):
    given = jp.catalog.chunmei2002(**{"clearance": 2.9e-4} | changes)
    found = jp.simulate(given, turns=3, rtol=1e-10, record=BALANCE)
    assert int(found.status) == 0
    flow = np.abs(np.diff(found.drive_work)).sum()
    assert np.abs(found.energy_residual).max() < 1e-9 * flow
    assert np.abs(found.load_work[-1]) > 1e-6 * flow


@pytest.mark.nightly
def test_an_orbit_in_step_with_a_load_closes():
    """At 25 rad/s the load of 50 rad/s repeats with each turn, whatever the phase of the section."""
    given = jp.catalog.chunmei2002(clearance=2.9e-5, speed=25.0, loads=[SHAKE])
    orbit = jp.periodic_orbit(given, transient=20, section=jp.CrankAngle(angle=1.0))
    assert int(orbit.status) == 0
    other = jp.periodic_orbit(given, transient=20)
    assert int(other.status) == 0
    multipliers = [np.sort(np.abs(each.floquet_multiplier.values)) for each in (orbit, other)]
    assert multipliers[0] == pytest.approx(multipliers[1], abs=1e-6)
