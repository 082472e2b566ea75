"""The method's algebra, written out and by plan, against dense solves.

Of a linear system one Newton update is the solution.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.polynomial import Polynomial

from jointplay.solver.method import radau

from .linear import A, C, factored, newtons_matrix, planned, written_out

WRITTEN_OUT = [(0, 3), (1, 1), (2, 3), (3, 3), (5, 5)]
PLANNED = [(0, 6), (4, 7), (6, 6), (13, 13)]
SYSTEMS = [
    *(pytest.param(written_out, sizes, id="written_out_{}_{}".format(*sizes)) for sizes in WRITTEN_OUT),
    *(pytest.param(planned, sizes, id="planned_{}_{}".format(*sizes)) for sizes in PLANNED),
    *(pytest.param(planned, (7, 7, 0.2, v), id=f"planned_variant_{v}") for v in range(3)),
    pytest.param(planned, (6, 6, 1.0), id="planned_full"),
]
every_system = pytest.mark.parametrize(("form", "sizes"), SYSTEMS)


@every_system
def test_one_update_solves_a_linear_step(form, sizes):
    system = form(*sizes)
    weight = np.ones(system.n_q + system.n)
    system.f.rest(system.w)
    size = system.newton(weight)
    Z = system.solution()
    assert system.z[:, :7] == pytest.approx(Z, rel=1e-10, abs=1e-12 * np.abs(Z).max())
    assert system.q[:, :7] == pytest.approx(
        system.h * (np.outer(system.z0, C) + Z @ A.T)[: system.n_q], abs=1e-12 * np.abs(Z).max()
    )
    assert system.time == pytest.approx(system.h * radau.NODES, abs=0.0)
    assert size == pytest.approx(np.sqrt(np.mean(Z**2)), rel=1e-9)
    assert system.newton(weight) < 1e-12 * size


@every_system
def test_an_update_is_weighed(form, sizes):
    system = form(*sizes)
    weight = np.random.default_rng(3).uniform(1, 9, system.n_q + system.n)
    system.f.rest(system.w)
    size = system.newton(weight)
    expected = np.sqrt(np.mean((system.solution() * weight[system.n_q :, None]) ** 2))
    assert size == pytest.approx(expected, rel=1e-9)


@every_system
def test_prediction_is_the_polynomial_of_the_last_step(form, sizes):
    """Beyond its end, or within it from its start; both in stages and in the eigenbasis."""
    system, random = form(*sizes), np.random.default_rng(4)
    curves = [Polynomial([0.0, *random.normal(size=7)]) for _ in range(system.n_q + system.n)]
    source = np.array([[curve(x) for x in radau.NODES] for curve in curves]).ravel()
    for start, ratio in ((1.0, 0.7), (0.0, 0.4)):
        system.f.extrapolate(system.w, source, start, ratio)
        expected = [[p(start + ratio * x) - p(start) for x in C] for p in curves[system.n_q :]]
        assert system.z[:, :7] == pytest.approx(np.array(expected), rel=1e-9, abs=1e-10)
        to = radau.TO_EIGEN.reshape(8, 8).T[:, :7]
        assert system.w.reshape(-1, 8)[: system.n] == pytest.approx(np.array(expected) @ to.T, abs=1e-9)


@every_system
def test_the_equations_about_a_state(form, sizes):
    """The Jacobian itself, which a plan has as that of a residual."""
    system = form(*sizes)
    out = np.full((system.n + system.n_q + system.n) * (system.n_q + system.n), np.nan)
    system.f.linearised(system.variant, system.values, out)
    J = system.J
    assert out[: J.size].reshape(J.shape) == pytest.approx(J, rel=1e-12, abs=1e-13 * np.abs(J).max())


@every_system
def test_error_estimate(form, sizes):
    """(I - h J / gamma)^-1 (h f(0) / gamma + sum e_i Z_i) over positions and speeds, in the weighed norm."""
    system, random = form(*sizes), np.random.default_rng(6)
    n_q, n = system.n_q, system.n
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
    size = system.estimate(weight, error)
    tolerance = 1e-8 * np.abs(expected).max() + 1e-15 * np.abs(span * f).max()
    assert error == pytest.approx(expected, abs=tolerance)
    assert size == pytest.approx(np.sqrt(np.mean((expected * weight) ** 2)), rel=1e-7)


@pytest.mark.parametrize("sizes", PLANNED)
def test_factors_make_newtons_matrix(sizes):
    """L U of every eigenvalue is (lambda/h) M - B_z - (h/lambda) B_q: entries and fill have places."""
    system = planned(*sizes)
    system.factor()
    for k in range(4):
        E = newtons_matrix(system.M, system.B, system.h, k)
        assert factored(system.plan, system.w, k) == pytest.approx(E, abs=1e-11 * np.abs(E).max())
