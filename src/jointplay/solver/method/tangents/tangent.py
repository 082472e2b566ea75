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

A frame of tangent vectors: made orthonormal again and again, its growth and works added up.

Vectors are rows of a flat array (a place for time, which no tangent uses, then the state) and are measured in
units of the state's scales. Reference: Benettin et al. (1980); modified Gram-Schmidt, a second time where
the first took most of a vector away (Giraud et al. 2005).
"""

from math import exp, log, sqrt
from typing import NamedTuple

import numpy as np

from ..interface import compiled, inlined, inner
from ..memory import SIZE, lane_rows
from ..modes import mask
from ..polynomial import basis, integral, interpolate
from ..step import keep

ITERATIONS, ROUNDING = 40, 3e-16
SMALL = 1e-6  # of a parameter's own size: smaller changes of the state than such a change makes are nothing
TRAILING = 20.0  # how much more error is tolerated of all vectors of a frame but the leading one
RESOLVED = -1.0  # ln of a volume's growth in a piece, down to which the method gives it to rounding
# Places in Tangents.count
ROWS = 0  # recorded
SALTATION = 1  # 0: jumps at events are left out
HELD = 2  # 1: the frame is kept as it comes out, and never made orthonormal
JUMPS, SOLVES = 3, 4  # events gone through; updates of the iteration
RESET = 5  # kind of reset at the event: 1 a wall is met, ENTERS and MAY_LEAVE of saltation; 0 none
NEUTRAL = 6  # 1: the first tangent is the rate of the state, which is evaluated
CONTINUES = 7  # 1: a tangent that is driven may be extrapolated from the piece before
# Places in Tangents.real
TRACE, VOLUME = 0, 1  # since the start: integral of the rate's divergence; ln |det S| of the jumps
GRAZING = 2  # smallest approach speed of a guard at an event, relative to its terms
THETA = 3  # slowest contraction that the iteration has shown in this piece
TOLERANCE, LIMIT = 4, 9  # of the iteration, and of the estimated error, relative to a tangent's length
NEXT, BLOCK = 5, 6  # time of the next row; time between rows
UNRESOLVED = 7  # time in which the last direction's growth is taken from the volume
STUCK_BEFORE = 8  # contacts that stuck before the event
PIECE_TRACE, PIECE_LENGTH = 10, 11  # of the last piece: its part of TRACE; the length of its step
AHEAD = 4  # columns of a row before the logarithms: time, trace, volume, unresolved time

AGAIN = 0.05  # share of its length that a vector must keep to need no second pass: rounding grows 20 fold
LOST = 1e-9  # share below which a jump of lower rank has taken a vector's own direction away


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
    room: np.ndarray  # of the derivative of several impulses, or of a map across several walls (saltation)
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
        room=np.zeros(max(turned + n_s + (1 + SIZE) * (2 + n_x + n_p + n), 2 * n_x * (n_x + n_p))),
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
def propagate(functions, derivatives, variant, work, motion, options, tangents, h, root):
    """Take the tangents along the step in work.w, of length h, up to its place `root`.

    Give back their largest estimated error in units of what is tolerated: above 1 the piece is too long for
    them, and they have been left where they were.
    """
    n_x, w, first = options.n_q + options.n, tangents.w, tangents.count[NEUTRAL]
    width = 1 + n_x
    if first and len(tangents.alive) < n_x:
        for r in range(options.n_q):
            tangents.after[r] = motion.s[1 + options.n_q + r]
        for r in range(options.n):
            tangents.after[options.n_q + r] = work.w[8 * (options.first + width + r) + 7]
        along(tangents, n_x)
        orthonormal(tangents, width, 0.0)
    for i in range(8 * (options.first + width)):  # the factored matrices, and the state's increments
        w[i] = work.w[i]
    derivatives.variation(variant, w, motion.s, motion.p, motion.m)
    derivatives.divergence(w)
    basis(root, tangents.b)
    trace = integral(w, len(w) - 8, h, tangents.b)
    tangents.real[THETA] = 0.0
    worst, last = 0.0, len(tangents.alive) - 1
    for i in range(len(tangents.d)):
        tangents.kept[i] = tangents.d[i]
    works = len(tangents.works) // 2
    for i in range(works):
        tangents.works[works + i] = tangents.works[i]
    for i in range(first, len(tangents.alive)):
        if tangents.alive[i]:
            d = tangents.d[i * width : (i + 1) * width]
            if not _solve(functions, derivatives, variant, work, options, tangents, d, i, h):
                worst = np.inf
            elif i < last or last + 1 < n_x or d[0] > 0.0:  # a whole frame's last one is known by its volume
                limit = tangents.real[LIMIT] * (1.0 if i == first or tangents.count[HELD] else TRAILING)
                error = _estimate(functions, derivatives, variant, work, options, tangents, d, i, h, limit)
                worst = max(worst, error)
            if d[0] > 0.0:
                keep(w, 8 * (options.first + 1), tangents.past[8 * n_x * i : 8 * n_x * (i + 1)])
            add_works(derivatives, tangents, d, i, h)
            interpolate(w, 8 * (options.first + 1), d, width - n_x, n_x, tangents.b, d)
    if worst > 1.0:
        for i in range(len(tangents.d)):
            tangents.d[i] = tangents.kept[i]
        for i in range(works):
            tangents.works[i] = tangents.works[works + i]
        tangents.count[CONTINUES] = 0
        return worst
    tangents.count[CONTINUES], tangents.real[PIECE_LENGTH], tangents.real[PIECE_TRACE] = 1, h, trace
    tangents.real[TRACE] += trace
    return worst


@inlined
def renew(functions, variant, motion, options, tangents, span):
    """Make the frame orthonormal where a piece of length `span` has ended.

    One that has the rate, and is not whole, becomes so where the next piece begins, for which the step knows
    the rate, unless a row is due here.
    """
    n_x, neutral = options.n_q + options.n, tangents.count[NEUTRAL]
    between = motion.s[0] < min(tangents.real[NEXT], options.t_end)
    if tangents.count[HELD] or (neutral and len(tangents.alive) < n_x and between):
        return
    before = tangents.logs[0]
    if neutral:
        functions.trig(motion.s, motion.p)
        rates(functions, variant, motion, options, tangents, tangents.after)
        along(tangents, n_x)
    orthonormal(tangents, 1 + n_x, 0.0)
    _by_volume(tangents, n_x, before, span)


@inner
def rates(functions, variant, motion, options, tangents, out):
    """Rate of the state at the base point."""
    first, n_x = options.first, options.n_q + options.n
    for i in range(8 * first, 8 * (first + 1 + n_x)):
        tangents.w[i] = 0.0
    mask(motion.modes, motion.m)
    functions.rate(variant, tangents.w, motion.s, motion.p, motion.m)
    for r in range(options.n_q):
        out[r] = motion.s[1 + options.n_q + r]
    for r in range(options.n):
        out[options.n_q + r] = tangents.w[8 * (first + 1 + n_x + r) + 7]


@inner
def along(tangents, n_x):
    """Set the neutral direction to the rate in `tangents.after`; one that once stood still stays lost."""
    for r in range(n_x):
        tangents.d[1 + r] = tangents.after[r]
    tangents.logs[0] = 0.0 if tangents.alive[0] else float("-inf")


@inlined
def _estimate(functions, derivatives, variant, work, options, tangents, d, i, h, limit):
    """Error of the i-th tangent d whose increments are in the lane buffer, in units of the tolerance."""
    w, n_q, n_x, state = tangents.w, options.n_q, options.n_q + options.n, 8 * (options.first + 1)
    rate, begin, end = state + 8 * (n_x - n_q), 0.0, 0.0
    for r in range(n_x):
        begin = max(begin, abs(tangents.weight[r] * d[1 + r]))
        end = max(end, abs(tangents.weight[r] * (d[1 + r] + w[state + 8 * r + 6])))
        tangents.error[r] = d[1 + n_q + r] if r < n_q else w[rate + 8 * r + 7]
    # what shrinks must be known relative to what is left; what is driven begins at nothing
    limit *= max(max(begin, end, tangents.small[i]) if d[0] > 0.0 else min(begin, end), 1e-300)
    size = functions.estimate(variant, w, work.J, tangents.weight, tangents.error, h)
    if size > limit:  # again, with the error added: sharper for stiff parts (see step)
        for r in range(n_x):
            w[state + 8 * r + 7] = tangents.error[r]
        derivatives.vary(w, d)
        for r in range(n_x):
            speed = d[1 + n_q + r] + w[state + 8 * (n_q + r) + 7] if r < n_q else 0.0
            tangents.error[r] = speed if r < n_q else w[rate + 8 * r + 7]
        for r in range(n_x):
            w[state + 8 * r + 7] = 0.0
        size = functions.estimate(variant, w, work.J, tangents.weight, tangents.error, h)
    return size / limit


@inlined
def _solve(functions, derivatives, variant, work, options, tangents, d, i, h):
    """Stage increments of the i-th tangent d, in the lane buffer; whether the iteration converged."""
    w, real, width = tangents.w, tangents.real, 8 * (options.n_q + options.n)
    if d[0] > 0.0 and tangents.count[CONTINUES]:
        functions.extrapolate(w, tangents.past[width * i : width * (i + 1)], 1.0, h / real[PIECE_LENGTH])
    else:
        functions.rest(w)
    functions.move(w, d, h)
    size, scale, theta = 0.0, 1.0, 0.0
    for iteration in range(ITERATIONS):
        before = size
        derivatives.vary(w, d)
        size = functions.newton(variant, w, d, work.J, tangents.weight, h)
        tangents.count[SOLVES] += 1
        if not size < 1e100:
            return False
        if iteration == 0:
            own = max(size_of(tangents, d, 8 * (options.first + 1)), tangents.small[i])
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
def _by_volume(tangents, n_x, before, span):
    """Take the last direction's growth from a whole frame's volume, where that shrinks too fast for steps.

    An implicit method takes a strongly damped direction to zero, but not at its true rate; that of the
    frame's volume is the trace's integral (Liouville). `before`: logarithm of a neutral direction's length
    where the piece began.
    """
    last, trace = len(tangents.alive) - 1, tangents.real[PIECE_TRACE]
    if last + 1 < n_x or not tangents.alive[last] or trace > RESOLVED:
        return
    product = exp(-before) if tangents.count[NEUTRAL] else 1.0
    for norm in tangents.norms:
        product *= norm
    tangents.logs[last] += trace - log(product)
    tangents.real[UNRESOLVED] += span


@inlined
def log_block(motion, tangents):
    """Record a row where a block ends."""
    if not motion.s[0] >= tangents.real[NEXT]:
        return
    row, k, real = tangents.rows[tangents.count[ROWS]], len(tangents.logs), tangents.real
    row[0], row[1], row[2], row[3] = motion.s[0], real[TRACE], real[VOLUME], real[UNRESOLVED]
    for i in range(k):
        row[AHEAD + i] = tangents.logs[i]
    for r in range(len(tangents.weight)):
        row[AHEAD + k + r] = motion.s[1 + r]
    tangents.count[ROWS] += 1
    while motion.s[0] >= tangents.real[NEXT]:
        tangents.real[NEXT] += tangents.real[BLOCK]


@inner
def _product(d, a, b, width, weight):
    """Inner product of the vectors that begin at d[a] and d[b]; two sums, neither waiting for the other."""
    total, other = 0.0, 0.0
    for r in range(1, width - 1, 2):
        total += (weight[r - 1] * d[a + r]) * (weight[r - 1] * d[b + r])
        other += (weight[r] * d[a + r + 1]) * (weight[r] * d[b + r + 1])
    if width % 2 == 0:
        other += (weight[width - 2] * d[a + width - 1]) * (weight[width - 2] * d[b + width - 1])
    return total + other


@inner
def _reduce(d, i, width, weight, alive):
    """Remove from vector i its parts along the vectors before it; the lengths before and after."""
    at = i * width
    whole = before = left = sqrt(_product(d, at, at, width, weight))
    for _ in range(2 if i > 0 else 0):
        for j in range(i):
            if alive[j]:
                along = _product(d, j * width, at, width, weight)
                for r in range(1, width):
                    d[at + r] -= along * d[j * width + r]
        left = sqrt(_product(d, at, at, width, weight))
        if left > AGAIN * before:
            break
        before = left
    return whole, left


@compiled
def orthonormalise(d, width, weight, alive, norms, logs, lossy):
    """Make the frame orthonormal; lengths go to `norms`, their logarithms are added to `logs`.

    `lossy`, if 1: the frame comes from a map that may have lost a dimension; what is left of a vector by
    rounding alone is then given up, with the logarithm -inf.
    """
    for i in range(len(norms)):
        norms[i] = 1.0
        if not alive[i]:
            continue
        at = i * width
        whole, left = _reduce(d, i, width, weight, alive)
        norms[i] = left
        if not left > (LOST * max(whole, 1.0) if lossy > 0.0 else 0.0):  # it was of unit length before
            alive[i], left = 0, 0.0
        logs[i] += log(left) if left > 0.0 else float("-inf")
        factor = 1.0 / left if left > 0.0 else 0.0
        for r in range(1, width):
            d[at + r] *= factor


@inner
def orthonormal(tangents, width, lossy):
    """Make the frame of tangents orthonormal (`orthonormalise`)."""
    d, weight, alive = tangents.d, tangents.weight, tangents.alive
    orthonormalise(d, width, weight, alive, tangents.norms, tangents.logs, lossy)


@inner
def determinant(S, n):
    """Determinant of the n by n matrix in S, row by row; S is spent."""
    found = 1.0
    for j in range(n):
        top = j
        for i in range(j + 1, n):
            if abs(S[i * n + j]) > abs(S[top * n + j]):
                top = i
        if S[top * n + j] == 0.0:
            return 0.0
        if top != j:
            found = -found
            for c in range(n):
                S[j * n + c], S[top * n + c] = S[top * n + c], S[j * n + c]
        found *= S[j * n + j]
        for i in range(j + 1, n):
            factor = S[i * n + j] / S[j * n + j]
            for c in range(j, n):
                S[i * n + c] -= factor * S[j * n + c]
    return found


@inner
def size_of(tangents, d, at):
    """Largest component of a tangent, at the piece's begin or end, in units of the scales."""
    size = 0.0
    for r in range(len(tangents.weight)):
        begin, end = d[1 + r], d[1 + r] + tangents.w[at + 8 * r + 6]
        size = max(size, abs(tangents.weight[r] * begin), abs(tangents.weight[r] * end))
    return size


@inlined
def add_works(derivatives, tangents, d, i, h):
    """Integrals of the powers' derivatives in the piece, of the i-th tangent."""
    w, n_w = tangents.w, len(tangents.powers) // 2
    if n_w > 0:
        derivatives.vary(w, d)
    for m in range(n_w):
        tangents.works[i * n_w + m] += integral(w, len(w) - 8 * (1 + n_w - m), h, tangents.b)
