"""Covariant Lyapunov vectors from a series of QR factors: plain linear algebra, of flows and of maps.

Forward, a frame Q is carried by the tangent maps M and made orthonormal again: M Q = Q' R, with R upper
triangular. Its first j columns come to span the j directions that grow fastest, whatever units they are
measured in. The vectors that maps take into one another are V = Q C, C upper triangular with unit columns:

    R C = C' D,    D diagonal: M V = V' D.

Solved backward, C = R^-1 C' D, column j forgets where it began as exp(-(lambda_(j-1) - lambda_j) t): what
grows least within the first j directions grows most backward. Reference: F. Ginelli, P. Poggi, A. Turchi, H.
Chate, R. Livi and A. Politi, Physical Review Letters 99 (2007) 130601.

Validity: away from both ends of the series, by the time in which directions settle. Where two exponents are
equal, only the plane of their vectors is determined.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np


def factors(image: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """QR factors of a frame's image, columns in units of the states' scales; R has a positive diagonal."""
    Q, R = np.linalg.qr(image)
    sign = np.where(np.diag(R) < 0, -1.0, 1.0)
    return Q * sign, R * sign[:, None]


def backward(factors: Iterable[np.ndarray], C: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Take the columns of C back through the factors R.

    Parameters
    ----------
    factors : iterable of ndarray, shape (j, j)
        R of each map, the last one first; a later one may have fewer directions, the leading ones.
    C : ndarray, shape (j, j)
        Upper triangular, of unit columns: where the series ends.

    Yields
    ------
    C, growth : ndarray
        Columns where the map begins, and the logarithm by which the map makes each vector grow.
    """
    for R in factors:
        back = np.linalg.solve(R, widened(C, len(R)))  # triangular: no row is exchanged, no zero is filled
        lengths = np.linalg.norm(back, axis=0)
        C = back / lengths
        yield C, -np.log(lengths)


def widened(C: np.ndarray, count: int) -> np.ndarray:
    """C with so many columns, new ones along axes of their own."""
    wide = np.eye(count)
    wide[: len(C), : len(C)] = C
    return wide


def start(count: int, seed: int) -> np.ndarray:
    """Reproducible upper triangular matrix of unit columns, that no direction is left out of."""
    C = np.triu(np.random.default_rng(seed).normal(size=(count, count)))
    return C / np.linalg.norm(C, axis=0)


def angles_between(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Angles between the lines of unit columns, rad; small ones to rounding."""
    along = np.sum(one * other, axis=0)
    return np.arctan2(np.linalg.norm(other - one * along, axis=0), np.abs(along))


def beyond(one: np.ndarray, other: np.ndarray, C: np.ndarray) -> np.ndarray:
    """Angles of the j-th vector with the span of another frame's first j columns, j = 1, 2, …, in rad.

    Parameters
    ----------
    one, other : ndarray, shape (states, columns)
        Orthonormal frames: that of the vectors, and another.
    C : ndarray, shape (columns, vectors)
        The vectors' columns in the first frame.
    """
    V, angles = one[:, : len(C)] @ C, []
    for j in range(min(V.shape[1], other.shape[1])):
        span = other[:, : j + 1]
        inside = span.T @ V[:, j]
        angles.append(np.arctan2(np.linalg.norm(V[:, j] - span @ inside), np.linalg.norm(inside)))
    return np.array(angles)


def splittings(C: np.ndarray) -> np.ndarray:
    """Smallest angle between the span of the first j vectors and that of all others, j = 1, 2, …, in rad.

    The first j columns span the first j axes, so that the sines of the principal angles are the singular
    values of what the others, made orthonormal, have across these.
    """
    return np.array(
        [
            np.arcsin(min(1.0, np.linalg.svd(np.linalg.qr(C[:, j:])[0][j:], compute_uv=False)[-1]))
            for j in range(1, len(C))
        ]
    )
