"""Radau IIA collocation with seven stages (order 13, L-stable, stiffly accurate): its constants in lanes.

Reference: Hairer and Wanner, Solving Ordinary Differential Equations II, sections IV.5 and IV.8; and J.
Comput. Appl. Math. 111 (1999) 93-111. Stage i is lane i, the base point is lane 7 (node 0). With A^-1 = V
Lambda V^-1 (one real eigenvalue, three complex pairs), the transformed increments W = V^-1 Z lie as

    lane 0: the real one;  lanes 1-3: real parts;  lane 4: empty;  lanes 5-7: imaginary parts.

Everything is computed here, once, in extended precision, from the nodes; rows of a matrix M that maps lanes
to lanes are stored by column (M[8 j + i] takes lane j to lane i).
"""

import numpy as np

STAGES = 7
LANES = 8


def nodes(stages: int) -> np.ndarray:
    """Roots of d^(s-1)/dx^(s-1) (x^(s-1) (x-1)^s), the last one 1, polished in extended precision."""
    p = np.polynomial.Polynomial.fromroots([0.0] * (stages - 1) + [1.0] * stages)
    coefficients = np.round(p.coef).astype(np.longdouble)
    for _ in range(stages - 1):
        coefficients = coefficients[1:] * np.arange(1, len(coefficients))
    slope = coefficients[1:] * np.arange(1, len(coefficients))
    x = np.sort(np.roots(coefficients[::-1].astype(float)).real).astype(np.longdouble)
    for _ in range(4):
        x[:-1] -= np.polyval(coefficients[::-1], x[:-1]) / np.polyval(slope[::-1], x[:-1])
    x[-1] = 1
    return x


def inverse(M: np.ndarray) -> np.ndarray:
    """Inverse in extended precision: double, then Newton-Schulz."""
    wide = np.clongdouble if np.iscomplexobj(M) else np.longdouble
    X = np.linalg.inv(M.astype(complex if np.iscomplexobj(M) else float)).astype(wide)
    eye = np.eye(len(M), dtype=wide)
    for _ in range(4):
        X = X @ (2 * eye - M @ X)
    return X


def collocation(c: np.ndarray) -> np.ndarray:
    """Matrix A of the method with nodes c, which integrates polynomials up to each node."""
    k = np.arange(len(c))
    return (c[:, None] ** (k + 1) / (k + 1)) @ inverse(c[:, None] ** k)


def eigen(M: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Eigenvalues (the real one, then ones with positive imaginary part) and all eigenvectors, polished."""
    values, vectors = np.linalg.eig(M.astype(float))
    order = sorted(range(len(M)), key=lambda i: (abs(values[i].imag), values[i].imag < 0))
    values, vectors = values[order].astype(np.clongdouble), vectors[:, order].astype(np.clongdouble)
    for _ in range(3):
        E = inverse(vectors) @ M @ vectors
        values = np.diag(E).copy()
        gaps = values[None, :] - values[:, None] + np.eye(len(M))
        vectors = vectors @ (np.eye(len(M)) + (E - np.diag(values)) / gaps)
    return values, vectors


def _lanes(columns: dict[int, np.ndarray]) -> np.ndarray:
    """A lane-to-lane matrix from its columns (length 7 or 8), flat."""
    flat = np.zeros((LANES, LANES))
    for j, column in columns.items():
        flat[j, : len(column)] = column.astype(float)
    return flat.ravel()


def _transforms(V: np.ndarray, A: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """W from Z (Z to eigenbasis), Z from W, and A Z from W."""
    U = inverse(V)
    to_eigen, to_stage = np.zeros((LANES, STAGES)), np.zeros((STAGES, LANES))
    for lane, k in enumerate((0, 1, 3, 5)):
        to_eigen[lane], to_eigen[lane + 4] = U[k].real, U[k].imag
        weight = 1 if lane == 0 else 2
        to_stage[:, lane], to_stage[:, lane + 4] = weight * V[:, k].real, -weight * V[:, k].imag
    to_eigen[4], to_stage[:, 4] = 0, 0
    moved = (A @ to_stage.astype(np.longdouble)).astype(float)
    return (
        _lanes(dict(enumerate(to_eigen.T))),
        _lanes(dict(enumerate(to_stage.T))),
        _lanes(dict(enumerate(moved.T))),
    )


def _error_weights(c: np.ndarray, inverse_A: np.ndarray, gamma: float) -> np.ndarray:
    """e of the estimate h f(0)/gamma + sum e_i Z_i: an embedded formula of order 7."""
    k = np.arange(STAGES)
    powers = np.array([c**n for n in k])
    full = inverse(powers) @ (1 / (k + np.longdouble(1)))
    moved = inverse(powers) @ (1 / (k + np.longdouble(1)) - (k == 0) / gamma)
    return inverse_A.T @ (moved - full)


_c = nodes(STAGES)
_A = collocation(_c)
_values, _vectors = eigen(inverse(_A))

NODES = np.append(_c.astype(float), 0.0)
GAMMA = float(_values[0].real)
EIGEN_RE = _values[[0, 1, 3, 5]].real.astype(float)
EIGEN_IM = np.append(0.0, _values[[1, 3, 5]].imag.astype(float))
TO_EIGEN, TO_STAGE, TO_MOVED = _transforms(_vectors, _A)
ERROR = np.append(_error_weights(_c, inverse(_A), _values[0].real).astype(float), 0.0)
COLLOCATION = _lanes(dict(enumerate(_A.T)))
