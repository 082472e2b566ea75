"""Derivative of an impact on several walls, or with friction, while the action of each wall stays as it is.

With z+ = z- + sum_a p_a w_a, w_a(t, q) the speeds that a unit impulse a adds, and g_a(t, q, z) the rate on
which it acts, the impulses follow from g_a(z+) + s_a(z-) = 0: s = r g where a wall is met, else 0. So

    dz+ = dz- + sum_a (p_a dw_a + dp_a w_a),    dg_a(z+) + ds_a(z-) = 0,

which is one linear system, of the matrix that the impact itself has. Where a body slips, q = -+f p has no
equation of its own. It is a function of time, state and directions, as `turned` gives it (codegen.variation).
The work of a drive that imposes a speed, sum_a p_a D_a, is treated as one more speed.

Where a body comes to rest, all that has acted on it at that instant (the impact, what `impacts.lay` takes
away, what puts it on its walls) comes to one plastic impact on the walls on which it rests then: no gap of
theirs has a rate afterwards, and friction is as the body slides. Its derivative is that of all. After a row
of rebounds it is that of the limit too, to second order in the speed of those left out, as the motion is.
"""

from ..interface import inner
from ..memory import CHOICE, EQUATIONS, JAMMED, MEMBERS, PUSH, SHARE, SIZE, STATE, TARGET, WALL
from ..modes import look
from ..walls.impacts import drive_share, gather, prepare, push, rough
from ..walls.impulses import (
    IMPOSSIBLE,
    PUSHES,
    SEPARATES,
    SLIPS_DOWN,
    SLIPS_UP,
    STICKS,
    choose,
    drawn,
    eliminate,
    equations,
    unknown,
)

ALIKE = 1e-6  # of a jump: by how much it may differ from what it is taken for


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
def work_place(y, n_q, n):
    """Place in y.D of the derivative of the drive's work; its end where no work is wanted."""
    width = 1 + n_q + n
    return n * width + (len(y.gradient) - width) * (width - 1)


@inner
def impact_map(f, g, k, x, o, y):
    """Write the derivative of the impact that has just acted to y.D; x.s is the state after it."""
    q, n_q, n = k.impact, o.n_q, o.n
    width, columns, members = 1 + n_q + n, len(y.gradient), int(k.impact[MEMBERS])
    after, right = y.room[len(y.D) :], y.room[len(y.D) + len(x.s) :]
    ways = right[SIZE * columns :]
    guard = ways[SIZE * (n + 1) :]
    for c in range(columns):
        guard[c] = y.gradient[c]
    for r in range(len(x.s)):
        after[r], x.s[r] = x.s[r], q[STATE + r]
    look(f.contacts, x.modes, x.m, x.s, x.p, k.contact)
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
def landing_map(f, g, k, x, o, y, j, several):
    """Write the derivative of coming to rest on wall j to y.D, from the state in y.state to that in x.s.

    Or of leaving it, as others come to hold the body. `several`: whether it rests on others too. False, where
    no one impact is what has happened.
    """
    walls = len(x.modes) - len(x.flags)
    if not (several or rough(x, j)):
        g.turned(walls + j, y.state, x.p, y.D)
        return True
    q, jammed = k.impact, x.count[JAMMED]
    members = gather(f, j, k, x, -1.0)
    if x.count[JAMMED] > jammed:
        x.count[JAMMED] = jammed
        return False
    for i in range(members):
        q[CHOICE + i] = _slides(k, x, o, i)
    for r in range(len(x.s)):
        k.ahead[r], x.s[r] = x.s[r], y.state[r]
    look(f.contacts, x.modes, x.m, x.s, x.p, k.contact)
    prepare(f, k, x, members)
    alike = choose(q, members, 1.0) < IMPOSSIBLE and _leads(f, k, x, o, y, members)
    for r in range(len(x.s)):
        x.s[r] = k.ahead[r]
    if alike:
        impact_map(f, g, k, x, o, y)
    return alike


@inner
def _slides(k, x, o, i):
    """Action of the i-th wall, as the body slides there now; where it sticks to a guide, one corner holds."""
    q, wall = k.impact, int(k.impact[WALL + i])
    if not rough(x, wall):
        return PUSHES
    v_t = k.contact[6 * (len(x.modes) + wall) + 2]
    if abs(v_t) > o.rest:
        return SLIPS_UP if v_t > 0.0 else SLIPS_DOWN
    for e in range(i):
        if q[CHOICE + e] == STICKS and x.group[int(q[WALL + e])] == x.group[wall]:
            return PUSHES
    return STICKS


@inner
def _leads(f, k, x, o, y, members):
    """Whether the impulses lead from the state before, in x.s, to the speeds in k.ahead."""
    q, first, off, size = k.impact, 1 + o.n_q, 0.0, 0.0
    for r in range(o.n):
        y.unit[r] = k.ahead[first + r] - q[STATE + first + r]
    for a in range(2 * members):
        if q[PUSH + a] != 0.0:
            push(f, k, x, a)
            for r in range(o.n):
                change = q[PUSH + a] * (x.s[first + r] - q[STATE + first + r])
                y.unit[r] -= change
                size = max(size, abs(change) * y.weight[o.n_q + r])
                x.s[first + r] = q[STATE + first + r]
    for r in range(o.n):
        off = max(off, abs(y.unit[r]) * y.weight[o.n_q + r])
    return off <= ALIKE * size


@inner
def _explicit(f, g, k, x, o, y, ways):
    """Start y.D as at fixed impulses, and note the vectors w_a; x.s is the state before the impact."""
    q, n_q, n, walls = k.impact, o.n_q, o.n, len(x.modes) - len(x.flags)
    width, columns, turned = 1 + n_q + n, len(y.gradient), y.room[: len(y.D)]
    work = work_place(y, n_q, n)
    for i in range(len(y.D)):
        y.D[i] = 0.0
    for r in range(n):
        y.D[r * width + 1 + n_q + r] = 1.0
    for a in range(2 * int(q[MEMBERS])):
        for r in range(n + 1):
            ways[a * (n + 1) + r] = 0.0
        if q[PUSH + a] != 0.0 or unknown(q, a):
            ways[a * (n + 1) + n] = drive_share(k, x, a)
            push(f, k, x, a)
            for r in range(n):
                ways[a * (n + 1) + r] = x.s[1 + n_q + r] - q[STATE + 1 + n_q + r]
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
                change = y.gradient[c] * normal * (1.0 if ratio > 0.0 else -1.0)
                for r in range(n):
                    y.D[at + r * step] += change * ways[(2 * i + 1) * (n + 1) + r]
                if work < len(y.D):
                    y.D[work + c] += change * ways[(2 * i + 1) * (n + 1) + n]


@inner
def _implicit(q, y, c, right, ways, columns, members, n_q, n):
    """Add the changes by the impulses to column c of y.D."""
    rows, work = 0, work_place(y, n_q, n)
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
            for r in range(n + 1):
                way = ways[a * (n + 1) + r]
                way += ratio * ways[(a + 1) * (n + 1) + r] if ratio != 0.0 else 0.0
                if r < n:
                    y.D[at + r * step] += change * way
                elif work < len(y.D):
                    y.D[work + c] += change * way
            rows += 1
