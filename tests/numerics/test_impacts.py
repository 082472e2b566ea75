"""Impacts on several walls at once: impulses against every choice of walls that push."""

from itertools import chain, combinations

import numpy as np
import pytest

from tests.support.plain import uncompiled

IMPACTS = uncompiled("impacts")


def swept(A, before, target, part):
    """Impulses and rates after, by the kernel's sweeps."""
    n = len(A)
    rows = np.zeros((IMPACTS.ROWS, n))
    rows[IMPACTS.PART], rows[IMPACTS.BEFORE], rows[IMPACTS.TARGET] = part, before, target
    w = np.concatenate([A.ravel(), rows.ravel()])
    IMPACTS._sweep(w, n)
    rows = w[n * n :].reshape(IMPACTS.ROWS, n)
    return rows[IMPACTS.PUSH], rows[IMPACTS.AFTER]


def chosen(A, before, target, part):
    """The same by trying every set of walls that push."""
    walls = np.flatnonzero(part)
    for push in chain.from_iterable(combinations(walls, k) for k in range(len(walls) + 1)):
        push, L = list(push), np.zeros(len(A))
        L[push] = np.linalg.solve(A[np.ix_(push, push)], (target - before)[push])
        after = before + A @ L
        if np.all(L >= 0) and np.all((after - target)[walls] >= -1e-12):
            return L, after
    raise AssertionError("no set fits")


@pytest.mark.parametrize("seed", range(8))
def test_impulses(seed):
    """Random walls of a random mass matrix, some of which open or take no part."""
    random = np.random.default_rng(seed)
    n = 2 + seed % 3
    N = random.standard_normal((n, 4))
    W = N @ N.T
    A = W / np.diag(W)  # columns: an impulse that changes the wall's own rate by 1
    before, part = random.standard_normal(n) - 1.0, random.random(n) < 0.8
    r = random.uniform(0.0, 1.0, n)
    target = np.where(before < 0.0, -r * before, 0.0)
    push, after = swept(A, before, target, part)
    wanted, rates = chosen(A, before, target, part)
    assert push == pytest.approx(wanted, abs=1e-9)
    assert after == pytest.approx(rates, abs=1e-9)


def test_two_corners_of_a_light_slider_leave_alike():
    """Coupled as those of a slider of hardly any inertia: still Newton's law for both."""
    A = np.array([[1.0, -0.979], [-0.979, 1.0]])
    push, after = swept(A, np.array([-1.0, -1.0]), np.array([0.4, 0.4]), np.ones(2))
    assert after == pytest.approx([0.4, 0.4], abs=1e-12)
    assert push == pytest.approx([1.4 / 0.021] * 2, rel=1e-10)
