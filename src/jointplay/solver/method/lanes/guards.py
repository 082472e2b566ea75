"""Guards and the section of one lane of an ensemble: where the step's polynomial has them leave their side.

As method.events for one trajectory, with the margins that guards have there; polynomials are of degree 5.
"""

from ..events import leaving, level_of, root_level
from ..interface import inner
from ..modes import CONE, FORCE
from ..polynomial import first_root
from . import layout as rows
from .radau import NODES, STAGES, TO_BERNSTEIN, A


@inner
def coefficients(w, at, start, i, b):
    """Bernstein coefficients of a value that is `start` at the base, and at w[at] at the first stage."""
    for n in range(STAGES + 1):
        b[n] = TO_BERNSTEIN[n, 0] * start
        for s in range(STAGES):
            b[n] += TO_BERNSTEIN[n, s + 1] * w[at + 8 * rows.GUARDS * s + i]
    b[0], b[STAGES] = start, w[at + 8 * rows.GUARDS * (STAGES - 1) + i]


@inner
def margin(w, i, g):
    """Margin of guard g: values up to it are within the tolerance of zero."""
    if g % 4 == CONE:
        return w[8 * (rows.CONE + g // 4) + i] * abs(w[8 * (rows.GUARD + g - CONE + FORCE) + i])
    return w[8 * (rows.MARGIN + g) + i]


@inner
def level(w, i, g):
    """The level that guard g is to leave."""
    start, side = w[8 * (rows.GUARD + g) + i], w[8 * (rows.SIDE + g) + i]
    return level_of(start, side, w[8 * (rows.FIRED + g) + i], margin(w, i, g))


@inner
def first(w, b, stack, contacts, i, doubt):
    """The guard that first leaves its side, and where in [0, 1]; -1 and 2.0 if none."""
    which, earliest = -1, 2.0
    for g in range(4 * contacts):
        side = w[8 * (rows.SIDE + g) + i]
        if side != 0.0:
            least = level(w, i, g) - side * doubt * margin(w, i, g)
            coefficients(w, 8 * (rows.WATCHES + g), w[8 * (rows.GUARD + g) + i], i, b)
            place = leaving(b, STAGES + 0 * g, int(side), least, stack)
            if place < earliest:
                which, earliest = g, place
    return which, earliest


@inner
def level_to_leave(w, b, i, g, place):
    """Level whose crossing near `place` is located (events.root_level)."""
    least, side = level(w, i, g), w[8 * (rows.SIDE + g) + i]
    if least == 0.0:
        return least
    coefficients(w, 8 * (rows.WATCHES + g), w[8 * (rows.GUARD + g) + i], i, b)
    return root_level(b, STAGES + 0 * g, side, place, least, margin(w, i, g))


@inner
def passing(w, b, stack, crank, i, end):
    """Place up to `end` where the crank passes the section's level; 2.0 if it does not."""
    h, at = w[8 * rows.H + i], 8 * crank + i
    if not w[8 * rows.CROSSED + i] >= 0.0:
        return 2.0
    start = w[8 * rows.POSITION + at] - w[8 * rows.AHEAD + i]
    for n in range(STAGES + 1):
        b[n] = start * TO_BERNSTEIN[n, 0]
    for s in range(STAGES):
        x = NODES[s] * w[8 * rows.SPEED + at]
        for n in range(STAGES):
            x += A[s, n] * w[8 * (rows.Z + rows.N * n) + at]
        for n in range(STAGES + 1):
            b[n] += TO_BERNSTEIN[n, s + 1] * (start + h * x)
    b[0], b[STAGES] = start, start + w[8 * rows.X + at]
    place = first_root(b, STAGES + 0 * i, -int(w[8 * rows.DIRECTION + i]), stack)
    return place if place <= end else 2.0
