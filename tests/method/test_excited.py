"""The longest step that follows what grows, against LAPACK's eigenvalues and the stability function."""

from types import SimpleNamespace

import numpy as np
import pytest

from jointplay.solver.method import excited as EXCITED
from jointplay.solver.method import radau
from jointplay.solver.method.memory import GROWTH, H_EXCITED, NUMBERS, H
from jointplay.solver.method.walls import wall_flow
from jointplay.solver.method.walls.walls import SEEK_GROWTH


def taken(z: complex) -> float:
    """|R(z)| of the method over |e^z|."""
    A, one = radau.COLLOCATION.reshape(8, 8).T[:7, :7], np.eye(7)
    above = one - z * A + z * np.outer(np.ones(7), A[-1])
    return abs(np.linalg.det(above) / np.linalg.det(one - z * A) / np.exp(z))


def longest(stiffness, damping, rate=1e-3, h=np.inf, weight=None):
    """The kernel's answer for q'' = stiffness q + damping q'."""
    n = len(stiffness)
    weight = np.ones(n) if weight is None else weight
    room = np.full(6 * n * n, np.nan)  # J, then scratch
    room[: 2 * n * n] = np.hstack([stiffness, damping]).ravel()
    return min(h, EXCITED.longest(room, weight, n, n, rate))


CYCLE = np.roll(np.eye(6), 1, 0)  # without shifts beside its eigenvalues, the iteration stands still


@pytest.mark.parametrize("n", [1, 2, 3, 5, 12])
def test_eigenvalues(n, monkeypatch):
    """Real part and size of each, a pair of complex ones once."""
    random = np.random.default_rng(n)
    drawn = [random.standard_normal((n, n)) * 10 ** random.uniform(-3, 3, (n, n)) for _ in range(10)]
    for A in [*drawn, np.zeros((n, n)), *([CYCLE] if n == 5 else [])]:
        found, at, size = [], 3, len(A)
        monkeypatch.setattr(
            EXCITED, "_fit", lambda gain, size, _, found=found: found.append((gain, size)) or np.inf
        )
        room = np.concatenate([np.full(at, np.nan), A.ravel(), [np.nan]])
        assert EXCITED._longest(room, at, size, 0.0) == np.inf
        values = np.linalg.eigvals(A)
        wanted = np.column_stack([values.real, np.abs(values)])
        apart = np.linalg.norm(np.array(found)[:, None] - wanted, axis=2)
        assert max(apart.min(0).max(), apart.min(1).max()) <= 1e-9 * np.abs(values).max()


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


@pytest.mark.parametrize("unit", [EXCITED, wall_flow], ids=["soft joints", "rigid walls too"])
def test_a_flow_is_told(unit):
    """Of what grows about an attempt; a step that is short for all there is needs no eigenvalues."""
    J = np.array([-1e6, 2.0])
    work = SimpleNamespace(J=J, eigen=np.zeros(6), weight=np.ones(2))
    motion = SimpleNamespace(real=np.zeros(NUMBERS), modes=np.array([2]))
    options = SimpleNamespace(n_q=1, n=1)
    functions = SimpleNamespace(linearised=lambda variant, J, out: np.copyto(out[:2], J))
    for h, expected in ((1.0, longest(J[:1, None], J[1:, None])), (1e-4, np.inf)):
        motion.real[H], motion.real[GROWTH] = h, 0.1
        unit.at_wall(functions, SEEK_GROWTH, SEEK_GROWTH, work, motion, options)
        assert motion.real[H_EXCITED] == expected
