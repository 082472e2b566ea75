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
def gather(lanes, jobs, motion, i):
    """Write the base point of a lane: time, state, fired guards."""
    w, speeds = lanes.w, 1 + lanes.n_q
    first = speeds + lanes.n - lanes.phases
    motion.s[0] = w[8 * rows.T + i]
    for r in range(lanes.n_q):
        motion.s[1 + r] = w[8 * (rows.POSITION + lanes.phases + r) + i]
    for r in range(lanes.n - lanes.phases):
        motion.s[speeds + r] = w[8 * (rows.SPEED + lanes.phases + r) + i]
    for r in range(lanes.memories):
        motion.s[first + r] = w[8 * (rows.MEMORY + r) + i]
    for g in range(len(motion.fired)):
        motion.fired[g] = int(w[8 * (rows.FIRED + g) + i])
    motion.count[LOGGED] = jobs.place[rows.LOGGED]


@inner
def gather_guards(lanes, work, options, n, i):
    """Write the first n guards, where they are watched, at the nodes of the attempted step."""
    for g in range(n):
        if lanes.w[8 * (rows.SIDE + g) + i] == 0.0:
            continue
        work.b[0] = lanes.w[8 * (rows.GUARD + g) + i]
        for s in range(STAGES):
            work.b[1 + s] = lanes.w[8 * (rows.WATCHES + rows.GUARDS * s + g) + i]
        _spread(work, options.guards + g, AT_NODES)


@inner
def _spread(work, row, table):
    """Write values at a trajectory's nodes to a row, by those at a lane's, in the first places of b."""
    work.b[6] = work.b[7] = 0.0
    matvec(work.w, 8 * row, work.b, 0, table)


@inner
def gather_position(lanes, work, row, r, i):
    """Write the increments of a lane's r-th position at the nodes of the attempted step to a row."""
    h = lanes.w[8 * rows.H + i]
    work.b[0] = h * lanes.w[8 * (rows.SPEED + r) + i]
    for s in range(STAGES):
        work.b[1 + s] = h * lanes.w[8 * (rows.Z + rows.N * s + r) + i]
    _spread(work, row, MOVED_AT_NODES)


@inner
def gather_step(lanes, work, options, i):
    """Write the increments of the attempted step at its nodes: of the time, positions, speeds."""
    row = options.first + 1
    for at in range(8):
        work.w[8 * options.first + at] = lanes.w[8 * rows.H + i] * NODES[at]
    for r in range(lanes.n_q):
        gather_position(lanes, work, row + r, lanes.phases + r, i)
    work.b[0] = 0.0
    for r in range(lanes.n - lanes.phases):
        for s in range(STAGES):
            work.b[1 + s] = lanes.w[8 * (rows.Z + rows.N * s + lanes.phases + r) + i]
        _spread(work, row + lanes.n_q + r, AT_NODES)


@inner
def at_base(work, options):
    """Write increments of no step, which are those of the base point itself."""
    for at in range(8 * options.first, 8 * (options.first + 1 + options.n_q + options.n)):
        work.w[at] = 0.0


@inner
def scatter(lanes, motion, i):
    """Write the state and the modes of a trajectory to a lane: masks, memories, sides of its guards."""
    w, touches, speeds = lanes.w, 0.0, 1 + lanes.n_q
    first = speeds + lanes.n - lanes.phases
    for r in range(lanes.n_q):
        w[8 * (rows.POSITION + lanes.phases + r) + i] = motion.s[1 + r]
    for r in range(lanes.n - lanes.phases):
        w[8 * (rows.SPEED + lanes.phases + r) + i] = motion.s[speeds + r]
    for r in range(lanes.memories):
        w[8 * (rows.MEMORY + r) + i] = motion.s[first + r]
    mask(motion.modes, motion.m)
    for r in range(len(motion.m)):
        w[8 * (rows.MASK + r) + i] = motion.m[r]
    for mode in motion.modes:
        touches = 1.0 if mode > RELEASED else touches
    for g in range(len(motion.fired)):
        w[8 * (rows.FIRED + g) + i], w[8 * (rows.MARGIN + g) + i] = motion.fired[g], motion.margin[g]
        w[8 * (rows.SIDE + g) + i] = side_of(g, motion.modes, motion.flags)
    w[8 * rows.VARIANT + i], w[8 * rows.NEW + i] = touches, 1.0


@inner
def signed(jobs, motion, job):
    """Sign rows that a trajectory has added to the log with its number."""
    for at in range(jobs.place[rows.LOGGED], motion.count[LOGGED]):
        jobs.log[at, jobs.log.shape[1] - 1] = job
    jobs.place[rows.LOGGED] = motion.count[LOGGED]
