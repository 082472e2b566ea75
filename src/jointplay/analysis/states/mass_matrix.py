"""The mass matrix of a linkage's free speeds, from its kinetic energy, which is quadratic in them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from jointplay.solver.codegen import cache, outputs
from jointplay.solver.mechanism.model import Model


def evaluated(model: Model, states: np.ndarray, keys: Sequence[str]) -> dict[str, np.ndarray]:
    """Quantities of a linkage (codegen.outputs) at some states at time 0, arrays of shape (rows,)."""
    module = cache.structure_module(model.structure)
    given = dict(zip(module.STATE, [np.zeros(len(states)), *np.asarray(states).T], strict=True))
    given |= dict(zip(module.PARAMETERS, model.numbers, strict=True))
    found = outputs.evaluate(module, keys, given)
    return {key: np.broadcast_to(found[key], len(states)) for key in keys}


def at_speeds(model: Model, speeds: np.ndarray) -> np.ndarray:
    """States of a linkage where it stands, with other speeds, shape (rows, states)."""
    n_q = len(model.turning)
    states = np.repeat(model.state[None, :], len(speeds), axis=0)
    states[:, n_q : 2 * n_q] = speeds
    return states


def mass_matrix(model: Model) -> np.ndarray:
    """The mass matrix where a linkage stands, shape (positions, positions)."""
    n_q = len(model.turning)
    pairs = [(i, j) for i in range(n_q) for j in range(i, n_q)]
    tried = np.zeros((1 + n_q + len(pairs), n_q))
    tried[1 : 1 + n_q] = np.eye(n_q)
    for row, (i, j) in enumerate(pairs, start=1 + n_q):
        tried[row, i] += 1.0
        tried[row, j] += 1.0
    energy = evaluated(model, at_speeds(model, tried), ["kinetic_energy"])["kinetic_energy"]
    M = np.zeros((n_q, n_q))
    for row, (i, j) in enumerate(pairs, start=1 + n_q):
        M[i, j] = M[j, i] = energy[row] - energy[1 + i] - energy[1 + j] + energy[0]
    return M
