"""Tangents that a parameter drives: their size, and the works that go with them (numerics.tangent)."""

from .interface import inlined, inner
from .radau import COLLOCATION


@inner
def size_of(y, d, at):
    """Largest component of a tangent, at the piece's begin or end, in units of the scales."""
    size = 0.0
    for r in range(len(y.weight)):
        begin, end = d[1 + r], d[1 + r] + y.w[at + 8 * r + 6]
        size = max(size, abs(y.weight[r] * begin), abs(y.weight[r] * end))
    return size


@inlined
def add_works(g, y, d, i, h):
    """Integrals of the powers' derivatives in the piece, of the i-th tangent."""
    n_w = len(y.powers) // 2
    if n_w > 0:
        g.vary(y.w, d)
    for m in range(n_w):
        y.works[i * n_w + m] += integral(y.w, len(y.w) - 8 * (1 + n_w - m), h, y.b)


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
