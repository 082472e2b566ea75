"""Random linear systems with the buffers of one step: by written-out algebra, and by plan."""

from __future__ import annotations

import numpy as np

from jointplay.solver.codegen import algebra, elimination
from jointplay.solver.method import radau
from jointplay.solver.method.memory import method_rows
from tests.support.plain import run

C, A = radau.NODES[:7], radau.COLLOCATION.reshape(8, 8).T[:7, :7]
EIGENVALUES = radau.EIGEN_RE + 1j * radau.EIGEN_IM


class Linear:
    """One step of z' = f0 + J (x - x0), x the positions and then the speeds, and its functions `f`.

    `values` is the Jacobian as the functions take it, `variant` the variant they are asked for.
    """

    def __init__(self, n_q, n, J, values, source, first, variant=0, h=0.3):
        self.n_q, self.n, self.J, self.values, self.h, self.variant = n_q, n, J, values, h, variant
        random = np.random.default_rng(n_q + 100 * n)
        self.f0, self.z0 = random.normal(size=(2, n))
        self.s = np.concatenate([[0.0], random.normal(size=n_q), self.z0])
        self.f = run(source)
        self.w = np.full(8 * (first + 1 + n_q + 2 * n), np.nan)  # nothing may be read that was not written
        rows = self.w.reshape(-1, 8)[first:]
        self.time, self.q, self.z = rows[0], rows[1 : 1 + n_q], rows[1 + n_q : 1 + n_q + n]
        self.rates = rows[1 + n_q + n :]

    def rate(self):
        """Fill the rates of all lanes from the increments."""
        self.rates[:] = self.f0[:, None] + self.J @ np.concatenate([self.q, self.z])

    def factor(self):
        """Fill and eliminate Newton's matrices."""
        self.f.factor(self.variant, self.w, self.values, self.h)

    def newton(self, weight):
        """One update from where the increments stand; its size."""
        self.f.move(self.w, self.s, self.h)
        self.rate()
        self.factor()
        return self.f.newton(self.variant, self.w, self.s, self.values, weight, self.h)

    def estimate(self, weight, error):
        """Put the error estimate in the place of the rates in `error`; its size."""
        return self.f.estimate(self.variant, self.w, self.values, weight, error, self.h)

    def solution(self):
        """Z = h A F, solved densely, shape (speeds, stages)."""
        n, n_q, h = self.n, self.n_q, self.h
        J_q, J_z = np.zeros((n, n)), self.J[:, n_q:]
        J_q[:, :n_q] = self.J[:, :n_q]
        matrix = np.eye(7 * n) - h * np.kron(A, J_z) - h * h * np.kron(A @ A, J_q)
        start = h * np.kron(C, J_q @ self.z0)  # positions move at the base's speeds
        right = h * np.kron(A, np.eye(n)) @ (np.tile(self.f0, 7) + start)
        return np.linalg.solve(matrix, right).reshape(7, n).T


def scaled(random, n_q, n, shape):
    """Random derivatives, those by positions larger."""
    return random.normal(size=shape) * np.where(np.arange(n_q + n) < n_q, 40.0, 6.0)


def written_out(n_q, n):
    """A system with a full Jacobian."""
    J = scaled(np.random.default_rng(10 * n_q + n), n_q, n, (n, n_q + n))
    return Linear(n_q, n, J, J.ravel(), algebra.text(n_q, n), method_rows(n))


def planned(n_q, n, density=0.3, variant=0):
    """A system M a = B x whose matrices are mostly zero; its plan stands among two others, unlike it."""
    random = np.random.default_rng(10 * n_q + n + variant)
    plans = [sparse_plan(random, n_q, n, density) for _ in range(3)]
    M, B = np.zeros((n, n)), np.zeros((n, n_q + n))
    drawn = random.normal(size=(n, n))
    drawn, derivatives = drawn @ drawn.T / n, n * scaled(random, n_q, n, (n, n_q + n))
    values = np.zeros(len(plans[variant].values))
    for (i, j), at in plans[variant].mass.items():
        values[at] = M[i, j] = drawn[i, j] + (n if i == j else 0.0)
    for part, shift in ((plans[variant].pull, 0), (plans[variant].rate, n_q)):
        for (i, j), at in part.items():
            values[at] = B[i, shift + j] = derivatives[i, shift + j]
    first = max(each.rows for each in plans)
    system = Linear(
        n_q, n, np.linalg.solve(M, B), values, elimination.text(plans, n_q, first), first, variant
    )
    system.M, system.B, system.plan = M, B, plans[variant]
    return system


def sparse_plan(random, n_q, n, density):
    """A plan of random patterns; values are numbered as they come."""
    found = elimination.Plan(n)
    for i, j in zip(
        *np.nonzero(np.tril(random.random((n, n)) < density) | np.eye(n, dtype=bool)), strict=True
    ):
        found.mass[int(i), int(j)] = found.mass[int(j), int(i)] = found._place(0)
    for part, width in ((found.pull, n_q), (found.rate, n)):
        for i, j in zip(*np.nonzero(random.random((n, width)) < density), strict=True):
            part[int(i), int(j)] = found._place(0)
    return found


def newtons_matrix(M, B, h, k):
    """(lambda/h) M - B_z - (h/lambda) B_q of the k-th eigenvalue lambda."""
    n, eigenvalue = len(M), EIGENVALUES[k]
    n_q = B.shape[1] - n
    E = eigenvalue / h * M - B[:, n_q:]
    E[:, :n_q] -= h / eigenvalue * B[:, :n_q]
    return E


def factored(plan, w, k):
    """The product of the k-th lane's factors: unit L, and U with its pivots inverted."""
    rows, both = w.reshape(-1, 8)[3 * plan.n + 2 :], np.zeros((plan.n, plan.n), dtype=complex)
    for row, place in zip(rows, plan.filled(), strict=False):
        both[place] = row[k] + 1j * row[4 + k]
    upper = np.triu(both, 1) + np.diag(1 / np.diag(both))
    return (np.tril(both, -1) + np.eye(plan.n)) @ upper
