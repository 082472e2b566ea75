"""Ideal linkages in full coordinates: links' origins and angles, and a multiplier for every constraint.

M a + G^T L = Q, G a = -(dG/dt) v, solved densely; G are the closure equations of `mechanism.ideal`, written
per joint and without a tree, tables or closed forms. dG/dt is a difference.
"""

from __future__ import annotations

import math

import numpy as np

from jointplay.mechanism.ideal import Closure, ideal_configuration


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
        G, h = self.constraints(self.x), 1e-4 / np.abs(self.v).max()
        part = [self.constraints(self.x + k * h * self.v) @ self.v for k in (-2, -1, 1, 2)]
        rate = (part[0] - 8 * part[1] + 8 * part[2] - part[3]) / (12 * h)
        K = np.block([[M, G.T], [G, np.zeros((len(G), len(G)))]])
        found = np.linalg.solve(K, np.concatenate([Q, -rate]))
        a, L = found[:n], found[n:]
        loads = [-G[2 * k : 2 * k + 2].T @ L[2 * k : 2 * k + 2] for k in range(len(self.mechanism.joints))]
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
