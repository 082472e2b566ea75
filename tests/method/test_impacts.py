"""Impacts on several walls, with friction: impulses against the laws themselves and every choice of walls."""

from itertools import chain, combinations

import numpy as np
import pytest

from jointplay.solver.method import memory
from jointplay.solver.method.walls import impacts as IMPULSES

MOST, SIZE = memory.MOST, memory.SIZE


def solved(matrix, before, target, friction):
    """Normal and tangential impulses, and rates after, by the kernel; the scratch that it leaves."""
    n, q = len(target), np.zeros(memory.STATE)
    place = np.ravel([[2 * i, 2 * i + 1] for i in range(n)])
    full = np.zeros((SIZE, SIZE))
    full[np.ix_(place, place)] = matrix
    q[memory.MATRIX : memory.MATRIX + SIZE * SIZE] = full.ravel()
    q[memory.BEFORE : memory.BEFORE + 2 * n] = before
    q[memory.TARGET : memory.TARGET + n] = target
    q[memory.FRICTION : memory.FRICTION + n] = friction
    IMPULSES.solve(q, n, 1.0)
    return q


def answer(q, n):
    impulses, after = (q[at : at + 2 * n].reshape(n, 2).T for at in (memory.PUSH, memory.AFTER))
    return (*impulses, *after)


def scene(seed, rubs):
    """Walls of a random body, some of which open; of smooth ones nothing acts along them."""
    random = np.random.default_rng(seed)
    n = 1 + seed % (4 if rubs else MOST)  # rubbing ones are twice as many rows, of six
    rows = random.standard_normal((2 * n, 6))
    rows[1::2] *= rubs
    matrix, before = rows @ rows.T, random.standard_normal(2 * n) - np.tile([1.0, 0.0], n)
    before[1::2] *= rubs
    r = random.uniform(0.0, 1.0, n)
    target = np.where(before[::2] < 0.0, -r * before[::2], 0.0)
    return matrix, before, target, rubs * random.uniform(0.05, 0.6, n)


def chosen(A, before, target):
    """Smooth walls: the impulses by trying every set of those that push."""
    walls = np.arange(len(A))
    for push in chain.from_iterable(combinations(walls, k) for k in range(len(walls) + 1)):
        push, L = list(push), np.zeros(len(A))
        L[push] = np.linalg.solve(A[np.ix_(push, push)], (target - before)[push])
        after = before + A @ L
        if np.all(L >= 0) and np.all(after - target >= -1e-12):
            return L, after
    raise AssertionError("no set fits")


@pytest.mark.parametrize("seed", range(8))
def test_smooth_walls(seed):
    matrix, before, target, friction = scene(seed, 0.0)
    push, along, after, _ = answer(solved(matrix, before, target, friction), len(target))
    wanted, rates = chosen(matrix[::2, ::2], before[::2], target)
    assert push == pytest.approx(wanted, abs=1e-9)
    assert after == pytest.approx(rates, abs=1e-9)
    assert not along.any()


@pytest.mark.parametrize("seed", range(16))
def test_rough_walls_obey_newton_and_coulomb(seed):
    """Every condition of both laws, and what impulses do to the rates."""
    matrix, before, target, f = scene(seed, 1.0)
    n = len(target)
    p, q, v, t = answer(solved(matrix, before, target, f), n)
    assert np.ravel([v, t], "F") == pytest.approx(before + matrix @ np.ravel([p, q], "F"), abs=1e-9)
    assert p.min() > -1e-9
    assert (v - target).min() > -1e-9
    assert p * (v - target) == pytest.approx(np.zeros(n), abs=1e-9)
    assert (f * p - np.abs(q)).min() > -1e-9
    slips = np.abs(t) > 1e-8
    assert q[slips] == pytest.approx(-(f * p * np.sign(t))[slips], abs=1e-8)


@pytest.mark.parametrize("seed", range(16))
def test_restitutions_are_lowered_to_where_no_energy_is_made(seed):
    """Plastic impacts make none; where Newton's law would, what is left of it makes exactly none."""
    matrix, before, target, f = scene(seed, 1.0)
    f, n = 3 * f, len(target)
    assert IMPULSES.gain(solved(matrix, before, 0 * target, f), n) < 1e-12
    q = solved(matrix, before, target, f)
    if IMPULSES.gain(q, n) > 1e-9:
        IMPULSES.lower(q, n)
        assert 0.0 <= q[memory.SHARE] < 1.0
        assert IMPULSES.gain(q, n) == pytest.approx(0.0, abs=1e-9)


def test_friction_that_would_make_energy_exists():
    """So that the test above is one."""
    matrices = [scene(seed, 1.0) for seed in range(16)]
    gains = [IMPULSES.gain(solved(m, b, t, 3 * f), len(t)) for m, b, t, f in matrices]
    assert max(gains) > 1e-4


@pytest.mark.parametrize(("speed", "slips"), [(0.74, False), (0.76, True), (-0.74, False), (-0.76, True)])
def test_a_point_mass_slips_above_its_threshold(speed, slips):
    """f (1 + r) |v-| = 0.75 is the most that friction can stop."""
    q = solved(np.eye(2), np.array([-1.0, speed]), np.array([0.5]), np.array([0.5]))
    p, along, v, t = (float(each[0]) for each in answer(q, 1))
    assert (p, v) == pytest.approx((1.5, 0.5))
    assert t == pytest.approx(speed - np.sign(speed) * 0.75 if slips else 0.0, abs=1e-15)
    assert along == pytest.approx(t - speed)


def test_two_corners_of_a_light_slider_leave_alike():
    """Coupled as those of a slider of hardly any inertia: still Newton's law for both."""
    matrix = np.zeros((4, 4))
    matrix[::2, ::2] = [[1.0, -0.979], [-0.979, 1.0]]
    q = solved(matrix, np.array([-1.0, 0.0, -1.0, 0.0]), np.array([0.4, 0.4]), np.zeros(2))
    push, _, after, _ = answer(q, 2)
    assert after == pytest.approx([0.4, 0.4], abs=1e-12)
    assert push == pytest.approx([1.4 / 0.021] * 2, rel=1e-10)
