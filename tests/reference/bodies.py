"""Free bodies: the four-bar with play, written link by link with Newton's laws and joint reactions.

Every link keeps its three accelerations; ideal joints, a prescribed crank speed and sticking contacts are
rows of one linear system whose extra unknowns are the reactions. Nothing here uses a reduced mass matrix,
so agreement with the package is agreement of two derivations.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

LINKS = ("crank", "coupler", "rocker")
GROUND = -1
MODES = ("free", "released", "slip+", "slip-", "stick")


@dataclass(frozen=True)
class Parameters:
    """Table 1 of the paper, in SI units, with the gear ratio ``i``, clearance ``e`` and friction ``f``.

    ``drive`` is ``"motor"`` (torque a - b w), ``"speed"`` (crank at a/b for ever) or ``"none"``.
    """

    l1: float = 0.181
    l2: float = 0.1175
    l3: float = 0.03
    l4: float = 0.2
    m1: float = 0.1743
    m2: float = 0.2916
    m3: float = 0.4489
    J_A: float = 2.7e-3
    J_C: float = 1.34e-3
    J_O: float = 1.5e-4
    R: float = 0.015
    K: float = 7.15e6
    C_n: float = 228.0
    C_t: float = 0.0
    f: float = 0.01
    n_C: float = 3000.0
    n_B: float = 2825.0
    M_b: float = 2.2
    mu: float = 0.8
    i: float = 15.0
    e: float = 2.9e-5
    gravity: float = 9.8
    tension: bool = True
    drive: str = "motor"

    @property
    def a(self):
        """Stall torque on the crank, N m: equation (1)."""
        return self.i * self.mu * 9.8 * self.n_C * self.M_b / (self.n_C - self.n_B)

    @property
    def b(self):
        """Slope of the motor line, N m s: equation (2) as printed."""
        return self.i**2 * 60 * 9.8 * self.M_b / (2 * math.pi * (self.n_C - self.n_B))

    @property
    def w0(self):
        """No-load crank speed a/b, rad/s."""
        return self.a / self.b


def closure(p):
    """Angles and speeds (crank, coupler, rocker) of the ideal mechanism, crank at 0, rocker above ground."""
    gap = p.l4 - p.l3  # A = (l3, 0) and C = (l4, 0): B is where two circles about them meet
    x = (gap**2 + p.l1**2 - p.l2**2) / (2 * gap)
    y = math.sqrt(p.l1**2 - x**2)
    angles = [0.0, math.atan2(y, x), math.atan2(y, x - gap)]
    # velocity of B seen from both sides, A moving straight up at l3 w0
    columns = np.array([[-y, y], [x, gap - x]])
    coupler, rocker = np.linalg.solve(columns, [0.0, -p.l3 * p.w0])
    return angles, [p.w0, float(coupler), float(rocker)]


@dataclass(frozen=True)
class Contact:
    """One clearance joint: r, r', direction of r, |r|, penetration, normal and slip speed, F_n."""

    r: tuple
    rate: tuple
    normal: tuple
    rho: float
    u: float
    v_n: float
    v_t: float
    force: float


class Bodies:
    """Right-hand side and guards of the mechanism with play at the joints of ``clearance`` (name -> e, m).

    The state is (three link angles, x and y of each floating base, their rates); a floating base is the
    origin of the first link of a part that no ideal joint ties to the ground.
    """

    def __init__(self, p, clearance):
        self.p, self.clearance = p, dict(clearance)
        self.mass = (p.m3, p.m1, p.m2)
        self.centre = (p.l3 / 2, p.l1 / 2, p.l2 / 2)
        about_origin = (p.J_O, p.J_A, p.J_C)
        self.inertia = [J - m * s * s for J, m, s in zip(about_origin, self.mass, self.centre, strict=True)]
        self.joints = {
            "O": ((0, 0.0), (GROUND, (0.0, 0.0))),
            "A": ((0, p.l3), (1, 0.0)),
            "B": ((1, p.l1), (2, p.l2)),
            "C": ((2, 0.0), (GROUND, (p.l4, 0.0))),
        }
        self.ideal = [name for name in self.joints if name not in self.clearance]
        self._plan()
        self.n = 3 + 2 * len(self.bases)
        self.evaluations = 0

    def _plan(self):
        """Order in which link origins can be placed: through ideal joints, else from a floating base."""
        self.steps, self.bases, known = [], [], {GROUND}
        while len(known) < 4:
            for name in self.ideal:
                sides = self.joints[name]
                new, old = sides if sides[1][0] in known else sides[::-1]
                if old[0] in known and new[0] not in known:
                    self.steps.append((new[0], new[1], old))
                    known.add(new[0])
                    break
            else:
                link = min({0, 1, 2} - known)
                self.steps.append((link, 3 + 2 * len(self.bases), None))
                self.bases.append(link)
                known.add(link)

    def start(self):
        """State of the ideal mechanism at crank angle 0, with every journal centred in its bearing."""
        angles, speeds = closure(self.p)
        w = speeds[0] * self.p.l3
        position = {0: (0.0, 0.0), 1: (self.p.l3, 0.0), 2: (self.p.l4, 0.0)}
        velocity = {0: (0.0, 0.0), 1: (0.0, w), 2: (0.0, 0.0)}
        bases = [c for link in self.bases for c in position[link]]
        rates = [c for link in self.bases for c in velocity[link]]
        return np.array([*angles, *bases, *speeds, *rates])

    def motion(self, y):
        """Directions, origins, origin velocities and speeds of the links."""
        y = [float(v) for v in y]
        n = self.n
        e = [(math.cos(angle), math.sin(angle)) for angle in y[:3]]
        w = y[n : n + 3]
        P, V = [None] * 3, [None] * 3
        for link, x, old in self.steps:
            if old is None:
                P[link], V[link] = (y[x], y[x + 1]), (y[n + x], y[n + x + 1])
                continue
            (px, py), (vx, vy) = self._point(old, e, w, P, V)
            P[link] = (px - x * e[link][0], py - x * e[link][1])
            V[link] = (vx + x * w[link] * e[link][1], vy - x * w[link] * e[link][0])
        return e, w, P, V

    @staticmethod
    def _point(place, e, w, P, V):
        link, x = place
        if link == GROUND:
            return x, (0.0, 0.0)
        c, s = e[link]
        return (P[link][0] + x * c, P[link][1] + x * s), (
            V[link][0] - x * w[link] * s,
            V[link][1] + x * w[link] * c,
        )

    def contact(self, name, y, motion=None):
        """Contact quantities of a clearance joint; direction and rates are 0 where the journal is centred."""
        e, w, P, V = motion or self.motion(y)
        journal, bearing = self.joints[name]
        (ax, ay), (avx, avy) = self._point(journal, e, w, P, V)
        (bx, by), (bvx, bvy) = self._point(bearing, e, w, P, V)
        rx, ry, vx, vy = ax - bx, ay - by, avx - bvx, avy - bvy
        rho = math.hypot(rx, ry)
        u = rho - self.clearance[name]
        if rho == 0.0:
            return Contact((rx, ry), (vx, vy), (0.0, 0.0), rho, u, 0.0, 0.0, 0.0)
        c, s = rx / rho, ry / rho
        v_n = vx * c + vy * s
        w_p, w_q = w[journal[0]], 0.0 if bearing[0] == GROUND else w[bearing[0]]
        v_t = vy * c - vx * s + w_p * self.p.R - w_q * (self.p.R + rho)
        return Contact((rx, ry), (vx, vy), (c, s), rho, u, v_n, v_t, self.p.K * u + self.p.C_n * v_n)

    def _relative(self, name, e, w):
        """Rows (2, 9) giving the acceleration of journal minus bearing centre, and its centripetal part."""
        rows, known = np.zeros((2, 9)), [0.0, 0.0]
        for sign, (link, x) in zip((1.0, -1.0), self.joints[name], strict=True):
            if link == GROUND:
                continue
            dx, dy = (x - self.centre[link]) * e[link][0], (x - self.centre[link]) * e[link][1]
            k = 3 * link
            rows[0, k], rows[0, k + 2] = sign, -sign * dy
            rows[1, k + 1], rows[1, k + 2] = sign, sign * dx
            known[0] -= sign * w[link] ** 2 * dx
            known[1] -= sign * w[link] ** 2 * dy
        return rows, known

    def _slip(self, name, c, e, w):
        """Row (9,) of the slip acceleration v_t', its known part, and the row of the normal direction."""
        rows, known = self._relative(name, e, w)
        (nx, ny), (journal, bearing) = c.normal, self.joints[name]
        row_n, row_t = nx * rows[0] + ny * rows[1], nx * rows[1] - ny * rows[0]
        row_t[3 * journal[0] + 2] += self.p.R
        turning = (c.rate[1] * nx - c.rate[0] * ny) / c.rho
        rest = nx * known[1] - ny * known[0] - turning * c.v_n
        if bearing[0] != GROUND:
            row_t[3 * bearing[0] + 2] -= self.p.R + c.rho
            rest -= w[bearing[0]] * c.v_n
        return row_t, rest, row_n

    def solve(self, y, modes):
        """Body accelerations (9,), F_t per sticking joint and v_t' per touching joint."""
        p, motion = self.p, self.motion(y)
        e, w, _, _ = motion
        load, rows, right, slips = np.zeros(9), [], [], {}
        for k in range(3):
            load[3 * k + 1] = -self.mass[k] * p.gravity
        if p.drive == "motor":
            load[2] += p.a - p.b * w[0]
        elif p.drive == "speed":
            rows.append(np.eye(9)[2])
            right.append(0.0)
        for name in self.ideal:
            both, known = self._relative(name, e, w)
            rows.extend(both)
            right.extend((-known[0], -known[1]))
        stuck = []
        for name, mode in modes.items():
            if mode in ("free", "released"):
                continue
            c = self.contact(name, y, motion)
            row_t, rest, row_n = slips[name] = self._slip(name, c, e, w)
            load -= c.force * row_n
            if mode == "stick":
                stuck.append((name, len(rows)))
                rows.append(row_t)
                right.append(-rest)
            else:
                friction = (p.f if mode == "slip+" else -p.f) * c.force + p.C_t * c.v_t
                load -= friction * row_t
        x = self._reactions(load, rows, right)
        self.evaluations += 1
        # M a + rows^T x = load: a multiplier pulls the journal against its row, which is F_t on the bearing
        held = {name: float(x[9 + k]) for name, k in stuck}
        return x[:9], held, {name: float(row @ x[:9]) + rest for name, (row, rest, _) in slips.items()}

    def _reactions(self, load, rows, right):
        size = 9 + len(rows)
        matrix = np.zeros((size, size))
        for k in range(3):
            matrix[3 * k, 3 * k] = matrix[3 * k + 1, 3 * k + 1] = self.mass[k]
            matrix[3 * k + 2, 3 * k + 2] = self.inertia[k]
        if rows:
            constraint = np.array(rows)
            matrix[9:, :9], matrix[:9, 9:] = constraint, constraint.T
        return np.linalg.solve(matrix, np.concatenate([load, right]))

    def rate(self, y, modes):
        """Time derivative of the state (2 n,) in the given modes."""
        acceleration, _, _ = self.solve(y, modes)
        out = np.empty(2 * self.n)
        out[: self.n] = y[self.n :]
        out[self.n : self.n + 3] = acceleration[2::3]
        for k, link in enumerate(self.bases):
            s, angle, w = self.centre[link], float(y[link]), float(y[self.n + link])
            c, d, turn = math.cos(angle), math.sin(angle), acceleration[3 * link + 2]
            out[self.n + 3 + 2 * k] = acceleration[3 * link] + s * (turn * d + w * w * c)
            out[self.n + 4 + 2 * k] = acceleration[3 * link + 1] - s * (turn * c - w * w * d)
        return out

    def energy(self, y):
        """Kinetic, gravity and contact energy, J (an adhesive law stores none outside contact)."""
        e, w, P, V = motion = self.motion(y)
        total = 0.0
        for k in range(3):
            s = self.centre[k]
            vx, vy = V[k][0] - s * w[k] * e[k][1], V[k][1] + s * w[k] * e[k][0]
            total += 0.5 * self.mass[k] * (vx * vx + vy * vy) + 0.5 * self.inertia[k] * w[k] ** 2
            total += self.mass[k] * self.p.gravity * (P[k][1] + s * e[k][1])
        touching = (max(self.contact(name, y, motion).u, 0.0) for name in self.clearance)
        return total + sum(0.5 * self.p.K * u * u for u in touching)
