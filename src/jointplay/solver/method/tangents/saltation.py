"""Saltation: the jump of tangents at an event.

The guard's gradient says how much earlier or later a neighbour meets it, and for that time it moves at the
other side's rate:

    d+ = d- + (F+ - F-) (grad h . d-) / h',                 h' = dh/dt + grad h . F-
    d+ = D d- + (F+ - D F- - dR/dt) (grad h . d-) / h'      where the state is reset by R, D = dR/dx.

Along a direction in which numbers change (method.tangents.tangent), dh/dp adds to grad h . d-, and dR/dp to D
d-. A work, whose rate is a power, jumps as a state does that is continuous itself; that of a drive which
imposes a speed as one that an impact resets.

Several mode changes at one event are one jump from F- to F+. An event that another one brings about, at the
same time, comes as much earlier to a neighbour as that one does: h is that one's then.

Onset of sticking loses a dimension, and so do the beginning and the end of a contact that a law remembers:
what it remembered before is of no account. A start that sticks is an onset too: neighbours that slide come to
stick at once, by the same projection from either side. Coming to rest on a rigid wall loses two, those of the
gap and of its rate. It is a reset like others, that of a plastic impact, after which the gap stays closed: F+
is the rate at rest. A neighbour that rests as the motion does has its gap and rate closed too, whatever
numbers it differs in: what rounding leaves there is projected away along the wall's impulse, of several walls
in turn.
References: Leine and Nijmeijer (2004), chapter 7; Kong et al., arXiv 2306.06862.

The derivative of an impact on several walls, or with friction, while the action of each wall stays as it is:
with z+ = z- + sum_a p_a w_a, w_a(t, q) the speeds that a unit impulse a adds, and g_a(t, q, z) the rate on
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

from math import log

import numpy as np

from ..interface import inner
from ..memory import (
    CHOICE,
    DRIVE,
    EQUATIONS,
    JAMMED,
    MEMBERS,
    PUSH,
    SHARE,
    SIMULTANEOUS,
    SIZE,
    STATE,
    TARGET,
    WALL,
)
from ..modes import FREE, RELEASED, REMEMBERS, SLIDE, SLIP_POSITIVE, STICK, contact_numbers, variant_of
from ..walls.impacts import (
    IMPOSSIBLE,
    PUSHES,
    SEPARATES,
    SLIPS_DOWN,
    SLIPS_UP,
    STICKS,
    choose,
    drawn,
    drive_share,
    eliminate,
    equations,
    gather,
    laid,
    prepare,
    push,
    rough,
    unknown,
)
from ..walls.walls import resting, walls_of
from .tangent import (
    CONTINUES,
    GRAZING,
    HELD,
    JUMPS,
    NEUTRAL,
    RESET,
    SALTATION,
    STUCK_BEFORE,
    VOLUME,
    along,
    determinant,
    orthonormal,
    rates,
)

# What Tangents.count[TURNED] says of a contact that a law remembers; 1: a wall is met; 0: neither
ENTERS, MAY_LEAVE = 2, 3
DEGENERATE = 1e-13  # of a determinant's bound: what is less is rounding of 0

SETTLED, SQUARINGS = 1e-8, 40  # change by the last squaring but one, relative to the scales; the most
SURE = 1e-3  # of its terms: a slope that rounding does not spoil
ALIKE = 1e-6  # of a jump: by how much it may differ from what it is taken for


@inner
def stuck(modes):
    """Number of contacts that stick."""
    held = 0
    for mode in modes:
        held += mode == STICK
    return held


@inner
def _wall_of(motion, guard):
    """The rigid wall whose gap or push a guard is; -1 if it is none's."""
    wall = guard - 4 * len(motion.flags)
    return wall if wall < walls_of(motion) else -1


@inner
def delays_known(tangents, options):
    """Whether the guard of the event before tells behind it how much earlier neighbours have met it.

    It does not where it hangs on speeds that differ and the state has jumped, or where it stands still now.
    """
    n_q, n_x, jumps = options.n_q, options.n_q + options.n, tangents.count[RESET] > 0
    slope, size = tangents.gradient[0], abs(tangents.gradient[0])
    for r in range(n_x):
        term = tangents.gradient[1 + r] * tangents.after[r]
        slope += term
        size += abs(term)
        for i in range(len(tangents.alive) if jumps and r >= n_q else 0):
            if tangents.gradient[1 + r] * tangents.d[i * (1 + n_x) + 1 + r] != 0.0:
                return False
    return abs(slope) > ALIKE * size


@inner
def before_event(functions, derivatives, variant, motion, options, tangents, guard, follows):
    """Note the values before an event that its jump needs; of one that follows, the guard of its cause."""
    functions.trig(motion.s, motion.p)
    for r in range(len(motion.s)):
        tangents.state[r] = motion.s[r]
    tangents.count[CONTINUES] = 0
    rates(functions, variant, motion, options, tangents, tangents.before)
    _powers(motion, options, tangents, 0.0)
    if not follows:
        derivatives.gradient(guard, motion.s, motion.p, motion.m, tangents.gradient)
    wall, tangents.real[STUCK_BEFORE], tangents.count[RESET] = _wall_of(motion, guard), stuck(motion.modes), 0
    if wall >= 0 and motion.modes[len(motion.flags) + wall] > RELEASED:
        tangents.real[STUCK_BEFORE] = np.inf  # it lets go: nothing jumps, nothing is lost
    elif wall >= 0:
        derivatives.reset_slopes(wall, motion.s, motion.p, tangents.D)
        tangents.count[RESET] = 1
    elif guard < 4 * len(motion.flags) and motion.flags[guard // 4] & REMEMBERS:
        tangents.count[RESET] = ENTERS if motion.modes[guard // 4] == FREE else MAY_LEAVE


@inner
def jump(functions, derivatives, work, motion, options, tangents, guard):
    """Take the tangents through an event that has just been handled."""
    wall, kind = _wall_of(motion, guard), tangents.count[RESET]
    leaves = kind == MAY_LEAVE and motion.modes[guard // 4] == FREE
    if kind == ENTERS or leaves:  # of what else the state holds, that is no function of what jumps
        memory = 2 * walls_of(motion) + guard // 4 + leaves * len(motion.flags)
        derivatives.reset_slopes(memory, motion.s, motion.p, tangents.D)
    reset = kind == 1 or kind == ENTERS or leaves
    rests = reset and wall >= 0 and motion.modes[len(motion.flags) + wall] > RELEASED
    several = reset and wall >= 0 and work.impact[MEMBERS] > 0.0
    held = reset and wall >= 0 and resting(motion) > 0 and motion.group[wall] >= 0
    if rests or (held and (laid(work) or not several)):  # others were put back on their walls in between
        others = resting(motion) > (1 if rests else 0)
        if not landing_map(functions, derivatives, work, motion, options, tangents, wall, others):
            motion.count[SIMULTANEOUS] += 1
    elif several:
        impact_map(functions, derivatives, work, motion, options, tangents)
    rates(functions, variant_of(motion.modes), motion, options, tangents, tangents.after)
    _powers(motion, options, tangents, 1.0)
    sticks = stuck(motion.modes) > tangents.real[STUCK_BEFORE]
    lossy = sticks or (reset and wall < 0)  # what was remembered before is lost
    lossy = lossy or rests or (several and loses(work))
    moves = through(tangents, options.n_q, options.n_q + options.n, reset, lossy)
    if moves and (rests or (several and resting(motion) > 0)):
        project_at_rest(functions, derivatives, motion, options, tangents, 0.0)


@inner
def through(tangents, n_q, n_x, reset, lossy):
    """Take the frame through an event, by the rates on both sides; whether the guard moves there."""
    width, real = 1 + n_x, tangents.real
    slope, size, later = tangents.gradient[0], abs(tangents.gradient[0]), tangents.gradient[0]
    for r in range(n_x):
        term = tangents.gradient[1 + r] * tangents.before[r]
        slope += term
        size += abs(term)
        later += tangents.gradient[1 + r] * tangents.after[r]
    real[GRAZING] = min(real[GRAZING], abs(slope) / size if size > 0.0 else 0.0)
    if slope == 0.0:
        return False
    tangents.count[JUMPS] += 1
    real[VOLUME] += _volume(tangents, n_q, n_x, slope, later, reset, lossy)
    for i in range(len(tangents.alive)):
        if tangents.alive[i]:
            d = tangents.d[i * width : (i + 1) * width]
            drawn = _drawn(tangents, d, n_q, n_x - n_q) if reset else 0.0
            saltation = float(tangents.count[SALTATION])
            delay = _through(tangents, d, n_q, n_x, slope, 1.0 if reset else 0.0, saltation)
            _add_works(tangents, i, delay)
            if drawn != 0.0 or (reset and delay != 0.0):
                _add_drawn(tangents, i, drawn, delay, n_q, n_x - n_q)
    if tangents.count[NEUTRAL]:
        along(tangents, n_x)
    if tangents.count[HELD] == 0:
        orthonormal(tangents, width, 1.0 if lossy or reset else 0.0)
        if lossy and len(tangents.alive) == n_x and tangents.count[SALTATION]:
            _lose_last(tangents, width)
    return True


@inner
def _lose_last(tangents, width):
    """Give up the last tangent of a whole frame that has lost a dimension, where rounding has left it one."""
    last, lost = len(tangents.alive) - 1, 0
    for i in range(last + 1):
        lost += 1 - tangents.alive[i]
    if lost == 0:
        tangents.alive[last], tangents.logs[last] = 0, -np.inf
        for r in range(last * width, (last + 1) * width):
            tangents.d[r] = 0.0


@inner
def begin_tangents(functions, derivatives, motion, options, tangents):
    """Remove from the tangents the parts that neighbours of a sticking or resting start lose at once."""
    _stay_at_stick(functions, derivatives, motion, options, tangents, 0.0)
    sticks = stuck(motion.modes[: len(motion.flags)]) > 0
    project_at_rest(functions, derivatives, motion, options, tangents, 1.0 if sticks else 0.0)


@inner
def stay(functions, derivatives, motion, options, tangents):
    """After a whole step, remove the parts across the walls on which bodies rest, and across what sticks.

    They neither grow nor shrink there: of rounding they would outlive all that is stable.
    """
    functions.trig(motion.s, motion.p)
    _stay_at_stick(functions, derivatives, motion, options, tangents, SURE)
    _stay_at_rest(derivatives, motion, options, tangents)


@inner
def _stay_at_stick(functions, derivatives, motion, options, tangents, sure):
    for j in range(len(motion.flags)):
        if motion.modes[j] == STICK:
            _project_at_stick(functions, derivatives, motion, options, tangents, j, sure)


@inner
def _project_at_stick(functions, derivatives, motion, options, tangents, j, sure):
    """Take the tangents through the onset of sticking of contact j, from either side.

    Not where the slip would begin by less than the share `sure` of its terms: near where sticking ends.
    """
    n_x, motion.modes[j] = options.n_q + options.n, SLIP_POSITIVE
    width = 1 + n_x
    rates(functions, variant_of(motion.modes), motion, options, tangents, tangents.before)
    _powers(motion, options, tangents, 0.0)
    derivatives.gradient(4 * j + SLIDE, motion.s, motion.p, motion.m, tangents.gradient)
    slope, size = tangents.gradient[0], abs(tangents.gradient[0])
    for r in range(n_x):
        slope += tangents.gradient[1 + r] * tangents.before[r]
        size += abs(tangents.gradient[1 + r] * tangents.before[r])
    motion.modes[j] = STICK
    rates(functions, variant_of(motion.modes), motion, options, tangents, tangents.after)
    _powers(motion, options, tangents, 1.0)
    for i in range(len(tangents.alive)):
        if tangents.alive[i] and abs(slope) > sure * size:
            d = tangents.d[i * width : (i + 1) * width]
            saltation = float(tangents.count[SALTATION])
            _add_works(tangents, i, _through(tangents, d, options.n_q, n_x, slope, 0.0, saltation))


@inner
def project_at_rest(functions, derivatives, motion, options, tangents, held):
    """Remove from the tangents the parts across the walls on which a body rests.

    `held`: 1, where something has been taken already.
    """
    if resting(motion) > 1:
        _project_jointly(derivatives, motion, options, tangents)
    else:
        _stay_at_rest(derivatives, motion, options, tangents)
    if held > 0.0 or resting(motion) > 0:
        tangents.count[JUMPS] += 1
        tangents.real[VOLUME] = -np.inf
        if tangents.count[NEUTRAL]:
            rates(functions, variant_of(motion.modes), motion, options, tangents, tangents.after)
            along(tangents, options.n_q + options.n)
        if tangents.count[HELD] == 0:
            orthonormal(tangents, 1 + options.n_q + options.n, 1.0)


@inner
def _stay_at_rest(derivatives, motion, options, tangents):
    """Remove the parts across each wall on which a body rests, one after the other."""
    walls, width = len(motion.modes) - len(motion.flags), 1 + options.n_q + options.n
    for j in range(walls):
        if motion.modes[len(motion.flags) + j] > RELEASED:
            derivatives.reset_slopes(walls + j, motion.s, motion.p, tangents.D)
            for i in range(len(tangents.alive)):
                if tangents.alive[i]:
                    _project(tangents, tangents.d[i * width : (i + 1) * width], options.n_q, options.n)


@inner
def _project_jointly(derivatives, motion, options, tangents):
    """Remove the parts across all walls: the map of one after the other, squared until it stays as it is."""
    walls, n_x = len(motion.modes) - len(motion.flags), options.n_q + options.n
    columns, unit = len(tangents.gradient) - 1, tangents.unit
    P, Q = tangents.room[: columns * n_x], tangents.room[columns * n_x : 2 * columns * n_x]
    for c in range(columns):
        for r in range(n_x):
            P[c * n_x + r] = 1.0 if r == c else 0.0
    for j in range(walls):
        if motion.modes[len(motion.flags) + j] > RELEASED:
            derivatives.reset_slopes(walls + j, motion.s, motion.p, tangents.D)
            for c in range(columns):
                unit[0] = max(1 + c - n_x, 0)
                for r in range(n_x):
                    unit[1 + r] = P[c * n_x + r]
                _project(tangents, unit, options.n_q, options.n)
                for r in range(n_x):
                    P[c * n_x + r] = unit[1 + r]
    for _ in range(SQUARINGS):
        changed = 0.0
        for c in range(columns):
            for r in range(n_x):
                Q[c * n_x + r] = _mapped(P, P[c * n_x : (c + 1) * n_x], max(1 + c - n_x, 0), r, n_x)
        for i in range(columns * n_x):
            if i < n_x * n_x:
                scale = tangents.weight[i % n_x] / tangents.weight[i // n_x]
                changed = max(changed, abs(Q[i] - P[i]) * scale)
            P[i] = Q[i]
        if changed <= SETTLED:
            break
    for i in range(len(tangents.alive)):
        if tangents.alive[i]:
            d = tangents.d[i * (1 + n_x) : (i + 1) * (1 + n_x)]
            for r in range(n_x):
                unit[1 + r] = _mapped(P, d[1:], int(d[0]), r, n_x)
            for r in range(n_x):
                d[1 + r] = unit[1 + r]


@inner
def _mapped(P, x, direction, r, n_x):
    """Component r of P x, and of the column of a direction, if above 0."""
    total = P[(n_x + direction - 1) * n_x + r] if direction > 0 else 0.0
    for i in range(n_x):
        total += P[i * n_x + r] * x[i]
    return total


@inner
def _project(tangents, d, n_q, n):
    """Positions as speeds, by D's part of them; then speeds by D, whose rows have a place for time."""
    width, new = 1 + n_q + n, tangents.S
    at, driven = _driven(d, width, n), d[0] > 0.0
    for r in range(n_q):
        new[r] = tangents.D[at + r] if driven else 0.0
        for i in range(n_q):
            new[r] += tangents.D[r * width + 1 + n_q + i] * d[1 + i]
    for r in range(n_q):
        d[1 + r] = new[r]
    for r in range(n):
        new[r] = tangents.D[at + n_q + r] if driven else 0.0
        for i in range(n_q + n):
            new[r] += tangents.D[r * width + 1 + i] * d[1 + i]
    for r in range(n):
        d[1 + n_q + r] = new[r]


@inner
def _driven(d, width, n):
    """Place in D of the column of a tangent's direction: new positions, new speeds."""
    return n * width + (int(d[0]) - 1) * (width - 1)


@inner
def _powers(motion, options, tangents, after):
    """Note the powers at the base point, whose rates are in the lane buffer, of one side of an event."""
    n_w = len(tangents.powers) // 2
    for m in range(n_w):
        tangents.powers[int(after) * n_w + m] = tangents.w[8 * (options.guards + len(motion.fired) + m) + 7]


@inner
def _add_works(tangents, i, delay):
    """Add the gain of the i-th tangent's works as the event comes earlier."""
    n_w = len(tangents.powers) // 2
    for m in range(n_w):
        tangents.works[i * n_w + m] += (tangents.powers[n_w + m] - tangents.powers[m]) * delay


@inner
def _drawn(tangents, d, n_q, n):
    """Derivative of the drive's work in an impact along a tangent, at the time of the event."""
    work, total = work_place(tangents, n_q, n), 0.0
    if work < len(tangents.D):
        for i in range(n_q + n):
            total += tangents.D[work + 1 + i] * d[1 + i]
        total += tangents.D[work + n_q + n + int(d[0])] if d[0] > 0.0 else 0.0
    return total


@inner
def _add_drawn(tangents, i, drawn, delay, n_q, n):
    """Add it to the works of the i-th tangent, which comes earlier to the event by `delay`."""
    work = work_place(tangents, n_q, n)
    if work < len(tangents.D):
        for r in range(n_q + n):
            drawn -= tangents.D[work + 1 + r] * tangents.before[r] * delay
        tangents.works[i * (len(tangents.powers) // 2) + DRIVE] += drawn - tangents.D[work] * delay


@inner
def _through(tangents, d, n_q, n_x, slope, reset, saltation):
    """Take a tangent through a jump; the time by which it comes earlier to the event."""
    width, delay = 1 + n_x, 0.0
    if saltation > 0.0:
        for r in range(n_x):
            delay += tangents.gradient[1 + r] * d[1 + r]
        if d[0] > 0.0:
            delay += tangents.gradient[n_x + int(d[0])]
        delay /= slope
    if reset == 0.0:
        for r in range(n_q, n_x):
            d[1 + r] += (tangents.after[r] - tangents.before[r]) * delay
        return delay
    new = tangents.S[n_x * n_x :]
    for r in range(n_x - n_q):
        turned, swept = 0.0, tangents.D[r * width]
        for i in range(n_x):
            turned += tangents.D[r * width + 1 + i] * d[1 + i]
            swept += tangents.D[r * width + 1 + i] * tangents.before[i]
        if d[0] > 0.0:
            turned += tangents.D[_driven(d, width, n_x - n_q) + n_q + r]
        new[r] = turned + (tangents.after[n_q + r] - swept) * delay
    for r in range(n_q):
        d[1 + r] += (tangents.after[r] - tangents.before[r]) * delay
    for r in range(n_x - n_q):
        d[1 + n_q + r] = new[r]
    return delay


@inner
def _volume(tangents, n_q, n_x, slope, later, reset, lossy):
    """ln |det S| of the jump."""
    if lossy:
        return -np.inf
    if not reset:
        return log(abs(later / slope)) if later != 0.0 else -np.inf
    for i in range(n_x):  # columns of S are the jumps of unit vectors
        for r in range(1 + n_x):
            tangents.unit[r] = 1.0 if r == 1 + i else 0.0
        _through(tangents, tangents.unit, n_q, n_x, slope, 1.0, 1.0)
        for r in range(n_x):
            tangents.S[r * n_x + i] = tangents.unit[1 + r]
    size = 1.0  # the product of the rows' sizes bounds the determinant
    for r in range(n_x):
        row = 0.0
        for i in range(n_x):
            row += abs(tangents.S[r * n_x + i]) * tangents.weight[r] / tangents.weight[i]
        size *= row
    found = abs(determinant(tangents.S, n_x))
    return log(found) if found > DEGENERATE * size else -np.inf


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
