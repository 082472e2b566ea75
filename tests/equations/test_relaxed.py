"""Links whose modes are given from outside: the others' motion under them, and what would excite them."""

from __future__ import annotations

import numpy as np
import pytest

from jointplay.solver.codegen import outputs
from jointplay.solver.mechanism.assemble import assemble
from tests.support.linkages import SMALL, SOFT, bending, mechanism
from tests.support.plain import Point, masks, plain

from ..reference.bodies import Parameters
from .both import bent_state
from .lagrange import Lagrange


class Given(Lagrange):
    """Lagrange's equations in the paper's order, with the modes' accelerations `acc` prescribed."""

    def _ideal(self, z, v):
        rows, right, names, slides = super()._ideal(z, v)
        rows += list(np.eye(self.size)[self.bent])
        return rows, [*right, *self.acc], [*names, *["modes"] * len(self.bent)], slides


def relaxed(joints, links, drive, seed=3):
    """Both sides: the reference with its state, and the package's functions with their numbers there."""
    p = Parameters(i=3.0, drive=drive, f=0.2, C_t=1.5)
    clearance = dict.fromkeys(joints, SMALL)
    bent = bending(mechanism(p, clearance), {name: SOFT[name] for name in links.split()}, "paper")
    system, model = Given(p, clearance, bent), assemble(bent, relaxed=True)
    y, functions = bent_state(system, seed), plain(model.structure)
    system.acc = np.random.default_rng(seed).normal(size=len(system.bent)) * 100.0
    numbers = dict(zip(functions.PARAMETERS, model.numbers, strict=True))
    for word, values in (("rate_", y[system.n + system.rigid :]), ("acc_", system.acc)):
        names = [name for name in numbers if name.startswith(word)]
        numbers |= dict(zip(names, values, strict=True))
    return system, y, functions, numbers | ({"theta_0": y[0]} if drive == "speed" else {})


@pytest.mark.parametrize(
    ("joints", "links", "drive"),
    [("B", "coupler rocker", "motor"), ("", "coupler", "motor"), ("B", "coupler", "speed")],
)
@pytest.mark.parametrize("mode", ["free", "slip+", "stick"])
def test_rigid_motion_and_loads(joints, links, drive, mode):
    """The load on a mode is what holds it to its motion, and what its inertia, damping and bending take."""
    system, y, functions, numbers = relaxed(joints, links, drive)
    modes, count = dict.fromkeys(joints, mode), len(system.bent)
    state = np.concatenate([half[count:] for half in np.split(system.state(y), 2)])
    here = Point(functions, list(numbers.values()), state, list(modes.values()))
    a, held, _ = system.forces(y, modes)
    theirs = system.rate(y, modes)[count:]
    assert np.abs(here.rate() - theirs[:, None]).max() < 1e-11 * np.abs(a).max()
    given = dict(zip(functions.STATE, here.s, strict=False)) | numbers
    words = [f"{word}_{name}" for name in joints for word in ("touch", "slip", "stick")]
    given |= dict(zip(words, masks(list(modes.values())), strict=False))
    loads = [name for name in functions.OUTPUTS if name.startswith("modal_load")]
    found = np.array(list(outputs.evaluate(functions, loads, given).values()))
    expected = held["modes"] + system.acc + bending_and_damping(system, y)
    assert found == pytest.approx(expected, abs=1e-10 * np.abs(expected).max())


def bending_and_damping(system, y):
    """omega^2 eta + 2 xi omega eta' of every mode."""
    pairs = [(link, modes) for link, modes in zip(system.links, system.modes, strict=True) if modes]
    omega = np.concatenate([modes.frequency for _, modes in pairs])
    xi = np.concatenate([np.full(len(modes.frequency), link.beam.damping_ratio) for link, modes in pairs])
    return omega**2 * y[system.rigid : system.n] + 2 * xi * omega * y[system.n + system.rigid :]
