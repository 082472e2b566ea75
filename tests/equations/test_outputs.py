"""Recorded quantities against the free bodies: accelerations, forces, reactions, torque, energies."""

from __future__ import annotations

import numpy as np
import pytest

from jointplay.solver.codegen import outputs
from jointplay.solver.mechanism.assemble import assemble
from tests.support.laws_grid import mechanism
from tests.support.linkages import ARRANGEMENTS, scattered
from tests.support.plain import masks, plain

from ..reference.bodies import LINKS, Bodies
from .both import numbers, pair, state

MODES = ("free", "slip+", "slip-", "stick")
PUSHED = {"O": "crank", "A": "crank", "B": "coupler", "C": "rocker"}  # journal carriers


class Watched(Bodies):
    """Free bodies that keep the multipliers of their last solution."""

    def _reactions(self, load, rows, right):
        self.x = super()._reactions(load, rows, right)
        return self.x

    def held(self):
        """Torque of a prescribed speed, and the force on the bearing of each ideal joint."""
        after, torque = 9, None
        if self.p.drive == "speed":
            after, torque = 10, -self.x[9]
        pairs = self.x[after : after + 2 * len(self.ideal)].reshape(-1, 2)
        return torque, dict(zip(self.ideal, pairs, strict=True))


def evaluated(system, model, y, modes):
    """Every output of the package at a state of the reference."""
    functions = plain(model.structure)
    values = np.concatenate([[0.0], state(system, y)])
    given = dict(zip(functions.STATE, values, strict=True)) | numbers(system, model, y)
    words = [f"{word}_{name}" for name in model.joints for word in ("touch", "slip", "stick")]
    given |= dict(zip(words, masks(modes), strict=False))
    return {k: float(v) for k, v in outputs.evaluate(functions, functions.OUTPUTS, given).items()}


def watched(joints, drive, mode, seed=4, **changes):
    """The reference after a solution in one mode of all joints, the package's outputs, and the state."""
    system, model = pair(joints, drive, **changes)
    system = Watched(system.p, system.clearance)
    y, modes = scattered(system, seed), dict.fromkeys(joints, mode)
    system.solve(y, modes)
    return system, evaluated(system, model, y, list(modes.values())), y


@pytest.mark.parametrize("drive", ["motor", "speed"])
@pytest.mark.parametrize("joints", ARRANGEMENTS)
def test_motion_forces_and_energies(joints, drive):
    for mode in MODES:
        system, found, y = watched(joints, drive, mode)
        turning = system.solve(y, dict.fromkeys(joints, mode))[0][2::3]
        for k, link in enumerate(LINKS):
            assert found[f"angle:{link}"] == pytest.approx(y[k], rel=1e-12)
            assert found[f"angular_velocity:{link}"] == pytest.approx(y[system.n + k], rel=1e-12)
        ours = np.array([found[f"angular_acceleration:{link}"] for link in LINKS])
        assert np.abs(ours - turning).max() < 1e-11 * max(1.0, np.abs(turning).max())
        _check_joints(system, found, y, mode)
        _check_energy(system, found, y)


def _check_joints(system, found, y, mode):
    for name in system.clearance:
        c = system.contact(name, y)
        words = ("journal_x", "journal_y", "eccentricity", "penetration")
        values = [found[f"{word}:{name}"] for word in words]
        assert values == pytest.approx([*c.r, c.rho, c.u], rel=1e-9, abs=1e-16)
        assert found[f"eccentricity_ratio:{name}"] == pytest.approx(c.rho / system.clearance[name])
        assert found[f"contact_angle:{name}"] == pytest.approx(np.arctan2(*c.r[::-1]))
        speeds = [found[f"{word}_velocity:{name}"] for word in ("normal", "tangential")]
        assert speeds == pytest.approx([c.v_n, c.v_t], rel=1e-10)
        assert found[f"normal_force:{name}"] == pytest.approx(0.0 if mode == "free" else c.force, rel=1e-9)
        assert found[f"stored_energy:{name}"] == pytest.approx(system.p.K * c.u**2 / 2, rel=1e-9)


def _check_energy(system, found, y):
    stored = sum(system.p.K * max(system.contact(name, y).u, 0.0) ** 2 / 2 for name in system.clearance)
    mechanical = system.energy(y) - stored
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
        system, found, y = watched(joints, drive, mode, seed)
        torque, reactions = system.held()
        scale = max(1.0, *(abs(v) for pair in reactions.values() for v in pair))
        for name, force in reactions.items():
            ours = found[f"reaction_x:{name}"], found[f"reaction_y:{name}"]
            assert ours == pytest.approx(tuple(force), abs=1e-11 * scale)
        law = system.p.a - system.p.b * y[system.n]
        expected = law if torque is None else torque
        assert found["drive_torque"] == pytest.approx(expected, abs=1e-11 * scale)


def test_a_pin_reaction_without_gravity():
    system, found, _ = watched("B", "motor", "slip+", gravity=0.0)
    for name, force in system.held()[1].items():
        assert (found[f"reaction_x:{name}"], found[f"reaction_y:{name}"]) == pytest.approx(
            tuple(force), rel=1e-9
        )


@pytest.mark.parametrize(("joints", "drive"), [("B", "motor"), ("BC", "speed"), ("OABC", "motor")])
@pytest.mark.parametrize("mode", MODES)
def test_power_balance(joints, drive, mode):
    """Power of the drive less what the joints take in is the rate of mechanical energy, along the motion."""
    system, model = pair(joints, drive)
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
