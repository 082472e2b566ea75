"""A lane's base point and step as one trajectory has them, with which the plain functions decide; and back.

A lane's step is a polynomial of a lower degree than a trajectory's own, which is as well known by its values
at that one's nodes: so what looks at a step there looks at one of a lane.
"""

from ..events import side_of
from ..interface import inner
from ..memory import LOGGED
from ..modes import RELEASED, mask
from ..radau import NODES
from . import layout as rows
from .lanes import matvec
from .radau import AT_NODES, MOVED_AT_NODES, STAGES


@inner
def gather(e, j, x, i):
    """Write the base point of a lane: time, state, fired guards."""
    w, speeds = e.w, 1 + e.n_q
    first = speeds + e.n - e.phases
    x.s[0] = w[8 * rows.T + i]
    for r in range(e.n_q):
        x.s[1 + r] = w[8 * (rows.POSITION + e.phases + r) + i]
    for r in range(e.n - e.phases):
        x.s[speeds + r] = w[8 * (rows.SPEED + e.phases + r) + i]
    for r in range(e.memories):
        x.s[first + r] = w[8 * (rows.MEMORY + r) + i]
    for g in range(len(x.fired)):
        x.fired[g] = int(w[8 * (rows.FIRED + g) + i])
    x.count[LOGGED] = j.place[rows.LOGGED]


@inner
def gather_guards(e, k, o, n, i):
    """Write the first n guards, where they are watched, at the nodes of the attempted step."""
    for g in range(n):
        if e.w[8 * (rows.SIDE + g) + i] == 0.0:
            continue
        k.b[0] = e.w[8 * (rows.GUARD + g) + i]
        for s in range(STAGES):
            k.b[1 + s] = e.w[8 * (rows.WATCHES + rows.GUARDS * s + g) + i]
        _spread(k, o.guards + g, AT_NODES)


@inner
def _spread(k, row, table):
    """Write values at a trajectory's nodes to a row, by those at a lane's, in the first places of b."""
    k.b[6] = k.b[7] = 0.0
    matvec(k.w, 8 * row, k.b, 0, table)


@inner
def gather_position(e, k, row, r, i):
    """Write the increments of a lane's r-th position at the nodes of the attempted step to a row."""
    h = e.w[8 * rows.H + i]
    k.b[0] = h * e.w[8 * (rows.SPEED + r) + i]
    for s in range(STAGES):
        k.b[1 + s] = h * e.w[8 * (rows.Z + rows.N * s + r) + i]
    _spread(k, row, MOVED_AT_NODES)


@inner
def gather_step(e, k, o, i):
    """Write the increments of the attempted step at its nodes: of the time, positions, speeds."""
    row = o.first + 1
    for at in range(8):
        k.w[8 * o.first + at] = e.w[8 * rows.H + i] * NODES[at]
    for r in range(e.n_q):
        gather_position(e, k, row + r, e.phases + r, i)
    k.b[0] = 0.0
    for r in range(e.n - e.phases):
        for s in range(STAGES):
            k.b[1 + s] = e.w[8 * (rows.Z + rows.N * s + e.phases + r) + i]
        _spread(k, row + e.n_q + r, AT_NODES)


@inner
def at_base(k, o):
    """Write increments of no step, which are those of the base point itself."""
    for at in range(8 * o.first, 8 * (o.first + 1 + o.n_q + o.n)):
        k.w[at] = 0.0


@inner
def scatter(e, x, i):
    """Write the state and the modes of a trajectory to a lane: masks, memories, sides of its guards."""
    w, touches, speeds = e.w, 0.0, 1 + e.n_q
    first = speeds + e.n - e.phases
    for r in range(e.n_q):
        w[8 * (rows.POSITION + e.phases + r) + i] = x.s[1 + r]
    for r in range(e.n - e.phases):
        w[8 * (rows.SPEED + e.phases + r) + i] = x.s[speeds + r]
    for r in range(e.memories):
        w[8 * (rows.MEMORY + r) + i] = x.s[first + r]
    mask(x.modes, x.m)
    for r in range(len(x.m)):
        w[8 * (rows.MASK + r) + i] = x.m[r]
    for mode in x.modes:
        touches = 1.0 if mode > RELEASED else touches
    for g in range(len(x.fired)):
        w[8 * (rows.FIRED + g) + i], w[8 * (rows.MARGIN + g) + i] = x.fired[g], x.margin[g]
        w[8 * (rows.SIDE + g) + i] = side_of(g, x.modes, x.flags)
    w[8 * rows.VARIANT + i], w[8 * rows.NEW + i] = touches, 1.0


@inner
def signed(j, x, job):
    """Sign rows that a trajectory has added to the log with its number."""
    for at in range(j.place[rows.LOGGED], x.count[LOGGED]):
        j.log[at, j.log.shape[1] - 1] = job
    j.place[rows.LOGGED] = x.count[LOGGED]
