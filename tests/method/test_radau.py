"""Constants of the method: order conditions, the eigenbasis, error weights."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import eigvals
from scipy.special import roots_jacobi

from jointplay.solver.method import radau
from jointplay.solver.method.polynomial import BARYCENTRIC, TO_BERNSTEIN, TO_BERNSTEIN_6

STAGES = 7
C = radau.NODES[:STAGES]
REAL = (0, 1, 2, 3, 5, 6, 7)


def lanes(flat):
    """A flat lane-to-lane matrix as rows of results."""
    return flat.reshape(8, 8).T


A = lanes(radau.COLLOCATION)[:STAGES, :STAGES]


def test_nodes_are_those_of_radau():
    inner = np.sort((roots_jacobi(STAGES - 1, 1.0, 0.0)[0] + 1) / 2)
    assert inner == pytest.approx(C[:-1], abs=1e-15)
    assert C[-1] == 1.0
    assert radau.NODES[STAGES] == 0.0


@pytest.mark.parametrize("k", range(1, 14))
def test_quadrature_of_order_thirteen(k):
    assert A[-1] @ C ** (k - 1) == pytest.approx(1 / k, abs=2e-16 * STAGES)


def test_quadrature_of_no_higher_order():
    assert abs(A[-1] @ C**13 - 1 / 14) > 1e-9


@pytest.mark.parametrize("k", range(1, STAGES + 1))
def test_stage_order_seven(k):
    assert A @ C ** (k - 1) == pytest.approx(C**k / k, abs=2e-15)


@pytest.mark.parametrize("k", range(1, STAGES))
def test_adjoint_condition_of_order_six(k):
    """D(6); with B(13) and C(7) it makes the method's order 13 (Butcher)."""
    b = A[-1]
    assert (b * C ** (k - 1)) @ A == pytest.approx(b * (1 - C**k) / k, abs=1e-15)


def test_stiffly_accurate_and_l_stable():
    """1 + z b (I - z A)^-1 1 vanishes at infinity and stays below 1 on the imaginary axis."""

    def growth(z):
        return 1 + z * A[-1] @ np.linalg.solve(np.eye(STAGES) - z * A, np.ones(STAGES))

    assert abs(growth(-1e9)) < 1e-6
    assert all(abs(growth(1j * y)) <= 1 + 1e-13 for y in np.geomspace(1e-3, 1e6, 200))
    assert growth(-1.7) == pytest.approx(np.exp(-1.7), rel=1e-10)


def test_eigenvalues_are_those_of_the_inverse():
    ours = np.concatenate([radau.EIGEN_RE + 1j * radau.EIGEN_IM, (radau.EIGEN_RE - 1j * radau.EIGEN_IM)[1:]])
    theirs = eigvals(np.linalg.inv(A))
    assert radau.EIGEN_IM[0] == 0.0
    for value in theirs:
        assert np.abs(ours - value).min() < 1e-10 * abs(value)
    assert pytest.approx(radau.EIGEN_RE[0]) == radau.GAMMA


def test_transforms_are_inverse_and_diagonalise():
    to, back = lanes(radau.TO_EIGEN), lanes(radau.TO_STAGE)
    assert back[:STAGES, REAL] @ to[REAL, :STAGES] == pytest.approx(np.eye(STAGES), abs=1e-13)
    moved = lanes(radau.TO_MOVED)[:STAGES, REAL]
    assert moved == pytest.approx(A @ back[:STAGES, REAL], abs=1e-15)
    Z = np.random.default_rng(1).normal(size=STAGES)
    W, scaled = to[:, :STAGES] @ Z, to[:, :STAGES] @ np.linalg.solve(A, Z)
    complex_W, complex_scaled = W[:4] + 1j * W[4:], scaled[:4] + 1j * scaled[4:]
    assert complex_scaled == pytest.approx((radau.EIGEN_RE + 1j * radau.EIGEN_IM) * complex_W, rel=1e-11)


def test_error_weights_make_an_embedded_formula_of_order_seven():
    """Of y' = t^k from 0 with h = 1, h f(0)/gamma + sum e_i Z_i vanishes up to k = 6, and not for k = 7."""
    for k in range(8):
        value = (k == 0) / radau.GAMMA + radau.ERROR[:STAGES] @ (C ** (k + 1) / (k + 1))
        assert (abs(value) < 1e-13) == (k < STAGES)


def test_constants_of_polynomials():
    nodes = radau.NODES
    for matrix, x in ((TO_BERNSTEIN, nodes), (TO_BERNSTEIN_6, nodes[:STAGES])):
        n = len(x) - 1
        square = matrix.reshape(n + 1, n + 1).T
        assert square @ np.ones(n + 1) == pytest.approx(np.ones(n + 1), abs=1e-12)
        assert square @ x == pytest.approx(np.arange(n + 1) / n, abs=1e-12)
    for j, weight in enumerate(BARYCENTRIC):
        assert 1 / weight == pytest.approx(np.prod(np.delete(nodes[j] - nodes, j)), rel=1e-13)
