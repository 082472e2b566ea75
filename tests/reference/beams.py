"""A bending link of the reference: particles on an elastic line, by Hermite elements and Gauss points."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.linalg import eigh


@dataclass(frozen=True)
class Beam:
    """How a link bends: number of Hermite elements, damping ratio xi of every mode, round steel bar."""

    elements: int = 2
    xi: float = 0.01
    modulus: float = 2.1e11
    density: float = 7800.0


def hermite(s, h):
    """Cubic Hermite shapes of an element of length h at s in 0..1, and their second derivatives."""
    shape = [1 - 3 * s**2 + 2 * s**3, h * (s - 2 * s**2 + s**3), 3 * s**2 - 2 * s**3, h * (s**3 - s**2)]
    curve = [-6 + 12 * s, h * (6 * s - 4), 6 - 12 * s, h * (6 * s - 2)]
    return np.array(shape), np.array(curve) / h**2


class Line:
    """Particles and stiffness of a beam of the given length and mass, both end deflections zero.

    Attributes
    ----------
    x, weight : ndarray, shape (G,)
        Places (m) and masses (kg) of the particles.
    shape : ndarray, shape (G, 2 n)
        Deflection of every particle for a unit of every coordinate.
    stiffness, damping : ndarray, shape (2 n, 2 n)
    """

    def __init__(self, beam, length, mass):
        self.beam, self.length = beam, length
        area = mass / (beam.density * length)
        self.bending = beam.modulus * area**2 / (4 * math.pi)
        self.h = length / beam.elements
        nodes, weights = np.polynomial.legendre.leggauss(4)  # exact to degree 7; two cubics make 6
        s, weights = (nodes + 1) / 2, weights * self.h / 2
        places = [(k + v) * self.h for k in range(beam.elements) for v in s]
        self.x, gauss = np.array(places), np.tile(weights, beam.elements)
        self.weight = mass / length * gauss
        both = [self.at(x) for x in self.x]
        self.shape = np.array([shape for shape, _ in both])
        curve = np.array([curve for _, curve in both])
        self.stiffness = self.bending * curve.T @ (gauss[:, None] * curve)
        self.inertia = self.shape.T @ (self.weight[:, None] * self.shape)
        square, modes = eigh(self.stiffness, self.inertia)
        self.frequency = np.sqrt(square)
        momenta = self.inertia @ modes
        self.damping = momenta @ np.diag(2 * beam.xi * self.frequency) @ momenta.T
        self.size = 2 * beam.elements
        self.slope_start, self.slope_end = np.eye(self.size)[[0, -1]]
        self.middle = self.at(length / 2)[0]

    def at(self, x):
        """Rows (2 n,) giving deflection and curvature at x from the link's origin."""
        element = min(int(x / self.h), self.beam.elements - 1)
        out = np.zeros((2, 2 * self.beam.elements + 2))
        out[:, 2 * element : 2 * element + 4] = hermite(x / self.h - element, self.h)
        return np.delete(out, [0, -2], axis=1)  # the end deflections
