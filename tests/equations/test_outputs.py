"""Recorded quantities against the free bodies: accelerations, forces, reactions, torque, energies."""

from __future__ import annotations

import numpy as np
import pytest

from jointplay.solver.codegen import outputs
from jointplay.solver.mechanism.assemble import assemble
from tests.support.laws_grid import mechanism
from tests.support.linkages import ARRANGEMENTS, own_state
from tests.support.motion import seen
from tests.support.plain import plain

from ..reference.four_bar import ANGLES, LINKS, scattered
from .both import numbers, pair

MODES = ("free", "slip+", "slip-", "stick")
PUSHED = {"O": "crank", "A": "crank", "B": "coupler", "C": "rocker"}  # journal carriers


def evaluated(system, model, y, modes):
    """Every output of the package at a state of the reference."""
    return seen(model, own_state(system, y), modes=modes, numbers=numbers(system, model, y))


def watched(joints, drive, mode, seed=4, **changes):
    """The bodies, their solution in one mode of all joints, the package's outputs, and the state."""
    system, model = pair(joints, drive=drive, **changes)
    y, modes = scattered(system, seed), dict.fromkeys(joints, mode)
    return system, system.at_modes(y, modes), evaluated(system, model, y, list(modes.values())), y


@pytest.mark.nightly
@pytest.mark.parametrize("drive", ["motor", "speed"])
@pytest.mark.parametrize("joints", ARRANGEMENTS)
def test_motion_forces_and_energies(joints, drive):
    for mode in MODES:
        system, solved, found, y = watched(joints, drive, mode)
        turning = solved.acceleration[ANGLES]
        for k, link in enumerate(LINKS):
            assert found[f"angle:{link}"] == pytest.approx(y[k], rel=1e-12)
            assert found[f"angular_velocity:{link}"] == pytest.approx(y[system.half + k], rel=1e-12)
        ours = np.array([found[f"angular_acceleration:{link}"] for link in LINKS])
        assert np.abs(ours - turning).max() < 1e-11 * max(1.0, np.abs(turning).max())
        _check_joints(system, solved, found, mode)
        _check_energy(system, found, y)


def _check_joints(system, solved, found, mode):
    for name, touch, _, _ in solved.touches:
        rho = touch.u + system.clearance[name]
        words = ("journal_x", "journal_y", "eccentricity", "penetration")
        values = [found[f"{word}:{name}"] for word in words]
        assert values == pytest.approx([*(rho * touch.normal), rho, touch.u], rel=1e-9, abs=1e-16)
        assert found[f"eccentricity_ratio:{name}"] == pytest.approx(rho / system.clearance[name])
        assert found[f"contact_angle:{name}"] == pytest.approx(np.arctan2(*touch.normal[::-1]))
        speeds = [found[f"{word}_velocity:{name}"] for word in ("normal", "tangential")]
        assert speeds == pytest.approx([touch.v_n, touch.v_t], rel=1e-10)
        force = 0.0 if mode == "free" else touch.law()
        assert found[f"normal_force:{name}"] == pytest.approx(force, rel=1e-9)
        assert found[f"stored_energy:{name}"] == pytest.approx(system.p.K * touch.u**2 / 2, rel=1e-9)


def _check_energy(system, found, y):
    mechanical = sum(system.energies(0.0, system.full(y)))
    assert found["kinetic_energy"] + found["potential_energy"] == pytest.approx(mechanical, rel=1e-11)


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize(
    ("joints", "drive"),
    [
        ("B", "motor"),
        ("B", "speed"),
        ("C", "speed"),
        ("BC", "speed"),
        ("A", "motor"),
        ("O", "motor"),
        ("AC", "speed"),
    ],
)
def test_reactions_and_torque_are_the_multipliers(joints, drive, mode):
    for seed in range(3):
        system, solved, found, y = watched(joints, drive, mode, seed)
        reactions = {name: solved.reactions[name][:2] for name in "OABC" if name in solved.reactions}
        scale = max(1.0, *(np.abs(force).max() for force in reactions.values()))
        for name, force in reactions.items():
            ours = found[f"reaction_x:{name}"], found[f"reaction_y:{name}"]
            assert ours == pytest.approx(tuple(force), abs=1e-11 * scale)
        law = system.p.a - system.p.b * y[system.half]
        expected = law if drive == "motor" else -solved.reactions["drive"][2]
        assert found["drive_torque"] == pytest.approx(expected, abs=1e-11 * scale)


def test_a_pin_reaction_without_gravity():
    _, solved, found, _ = watched("B", "motor", "slip+", gravity=0.0)
    for name, force in solved.reactions.items():
        ours = found[f"reaction_x:{name}"], found[f"reaction_y:{name}"]
        assert ours == pytest.approx(tuple(force[:2]), rel=1e-9)


@pytest.mark.long
@pytest.mark.parametrize(("joints", "drive"), [("B", "motor"), ("BC", "speed"), ("OABC", "motor")])
@pytest.mark.parametrize("mode", MODES)
def test_power_balance(joints, drive, mode):
    """Power of the drive less what the joints take in is the rate of mechanical energy, along the motion."""
    system, model = pair(joints, drive=drive)
    y, modes = scattered(system, 7), [mode] * len(joints)
    rate, energies = system.rate(y, dict(zip(joints, modes, strict=True))), []
    for step in (-2e-7, -1e-7, 1e-7, 2e-7):
        found = evaluated(system, model, y + step * rate, modes)
        energies.append(found["kinetic_energy"] + found["potential_energy"])
    gained = np.dot(energies, [1, -8, 8, -1]) / 12e-7
    found = evaluated(system, model, y, modes)
    drive_power = found["drive_torque"] * found["angular_velocity:crank"]
    taken = [
        found[f"{part}_force:{name}"] * found[f"{part}_velocity:{name}"]
        for name in joints
        for part in ("normal", "tangential")
    ]
    scale = abs(drive_power) + np.abs(taken).sum()
    assert gained == pytest.approx(drive_power - sum(taken), abs=1e-6 * scale)


def test_the_recorded_force_of_johnsons_law_presses_a_journal_in_as_far_as_published():
    """Depth over force, in the units of the publication: force a length."""
    one = mechanism("four_bar", "johnson", "none", False)
    model = assemble(one)
    functions, state = plain(model.structure), np.tile(model.state, (3, 1))
    state[:, 1] += [1.8e-3, 2e-3, 1.9e-3]  # the coupler ahead: the journal is pressed into its bearing
    state[:, 3:6] = 0.0
    given = dict(zip(functions.STATE, [0.0, *state.T], strict=True)) | {
        "touch_B": 1,
        "slip_B": 0,
        "stick_B": 0,
    }
    given |= dict(zip(functions.PARAMETERS, model.numbers, strict=True))
    found = outputs.evaluate(functions, ["penetration:B", "normal_force:B"], given)
    h = 2 * (1 - 0.3**2) / (np.pi * 2.07e11)  # steel on steel
    f = found["normal_force:B"] / one.joint("B").contact.parameters["length"]
    deep = f * h * (np.log(4 * one.joint("B").clearance / (h * f)) - 1)
    assert found["penetration:B"] == pytest.approx(deep, rel=1e-9)
    assert np.all(deep > 1e-6)
