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


def longest(stiffness, damping, rate=1e-3, h=np.inf):
    """The kernel's answer for q'' = stiffness q + damping q'."""
    n = len(stiffness)
    room = np.full(6 * n * n, np.nan)  # J, then scratch
    room[: 2 * n * n] = np.hstack([stiffness, damping]).ravel()
    return min(h, EXCITED.longest(room, n, n, rate))


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
    assert 5.0 <= longest(stiff, damp) * 1e3 <= 7.0
    assert longest(stiff, -np.abs(damp[0, 0]) * np.eye(2), h=1.0) == 1.0
    assert longest(stiff, damp, rate=2.0, h=1.0) == 1.0
    assert longest(stiff, damp, h=1e-5) == 1e-5


BENT = np.array(  # about a contact of the four-bar beside a bent coupler (Hertz, Stribeck), digits cut
    [
        [-5.4e7, 4.5e4, -7.6e4, 1.7e6, -1.1e2, -5.6e2, -2.4e1, -2.8e-1],
        [-1.3e9, 5.3e5, -3.7e5, 2.5e7, -2.8e3, -6.0e4, -5.0e2, -5.9e0],
        [4.6e8, -8.7e5, 1.3e6, -3.3e7, -2.0e2, -3.6e3, 4.6e2, 5.3e0],
        [0.0, -3.0e6, 8.5e6, -7.8e7, -2.6e1, -8.6e-1, 5.7e0, 6.6e-2],
    ]
)
OF_BENT = np.linalg.eigvals(np.vstack([np.eye(4, 8, 4), BENT]))


@pytest.mark.parametrize("unit", [1.0, 1e3, 1e6, 1e9])
def test_units_far_apart_do_not_matter(unit, monkeypatch):
    """Of deflections and of time: the modes are found in a few sweeps of the iteration each."""
    monkeypatch.setattr(EXCITED, "ITERATIONS", EXCITED.STALLED)
    scale = np.array([unit, 1.0, 1.0, 1.0])
    stiff, damp = (scale[:, None] * BENT[:, at : at + 4] / scale for at in (0, 4))
    for second in (1.0, 1e-6, 1e6):
        wanted = min(EXCITED._fit(x.real, abs(x), 13.0) for x in OF_BENT)
        found = longest(stiff / second**2, damp / second, rate=13.0 / second)
        assert found == pytest.approx(wanted * second, rel=1e-6)


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


def test_where_eigenvalues_are_not_found_their_bound_says_how_long_a_step_is(monkeypatch):
    """No mode is faster than that, so none is passed over; and the run goes on."""
    monkeypatch.setattr(EXCITED, "ITERATIONS", 0)
    work = SimpleNamespace(J=BENT, eigen=np.zeros(96), weight=np.ones(8))
    motion = SimpleNamespace(real=np.zeros(NUMBERS), modes=np.array([2]))
    functions = SimpleNamespace(linearised=lambda variant, J, out: np.copyto(out[:32], J.ravel()))
    motion.real[H], motion.real[GROWTH] = 1.0, 13.0
    EXCITED.find_excited(functions, work, motion, SimpleNamespace(n_q=4, n=4))
    assert 0.0 < motion.real[H_EXCITED] * np.abs(OF_BENT).max() <= EXCITED.FAITHFUL
