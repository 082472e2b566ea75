"""Operations on whole lane rows at places that are known only at run time.

A loop over eight lanes is compiled to vector instructions where places are constants; where they are not,
the compiler must assume that rows overlap, and computes lane by lane. These few operations are therefore
given as vector instructions (lane_instructions); here is their meaning in plain Python, which runs where
nothing is compiled. A complex row is four real parts, then four imaginary parts.
"""

import numpy as np

from ..interface import instruction


@instruction
def matvec(w, to, source, at, table):
    """Row at w[to]: the eight numbers from source[at] on times a lane-to-lane matrix (see radau)."""
    w[to : to + 8] = source[at : at + 8] @ table.reshape(8, 8)


@instruction
def position_row(w, to, h, speed, at, table, nodes):
    """Row at w[to]: h times (`speed` * nodes + the row at w[at] times a lane-to-lane matrix)."""
    w[to : to + 8] = h * (speed * nodes + w[at : at + 8] @ table.reshape(8, 8))


@instruction
def add_matvec(w, to, squares, factor, at, table):
    """Add z, the row at w[at] times a matrix, to the row at w[to], and (factor z)^2 to the squares."""
    z = w[at : at + 8] @ table.reshape(8, 8)
    w[to : to + 8] += z
    w[squares : squares + 8] += (factor * z) ** 2


@instruction
def axpy(w, to, factor, at):
    """Row at w[to] plus `factor` times the row at w[at]."""
    w[to : to + 8] += factor * w[at : at + 8]


@instruction
def sparse_dot(w, to, numbers, pairs, begin, end):
    """Row at w[to]: the sum of numbers[i] times the row at w[at] over (i, at) in pairs[begin:end]."""
    rows = [numbers[pairs[o]] * w[pairs[o + 1] : pairs[o + 1] + 8] for o in range(begin, end, 2)]
    w[to : to + 8] = np.sum(rows, axis=0)


@instruction
def subtract_products(w, to, pairs, begin, end):
    """Complex row at w[to] less the products of rows w[a] and w[b] over (a, b) in pairs[begin:end]."""
    total = _number(w, to)
    for o in range(begin, end, 2):
        total = total - _number(w, pairs[o]) * _number(w, pairs[o + 1])
    w[to : to + 4], w[to + 4 : to + 8] = total.real, total.imag


@instruction
def complex_multiply(w, to, a):
    """Complex row at w[to] times that at w[a]."""
    product = _number(w, to) * _number(w, a)
    w[to : to + 4], w[to + 4 : to + 8] = product.real, product.imag


@instruction
def complex_fma(w, to, a, b):
    """Complex row at w[to] plus the product of the rows at w[a] and w[b]."""
    total = _number(w, to) + _number(w, a) * _number(w, b)
    w[to : to + 4], w[to + 4 : to + 8] = total.real, total.imag


@instruction
def complex_sum(w, to, x, a, y, b, z):
    """Complex row at w[to]: x times that at w[a], y times that at w[b], and the real z."""
    total = x * _number(w, a) + y * _number(w, b) + z
    w[to : to + 4], w[to + 4 : to + 8] = total.real, total.imag


def _number(w, at):
    return w[at : at + 4] + 1j * w[at + 4 : at + 8]
