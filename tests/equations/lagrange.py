"""Linkages whose links bend, by Lagrange's equations of free links: the model's energies, derived by machine.

Every link has coordinates of its own (x and y of its origin, its angle, its modes); kinetic and potential
energy are written as the model, section 4, prints them, and differentiated by complex steps. Ideal joints,
sticking contacts and a prescribed speed are constraints, whose multipliers are the reactions. No table of
chains, no closure, and no derivative by hand.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from jointplay.solver.mechanism.parts.beam import modal

from ..reference.bodies import GROUND, LINKS, Bodies

STEP = 1e-30


def along(f, x, v):
    """Derivative of f at x along v."""
    return np.imag(f(x + 1j * STEP * v)) / STEP


def linear(f, n):
    """Matrix of a linear function of n numbers."""
    return np.array([f(unit) for unit in np.eye(n)]).T


class Lagrange(Bodies):
    """The four-bar of a mechanism's record, with the numbers of `p` and play at the joints of `clearance`.

    The state is that of `Bodies` with the modal coordinates of the bending links, in the order of `LINKS`,
    behind the bases; then the rates. `smooth` is the velocity of friction by tanh (None: Coulomb).
    """

    def __init__(self, p, clearance, mechanism, smooth=None):
        super().__init__(p, clearance)
        self.links, self.order, self.smooth = [mechanism.link(k) for k in LINKS], mechanism.order, smooth
        self.modes = [modal(link) if link.elastic else None for link in self.links]
        counts = [link.beam.size if link.elastic else 0 for link in self.links]
        edges = np.cumsum([0, *(3 + count for count in counts)])
        self.own, self.size = [slice(*ends) for ends in pairwise(edges)], edges[-1]
        self.rigid, self.n = self.n, self.n + sum(counts)
        self.bent = np.concatenate([np.arange(own.start + 3, own.stop) for own in self.own]).astype(int)

    def spread(self, y):
        """Coordinates of all free links, and their rates."""
        _, w, P, V = self.motion(y)
        z = np.zeros((2, self.size))
        for k, own in enumerate(self.own):
            z[0, own.start : own.start + 3], z[1, own.start : own.start + 3] = (*P[k], y[k]), (*V[k], w[k])
        z[0, self.bent], z[1, self.bent] = y[self.rigid : self.n], y[self.n + self.rigid :]
        return z

    def kinetic(self, k, x, v):
        """T of link k at its coordinates x and rates v."""
        link, modes, w = self.links[k], self.modes[k], v[2]
        axial = v[0] * np.cos(x[2]) + v[1] * np.sin(x[2])
        across = v[1] * np.cos(x[2]) - v[0] * np.sin(x[2])
        T = link.mass * ((v[0] ** 2 + v[1] ** 2) / 2 + link.centre * w * across) + link.inertia * w**2 / 2
        if modes is None:
            return T
        eta, rate = x[3:], v[3:]
        T += across * (modes.force @ rate) + w * (modes.moment @ rate) + rate @ rate / 2
        return T - w * axial * (modes.force @ eta) + w**2 * (eta @ eta) / 2

    def potential(self, k, x):
        """V of link k: weight and bending."""
        link, modes, g = self.links[k], self.modes[k], self.p.gravity
        V = link.mass * g * (x[1] + link.centre * np.sin(x[2]))
        if modes is None:
            return V
        return V + g * np.cos(x[2]) * (modes.force @ x[3:]) + (modes.frequency**2 * x[3:]) @ x[3:] / 2

    def _mass(self, k, x):
        """Second derivatives of T by the rates."""
        units = np.eye(len(x))
        diagonal = [self.kinetic(k, x, unit) for unit in units]
        return np.array(
            [
                [self.kinetic(k, x, a + b) - diagonal[i] - diagonal[j] for j, b in enumerate(units)]
                for i, a in enumerate(units)
            ]
        )

    def link_equations(self, k, x, v):
        """Mass matrix and load of a link: d(dT/dv)/dt - d(T - V)/dx = 0, less structural damping."""
        load = np.array(
            [along(lambda at: self.kinetic(k, at, v) - self.potential(k, at), x, u) for u in np.eye(len(x))]
        )
        load -= along(lambda at: self._mass(k, at) @ v, x, v)
        mass = self._mass(k, x)
        if self.modes[k] is not None and self.order == "paper":
            mass, load = self._printed(k, x, v)
        if self.modes[k] is not None:
            load[3:] -= 2 * self.links[k].beam.damping_ratio * self.modes[k].frequency * v[3:]
        return mass, load

    def _printed(self, k, x, v):
        """As equations (3) to (12) have it: S eta'' on the origin, I eta'' on the angle, no second order."""
        link, modes, g, w = self.links[k], self.modes[k], self.p.gravity, v[2]
        m, s, (e, n) = link.mass, link.centre, directions(x[2])
        size, S = len(x), modes.force
        mass, load = np.eye(size), np.zeros(size)
        mass[:2, :2], mass[2, 2] = m * np.eye(2), link.inertia
        mass[:2, 2] = mass[2, :2] = m * s * n
        mass[:2, 3:], mass[3:, :2] = np.outer(n, S), np.outer(S, n)
        mass[2, 3:] = mass[3:, 2] = modes.moment
        load[:2] = m * s * w**2 * e - [0.0, m * g]
        load[2] = -m * g * s * e[0]
        load[3:] = -g * e[0] * S - modes.frequency**2 * x[3:]
        return mass, load

    def _pin(self, z, v, place):
        """Position and velocity of a pin."""
        link, at = place
        if link == GROUND:
            return np.array(at), np.zeros(2)
        x, rate, (e, n) = z[self.own[link]], v[self.own[link]], directions(z[self.own[link]][2])
        return x[:2] + at * e, rate[:2] + at * rate[2] * n

    def _spin(self, v, place):
        """How fast the end of a link turns, its slope included."""
        link, at = place
        if link == GROUND:
            return 0.0
        rate, modes = v[self.own[link]], self.modes[link]
        slope = 0.0 if modes is None else (modes.slope_end if at else modes.slope_start) @ rate[3:]
        return rate[2] + slope

    def relative(self, name, z, v):
        """Journal centre less bearing centre, and its velocity."""
        (a, va), (b, vb) = (self._pin(z, v, place) for place in self.joints[name])
        return a - b, va - vb

    def slide(self, name, z, v):
        """Normal and sliding velocity: equations (16), with the surfaces turning as the links' ends do."""
        r, rate = self.relative(name, z, v)
        rho = np.sqrt(r @ r)
        journal, bearing = (self._spin(v, place) for place in self.joints[name])
        v_t = (r[0] * rate[1] - r[1] * rate[0]) / rho + (journal - bearing) * self.p.R - bearing * rho
        return np.array([r @ rate / rho, v_t])

    def forces(self, y, modes):
        """Accelerations of the free coordinates, multipliers by name, and v_t' of touching joints.

        Multipliers are (x, y) of force on the bearing of ideal joints, F_t of sticking ones, and the torque
        under ``"drive"``.
        """
        z, v = self.spread(y)
        mass, load = np.zeros((self.size, self.size)), np.zeros(self.size)
        for k, own in enumerate(self.own):
            mass[own, own], load[own] = self.link_equations(k, z[own], v[own])
        if self.p.drive == "motor":
            load[2] += self.p.a - self.p.b * v[2]
        rows, right, names, slides = self._ideal(z, v)
        for name, mode in modes.items():
            if mode in ("free", "released"):
                continue
            normal, tangential = linear(lambda u, name=name: self.slide(name, z, u), self.size)
            bias = along(lambda at, name=name: self.slide(name, at, v), z, v)[1]
            slides[name] = tangential, bias
            _, _, v_t, F_n = self.touch(name, z, v)
            load = load - normal * F_n
            if mode == "stick":
                rows, right, names = [*rows, tangential], [*right, -bias], [*names, name]
            else:
                load = load - tangential * self.friction(mode, F_n, v_t)
        a, held = self._solved(mass, load, rows, right, names)
        return a, held, {name: row @ a + bias for name, (row, bias) in slides.items()}

    def _ideal(self, z, v):
        rows, right, names = [], [], []
        if self.p.drive == "speed":
            rows, right, names = [np.eye(self.size)[2]], [0.0], ["drive"]
        for name in self.ideal:
            rows += list(linear(lambda u, name=name: self.relative(name, z, u)[1], self.size))
            right += list(-along(lambda at, name=name: self.relative(name, at, v)[1], z, v))
            names += [name, name]
        return rows, right, names, {}

    def _solved(self, mass, load, rows, right, names):
        """Of M a + rows^T x = load: a multiplier pulls the journal against its row, as F on the bearing."""
        n, matrix = self.size, np.zeros((self.size + len(rows),) * 2)
        matrix[:n, :n] = mass
        if rows:
            matrix[n:, :n] = rows
            matrix[:n, n:] = matrix[n:, :n].T
        x = np.linalg.solve(matrix, np.concatenate([load, right]))
        return x[:n], {name: x[n:][[other == name for other in names]] for name in dict.fromkeys(names)}

    def touch(self, name, z, v):
        """Penetration, normal and sliding velocity, normal force."""
        r, _ = self.relative(name, z, v)
        u, (v_n, v_t) = np.sqrt(r @ r) - self.clearance[name], self.slide(name, z, v)
        return u, v_n, v_t, self.p.K * u + self.p.C_n * v_n

    def friction(self, mode, F_n, v_t):
        """F_t of a sliding contact."""
        direction = np.tanh(v_t / self.smooth) if self.smooth else {"slip+": 1.0, "slip-": -1.0}[mode]
        return self.p.f * F_n * direction + self.p.C_t * v_t

    def rate(self, y, modes):
        """Accelerations of the package's unknowns, in its order: modes, angles, bases."""
        a = self.forces(y, modes)[0]
        angles = [a[own.start + 2] for own in self.own]
        if not self.clearance:
            angles = angles[:1]
        elif self.p.drive == "speed":
            angles = angles[1:]
        bases = [a[self.own[link].start + axis] for link in self.bases for axis in (0, 1)]
        return np.array([*a[self.bent], *angles, *bases])

    def state(self, y):
        """The package's positions and speeds, in its order; of a closed loop only the crank is among them."""
        first, last = (1 if self.p.drive == "speed" else 0), self.rigid
        if not self.clearance:
            first, last = 0, 1
        halves = (y[: self.n], y[self.n :])
        return np.concatenate([part for half in halves for part in (half[self.rigid :], half[first:last])])

    def energies(self, y):
        """Kinetic, potential and bending energy, J."""
        z, v = self.spread(y)
        masses = (self.link_equations(k, z[own], v[own])[0] for k, own in enumerate(self.own))
        T = sum(v[own] @ mass @ v[own] for own, mass in zip(self.own, masses, strict=True)) / 2
        V = sum(self.potential(k, z[own]) for k, own in enumerate(self.own))
        pairs = [(modes, z[own][3:]) for modes, own in zip(self.modes, self.own, strict=True) if modes]
        return T, V, sum(float((modes.frequency**2 * eta) @ eta) / 2 for modes, eta in pairs)


def directions(angle):
    """Unit vectors along and across a link."""
    return np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
