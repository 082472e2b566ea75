"""Polynomials of a step: evaluation at any place, and roots isolated without stepping over any.

A quantity known at the nodes (0, c_1 … c_7) of a step of the collocation method is a polynomial of degree 7
on it. Its Bernstein coefficients bound it: no change of sign among them, no root (Descartes); one change,
one root; more, halve the interval (de Casteljau). Reference: Farouki, Comput. Aided Geom. Design 29 (2012)
379-419.

A guard that has just fired starts at zero. It is divided by tau^m, m its multiplicity there, which leaves a
polynomial of degree 6 through the seven stages and its other roots.
"""

import numpy as np

from .interface import compiled, inlined
from .lanes.lanes import matvec
from .memory import HALVINGS
from .radau import COLLOCATION, NODES

DEGREE = 7
TO_ROUNDING = 1e-15  # to which a root is found in an interval of length 1


def to_bernstein(nodes: np.ndarray) -> np.ndarray:
    """Matrix from values at nodes to Bernstein coefficients, in extended precision."""
    n = len(nodes) - 1
    x = nodes.astype(np.longdouble)
    binomial = np.array(
        [np.prod([(n - i) / (i + 1) for i in range(k)]) for k in range(n + 1)], dtype=np.longdouble
    )
    basis = np.array([binomial[k] * x**k * (1 - x) ** (n - k) for k in range(n + 1)]).T
    inverse = np.linalg.inv(basis.astype(float)).astype(np.longdouble)
    for _ in range(4):
        inverse = inverse @ (2 * np.eye(n + 1) - basis @ inverse)
    return inverse.astype(float)


TO_BERNSTEIN = to_bernstein(NODES).T.copy().ravel()
TO_BERNSTEIN_6 = to_bernstein(NODES[:DEGREE]).T.copy().ravel()
BARYCENTRIC = np.array([1 / np.prod([x - y for y in NODES if y != x]) for x in NODES])


CHEBYSHEV = np.linalg.inv(np.polynomial.chebyshev.chebvander(2 * NODES - 1, DEGREE))[-2:].ravel()


@compiled
def last_terms(g, at):
    """Sizes of the last two of the Chebyshev polynomials that make up the row g[at : at + 8], together."""
    last, before = 0.0, 0.0
    for i in range(8):
        before += CHEBYSHEV[i] * g[at + i]
        last += CHEBYSHEV[8 + i] * g[at + i]
    return abs(before) + abs(last)


@compiled
def basis(x, out):
    """Lagrange basis polynomials of the eight nodes at x, in out[8:]."""
    if x == 1.0:
        for j in range(8):
            out[8 + j] = 0.0
        out[14] = 1.0
        return
    left = 1.0
    for j in range(8):
        out[8 + j] = BARYCENTRIC[j] * left
        left *= x - NODES[j]
    right = 1.0
    for j in range(7, -1, -1):
        out[8 + j] *= right
        right *= x - NODES[j]


@compiled
def interpolate(w, at, start, shift, n, b, out):
    """Write start[shift:] plus increments from w[at] on, at the place of the basis b[8:], to out[shift:]."""
    if b[14] == 1.0:  # the step's end
        for r in range(n):
            out[shift + r] = start[shift + r] + w[at + 8 * r + 6]
        return
    for r in range(n):
        total = start[shift + r]
        for i in range(7):
            total += b[8 + i] * w[at + 8 * r + i]
        out[shift + r] = total


@compiled
def bernstein(g, at, multiplicity, b):
    """Bernstein coefficients of the row g[at : at + 8]; give back their degree.

    The outer ones are the values at both ends: taken as they are, so that rounding makes no root there.
    """
    if multiplicity == 0:
        matvec(b, 0, g, at, TO_BERNSTEIN)
        b[0], b[7] = g[at + 7], g[at + 6]
        return 7
    for i in range(8):
        b[i] = 0.0
    for j in range(7):  # it starts at zero by definition, whatever rounding or tolerance made of that
        value = (g[at + j] - g[at + 7]) / NODES[j]
        for _ in range(1, multiplicity):
            value /= NODES[j]
        for i in range(7):
            b[i] += TO_BERNSTEIN_6[7 * j + i] * value
    return 6


@compiled
def _changes(b, at, n, inside):
    """Changes of sign along b[at : at + n + 1], beginning on the side `inside` (-1 or +1)."""
    count, last = 0, float(inside)
    for i in range(at, at + n + 1):
        if b[i] * last < 0.0:
            count += 1
            last = b[i]
    return count


@compiled
def value(b, at, n, x):
    """de Casteljau at x, in local variables; those beyond the degree n, 7 at most, are of no account."""
    c0, c1, c2, c3 = b[at], b[at + 1], b[at + 2], b[at + 3]
    c4, c5, c6, c7 = b[at + 4], b[at + 5], b[at + 6], b[at + 7]
    for _ in range(n):
        c0 += x * (c1 - c0)
        c1 += x * (c2 - c1)
        c2 += x * (c3 - c2)
        c3 += x * (c4 - c3)
        c4 += x * (c5 - c4)
        c5 += x * (c6 - c5)
        c6 += x * (c7 - c6)
    return c0


@compiled
def keep_right(b, n, x):
    """Restrict b to [x, 1], where x is a root, and divide that root out; the degree that is left."""
    for k in range(n):
        for i in range(n - k):
            b[i] += x * (b[i + 1] - b[i])
    for i in range(n):
        b[i] = b[i + 1] * n / (i + 1)
    return n - 1


@compiled
def _halve(b, at, n, left):
    """Split b[at : at + n + 1]: its right half stays, its left half goes to b[left : …]."""
    for k in range(n + 1):
        b[left + k] = b[at]
        for i in range(n - k):
            b[at + i] = 0.5 * (b[at + i] + b[at + i + 1])


@compiled
def _bracketed(b, at, n, inside, share):
    """The one root of b[at : at + n + 1] on [0, 1], by false position that keeps its bracket (Illinois)."""
    lo, hi, side = 0.0, 1.0, 0
    g_lo, g_hi = b[at] * inside, b[at + n] * inside
    if g_lo <= 0.0:
        return lo
    for _ in range(80):
        if g_hi == 0.0 or hi - lo < share:
            break
        x = hi - g_hi * (hi - lo) / (g_hi - g_lo)
        if not lo < x < hi:
            x = 0.5 * (lo + hi)
        g = value(b, at, n, x) * inside
        if g <= 0.0:
            hi, g_hi = x, g
            g_lo, side = (0.5 * g_lo if side == 1 else g_lo), 1
        else:
            lo, g_lo = x, g
            g_hi, side = (0.5 * g_hi if side == -1 else g_hi), -1
    return hi


@compiled
def first_root(b, n, inside, stack, share):
    """First place in [0, 1] where the polynomial with coefficients b[: n + 1] leaves `inside`; 2.0 if none.

    It is found to a share of the interval in which it is alone.

    `stack` takes intervals of ten doubles (place, width, coefficients), the leftmost on top. Where HALVINGS
    halvings leave two changes of sign, the polynomial touches zero and does not cross it: passed over.
    """
    depth = 1
    stack[0], stack[1] = 0.0, 1.0
    for i in range(n + 1):
        stack[2 + i] = b[i]
    while depth > 0:
        top = 10 * (depth - 1)
        changes = _changes(stack, top + 2, n, inside)
        if changes == 1:
            return stack[top] + stack[top + 1] * _bracketed(stack, top + 2, n, inside, share)
        if changes == 0 or depth > HALVINGS:
            depth -= 1
            continue
        half = 0.5 * stack[top + 1]
        _halve(stack, top + 2, n, top + 12)
        stack[top + 10], stack[top + 11] = stack[top], half
        stack[top], stack[top + 1] = stack[top] + half, half
        depth += 1
    return 2.0


@compiled
def differentiate(b, degree):
    """Turn Bernstein coefficients into the derivative's, but for a factor; its degree, and its first side."""
    for i in range(degree):
        b[i] = b[i + 1] - b[i]
    return degree - 1, 1 if b[0] > 0.0 else -1


@compiled
def next_extremum(b, degree, place, side, end, stack):
    """Next extremum of a quantity after `place`, up to `end` (2.0: none), and the degree that b has then.

    b is its derivative on [place, 1], which begins on the side `side`, and becomes that beyond the extremum.
    """
    root = first_root(b, degree, side, stack, TO_ROUNDING) if degree > 0 else 2.0
    at = place + root * (1.0 - place)
    if root > 1.0 or at > end:
        return 2.0, degree
    return at, keep_right(b, degree, root)


@inlined
def integral(w, at, h, b):
    """Integral of the lane row at w[at] up to the place whose basis stands in b[8:]."""
    total = 0.0
    for j in range(7):
        share = COLLOCATION[8 * j + 6]
        if b[14] != 1.0:  # not the step's end
            share = 0.0
            for i in range(7):
                share += b[8 + i] * COLLOCATION[8 * j + i]
        total += share * w[at + j]
    return h * total
