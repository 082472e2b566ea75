"""Floquet multipliers of a periodic orbit: what they say of its stability, and what is 0 where it changes.

A multiplier mu is an eigenvalue of the section map's derivative P at its fixed point; the orbit is stable
where all |mu| < 1, and ln|mu|/T is an exponent of the flow. Test functions, real and regular in a parameter:

fold, branch point   det(P - I)                    one multiplier +1
period doubling      det(P + I)                    one multiplier -1
Neimark-Sacker       prod_{i<j} (mu_i mu_j - 1)    a pair on the unit circle, unless it is real

Reference: Kuznetsov, Elements of Applied Bifurcation Theory (2004), chapters 5 and 10.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np


def multipliers(derivative: np.ndarray) -> np.ndarray:
    """Eigenvalues of a section map's derivative, the largest first; of a pair, the one above first."""
    found = np.linalg.eigvals(derivative).astype(complex)
    order = np.lexsort((-found.imag, -np.round(np.abs(found), 12)))
    return found[order]


def exponents(found: np.ndarray, period: float) -> np.ndarray:
    """Lyapunov exponents ln|mu|/T of an orbit, 1/s; minus infinity where a direction is lost."""
    with np.errstate(divide="ignore"):
        return np.log(np.abs(found)) / period


def stable(found: np.ndarray) -> bool:
    """Whether every multiplier lies within the unit circle."""
    return bool(np.all(np.abs(found) < 1))


def doubling_test(found: np.ndarray) -> float:
    """Zero where a multiplier is -1."""
    return float(np.prod(found + 1).real)


def unit_test(found: np.ndarray) -> float:
    """Zero where a multiplier is +1."""
    return float(np.prod(found - 1).real)


def torus_test(found: np.ndarray) -> float:
    """Zero where the product of two multipliers is 1."""
    return float(np.prod([a * b - 1 for a, b in combinations(found, 2)]).real)


def critical(found: np.ndarray, kind: str) -> complex:
    """The multiplier that makes a bifurcation: nearest to +1, to -1, or to the unit circle off the axis."""
    if kind == "neimark_sacker":
        pairs = found[found.imag > 0]
        return complex(pairs[np.argmin(np.abs(np.abs(pairs) - 1))]) if len(pairs) else complex(np.nan)
    return complex(found[np.argmin(np.abs(found - (-1 if kind == "period_doubling" else 1)))])


def direction(derivative: np.ndarray, value: float) -> np.ndarray:
    """Unit vector that the derivative multiplies by (nearly) a real number."""
    return np.linalg.svd(derivative - value * np.eye(len(derivative)))[2][-1]
