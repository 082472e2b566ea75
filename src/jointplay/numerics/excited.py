"""The longest step that follows what grows.

The method is L-stable: of a mode with h |lambda| >> 1 it leaves nothing, also where the mode grows. So a step
that is long for a vibration that friction excites, as where it falls with the sliding speed, keeps it from
ever coming up. No estimate of the error tells: without the vibration the motion is a solution as well, only
one that nothing holds. Hence the eigenvalues of the step's Jacobian are looked at: those of q' = z, z' =
J (q, z), by elimination to Hessenberg form and the QR iteration with Wilkinson's shifts.

On the imaginary axis the stability function is |R(iy)| = 1 - 2.4e-5 (y/5)^13, to a fifth for 5 <= y <= 7. A
step is short enough if that takes less than half of what the mode gains in it. References: Wilkinson, The
Algebraic Eigenvalue Problem (1965); Hairer and Wanner (see radau), section IV.3.
"""

from math import copysign, hypot

import numpy as np

from .interface import SIGNATURES, inner
from .memory import FOLLOWED, GROWTH, H

FAITHFUL, HALF, SPAN = 5.0, 1e5, 7.0  # h |lambda| at which R takes 2.4e-5; 2.5/2.4e-5, rounded; the most
EPS, ITERATIONS = 1e-15, 30


@inner
def _bound(J, weight, n_q, n):
    """A bound of all |lambda|: these have lambda^2 <= |J_z| lambda + |J_q|, in units of the speeds."""
    most, width = 0.0, n_q + n
    for r in range(n):
        stiff = damped = 0.0
        for c in range(n):
            stiff += abs(J[r * width + c]) * weight[r] / weight[c] if c < n_q else 0.0
            damped += abs(J[r * width + n_q + c]) * weight[r] / weight[c]
        most = max(most, damped + np.sqrt(stiff))
    return most


@inner
def _over(a, b):
    """Quotient of complex numbers (Smith, 1962), without the error that / has in store for b = 0."""
    if abs(b.real) >= abs(b.imag):
        ratio = b.imag / b.real
        whole = b.real + b.imag * ratio
        return complex((a.real + a.imag * ratio) / whole, (a.imag - a.real * ratio) / whole)
    ratio = b.real / b.imag
    whole = b.real * ratio + b.imag
    return complex((a.real * ratio + a.imag) / whole, (a.imag * ratio - a.real) / whole)


@inner
def _root(z):
    """Square root of a complex number (Friedland, Algorithm 312, 1967)."""
    a, b = z.real, z.imag
    part = np.sqrt((abs(a) + hypot(a, b)) * 0.5)
    if part == 0.0:
        return 0.0 * z
    return complex(part, b / (2 * part)) if a >= 0.0 else complex(abs(b) / (2 * part), copysign(part, b))


@inner
def _reduce(A, n):
    """Make A zero below its subdiagonal by elimination, keeping its eigenvalues."""
    for m in range(1, n - 1):
        p = m
        for i in range(m, n):
            p = i if abs(A[i, m - 1]) > abs(A[p, m - 1]) else p
        if A[p, m - 1] == 0.0:
            continue
        for i in range(n):
            A[m, i], A[p, i] = A[p, i], A[m, i]
        for i in range(n):
            A[i, m], A[i, p] = A[i, p], A[i, m]
        for i in range(m + 1, n):
            ratio = _over(A[i, m - 1], A[m, m - 1])
            if ratio != 0.0:
                for c in range(n):
                    A[i, c] -= ratio * A[m, c]
                for r in range(n):
                    A[r, m] += ratio * A[r, i]


@inner
def _iterate(A, n):
    """Bring the eigenvalues of a Hessenberg matrix to its diagonal."""
    for end in range(n - 1, 0, -1):
        for _ in range(ITERATIONS):
            low = end
            while low > 0 and abs(A[low, low - 1]) > EPS * (abs(A[low, low]) + abs(A[low - 1, low - 1])):
                low -= 1
            if low == end:
                break
            half = 0.5 * (A[end - 1, end - 1] - A[end, end])
            root = _root(half * half + A[end - 1, end] * A[end, end - 1])
            far = half + root if abs(half + root) > abs(half - root) else half - root
            shift = A[end, end] - (_over(A[end - 1, end] * A[end, end - 1], far) if far != 0.0 else 0.0)
            _sweep(A, n, low, end, shift)


@inner
def _sweep(A, n, low, end, shift):
    """One QR step with a shift on rows and columns from `low` to `end`; rows n and n + 1 are scratch."""
    for i in range(low, end + 1):
        A[i, i] -= shift
    for i in range(low, end):
        a, b = A[i, i], A[i + 1, i]
        size = np.sqrt(abs(a) ** 2 + abs(b) ** 2)
        c, s = (_over(a, size + 0.0j), _over(b, size + 0.0j)) if size > 0.0 else (1.0 + 0.0j, 0.0j)
        A[n, i], A[n + 1, i] = c, s
        for j in range(i, end + 1):
            upper, under = A[i, j], A[i + 1, j]
            A[i, j] = c.conjugate() * upper + s.conjugate() * under
            A[i + 1, j] = c * under - s * upper
    for i in range(low, end):
        c, s = A[n, i], A[n + 1, i]
        for r in range(low, i + 2):
            left, right = A[r, i], A[r, i + 1]
            A[r, i] = left * c + right * s
            A[r, i + 1] = right * c.conjugate() - left * s.conjugate()
    for i in range(low, end + 1):
        A[i, i] += shift


@inner
def longest(J, weight, A, n_q, n, rate):
    """Longest step for modes that grow faster than `rate`, 1/s; A is scratch."""
    n_x, weight, h = n_q + n, weight[n_q:], np.inf
    for r in range(n_x):
        for c in range(n_x):
            A[r, c] = 1.0 if c == n_q + r else 0.0
            if r >= n_q:
                A[r, c] = J[(r - n_q) * n_x + c] * weight[r - n_q] / weight[c if c < n_q else c - n_q]
    _reduce(A, n_x)
    _iterate(A, n_x)
    for r in range(n_x):
        gain, size = A[r, r].real, abs(A[r, r])
        if gain > rate:
            h = min(h, min(SPAN, FAITHFUL * (HALF * gain / size) ** (1.0 / 12.0)) / size)
    return h


@inner
def at_wall(f, guard, at, k, x, o):
    """Note the longest step; in the place of what happens at walls (wall_flow), of which there are none."""
    x.real[FOLLOWED] = np.inf
    if x.real[H] * _bound(k.J, k.weight[o.n_q :], o.n_q, o.n) > FAITHFUL:
        x.real[FOLLOWED] = longest(k.J, k.weight, k.modes, o.n_q, o.n, x.real[GROWTH])


UNIT = {"at_wall": SIGNATURES["at_wall"]}
