"""Links whose modes are given from outside: the others' motion under them, and what would excite them."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import block_diag

from jointplay.solver.codegen import outputs
from jointplay.solver.mechanism.assemble import assemble
from tests.support.linkages import SMALL, SOFT, bending, mechanism, own_state
from tests.support.multibody_beams import row
from tests.support.plain import Point, masks, plain

from ..reference.four_bar import FourBar, Parameters, scattered
from .both import accelerations


class Given:
    """Prescribed accelerations `acc` of a system's modes, as of a drive; its forces are their loads."""

    name, play = "modes", None

    def __init__(self, system, acc):
        self.rows_of, self.acc, self.many = np.linalg.inv(system.modes), acc, len(acc)

    def rows(self, now):
        """g, G, g_t and bias."""
        none = np.zeros(self.many)
        return none, np.hstack([np.zeros((self.many, 9)), self.rows_of]), none, -self.acc

    def on_bearing(self, now, multipliers):
        """The loads."""
        return multipliers


def relaxed(joints, links, drive, seed=3):
    """Both sides: the bodies with their state, and the package's functions with their numbers there."""
    p = Parameters(i=3.0, drive=drive, f=0.2, C_t=1.5)
    clearance = dict.fromkeys(joints, SMALL)
    bent = bending(mechanism(p, clearance), {name: SOFT[name] for name in links.split()}, "paper")
    system = FourBar(p, clearance, {link.name: row(link, "paper") for link in bent.links if link.elastic})
    model = assemble(bent, relaxed=True)
    y, functions = scattered(system, seed), plain(model.structure)
    acc = np.random.default_rng(seed).normal(size=len(system.modes)) * 100.0
    system.ideal.append(Given(system, acc))
    numbers = dict(zip(functions.PARAMETERS, model.numbers, strict=True))
    for word, values in (("rate_", y[system.half + system.rigid :]), ("acc_", acc)):
        names = [name for name in numbers if name.startswith(word)]
        numbers |= dict(zip(names, values, strict=True))
    return system, y, acc, functions, numbers | ({"theta_0": y[0]} if drive == "speed" else {})


@pytest.mark.parametrize(
    ("joints", "links", "drive"),
    [("B", "coupler rocker", "motor"), ("", "coupler", "motor"), ("B", "coupler", "speed")],
)
@pytest.mark.parametrize("mode", ["free", "slip+", "stick"])
def test_rigid_motion_and_loads(joints, links, drive, mode):
    """The load on a mode is what holds it to its motion, and what its inertia, damping and bending take."""
    system, y, acc, functions, numbers = relaxed(joints, links, drive)
    modes, count = dict.fromkeys(joints, mode), len(acc)
    state = np.concatenate([half[count:] for half in np.split(own_state(system, y), 2)])
    here = Point(functions, list(numbers.values()), state, list(modes.values()))
    solved, theirs = system.at_modes(y, modes), accelerations(system, y, modes)[count:]
    assert np.abs(here.rate() - theirs[:, None]).max() < 1e-11 * np.abs(solved.acceleration).max()
    given = dict(zip(functions.STATE, here.s, strict=False)) | numbers
    words = [f"{word}_{name}" for name in joints for word in ("touch", "slip", "stick")]
    given |= dict(zip(words, masks(list(modes.values())), strict=False))
    loads = [name for name in functions.OUTPUTS if name.startswith("modal_load")]
    found = np.array(list(outputs.evaluate(functions, loads, given).values()))
    expected = solved.reactions["modes"] + acc + bending_and_damping(system, y)
    assert found == pytest.approx(expected, abs=1e-10 * np.abs(expected).max())


def bending_and_damping(system, y):
    """omega^2 eta + 2 xi omega eta' of every mode."""
    halves = [half[system.rigid :] for half in np.split(y, 2)]
    rows = [row for row, _ in system.beams.values()]
    parts = [[row.stiffness for row in rows], [row.damping for row in rows]]
    return sum(
        system.modes.T @ block_diag(*part) @ system.modes @ half
        for part, half in zip(parts, halves, strict=True)
    )
