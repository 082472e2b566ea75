"""The method's algebra for structures with many unknowns: by plan, not written out.

What codegen.algebra writes out for few unknowns is done here for many, with matrices that are mostly zero:
the Jacobian comes as that of the residual M a = Q, as M and the derivatives B_q, B_z of Q - M a at fixed a,
and Newton's matrix is

    E = (lambda/h) M - B_z - (h/lambda) B_q,     E X = M (R - (lambda/h) W),

the same iteration as with J = M^-1 B. A plan (codegen.elimination) says which entries of `J` are what, and
lists the operations that eliminate and substitute, fill included: (to, count, then) followed by `count`
pairs (a, b) of places in the lane buffer, for: the complex row `to` less the products a b; `then` times
the row at that place, or -1: nothing more, -2: its inverse.

`size` holds the numbers of positions and speeds and the lane row of time. The buffer begins, in rows: W, R, X
(n each; see codegen.algebra), squares, -lambda/h, then the entries of E.
"""

from math import sqrt

from .interface import INT, REAL, Array, Signature, compiled, vector, void
from .lanes.lanes import (
    add_matvec,
    axpy,
    complex_fma,
    complex_multiply,
    complex_sum,
    matvec,
    position_row,
    sparse_dot,
    subtract_products,
)
from .polynomial import BARYCENTRIC
from .radau import EIGEN_IM, EIGEN_RE, ERROR, GAMMA, LANES, NODES, TO_EIGEN, TO_MOVED, TO_STAGE

AHEAD = 2  # rows between X and E
NOTHING, INVERSE = -1, -2
_PLAN = Array(INT)
UNIT = {  # what generated functions call by address (codegen.elimination)
    "extrapolate": void(vector, vector, REAL, REAL, _PLAN),
    "rest": void(vector, _PLAN),
    "move": void(vector, vector, REAL, _PLAN),
    "factor": void(vector, vector, REAL, _PLAN, _PLAN, _PLAN),
    "linearised": void(vector, vector, _PLAN, _PLAN, _PLAN, _PLAN),
    "newton": Signature(REAL, (vector, vector, vector, vector, REAL, _PLAN, _PLAN, _PLAN)),
    "estimate": Signature(REAL, (vector, vector, vector, vector, REAL, _PLAN, _PLAN, _PLAN, _PLAN)),
}


@compiled
def _execute(w, program):
    """Carry out operations of a plan."""
    o = 0
    while o < len(program):
        to, end, then = program[o], o + 3 + 2 * program[o + 1], program[o + 2]
        subtract_products(w, to, program, o + 3, end)
        if then >= 0:
            complex_multiply(w, to, then)
        elif then == INVERSE:
            for i in range(to, to + 4):
                d = 1.0 / (w[i] * w[i] + w[i + 4] * w[i + 4])
                w[i], w[i + 4] = w[i] * d, -w[i + 4] * d
        o = end


@compiled
def factor(w, J, h, size, entries, program):
    """Fill E from (place, M, B_z, B_q) of each entry, the last three places in J or -1, and eliminate."""
    n = size[1]
    ratio, moved = 8 * (3 * n + 1), 16 * n
    for i in range(4):
        square = EIGEN_RE[i] * EIGEN_RE[i] + EIGEN_IM[i] * EIGEN_IM[i]
        w[ratio + i], w[ratio + 4 + i] = -EIGEN_RE[i] / h, -EIGEN_IM[i] / h
        w[moved + i], w[moved + 4 + i] = h * EIGEN_RE[i] / square, -h * EIGEN_IM[i] / square
    for e in range(0, len(entries), 4):
        at, m, z, q = entries[e], entries[e + 1], entries[e + 2], entries[e + 3]
        mass, rate, pull = J[m] if m >= 0 else 0.0, J[z] if z >= 0 else 0.0, J[q] if q >= 0 else 0.0
        complex_sum(w, at, -mass, ratio, -pull, moved, -rate)
    _execute(w, program)


@compiled
def linearised(J, out, size, masses, rates, pulls):
    """M^-1 (B_q, B_z), row by row, and behind it scratch; lists as in `estimate`, `rates` that of B_z.

    M is positive definite, so that nothing is exchanged (Gauss and Jordan).
    """
    n_q, n = size[0], size[1]
    width, o = n_q + n, 0
    M = n * width
    for i in range(M + n * n):
        out[i] = 0.0
    for p in range(0, len(pulls), 3):
        out[width * pulls[p] + pulls[p + 1]] = J[pulls[p + 2]]
    for p in range(0, len(rates), 3):
        out[width * rates[p] + n_q + rates[p + 1]] = J[rates[p + 2]]
    for r in range(n):
        for p in range(masses[o]):
            out[M + n * r + masses[o + 2 + 2 * p] // 8 - n] = J[masses[o + 1 + 2 * p]]
        o += 1 + 2 * masses[o]
    for m in range(n):
        pivot = out[M + n * m + m]
        for r in range(n):
            ratio = out[M + n * r + m] / pivot
            if r != m and ratio != 0.0:
                for c in range(m, n):
                    out[M + n * r + c] -= ratio * out[M + n * m + c]
                for c in range(width):
                    out[width * r + c] -= ratio * out[width * m + c]
        for c in range(width):
            out[width * m + c] /= pivot
        for c in range(m, n):
            out[M + n * m + c] /= pivot


@compiled
def _weigh(w, J, masses, X):
    """X = M R. `masses` lists, row by row, a count and as many pairs: place in J, and of a row of R in w."""
    o = 0
    while o < len(masses):
        end = o + 1 + 2 * masses[o]
        sparse_dot(w, X, J, masses, o + 1, end)
        X += 8
        o = end


@compiled
def extrapolate(w, source, start, ratio, size):
    """Stage increments of the speeds from the polynomial in `source`, at start + ratio c_i."""
    n_q, n, first = size[0], size[1], size[2]
    table, state = w[8 * n : 8 * n + 64], 8 * (first + 1)
    for i in range(LANES):
        x, product = start + ratio * NODES[i], 1.0
        for j in range(LANES):
            table[8 * j + i] = product * BARYCENTRIC[j]
            product *= x - NODES[j]
        product = 1.0
        for j in range(LANES - 1, -1, -1):
            table[8 * j + i] *= product
            product *= x - NODES[j]
        table[48 + i] -= 1.0 if start == 1.0 else 0.0  # from here on increments of the new base point
        table[56 + i] = 0.0
    for r in range(n):
        matvec(w, state + 8 * (n_q + r), source, 8 * (n_q + r), table)
    for r in range(n):
        matvec(w, 8 * r, w, state + 8 * (n_q + r), TO_EIGEN)


@compiled
def rest(w, size):
    """No change of the speeds."""
    n_q, n, first = size[0], size[1], size[2]
    speeds = 8 * (first + 1 + n_q)
    for i in range(8 * n):
        w[i] = 0.0
        w[speeds + i] = 0.0


@compiled
def move(w, s, h, size):
    """Increments of time and positions from increments of the speeds."""
    n_q, first = size[0], size[2]
    time, state = 8 * first, 8 * (first + 1)
    for i in range(LANES):
        w[time + i] = h * NODES[i]
    for r in range(n_q):
        position_row(w, state + 8 * r, h, s[1 + n_q + r], 8 * r, TO_MOVED, NODES)


@compiled
def newton(w, s, J, weight, h, size, masses, program):
    """One Newton update; its size."""
    n_q, n, first = size[0], size[1], size[2]
    R, X, squares = 8 * n, 16 * n, 24 * n
    speeds = 8 * (first + 1 + n_q)
    for r in range(n):
        matvec(w, R + 8 * r, w, speeds + 8 * (n + r), TO_EIGEN)
        complex_fma(w, R + 8 * r, squares + 8, 8 * r)
    _weigh(w, J, masses, X)
    _execute(w, program)
    for i in range(squares, squares + 8):
        w[i] = 0.0
    one = 1.0
    for r in range(n):
        axpy(w, 8 * r, one, X + 8 * r)
        add_matvec(w, speeds + 8 * r, squares, weight[n_q + r], X + 8 * r, TO_STAGE)
    move(w, s, h, size)
    total = 0.0
    for i in range(squares, squares + 7):
        total += w[i]
    return sqrt(total / (7.0 * n))


@compiled
def estimate(w, J, weight, error, h, size, masses, pulls, program):
    """Error estimate (see codegen.algebra); its size. `pulls` lists (row, column, place in J) of B_q."""
    n_q, n, first = size[0], size[1], size[2]
    state, X, span = 8 * (first + 1), 16 * n, h / GAMMA
    for r in range(n_q + n):
        total = span * error[r]
        for i in range(7):
            total += ERROR[i] * w[state + 8 * r + i]
        error[r] = total
    for r in range(n):
        for i in range(8):
            w[8 * (n + r) + i] = 0.0
        w[8 * (n + r)] = error[n_q + r] / span
    _weigh(w, J, masses, X)
    for o in range(0, len(pulls), 3):
        w[X + 8 * pulls[o]] += J[pulls[o + 2]] * error[pulls[o + 1]]
    _execute(w, program)
    for r in range(n):
        error[n_q + r] = w[X + 8 * r]
        if r < n_q:
            error[r] += span * w[X + 8 * r]
    total = 0.0
    for r in range(n_q + n):
        total += (error[r] * weight[r]) ** 2
    return sqrt(total / (n_q + n))
