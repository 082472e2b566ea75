"""The base point of a lane of an ensemble as method.modes and method.walls.walls take it, and back."""

from ..control import close_events, restarted
from ..interface import inlined, inner
from ..memory import EVENT_ROW
from ..modes import GAP, PULLS, RELEASED, inside, mask
from . import layout as rows
from .attempts import begin
from .record import note, record


@inner
def _first_memory(k):
    """Index of the memories in a trajectory's state, which has no phases: behind positions and speeds."""
    return 1 + k.n_q + k.n - k.phases


@inner
def gather(f, k, i):
    """The base point of a lane, as method.modes takes it."""
    w, speeds = k.w, 1 + k.n_q
    k.s[0] = w[8 * rows.T + i]
    for r in range(k.n_q):
        k.s[1 + r] = w[8 * (rows.POSITION + k.phases + r) + i]
    for r in range(k.n - k.phases):
        k.s[speeds + r] = w[8 * (rows.SPEED + k.phases + r) + i]
    first = _first_memory(k)
    for r in range(k.memories):
        k.s[first + r] = w[8 * (rows.MEMORY + r) + i]
    for r in range(len(k.p)):
        k.p[r] = w[8 * (rows.NUMBERS + r) + i]
    for c in range(len(k.modes)):
        k.modes[c] = k.whole[8 * (rows.MODE + c) + i]
    if k.phases > 0:
        f.trig(k.s, k.p)
    else:
        _gather_angles(k, i, first + k.memories)


@inner
def _gather_angles(k, i, first):
    a, angles = 0, (len(k.s) - first) // 2
    for r in range(k.n):
        if k.turning[r] != 0.0:
            k.s[first + a] = k.w[8 * (rows.SINE + r) + i]
            k.s[first + angles + a] = k.w[8 * (rows.COSINE + r) + i]
            a += 1


@inner
def scatter(k, i):
    """The modes that a lane has now: masks, memories, and the sides of its guards."""
    w, touches, first = k.w, 0.0, _first_memory(k)
    mask(k.modes, k.m)
    for r in range(3 * k.contacts):
        w[8 * (rows.MASK + r) + i] = k.m[r]
    for r in range(k.memories):
        w[8 * (rows.MEMORY + r) + i] = k.s[first + r]
    for c in range(len(k.flags), k.contacts):
        w[8 * (rows.SIDE + 4 * c + GAP) + i] = 1.0
    for c in range(len(k.flags)):
        mode, pulls = k.modes[c], k.flags[c] & PULLS
        k.whole[8 * (rows.MODE + c) + i] = mode
        for g in range(4):
            w[8 * (rows.SIDE + 4 * c + g) + i] = inside(mode, g, pulls)
        touches = 1.0 if mode > RELEASED else touches
    w[8 * rows.VARIANT + i] = touches
    w[8 * rows.NEW + i] = 1.0


@inner
def settings(real):
    """Options of a run that method.walls.walls needs."""
    return rows.Settings(real[rows.J_NEAR], real[rows.J_REST], real[rows.J_HOP], real[rows.J_PLAY])


@inner
def _restart(k, i):
    """Length of the first step after an event: that which served the last one into the same mode."""
    w, variant = k.w, int(k.w[8 * rows.VARIANT + i])
    served, kept = w[8 * (rows.H_VARIANT + variant) + i], k.real[8 * (rows.H_START + variant) + i]
    h = restarted(w[8 * rows.H_CONTROL + i], served, kept)
    w[8 * rows.SMOOTH + i], w[8 * rows.REJECTION + i], w[8 * rows.H_BEFORE + i] = 0.0, 0.0, 0.0
    w[8 * rows.H_LIMIT + i], w[8 * rows.ODD + i], w[8 * rows.H_CONTROL + i] = 1e300, 1.0, h
    begin(k, i, h)
    w[8 * rows.H + i] = w[8 * rows.H_NEXT + i]
    k.whole[8 * rows.FRESH + i] = 1


@inlined
def begin_event(f, k, j, i):
    """Count and record an event of a lane, and gather its base point."""
    w, job, t = k.w, k.whole[8 * rows.JOB + i], k.w[8 * rows.T + i]
    real, later = j.real[job], t - k.real[8 * rows.T_EVENT + i]
    k.whole[8 * rows.CLOSE + i] = close_events(k.whole[8 * rows.CLOSE + i], later, real[rows.J_NEAR])
    k.real[8 * rows.T_EVENT + i] = t
    j.count[job, rows.C_EVENTS] += 1
    if j.whole[job, rows.J_EVENTS]:
        record(k, i, j.log[j.place[rows.LOGGED], rows.COLUMNS :])
        note(k, j, i, float(EVENT_ROW), 0.0, 0.0)
    gather(f, k, i)
    for g in range(4 * len(k.flags)):
        k.fired[g] = int(w[8 * (rows.FIRED + g) + i])


@inlined
def end_event(k, j, i, c, kind):
    """Scatter the changes of a lane at contact c, and start anew."""
    if j.whole[k.whole[8 * rows.JOB + i], rows.J_EVENTS]:
        row = j.log[j.place[rows.LOGGED] - 1]
        row[2], row[3] = c, kind
    for g in range(4 * len(k.flags)):
        k.w[8 * (rows.FIRED + g) + i] = k.fired[g]
    scatter(k, i)
    _restart(k, i)
