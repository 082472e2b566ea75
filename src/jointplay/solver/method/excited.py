"""The longest step that follows growing modes.

The method is L-stable: of a mode with h |lambda| >> 1 it leaves nothing, also where the mode grows. So a step
that is long for a vibration that friction excites, as where it falls with the sliding speed, keeps it from
ever coming up. No estimate of the error tells: without the vibration the motion is a solution as well, only
one that nothing holds. Hence the eigenvalues of the step's Jacobian are looked at: those of q' = z, z' =
J (q, z), by balancing, elimination to Hessenberg form, and the QR iteration with Francis's double shifts.

On the imaginary axis the stability function is |R(iy)| = 1 - 2.4e-5 (y/5)^13, to a fifth for 5 <= y <= 7. A
step is short enough if that takes less than half of what the mode gains in it. References: Golub and Van
Loan, Matrix Computations (2013), section 7.5; Parlett and Reinsch, Numerische Mathematik 13 (1969) 293-304;
Hairer and Wanner (see radau), section IV.3.

A matrix of n rows lies in one array from the place `at` on, its entry (r, c) at `at` + n r + c.
"""

from math import copysign

import numpy as np

from .interface import SIGNATURES, inner
from .memory import GROWTH, H_EXCITED, H
from .modes import variant_of

FAITHFUL, HALF, SPAN = 5.0, 1e5, 7.0  # h |lambda| at which R takes 2.4e-5; 2.5/2.4e-5, rounded; the most
EPS, ITERATIONS = 1e-15, 40
STALLED = 10  # iterations after which shifts are taken beside the eigenvalues


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
def _balance(A, at, n):
    """Scale A until the row and the column of each place are of one size, keeping its eigenvalues.

    Positions and speeds, and those of bent links, have units far apart, and the iteration would wander.
    """
    for _ in range(ITERATIONS):
        balanced = True
        for i in range(n):
            row = column = 0.0
            for k in range(n):
                row += abs(A[at + n * i + k]) if k != i else 0.0
                column += abs(A[at + n * k + i]) if k != i else 0.0
            mean = np.sqrt(row * column)
            if 0.0 < mean < 0.475 * (row + column):
                for k in range(n):
                    A[at + n * i + k] *= mean / row
                    A[at + n * k + i] *= mean / column
                balanced = False
        if balanced:
            return


@inner
def _reduce(A, at, n):
    """Make A zero below its subdiagonal by elimination, keeping its eigenvalues."""
    for m in range(1, n - 1):
        p = m
        for i in range(m, n):
            p = i if abs(A[at + n * i + m - 1]) > abs(A[at + n * p + m - 1]) else p
        pivot = A[at + n * p + m - 1]
        if pivot == 0.0:
            continue
        for i in range(n):
            above, below = at + n * m + i, at + n * p + i
            A[above], A[below] = A[below], A[above]
        for i in range(n):
            left, right = at + n * i + m, at + n * i + p
            A[left], A[right] = A[right], A[left]
        for i in range(m + 1, n):
            ratio = A[at + n * i + m - 1] / pivot
            if ratio != 0.0:
                for c in range(n):
                    A[at + n * i + c] -= ratio * A[at + n * m + c]
                for r in range(n):
                    A[at + n * r + m] += ratio * A[at + n * r + i]


@inner
def _lowest(A, at, n, end):
    """First row of the block that ends with row `end`, and hangs together."""
    low = end
    while low > 0:
        here = at + (n + 1) * low
        if not abs(A[here - 1]) > EPS * (abs(A[here]) + abs(A[here - n - 1])):
            break
        low -= 1
    return low


@inner
def _sweep(A, at, n, low, end, total, product):
    """One QR step on rows and columns `low` to `end`, at least three, with two shifts (sum and product)."""
    here = at + (n + 1) * low
    first, under = A[here], A[here + n]
    x = first * (first - total) + A[here + 1] * under + product
    y, z = under * (first + A[here + n + 1] - total), under * A[here + 2 * n + 1]
    for k in range(low, end):
        last = min(k + 2, end)
        size = np.sqrt(x * x + y * y + z * z)
        if size > 0.0:
            whole = x + copysign(size, x)
            y, z = y / whole, z / whole
            twice = 2.0 / (1.0 + y * y + z * z)
            for c in range(max(low, k - 1), end + 1):
                place = at + n * k + c
                part = A[place] + y * A[place + n] + (z * A[place + 2 * n] if last > k + 1 else 0.0)
                A[place] -= twice * part
                A[place + n] -= twice * y * part
                if last > k + 1:
                    A[place + 2 * n] -= twice * z * part
            for r in range(low, min(k + 3, end) + 1):
                place = at + n * r + k
                part = A[place] + y * A[place + 1] + (z * A[place + 2] if last > k + 1 else 0.0)
                A[place] -= twice * part
                A[place + 1] -= twice * y * part
                if last > k + 1:
                    A[place + 2] -= twice * z * part
        for r in range(k + 1, last + 1):
            if k > low:
                A[at + n * r + k - 1] = 0.0
        x, y = A[at + n * (k + 1) + k], A[at + n * last + k] if last > k + 1 else 0.0
        z = A[at + n * (k + 3) + k] if k + 3 <= end else 0.0


@inner
def _fit(gain, size, rate):
    """Longest step for a mode of |lambda| = `size`; infinite for one that gains no more than `rate`."""
    if not gain > rate:
        return np.inf
    return min(SPAN, FAITHFUL * (HALF * gain / size) ** (1.0 / 12.0)) / size


@inner
def _longest(A, at, n, rate):
    """Longest step for all modes that gain more than `rate`; 0 where the iteration does not converge."""
    h, end, tries = np.inf, n - 1, 0
    _balance(A, at, n)
    _reduce(A, at, n)
    while end >= 0:
        low, here = _lowest(A, at, n, end), at + (n + 1) * end
        if low == end:
            h = min(h, _fit(A[here], abs(A[here]), rate))
            end, tries = end - 1, 0
            continue
        half = 0.5 * (A[here - n - 1] + A[here])
        apart = 0.5 * (A[here - n - 1] - A[here])
        square = apart * apart + A[here - 1] * A[here - n]
        if low == end - 1:
            if square < 0.0:
                h = min(h, _fit(half, np.sqrt(half * half - square), rate))
            else:
                root = np.sqrt(square)
                h = min(h, _fit(half - root, abs(half - root), rate))
                h = min(h, _fit(half + root, abs(half + root), rate))
            end, tries = end - 2, 0
            continue
        tries += 1
        if tries > ITERATIONS:
            return 0.0
        total, product = 2.0 * half, half * half - square
        if tries % STALLED == 0:
            size = abs(A[here - 1]) + abs(A[here - n - 2])
            total, product = 1.5 * size, size * size
        _sweep(A, at, n, low, end, total, product)
    return h


@inner
def longest(A, n_q, n, rate):
    """Longest step for modes that gain more than `rate`, 1/s, of the Jacobian with which A begins.

    0 where they are not found. The rest of A is scratch.
    """
    n_x, at = n_q + n, n * (n_q + n)
    for r in range(n_x):
        for c in range(n_x):
            slope = 1.0 if c == n_q + r else 0.0
            A[at + n_x * r + c] = slope if r < n_q else A[(r - n_q) * n_x + c]
    return _longest(A, at, n_x, rate)


@inner
def find_excited(functions, work, motion, options):
    """Note the longest step that follows growing modes about the attempt in work.

    Where their eigenvalues are not found, it is one that is short enough for any within their bound.
    """
    functions.linearised(variant_of(motion.modes), work.J, work.eigen)
    motion.real[H_EXCITED] = np.inf
    bound = _bound(work.eigen, work.weight[options.n_q :], options.n_q, options.n)
    if motion.real[H] * bound > FAITHFUL:
        found = longest(work.eigen, options.n_q, options.n, motion.real[GROWTH])
        motion.real[H_EXCITED] = found if found > 0.0 else FAITHFUL / bound


@inner
def at_wall(functions, guard, at, work, motion, options):
    """Look for growing modes; stands in the place of wall_flow.at_wall where there are no walls."""
    find_excited(functions, work, motion, options)


UNIT = {"at_wall": SIGNATURES["at_wall"]}
