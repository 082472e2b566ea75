"""What a run writes down: samples at asked times, and a log of steps, events and section points."""

from .events import state_at
from .interface import inner
from .memory import COLUMNS, DOUBT_ROW, LOGGED
from .radau import COLLOCATION, ERROR, GAMMA

KEPT = 0.5  # share of a decay that the polynomial keeps at most, soon after the step's beginning
MISSED = 0.15  # times h / gamma and the slope's error at the beginning: largest error between the stages


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


@inner
def doubtful(k, x, o, h):
    """Whether rates of angles on the step of length h may be off by more than is tolerated (o.sharp).

    At its base point the rate differs from the polynomial's slope. What of that the error's filter
    (I - h J / gamma)^-1 takes away is the rate of components that the step passes over: decays, of which the
    polynomial keeps a part. Between the stages it also misses the slow motion of these components, by a
    share of h times that difference, and rates by as many times more as the filter made it smaller.
    """
    at, span = 8 * (o.first + 1 + o.n_q), h / GAMMA
    for r in range(o.n):
        slope = k.w[at + 8 * (o.n + r) + 7]
        for i in range(7):
            slope += ERROR[i] * k.w[at + 8 * r + i] / span
        slow = k.error[o.n_q + r] / span
        off = x.turning[r] * abs(slope - slow) * max(KEPT * abs(slow), MISSED * abs(slope))
        if off * k.weight[o.n_q + r] > o.sharp * abs(slow):
            return True
    return False


@inner
def doubt(k, x, o, end):
    """Note a step that is doubtful: its base point, what guards fired there (a number to base 3), its end."""
    fired, digit = 0.0, 1.0
    for g in range(len(x.fired)):
        fired += digit * x.fired[g]
        digit *= 3.0
    note(k, x, o, DOUBT_ROW, fired, end, x.s[0], 0.0)
