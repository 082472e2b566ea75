"""Journals in their bearings: where a state has them, and which angles and speeds of links put them elsewhere.

The vector from bearing to journal is r = const + sum_k D_k e_k (+ bases). With the crank held, other links'
angles that give every journal its place solve r(q) = r* by Newton's method, and their speeds then
A q' = r*' - A_crank q'_crank with A = dr/dq. A is exact without derivatives: e_k(a + pi/2) - e_k(a - pi/2)
is twice de_k/da, and bases enter linearly. Where joints leave more links free than they place, the smallest
change is taken. Bending moves no journal (beams are pinned at both ends). Units: m, rad, s.
"""

from __future__ import annotations

import math

import numpy as np

from jointplay.analysis.starts import crank_place
from jointplay.codegen import cache, outputs
from jointplay.mechanism.model import Model

ITERATIONS = 30
PLACED = 1e-10  # of the smallest clearance: how closely a journal is put where it is asked to be


class Journals:
    """The journals of a linkage's joints with clearance.

    Parameters
    ----------
    model : Model
        The linkage; its state plays no part.
    """

    def __init__(self, model: Model):
        self.model, self.module = model, cache.structure_module(model.structure)
        names = self.module.STATE[1:]
        self.crank = crank_place(model)
        moves = [i for i in range(len(model.turning)) if not names[i].startswith("eta_")]
        self.free = [i for i in moves if i != self.crank]

    @property
    def clearances(self) -> np.ndarray:
        """Clearance of each journal's two coordinates, m."""
        return np.repeat(self.model.clearances, 2)

    def places(self, states: np.ndarray, crank: float = 0.0) -> np.ndarray:
        """Journal centres relative to their bearings, m: (x, y) of each joint in turn.

        Parameters
        ----------
        states : ndarray, shape (rows, states)
            Positions and speeds.
        crank : float
            How far a crank whose motion is prescribed is turned on, rad.
        """
        given = dict(zip(self.module.STATE, [np.zeros(len(states)), *np.asarray(states).T], strict=True))
        given |= dict(zip(self.module.PARAMETERS, self.model.numbers, strict=True))
        if "theta_0" in given:
            given["theta_0"] = given["theta_0"] + crank
        keys = [f"journal_{axis}:{name}" for name in self.model.joints for axis in "xy"]
        found = outputs.evaluate(self.module, keys, given)
        return np.stack([np.broadcast_to(found[key], len(states)) for key in keys], -1)

    def eccentricity_ratios(self, states: np.ndarray) -> np.ndarray:
        """Distances of journal and bearing centres over the clearances, shape (rows, joints)."""
        over = self.places(states) / self.clearances
        return np.hypot(over[:, ::2], over[:, 1::2])

    def derivative(self, state: np.ndarray, columns: list[int]) -> np.ndarray:
        """Derivative of the journals' places by some positions, shape (places, columns)."""
        steps = np.zeros((len(columns), len(state)))
        steps[np.arange(len(columns)), columns] = [
            math.pi / 2 if self.model.turning[i] else 1.0 for i in columns
        ]
        both = self.places(np.concatenate([state + steps, state - steps]))
        return (both[: len(columns)] - both[len(columns) :]).T / 2

    def velocities(self, state: np.ndarray) -> np.ndarray:
        """Velocities of the journal centres relative to their bearings, m/s: (x, y) of each joint in turn."""
        n_q = len(self.model.turning)
        free = self.derivative(state, self.free) @ state[n_q:][self.free]
        return free + self._of_crank(state)

    def _of_crank(self, state: np.ndarray) -> np.ndarray:
        """The part of the velocities that the crank's speed makes."""
        if self.crank is not None:
            speed = state[len(self.model.turning) + self.crank]
            return self.derivative(state, [self.crank])[:, 0] * speed
        row = state[None, :]
        return (self.places(row, math.pi / 2) - self.places(row, -math.pi / 2))[0] / 2 * self._prescribed

    @property
    def _prescribed(self) -> float:
        return dict(zip(self.module.PARAMETERS, self.model.numbers, strict=True)).get("Omega", 0.0)

    def put(self, state: np.ndarray, places: np.ndarray, velocities: np.ndarray) -> np.ndarray | None:
        """Give a state with the same crank in which every journal has its place (m) and velocity (m/s).

        Returns
        -------
        ndarray or None
            None where the links cannot reach.
        """
        found, n_q = state.copy(), len(self.model.turning)
        for _ in range(ITERATIONS):
            off = places - self.places(found[None, :])[0]
            if np.abs(off).max() <= PLACED * self.clearances.min():
                A = self.derivative(found, self.free)
                wanted = velocities - self._of_crank(found)
                now = A @ found[n_q:][self.free]
                found[[n_q + i for i in self.free]] += np.linalg.lstsq(A, wanted - now, rcond=None)[0]
                return found
            found[self.free] += np.linalg.lstsq(self.derivative(found, self.free), off, rcond=None)[0]
        return None
