"""Impacts on several rigid walls at one instant, and impacts with friction.

Two corners of a slider meet a face together, or a journal meets its bearing while another rests in its own.
Newton's and Coulomb's laws (method.walls.impulses) hold for all walls at once on which bodies rest, or that
are that near: within what they move in the time in which events crowd. A wall that opens, or at which a body
rests, counts with r = 0. Single impacts in a row would not do: two corners of a light slider hand the impulse
to each other almost without end, ever faster.

Where the last rebounds from a rough wall are left out, friction goes with what they push. They push for m v
less than rest does in their time, v being the speed of the first: so a body is laid down by the impulse -m v
and its friction, as if it were an impact. Without that, its sliding would be wrong by f v.
"""

from ..interface import inner
from ..memory import (
    BEFORE,
    CHOICE,
    DRIVE,
    EVENT_ROW,
    EVENTS,
    FRICTION,
    JAMMED,
    JOINTS,
    MATRIX,
    MEMBERS,
    MOST,
    PUSH,
    SHARE,
    SIZE,
    STATE,
    TARGET,
    TOGETHER,
    WALL,
)
from ..modes import FREE, IMPACT, RELEASED, look
from ..record import note
from ..sections import count_event
from .impulses import (
    IMPOSSIBLE,
    PUSHES,
    ROUNDING,
    SLIPS_DOWN,
    SLIPS_UP,
    STICKS,
    choose,
    gain,
    lower,
    size,
    solve,
)


@inner
def rough(x, j):
    """Whether wall j has friction."""
    return len(x.fired) > 3 * len(x.flags) + len(x.modes) and x.cone[len(x.flags) + j] > 0.0


@inner
def together(f, j, k, x, o):
    """Impact on wall j, and on others at the same instant; False, and nothing done, if alone and smooth.

    The impulses and what each wall does are left in `Work.impact`.
    """
    q, members = k.impact, gather(f, j, k, x, o.near)
    if members == 1 and not rough(x, j):
        return False
    prepare(f, k, x, members)
    solve(q, members, 1.0)
    if gain(q, members) > ROUNDING * size(q, members):
        lower(q, members)
    _apply(f, j, k, x, o, members)
    return True


@inner
def lay(f, j, k, x, o):
    """Take the rate of gap j away by impulses that rub as bodies slide; the share of restitution is 0 then.

    A body sticks where it is at rest, or where slip would need a pull.
    """
    q, members, own = k.impact, gather(f, j, k, x, -1.0), 0
    prepare(f, k, x, members)
    for held in range(2):
        for i in range(members):
            wall, v_t = int(q[WALL + i]), q[BEFORE + 2 * i + 1]
            slips = SLIPS_UP if v_t > 0.0 else SLIPS_DOWN
            still = held == 1 or abs(v_t) <= o.rest
            q[CHOICE + i] = (STICKS if still else slips) if rough(x, wall) else PUSHES
            own = i if wall == j else own
        if choose(q, members, 0.0) < IMPOSSIBLE and q[PUSH + 2 * own] * q[BEFORE + 2 * own] <= 0.0:
            _apply(f, j, k, x, o, members)
            q[SHARE] = 0.0
            return
    q[MEMBERS] = 0.0


@inner
def laid(k):
    """Whether the impulses in `Work.impact` were written by `lay`."""
    return k.impact[MEMBERS] > 0.0 and k.impact[SHARE] == 0.0


@inner
def plastic(k, wall):
    """Whether the impact leaves a body that meets this wall on it at once."""
    q, found = k.impact, False
    for i in range(int(q[MEMBERS])):
        found = found or (q[WALL + i] == wall and q[TARGET + i] == 0.0)
    return found


@inner
def gather(f, j, k, x, near):
    """Note wall j, walls on which bodies rest, and walls met within the time `near`; their number."""
    members = 0
    look(f.contacts, x.modes, x.m, x.s, x.p, k.contact)
    for i in range(len(x.modes) - len(x.flags)):
        if i == j or _met(k, x, near, i):
            x.count[JAMMED] += members == MOST
            members = min(members, MOST - 1)
            k.impact[WALL + members] = i
            members += 1
    return members


@inner
def _met(k, x, near, i):
    """Whether wall i takes part in an impact on another."""
    at = len(x.flags) + i
    soon = near >= 0.0 and k.contact[6 * at] <= abs(k.contact[6 * at + 2]) * near
    return x.group[i] >= 0 and (x.modes[at] > RELEASED or soon)


@inner
def prepare(f, k, x, members):
    """Write the rates before an impact, their changes by unit impulses, and the wanted rates at walls."""
    q = k.impact
    q[MEMBERS], q[SHARE] = members, 1.0
    for r in range(len(x.s)):
        q[STATE + r] = x.s[r]
    for a in range(2 * members):
        wall = int(q[WALL + a // 2])
        q[BEFORE + a] = _rate(k, x, a) if a % 2 == 0 or rough(x, wall) else 0.0
    for i in range(members):
        _aim(f, i, k, x)


@inner
def push(f, k, x, a):
    """A unit impulse of unknown a, on the state in x.s."""
    walls, wall = len(x.modes) - len(x.flags), int(k.impact[WALL + a // 2])
    f.reset(2 * len(x.modes) + wall + (a % 2) * walls, x.s, x.p)


@inner
def _rate(k, x, a):
    """Rate of the gap, or sliding speed, of unknown a, by the last contact numbers."""
    return k.contact[_place(k, x, a)]


@inner
def _place(k, x, a):
    """Place of rate a among the numbers of contacts."""
    walls = len(x.modes) - len(x.flags)
    return 6 * (len(x.flags) + int(k.impact[WALL + a // 2]) + (a % 2) * walls) + 2


@inner
def drive_share(k, x, a):
    """Work of a drive that imposes a speed, per impulse of unknown a, by the last contact numbers."""
    return k.contact[_place(k, x, a) + 1]


@inner
def _aim(f, i, k, x):
    """Write the changes of the rates by impulses on the i-th wall, its friction, and its wanted rate."""
    q, first = k.impact, len(x.flags)
    wall, walls = int(q[WALL + i]), len(x.modes) - len(x.flags)
    members, has = int(q[MEMBERS]), rough(x, wall)
    at = 6 * (first + walls + wall)
    q[FRICTION + i] = k.contact[at] if has else 0.0
    r = k.contact[at + 1] if has else 0.0
    closing = q[BEFORE + 2 * i] < 0.0 and x.modes[first + wall] == FREE
    if closing and not has:
        f.reset(wall, x.s, x.p)
        look(f.contacts, x.modes, x.m, x.s, x.p, k.contact)
        r = -_rate(k, x, 2 * i) / q[BEFORE + 2 * i]
        _back(k, x)
    q[TARGET + i] = -r * q[BEFORE + 2 * i] if closing else 0.0
    for a in range(2 * i, 2 * i + 2):
        if a == 2 * i or has:
            push(f, k, x, a)
            look(f.contacts, x.modes, x.m, x.s, x.p, k.contact)
        for b in range(2 * members):
            turned = (a == 2 * i or has) and (b % 2 == 0 or rough(x, int(q[WALL + b // 2])))
            q[MATRIX + SIZE * b + a] = _rate(k, x, b) - q[BEFORE + b] if turned else 0.0
        _back(k, x)


@inner
def _back(k, x):
    for r in range(len(x.s)):
        x.s[r] = k.impact[STATE + r]


@inner
def _work(k, x, members):
    """Add up the work of the impulses: the joints take it in, the drive answers it."""
    q = k.impact
    if len(x.work) > JOINTS:
        x.work[JOINTS] -= gain(q, members)
        for a in range(2 * members):
            x.work[DRIVE] += q[PUSH + a] * drive_share(k, x, a) if q[PUSH + a] != 0.0 else 0.0


@inner
def bring(f, j, k, x):
    """Add up the work of bringing a body to rest on wall j as well as on walls on which bodies rest already.

    Nothing moves: it is put there by `walls.settle` and `walls.stay`.
    """
    q, members = k.impact, gather(f, j, k, x, -1.0)
    prepare(f, k, x, members)
    for i in range(members):
        q[CHOICE + i] = PUSHES
    if choose(q, members, 0.0) < IMPOSSIBLE:
        _work(k, x, members)
    q[MEMBERS] = 0.0


@inner
def _apply(f, j, k, x, o, members):
    """Note the impacts besides that on wall j; let the impulses act, which are work of joints and drive.

    Where neighbours meet walls one after the other, or restitutions were lowered, there are no tangents.
    """
    first, q, time = len(x.flags), k.impact, x.s[0]
    x.count[TOGETHER] += q[SHARE] < 1.0
    _work(k, x, members)
    for i in range(members):
        wall = int(q[WALL + i])
        if wall != j and q[PUSH + 2 * i] > 0.0 and x.modes[first + wall] == FREE:
            x.count[TOGETHER] += 1
            x.count[EVENTS] += 1
            if o.log_events and time >= o.log_from:
                note(k, x, o, EVENT_ROW, float(first + wall), float(IMPACT), time, 0.0)
    for a in range(2 * members):
        if q[PUSH + a] != 0.0:
            for r in range(len(x.s)):
                k.ahead[r] = x.s[r]
            push(f, k, x, a)
            for r in range(len(x.s)):
                x.s[r] = k.ahead[r] + q[PUSH + a] * (x.s[r] - k.ahead[r])
    for i in range(members):
        wall = int(q[WALL + i])
        if wall != j and q[PUSH + 2 * i] > 0.0 and x.modes[first + wall] == FREE:
            count_event(k, x, o, first + wall, IMPACT, time)
