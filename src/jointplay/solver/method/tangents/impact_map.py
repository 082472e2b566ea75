"""Derivative of an impact on several walls, or with friction, while the action of each wall stays as it is.

With z+ = z- + sum_a p_a w_a, w_a(t, q) the speeds that a unit impulse a adds, and g_a(t, q, z) the rate on
which it acts, the impulses follow from g_a(z+) + s_a(z-) = 0: s = r g where a wall is met, else 0. So

    dz+ = dz- + sum_a (p_a dw_a + dp_a w_a),    dg_a(z+) + ds_a(z-) = 0,

which is one linear system, of the matrix that the impact itself has. Where a body slips, q = -+f p has no
equation of its own. It is a function of time, state and directions, as `reset_slopes` (codegen.variation)
gives it. The work of a drive that imposes a speed, sum_a p_a D_a, is treated as one more speed.

Where a body comes to rest, all that has acted on it at that instant (the impact, what `impacts.lay` takes
away, what puts it on its walls) comes to one plastic impact on the walls on which it rests then: no gap of
theirs has a rate afterwards, and friction is as the body slides. Its derivative is that of all. After a row
of rebounds it is that of the limit too, to second order in the speed of those left out, as the motion is.
"""

from ..interface import inner
from ..memory import CHOICE, EQUATIONS, JAMMED, MEMBERS, PUSH, SHARE, SIZE, STATE, TARGET, WALL
from ..modes import contact_numbers
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
def loses(work):
    """Whether the impact takes a dimension: a body sticks, or a wall at which it rests goes on to push."""
    q = work.impact
    for i in range(int(q[MEMBERS])):
        still = q[CHOICE + i] > SEPARATES and q[TARGET + i] == 0.0
        if still or q[CHOICE + i] == STICKS:
            return True
    return False


@inner
def _column(c, n_q, n):
    """Place in tangents.D of a column's first speed, and the step from one speed to the next."""
    width = 1 + n_q + n
    if c < width:
        return c, width
    return n * width + (c - width) * (width - 1) + n_q, 1


@inner
def work_place(tangents, n_q, n):
    """Place in tangents.D of the derivative of the drive's work; its end where no work is wanted."""
    width = 1 + n_q + n
    return n * width + (len(tangents.gradient) - width) * (width - 1)


@inner
def impact_map(functions, derivatives, work, motion, options, tangents):
    """Write to tangents.D the derivative of the impact that has just led to the state."""
    q, n_q, n = work.impact, options.n_q, options.n
    s, p, m, gradient = motion.s, motion.p, motion.m, tangents.gradient
    width, columns, members = 1 + n_q + n, len(gradient), int(work.impact[MEMBERS])
    after, right = tangents.room[len(tangents.D) :], tangents.room[len(tangents.D) + len(s) :]
    responses = right[SIZE * columns :]
    guard = responses[SIZE * (n + 1) :]
    for c in range(columns):
        guard[c] = gradient[c]
    for r in range(len(s)):
        after[r], s[r] = s[r], q[STATE + r]
    contact_numbers(functions.contacts, motion.modes, m, s, p, work.contact)
    for i in range(SIZE * columns):
        right[i] = 0.0
    _explicit(functions, derivatives, work, motion, options, tangents, responses)
    for i in range(members):
        if q[TARGET + i] != 0.0:
            derivatives.gradient(len(motion.fired) + 4 * int(q[WALL + i]) + 1, s, p, m, gradient)
            for c in range(columns):
                right[2 * i * columns + c] = -q[SHARE] * gradient[c]
    for r in range(len(s)):
        s[r] = after[r]
    for a in range(2 * members):
        if unknown(q, a):
            derivatives.gradient(
                len(motion.fired) + 4 * int(q[WALL + a // 2]) + 2 * (a % 2), s, p, m, gradient
            )
            for c in range(columns):
                at, step = _column(c, n_q, n)
                total = 0.0 if 1 + n_q <= c < width else gradient[c]
                for r in range(n):
                    total += gradient[1 + n_q + r] * tangents.D[at + r * step]
                right[a * columns + c] -= total
    for c in range(columns):
        _implicit(q, tangents, c, right, responses, columns, members, n_q, n)
        gradient[c] = guard[c]


@inner
def landing_map(functions, derivatives, work, motion, options, tangents, j, several):
    """Write to tangents.D the derivative of coming to rest on wall j, from tangents.state to the state now.

    Or of leaving it, as others come to hold the body. `several`: whether it rests on others too. False, where
    no one impact is what has happened.
    """
    walls = len(motion.modes) - len(motion.flags)
    if not (several or rough(motion, j)):
        derivatives.reset_slopes(walls + j, tangents.state, motion.p, tangents.D)
        return True
    q, jammed = work.impact, motion.count[JAMMED]
    members = gather(functions, j, work, motion, -1.0)
    if motion.count[JAMMED] > jammed:
        motion.count[JAMMED] = jammed
        return False
    for i in range(members):
        q[CHOICE + i] = _slides(work, motion, options, i)
    for r in range(len(motion.s)):
        work.predicted[r], motion.s[r] = motion.s[r], tangents.state[r]
    contact_numbers(functions.contacts, motion.modes, motion.m, motion.s, motion.p, work.contact)
    prepare(functions, work, motion, members)
    alike = choose(q, members, 1.0) < IMPOSSIBLE and _leads(
        functions, work, motion, options, tangents, members
    )
    for r in range(len(motion.s)):
        motion.s[r] = work.predicted[r]
    if alike:
        impact_map(functions, derivatives, work, motion, options, tangents)
    return alike


@inner
def _slides(work, motion, options, i):
    """Action of the i-th wall, as the body slides there now; where it sticks to a guide, one corner holds."""
    q, wall = work.impact, int(work.impact[WALL + i])
    if not rough(motion, wall):
        return PUSHES
    v_t = work.contact[6 * (len(motion.modes) + wall) + 2]
    if abs(v_t) > options.speed_tolerance:
        return SLIPS_UP if v_t > 0.0 else SLIPS_DOWN
    for e in range(i):
        if q[CHOICE + e] == STICKS and motion.group[int(q[WALL + e])] == motion.group[wall]:
            return PUSHES
    return STICKS


@inner
def _leads(functions, work, motion, options, tangents, members):
    """Whether the impulses lead from the state, which is that before, to the speeds in work.predicted."""
    q, first, off, size = work.impact, 1 + options.n_q, 0.0, 0.0
    for r in range(options.n):
        tangents.unit[r] = work.predicted[first + r] - q[STATE + first + r]
    for a in range(2 * members):
        if q[PUSH + a] != 0.0:
            push(functions, work, motion, a)
            for r in range(options.n):
                change = q[PUSH + a] * (motion.s[first + r] - q[STATE + first + r])
                tangents.unit[r] -= change
                size = max(size, abs(change) * tangents.weight[options.n_q + r])
                motion.s[first + r] = q[STATE + first + r]
    for r in range(options.n):
        off = max(off, abs(tangents.unit[r]) * tangents.weight[options.n_q + r])
    return off <= ALIKE * size


@inner
def _explicit(functions, derivatives, work, motion, options, tangents, responses):
    """Start tangents.D as at fixed impulses, and note the vectors w_a; the state is that before."""
    q, n_q, n, walls = work.impact, options.n_q, options.n, len(motion.modes) - len(motion.flags)
    width, columns, slopes = 1 + n_q + n, len(tangents.gradient), tangents.room[: len(tangents.D)]
    s, p, work_row = motion.s, motion.p, work_place(tangents, n_q, n)
    for i in range(len(tangents.D)):
        tangents.D[i] = 0.0
    for r in range(n):
        tangents.D[r * width + 1 + n_q + r] = 1.0
    for a in range(2 * int(q[MEMBERS])):
        for r in range(n + 1):
            responses[a * (n + 1) + r] = 0.0
        if q[PUSH + a] != 0.0 or unknown(q, a):
            responses[a * (n + 1) + n] = drive_share(work, motion, a)
            push(functions, work, motion, a)
            for r in range(n):
                responses[a * (n + 1) + r] = s[1 + n_q + r] - q[STATE + 1 + n_q + r]
                s[1 + n_q + r] = q[STATE + 1 + n_q + r]
            derivatives.reset_slopes(
                2 * len(motion.modes) + int(q[WALL + a // 2]) + (a % 2) * walls, s, p, slopes
            )
            for r in range(n):
                slopes[r * width + 1 + n_q + r] -= 1.0
            for i in range(len(tangents.D)):
                tangents.D[i] += q[PUSH + a] * slopes[i]
    for i in range(int(q[MEMBERS])):
        ratio, normal = drawn(q, i), q[PUSH + 2 * i]
        if ratio != 0.0 and columns > width:
            derivatives.gradient(
                len(motion.fired) + 4 * int(q[WALL + i]) + 3, s, p, motion.m, tangents.gradient
            )
            for c in range(width, columns):
                at, step = _column(c, n_q, n)
                change = tangents.gradient[c] * normal * (1.0 if ratio > 0.0 else -1.0)
                for r in range(n):
                    tangents.D[at + r * step] += change * responses[(2 * i + 1) * (n + 1) + r]
                if work_row < len(tangents.D):
                    tangents.D[work_row + c] += change * responses[(2 * i + 1) * (n + 1) + n]


@inner
def _implicit(q, tangents, c, right, responses, columns, members, n_q, n):
    """Add the changes by the impulses to column c of tangents.D."""
    rows, work = 0, work_place(tangents, n_q, n)
    at, step = _column(c, n_q, n)
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
                response = responses[a * (n + 1) + r]
                response += ratio * responses[(a + 1) * (n + 1) + r] if ratio != 0.0 else 0.0
                if r < n:
                    tangents.D[at + r * step] += change * response
                elif work < len(tangents.D):
                    tangents.D[work + c] += change * response
            rows += 1
