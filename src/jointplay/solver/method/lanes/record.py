"""Records of the lanes of an ensemble: events, section points, closest approaches, starts and ends."""

from ..interface import inner
from . import layout as rows
from .radau import MONOMIAL, STAGES


@inner
def note(k, j, i, tag, contact, kind):
    """Head the next log row, whose record is written, by trajectory, tag, contact and kind."""
    row = j.log[j.place[rows.LOGGED]]
    row[0], row[1], row[2], row[3] = k.whole[8 * rows.JOB + i], tag, contact, kind
    j.place[rows.LOGGED] += 1


@inner
def record(k, i, row):
    """Time, positions, speeds, memories, modes at the base point."""
    w = k.w
    for r in range(k.n):
        row[1 + r], row[1 + k.n + r] = w[8 * (rows.POSITION + r) + i], w[8 * (rows.SPEED + r) + i]
    row[0] = w[8 * rows.T + i]
    _lasting(k, i, row)


@inner
def _lasting(k, i, row):
    """Write the values that stay the same between events: memories and modes."""
    at = 1 + 2 * k.n
    for r in range(k.memories):
        row[at + r] = k.w[8 * (rows.MEMORY + r) + i]
    for c in range(k.contacts):
        row[at + k.memories + c] = k.whole[8 * (rows.MODE + c) + i]


@inner
def record_end(k, i, row, later):
    """Time, state, modes `later` than the step's end, by Taylor's series."""
    w = k.w
    for r in range(k.n):
        z, a = w[8 * (rows.Y + r) + i], w[8 * (rows.RATE + r) + i]
        row[1 + r] = w[8 * (rows.POSITION + r) + i] + w[8 * (rows.X + r) + i] + (z + 0.5 * a * later) * later
        row[1 + k.n + r] = z + a * later
    row[0] = w[8 * rows.T + i] + (w[8 * rows.H + i] + later)
    _lasting(k, i, row)


@inner
def record_within(k, i, row, place):
    """Time, state, modes at a place of the step, by the stages' polynomial."""
    w, h = k.w, k.w[8 * rows.H + i]
    for r in range(k.n):
        z0, z, moved, power = w[8 * (rows.SPEED + r) + i], 0.0, 0.0, 1.0
        for n in range(STAGES):
            power *= place
            for s in range(STAGES):
                part = MONOMIAL[n, s] * w[8 * (rows.Z + rows.N * s + r) + i] * power
                z += part
                moved += part * place / (n + 2)
        row[1 + r] = w[8 * (rows.POSITION + r) + i] + h * (place * z0 + moved)
        row[1 + k.n + r] = z0 + z
    row[0] = w[8 * rows.T + i] + h * place
    _lasting(k, i, row)
