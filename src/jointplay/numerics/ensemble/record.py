"""What the lanes of an ensemble write down: events, section points, closest approaches, starts and ends."""

from ..interface import inner
from . import layout as c
from .radau import MONOMIAL, STAGES


@inner
def note(k, j, i, tag, contact, kind):
    """Head the next log row, whose record is written, by trajectory, tag, contact and kind."""
    row = j.log[j.place[c.LOGGED]]
    row[0], row[1], row[2], row[3] = k.whole[8 * c.JOB + i], tag, contact, kind
    j.place[c.LOGGED] += 1


@inner
def record(k, i, row):
    """Time, angles, speeds, mode at the base point."""
    w = k.w
    for r in range(c.N):
        row[1 + r], row[1 + c.N + r] = w[8 * (c.POSITION + r) + i], w[8 * (c.SPEED + r) + i]
    row[0], row[1 + 2 * c.N] = w[8 * c.T + i], k.whole[8 * c.MODE + i]


@inner
def record_end(k, i, row, later):
    """The same `later` than the step's end, by Taylor's series."""
    w = k.w
    for r in range(c.N):
        z, a = w[8 * (c.Y + r) + i], w[8 * (c.RATE + r) + i]
        row[1 + r] = w[8 * (c.POSITION + r) + i] + w[8 * (c.X + r) + i] + (z + 0.5 * a * later) * later
        row[1 + c.N + r] = z + a * later
    row[0], row[1 + 2 * c.N] = w[8 * c.T + i] + (w[8 * c.H + i] + later), k.whole[8 * c.MODE + i]


@inner
def record_within(k, i, row, place):
    """The same at a place of the step, by the stages' polynomial."""
    w, h = k.w, k.w[8 * c.H + i]
    for r in range(c.N):
        z0, z, moved, power = w[8 * (c.SPEED + r) + i], 0.0, 0.0, 1.0
        for n in range(STAGES):
            power *= place
            for s in range(STAGES):
                part = MONOMIAL[n, s] * w[8 * (c.Z + c.N * s + r) + i] * power
                z += part
                moved += part * place / (n + 2)
        row[1 + r] = w[8 * (c.POSITION + r) + i] + h * (place * z0 + moved)
        row[1 + c.N + r] = z0 + z
    row[0], row[1 + 2 * c.N] = w[8 * c.T + i] + h * place, k.whole[8 * c.MODE + i]
