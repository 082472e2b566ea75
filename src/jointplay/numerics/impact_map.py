"""Derivative of an impact on several walls, or with friction, where what each wall does stays as it is.

With z+ = z- + sum_a p_a w_a, w_a(t, q) the speeds that a unit impulse a adds, and g_a(t, q, z) the rate on
which it acts, the impulses follow from g_a(z+) + s_a(z-) = 0: s = r g where a wall is met, else 0. So

    dz+ = dz- + sum_a (p_a dw_a + dp_a w_a),    dg_a(z+) + ds_a(z-) = 0,

which is one linear system, of the matrix that the impact itself has. Where a body slips, q = -+f p has no
equation of its own. It is a function of time, state and directions, as `turned` gives it (codegen.variation).
"""

from .impacts import push
from .impulses import SEPARATES, STICKS, drawn, eliminate, equations, unknown
from .interface import inner
from .memory import CHOICE, EQUATIONS, MEMBERS, PUSH, SHARE, SIZE, STATE, TARGET, WALL


@inner
def loses(k):
    """Whether the impact takes a dimension: a body sticks, or a wall at which it rests goes on to push."""
    q = k.impact
    for i in range(int(q[MEMBERS])):
        still = q[CHOICE + i] > SEPARATES and q[TARGET + i] == 0.0
        if still or q[CHOICE + i] == STICKS:
            return True
    return False


@inner
def _column(y, c, n_q, n):
    """Place in y.D of a column's first speed, and the way from one speed to the next."""
    width = 1 + n_q + n
    if c < width:
        return c, width
    return n * width + (c - width) * (width - 1) + n_q, 1


@inner
def impact_map(f, g, k, x, o, y):
    """Write the derivative of the impact that has just acted to y.D; x.s is the state after it."""
    q, n_q, n = k.impact, o.n_q, o.n
    width, columns, members = 1 + n_q + n, len(y.gradient), int(k.impact[MEMBERS])
    after, right = y.room[len(y.D) :], y.room[len(y.D) + len(x.s) :]
    ways = right[SIZE * columns :]
    guard = ways[SIZE * n :]
    for c in range(columns):
        guard[c] = y.gradient[c]
    for r in range(len(x.s)):
        after[r], x.s[r] = x.s[r], q[STATE + r]
    for i in range(SIZE * columns):
        right[i] = 0.0
    _explicit(f, g, k, x, o, y, ways)
    for i in range(members):
        if q[TARGET + i] != 0.0:
            g.gradient(len(x.fired) + 4 * int(q[WALL + i]) + 1, x.s, x.p, x.m, y.gradient)
            for c in range(columns):
                right[2 * i * columns + c] = -q[SHARE] * y.gradient[c]
    for r in range(len(x.s)):
        x.s[r] = after[r]
    for a in range(2 * members):
        if unknown(q, a):
            g.gradient(len(x.fired) + 4 * int(q[WALL + a // 2]) + 2 * (a % 2), x.s, x.p, x.m, y.gradient)
            for c in range(columns):
                at, step = _column(y, c, n_q, n)
                total = 0.0 if 1 + n_q <= c < width else y.gradient[c]
                for r in range(n):
                    total += y.gradient[1 + n_q + r] * y.D[at + r * step]
                right[a * columns + c] -= total
    for c in range(columns):
        _implicit(q, y, c, right, ways, columns, members, n_q, n)
        y.gradient[c] = guard[c]


@inner
def _explicit(f, g, k, x, o, y, ways):
    """Start y.D as at fixed impulses, and note the ways w_a; the state in x.s is that before the impact."""
    q, n_q, n, walls = k.impact, o.n_q, o.n, len(x.modes) - len(x.flags)
    width, columns, turned = 1 + n_q + n, len(y.gradient), y.room[: len(y.D)]
    for i in range(len(y.D)):
        y.D[i] = 0.0
    for r in range(n):
        y.D[r * width + 1 + n_q + r] = 1.0
    for a in range(2 * int(q[MEMBERS])):
        for r in range(n):
            ways[a * n + r] = 0.0
        if q[PUSH + a] != 0.0 or unknown(q, a):
            push(f, k, x, a)
            for r in range(n):
                ways[a * n + r] = x.s[1 + n_q + r] - q[STATE + 1 + n_q + r]
                x.s[1 + n_q + r] = q[STATE + 1 + n_q + r]
            g.turned(2 * len(x.modes) + int(q[WALL + a // 2]) + (a % 2) * walls, x.s, x.p, turned)
            for r in range(n):
                turned[r * width + 1 + n_q + r] -= 1.0
            for i in range(len(y.D)):
                y.D[i] += q[PUSH + a] * turned[i]
    for i in range(int(q[MEMBERS])):
        ratio, normal = drawn(q, i), q[PUSH + 2 * i]
        if ratio != 0.0 and columns > width:
            g.gradient(len(x.fired) + 4 * int(q[WALL + i]) + 3, x.s, x.p, x.m, y.gradient)
            for c in range(width, columns):
                at, step = _column(y, c, n_q, n)
                for r in range(n):
                    change = y.gradient[c] * normal * ways[(2 * i + 1) * n + r]
                    y.D[at + r * step] += change if ratio > 0.0 else -change


@inner
def _implicit(q, y, c, right, ways, columns, members, n_q, n):
    """Add to column c of y.D what the impulses change."""
    rows = 0
    at, step = _column(y, c, n_q, n)
    n_unknown = equations(q, members)
    for a in range(2 * members):
        if unknown(q, a):
            q[EQUATIONS + (SIZE + 1) * rows + SIZE] = right[a * columns + c]
            rows += 1
    eliminate(q[EQUATIONS:], n_unknown)
    rows = 0
    for a in range(2 * members):
        if unknown(q, a):
            change = q[EQUATIONS + (SIZE + 1) * rows + SIZE]
            ratio = drawn(q, a // 2) if a % 2 == 0 else 0.0
            for r in range(n):
                way = ways[a * n + r] + (ratio * ways[(a + 1) * n + r] if ratio != 0.0 else 0.0)
                y.D[at + r * step] += change * way
            rows += 1
