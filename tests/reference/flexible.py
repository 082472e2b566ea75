"""Free bodies that bend: the four-bar of ``bodies.py`` with any of its links elastic.

A bending link is a row of particles on a massless elastic line, at the Gauss points of its elements, and a
rigid remainder that makes up the table's mass, mass centre and inertia while nothing bends. Newton's law is
written for every particle, with its acceleration as it is, and projected on the link's own coordinates:
origin, frame angle, nodal deflections and slopes. Joints are rows of one linear system whose extra unknowns
are the reactions. No inertia integral S, I or mass matrix of the model's printed equations is used, so
agreement with the package is agreement of two derivations.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .beams import Line
from .bodies import GROUND, LINKS, Bodies

# The state holds nodal deflections and slopes (m or rad), and their rates, in these: about as large as angles
# and speeds are, so that the same absolute tolerances do, and a hundred times above what rounding makes.
UNIT, RATE_UNIT = 1e-5, 1e-3


class Flexible(Bodies):
    """Right-hand side and guards of the four-bar whose links named in ``beams`` (name -> Beam) bend.

    The state is that of `Bodies` with the nodal coordinates of the bending links, in crank, coupler, rocker
    order and units of `UNIT` and `RATE_UNIT`, behind the bases. ``order="paper"`` leaves out of every
    particle's velocity and acceleration what its deflection adds, except the deflection's own rate across
    the link.
    """

    def __init__(self, p, clearance, beams=None, order="consistent"):
        super().__init__(p, clearance)
        if order not in ("consistent", "paper"):
            raise ValueError(order)
        self.moved = order == "consistent"
        lengths, self.lines, self.columns, size = (p.l3, p.l1, p.l2), {}, {}, 9
        for link, name in enumerate(LINKS):
            if name in (beams or {}):
                line = self.lines[link] = Line(beams[name], lengths[link], self.mass[link])
                self.columns[link] = slice(size, size + line.size)
                size += line.size
        self.size, self.rigid = size, self.n
        self.n += size - 9
        everything = np.arange(size)
        self.own = [
            np.ix_(*2 * [np.append(everything[3 * k : 3 * k + 3], everything[self.columns.get(k, slice(0))])])
            for k in range(3)
        ]
        self._remainders(lengths)

    def _remainders(self, lengths):
        """Mass, first moment and inertia about the origin that no particle stands for."""
        about_origin = (self.p.J_O, self.p.J_A, self.p.J_C)
        self.remainder = []
        for link, m in enumerate(self.mass):
            data = np.array([m, m * self.centre[link], about_origin[link]])
            if link in self.lines:
                data -= m * np.array([1.0, lengths[link] / 2, lengths[link] ** 2 / 3])
            self.remainder.append([float(v) for v in data])

    def start(self):
        """State of the ideal mechanism at crank angle 0, journals centred, links straight and at rest."""
        y, bent = super().start(), np.zeros(self.size - 9)
        half = len(y) // 2
        return np.concatenate([y[:half], bent, y[half:], bent])

    def bend(self, y):
        """Nodal coordinates and their rates by bending link."""
        q, rate = UNIT * y[self.rigid : self.n], RATE_UNIT * y[self.n + self.rigid :]
        return {
            k: (q[c.start - 9 : c.stop - 9], rate[c.start - 9 : c.stop - 9]) for k, c in self.columns.items()
        }

    def deflections(self, y):
        """Mid-length deflection of every bending link, m."""
        return {LINKS[k]: float(self.lines[k].middle @ q) for k, (q, _) in self.bend(y).items()}

    def _slope(self, place):
        """Columns of a link's coordinates and the row of the slope at a pin; None where it cannot bend."""
        link, x = place
        if link not in self.lines:
            return None
        line = self.lines[link]
        return self.columns[link], line.slope_end if x > 0 else line.slope_start

    def contact(self, name, y, motion=None):
        """As of rigid links; the surfaces slide with the end slopes' rates as well."""
        c = super().contact(name, y, motion)
        if c.rho == 0.0 or not self.lines:
            return c
        rates, v_t = self.bend(y), c.v_t
        for arm, place in zip((self.p.R, -self.p.R - c.rho), self.joints[name], strict=True):
            if slope := self._slope(place):
                v_t += arm * float(slope[1] @ rates[place[0]][1])
        return replace(c, v_t=v_t)

    def _relative(self, name, e, w):
        """Rows (2, size) of the acceleration of journal minus bearing centre, and its centripetal part."""
        rows, known = np.zeros((2, self.size)), [0.0, 0.0]
        for sign, (link, x) in zip((1.0, -1.0), self.joints[name], strict=True):
            if link == GROUND:
                continue
            dx, dy = x * e[link][0], x * e[link][1]
            k = 3 * link
            rows[0, k], rows[0, k + 2] = sign, -sign * dy
            rows[1, k + 1], rows[1, k + 2] = sign, sign * dx
            known[0] -= sign * w[link] ** 2 * dx
            known[1] -= sign * w[link] ** 2 * dy
        return rows, known

    def _slide(self, name, c, e, w, bent):
        """As `Bodies._slip`, with what the end slopes add to v_t'."""
        row_t, rest, row_n = self._slip(name, c, e, w)
        journal, bearing = self.joints[name]
        if slope := self._slope(journal):
            row_t[slope[0]] += self.p.R * slope[1]
        if slope := self._slope(bearing):
            row_t[slope[0]] -= (self.p.R + c.rho) * slope[1]
            rest -= float(slope[1] @ bent[bearing[0]][1]) * c.v_n
        return row_t, rest, row_n

    def _particles(self, link, direction, w, q, rate):
        """Rows of the particles' velocity along and across the link, and their acceleration's known part."""
        line, (c, s) = self.lines[link], direction
        y, y_t = (line.shape @ q, line.shape @ rate) if self.moved else (0.0 * line.x, 0.0 * line.x)
        along, across = np.zeros((2, len(line.x), 3 + line.size))
        along[:, 0], along[:, 1], along[:, 2] = c, s, -y
        across[:, 0], across[:, 1], across[:, 2], across[:, 3:] = -s, c, line.x, line.shape
        return along, across, -w * w * line.x - 2 * w * y_t, -w * w * y

    def link_inertia(self, link, direction, w, q, rate):
        """Mass matrix of a link's own coordinates (x, y, angle, nodal) and the load of gravity and motion."""
        m, first, J = self.remainder[link]
        (c, s), g = direction, self.p.gravity
        size = 3 + len(q)
        mass, load = np.zeros((size, size)), np.zeros(size)
        mass[:3, :3] = [[m, 0.0, -first * s], [0.0, m, first * c], [-first * s, first * c, J]]
        load[:3] = [first * w * w * c, first * w * w * s - m * g, -first * g * c]
        if link in self.lines:
            weight = self.lines[link].weight
            along, across, inward, sideways = self._particles(link, direction, w, q, rate)
            mass += along.T @ (weight[:, None] * along) + across.T @ (weight[:, None] * across)
            load += along.T @ (weight * (-g * s - inward)) + across.T @ (weight * (-g * c - sideways))
        return mass, load

    def _unconstrained(self, e, w, bent):
        """Mass matrix and load of all coordinates: gravity, centripetal terms, bending, drive."""
        mass, load = np.zeros((self.size, self.size)), np.zeros(self.size)
        for link in range(3):
            q, rate = bent.get(link, (np.zeros(0), np.zeros(0)))
            own = self.own[link]
            mass[own], load[own[1][0]] = self.link_inertia(link, e[link], w[link], q, rate)
            if link in self.lines:
                load[self.columns[link]] -= self.lines[link].stiffness @ q + self.lines[link].damping @ rate
        if self.p.drive == "motor":
            load[2] += self.p.a - self.p.b * w[0]
        return mass, load

    def forces(self, y, modes):
        """Accelerations of all coordinates, by name the multipliers, and v_t' of every touching joint.

        Multipliers are (x, y) of the force on the bearing at ideal joints, F_t at sticking ones, and, under
        ``"drive"``, the torque against which a prescribed speed is held.
        """
        self.evaluations += 1
        motion = self.motion(y)
        (e, w, _, _), bent = motion, self.bend(y)
        mass, load = self._unconstrained(e, w, bent)
        rows, right, names, slips = [], [], [], {}
        if self.p.drive == "speed":
            rows, right, names = [np.eye(self.size)[2]], [0.0], ["drive"]
        for name in self.ideal:
            both, known = self._relative(name, e, w)
            rows, right, names = [*rows, *both], [*right, -known[0], -known[1]], [*names, name, name]
        for name, mode in modes.items():
            if mode in ("free", "released"):
                continue
            c = self.contact(name, y, motion)
            row_t, rest, row_n = slips[name] = self._slide(name, c, e, w, bent)
            load -= c.force * row_n
            if mode == "stick":
                rows, right, names = [*rows, row_t], [*right, -rest], [*names, name]
            else:
                load -= self.friction(c, mode) * row_t
        a, pulls = self._saddle(mass, load, rows, right)
        held = {name: pulls[[other == name for other in names]] for name in dict.fromkeys(names)}
        return a, held, {name: float(row @ a) + rest for name, (row, rest, _) in slips.items()}

    def friction(self, c, mode):
        """F_t of a sliding contact."""
        return (self.p.f if mode == "slip+" else -self.p.f) * c.force + self.p.C_t * c.v_t

    def _saddle(self, mass, load, rows, right):
        n, size = self.size, self.size + len(rows)
        matrix = np.zeros((size, size))
        matrix[:n, :n] = mass
        if rows:
            matrix[n:, :n] = rows
            matrix[:n, n:] = matrix[n:, :n].T
        x = np.linalg.solve(matrix, np.concatenate([load, right]))
        return x[:n], x[n:]

    def solve(self, y, modes):
        """Accelerations, F_t per sticking joint and v_t' per touching joint."""
        a, held, slips = self.forces(y, modes)
        return a, {name: float(held[name][0]) for name, mode in modes.items() if mode == "stick"}, slips

    def rate(self, y, modes):
        """Time derivative of the state (2 n,) in the given modes."""
        a = self.forces(y, modes)[0]
        bases = [a[3 * link + k] for link in self.bases for k in (0, 1)]
        out = np.concatenate([y[self.n :], a[2:9:3], bases, a[9:] / RATE_UNIT])
        out[self.rigid : self.n] *= RATE_UNIT / UNIT
        return out

    def strain_energy(self, y):
        """Bending energy, J."""
        return sum(0.5 * float(q @ self.lines[k].stiffness @ q) for k, (q, _) in self.bend(y).items())

    def energy(self, y):
        """Kinetic, gravity, bending and contact energy, J (an adhesive law stores none outside contact)."""
        motion, bent, g = self.motion(y), self.bend(y), self.p.gravity
        e, w, P, V = motion
        total = self.strain_energy(y)
        for link in range(3):
            q, rate = bent.get(link, (np.zeros(0), np.zeros(0)))
            speed = np.concatenate([V[link], [w[link]], rate])
            total += 0.5 * speed @ self.link_inertia(link, e[link], w[link], q, rate)[0] @ speed
            total += g * self.mass[link] * (P[link][1] + self.centre[link] * e[link][1])
            if link in self.lines and self.moved:
                total += g * e[link][0] * float(self.lines[link].weight @ self.lines[link].shape @ q)
        touching = (max(self.contact(name, y, motion).u, 0.0) for name in self.clearance)
        return float(total) + sum(0.5 * self.p.K * u * u for u in touching)
