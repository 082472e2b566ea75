"""Ideal linkages in full coordinates: links' origins and angles, and a multiplier for every constraint.

M a + G^T L = Q, G a = -(dG/dt) v, solved densely; G are the closure equations of `mechanism.ideal`, written
per joint and without a tree, tables or closed forms. dG/dt is a difference.
"""

from __future__ import annotations

import math

import numpy as np

from jointplay.solver.mechanism.loops.ideal import Closure, ideal_configuration


class Full:
    """A mechanism at a crank angle and speed, with every joint ideal."""

    def __init__(self, mechanism, angle, speed):
        self.mechanism, self.closure = mechanism, Closure(mechanism)
        self.state = ideal_configuration(mechanism, angle, speed)
        n = 3 * len(mechanism.links)
        self.x, self.v = np.zeros(n), np.zeros(n)
        for name, i in self.closure.place.items():
            self.x[i : i + 2], self.v[i : i + 2] = self.state.points[name]
            self.x[i + 2], self.v[i + 2] = self.state.angles[name], self.state.speeds[name]

    def loads(self):
        """Further forces on the coordinates."""
        return 0.0

    def constraints(self, x):
        """Jacobian of the joints' equations, and of the crank's angle where its speed is prescribed."""
        held = {self.mechanism.crank: 0.0} if self.mechanism.drive.kind == "speed" else {}
        return self.closure.equations(x, held)[1]

    def solve(self):
        """Accelerations, and generalised forces of each joint on the coordinates."""
        n = len(self.x)
        M, Q = np.zeros((n, n)), np.zeros(n)
        for link in self.mechanism.links:
            i = self.closure.place[link.name]
            c, s = math.cos(self.x[i + 2]), math.sin(self.x[i + 2])
            m, d, w = link.mass, link.centre, self.v[i + 2]
            M[i : i + 3, i : i + 3] = [
                [m, 0, -m * d * s],
                [0, m, m * d * c],
                [-m * d * s, m * d * c, link.inertia],
            ]
            g = self.mechanism.gravity
            Q[i : i + 3] = [m * d * w**2 * c, m * d * w**2 * s - m * g, -m * g * d * c]
        drive = self.mechanism.drive
        at = self.closure.place[drive.link] + 2
        if drive.kind == "motor":
            Q[at] += drive.stall_torque - drive.slope * self.v[at]
        Q += self.loads()
        G, h = self.constraints(self.x), 1e-4 / np.abs(self.v).max()
        part = [self.constraints(self.x + k * h * self.v) @ self.v for k in (-2, -1, 1, 2)]
        rate = (part[0] - 8 * part[1] + 8 * part[2] - part[3]) / (12 * h)
        K = np.block([[M, G.T], [G, np.zeros((len(G), len(G)))]])
        found = np.linalg.solve(K, np.concatenate([Q, -rate]))
        a, L = found[:n], found[n:]
        joints = self.closure.mechanism.joints
        loads = [-G[2 * k : 2 * k + 2].T @ L[2 * k : 2 * k + 2] for k in range(len(joints))]
        return a, loads, -L[-1] if drive.kind == "speed" else None

    def on_bearing(self, joint, load):
        """Force on the bearing of a joint, and the moment on it about the journal's point."""
        i = self.closure.place.get(joint.journal.link)
        if i is not None:
            P = joint.journal.at * np.array([math.cos(self.x[i + 2]), math.sin(self.x[i + 2])])
            x, y, moment = load[i : i + 3]
            return -x, -y, -(moment - (P[0] * y - P[1] * x))
        i = self.closure.place[joint.bearing.link]
        P = np.array(joint.journal.point) - self.x[i : i + 2]
        x, y, moment = load[i : i + 3]
        return x, y, moment - (P[0] * y - P[1] * x)


class Loose(Full):
    """A mechanism with contact in its joints with clearance, at given free coordinates and speeds.

    `held` are values and speeds of the free coordinates, by angle, slide or (link, 0 or 1); `contacts` are
    normal and tangential force of each joint with clearance, as the other side computes them.
    """

    def __init__(self, mechanism, held, contacts):
        self.mechanism, self.contacts = mechanism, contacts
        closed = Closure(mechanism)
        self.closure = Closure(
            mechanism.model_copy(update={"joints": tuple(j for j in mechanism.joints if j.ideal)})
        )
        start = ideal_configuration(mechanism, held[mechanism.crank][0], 1.0)
        x = np.zeros(3 * len(mechanism.links))
        for name, i in closed.place.items():
            x[i : i + 2], x[i + 2] = start.points[name][0], start.angles[name]
        for _ in range(30):
            value, G = self.equations(x, {k: pair[0] for k, pair in held.items()})
            x = x - np.linalg.solve(G, value)
        right = np.zeros(len(x))
        right[-len(held) :] = [pair[1] for pair in held.values()]
        self.x, self.v = x, np.linalg.solve(G, right)

    def equations(self, x, held):
        """Joints' equations and what is held, with Jacobian."""
        value, G = self.closure.equations(x, {})
        value, G = list(value), list(G)
        for k, wanted in held.items():
            row = np.zeros(len(x))
            if isinstance(k, tuple) and k[0] is not None:
                row[self.closure.place[k[0]] + k[1]] = 1.0
                now = row @ x
            else:
                now, row = self.closure.free(x, k)
            value.append(now - wanted)
            G.append(row)
        return np.array(value), np.array(G)

    def loads(self):
        """Contact forces on the coordinates."""
        Q = np.zeros(len(self.x))
        for joint in self.mechanism.clearance_joints:
            (P, dP), (B, dB) = (self.closure.pin(self.x, pin) for pin in (joint.journal, joint.bearing))
            rho = np.hypot(*(P - B))
            unit = (P - B) / rho
            F_n, F_t = self.contacts[joint.name]
            F = F_n * unit + F_t * np.array([-unit[1], unit[0]])
            Q += (dB - dP).T @ F
            for pin, arm in ((joint.journal, -joint.radius), (joint.bearing, joint.radius + rho)):
                if pin.link in self.closure.place:
                    Q[self.closure.place[pin.link] + 2] += arm * F_t
        return Q
