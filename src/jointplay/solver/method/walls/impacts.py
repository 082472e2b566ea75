"""Impacts on several rigid walls at one instant, and impacts with friction.

Two corners of a slider meet a face together, or a journal meets its bearing while another rests in its own.
Newton's and Coulomb's laws hold for all walls at once on which bodies rest, or that are that near: within
what they move in the time in which events crowd. A wall that opens, or at which a body rests, counts with
r = 0. Single impacts in a row would not do: two corners of a light slider hand the impulse to each other
almost without end, ever faster.

Where the last rebounds from a rough wall are left out, friction goes with what they push. They push for m v
less than rest does in their time, v being the speed of the first: so a body is laid down by the impulse -m v
and its friction, as if it were an impact. Without that, its sliding would be wrong by f v.

Impulses: every choice of the walls' actions is tried. With v_i the rate of gap i, t_i the sliding speed
there, p_i and q_i the impulses along both, r the restitutions and f the friction coefficients,

    p_i >= 0,    v+_i + r_i v-_i >= 0,    p_i (v+_i + r_i v-_i) = 0          (Newton)
    q_i = -f_i p_i sign(t+_i),    |q_i| <= f_i p_i where t+_i = 0              (Coulomb)

Walls separate, stick, or slip one way or the other; smooth ones separate or push. The energy changes by the
sum of p_i (v+_i + v-_i)/2 + q_i (t+_i + t-_i)/2. With r = 0 it falls: it is the sum of p_i v+_i + q_i t+_i,
of which no term is positive, less the kinetic energy of the jump. Newton's r > 0 can make energy where
friction turns a body, or a wall opens (Kane and Levinson 1985): then all r are lowered by one share, until
none is made. References: Moreau (1988); Glocker, Set-Valued Force Laws (2001); Leine and Nijmeijer (2004);
Flores, Leine and Glocker, Multibody Syst. Dyn. 23 (2010) 165-190. Assumptions: rigid bodies, no tangential
restitution, one instant for normal and tangential impulses.
"""

from ..interface import inner
from ..memory import (
    AFTER,
    BEFORE,
    BEST,
    CHOICE,
    CHOSEN,
    DRIVE,
    EQUATIONS,
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
    SIMULTANEOUS,
    SIZE,
    STATE,
    TARGET,
    WALL,
)
from ..modes import FREE, IMPACT, RELEASED, contact_numbers
from ..record import count_event, note

SEPARATES, PUSHES, STICKS, SLIPS_UP, SLIPS_DOWN = range(5)  # what a wall may do
ROUNDING, SINGULAR = 1e-12, 1e-10
IMPOSSIBLE = 1e300  # contradiction of a choice without impulses
HALVINGS = 50


@inner
def rough(motion, j):
    """Whether wall j has friction."""
    return (
        len(motion.fired) > 3 * len(motion.flags) + len(motion.modes)
        and motion.cone[len(motion.flags) + j] > 0.0
    )


@inner
def together(functions, j, work, motion, options):
    """Impact on wall j, and on others at the same instant; False, and nothing done, if alone and smooth.

    The impulses and what each wall does are left in `Work.impact`.
    """
    q, members = work.impact, gather(functions, j, work, motion, options.chatter_time)
    if members == 1 and not rough(motion, j):
        return False
    prepare(functions, work, motion, members)
    solve(q, members, 1.0)
    if gain(q, members) > ROUNDING * size(q, members):
        lower(q, members)
    _apply(functions, j, work, motion, options, members)
    return True


@inner
def lay(functions, j, work, motion, options):
    """Take the rate of gap j away by impulses that rub as bodies slide; the share of restitution is 0 then.

    A body sticks where it is at rest, or where slip would need a pull.
    """
    q, members, own = work.impact, gather(functions, j, work, motion, -1.0), 0
    prepare(functions, work, motion, members)
    for held in range(2):
        for i in range(members):
            wall, v_t = int(q[WALL + i]), q[BEFORE + 2 * i + 1]
            slips = SLIPS_UP if v_t > 0.0 else SLIPS_DOWN
            still = held == 1 or abs(v_t) <= options.speed_tolerance
            q[CHOICE + i] = (STICKS if still else slips) if rough(motion, wall) else PUSHES
            own = i if wall == j else own
        if choose(q, members, 0.0) < IMPOSSIBLE and q[PUSH + 2 * own] * q[BEFORE + 2 * own] <= 0.0:
            _apply(functions, j, work, motion, options, members)
            q[SHARE] = 0.0
            return
    q[MEMBERS] = 0.0


@inner
def laid(work):
    """Whether the impulses in `Work.impact` were written by `lay`."""
    return work.impact[MEMBERS] > 0.0 and work.impact[SHARE] == 0.0


@inner
def plastic(work, wall):
    """Whether the impact leaves a body that meets this wall on it at once."""
    q, found = work.impact, False
    for i in range(int(q[MEMBERS])):
        found = found or (q[WALL + i] == wall and q[TARGET + i] == 0.0)
    return found


@inner
def gather(functions, j, work, motion, within):
    """Note wall j, walls on which bodies rest, and walls met within a time; their number."""
    members = 0
    contact_numbers(functions.contacts, motion.modes, motion.m, motion.s, motion.p, work.contact)
    for i in range(len(motion.modes) - len(motion.flags)):
        if i == j or _met(work, motion, within, i):
            motion.count[JAMMED] += members == MOST
            members = min(members, MOST - 1)
            work.impact[WALL + members] = i
            members += 1
    return members


@inner
def _met(work, motion, within, i):
    """Whether wall i takes part in an impact on another."""
    at = len(motion.flags) + i
    soon = within >= 0.0 and work.contact[6 * at] <= abs(work.contact[6 * at + 2]) * within
    return motion.group[i] >= 0 and (motion.modes[at] > RELEASED or soon)


@inner
def prepare(functions, work, motion, members):
    """Write the rates before an impact, their changes by unit impulses, and the wanted rates at walls."""
    q = work.impact
    q[MEMBERS], q[SHARE] = members, 1.0
    for r in range(len(motion.s)):
        q[STATE + r] = motion.s[r]
    for a in range(2 * members):
        wall = int(q[WALL + a // 2])
        q[BEFORE + a] = _rate(work, motion, a) if a % 2 == 0 or rough(motion, wall) else 0.0
    for i in range(members):
        _aim(functions, i, work, motion)


@inner
def push(functions, work, motion, a):
    """A unit impulse of unknown a, on the state at the base point."""
    walls, wall = len(motion.modes) - len(motion.flags), int(work.impact[WALL + a // 2])
    functions.reset(2 * len(motion.modes) + wall + (a % 2) * walls, motion.s, motion.p)


@inner
def _rate(work, motion, a):
    """Rate of the gap, or sliding speed, of unknown a, by the last contact numbers."""
    return work.contact[_place(work, motion, a)]


@inner
def _place(work, motion, a):
    """Place of rate a among the numbers of contacts."""
    walls = len(motion.modes) - len(motion.flags)
    return 6 * (len(motion.flags) + int(work.impact[WALL + a // 2]) + (a % 2) * walls) + 2


@inner
def drive_share(work, motion, a):
    """Work of a drive that imposes a speed, per impulse of unknown a, by the last contact numbers."""
    return work.contact[_place(work, motion, a) + 1]


@inner
def _aim(functions, i, work, motion):
    """Write the changes of the rates by impulses on the i-th wall, its friction, and its wanted rate."""
    q, first = work.impact, len(motion.flags)
    wall, walls = int(q[WALL + i]), len(motion.modes) - len(motion.flags)
    members, has = int(q[MEMBERS]), rough(motion, wall)
    at = 6 * (first + walls + wall)
    q[FRICTION + i] = work.contact[at] if has else 0.0
    r = work.contact[at + 1] if has else 0.0
    closing = q[BEFORE + 2 * i] < 0.0 and motion.modes[first + wall] == FREE
    if closing and not has:
        functions.reset(wall, motion.s, motion.p)
        contact_numbers(functions.contacts, motion.modes, motion.m, motion.s, motion.p, work.contact)
        r = -_rate(work, motion, 2 * i) / q[BEFORE + 2 * i]
        _back(work, motion)
    q[TARGET + i] = -r * q[BEFORE + 2 * i] if closing else 0.0
    for a in range(2 * i, 2 * i + 2):
        if a == 2 * i or has:
            push(functions, work, motion, a)
            contact_numbers(functions.contacts, motion.modes, motion.m, motion.s, motion.p, work.contact)
        for b in range(2 * members):
            turned = (a == 2 * i or has) and (b % 2 == 0 or rough(motion, int(q[WALL + b // 2])))
            q[MATRIX + SIZE * b + a] = _rate(work, motion, b) - q[BEFORE + b] if turned else 0.0
        _back(work, motion)


@inner
def _back(work, motion):
    for r in range(len(motion.s)):
        motion.s[r] = work.impact[STATE + r]


@inner
def _work(work, motion, members):
    """Add up the work of the impulses: the joints take it in, the drive answers it."""
    q = work.impact
    if len(motion.work) > JOINTS:
        motion.work[JOINTS] -= gain(q, members)
        for a in range(2 * members):
            motion.work[DRIVE] += q[PUSH + a] * drive_share(work, motion, a) if q[PUSH + a] != 0.0 else 0.0


@inner
def bring(functions, j, work, motion):
    """Add up the work of bringing a body to rest on wall j as well as on walls on which bodies rest already.

    Nothing moves: it is put there by `walls.settle` and `walls.stay`.
    """
    q, members = work.impact, gather(functions, j, work, motion, -1.0)
    prepare(functions, work, motion, members)
    for i in range(members):
        q[CHOICE + i] = PUSHES
    if choose(q, members, 0.0) < IMPOSSIBLE:
        _work(work, motion, members)
    q[MEMBERS] = 0.0


@inner
def bring_back(functions, work, motion, options):
    """Take away the gaps, then the rates, of all walls on which bodies rest; False if these are redundant.

    By the solution of all at once: of two corners of a light slider, taken in turn, next to nothing would go
    at a time. `Work.impact` stays as it is.
    """
    q, half = work.impact, len(work.impact) // 2
    for i in range(half):
        q[half + i] = q[i]
    members = gather(functions, -1, work, motion, -1.0)
    prepare(functions, work, motion, members)
    for i in range(members):
        q[BEFORE + 2 * i] = work.contact[6 * (len(motion.flags) + int(q[WALL + i]))]
    possible = _taken(functions, work, motion, options, members, 1)
    if possible:
        contact_numbers(functions.contacts, motion.modes, motion.m, motion.s, motion.p, work.contact)
        prepare(functions, work, motion, members)
        possible = _taken(functions, work, motion, options, members, 1 + options.n_q)
    for i in range(half):
        q[i] = q[half + i]
    return possible


@inner
def _taken(functions, work, motion, options, members, at):
    """Change the positions, or speeds, from place `at` of the state on, as impulses that leave no rate do."""
    q, s, first = work.impact, motion.s, 1 + options.n_q
    for i in range(members):
        q[CHOICE + i] = PUSHES
    if not choose(q, members, 0.0) < IMPOSSIBLE:
        return False
    for i in range(members):
        push(functions, work, motion, 2 * i)
        for r in range(options.n):
            change = q[PUSH + 2 * i] * (s[first + r] - q[STATE + first + r])
            s[first + r] = q[STATE + first + r]
            if at + r < first or at == first:
                s[at + r] += change
        for r in range(len(s)):
            q[STATE + r] = s[r]
    functions.trig(s, motion.p)
    return True


@inner
def _apply(functions, j, work, motion, options, members):
    """Note the impacts besides that on wall j; let the impulses act, which are work of joints and drive.

    Where neighbours meet walls one after the other, or restitutions were lowered, there are no tangents.
    """
    first, q, time = len(motion.flags), work.impact, motion.s[0]
    motion.count[SIMULTANEOUS] += q[SHARE] < 1.0
    _work(work, motion, members)
    for i in range(members):
        wall = int(q[WALL + i])
        if wall != j and q[PUSH + 2 * i] > 0.0 and motion.modes[first + wall] == FREE:
            motion.count[SIMULTANEOUS] += 1
            motion.count[EVENTS] += 1
            if options.log_events and time >= options.log_from:
                note(work, motion, options, EVENT_ROW, float(first + wall), float(IMPACT), time, 0.0)
    for a in range(2 * members):
        if q[PUSH + a] != 0.0:
            for r in range(len(motion.s)):
                work.predicted[r] = motion.s[r]
            push(functions, work, motion, a)
            for r in range(len(motion.s)):
                motion.s[r] = work.predicted[r] + q[PUSH + a] * (motion.s[r] - work.predicted[r])
    for i in range(members):
        wall = int(q[WALL + i])
        if wall != j and q[PUSH + 2 * i] > 0.0 and motion.modes[first + wall] == FREE:
            count_event(work, motion, options, first + wall, IMPACT, time)


@inner
def solve(q, members, share):
    """Impulses and rates after, with that share of the restitutions: of all choices the one that fits."""
    choices, fastest, least = 1, 0.0, IMPOSSIBLE
    for i in range(members):
        choices *= 4 if q[FRICTION + i] > 0.0 else 2
        fastest = max(fastest, abs(q[BEFORE + 2 * i]), abs(q[BEFORE + 2 * i + 1]))
    for code in range(choices):
        rest = code
        for i in range(members):
            options = 4 if q[FRICTION + i] > 0.0 else 2
            chosen = rest % options
            rest = rest // options
            q[CHOICE + i] = chosen if chosen == SEPARATES or options == 2 else chosen + 1
        wrong = choose(q, members, share)
        if wrong < least:
            least = wrong
            for a in range(SIZE):
                q[BEST + a], q[CHOSEN + a] = q[PUSH + a], q[CHOICE + a]
        if least <= ROUNDING * fastest:
            break
    for a in range(SIZE):
        q[PUSH + a], q[CHOICE + a] = q[BEST + a], q[CHOSEN + a]
    _after(q, members)


@inner
def unknown(q, a):
    """Whether the impulse of unknown a is to be solved for, in the present choice."""
    choice = q[CHOICE + a // 2]
    return choice > SEPARATES if a % 2 == 0 else choice == STICKS


@inner
def drawn(q, i):
    """Tangential impulse over the normal one of the i-th wall where it slips."""
    choice = q[CHOICE + i]
    return -q[FRICTION + i] if choice == SLIPS_UP else (q[FRICTION + i] if choice == SLIPS_DOWN else 0.0)


@inner
def equations(q, members):
    """Write the matrix of the present choice's unknowns, and give back their number."""
    n = 0
    for a in range(2 * members):
        if unknown(q, a):
            c = 0
            for b in range(2 * members):
                if unknown(q, b):
                    entry = q[MATRIX + SIZE * a + b]
                    entry += drawn(q, b // 2) * q[MATRIX + SIZE * a + b + 1] if b % 2 == 0 else 0.0
                    q[EQUATIONS + (SIZE + 1) * n + c] = entry
                    c += 1
            n += 1
    return n


@inner
def choose(q, members, share):
    """Impulses of the present choice, and the size of its contradiction, as a speed."""
    n = equations(q, members)
    c = 0
    for a in range(2 * members):
        if unknown(q, a):
            aim = share * q[TARGET + a // 2] if a % 2 == 0 else 0.0
            q[EQUATIONS + (SIZE + 1) * c + SIZE] = aim - q[BEFORE + a]
            c += 1
    if not eliminate(q[EQUATIONS:], n):
        return IMPOSSIBLE
    n = 0
    for a in range(2 * members):
        q[PUSH + a] = drawn(q, a // 2) * q[PUSH + a - 1] if a % 2 == 1 else 0.0
        if unknown(q, a):
            q[PUSH + a] = q[EQUATIONS + (SIZE + 1) * n + SIZE]
            n += 1
    _after(q, members)
    wrong = 0.0
    for i in range(members):
        normal, along, choice = 2 * i, 2 * i + 1, q[CHOICE + i]
        if choice == SEPARATES:
            wrong = max(wrong, share * q[TARGET + i] - q[AFTER + normal])
        else:
            wrong = max(wrong, -q[PUSH + normal] * q[MATRIX + (SIZE + 1) * normal])
        if choice == STICKS:
            beyond = abs(q[PUSH + along]) - q[FRICTION + i] * q[PUSH + normal]
            wrong = max(wrong, beyond * q[MATRIX + (SIZE + 1) * along])
        elif choice > STICKS:
            wrong = max(wrong, -q[AFTER + along] if choice == SLIPS_UP else q[AFTER + along])
    return wrong


@inner
def _after(q, members):
    """Rates after the impulses."""
    for a in range(2 * members):
        total = q[BEFORE + a]
        for b in range(2 * members):
            total += q[MATRIX + SIZE * a + b] * q[PUSH + b]
        q[AFTER + a] = total


@inner
def eliminate(E, n):
    """Solve n equations in rows of SIZE + 1, right-hand sides last; False if they are singular."""
    width, largest = SIZE + 1, 0.0
    for r in range(n):
        for c in range(n):
            largest = max(largest, abs(E[width * r + c]))
    for c in range(n):
        p = c
        for r in range(c + 1, n):
            p = r if abs(E[width * r + c]) > abs(E[width * p + c]) else p
        if not abs(E[width * p + c]) > SINGULAR * largest:
            return False
        for i in range(width):
            E[width * c + i], E[width * p + i] = E[width * p + i], E[width * c + i]
        for r in range(n):
            if r != c:
                ratio = E[width * r + c] / E[width * c + c]
                for i in range(c, n):
                    E[width * r + i] -= ratio * E[width * c + i]
                E[width * r + SIZE] -= ratio * E[width * c + SIZE]
    for r in range(n):
        E[width * r + SIZE] /= E[width * r + r]
    return True


@inner
def gain(q, members):
    """Kinetic energy that the impulses add."""
    total = 0.0
    for a in range(2 * members):
        total += 0.5 * q[PUSH + a] * (q[BEFORE + a] + q[AFTER + a])
    return total


@inner
def size(q, members):
    """Size of the terms of `_gain`."""
    total = 0.0
    for a in range(2 * members):
        total += abs(q[PUSH + a]) * (abs(q[BEFORE + a]) + abs(q[AFTER + a]))
    return total


@inner
def lower(q, members):
    """Lower all restitutions by one share, to where no energy is made."""
    low, high = 0.0, 1.0
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        solve(q, members, middle)
        if gain(q, members) > 0.0:
            high = middle
        else:
            low = middle
    solve(q, members, low)
    q[SHARE] = low
