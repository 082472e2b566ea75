"""Saltation: the jump of tangents at an event.

The guard's gradient says how much earlier or later a neighbour meets it, and for that time it moves at the
other side's rate:

    d+ = d- + (F+ - F-) (grad h . d-) / h',                 h' = dh/dt + grad h . F-
    d+ = D d- + (F+ - D F- - dR/dt) (grad h . d-) / h'      where the state is reset by R, D = dR/dx.

Along a direction in which numbers change (method.tangents.tangent), dh/dp adds to grad h . d-, and dR/dp to D
d-. A work, whose rate is a power, jumps as a state does that is continuous itself; that of a drive which
imposes a speed as one that an impact resets.

Several mode changes at one event are one jump from F- to F+. Onset of sticking loses a dimension, and so do
the beginning and the end of a contact that a law remembers: what it remembered before is of no account. A
start that sticks is an onset too: neighbours that slide come to stick at once, by the same projection from
either side. Coming to rest on a rigid wall loses two, those of the gap and of its rate. It is a reset like
others, that of a plastic impact (method.tangents.impact_map), after which the gap stays closed: F+ is the
rate at rest. A neighbour that rests as the motion does has its gap and rate closed too, whatever numbers it
differs in: what rounding leaves there is projected away along the wall's impulse, of several walls in turn.
References: Leine and Nijmeijer (2004), chapter 7; Kong et al., arXiv 2306.06862.
"""

from math import log

import numpy as np

from ..interface import inner
from ..memory import DRIVE, MEMBERS, TOGETHER
from ..modes import FREE, RELEASED, REMEMBERS, SLIDE, SLIP_POSITIVE, STICK, variant_of
from ..walls.impacts import laid
from ..walls.sliding import walls_of
from ..walls.walls import SWEEPS, resting
from .frame import determinant, orthonormalise
from .impact_map import impact_map, landing_map, loses, work_place
from .tangent import FOLLOWS, GRAZING, HELD, JUMPS, NEUTRAL, ONSET, SALTATION, TURNED, VOLUME, along, rates

# What Tangents.count[TURNED] says of a contact that a law remembers; 1: a wall is met; 0: neither
ENTERS, MAY_LEAVE = 2, 3
DEGENERATE = 1e-13  # of a determinant's bound: what is less is rounding of 0


@inner
def stuck(modes):
    """Number of contacts that stick."""
    held = 0
    for mode in modes:
        held += mode == STICK
    return held


@inner
def _wall_of(x, guard):
    """The rigid wall whose gap or push a guard is; -1 if it is none's."""
    wall = guard - 4 * len(x.flags)
    return wall if wall < walls_of(x) else -1


@inner
def before_event(f, g, variant, x, o, y, guard):
    """Note the values before an event that the jump of the tangents needs."""
    f.trig(x.s, x.p)
    for r in range(len(x.s)):
        y.state[r] = x.s[r]
    y.count[FOLLOWS] = 0
    rates(f, variant, x, o, y, y.before)
    _powers(x, o, y, 0.0)
    g.gradient(guard, x.s, x.p, x.m, y.gradient)
    wall, y.real[ONSET], y.count[TURNED] = _wall_of(x, guard), stuck(x.modes), 0
    if wall >= 0 and x.modes[len(x.flags) + wall] > RELEASED:
        y.real[ONSET] = np.inf  # it lets go: nothing jumps, nothing is lost
    elif wall >= 0:
        g.turned(wall, x.s, x.p, y.D)
        y.count[TURNED] = 1
    elif guard < 4 * len(x.flags) and x.flags[guard // 4] & REMEMBERS:
        y.count[TURNED] = ENTERS if x.modes[guard // 4] == FREE else MAY_LEAVE


@inner
def jump(f, g, k, x, o, y, guard):
    """Take the tangents through an event that has just been handled."""
    wall, turned = _wall_of(x, guard), y.count[TURNED]
    leaves = turned == MAY_LEAVE and x.modes[guard // 4] == FREE
    if turned == ENTERS or leaves:  # of what else the state holds, that is no function of what jumps
        g.turned(2 * walls_of(x) + guard // 4 + leaves * len(x.flags), x.s, x.p, y.D)
    reset = turned == 1 or turned == ENTERS or leaves
    rests = reset and wall >= 0 and x.modes[len(x.flags) + wall] > RELEASED
    several = reset and wall >= 0 and k.impact[MEMBERS] > 0.0
    held = reset and wall >= 0 and resting(x) > 0 and x.group[wall] >= 0
    if rests or (held and (laid(k) or not several)):  # others were put back on their walls in between
        if not landing_map(f, g, k, x, o, y, wall, resting(x) > (1 if rests else 0)):
            x.count[TOGETHER] += 1
    elif several:
        impact_map(f, g, k, x, o, y)
    rates(f, variant_of(x.modes), x, o, y, y.after)
    _powers(x, o, y, 1.0)
    lossy = stuck(x.modes) > y.real[ONSET] or (reset and wall < 0)  # what was remembered before is lost
    lossy = lossy or rests or (several and loses(k))
    if through(y, o.n_q, o.n_q + o.n, reset, lossy) and (rests or (several and resting(x) > 0)):
        project_at_rest(f, g, x, o, y, 0.0)


@inner
def through(y, n_q, n_x, reset, lossy):
    """Take the frame through an event, by the rates on both sides; whether the guard moves there."""
    width, real = 1 + n_x, y.real
    slope, size, later = y.gradient[0], abs(y.gradient[0]), y.gradient[0]
    for r in range(n_x):
        term = y.gradient[1 + r] * y.before[r]
        slope += term
        size += abs(term)
        later += y.gradient[1 + r] * y.after[r]
    real[GRAZING] = min(real[GRAZING], abs(slope) / size if size > 0.0 else 0.0)
    if slope == 0.0:
        return False
    y.count[JUMPS] += 1
    real[VOLUME] += _volume(y, n_q, n_x, slope, later, reset, lossy)
    for i in range(len(y.alive)):
        if y.alive[i]:
            d = y.d[i * width : (i + 1) * width]
            drawn = _drawn(y, d, n_q, n_x - n_q) if reset else 0.0
            delay = _through(y, d, n_q, n_x, slope, 1.0 if reset else 0.0, float(y.count[SALTATION]))
            _add_works(y, i, delay)
            if drawn != 0.0 or (reset and delay != 0.0):
                _add_drawn(y, i, drawn, delay, n_q, n_x - n_q)
    if y.count[NEUTRAL]:
        along(y, n_x)
    if y.count[HELD] == 0:
        orthonormalise(y.d, width, y.weight, y.alive, y.norms, y.logs, 1.0 if lossy or reset else 0.0)
    return True


@inner
def begin_tangents(f, g, x, o, y):
    """Remove from the tangents the parts that neighbours of a sticking or resting start lose at once."""
    held = 0.0
    for j in range(len(x.flags)):
        if x.modes[j] == STICK:
            held = 1.0
            _project_at_stick(f, g, x, o, y, j)
    project_at_rest(f, g, x, o, y, held)


@inner
def _project_at_stick(f, g, x, o, y, j):
    """Take the tangents through the onset of sticking of contact j, from either side."""
    n_x, x.modes[j] = o.n_q + o.n, SLIP_POSITIVE
    width, slope = 1 + n_x, 0.0
    rates(f, variant_of(x.modes), x, o, y, y.before)
    _powers(x, o, y, 0.0)
    g.gradient(4 * j + SLIDE, x.s, x.p, x.m, y.gradient)
    for r in range(n_x):
        slope += y.gradient[1 + r] * y.before[r]
    slope += y.gradient[0]
    x.modes[j] = STICK
    rates(f, variant_of(x.modes), x, o, y, y.after)
    _powers(x, o, y, 1.0)
    for i in range(len(y.alive)):
        if y.alive[i]:
            d = y.d[i * width : (i + 1) * width]
            _add_works(y, i, _through(y, d, o.n_q, n_x, slope, 0.0, float(y.count[SALTATION])))


@inner
def project_at_rest(f, g, x, o, y, held):
    """Remove from the tangents the parts across the walls on which a body rests.

    `held`: 1, where something has been taken already.
    """
    walls = len(x.modes) - len(x.flags)
    for n in range(walls if resting(x) < 2 else walls * SWEEPS):
        j = n % walls
        if x.modes[len(x.flags) + j] > RELEASED:
            held = 1.0
            g.turned(walls + j, x.s, x.p, y.D)
            _project_all(y, o)
    if held > 0.0:
        y.count[JUMPS] += 1
        y.real[VOLUME] = -np.inf
        if y.count[NEUTRAL]:
            rates(f, variant_of(x.modes), x, o, y, y.after)
            along(y, o.n_q + o.n)
        if y.count[HELD] == 0:
            orthonormalise(y.d, 1 + o.n_q + o.n, y.weight, y.alive, y.norms, y.logs, 1.0)


@inner
def _project_all(y, o):
    width = 1 + o.n_q + o.n
    for i in range(len(y.alive)):
        if y.alive[i]:
            _project(y, y.d[i * width : (i + 1) * width], o.n_q, o.n)


@inner
def _project(y, d, n_q, n):
    """Positions as speeds, by D's part of them; then speeds by D, whose rows have a place for time."""
    width, new = 1 + n_q + n, y.S
    at, driven = _driven(d, width, n), d[0] > 0.0
    for r in range(n_q):
        new[r] = y.D[at + r] if driven else 0.0
        for i in range(n_q):
            new[r] += y.D[r * width + 1 + n_q + i] * d[1 + i]
    for r in range(n_q):
        d[1 + r] = new[r]
    for r in range(n):
        new[r] = y.D[at + n_q + r] if driven else 0.0
        for i in range(n_q + n):
            new[r] += y.D[r * width + 1 + i] * d[1 + i]
    for r in range(n):
        d[1 + n_q + r] = new[r]


@inner
def _driven(d, width, n):
    """Place in D of the column of a tangent's direction: new positions, new speeds."""
    return n * width + (int(d[0]) - 1) * (width - 1)


@inner
def _powers(x, o, y, after):
    """Note the powers at the base point, whose rates are in the lane buffer, of one side of an event."""
    n_w = len(y.powers) // 2
    for m in range(n_w):
        y.powers[int(after) * n_w + m] = y.w[8 * (o.guards + len(x.fired) + m) + 7]


@inner
def _add_works(y, i, delay):
    """Add the gain of the i-th tangent's works as the event comes earlier."""
    n_w = len(y.powers) // 2
    for m in range(n_w):
        y.works[i * n_w + m] += (y.powers[n_w + m] - y.powers[m]) * delay


@inner
def _drawn(y, d, n_q, n):
    """Derivative of the drive's work in an impact along a tangent, at the time of the event."""
    work, total = work_place(y, n_q, n), 0.0
    if work < len(y.D):
        for i in range(n_q + n):
            total += y.D[work + 1 + i] * d[1 + i]
        total += y.D[work + n_q + n + int(d[0])] if d[0] > 0.0 else 0.0
    return total


@inner
def _add_drawn(y, i, drawn, delay, n_q, n):
    """Add it to the works of the i-th tangent, which comes earlier to the event by `delay`."""
    work = work_place(y, n_q, n)
    if work < len(y.D):
        for r in range(n_q + n):
            drawn -= y.D[work + 1 + r] * y.before[r] * delay
        y.works[i * (len(y.powers) // 2) + DRIVE] += drawn - y.D[work] * delay


@inner
def _through(y, d, n_q, n_x, slope, reset, saltation):
    """Take a tangent through a jump; the time by which it comes earlier to the event."""
    width, delay = 1 + n_x, 0.0
    if saltation > 0.0:
        for r in range(n_x):
            delay += y.gradient[1 + r] * d[1 + r]
        if d[0] > 0.0:
            delay += y.gradient[n_x + int(d[0])]
        delay /= slope
    if reset == 0.0:
        for r in range(n_q, n_x):
            d[1 + r] += (y.after[r] - y.before[r]) * delay
        return delay
    new = y.S[n_x * n_x :]
    for r in range(n_x - n_q):
        turned, swept = 0.0, y.D[r * width]
        for i in range(n_x):
            turned += y.D[r * width + 1 + i] * d[1 + i]
            swept += y.D[r * width + 1 + i] * y.before[i]
        if d[0] > 0.0:
            turned += y.D[_driven(d, width, n_x - n_q) + n_q + r]
        new[r] = turned + (y.after[n_q + r] - swept) * delay
    for r in range(n_q):
        d[1 + r] += (y.after[r] - y.before[r]) * delay
    for r in range(n_x - n_q):
        d[1 + n_q + r] = new[r]
    return delay


@inner
def _volume(y, n_q, n_x, slope, later, reset, lossy):
    """ln |det S| of the jump."""
    if lossy:
        return -np.inf
    if not reset:
        return log(abs(later / slope)) if later != 0.0 else -np.inf
    for i in range(n_x):  # columns of S are the jumps of unit vectors
        for r in range(1 + n_x):
            y.unit[r] = 1.0 if r == 1 + i else 0.0
        _through(y, y.unit, n_q, n_x, slope, 1.0, 1.0)
        for r in range(n_x):
            y.S[r * n_x + i] = y.unit[1 + r]
    size = 1.0  # the product of the rows' sizes bounds the determinant
    for r in range(n_x):
        row = 0.0
        for i in range(n_x):
            row += abs(y.S[r * n_x + i]) * y.weight[r] / y.weight[i]
        size *= row
    found = abs(determinant(y.S, n_x))
    return log(found) if found > DEGENERATE * size else -np.inf
