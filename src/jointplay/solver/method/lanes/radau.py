"""Radau IIA collocation with five stages (order 9, L-stable, stiffly accurate): constants for an ensemble.

Reference: Hairer and Wanner, Solving Ordinary Differential Equations II, sections IV.5 and IV.8. A constant
stands in the code's text, since each lane is a trajectory and stages are rows. The eigenbasis of A^-1: row 0
is that of the real eigenvalue, the others are real and imaginary parts of the complex pairs'.
"""

import numpy as np

from ..polynomial import to_bernstein
from ..radau import LANES, collocation, eigen, inverse, nodes
from ..radau import STAGES as SEVEN

STAGES = 5
LATE = 3  # stage whose Jacobian serves the iteration
NEWTON, STALE = 0.2, 0.3  # of the tolerated error: what an iteration leaves, and its last update
MAX_TURN = 0.25  # of an angle in a step


def _parts(rows: np.ndarray, real: int, imaginary: int) -> np.ndarray:
    """The real row, then real and imaginary parts of the pairs' rows, weighted."""
    found = [rows[0].real]
    for k in (1, 3):
        found += [real * rows[k].real, imaginary * rows[k].imag]
    return np.array(found).astype(float)


def _at_nodes() -> tuple[np.ndarray, np.ndarray]:
    """Tables (see radau) from values at the base and at the stages to those at a trajectory's own nodes.

    And, from the speed at the base and speeds' increments at the stages, to a position's increments there.
    """
    own, power = np.append(nodes(SEVEN), np.longdouble(0)), np.arange(STAGES + 1)
    basis = inverse(np.append(np.longdouble(0), _c)[:, None] ** power)
    values, moved = np.zeros((LANES, LANES)), np.zeros((LANES, LANES))
    values[: STAGES + 1] = (own[:, None] ** power @ basis).astype(float).T
    values[:, SEVEN - 1], values[:, SEVEN] = np.eye(LANES)[STAGES], np.eye(LANES)[0]
    moved[: STAGES + 1] = (own[:, None] ** (power + 1) / (power + 1) @ basis).astype(float).T
    moved[0] = own.astype(float)
    return values.ravel(), moved.ravel()


_c = nodes(STAGES)
_A = collocation(_c)
_inverse = inverse(_A)
_values, _V = eigen(_inverse)
_V = _V * np.where(np.arange(STAGES) == 0, np.conj(_V[-1]) / abs(_V[-1]), 1)
_gamma = _values[0].real
_moved = np.where(np.arange(STAGES) == 0, -1 / _gamma, 0)
_error = _gamma * _inverse.T @ inverse(_c[:, None] ** np.arange(STAGES)).T @ _moved

NODES, A, A_INVERSE = _c.astype(float), _A.astype(float), _inverse.astype(float)
EIGEN = [(float(_values[k].real), float(_values[k].imag)) for k in (0, 1, 3)]
GAMMA = EIGEN[0][0]
TO_EIGEN, TO_STAGE = _parts(inverse(_V), 1, 1), _parts(_V.T, 2, -2).T.copy()
ERROR = _error.astype(float)  # of the estimate h f(0) + sum e_i Z_i, times (I - h J / gamma)^-1
ERROR_A, ERROR_C = (_error @ _A).astype(float), float(_error @ _c)
MONOMIAL = inverse(_c[:, None] ** np.arange(1, STAGES + 1)).astype(float)  # of t Z(t) from Z
TO_BERNSTEIN = to_bernstein(np.append(np.longdouble(0), _c))
AT_NODES, MOVED_AT_NODES = _at_nodes()
