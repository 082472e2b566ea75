"""Floquet multipliers of a periodic orbit, and its stability.

A multiplier mu is an eigenvalue of the section map's derivative P at its fixed point; the orbit is stable
where all |mu| < 1, and ln|mu|/T is an exponent of the flow.
Reference: Kuznetsov, Elements of Applied Bifurcation Theory (2004), chapters 5 and 10.
"""

from __future__ import annotations

import numpy as np


def multipliers(derivative: np.ndarray) -> np.ndarray:
    """Eigenvalues of a section map's derivative, the largest first, of a pair the upper one."""
    values = np.linalg.eigvals(derivative).astype(complex)
    return values[descending(values)]


def descending(values: np.ndarray) -> np.ndarray:
    """Order of multipliers: the largest first, of a pair the upper one."""
    return np.lexsort((-values.imag, -np.round(np.abs(values), 12)))


def exponents(multipliers: np.ndarray, period: float) -> np.ndarray:
    """Lyapunov exponents ln|mu|/T of an orbit, 1/s; minus infinity where a multiplier is 0."""
    with np.errstate(divide="ignore"):
        return np.log(np.abs(multipliers)) / period


def stable(multipliers: np.ndarray) -> bool:
    """Whether every multiplier lies within the unit circle."""
    return bool(np.all(np.abs(multipliers) < 1))


def critical(multipliers: np.ndarray, kind: str) -> complex:
    """The critical multiplier of a bifurcation: nearest to +1, to -1, or to the unit circle off the axis."""
    if kind == "neimark_sacker":
        pairs = multipliers[multipliers.imag > 0]
        return complex(pairs[np.argmin(np.abs(np.abs(pairs) - 1))]) if len(pairs) else complex(np.nan)
    return complex(multipliers[np.argmin(np.abs(multipliers - (-1 if kind == "period_doubling" else 1)))])


def direction(derivative: np.ndarray, value: float) -> np.ndarray:
    """Unit eigenvector of the derivative to a real eigenvalue, given at least roughly."""
    return np.linalg.svd(derivative - value * np.eye(len(derivative)))[2][-1]
