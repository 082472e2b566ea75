"""A frame of tangent vectors: made orthonormal again and again, its growth and works added up.

Vectors are rows of a flat array (a place for time, which no tangent uses, then the state) and are measured in
units of the state's scales. Reference: Benettin et al. (1980); modified Gram-Schmidt, a second time where
the first took most of a vector away (Giraud et al. 2005).
"""

from math import log, sqrt

from ..interface import compiled, inlined, inner
from ..polynomial import integral

AGAIN = 0.05  # share of its length that a vector must keep to need no second pass: rounding grows 20 fold
LOST = 1e-9  # share below which a jump of lower rank has taken a vector's own direction away


@inner
def _product(d, a, b, width, weight):
    """Inner product of the vectors that begin at d[a] and d[b]; two sums, neither waiting for the other."""
    total, other = 0.0, 0.0
    for r in range(1, width - 1, 2):
        total += (weight[r - 1] * d[a + r]) * (weight[r - 1] * d[b + r])
        other += (weight[r] * d[a + r + 1]) * (weight[r] * d[b + r + 1])
    if width % 2 == 0:
        other += (weight[width - 2] * d[a + width - 1]) * (weight[width - 2] * d[b + width - 1])
    return total + other


@inner
def _reduce(d, i, width, weight, alive):
    """Remove from vector i its parts along the vectors before it; the lengths before and after."""
    at = i * width
    whole = before = left = sqrt(_product(d, at, at, width, weight))
    for _ in range(2 if i > 0 else 0):
        for j in range(i):
            if alive[j]:
                along = _product(d, j * width, at, width, weight)
                for r in range(1, width):
                    d[at + r] -= along * d[j * width + r]
        left = sqrt(_product(d, at, at, width, weight))
        if left > AGAIN * before:
            break
        before = left
    return whole, left


@compiled
def orthonormalise(d, width, weight, alive, norms, logs, lossy):
    """Make the frame orthonormal; lengths go to `norms`, their logarithms are added to `logs`.

    `lossy`, if 1: the frame comes from a map that may have lost a dimension; what is left of a vector by
    rounding alone is then given up, with the logarithm -inf.
    """
    for i in range(len(norms)):
        norms[i] = 1.0
        if not alive[i]:
            continue
        at = i * width
        whole, left = _reduce(d, i, width, weight, alive)
        norms[i] = left
        if not left > (LOST * whole if lossy > 0.0 else 0.0):
            alive[i], left = 0, 0.0
        logs[i] += log(left) if left > 0.0 else float("-inf")
        factor = 1.0 / left if left > 0.0 else 0.0
        for r in range(1, width):
            d[at + r] *= factor


@inner
def orthonormal(tangents, width, lossy):
    """Make the frame of tangents orthonormal (`orthonormalise`)."""
    d, weight, alive = tangents.d, tangents.weight, tangents.alive
    orthonormalise(d, width, weight, alive, tangents.norms, tangents.logs, lossy)


@inner
def determinant(S, n):
    """Determinant of the n by n matrix in S, row by row; S is spent."""
    found = 1.0
    for j in range(n):
        top = j
        for i in range(j + 1, n):
            if abs(S[i * n + j]) > abs(S[top * n + j]):
                top = i
        if S[top * n + j] == 0.0:
            return 0.0
        if top != j:
            found = -found
            for c in range(n):
                S[j * n + c], S[top * n + c] = S[top * n + c], S[j * n + c]
        found *= S[j * n + j]
        for i in range(j + 1, n):
            factor = S[i * n + j] / S[j * n + j]
            for c in range(j, n):
                S[i * n + c] -= factor * S[j * n + c]
    return found


@inner
def size_of(tangents, d, at):
    """Largest component of a tangent, at the piece's begin or end, in units of the scales."""
    size = 0.0
    for r in range(len(tangents.weight)):
        begin, end = d[1 + r], d[1 + r] + tangents.w[at + 8 * r + 6]
        size = max(size, abs(tangents.weight[r] * begin), abs(tangents.weight[r] * end))
    return size


@inlined
def add_works(derivatives, tangents, d, i, h):
    """Integrals of the powers' derivatives in the piece, of the i-th tangent."""
    w, n_w = tangents.w, len(tangents.powers) // 2
    if n_w > 0:
        derivatives.vary(w, d)
    for m in range(n_w):
        tangents.works[i * n_w + m] += integral(w, len(w) - 8 * (1 + n_w - m), h, tangents.b)
