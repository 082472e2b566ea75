"""Small kernels for the translator's tests: every construct that differs between the two languages."""

from math import log
from typing import NamedTuple

import numpy as np

TABLE = np.array([1.5, -2.0, 4.0])
COUNTS = np.array([3, 1], dtype=np.int64)
LAST = 2


class Pair(NamedTuple):
    first: float
    second: float


def whole_numbers(x, out):
    out[0], out[1], out[2], out[3] = -7 // 2, -7 % 3, 7 // -2, 7 % -3
    out[4], out[5], out[6] = 7 / 2, int(-2.5), 6 & 3
    out[7] = -(x[0] ** 2) - (x[1] - x[2] - x[0]) * 2 / 3 - (x[0] - x[1]) / (x[2] * (x[0] / x[1]))


def order(x, out):
    out[0] = 1.0 if x[0] < x[1] <= x[2] else 0.0
    out[1] = 1.0 if not x[0] > x[1] or x[2] == 2.0 else 0.0
    out[2] = min(x[3], x[0]) + max(x[0], x[1], x[2])
    out[3] = max(x[3], 1.0)  # x[3] is not a number
    out[4] = max(1.0, x[3])
    if x[3]:
        out[5] = 1.0
    out[6] = (x[0] < x[1]) + LAST * (x[1] < x[0])


def loops(x, out):
    total = 0.0
    for i in range(7, -1, -2):
        total += i * x[0]
    for i in range(1, len(x)):
        if i == 2:
            continue
        total += i
    for value in TABLE:
        total += value
        if value < 0.0:
            break
    n = 3
    while n > 0:
        n -= 1
        total *= 1.5
    for _ in range(n + 2):
        _, total = 1.0, total + COUNTS[0]
    out[0] = total


def views(x, out):
    part = out[2:5]
    part[0] = x[1]
    _fill(out[5:], 2.5)
    out[0], out[1] = x[1], x[0]
    out[0], out[1] = out[1], out[0]
    a = b = out[5] + 1.0
    out[6] = a + b


def _fill(array, value):
    array[0] = array[1] = value


def changed(x, out):
    n, left, power = -7, -7, x[1]
    n //= 2
    left %= 4
    power **= 2
    out[0], out[1], out[2], out[3] = n, left, power, 8.5
    out[3] //= x[0] + 1.0  # what stands on the right is one operand


def tables(rows, out):
    rows[1, 0] = rows[0][1] * 2.0
    row = rows[1]
    row[1] += 1.0
    out[0] = len(rows) + rows[1, 1]


def two(x):
    return x + 1.0, -x


def handed(function, x, out):
    new, _ = two(x[0])
    first, second = two(new)
    both = Pair(first, second)
    out[0], out[1] = function(both.first), log(both.second * both.second)
    out[2] = float("-inf")
    for j in range(2):
        kind = j in (0, LAST)
        out[3 + j] = kind
