"""Participation of parts in a tangent: shares of the crank, of each joint's play and of bending.

A linkage moves in as many ways as it has coordinates q: the crank turns with every journal held in its
bearing, a journal moves in its bearing, a link bends. These are other coordinates z(q): the crank's angle,
places of journals in their bearings, deflections. A tangent (dq, dq') changes them by

    dz = Z dq,    dz' = Z dq' + Z' dq,    Z = dz/dq,

and each moves the linkage by its columns B of Z^-1. The size of a part's motion is an energy, with the mass
matrix M and the drive's nominal speed W,

    E = (B dz')^T M (B dz') / 2 + W^2 (B dz)^T M (B dz) / 2,

and its share is E over the sum of all parts' E. A motion that the ideal mechanism could make has no share of
play.

What has no such coordinates (a test system, guides with play, more freedom than that) has one part a state:
the square of its change in units of its scale (tangents), over the sum of these.
"""

from __future__ import annotations

import math

import numpy as np

from jointplay.analysis.starts import state_names
from jointplay.analysis.tangents import scales
from jointplay.solver.codegen import cache, outputs
from jointplay.solver.mechanism.model import Model

STEP = 1e-6  # of a turn: to either side, for the rate of Z
COMPLEX = 1e-30  # of an imaginary part, for Z itself: no difference is taken
DEPENDENT = 1e-9  # of its largest singular value, at which Z counts as singular


class Participation:
    """Shares of a model's parts in tangents.

    Parameters
    ----------
    model : Model
        Its state plays no part, but for the choice of the parts.

    Attributes
    ----------
    parts : tuple of str
        ``crank``, ``play NAME`` of each joint, ``bending``; or the names of the states.
    norm : str
        What the shares are shares of, in words.
    """

    def __init__(self, model: Model):
        self.model, self.rows = model, _rows(model)
        self.parts = tuple(self.rows) or state_names(model)
        self.norm = (
            "kinetic energy of the part's motion alone, and of its displacements at the nominal speed"
            if self.rows
            else "square of a state's change in units of its scale"
        )

    def __call__(self, time: float, state: np.ndarray, tangents: np.ndarray) -> np.ndarray:
        """Shares of each part in tangents (columns, in units of the scales), shape (parts, tangents)."""
        if not self.rows:
            return tangents**2 / np.sum(tangents**2, axis=0)
        n, physical = len(self.model.turning), tangents * scales(self.model)[:, None]
        dq, rate = physical[:n], physical[n : 2 * n]
        Z, M = _coordinates(self.model, time, state), _masses(self.model, time, state)
        B, dz, dz_rate = np.linalg.inv(Z), Z @ dq, Z @ rate + _turning(self.model, time, state) @ dq
        W = math.tau / self.model.period
        energies = [
            _energy(M, B[:, rows] @ dz_rate[rows]) + W**2 * _energy(M, B[:, rows] @ dz[rows])
            for rows in self.rows.values()
        ]
        return np.array(energies) / np.sum(energies, axis=0)


def _energy(M: np.ndarray, speeds: np.ndarray) -> np.ndarray:
    return np.einsum("im,ij,jm->m", speeds, M, speeds) / 2


def _rows(model: Model) -> dict[str, list[int]]:
    """Rows of Z by part; none where Z does not determine a motion."""
    if not model.links:
        return {}
    names, count = state_names(model)[: len(model.turning)], 2 * len(model.joints)
    bending = [i for i, name in enumerate(names) if name.startswith("eta_")]
    crank = f"theta_{model.crank}" in names
    if crank + count + len(bending) != len(names):
        return {}
    rows = {"crank": [0]} if crank else {}
    rows |= {f"play {name}": [crank + 2 * j, crank + 2 * j + 1] for j, name in enumerate(model.joints)}
    rows |= {"bending": list(range(crank + count, len(names)))} if bending else {}
    sizes = np.linalg.svd(_coordinates(model, 0.0, model.state), compute_uv=False)
    return rows if sizes[-1] > DEPENDENT * sizes[0] else {}


def _coordinates(model: Model, time: float, state: np.ndarray) -> np.ndarray:
    """Z at a state: rows of the crank's angle, of journals' x and y, of deflections."""
    names = state_names(model)[: len(model.turning)]
    unit = np.eye(len(names))
    crank = [i for i, name in enumerate(names) if name == f"theta_{model.crank}"]
    bending = [i for i, name in enumerate(names) if name.startswith("eta_")]
    keys = [f"journal_{axis}:{name}" for name in model.joints for axis in "xy"]
    steps = np.pad(unit, ((0, 0), (0, len(state) - len(names))))
    play = _evaluated(model, keys, time, state + 1j * COMPLEX * steps).imag / COMPLEX
    return np.concatenate([unit[crank], play.reshape(len(keys), len(names)), unit[bending]])


def _turning(model: Model, time: float, state: np.ndarray) -> np.ndarray:
    """Rate of Z along the motion."""
    n, step = len(model.turning), STEP * model.period
    speeds = np.pad(state[n : 2 * n], (0, len(state) - n))
    ahead, behind = (_coordinates(model, time + dt, state + dt * speeds) for dt in (step, -step))
    return (ahead - behind) / (2 * step)


def _masses(model: Model, time: float, state: np.ndarray) -> np.ndarray:
    """Mass matrix at a state, from the kinetic energy, which is quadratic in the speeds."""
    n = len(model.turning)
    one, none = np.eye(n), np.zeros((1, n))
    rows = np.tile(state, (n * n + n + 1, 1))
    rows[:, n : 2 * n] = np.concatenate([(one[:, None] + one[None, :]).reshape(-1, n), one, none])
    energy = _evaluated(model, ["kinetic_energy"], time, rows)[0]
    both, single, rest = energy[: n * n].reshape(n, n), energy[n * n : -1], energy[-1]
    return both - single[:, None] - single[None, :] + rest


def _evaluated(model: Model, keys: list[str], time: float, states: np.ndarray) -> np.ndarray:
    """Quantities of states at a time, shape (quantities, states)."""
    module = cache.structure_module(model.structure)
    given = dict(zip(module.STATE, [np.full(len(states), time), *states.T], strict=True))
    given |= dict(zip(module.PARAMETERS, model.numbers, strict=True))
    values = outputs.evaluate(module, keys, given)
    return np.array([np.broadcast_to(values[key], len(states)) for key in keys])
