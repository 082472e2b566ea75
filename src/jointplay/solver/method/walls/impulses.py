"""Impulses of an impact on several walls at once, with friction: every choice of their actions is tried.

With v_i the rate of gap i, t_i the sliding speed there, p_i and q_i the impulses along both, r the
restitutions and f the friction coefficients,

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
    EQUATIONS,
    FRICTION,
    MATRIX,
    PUSH,
    SHARE,
    SIZE,
    TARGET,
)

SEPARATES, PUSHES, STICKS, SLIPS_UP, SLIPS_DOWN = range(5)  # what a wall may do
ROUNDING, SINGULAR = 1e-12, 1e-10
IMPOSSIBLE = 1e300  # contradiction of a choice without impulses
HALVINGS = 50


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
