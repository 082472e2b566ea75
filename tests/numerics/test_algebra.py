"""The written-out algebra against dense solves: of a linear system one Newton update is the solution."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from numpy.polynomial import Polynomial

from jointplay.codegen import algebra
from jointplay.numerics import radau
from jointplay.numerics.memory import method_rows

from ..plain import PRETENCE

SIZES = [(0, 3), (1, 1), (2, 3), (3, 3), (5, 5)]
C, A = radau.NODES[:7], radau.COLLOCATION.reshape(8, 8).T[:7, :7]


class Linear:
    """One step of a random linear system z' = f0 + J_q (q - q0) + J_z (z - z0), with its buffers."""

    def __init__(self, n_q, n, h=0.3):
        random = np.random.default_rng(10 * n_q + n)
        self.n_q, self.n, self.h = n_q, n, h
        self.J = random.normal(size=(n, n_q + n)) * np.where(np.arange(n_q + n) < n_q, 40.0, 6.0)
        self.f0, self.z0 = random.normal(size=(2, n))
        self.s = np.concatenate([[0.0], random.normal(size=n_q), self.z0])
        source = algebra.text(n_q, n).replace("import SIGNATURES, entry", "import SIGNATURES")
        scope = {k: v for k, v in PRETENCE.items() if k != "SIGNATURES"}
        exec(source, scope)
        self.f = SimpleNamespace(**scope)
        first = method_rows(n)
        self.w = np.zeros(8 * (first + 1 + n_q + 2 * n))
        rows = self.w.reshape(-1, 8)[first:]
        self.time, self.q, self.z = rows[0], rows[1 : 1 + n_q], rows[1 + n_q : 1 + n_q + n]
        self.rates = rows[1 + n_q + n :]

    def rate(self):
        """Fill the rates of all lanes from the increments."""
        self.rates[:] = self.f0[:, None] + self.J @ np.concatenate([self.q, self.z])

    def newton(self, weight):
        """One update from where the increments stand."""
        self.f.move(self.w, self.s, self.h)
        self.rate()
        self.f.factor(self.w, self.J.ravel(), self.h)
        return self.f.newton(self.w, self.s, weight, self.h)

    def solution(self):
        """Z = h A F, solved densely, shape (speeds, stages)."""
        n, n_q, h = self.n, self.n_q, self.h
        J_q, J_z = np.zeros((n, n)), self.J[:, n_q:]
        J_q[:, :n_q] = self.J[:, :n_q]
        matrix = np.eye(7 * n) - h * np.kron(A, J_z) - h * h * np.kron(A @ A, J_q)
        start = h * np.kron(C, J_q @ self.z0)  # positions move at the base's speeds
        right = h * np.kron(A, np.eye(n)) @ (np.tile(self.f0, 7) + start)
        return np.linalg.solve(matrix, right).reshape(7, n).T


@pytest.mark.parametrize(("n_q", "n"), SIZES)
def test_one_update_solves_a_linear_step(n_q, n):
    system, weight = Linear(n_q, n), np.ones(n_q + n)
    system.f.rest(system.w)
    size = system.newton(weight)
    Z = system.solution()
    assert system.z[:, :7] == pytest.approx(Z, rel=1e-10, abs=1e-12 * np.abs(Z).max())
    assert system.q[:, :7] == pytest.approx(
        system.h * (np.outer(system.z0, C) + Z @ A.T)[:n_q], abs=1e-12 * np.abs(Z).max()
    )
    assert size == pytest.approx(np.sqrt(np.mean(Z**2)), rel=1e-9)
    assert system.newton(weight) < 1e-12 * size


@pytest.mark.parametrize(("n_q", "n"), SIZES)
def test_an_update_is_weighed(n_q, n):
    system, weight = Linear(n_q, n), np.random.default_rng(3).uniform(1, 9, n_q + n)
    system.f.rest(system.w)
    size = system.newton(weight)
    assert size == pytest.approx(np.sqrt(np.mean((system.solution() * weight[n_q:, None]) ** 2)), rel=1e-9)


@pytest.mark.parametrize(("n_q", "n"), SIZES)
def test_prediction_is_the_polynomial_of_the_last_step(n_q, n):
    """Beyond its end, or within it from its start; both in stages and in the eigenbasis."""
    system, random = Linear(n_q, n), np.random.default_rng(4)
    curves = [Polynomial([0.0, *random.normal(size=7)]) for _ in range(n_q + n)]
    source = np.array([[curve(x) for x in radau.NODES] for curve in curves]).ravel()
    for start, ratio in ((1.0, 0.7), (0.0, 0.4)):
        system.f.extrapolate(system.w, source, start, ratio)
        expected = [[p(start + ratio * x) - p(start) for x in C] for p in curves[n_q:]]
        assert system.z[:, :7] == pytest.approx(np.array(expected), rel=1e-9, abs=1e-10)
        to = radau.TO_EIGEN.reshape(8, 8).T[:, :7]
        assert system.w.reshape(-1, 8)[:n] == pytest.approx(np.array(expected) @ to.T, abs=1e-9)


@pytest.mark.parametrize(("n_q", "n"), SIZES)
def test_error_estimate(n_q, n):
    """(I - h J / gamma)^-1 (h f(0) / gamma + sum e_i Z_i) over positions and speeds, in the weighed norm."""
    system, random = Linear(n_q, n), np.random.default_rng(6)
    weight = random.uniform(1, 5, n_q + n)
    system.f.rest(system.w)
    system.newton(weight)
    span = system.h / radau.GAMMA
    J = np.zeros((n_q + n, n_q + n))
    J[np.arange(n_q), n_q + np.arange(n_q)] = 1.0
    J[n_q:] = system.J
    f = np.concatenate([system.z0[:n_q], system.f0])
    Z = np.concatenate([system.q, system.z])[:, :7]
    expected = np.linalg.solve(np.eye(n_q + n) - span * J, span * f + Z @ radau.ERROR[:7])
    error = f.copy()
    size = system.f.estimate(system.w, system.J.ravel(), weight, error, system.h)
    scale = np.abs(expected).max() + 1e-12 * np.abs(span * f).max()
    assert error == pytest.approx(expected, abs=1e-8 * scale)
    assert size == pytest.approx(np.sqrt(np.mean((expected * weight) ** 2)), rel=1e-7)
