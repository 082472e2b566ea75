"""Knocks: sudden changes of a motion's state, of a size and in a direction.

- ``impulse:LINK``, an impulsive moment on a link, N m s: with the mass matrix M of the free speeds q', and
  the link's angular velocity w = b q', the speeds change by M^-1 b^T J. Both are exact from values: the
  kinetic energy is quadratic in the speeds, and w is linear. A crank whose speed is prescribed keeps it.
- ``shift:JOINT``, a displacement of the journal in its bearing, m; crank and other journals stay, and so do
  the speeds of journals in their bearings. It ends where the journal would leave the clearance.
- ``state:NAME``, of a test system: a change of one state, in its own units.

Sizes have a unit: what changes the link's speed by the nominal one; what gives the point the nominal speed
times the mechanism's reach; the clearance; 1. Validity: the knock is
over before anything moves, and contacts that are closed take no part of it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from jointplay.analysis.coexisting.point_impulses import Blow, Impulse
from jointplay.analysis.starts import free_states, state_names
from jointplay.analysis.states.journal_position import Journals
from jointplay.analysis.states.mass_matrix import at_speeds, evaluated, mass_matrix
from jointplay.analysis.states.start_plane import INSIDE, beyond_a_wall
from jointplay.solver.mechanism.model import Model
from jointplay.solver.mechanism.records import Mechanism, TestSystem

UNITS = {"impulse": "N m s", "blow": "N s", "shift": "m", "state": "1"}


@dataclass(frozen=True)
class Knock:
    """A kind of knock by its name, with the size that counts as one, in its units."""

    name: str
    unit: float
    blow: Blow | None = None

    @property
    def kind(self) -> str:
        """Kind of the knock: the first part of its name."""
        return self.name.partition(":")[0]

    @property
    def plane(self) -> bool:
        """Whether it has directions in a plane; else one and its opposite."""
        return self.kind == "shift" or (self.blow is not None and self.blow.impulse.direction is None)

    def applied(self, model: Model, direction: float, size: float) -> Model | None:
        """The model after a knock of a size, in units, in a direction, rad; None where it cannot be."""
        of, amount = self.name.partition(":")[2], size * self.unit
        if self.kind in ("impulse", "blow"):
            n_q, state = len(model.turning), model.state.copy()
            if self.blow is None:
                change = math.cos(direction) * speeds_by_moment(model, of)
            else:
                push = self.blow.slopes(model).T @ self.blow.aim(model, direction)
                change = np.linalg.solve(mass_matrix(model), push)
            state[n_q : 2 * n_q] += amount * change
            return replace(model, state=state)
        if self.kind == "state":
            state = model.state.copy()
            state[state_names(model).index(of)] += math.cos(direction) * amount
            moved = replace(model, state=state)
            return None if beyond_a_wall(moved) else moved
        return _shifted(model, of, amount * np.array([math.cos(direction), math.sin(direction)]))


def _shifted(model: Model, joint: str, way: np.ndarray) -> Model | None:
    journals, at = Journals(model), 2 * model.joints.index(joint)
    states, before = model.state[None, :], journals.eccentricity_ratios(model.state[None, :])
    positions = journals.positions(states).copy()
    positions[:, at : at + 2] += way
    put = journals.put(states, positions, journals.velocities(states))
    inside = journals.eccentricity_ratios(put) <= np.maximum(before, 1.0) * INSIDE
    return replace(model, state=put[0]) if inside.all() else None


def speeds_by_moment(model: Model, link: str) -> np.ndarray:
    """Change of the free speeds by a unit of an impulsive moment on a link, shape (coordinates,)."""
    n_q = len(model.turning)
    return np.linalg.solve(mass_matrix(model), np.diff(_link_speeds(model, link, np.eye(n_q)), axis=0)[0])


def _link_speeds(model: Model, link: str, changes: np.ndarray) -> np.ndarray:
    """Angular velocity of a link without free speeds, and with these, shape (2, changes)."""
    states, key = (
        at_speeds(model, np.vstack([np.zeros(changes.shape[1]), changes])),
        f"angular_velocity:{link}",
    )
    speeds = evaluated(model, states, [key])[key]
    return np.stack([np.repeat(speeds[0], len(changes)), speeds[1:]])


def knocks(model: Model, mechanism: Mechanism | TestSystem, impulses: Sequence[Impulse] = ()) -> list[Knock]:
    """Kinds of knock that a model can have: all of each kind, and the given impulses on points."""
    if not model.links:
        return [Knock(f"state:{name}", 1.0) for name in free_states(model)]
    nominal, found = math.tau / model.period, []
    for link in model.links:
        change = speeds_by_moment(model, link)
        moved = float(np.diff(_link_speeds(model, link, change[None]), axis=0)[0, 0])
        if moved > 0:
            found.append(Knock(f"impulse:{link}", nominal / moved))
    for blow in (Blow(mechanism, each) for each in impulses):
        moved = blow.mobility(model, mass_matrix(model))
        if moved > 0:
            found.append(Knock(f"blow:{blow.impulse.name}", nominal * model.reach / moved, blow))
    bearings = [joint.name for joint in model.structure.joints if not joint.corner]
    return found + [Knock(f"shift:{name}", model.clearances[model.joints.index(name)]) for name in bearings]
