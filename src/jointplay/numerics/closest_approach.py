"""Closest approaches in flight: where a gap that stays open is smallest.

As a parameter changes, one of them reaches zero and a new contact begins (grazing). They are extrema of the
step's polynomial, found as its derivative's roots, so that none is stepped over.
"""

from jointplay.numerics.interface import inner
from jointplay.numerics.memory import MISS_ROW
from jointplay.numerics.modes import FREE, GAP
from jointplay.numerics.polynomial import basis, bernstein, next_extremum
from jointplay.numerics.record import note


@inner
def misses(k, x, o, h, end):
    """Log the closest approaches of every open gap within the step of length h, up to its place `end`."""
    for g in range(len(x.fired)):
        j, row = g // 4, 8 * (o.guards + g)
        wall = g - 4 * len(x.flags)
        if wall >= 0:
            if x.modes[len(x.flags) + wall] == FREE:
                _of_gap(k, x, o, h, end, row, -1.0, wall)
        elif x.modes[j] == FREE and g % 4 == GAP:
            _of_gap(k, x, o, h, end, row, 1.0, j)


@inner
def _of_gap(k, x, o, h, end, row, rising, contact):
    """`rising`: sign of the guard's slope on the way to contact. The gap goes where events have kinds."""
    b, whole = k.b, 0 * o.n  # no root is divided out; a variable, for the reason that interface gives
    degree = bernstein(k.w, row, whole, b) - 1
    for i in range(degree + 1):
        b[i] = b[i + 1] - b[i]
    side = 1 if b[0] > 0.0 else -1
    at, degree = next_extremum(b, degree, 0.0, side, end, k.stack)
    while at <= 1.0:
        if side * rising > 0.0 and x.s[0] + h * at >= o.log_from:
            basis(at, b)
            gap = 0.0
            for i in range(8):
                gap += b[8 + i] * k.w[row + i]
            note(k, x, o, MISS_ROW, float(contact), -rising * gap, x.s[0] + h * at, at)
        side = -side
        at, degree = next_extremum(b, degree, at, side, end, k.stack)
