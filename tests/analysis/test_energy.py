"""Energy: the balance of driven scenes, and what undriven ones keep."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ..reference.scenes import SCENES
from .test_truth import motion

BALANCE = ["energy_residual", "drive_work", "joint_work", "kinetic_energy", "mode"]
STICK = 4


def flowed(found):
    """Energy that the drive moved to and fro, J."""
    return float(np.abs(np.diff(found.drive_work.values)).sum())


def turns(name, count):
    """Duration of some nominal turns of a model, s."""
    return count * 2 * math.pi / SCENES[name].parameters.w0


@pytest.mark.parametrize(
    "name",
    [
        *("A", "B", "C", "B_sticking", "C_constant_speed"),
        *(pytest.param(n, marks=pytest.mark.nightly) for n in ("C_without_tension", "damped_at_BC_sticking")),
    ],
)
def test_balance_over_fifty_turns(name):
    found = motion(name, 1e-10, duration=turns(name, 50), at=None, record=BALANCE)
    assert found.status == 0
    assert float(np.abs(found.energy_residual).max()) < 2e-11 * flowed(found)
    assert not name.endswith("sticking") or STICK in found.mode


def test_balance_at_the_integrators_own_points():
    found = motion("C_sticking", 1e-10, duration=turns("C_sticking", 5), at=None, steps=True, record=BALANCE)
    assert float(np.abs(found.energy_residual).max()) < 2e-11 * flowed(found)


@pytest.mark.parametrize("name", ["B", "C_sticking"])
def test_contacts_only_take_in(name):
    """The work taken in by the contacts, less what they store and give back, never falls."""
    found = motion(name, 1e-10, duration=turns(name, 10), at=None, record=[*BALANCE, "energy"])
    mechanical = found.energy - found.energy.isel(time=0) - found.drive_work
    lost = -mechanical.values
    assert np.diff(lost).min() > -1e-12 * flowed(found)
    assert lost[-1] > 0.0


@pytest.mark.parametrize("joints", ["A", "B", "C", "BC"])
def test_undriven_undamped_motion_keeps_its_energy(joints):
    name = f"conservative_at_{joints}"
    found = motion(name, 1e-10, duration=turns(name, 5), at=None, record=["energy", "penetration"])
    energy = found.energy.values
    assert found.status == 0
    assert found.n_events > 300
    assert np.abs(energy - energy[0]).max() < 1e-9 * energy[0]
    assert float(found.penetration.max()) > 1e-6
