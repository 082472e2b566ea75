"""One mechanism twice: the references' free links, and the package's generated functions."""

from __future__ import annotations

import numpy as np

from jointplay.solver.mechanism.assemble import assemble
from tests.support.linkages import SMALL, SOFT, bending, mechanism, own_state, start
from tests.support.plain import Point, plain

from ..reference.bodies import Bodies, Parameters
from ..reference.flexible_twin import loop
from .lagrange import Lagrange


def pair(joints, drive="motor", **changes):
    """The reference's system and the package's model of the same mechanism."""
    p = Parameters(i=3.0, drive=drive, **{"f": 0.2} | changes)
    clearance = dict.fromkeys(joints, SMALL)
    model = assemble(mechanism(p, clearance), start(p) if drive == "none" else None)
    return Bodies(p, clearance), model


def numbers(system, model, y):
    """The package's numbers; a prescribed crank is at the reference's angle at time 0."""
    found = dict(zip(plain(model.structure).PARAMETERS, model.numbers, strict=True))
    return found | {"theta_0": y[0]} if system.p.drive == "speed" else found


def state(system, y):
    """The package's positions and speeds at the reference's state y."""
    return system.state(y) if isinstance(system, Lagrange) else own_state(system, y)


def point(system, model, y, modes):
    """The package's functions at the reference's state y."""
    values = list(numbers(system, model, y).values())
    return Point(plain(model.structure), values, state(system, y), modes)


def bent_pair(joints, links, drive="motor", order="consistent", smooth=None, **changes):
    """Lagrange's equations and the package's model of a mechanism with soft links, words in `links`.

    `smooth` is the velocity of friction by tanh.
    """
    p = Parameters(i=3.0, drive=drive, **{"f": 0.2, "C_t": 1.5} | changes)
    clearance = dict.fromkeys(joints, SMALL)
    bent = bending(mechanism(p, clearance, smooth), {name: SOFT[name] for name in links.split()}, order)
    return Lagrange(p, clearance, bent, smooth), assemble(bent, start(p) if drive == "none" else None)


def bent_state(system, seed):
    """A state of bent links in motion, joints displaced by more than their clearance; or the loop closed."""
    random = np.random.default_rng(seed)
    size = np.concatenate([np.full(system.rigid, 1e-3), np.full(system.n - system.rigid, 3e-3)])
    y = np.concatenate([size, 2e3 * size]) * random.standard_normal(2 * system.n)
    rigid = np.r_[: system.rigid, system.n : system.n + system.rigid]
    y[rigid] += system.start()
    if system.p.drive == "speed":
        y[system.n] = system.p.w0
    if not system.clearance:
        y[0] = random.uniform(0, 2 * np.pi)
        y[: system.rigid], y[system.n : system.n + system.rigid] = loop(system.p, y[0], y[system.n])
    return y
