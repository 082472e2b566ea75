"""Knocks: sudden changes of a motion's state, of a size and in a direction.

- ``impulse:LINK``, an impulsive moment on a link, N m s: with the mass matrix M of the free speeds q', and
  the link's angular velocity w = b q', the speeds change by M^-1 b^T J. Both are exact from values: the
  kinetic energy is quadratic in the speeds, and w is linear. A crank whose speed is prescribed keeps it.
- ``shift:JOINT``, a displacement of the journal in its bearing, m; crank and other journals stay, and so do
  the speeds of journals in their bearings. It ends where the journal would leave the clearance.
- ``state:NAME``, of a test system: a change of one state, in its own units.

Sizes have a unit: what changes the link's speed by the nominal one; the clearance; 1. Validity: the knock is
over before anything moves, and contacts that are closed take no part of it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from jointplay.analysis.starts import state_names
from jointplay.analysis.states.journal_position import Journals
from jointplay.analysis.states.start_plane import INSIDE, beyond_a_wall
from jointplay.codegen import cache, outputs
from jointplay.mechanism.model import Model

UNITS = {"impulse": "N m s", "shift": "m", "state": "1"}


@dataclass(frozen=True)
class Knock:
    """A kind of knock by its name, with the size that counts as one, in its units."""

    name: str
    unit: float

    @property
    def kind(self) -> str:
        return self.name.partition(":")[0]

    @property
    def plane(self) -> bool:
        """Whether it has directions in a plane; else one and its opposite."""
        return self.kind == "shift"

    def applied(self, model: Model, direction: float, size: float) -> Model | None:
        """The model after a knock of a size, in units, in a direction, rad; None where it cannot be."""
        of, amount = self.name.partition(":")[2], size * self.unit
        if self.kind == "impulse":
            n_q, state = len(model.turning), model.state.copy()
            state[n_q : 2 * n_q] += math.cos(direction) * amount * speeds_by_moment(model, of)
            return replace(model, state=state)
        if self.kind == "state":
            state = model.state.copy()
            state[state_names(model).index(of)] += math.cos(direction) * amount
            moved = replace(model, state=state)
            return None if beyond_a_wall(moved) else moved
        return _shifted(model, of, amount * np.array([math.cos(direction), math.sin(direction)]))


def _shifted(model: Model, joint: str, way: np.ndarray) -> Model | None:
    journals, at = Journals(model), 2 * model.joints.index(joint)
    positions = journals.positions(model.state[None, :])[0]
    before = journals.eccentricity_ratios(model.state[None, :])[0]
    positions[at : at + 2] += way
    state = journals.put(model.state, positions, journals.velocities(model.state))
    if state is None:
        return None
    after = journals.eccentricity_ratios(state[None, :])[0]
    return None if np.any(after > np.maximum(before, 1.0) * INSIDE) else replace(model, state=state)


def speeds_by_moment(model: Model, link: str) -> np.ndarray:
    """Change of the free speeds by a unit of an impulsive moment on a link, shape (coordinates,)."""
    n_q, module = len(model.turning), cache.structure_module(model.structure)
    pairs = [(i, j) for i in range(n_q) for j in range(i, n_q)]
    tried = np.zeros((1 + n_q + len(pairs), n_q))
    tried[1 : 1 + n_q] = np.eye(n_q)
    for row, (i, j) in enumerate(pairs, start=1 + n_q):
        tried[row, i] += 1.0
        tried[row, j] += 1.0
    states = np.repeat(model.state[None, :], len(tried), axis=0)
    states[:, n_q : 2 * n_q] = tried
    given = dict(zip(module.STATE, [np.zeros(len(states)), *states.T], strict=True))
    given |= dict(zip(module.PARAMETERS, model.numbers, strict=True))
    keys = ("kinetic_energy", f"angular_velocity:{link}")
    energy, speed = (
        np.broadcast_to(outputs.evaluate(module, [key], given)[key], len(states)) for key in keys
    )
    M = np.zeros((n_q, n_q))
    for row, (i, j) in enumerate(pairs, start=1 + n_q):
        M[i, j] = M[j, i] = energy[row] - energy[1 + i] - energy[1 + j] + energy[0]
    return np.linalg.solve(M, speed[1 : 1 + n_q] - speed[0])


def knocks(model: Model) -> list[Knock]:
    """Kinds of knock that a model can have."""
    if not model.links:
        return [Knock(f"state:{name}", 1.0) for name in state_names(model)]
    nominal, found = math.tau / model.period, []
    for link in model.links:
        change = speeds_by_moment(model, link)
        moved = _link_speed(model, link, change)
        if moved > 0:
            found.append(Knock(f"impulse:{link}", nominal / moved))
    bearings = [joint.name for joint in model.structure.joints if not joint.corner]
    return found + [Knock(f"shift:{name}", model.clearances[model.joints.index(name)]) for name in bearings]


def _link_speed(model: Model, link: str, change: np.ndarray) -> float:
    """Change of a link's angular velocity by one of the free speeds."""
    n_q, module = len(model.turning), cache.structure_module(model.structure)
    states = np.repeat(model.state[None, :], 2, axis=0)
    states[:, n_q : 2 * n_q] = [np.zeros(n_q), change]
    given = dict(zip(module.STATE, [np.zeros(2), *states.T], strict=True))
    given |= dict(zip(module.PARAMETERS, model.numbers, strict=True))
    key = f"angular_velocity:{link}"
    return float(np.ptp(np.broadcast_to(outputs.evaluate(module, [key], given)[key], 2)))
