"""Conditions that critical orbits fulfil, besides closing, on curves in two parameters.

fold                g = 0 of [[P - I, b], [c', 0]] (v, g) = (0, 1)      a multiplier +1
period doubling     g = 0 of [[P + I, b], [c', 0]] (v, g) = (0, 1)      a multiplier -1
symmetry breaking   the same, P of the half map (half_map)
Neimark-Sacker      det B - 1, P V = V B on the plane V of a pair of multipliers

b and c are singular vectors of P -+ I at the point before, so that g is regular and of order 1. With (w, g)
from the transposed system, dg = -w' dP v, where dP along a coordinate or parameter k is column k of the
derivative of P, or of the map's derivative in k, along v: second derivatives commute, and one difference of
exact derivatives gives all coordinates and parameters.
References: Govaerts, Numerical Methods for Bifurcations of Dynamical Equilibria (2000), chapters 3 and 4;
Kuznetsov (2004), chapters 9 and 10. Validity: the orbit meets no event at grazing incidence.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.linalg import schur

from jointplay.analysis.orbits.branch_points import doubling, torus, unit
from jointplay.analysis.orbits.family import Family, Point, Trial
from jointplay.analysis.orbits.orbit_events import same_events

NEAR = 3e-3  # of a multiplier from a critical value, where two are so: double ones are uncertain by a root
DIFFERENCES = (3e-6, 1e-7, 1e-8)  # their lengths along a vector, in units of the states' scales
SHARES = {"resonance_1_1": 2.0, "resonance_1_2": -2.0, "resonance_1_3": -1.0, "resonance_1_4": 0.0}
REVERSED = 1e-3  # share of the parameters in a tangent at a cusp
REAL = 1e-6  # imaginary part below which a multiplier counts as real


@dataclass(frozen=True)
class Critical:
    """A multiplier at +1 or -1.

    Parameters
    ----------
    multiplier : float
        Which.
    half : bool
        Whether the map is that of half a turn and a reflection.
    """

    multiplier: float
    half: bool = False
    sided = False

    def value(self, trial: Trial, like: Point) -> float:
        """The bordered determinant."""
        return float(self._bordered(trial.image.derivative, like)[1][-1])

    def gradient(self, family: Family, trial: Trial, like: Point) -> np.ndarray:
        """Its derivatives in the coordinates x/c and the fractions of the ranges."""
        M, right = self._bordered(trial.image.derivative, like)
        left = np.linalg.solve(M.T, np.eye(len(M))[-1])
        return _scaled(-left[:-1] @ along(family, trial, right[:-1]), like)

    def _bordered(self, P: np.ndarray, like: Point) -> tuple[np.ndarray, np.ndarray]:
        """The bordered matrix, and (v, g)."""
        n, identity = len(P), np.eye(len(P))
        U, _, V = np.linalg.svd(like.orbit.image.derivative - self.multiplier * identity)
        M = np.zeros((n + 1, n + 1))
        M[:n, :n], M[:n, n], M[n, :n] = P - self.multiplier * identity, U[:, -1], V[-1]
        return M, np.linalg.solve(M, np.eye(n + 1)[-1])

    def tests(self, one: Point) -> Mapping[str, Callable[[Point], float]]:
        """Zeros at meetings with other curves, by their names."""
        pairs = torus if len(one.tangent) > 3 else lambda point: 1.0
        if self.multiplier < 0:
            other = "fold_symmetry_breaking" if self.half else "fold_doubling"
            return {other: unit, "resonance_1_2": pairs, "doubling_torus": pairs}
        before = one.tangent[-2:]
        return {
            "cusp": lambda point: float(point.tangent[-2:] @ before),
            "fold_doubling": doubling,
            "resonance_1_1": pairs,
            "fold_torus": pairs,
        }

    def genuine(self, kind: str, point: Point) -> bool:
        """Whether the zero of a test is a genuine point of its kind."""
        values = np.asarray(point.multipliers)
        if kind == "cusp":
            return bool(np.linalg.norm(point.tangent[-2:]) < REVERSED)
        if kind.endswith("torus"):
            pairs = values[values.imag > NEAR]
            return bool(np.any(np.abs(np.abs(pairs) - 1) < NEAR))
        if kind.startswith("resonance"):
            return int(np.sum(np.abs(values - self.multiplier) < NEAR)) > 1
        return bool(np.any(np.abs(values + self.multiplier) < NEAR))


@dataclass(frozen=True)
class Torus:
    """A pair of multipliers on the unit circle; beyond a strong resonance, a real pair with the product 1."""

    sided = False

    def value(self, trial: Trial, like: Point) -> float:
        """Its product less 1."""
        return float(np.linalg.det(_plane(trial.image.derivative)[1]) - 1)

    def gradient(self, family: Family, trial: Trial, like: Point) -> np.ndarray:
        """Its derivatives in the coordinates x/c and the fractions of the ranges."""
        P = trial.image.derivative
        V, B = _plane(P)
        W = _plane(P.T)[0]
        dual = np.linalg.solve(W.T @ V, W.T)  # rows
        rows = np.stack(
            [dual @ along(family, trial, v) for v in V.T], 1
        )  # of dB: (row, column of B, unknown)
        adjugate = np.linalg.det(B) * np.linalg.inv(B)
        return _scaled(np.einsum("ij,jik->k", adjugate, rows), like)

    def trace(self, point: Point) -> float:
        """The sum of the pair: twice the cosine of its angle, and beyond that of a real one."""
        return float(np.trace(_plane(point.orbit.image.derivative)[1]))

    def tests(self, one: Point) -> Mapping[str, Callable[[Point], float]]:
        """Zeros at strong resonances and at meetings with other curves, by their names."""

        def share(double: float) -> Callable[[Point], float]:
            return lambda point: self.trace(point) - double

        others = {"fold_torus": unit, "doubling_torus": doubling} if len(one.tangent) > 4 else {}
        return {name: share(double) for name, double in SHARES.items()} | others

    def genuine(self, kind: str, point: Point) -> bool:
        """Whether the zero of a test is a genuine point of its kind."""
        if kind in SHARES:
            return True
        wanted = 1.0 if kind == "fold_torus" else -1.0
        values = np.asarray(point.multipliers)
        return bool(np.any((np.abs(values - wanted) < NEAR) & (np.abs(values.imag) < REAL)))


def _plane(P: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Basis of the plane of that pair of multipliers whose product is nearest to 1, and the map on it."""
    values = np.linalg.eigvals(P).astype(complex)
    pairs = [pair for pair in combinations(values, 2) if abs((pair[0] * pair[1]).imag) < 1e-9]
    chosen = min(pairs, key=lambda pair: abs(pair[0] * pair[1] - 1))
    apart = [abs(value - each) for value in values for each in chosen]
    near = 1e-6 * (1 + max(apart))

    def wanted(real: float, imaginary: float) -> bool:
        return min(abs(complex(real, imaginary) - each) for each in chosen) < near

    T, Z, _ = schur(P, sort=wanted)
    return Z[:, :2], T[:2, :2]


def along(family: Family, trial: Trial, vector: np.ndarray) -> np.ndarray:
    """Derivative of the map's derivatives along a vector of coordinates, in units of their scales.

    A central difference of motions with the same events, smaller where others are near; one-sided where no
    central one is found, NaN where none is. Columns: coordinates, then fractions of the ranges.
    """
    section, own = trial.section, family.slopes(trial.image)
    place, length = section.unknowns(trial.state), float(np.linalg.norm(vector))
    for size in DIFFERENCES:
        found = [(0.0, own)]
        for side in (-size / length, size / length):
            other = section.image(section.state(place + side * vector), directions=trial.directions)
            if not other.status and same_events(other.events, trial.image.events):
                found.append((side, family.slopes(other)))
        if len(found) == 3 or (len(found) == 2 and size == DIFFERENCES[-1]):
            found.sort(key=lambda each: each[0])
            return (found[-1][1] - found[0][1]) / (found[-1][0] - found[0][0])
    return np.full_like(own, np.nan)


def _scaled(row: np.ndarray, like: Point) -> np.ndarray:
    """Derivatives in coordinates and parameters, the first in units of the constant c."""
    row[:-2] *= like.unit
    return row
