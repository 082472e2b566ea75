"""Derivatives of recorded quantities at a point of a motion, by the complex step.

A quantity's program (codegen.outputs) is arithmetic: run on x + i eps dx it gives value + i eps derivative,
without a difference's cancellation. Reference: Squire and Trapp, SIAM Review 40 (1998) 110-112.
"""

from __future__ import annotations

import numpy as np

from jointplay.analysis.evaluate import Quantities
from jointplay.solver.codegen import outputs
from jointplay.solver.mechanism.directions import Directions
from jointplay.solver.mechanism.model import Model

STEP = 1e-40


def values(model: Model, rows: np.ndarray, key: str) -> np.ndarray:
    """A quantity at rows (time, positions, speeds, modes)."""
    quantities = Quantities(model, rows, rows[0])
    found = outputs.evaluate(quantities.module, [key], quantities.given(rows))[key]
    return np.broadcast_to(found, len(rows))


def derivatives(
    model: Model, row: np.ndarray, key: str, dx: np.ndarray, dt: np.ndarray, directions: Directions
) -> np.ndarray:
    """Derivatives of a quantity at a row, as the state moves by dx (directions, states) and time by dt."""
    quantities = Quantities(model, row[None, :], row)
    module, given = quantities.module, dict(quantities.given(row[None, :]))
    for name, moves in zip(module.STATE, np.column_stack([dt, dx]).T, strict=True):
        given[name] = given[name] + 1j * STEP * moves
    for j, (names, rates) in enumerate(zip(directions.names, directions.rates_of, strict=True)):
        unit = 1j * STEP * (np.arange(len(dx)) == j)
        given |= {name: given[name] + unit * rate for name, rate in zip(names, rates, strict=True)}
    found = outputs.evaluate(module, [key], given | {"atan2": _atan2, "copysign": _copysign})[key]
    return np.broadcast_to(np.imag(found) / STEP, len(dx))


def _atan2(y: np.ndarray, x: np.ndarray) -> np.ndarray:
    a, b = np.real(x), np.real(y)
    return np.arctan2(b, a) + 1j * (a * np.imag(y) - b * np.imag(x)) / (a * a + b * b)


def _copysign(size: float, of: np.ndarray) -> np.ndarray:
    return np.copysign(size, np.real(of))
