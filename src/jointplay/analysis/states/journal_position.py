"""Positions of journals in their bearings, and the angles and speeds of links that give them others.

The vector from bearing to journal is r = const + sum_k D_k e_k (+ bases). With the crank held, other links'
angles that give every journal its position solve r(q) = r* by Newton's method, and their speeds then
A q' = r*' - A_crank q'_crank with A = dr/dq. A is exact without derivatives, by complex steps: r(q + i h) has
the imaginary part h dr/dq, and no difference is taken. Where journals leave more links free than they
determine, the smallest change is taken. Bending moves no journal (beams are pinned at both ends). Units: m,
rad, s.
"""

from __future__ import annotations

import numpy as np

from jointplay.codegen import cache, outputs
from jointplay.mechanism.model import Model

ITERATIONS = 30
STEP = 1e-30  # of the imaginary part, rad or m
TOLERANCE = 1e-10  # of a journal's position, relative to the smallest clearance


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
        angles = [i for i in range(len(model.turning)) if not names[i].startswith("eta_")]
        self.crank = next((i for i in angles if names[i] == f"theta_{model.crank}"), None)
        self.free = [i for i in angles if i != self.crank]

    @property
    def clearances(self) -> np.ndarray:
        """Clearance of each journal's two coordinates, m."""
        return np.repeat(self.model.clearances, 2)

    def positions(self, states: np.ndarray, crank: complex = 0.0) -> np.ndarray:
        """Journal centres relative to their bearings, m: (x, y) of each joint in turn.

        Parameters
        ----------
        states : ndarray, shape (rows, states)
            Positions and speeds.
        crank : float
            Angle by which a crank whose motion is prescribed is turned further, rad.
        """
        given = dict(zip(self.module.STATE, [np.zeros(len(states)), *np.asarray(states).T], strict=True))
        given |= self._numbers
        if "theta_0" in given:
            given["theta_0"] = given["theta_0"] + crank
        keys = [f"journal_{axis}:{name}" for name in self.model.joints for axis in "xy"]
        values = outputs.evaluate(self.module, keys, given)
        return np.stack([np.broadcast_to(values[key], len(states)) for key in keys], -1)

    def eccentricity_ratios(self, states: np.ndarray) -> np.ndarray:
        """Distances of journal and bearing centres over the clearances, shape (rows, joints)."""
        ratios = self.positions(states) / self.clearances
        return np.hypot(ratios[:, ::2], ratios[:, 1::2])

    def derivative(self, state: np.ndarray, columns: list[int]) -> np.ndarray:
        """Derivative of the journals' positions by some coordinates, shape (positions, columns)."""
        steps = np.zeros((len(columns), len(state)))
        steps[np.arange(len(columns)), columns] = STEP
        return self.positions(state + 1j * steps).imag.T / STEP

    def velocities(self, state: np.ndarray) -> np.ndarray:
        """Velocities of the journal centres relative to their bearings, m/s: (x, y) of each joint in turn."""
        n_q = len(self.model.turning)
        free = self.derivative(state, self.free) @ state[n_q:][self.free]
        return free + self._velocities_by_crank(state)

    def _velocities_by_crank(self, state: np.ndarray) -> np.ndarray:
        """The part of the velocities that is due to the crank's speed."""
        if self.crank is not None:
            speed = state[len(self.model.turning) + self.crank]
            return self.derivative(state, [self.crank])[:, 0] * speed
        speed = self._numbers.get("Omega", 0.0)
        return self.positions(state[None, :], 1j * STEP)[0].imag / STEP * speed

    @property
    def _numbers(self) -> dict[str, float]:
        return dict(zip(self.module.PARAMETERS, self.model.numbers, strict=True))

    def put(self, state: np.ndarray, positions: np.ndarray, velocities: np.ndarray) -> np.ndarray | None:
        """Give a state with the same crank in which every journal has its position (m) and velocity (m/s).

        Returns
        -------
        ndarray or None
            None where the links cannot reach.
        """
        result, n_q = state.copy(), len(self.model.turning)
        for _ in range(ITERATIONS):
            error = positions - self.positions(result[None, :])[0]
            A = self.derivative(result, self.free)
            if np.abs(error).max() <= TOLERANCE * self.clearances.min():
                needed = velocities - self._velocities_by_crank(result) - A @ result[n_q:][self.free]
                result[[n_q + i for i in self.free]] += np.linalg.lstsq(A, needed, rcond=None)[0]
                return result
            result[self.free] += np.linalg.lstsq(A, error, rcond=None)[0]
        return None
