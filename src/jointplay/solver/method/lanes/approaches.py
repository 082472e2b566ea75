"""Closest approaches of the lanes of an ensemble, compiled only where they are recorded.

As method.record for one trajectory.
"""

from ..interface import inner, spliced
from ..memory import MISS_ROW
from ..modes import GAP
from ..polynomial import differentiate, next_extremum, value
from . import layout as rows
from .guards import coefficients
from .memory import PART
from .radau import STAGES
from .record import note, record_within


@spliced
def _of_gap(k, j, i, contact, rising, end):
    """`rising`: sign of the guard's slope on the way to contact."""
    b, g, degree, beyond = k.b, 4 * contact + GAP, STAGES + 0 * i, 8 + 0 * i
    coefficients(k.w, 8 * (rows.WATCHES + g), k.w[8 * (rows.GUARD + g) + i], i, b)
    for n in range(STAGES + 1):
        b[8 + n] = b[n]
    degree, side = differentiate(b, degree)
    at, degree = next_extremum(b, degree, 0.0, side, end, k.stack)
    while at <= 1.0:
        if side * rising > 0.0:
            gap = value(b, beyond, STAGES + 0 * i, at, k.stack)
            record_within(k, i, j.log[j.place[rows.LOGGED], rows.COLUMNS :], at)
            note(k, j, i, float(MISS_ROW), float(contact), -rising * gap)
        side = -side
        at, degree = next_extremum(b, degree, at, side, end, k.stack)


@inner
def approaches(f, k, j, i):
    """Log closest approaches of open gaps in the step that is taken, up to its end (method.record)."""
    end = 1.0 + k.w[8 * rows.LATER + i] / k.w[8 * rows.H + i]
    for contact in range(k.contacts):
        flies = k.w[8 * (rows.SIDE + 4 * contact + GAP) + i] < 0.0
        if flies or contact >= len(k.flags):
            _of_gap(k, j, i, contact, 1.0 if flies else -1.0, end)


UNIT = {"approaches": PART}
