"""Bodies of `tests.support.multibody` that bend: rows of particles on an elastic line.

A particle at x from the link's origin stands at (x + w) e + y n of the link's frame, y and w being sums of
shapes. Its inertia beyond what the rigid body has of it already is Newton's law of the particle, projected:
with the velocity's rows J in the coordinates (x, y, θ, q) and J_0 those of the particle that stays on its
line,

    M = Σ μ (JᵀJ − J_0ᵀJ_0),    Q = Σ μ (Jᵀ(g − b) − J_0ᵀ(g − b_0)) − K q − C q̇,

b the acceleration that remains where all those of coordinates are 0. None of the integrals of the model's
printed equations is used.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.linalg import block_diag, eigh

from tests.reference import beams

GAUSS = 24  # points of a row of sine shapes: exact to rounding for the lowest five


class Row:
    """Particles of a uniform beam of a length and mass, both ends on its line; across, and along if axial.

    Parameters
    ----------
    length, mass, stiffness, tension : float
        l; of the beam; E I; E A.
    xi : float
        Damping ratio of every mode.
    shapes : "sine" or "hermite"
    number : int
        Of sine shapes, or of elements.
    axial : bool
        Whether it stretches by two quadratics too.
    """

    def __init__(self, length, mass, stiffness, tension, xi, shapes, number, axial=False):
        self.length = length
        if shapes == "hermite":
            x, weight, across, K, start, end, middle = self._hermite(mass, stiffness, number)
        else:
            x, weight, across, K, start, end, middle = self._sines(mass, stiffness, number)
        self.x, self.weight, self.bending = x, weight, across.shape[1]
        along = np.stack([x / length, (x / length) ** 2], axis=1) if axial else np.zeros((len(x), 0))
        self.across = np.hstack([across, np.zeros(along.shape)])
        self.along = np.hstack([np.zeros(across.shape), along])
        stretch = tension / length * np.array([[1.0, 1.0], [1.0, 4 / 3]]) if axial else np.zeros((0, 0))
        parts = [(across, K), (along, stretch)]
        self.stiffness = block_diag(*(K for _, K in parts if len(K)))
        self.damping = block_diag(*(self._damped(shape, K, xi) for shape, K in parts if len(K)))
        self.size = len(self.stiffness)
        zero = np.zeros(along.shape[1])
        self.ends = np.append(start, zero), np.append(end, zero)
        self.middle = np.append(middle, zero)
        self.reach = np.append(np.zeros(self.bending), np.ones(along.shape[1]))

    def _damped(self, shape, K, xi):
        M = shape.T @ (self.weight[:, None] * shape)
        square, modes = eigh(K, M)
        return M @ modes @ np.diag(2 * xi * np.sqrt(square)) @ modes.T @ M

    def _sines(self, mass, stiffness, number):
        l, k = self.length, np.pi * np.arange(1, number + 1) / self.length
        nodes, weights = np.polynomial.legendre.leggauss(GAUSS + 8 * number)
        x, share = l * (nodes + 1) / 2, weights / 2
        ends = k, k * np.cos(k * l)
        return (
            x,
            mass * share,
            np.sin(np.outer(x, k)),
            np.diag(stiffness * k**4 * l / 2),
            *ends,
            np.sin(k * l / 2),
        )

    def _hermite(self, mass, stiffness, number):
        line = beams.Line(beams.Beam(elements=number), self.length, mass)
        K = line.stiffness * (stiffness / line.bending)
        return line.x, line.weight, line.shape, K, line.slope_start, line.slope_end, line.middle

    def slope(self, at: float) -> np.ndarray:
        """The row of the slope at an end."""
        if not (at == 0.0 or math.isclose(at, self.length)):
            raise ValueError("a place between the ends of a bent link is not known here")
        return self.ends[at > 0]

    def far(self, at: float) -> np.ndarray:
        """The row of the way along of an end."""
        self.slope(at)
        return self.reach * (at > 0)

    def deflection(self, q: np.ndarray) -> float:
        """The deflection at mid-length."""
        return float(self.middle @ q)

    def moved(self, centre, q, v, pull) -> tuple[np.ndarray, np.ndarray]:
        """What the particles add to mass matrix and forces of the body's (x, y, θ, q)."""
        (c, s), w = (math.cos(q[2]), math.sin(q[2])), v[2]
        e, n = np.array([c, s]), np.array([-s, c])
        out, up, out_rate, up_rate = (
            self.along @ q[3:],
            self.across @ q[3:],
            self.along @ v[3:],
            self.across @ v[3:],
        )
        M, Q = np.zeros((3 + self.size,) * 2), np.zeros(3 + self.size)
        for moved in (True, False):
            x = self.x - centre + (out if moved else 0.0)
            y = up if moved else np.zeros(len(x))
            J = np.zeros((len(x), 2, 3 + self.size))
            J[:, 0, 0] = J[:, 1, 1] = 1.0
            J[:, :, 2] = np.outer(x, n) - np.outer(y, e)
            b = -w * w * (np.outer(x, e) + np.outer(y, n))
            if moved:
                J[:, :, 3:] = e[None, :, None] * self.along[:, None] + n[None, :, None] * self.across[:, None]
                b += 2 * w * (np.outer(out_rate, n) - np.outer(up_rate, e))
            sign = self.weight * (1 if moved else -1)
            M += np.einsum("p,pai,paj->ij", sign, J, J)
            Q += np.einsum("p,pai,pa->i", sign, J, pull - b)
        Q[3:] -= self.stiffness @ q[3:] + self.damping @ v[3:]
        return M, Q


def row(link) -> Row:
    """The particles of a `Link` that bends."""
    beam = link.beam
    area = beam.area or link.mass / (beam.density * link.length)
    second = beam.second_moment or area**2 / (4 * math.pi if beam.section == "round" else 12.0)
    if beam.shapes == "hermite" and beam.modes not in (None, 2 * beam.elements):
        raise ValueError("fewer modes than elements have are not known here")
    number = beam.elements if beam.shapes == "hermite" else beam.size
    numbers = link.length, beam.density * area * link.length, beam.modulus * second, beam.modulus * area
    return Row(*numbers, beam.damping_ratio, beam.shapes, number, beam.axial)
