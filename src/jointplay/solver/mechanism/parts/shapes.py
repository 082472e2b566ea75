"""Mode shapes of a beam of unit length, mass per length and bending stiffness, pinned at both ends.

Sine shapes are exact: φ_i = √2 sin(iπx) with ω_i = (iπ)². Hermite shapes are the eigenvectors of K_f and M_f
of equal cubic elements whose end deflections are removed, so n elements have 2n modes (Chunmei et al. (2002),
equations (10) to (12), with n = 2).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

Array = np.ndarray


@dataclass(frozen=True)
class Modes:
    """Coefficients of the modes φ_i of a beam in the equations of motion; arrays of shape (n,).

    Parameters
    ----------
    frequency : numpy.ndarray
        ω_i, rad/s, rising.
    force : numpy.ndarray
        S_i = ∫ρA φ_i dx, √kg.
    moment, second : numpy.ndarray
        I_i = ∫ρA x φ_i dx, √kg m; ∫ρA x² φ_i dx, √kg m².
    slope_start, slope_end : numpy.ndarray
        φ_i′ at the link's origin and far end, 1/(√kg m); positive at the origin.
    gauge : numpy.ndarray
        φ_i where the deflection is recorded, 1/√kg.
    """

    frequency: Array
    force: Array
    moment: Array
    second: Array
    slope_start: Array
    slope_end: Array
    gauge: Array


def sines(count: int, gauge: float) -> Modes:
    """Sine modes of the beam of unit length, mass and stiffness."""
    i = np.arange(1, count + 1)
    wave, sign = i * math.pi, (-1.0) ** i
    root = math.sqrt(2)
    return Modes(
        frequency=wave**2,
        force=root * (1 - sign) / wave,
        moment=-root * sign / wave,
        second=root * (2 * (sign - 1) / wave**2 - sign) / wave,
        slope_start=root * wave,
        slope_end=root * wave * sign,
        gauge=root * np.sin(wave * gauge),
    )


def hermites(elements: int, count: int, gauge: float) -> Modes:
    """Modes of cubic elements of the beam of unit length, mass and stiffness."""
    squares, shapes, *moments = _solved(elements)
    e = min(int(gauge * elements), elements - 1)
    deflection = _cubics(gauge * elements - e, 1 / elements) @ shapes[2 * e : 2 * e + 4]
    modes = (np.sqrt(squares), *moments, shapes[1], shapes[-1], deflection)
    return Modes(*(values[:count] for values in modes))


@lru_cache(maxsize=32)
def _solved(elements: int) -> tuple[Array, ...]:
    """Solve K_f v = ω² M_f v: squares of the frequencies, coordinates of all modes as columns, moments."""
    from scipy.linalg import eigh  # takes long to import, and rigid mechanisms go without

    mass, bending, *moments = _assembled(elements)
    inner = np.delete(np.arange(2 * elements + 2), [0, 2 * elements])
    squares, vectors = eigh(bending[np.ix_(inner, inner)], mass[np.ix_(inner, inner)])
    shapes = np.zeros((2 * elements + 2, 2 * elements))
    shapes[inner] = vectors * np.sign(vectors[0])
    return squares, shapes, *(moment @ shapes for moment in moments)


def _cubics(s: float, h: float) -> Array:
    """Give the four Hermite cubics of an element of length h at the fraction s of it.

    Their coordinates are deflection and slope at its start, then at its end.
    """
    return np.array(
        [1 - 3 * s**2 + 2 * s**3, h * (s - 2 * s**2 + s**3), 3 * s**2 - 2 * s**3, h * (s**3 - s**2)]
    )


def _assembled(elements: int) -> tuple[Array, ...]:
    """Assemble M_f, K_f, ∫N dx, ∫x N dx and ∫x² N dx of equal elements, both end deflections kept.

    Coordinates are deflection and slope at each node in turn: shapes (2n + 2, 2n + 2) and (2n + 2,).
    """
    h, size = 1 / elements, 2 * elements + 2
    unit = np.array([1, h, 1, h])
    scale = np.outer(unit, unit)
    even = np.array([1 / 2, 1 / 12, 1 / 2, -1 / 12]) * unit * h
    rising = np.array([3 / 20, 1 / 30, 7 / 20, -1 / 20]) * unit * h * h
    squared = np.array([1 / 15, 1 / 60, 4 / 15, -1 / 30]) * unit * h**3
    mass, bending = np.zeros((size, size)), np.zeros((size, size))
    force, moment, second = np.zeros(size), np.zeros(size), np.zeros(size)
    for e in range(elements):
        at = slice(2 * e, 2 * e + 4)
        mass[at, at] += _MASS * scale * h
        bending[at, at] += _BENDING * scale / h**3
        force[at] += even
        moment[at] += e * h * even + rising
        second[at] += (e * h) ** 2 * even + 2 * e * h * rising + squared
    return mass, bending, force, moment, second


_MASS = np.array([[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]]) / 420
_BENDING = np.array([[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]], dtype=float)
