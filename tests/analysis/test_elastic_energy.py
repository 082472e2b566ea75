"""Energy of linkages that bend: kept where nothing takes it, accounted for where something does."""

from __future__ import annotations

import math

import numpy as np
import pytest

import jointplay as jp
from tests.support.linkages import bending, mechanism, start

from ..reference.four_bar import Parameters

BALANCE = ["energy_residual", "drive_work", "joint_work", "structural_work", "kinetic_energy", "mode"]
STICK = 4
LARGE = 2.9e-4
ALL = ("crank", "coupler", "rocker")
LEFT_ALONE = Parameters(i=3.0, drive="none", f=0.0, C_n=0.0)


def kept(joints, elastic, turns, e=2.9e-5):
    """Energy along a motion without motor, friction and damping, relative to its start; events."""
    given = mechanism(LEFT_ALONE, dict.fromkeys(joints, e)).replace(elastic=elastic, damping_ratio=0.0)
    duration = turns * 2 * math.pi / LEFT_ALONE.w0
    words = ["energy", "strain_energy"] + ["penetration"] * bool(joints)
    found = jp.simulate(given, duration=duration, rtol=1e-10, initial=start(LEFT_ALONE), record=words)
    assert found.status == 0
    assert float(found.strain_energy.max()) > 1e-6 * float(found.energy[0])
    assert not joints or float(found.penetration.max()) > 1e-6
    return np.abs(found.energy.values / float(found.energy[0]) - 1).max(), int(found.n_events)


@pytest.mark.nightly
def test_contacts_and_an_elastic_link_keep_energy_over_ten_turns():
    error, events = kept("B", ("coupler",), 10)
    assert events > 1000
    assert error < 1e-11


def test_a_closed_loop_keeps_energy_over_ten_turns():
    assert kept("", ("coupler",), 10)[0] < 1e-11


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("joints", "elastic", "turns"),
    [("A", ("coupler",), 3), ("C", ("rocker",), 3), ("BC", ("coupler",), 2), ("B", ALL, 0.2), ("", ALL, 0.2)],
)
def test_other_joints_and_links_keep_energy(joints, elastic, turns):
    assert kept(joints, elastic, turns)[0] < 1e-11


def balance(joints="B", elastic=("coupler",), turns=5, smooth=None, damping=0.05, **changes):
    """A driven motion; its residual relative to the energy that the drive moved to and fro."""
    p = Parameters(i=3.0, **changes)
    given = mechanism(p, dict.fromkeys(joints, p.e), smooth).replace(elastic=elastic, damping_ratio=damping)
    words = [word for word in BALANCE if joints or word != "mode"]
    found = jp.simulate(given, turns=turns, rtol=1e-10, record=words, samples_per_turn=200)
    assert found.status == 0
    lost = np.diff(found.structural_work.values)
    assert lost.min() >= 0.0
    assert lost.sum() > 1e-6 * float(found.kinetic_energy.max())
    return found, np.abs(found.energy_residual).max() / np.abs(np.diff(found.drive_work)).sum()


@pytest.mark.nightly
@pytest.mark.parametrize("changes", [{}, {"f": 0.3}, {"f": 0.3, "e": LARGE}], ids=str)
def test_balance_with_friction_and_damping(changes):
    found, residual = balance(**changes)
    assert residual < 1e-12
    assert STICK in found.mode or "f" not in changes


def test_balance_of_a_closed_loop():
    found, residual = balance("", damping=0.3)
    assert residual < 1e-10
    assert np.all(found.joint_work == 0.0)


def test_balance_of_smoothed_friction_on_rigid_links():
    """Nothing sticks, and the friction's work is the force's."""
    p = Parameters(i=3.0, f=0.3)
    given = mechanism(p, {"B": p.e}, smooth=1e-2)
    found = jp.simulate(given, turns=5, rtol=1e-10, record=BALANCE, samples_per_turn=200)
    assert float(np.abs(found.energy_residual).max()) < 1e-11 * np.abs(np.diff(found.drive_work)).sum()
    assert set(np.unique(found.mode)) == {0, 5}
    assert np.all(found.structural_work == 0.0)


@pytest.mark.nightly
@pytest.mark.parametrize(
    "model",
    [
        {"tension": False, "C_t": 3.0, "f": 0.3},
        {"C_t": 3.0, "f": 0.3, "drive": "speed"},
        {"f": 0.3, "smooth": 1e-2},
        {"joints": "BC", "elastic": ("coupler", "rocker"), "turns": 1, "f": 0.3},
        {"joints": "A", "elastic": ALL, "turns": 0.5, "f": 0.3},
        {"joints": "", "elastic": ("coupler", "rocker"), "turns": 2},
        {"joints": "", "elastic": ALL, "turns": 0.3, "drive": "speed"},
    ],
    ids=str,
)
def test_balance_with_everything_on(model):
    assert balance(**model)[1] < 1e-10


def test_energy_of_unlike_beams():
    """Of links that bend by sines and by elements, in one closed loop under a constant speed."""
    p = Parameters(i=3.0, drive="speed")
    beams = {"coupler": jp.Beam(shapes="sine", modes=2, damping_ratio=0.1), "rocker": jp.Beam(elements=1)}
    given = bending(mechanism(p, {}), beams)
    found = jp.simulate(given, turns=2, rtol=1e-10, record=BALANCE[:-1], samples_per_turn=200)
    assert float(np.abs(found.energy_residual).max()) < 1e-11 * np.abs(np.diff(found.drive_work)).sum()
