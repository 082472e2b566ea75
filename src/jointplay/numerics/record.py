"""What a run writes down: samples at asked times, and a log of steps, events and section points."""

from .events import state_at
from .interface import compiled
from .memory import COLUMNS


@compiled
def write(row, to, time, place, w, at, s, n_x, b, modes, work):
    """One record: time, state at `place` of the step whose increments begin at w[at], modes, work."""
    row[to] = time
    state_at(w, at, s, n_x, place, b, row, to + 1)
    to += 1 + n_x
    for j in range(len(modes)):
        row[to + j] = modes[j]
    to += len(modes)
    for i in range(len(work)):
        row[to + i] = work[i]


@compiled
def log(row, tag, contact, kind, time, place, w, at, s, n_x, b, modes, work):
    """A log row: what it is of, then the record."""
    row[0], row[1], row[2] = tag, contact, kind
    write(row, COLUMNS, time, place, w, at, s, n_x, b, modes, work)


@compiled
def sample(samples, times, i, h, end, w, at, s, n_x, b, modes, work):
    """Asked times from number i on that lie within the step of length h, up to `end`; the next number."""
    while i < len(times) and times[i] <= end:
        write(samples[i], 0, times[i], (times[i] - s[0]) / h, w, at, s, n_x, b, modes, work)
        i += 1
    return i
