"""Records of a run: samples at given times; a log of steps, events, sections and closest approaches.

As a parameter changes, a closest approach in flight reaches zero and a new contact begins (grazing). They are
extrema of the step's polynomial, found as its derivative's roots, so that none is stepped over.
"""

from .events import state_at
from .interface import inner
from .memory import COLUMNS, LOGGED, MISS_ROW
from .modes import FREE, GAP
from .polynomial import basis, bernstein, differentiate, interpolate, next_extremum
from .radau import COLLOCATION


@inner
def gains(w, row, h, gain):
    """Increments h A P of the work at the stages of a step, its powers P in lane rows from `row` on."""
    for r in range(len(gain) // 8):
        for i in range(8):
            total = 0.0
            for j in range(7):
                total += COLLOCATION[8 * j + i] * w[8 * (row + r) + j]
            gain[8 * r + i] = h * total


@inner
def write(row, time, place, w, at, s, n_x, b, modes, gain, work):
    """One record: time, state at `place` of the step whose increments begin at w[at], modes, work."""
    row[0] = time
    state_at(w, at, s, n_x, place, b, row)
    to = 1 + n_x
    for j in range(len(modes)):
        row[to + j] = modes[j]
    start = 0 * n_x  # a variable, for the reason that interface gives
    interpolate(gain, start, work, start, len(work), b, row[to + len(modes) :])


@inner
def sample(samples, times, i, h, end, w, at, s, n_x, b, modes, gain, work):
    """Samples at given times from number i on within the step of length h, up to `end`; the next number."""
    while i < len(times) and times[i] <= end:
        write(samples[i], times[i], (times[i] - s[0]) / h, w, at, s, n_x, b, modes, gain, work)
        i += 1
    return i


@inner
def note(work, motion, options, tag, contact, kind, time, place):
    """Add a log row: its tag, contact and kind, then the record."""
    row, at, n_x = motion.log[motion.count[LOGGED]], 8 * (options.first + 1), options.n_q + options.n
    row[0], row[1], row[2] = tag, contact, kind
    write(row[COLUMNS:], time, place, work.w, at, motion.s, n_x, work.b, motion.modes, work.gain, motion.work)
    motion.count[LOGGED] += 1


@inner
def closest_approaches(work, motion, options, h, end):
    """Log the closest approaches of every open gap within the step of length h, up to its place `end`."""
    modes, contacts = motion.modes, len(motion.flags)
    for g in range(len(motion.fired)):
        j, row = g // 4, 8 * (options.guards + g)
        wall = g - 4 * contacts
        if wall >= 0:
            if wall < len(modes) - contacts and modes[contacts + wall] == FREE:
                _of_gap(work, motion, options, h, end, row, -1.0, contacts + wall)
        elif modes[j] == FREE and g % 4 == GAP:
            _of_gap(work, motion, options, h, end, row, 1.0, j)


@inner
def _of_gap(work, motion, options, h, end, row, rising, contact):
    """`rising`: sign of the guard's slope on the way to contact. The gap goes where events have kinds."""
    b = work.b
    whole = 0 * options.n  # no root is divided out; a variable, for the reason that interface gives
    degree, side = differentiate(b, bernstein(work.w, row, whole, b))
    at, degree = next_extremum(b, degree, 0.0, side, end, work.stack)
    while at <= 1.0:
        if side * rising > 0.0 and motion.s[0] + h * at >= options.log_from:
            basis(at, b)
            gap = 0.0
            for i in range(8):
                gap += b[8 + i] * work.w[row + i]
            note(work, motion, options, MISS_ROW, float(contact), -rising * gap, motion.s[0] + h * at, at)
        side = -side
        at, degree = next_extremum(b, degree, at, side, end, work.stack)
