"""What a run writes down: samples at asked times, and a log of steps, events and section points."""

from .events import state_at
from .interface import inner
from .memory import COLUMNS, LOGGED
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
def work_at(gain, b, work, out):
    """Write the work at the place whose Lagrange basis stands in b[8:]."""
    for r in range(len(work)):
        total = work[r]
        for i in range(7):
            total += b[8 + i] * gain[8 * r + i]
        out[r] = total


@inner
def write(row, time, place, w, at, s, n_x, b, modes, gain, work):
    """One record: time, state at `place` of the step whose increments begin at w[at], modes, work."""
    row[0] = time
    state_at(w, at, s, n_x, place, b, row)
    to = 1 + n_x
    for j in range(len(modes)):
        row[to + j] = modes[j]
    work_at(gain, b, work, row[to + len(modes) :])


@inner
def log(rows, count, tag, contact, kind, time, place, w, at, s, n_x, b, modes, gain, work):
    """Add a log row: what it is of, then the record."""
    row = rows[count[LOGGED]]
    row[0], row[1], row[2] = tag, contact, kind
    write(row[COLUMNS:], time, place, w, at, s, n_x, b, modes, gain, work)
    count[LOGGED] += 1


@inner
def sample(samples, times, i, h, end, w, at, s, n_x, b, modes, gain, work):
    """Asked times from number i on that lie within the step of length h, up to `end`; the next number."""
    while i < len(times) and times[i] <= end:
        write(samples[i], times[i], (times[i] - s[0]) / h, w, at, s, n_x, b, modes, gain, work)
        i += 1
    return i


@inner
def note(k, x, o, tag, contact, kind, time, place):
    """Add a row to the log."""
    at, n_x = 8 * (o.first + 1), o.n_q + o.n
    log(x.log, x.count, tag, contact, kind, time, place, k.w, at, x.s, n_x, k.b, x.modes, k.gain, x.work)
