"""Motions that reach a dead centre end there.

Five uniform bars in two parallelograms fall into one line, where no step leads on (N-four-bar). The long
crank of a slider-crank turns back where the short rod stands across the guide.
"""

import numpy as np
import pytest
from scipy.integrate import quad

import jointplay as jp
from jointplay.analysis.quantities import STATUS
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.loops import ideal
from jointplay.solver.motion.eligibility import ROUTES
from jointplay.solver.motion.ensemble_runs import follow_ensemble
from jointplay.solver.motion.trajectory import Request, follow

L, M, G, SPEED = 1.0, 1.0, 9.81, -1.0


def falling():
    """Three upright bars on the ground, joined by two level ones."""
    names = ("crank", "c1", "r1", "c2", "r2")
    links = [jp.Link(name=name, length=L, mass=M, inertia=M * L * L / 3) for name in names]
    pins = {
        "O": ({"link": "crank"}, {"link": "ground", "point": (0, 0)}),
        "A": ({"link": "crank", "at": L}, {"link": "c1"}),
        "B": ({"link": "c1", "at": L}, {"link": "r1", "at": L}),
        "C": ({"link": "r1"}, {"link": "ground", "point": (1, 0)}),
        "D": ({"link": "c2"}, {"link": "r1", "at": L}),
        "E": ({"link": "c2", "at": L}, {"link": "r2", "at": L}),
        "F": ({"link": "r2"}, {"link": "ground", "point": (2, 0)}),
    }
    joints = [jp.Joint(name=name, journal=one, bearing=two) for name, (one, two) in pins.items()]
    guess = {"crank": 1.57, "c1": 0.0, "r1": 1.57, "c2": 0.0, "r2": 1.57}
    return jp.Mechanism(name="falling", links=links, joints=joints, gravity=G, guess=guess)


SPEED_UP = {"kind": "profile", "link": "crank", "start": 5.0, "end": 20.0, "time": 0.2}
DRIVES = [{"kind": "speed", "link": "crank", "speed": 20.0}, pytest.param(SPEED_UP, marks=pytest.mark.long)]


@pytest.mark.parametrize("drive", DRIVES, ids=["speed", "profile"])
def test_an_imposed_speed_ends_where_the_rod_cannot_follow(drive, monkeypatch):
    """A crank longer than its rod, let past its refusal: none beyond arcsin(3/4), no value that is none."""
    monkeypatch.setattr(ideal, "cannot_turn", lambda *_: iter(()))
    mechanism = jp.catalog.slider_crank(crank=0.2, rod=0.15, clearance=0, drive=drive)
    run = jp.simulate(mechanism, turns=1, record=["angle", "reaction"])
    assert STATUS[int(run.status)] == "not_converged"
    assert 0.99 < float(run.angle.sel(link="crank")[-1]) / np.arcsin(0.75) < 1
    assert not run.angle.isnull().any()
    assert not run.reaction.isnull().any()


@pytest.mark.nightly
def test_a_dead_centre_ends_a_run_soon():
    """Energy by hand: inertia 3 M L^2/3 + 2 M L^2, weights at 3 L/2 + 2 L."""
    start = {"crank_angle": np.pi / 2, "crank_speed": SPEED}
    names = ["angle", "angular_velocity"]
    run = jp.simulate(falling(), duration=10.0, initial=start, record=names, max_steps=200_000)
    assert STATUS[int(run.status)] == "not_converged"
    last = run.sel(link="crank").isel(time=-1)
    squared = SPEED**2 + 2 * 3.5 * M * G * L * (1 - np.sin(last.angle)) / (3 * M * L**2)
    assert 0 < last.angle < 0.1
    np.testing.assert_allclose(last.angular_velocity**2, squared, rtol=1e-7)


LONG, SHORT, ROD, SLIDER = 1.0, 0.5, 0.4, 0.7


def turning_back(clearance=0.0):
    """A crank and a rod, half as long, to a slider; with clearance, something hangs on that."""
    links = [
        jp.Link(name="crank", length=LONG, mass=M, inertia=M * LONG**2 / 3),
        jp.Link(name="rod", length=SHORT, mass=ROD, inertia=ROD * SHORT**2 / 3),
        jp.Link(name="slider", length=0.1, mass=SLIDER, inertia=0.01),
    ]
    ground = {"link": "ground", "point": (0, 0)}
    joints = [
        jp.Joint(name="O", journal={"link": "crank"}, bearing=ground),
        jp.Joint(name="A", journal={"link": "crank", "at": LONG}, bearing={"link": "rod"}),
        jp.Joint(name="B", journal={"link": "rod", "at": SHORT}, bearing={"link": "slider"}),
        jp.Joint(name="G", kind="prismatic", journal={"link": "slider"}, bearing=ground),
    ]
    guess = {"crank": 0.2, "rod": -0.4}
    if clearance:
        guess["tail"] = 0.0
        links.append(jp.Link(name="tail", length=0.3, mass=0.1, inertia=0.003))
        loose = {"clearance": clearance, "radius": 0.01, "contact": {"stiffness": 1e6, "damping": 10.0}}
        joints.append(jp.Joint(name="T", journal={"link": "slider"}, bearing={"link": "tail"}, **loose))
    return jp.Mechanism(name="turning_back", links=links, joints=joints, gravity=0.0, guess=guess)


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-8, 1e-11])
def test_a_crank_does_not_turn_back_at_a_dead_centre_with_what_it_leads(rtol):
    """The time to there, by quadrature over the rod's angle, in which the motion is regular."""
    angle, speed, last = 0.2, 1.0, 1.5
    names = ["energy_residual", "angular_velocity"]
    start = {"crank_angle": angle, "crank_speed": speed}
    at = np.linspace(0.0, last, 3001)
    run = jp.simulate(turning_back(), duration=last, initial=start, rtol=rtol, record=names, at=at)
    assert STATUS[int(run.status)] == "not_converged"

    def energy(rod):
        """Kinetic energy at a rod's angle, below the guide, and its rate 1."""
        crank = np.arcsin(SHORT / LONG * np.sin(rod))
        rate = SHORT * np.cos(rod) / (LONG * np.cos(crank))
        end = LONG * rate * np.array([-np.sin(crank), np.cos(crank)])
        middle = end - SHORT / 2 * np.array([np.sin(rod), np.cos(rod)])
        slider = end[0] - SHORT * np.sin(rod)
        turning = M * LONG**2 / 6 * rate**2 + ROD * SHORT**2 / 24
        return turning + ROD / 2 * (middle @ middle) + SLIDER / 2 * slider**2

    first = np.arcsin(LONG / SHORT * np.sin(angle))
    started = speed * LONG * np.cos(angle) / (SHORT * np.cos(first))
    whole = started**2 * energy(first)
    arrival = quad(lambda rod: np.sqrt(energy(rod) / whole), first, np.pi / 2)[0]
    reached = run.time.values
    assert arrival - last / 1500 < reached[-1] < arrival
    assert np.all(run.angular_velocity.sel(link="crank") > 0)
    np.testing.assert_allclose(run.energy_residual, 0.0, atol=300 * rtol * whole)


@pytest.mark.nightly
def test_lanes_leave_it_to_one_by_one():
    """A motion that arrives beside others that do not: lanes took it across, as `ok`."""
    slack = assemble(turning_back(clearance=1e-3), {"crank_angle": 0.2, "crank_speed": 1.0})
    asked = [Request(time, 1e-6, at=np.array([time])) for time in (1.5, 0.1, 1.4, 0.12, 1.3)]
    found = follow_ensemble([slack] * len(asked), asked)
    for request, run in zip(asked, found, strict=True):
        alone, arrives = follow(slack, request), request.duration > 1
        assert STATUS[run.status] == STATUS[alone.status] == ("not_converged" if arrives else "ok")
        assert ROUTES[run.route] == ("left_lanes" if arrives else "in_lanes")
        assert run.samples.shape == alone.samples.shape
        assert np.allclose(run.samples, alone.samples, atol=1e-5)
