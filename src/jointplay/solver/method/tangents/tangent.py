"""Tangents: the flow's derivative, carried along with each accepted piece and through every event.

Within a piece a tangent's stage increments solve the collocation equations linearised about the step,

    Z = h A J (d + D),    d the tangent, D its increments (Z, and Z_q = h c z + h A Z), J at each stage,

by Newton's iteration with the matrices that the step itself was solved with. At events tangents jump
(saltation). Where nothing outside keeps the time, the rate F = dx/dt is a tangent too: it is the frame's
first then, and is evaluated, not carried. What is left of the others across F grows as a section's tangents.

A tangent may also be the derivative of the state as numbers change along a direction p: its place for time
then holds the direction's number, counted from 1, and in each piece d' = (dF/dx) d + dF/dp. With it goes the
derivative of the works, whose rates are powers. Reference: Hiskens and Pai, IEEE Trans. Circuits Syst. I 47
(2000) 204-220, for such derivatives through events.
"""

from math import exp, log
from typing import NamedTuple

import numpy as np

from ..interface import inlined, inner
from ..memory import SIZE, lane_rows
from ..modes import mask
from ..polynomial import basis, integral, interpolate
from ..step import keep
from .frame import add_works, orthonormalise, size_of

ITERATIONS, ROUNDING = 40, 3e-16
SMALL = 1e-6  # of a parameter's own size: smaller changes of the state than such a change makes are nothing
TRAILING = 20.0  # how much more error is tolerated of all vectors of a frame but the leading one
RESOLVED = -1.0  # ln of a volume's growth in a piece, down to which the method gives it to rounding
# Places in Tangents.count
ROWS, SALTATION, HELD, JUMPS, SOLVES, TURNED, NEUTRAL, FOLLOWS = range(8)
# Places in Tangents.real
TRACE, VOLUME, GRAZING, THETA, TOLERANCE, NEXT, BLOCK, UNRESOLVED, ONSET, LIMIT, PIECE, SPAN = range(12)
AHEAD = 4  # columns of a row before the logarithms: time, trace, volume, unresolved time


class Tangents(NamedTuple):
    """A frame of tangents, the arrays that carry it, and its records."""

    w: np.ndarray  # lane buffer: the structure's rows, then those of its derivatives
    kept: np.ndarray  # the frame before the piece
    error: np.ndarray  # estimated error of each state of a tangent
    d: np.ndarray  # tangents: rows of a place for time and the state
    weight: np.ndarray  # 1 / scale of each state
    alive: np.ndarray  # 0: this vector's direction was lost
    norms: np.ndarray
    logs: np.ndarray  # logarithms of the growth since the start; of a neutral direction, of its length
    b: np.ndarray  # Lagrange basis
    before: np.ndarray  # rate of the state before and after an event
    after: np.ndarray
    state: np.ndarray  # before an event, as Trajectory.s
    gradient: np.ndarray  # of the guard: time, state, directions
    D: np.ndarray  # of the reset: rows of new speeds, by time and state; columns of directions; drive's work
    S: np.ndarray  # a saltation matrix, and room for a vector
    room: np.ndarray  # of the derivative of several impulses (impact_map)
    unit: np.ndarray
    count: np.ndarray
    real: np.ndarray
    small: np.ndarray  # of each vector, a size in units of the scales that is nothing; 0: there is none
    past: np.ndarray  # of each vector that is driven, its increments in the last piece, of length SPAN
    works: np.ndarray  # of each vector, derivatives of the works; then those before the piece
    powers: np.ndarray  # before an event, then after
    rows: np.ndarray  # at ends of blocks: time, trace, volume, unresolved time; logs; state


def tangents(
    frame: np.ndarray,
    scale: np.ndarray,
    n: int,
    n_rows: int,
    n_blocks: int,
    driven=(),
    units=(),
    n_powers: int = 0,
    n_s: int = 0,
) -> Tangents:
    """Allocate for the rows of `frame` (tangents, state); n speeds, `n_rows` lane rows, `n_s` numbers in s.

    `driven`: each tangent's direction, 0 of none; where there are any, `units` are sizes of the parameters,
    and `n_powers` works go with them.
    """
    k, n_x = frame.shape
    d, n_p = np.zeros((k, 1 + n_x)), int(max(driven, default=0))
    turned = n * (1 + n_x) + n_p * n_x + (1 + n_x + n_p) * (n_p > 0 and n_powers > 0)
    d[:, 1:] = frame
    small = np.zeros(k)
    if n_p:
        d[:, 0], small[k - n_p :] = driven, SMALL / np.asarray(units, dtype=float)
    return Tangents(
        w=lane_rows(n_rows),
        kept=d.ravel().copy(),
        error=np.zeros(n_x),
        d=d.ravel(),
        weight=1.0 / np.asarray(scale, dtype=float),
        alive=np.ones(k, dtype=np.int64),
        norms=np.ones(k),
        logs=np.zeros(k),
        b=lane_rows(2),
        before=np.zeros(n_x),
        after=np.zeros(n_x),
        state=np.zeros(n_s),
        gradient=np.zeros(1 + n_x + n_p),
        D=np.zeros(turned),
        S=np.zeros(n_x * n_x + n_x),
        room=np.zeros(turned + n_s + (1 + SIZE) * (2 + n_x + n_p + n)),
        unit=np.zeros(1 + n_x),
        count=np.zeros(8, dtype=np.int64),
        real=np.zeros(12),
        small=small,
        past=lane_rows(k * n_x * (n_p > 0)),
        works=np.zeros(2 * k * n_powers * (n_p > 0)),
        powers=np.zeros(2 * n_powers * (n_p > 0)),
        rows=np.zeros((n_blocks, AHEAD + k + n_x)),
    )


@inlined
def propagate(f, g, variant, k, x, o, y, h, root):
    """Take the tangents along the step in k.w, of length h, up to its place `root`.

    Give back their largest estimated error in units of what is tolerated: above 1 the piece is too long for
    them, and they have been left where they were.
    """
    n_x, w, first = o.n_q + o.n, y.w, y.count[NEUTRAL]
    width = 1 + n_x
    if first and len(y.alive) < n_x:
        for r in range(o.n_q):
            y.after[r] = x.s[1 + o.n_q + r]
        for r in range(o.n):
            y.after[o.n_q + r] = k.w[8 * (o.first + width + r) + 7]
        along(y, n_x)
        orthonormalise(y.d, width, y.weight, y.alive, y.norms, y.logs, 0.0)
    for i in range(8 * (o.first + width)):  # the factored matrices, and the state's increments
        w[i] = k.w[i]
    g.variation(variant, w, x.s, x.p, x.m)
    g.divergence(w)
    basis(root, y.b)
    trace = integral(w, len(w) - 8, h, y.b)
    y.real[THETA] = 0.0
    worst, last = 0.0, len(y.alive) - 1
    for i in range(len(y.d)):
        y.kept[i] = y.d[i]
    works = len(y.works) // 2
    for i in range(works):
        y.works[works + i] = y.works[i]
    for i in range(first, len(y.alive)):
        if y.alive[i]:
            d = y.d[i * width : (i + 1) * width]
            if not _solve(f, g, variant, k, o, y, d, i, h):
                worst = np.inf
            elif i < last or last + 1 < n_x or d[0] > 0.0:  # a whole frame's last one is known by its volume
                limit = y.real[LIMIT] * (1.0 if i == first or y.count[HELD] else TRAILING)
                worst = max(worst, _estimate(f, g, variant, k, o, y, d, i, h, limit))
            if d[0] > 0.0:
                keep(w, 8 * (o.first + 1), y.past[8 * n_x * i : 8 * n_x * (i + 1)])
            add_works(g, y, d, i, h)
            interpolate(w, 8 * (o.first + 1), d, width - n_x, n_x, y.b, d)
    if worst > 1.0:
        for i in range(len(y.d)):
            y.d[i] = y.kept[i]
        for i in range(works):
            y.works[i] = y.works[works + i]
        y.count[FOLLOWS] = 0
        return worst
    y.count[FOLLOWS], y.real[SPAN], y.real[PIECE] = 1, h, trace
    y.real[TRACE] += trace
    return worst


@inlined
def renew(f, variant, x, o, y, span):
    """Make the frame orthonormal where a piece of length `span` has ended.

    One that has the rate, and is not whole, becomes so where the next piece begins, for which the step knows
    the rate, unless a row is due here.
    """
    later = y.count[NEUTRAL] and len(y.alive) < o.n_q + o.n and x.s[0] < min(y.real[NEXT], o.t_end)
    if y.count[HELD] or later:
        return
    before = y.logs[0]
    if y.count[NEUTRAL]:
        f.trig(x.s, x.p)
        rates(f, variant, x, o, y, y.after)
        along(y, o.n_q + o.n)
    orthonormalise(y.d, 1 + o.n_q + o.n, y.weight, y.alive, y.norms, y.logs, 0.0)
    _by_volume(y, o.n_q + o.n, before, span)


@inner
def rates(f, variant, x, o, y, out):
    """Rate of the state at the base point."""
    first, n_x = o.first, o.n_q + o.n
    for i in range(8 * first, 8 * (first + 1 + n_x)):
        y.w[i] = 0.0
    mask(x.modes, x.m)
    f.rate(variant, y.w, x.s, x.p, x.m)
    for r in range(o.n_q):
        out[r] = x.s[1 + o.n_q + r]
    for r in range(o.n):
        out[o.n_q + r] = y.w[8 * (first + 1 + n_x + r) + 7]


@inner
def along(y, n_x):
    """Set the neutral direction to the rate in `y.after`; one that once stood still stays lost."""
    for r in range(n_x):
        y.d[1 + r] = y.after[r]
    y.logs[0] = 0.0 if y.alive[0] else float("-inf")


@inlined
def _estimate(f, g, variant, k, o, y, d, i, h, limit):
    """Error of the i-th tangent d whose increments are in the lane buffer, in units of the tolerance."""
    n_x, state = o.n_q + o.n, 8 * (o.first + 1)
    width, begin, end = 8 * n_x, 0.0, 0.0
    for r in range(n_x):
        begin = max(begin, abs(y.weight[r] * d[1 + r]))
        end = max(end, abs(y.weight[r] * (d[1 + r] + y.w[state + 8 * r + 6])))
        y.error[r] = d[1 + o.n_q + r] if r < o.n_q else y.w[state + width + 8 * (r - o.n_q) + 7]
    # what shrinks must be known relative to what is left; what is driven begins at nothing
    limit *= max(max(begin, end, y.small[i]) if d[0] > 0.0 else min(begin, end), 1e-300)
    size = f.estimate(variant, y.w, k.J, y.weight, y.error, h)
    if size > limit:  # again, with the error added: sharper for stiff parts (see step)
        for r in range(n_x):
            y.w[state + 8 * r + 7] = y.error[r]
        g.vary(y.w, d)
        for r in range(n_x):
            speed = d[1 + o.n_q + r] + y.w[state + 8 * (o.n_q + r) + 7] if r < o.n_q else 0.0
            y.error[r] = speed if r < o.n_q else y.w[state + width + 8 * (r - o.n_q) + 7]
        for r in range(n_x):
            y.w[state + 8 * r + 7] = 0.0
        size = f.estimate(variant, y.w, k.J, y.weight, y.error, h)
    return size / limit


@inlined
def _solve(f, g, variant, k, o, y, d, i, h):
    """Stage increments of the i-th tangent d, in the lane buffer; whether the iteration converged."""
    w, real, width = y.w, y.real, 8 * (o.n_q + o.n)
    if d[0] > 0.0 and y.count[FOLLOWS]:
        f.extrapolate(w, y.past[width * i : width * (i + 1)], 1.0, h / real[SPAN])
    else:
        f.rest(w)
    f.move(w, d, h)
    size, scale, theta = 0.0, 1.0, 0.0
    for iteration in range(ITERATIONS):
        before = size
        g.vary(w, d)
        size = f.newton(variant, w, d, k.J, y.weight, h)
        y.count[SOLVES] += 1
        if not size < 1e100:
            return False
        if iteration == 0:
            own = max(size_of(y, d, 8 * (o.first + 1)), y.small[i])
            scale = max(own if d[0] > 0.0 else 1.0, size)
        else:
            theta = size / before
        slowest = max(theta, real[THETA])  # of one operator, whichever tangent has shown it
        if size <= ROUNDING * scale:
            return True
        if 0.0 < slowest < 1.0 and slowest / (1.0 - slowest) * size <= real[TOLERANCE] * scale:
            real[THETA] = slowest
            return True
    return False


@inner
def _by_volume(y, n_x, before, span):
    """Take the last direction's growth from a whole frame's volume, where that shrinks too fast for steps.

    An implicit method takes a strongly damped direction to zero, but not at its true rate; that of the
    frame's volume is the trace's integral (Liouville). `before`: logarithm of a neutral direction's length
    where the piece began.
    """
    last, trace = len(y.alive) - 1, y.real[PIECE]
    if last + 1 < n_x or not y.alive[last] or trace > RESOLVED:
        return
    product = exp(-before) if y.count[NEUTRAL] else 1.0
    for norm in y.norms:
        product *= norm
    y.logs[last] += trace - log(product)
    y.real[UNRESOLVED] += span


@inlined
def log_block(x, y):
    """Record a row where a block ends."""
    if not x.s[0] >= y.real[NEXT]:
        return
    row, k = y.rows[y.count[ROWS]], len(y.logs)
    row[0], row[1], row[2], row[3] = x.s[0], y.real[TRACE], y.real[VOLUME], y.real[UNRESOLVED]
    for i in range(k):
        row[AHEAD + i] = y.logs[i]
    for r in range(len(y.weight)):
        row[AHEAD + k + r] = x.s[1 + r]
    y.count[ROWS] += 1
    while x.s[0] >= y.real[NEXT]:
        y.real[NEXT] += y.real[BLOCK]
