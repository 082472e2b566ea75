"""Links that bend, with play: motion, contacts, reactions and energies against Lagrange's equations."""

from __future__ import annotations

import numpy as np
import pytest

from ..reference.bodies import LINKS
from .both import bent_pair, bent_state, point
from .test_accelerations import mixed
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


@every_scene
def test_accelerations_and_contacts(model):
    system, ours = bent_pair(*model)
    for seed, modes in enumerate(combinations(model[0])):
        y = bent_state(system, seed)
        named = dict(zip(system.clearance, modes, strict=True))
        here = point(system, ours, y, modes)
        theirs = system.rate(y, named)
        assert np.abs(here.rate() - theirs[:, None]).max() < 1e-11 * np.abs(theirs).max()
        _contacts(system, y, named, here.contacts())


def _contacts(system, y, named, rows):
    a, held, slides = system.forces(y, named)
    z, v = system.spread(y)
    for (name, mode), (u, v_n, v_t, F_n, F_t, creep) in zip(named.items(), rows, strict=True):
        expected = system.touch(name, z, v)
        assert (u, v_n, v_t) == pytest.approx(expected[:3], rel=1e-9, abs=1e-13)
        if mode == "stick":
            assert F_t == pytest.approx(held[name][0], rel=1e-9)
            assert abs(creep) < 1e-11 * np.abs(a).max()
        elif mode != "free":
            assert F_n == pytest.approx(expected[3], rel=1e-9)
            assert F_t == pytest.approx(system.friction(mode, F_n, v_t), rel=1e-9)
            assert creep == pytest.approx(slides[name], rel=1e-8)


@every_scene
def test_outputs(model):
    """Reactions and torque are the multipliers; energies are those that were differentiated."""
    system, ours = bent_pair(*model)
    for mode in MODES:
        y = bent_state(system, 4)
        a, held, _ = system.forces(y, dict.fromkeys(model[0], mode))
        found = evaluated(system, ours, y, [mode] * len(model[0]))
        turning = [a[own.start + 2] for own in system.own]
        assert [found[f"angular_acceleration:{k}"] for k in LINKS] == pytest.approx(turning, rel=1e-9)
        check_reactions(system, y, held, found)
        check_energies(system, y, found)


def check_reactions(system, y, held, found):
    """Forces on the bearings of ideal joints, and the torque."""
    scale = max(np.abs(force).max() for force in held.values())
    for name in system.ideal:
        force = [found[f"reaction_{axis}:{name}"] for axis in "xy"]
        assert force == pytest.approx(held[name], abs=1e-10 * scale)
        assert found[f"reaction:{name}"] == pytest.approx(np.hypot(*held[name]), abs=1e-10 * scale)
    law = system.p.a - system.p.b * y[system.n] if system.p.drive == "motor" else 0.0
    torque = -held["drive"][0] if system.p.drive == "speed" else law
    assert found["drive_torque"] == pytest.approx(torque, abs=1e-10 * scale)


def check_energies(system, y, found):
    """Energies, and the deflections at the gauges."""
    T, V, strain = system.energies(y)
    assert found["kinetic_energy"] == pytest.approx(T, rel=1e-12)
    assert found["potential_energy"] == pytest.approx(V, rel=1e-11)
    assert found["strain_energy"] == pytest.approx(strain, rel=1e-12)
    z, _ = system.spread(y)
    for name, modes, own in zip(LINKS, system.modes, system.own, strict=True) if len(system.bent) else ():
        bent = modes.gauge @ z[own][3:] if modes else 0.0
        assert found[f"deflection:{name}"] == pytest.approx(bent, rel=1e-12)
