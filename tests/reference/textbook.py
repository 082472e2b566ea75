"""Matrices of Hermite elements as textbooks print them, for what the reference takes from Gauss points."""

from __future__ import annotations

import numpy as np


def textbook(line, mass):
    """Consistent mass, stiffness, S and I of Hermite elements from the closed forms of textbooks."""
    h, count, per_length = line.h, line.beam.elements, mass / line.length
    M, K, S, I = *np.zeros((2, 2 * count + 2, 2 * count + 2)), *np.zeros((2, 2 * count + 2))
    m = [
        [156, 22 * h, 54, -13 * h],
        [0, 4 * h * h, 13 * h, -3 * h * h],
        [0, 0, 156, -22 * h],
        [0, 0, 0, 4 * h * h],
    ]
    k = [[12, 6 * h, -12, 6 * h], [0, 4 * h * h, -6 * h, 2 * h * h], [0, 0, 12, -6 * h], [0, 0, 0, 4 * h * h]]
    area = np.array([h / 2, h**2 / 12, h / 2, -(h**2) / 12])
    moment = np.array([3 / 20, h / 30, 7 / 20, -h / 20])
    for e in range(count):
        at = slice(2 * e, 2 * e + 4)
        for whole, part in ((M, per_length * h / 420 * np.array(m)), (K, line.bending / h**3 * np.array(k))):
            whole[at, at] += np.triu(part) + np.triu(part, 1).T
        S[at] += per_length * area
        I[at] += per_length * (e * h * area + h * h * moment)
    keep = [i for i in range(2 * count + 2) if i not in (0, 2 * count)]
    return M[np.ix_(keep, keep)], K[np.ix_(keep, keep)], S[keep], I[keep]
