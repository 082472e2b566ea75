"""Roots by Bernstein coefficients against numpy's, and what does not count as a root."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from numpy.polynomial import Polynomial

from jointplay.solver.method.memory import STACK
from jointplay.solver.method.polynomial import TO_ROUNDING, basis, bernstein, first_root, keep_right
from jointplay.solver.method.radau import NODES

NONE = 2.0


def coefficients(polynomial, multiplicity=0):
    """Bernstein coefficients from the values at the method's nodes."""
    values, b = np.array([polynomial(x) for x in NODES]), np.zeros(16)
    degree = bernstein(values, 0, multiplicity, b)
    return b, degree


def first(polynomial, side, multiplicity=0):
    b, degree = coefficients(polynomial, multiplicity)
    return first_root(b, degree, side, np.zeros(STACK), TO_ROUNDING)


def expected(polynomial, side):
    """First place in [0, 1] where the sign leaves `side`, from numpy's roots and the signs between them."""
    found = polynomial.roots()
    inner = np.sort(found[(np.abs(found.imag) < 1e-9) & (found.real > 0) & (found.real < 1)].real)
    marks = [0.0, *inner, 1.0]
    for left, right in itertools.pairwise(marks):
        if polynomial((left + right) / 2) * side < 0:
            return left
    return NONE


@pytest.mark.parametrize("seed", range(60))
def test_random_polynomials(seed):
    random = np.random.default_rng(seed)
    polynomial = Polynomial.fromroots(random.uniform(-0.6, 1.6, 7)) * random.choice([-1e-6, 1.0, 1e5])
    side = 1 if polynomial(0.0) > 0 else -1
    assert first(polynomial, side) == pytest.approx(expected(polynomial, side), abs=1e-9)


@pytest.mark.parametrize("seed", range(20))
def test_complex_roots_are_none(seed):
    random = np.random.default_rng(100 + seed)
    pairs = random.uniform(0, 1, 3) + 1j * random.uniform(1e-3, 0.3, 3)
    polynomial = Polynomial.fromroots([*pairs, *pairs.conj()])
    polynomial = Polynomial(polynomial.coef.real)
    assert first(polynomial, 1) == NONE
    assert first(-1 * polynomial, -1) == NONE


@pytest.mark.parametrize("place", [0.03, 0.31, 0.5, 0.87])
def test_a_touch_is_no_crossing(place):
    """A double root within rounding of zero is passed over; the crossing after it is found."""
    touch = Polynomial.fromroots([place, place])
    assert first(touch, 1) in (NONE, pytest.approx(place, abs=1e-6))
    assert first(touch + 1e-9, 1) == NONE
    crossing = touch * Polynomial([0.95, -1.0])
    assert first(crossing + 1e-9, 1) == pytest.approx(0.95, abs=1e-6)


@pytest.mark.parametrize("gap", [1e-2, 1e-4, 1e-6])
def test_a_short_visit_is_not_stepped_over(gap):
    polynomial = Polynomial.fromroots([0.4, 0.4 + gap]) * Polynomial([2.0, 1.0, -0.5])
    assert first(polynomial, 1) == pytest.approx(0.4, abs=1e-3 * gap + 1e-12)


@pytest.mark.parametrize("multiplicity", [1, 2])
@pytest.mark.parametrize("seed", range(12))
def test_a_guard_that_starts_at_zero(multiplicity, seed):
    """Its root at the start is divided out; its other roots are found."""
    random = np.random.default_rng(seed)
    others = Polynomial.fromroots(random.uniform(0.05, 1.5, 7 - multiplicity))
    polynomial = Polynomial.fromroots([0.0] * multiplicity) * others
    side = 1 if others(0.0) > 0 else -1
    b, degree = coefficients(polynomial, multiplicity)
    assert (degree, b[0]) == (6, pytest.approx(others(0.0), abs=1e-10))
    assert first(polynomial, side, multiplicity) == pytest.approx(expected(others, side), abs=1e-8)


def test_the_wrong_side_at_the_start_is_left_at_once():
    assert first(Polynomial([1.0, 1.0]), -1) == 0.0


def test_a_root_at_the_end_is_one():
    assert first(Polynomial([-1.0, 1.0]), -1) in (NONE, pytest.approx(1.0, abs=1e-14))
    assert first(Polynomial([-1.0, 1.0 + 1e-12]), -1) == pytest.approx(1.0, abs=1e-11)


def test_what_lies_to_the_right_of_a_root():
    """Divided out, or the root itself would be found again and the next one missed."""
    polynomial = Polynomial.fromroots([0.3, 0.6, 1.4])
    b, degree = coefficients(polynomial)
    degree = keep_right(b, degree, 0.3)
    place = first_root(b, degree, 1, np.zeros(STACK), TO_ROUNDING)
    assert 0.3 + place * 0.7 == pytest.approx(0.6, abs=1e-12)


def test_lagrange_basis():
    polynomial = Polynomial(np.random.default_rng(5).normal(size=8))
    values, out = polynomial(NODES), np.zeros(16)
    for x in (0.0, 0.2, 0.77, 1.0, 1.3, *NODES):
        basis(x, out)
        assert out[8:] @ values == pytest.approx(polynomial(x), rel=1e-10, abs=1e-12)
