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

from jointplay.solver.codegen import cache, outputs
from jointplay.solver.mechanism.model import Model

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

    def positions(self, states: np.ndarray, crank: complex | np.ndarray = 0.0) -> np.ndarray:
        """Journal centres relative to their bearings, m: (x, y) of each joint in turn.

        Parameters
        ----------
        states : ndarray, shape (rows, states)
            Positions and speeds.
        crank : complex or ndarray
            Angle by which a crank whose motion is prescribed is turned further, rad; of each row, or of all.
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

    def linear(self, states: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Positions, derivatives by the free coordinates, velocities by the crank: of each state (row)."""
        rows, last = len(states), len(self.free)
        turned, steps = np.zeros(last + 1, complex), np.zeros((last + 1, states.shape[1]), complex)
        steps[np.arange(last), self.free] = 1j * STEP
        speed = np.full(rows, self._numbers.get("Omega", 0.0))
        if self.crank is None:
            turned[last] = 1j * STEP
        else:
            steps[last, self.crank], speed = 1j * STEP, states[:, len(self.model.turning) + self.crank]
        stepped = (states[:, None, :] + steps).reshape(-1, states.shape[1])
        values = self.positions(stepped, np.tile(turned, rows)).reshape(rows, last + 1, -1)
        slopes = values.imag.swapaxes(1, 2) / STEP
        return values[:, last].real, slopes[:, :, :last], slopes[:, :, last] * speed[:, None]

    def velocities(self, states: np.ndarray) -> np.ndarray:
        """Velocities of the journal centres relative to their bearings, m/s: (x, y) of each joint in turn."""
        _, A, by_crank = self.linear(states)
        return _times(A, states[:, len(self.model.turning) :][:, self.free]) + by_crank

    @property
    def _numbers(self) -> dict[str, float]:
        return dict(zip(self.module.PARAMETERS, self.model.numbers, strict=True))

    def put(self, states: np.ndarray, positions: np.ndarray, velocities: np.ndarray) -> np.ndarray:
        """Give states with the same crank in which every journal has its position (m) and velocity (m/s).

        All have a row a state; NaN where the links cannot reach.
        """
        result, left = states.copy(), np.arange(len(states))
        speeds = [len(self.model.turning) + i for i in self.free]
        for _ in range(ITERATIONS):
            here, A, by_crank = self.linear(result[left])
            error, inverse = positions[left] - here, np.linalg.pinv(A)
            there = np.abs(error).max(axis=1) <= TOLERANCE * self.clearances.min()
            needed = velocities[left] - by_crank - _times(A, result[left][:, speeds])
            result[np.ix_(left[there], speeds)] += _times(inverse, needed)[there]
            result[np.ix_(left[~there], self.free)] += _times(inverse, error)[~there]
            left = left[~there]
            if not len(left):
                break
        result[left] = np.nan
        return result


def _times(matrices: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    return (matrices @ vectors[:, :, None])[:, :, 0]
