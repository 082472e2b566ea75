"""The longest step that follows what grows, against LAPACK's eigenvalues and the stability function."""

import numpy as np
import pytest

from jointplay.numerics import excited as EXCITED
from jointplay.numerics import radau


def taken(z: complex) -> float:
    """|R(z)| of the method over |e^z|."""
    A, one = radau.COLLOCATION.reshape(8, 8).T[:7, :7], np.eye(7)
    above = one - z * A + z * np.outer(np.ones(7), A[-1])
    return abs(np.linalg.det(above) / np.linalg.det(one - z * A) / np.exp(z))


def longest(stiffness, damping, rate=1e-3, h=np.inf, weight=None):
    """The kernel's answer for q'' = stiffness q + damping q'."""
    n = len(stiffness)
    weight = np.ones(n) if weight is None else weight
    J = np.hstack([stiffness, damping]).ravel()
    room = np.zeros((2 * n + 2, 2 * n), dtype=complex)
    return min(h, EXCITED.longest(J, np.concatenate([weight, weight]), room, n, n, rate))


@pytest.mark.parametrize("n", [2, 3, 5, 12])
def test_eigenvalues(n):
    random = np.random.default_rng(n)
    for _ in range(10):
        A = random.standard_normal((n, n)) * 10 ** random.uniform(-3, 3, (n, n))
        room = np.zeros((n + 2, n), dtype=complex)
        room[:n] = A
        EXCITED._reduce(room, n)
        EXCITED._iterate(room, n)
        found, wanted = np.diag(room[:n]), np.linalg.eigvals(A)
        apart = np.abs(found[:, None] - wanted)
        assert max(apart.min(0).max(), apart.min(1).max()) < 1e-9 * np.abs(wanted).max()


@pytest.mark.parametrize("share", [1e-4, 1e-3, 1e-2, 1.0])
def test_a_step_takes_less_than_half_of_what_a_vibration_gains(share):
    omega = 3e4
    h = longest(np.array([[-(omega**2)]]), np.array([[2 * share * omega]]))
    value = max(np.roots([1.0, -2 * share * omega, omega**2]), key=lambda z: abs(z.imag))
    assert taken(h * value) > np.exp(-0.5 * h * value.real)
    assert h * omega > 4.0


def test_only_what_grows_shortens_a_step():
    """Of two vibrations in other units the slower one grows; the faster one would ask for shorter steps."""
    turn = np.array([[1.0, 3e-4], [2e3, 1.0]])
    back = np.linalg.inv(turn)
    stiff, damp = (turn @ np.diag(each) @ back for each in ([-1e10, -1e6], [-10.0, 2.0]))
    weight = np.array([1.0, 3e-4])
    assert 5.0 <= longest(stiff, damp, weight=weight) * 1e3 <= 7.0
    assert longest(stiff, -np.abs(damp[0, 0]) * np.eye(2), h=1.0, weight=weight) == 1.0
    assert longest(stiff, damp, rate=2.0, h=1.0, weight=weight) == 1.0
    assert longest(stiff, damp, h=1e-5, weight=weight) == 1e-5
