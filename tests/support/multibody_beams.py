"""Bodies of `tests.support.multibody` that bend: rows of particles on an elastic line.

A particle at x from the link's origin stands at (x + w) e + y n of the link's frame, y and w being sums of
shapes. Its inertia beyond what the rigid body has of it already is Newton's law of the particle, projected:
with the velocity's rows J in the coordinates (x, y, θ, q) and J_0 those of the particle that stays on its
line,

    M = Σ μ (JᵀJ − J_0ᵀJ_0),    Q = Σ μ (Jᵀ(g − b) − J_0ᵀ(g − b_0)) − K q − C q̇,

b the acceleration that remains where all those of coordinates are 0. None of the integrals of the model's
printed equations is used. In the paper's order a particle's velocity and acceleration have nothing of its
deflection but the deflection's own rate across the link.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.linalg import block_diag, eigh

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
    order : "consistent" or "paper"
    """

    def __init__(self, length, mass, stiffness, tension, xi, shapes, number, axial=False, order="consistent"):
        self.length, self.paper = length, order == "paper"
        made = {"hermite": self._hermites, "sine": self._sines}[shapes]
        x, weight, across, K, start, end, middle = made(mass, stiffness, number)
        self.x, self.weight, self.bending = x, weight, across.shape[1]
        along = np.stack([x / length, (x / length) ** 2], axis=1) if axial else np.zeros((len(x), 0))
        self.across = np.hstack([across, np.zeros(along.shape)])
        self.along = np.hstack([np.zeros(across.shape), along])
        stretch = tension / length * np.array([[1.0, 1.0], [1.0, 4 / 3]])
        parts = [(across, K), (along, stretch)][: 1 + axial]
        masses = [shape.T @ (weight[:, None] * shape) for shape, _ in parts]
        solved = [eigh(K, M) for (_, K), M in zip(parts, masses, strict=True)]
        self.stiffness, self.inertia = block_diag(*(K for _, K in parts)), block_diag(*masses)
        self.frequency = np.sqrt(np.concatenate([square for square, _ in solved]))
        self.modes = block_diag(*(modes for _, modes in solved))  # of unit mass
        momenta = self.inertia @ self.modes
        self.damping = momenta @ np.diag(2 * xi * self.frequency) @ momenta.T
        self.size = len(self.stiffness)
        zero = np.zeros(along.shape[1])
        self.ends = np.append(start, zero), np.append(end, zero)
        self.middle = np.append(middle, zero)
        self.reach = np.append(np.zeros(self.bending), np.ones(along.shape[1]))

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

    def _hermites(self, mass, stiffness, number):
        nodes, weights = np.polynomial.legendre.leggauss(4)  # exact to degree 7; two cubics make 6
        x = np.array([(k + (v + 1) / 2) * self.length / number for k in range(number) for v in nodes])
        share = np.tile(weights / 2 / number, number)
        across, bent = np.moveaxis([self._cubics(at, number) for at in x], 1, 0)
        K = stiffness * self.length * bent.T @ (share[:, None] * bent)
        start, end = np.eye(2 * number)[[0, -1]]
        return x, mass * share, across, K, start, end, self._cubics(self.length / 2, number)[0]

    def _cubics(self, x, number):
        """Rows of deflection and curvature at x: of slopes at the ends, of both between elements."""
        h = self.length / number
        element = min(int(x / h), number - 1)
        s, out = x / h - element, np.zeros((2, 2 * number + 2))
        out[:, 2 * element : 2 * element + 4] = (
            [1 - 3 * s**2 + 2 * s**3, h * (s - 2 * s**2 + s**3), 3 * s**2 - 2 * s**3, h * (s**3 - s**2)],
            np.array([12 * s - 6, h * (6 * s - 4), 6 - 12 * s, h * (6 * s - 2)]) / h**2,
        )
        return np.delete(out, [0, -2], axis=1)

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

    def raised(self, angle: float, q: np.ndarray) -> np.ndarray:
        """Mass times the way x, y by which deflections and stretches move it."""
        e, n = np.array([math.cos(angle), math.sin(angle)]), np.array([-math.sin(angle), math.cos(angle)])
        return self.weight @ self.along @ q * e + self.weight @ self.across @ q * n

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
            far = moved and not self.paper
            x = self.x - centre + (out if far else 0.0)
            y = up if far else np.zeros(len(x))
            J = np.zeros((len(x), 2, 3 + self.size))
            J[:, 0, 0] = J[:, 1, 1] = 1.0
            J[:, :, 2] = np.outer(x, n) - np.outer(y, e)
            b = -w * w * (np.outer(x, e) + np.outer(y, n))
            if moved:
                J[:, :, 3:] = e[None, :, None] * self.along[:, None] + n[None, :, None] * self.across[:, None]
                b += far * 2 * w * (np.outer(out_rate, n) - np.outer(up_rate, e))
            sign = self.weight * (1 if moved else -1)
            M += np.einsum("p,pai,paj->ij", sign, J, J)
            Q += np.einsum("p,pai,pa->i", sign, J, pull - b)
        Q[3:] -= self.stiffness @ q[3:] + self.damping @ v[3:]
        return M, Q


def row(link, order: str = "consistent") -> Row:
    """The particles of a `Link` that bends."""
    beam = link.beam
    area = beam.area or link.mass / (beam.density * link.length)
    second = beam.second_moment or area**2 / (4 * math.pi if beam.section == "round" else 12.0)
    if beam.shapes == "hermite" and beam.modes not in (None, 2 * beam.elements):
        raise ValueError("fewer modes than elements have are not known here")
    number = beam.elements if beam.shapes == "hermite" else beam.size
    numbers = link.length, beam.density * area * link.length, beam.modulus * second, beam.modulus * area
    return Row(*numbers, beam.damping_ratio, beam.shapes, number, beam.axial, order)
