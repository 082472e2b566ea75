"""Links that bend, with play: motion, contacts, reactions and energies against rows of particles."""

from __future__ import annotations

import numpy as np
import pytest

from ..reference.four_bar import ANGLES, LINKS, by_name, scattered
from .both import pair
from .test_accelerations import agree, mixed
from .test_outputs import evaluated

MODES = ("free", "slip+", "slip-", "stick")
SCENES = [  # joints with play, links that bend, drive, order: grounded, hung by the far end, floating
    ("B", "coupler", "motor", "consistent"),
    ("B", "crank coupler rocker", "speed", "consistent"),
    ("A", "coupler rocker", "motor", "consistent"),
    ("C", "rocker", "speed", "consistent"),
    ("AC", "coupler", "motor", "consistent"),
    ("AB", "coupler", "motor", "consistent"),
    ("B", "coupler rocker", "motor", "paper"),
    ("AC", "rocker", "speed", "paper"),
]
every_scene = pytest.mark.parametrize(
    "model", SCENES, ids=["_".join(model).replace(" ", "_") for model in SCENES]
)


def combinations(joints):
    """Modes of all joints."""
    same = [(mode,) * len(joints) for mode in MODES]
    return same + [mixed(len(joints), seed) for seed in range(3)] if len(joints) > 1 else same


@pytest.mark.nightly
@every_scene
def test_accelerations_and_contacts(model):
    system, ours = pair(*model)
    for seed, modes in enumerate(combinations(model[0])):
        agree(system, ours, scattered(system, seed), modes)


@pytest.mark.nightly
@every_scene
def test_outputs(model):
    """Reactions and torque are the multipliers; energies are the particles'."""
    system, ours = pair(*model)
    for mode in MODES:
        y = scattered(system, 4)
        solved = system.at_modes(y, dict.fromkeys(model[0], mode))
        found = evaluated(system, ours, y, [mode] * len(model[0]))
        turning = solved.acceleration[ANGLES]
        assert [found[f"angular_acceleration:{k}"] for k in LINKS] == pytest.approx(turning, rel=1e-9)
        check_reactions(system, y, solved, found)
        check_energies(system, y, found)


def check_reactions(system, y, solved, found):
    """Forces on the bearings of ideal joints, and the torque."""
    held = by_name(solved)[0]
    scale = max(np.abs(force).max() for force in held.values())
    for name in (joint.name for joint in system.joints if joint.play is None):
        force = [found[f"reaction_{axis}:{name}"] for axis in "xy"]
        assert force == pytest.approx(held[name][:2], abs=1e-10 * scale)
        assert found[f"reaction:{name}"] == pytest.approx(np.hypot(*force), abs=1e-10 * scale)
    law = system.p.a - system.p.b * y[system.half] if system.p.drive == "motor" else 0.0
    torque = -held["drive"][2] if system.p.drive == "speed" else law
    assert found["drive_torque"] == pytest.approx(torque, abs=1e-10 * scale)


def check_energies(system, y, found):
    """Energies, and the deflections at mid-length."""
    kinetic, potential, strain = system.energies(0.0, system.full(y))
    assert found["kinetic_energy"] == pytest.approx(kinetic, rel=1e-12)
    assert found["potential_energy"] == pytest.approx(potential + strain, rel=1e-11)
    assert found["strain_energy"] == pytest.approx(strain, rel=1e-12)
    bent = system.deflections(system.full(y))
    for name in LINKS if bent else ():
        assert found[f"deflection:{name}"] == pytest.approx(bent.get(name, 0.0), rel=1e-12)
