"""A function of one lane with all that such functions may contain, for its compiled form to be tested."""

from math import copysign, cos, sqrt

from jointplay.solver.method.control import bounded
from jointplay.solver.method.events import level_of
from jointplay.solver.method.interface import compiled as marked
from jointplay.solver.method.lanes.attempts import solved
from jointplay.solver.method.lanes.lanewise import lanewise

SHARE = 0.25


@marked
def root(x):
    """A function with a loop, which is called lane by lane."""
    y = max(x, 1.0)
    for _ in range(9):
        y = 0.5 * (y + x / y)
    return y


def written(w, i):
    """Rows 0 to 3 are read, the others written."""
    a, b, c, d = w[0 + i], w[8 + i], w[16 + i], w[24 + i]
    w[32 + i] = a + b
    w[40 + i] = a - b / c
    w[48 + i] = -a * SHARE
    w[56 + i] = sqrt(abs(b))
    w[64 + i] = abs(a)
    w[72 + i] = min(a, b)
    w[80 + i] = max(a, min(c, d), b)
    w[88 + i] = a if a > b else c
    w[96 + i] = 1.0 if a != b else 2.0
    w[104 + i] = 1.0 if 0.0 <= a < b or c == d else w[32 + i]
    w[112 + i] = cos(c)
    w[120 + i] = abs(c) ** d
    w[128 + i] = level_of(a, b, c, d)
    w[136 + i] = bounded(a, b, c, d)
    w[144 + i] = 1.0 if solved(abs(a), abs(c), abs(d)) else 0.0
    a, b = b, a
    w[152 + i] = a - 2 * b
    w[160 + i] = w[168 + i] = c
    w[176 + i] = root(abs(c)) + copysign(1.0, a)


looped = lanewise(written)
