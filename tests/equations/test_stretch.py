"""Elastic links that stretch, against masses spread along them, in coordinates of free links."""

from __future__ import annotations

import math

import numpy as np
import pytest

import jointplay as jp
from jointplay.solver.codegen import outputs
from jointplay.solver.mechanism.assemble import assemble
from tests.support.linkages import bending
from tests.support.plain import plain

G = 9.8
LENGTHS, INERTIA = {"crank": 0.05, "rod": 0.12, "slider": 0.02}, {"rod": 4e-4}
BEAM = jp.Beam(shapes="sine", modes=2, axial=True, damping_ratio=0.02, modulus=2e8, density=7800.0, area=2e-4)
STEP = 1e-30


def rods(clearance=0, beam=BEAM, **changes):
    """The slider-crank whose rod bends and stretches, softly."""
    plain_one = jp.catalog.slider_crank(clearance=clearance, gravity=G, inertia_centre=INERTIA, offset=0.01)
    return bending(plain_one.replace(**changes), {"rod": beam})


def shapes(x):
    """Shapes across and along at a fraction of the length: two sines, two parabolas."""
    return np.array([np.sin(math.pi * x), np.sin(2 * math.pi * x)]), np.array(
        [4 * x * (1 - x), x * (2 * x - 1)]
    )


class Free:
    """Crank, rod and slider as free links of many masses: x, y, angle each; then the rod's four shapes."""

    def __init__(self, mechanism):
        self.mechanism, self.size = mechanism, 13
        node, weight = np.polynomial.legendre.leggauss(24)
        self.points = []
        for k, link in enumerate(mechanism.links):
            beam = BEAM.density * BEAM.area * link.length * link.elastic
            if beam:
                self.points += [
                    (k, (1 + x) / 2, w * beam / 2, 1.0) for x, w in zip(node, weight, strict=True)
                ]
            at = np.array([0.0, 0.5, 1.0])  # three rigid masses for what the beam is not
            rest = [link.mass - beam, link.mass * link.centre / link.length - beam / 2]
            rest += [link.inertia / link.length**2 - beam / 3]
            self.points += [
                (k, x, m, 0.0)
                for x, m in zip(at, np.linalg.solve(at ** np.array([[0], [1], [2]]), rest), strict=True)
            ]

    def place(self, q, k, x, bends):
        """Where a point of a link is."""
        y, u = shapes(x)
        X = x * LENGTHS[self.mechanism.links[k].name] + bends * (k == 1) * (u @ q[11:])
        Y = bends * (k == 1) * (y @ q[9:11])
        c, s = np.cos(q[3 * k + 2]), np.sin(q[3 * k + 2])
        return np.array([q[3 * k] + X * c - Y * s, q[3 * k + 1] + X * s + Y * c])

    def closed(self, q):
        """What joints hold at 0: O, A, B, the slider on its guide; a turning crank's angle comes last."""
        ends = [self.place(q, k, x, 1.0) for k, x in ((0, 1.0), (1, 0.0), (1, 1.0), (2, 0.0))]
        guide = np.array([q[7] - 0.01, q[8]])
        return np.concatenate([q[:2], ends[1] - ends[0], ends[2] - ends[3], guide, q[2:3]])

    def slopes(self, f, q):
        """Derivatives of f by the coordinates."""
        return np.array([np.imag(f(q + 1j * STEP * unit)) / STEP for unit in np.eye(self.size)]).T

    def bend(self, f, q, v):
        """Second derivative of f along v."""
        h = 1e-4
        ahead, back = (np.imag(f(q + s * h * v / 50 + 1j * STEP * v)) / STEP for s in (1, -1))
        return (ahead - back) / (2 * h / 50)

    def solve(self, q, v):
        """Accelerations, and the forces of the joints."""
        M, Q = np.zeros((self.size, self.size)), np.zeros(self.size)
        for k, x, m, bends in self.points:

            def f(q, k=k, x=x, bends=bends):
                return self.place(q, k, x, bends)

            J = self.slopes(f, q)
            M, Q = M + m * J.T @ J, Q + m * J.T @ (np.array([0.0, -G]) - self.bend(f, q, v))
        Q -= self.elastic() @ q + self.damped(M) @ v
        C, rows = self.slopes(self.closed, q), -self.bend(self.closed, q, v)
        n = len(C)
        whole = np.block([[M, C.T], [C, np.zeros((n, n))]])
        found = np.linalg.solve(whole, np.concatenate([Q, rows]))
        return found[: self.size], found[self.size :]

    def elastic(self):
        """Stiffness by the shapes' derivatives."""
        l, E, A = LENGTHS["rod"], BEAM.modulus, BEAM.area
        K = np.zeros((self.size, self.size))
        K[9, 9], K[10, 10] = (E * A**2 / (4 * math.pi) * (i * math.pi) ** 4 / (2 * l**3) for i in (1, 2))
        K[11:, 11:] = E * A / l * np.array([[16, -8], [-8, 7]]) / 3
        return K

    def damped(self, M):
        """Each mode's share of its critical damping, of bars across and along."""
        from scipy.linalg import eigh

        C, K = np.zeros_like(M), self.elastic()
        for at in (slice(9, 11), slice(11, 13)):
            squares, v = eigh(K[at, at], M[at, at])
            C[at, at] = M[at, at] @ v @ np.diag(2 * BEAM.damping_ratio * np.sqrt(squares)) @ v.T @ M[at, at]
        return C


def shaken(mechanism, amounts, rates):
    """Every quantity at a crank angle of 0.7, with amounts of the rod's shapes, m and m/s."""
    model = assemble(mechanism, {"crank_angle": 0.7})
    functions, free = plain(model.structure), Free(mechanism)
    x = dict(zip(functions.STATE, [0.0, *model.state], strict=True))
    modes = modal_rows(model)
    for word, row in (("", amounts), ("d", rates)):
        eta, zeta = modes[0] @ row[:2], modes[1] @ row[2:]
        for i in (0, 1):
            x[next(s for s in x if str(s) == f"{word}eta_rod_{i}")] = eta[i]
            x[next(s for s in x if str(s) == f"{word}zeta_rod_{i}")] = zeta[i]
    given = x | dict(zip(functions.PARAMETERS, model.numbers, strict=True))
    found = {k: float(v) for k, v in outputs.evaluate(functions, functions.OUTPUTS, given).items()}
    return free, found


def modal_rows(model):
    """Matrices that make modal coordinates of amounts of the shapes."""
    from scipy.linalg import eigh

    mass = BEAM.density * BEAM.area * LENGTHS["rod"]
    v = eigh(np.array([[16.0, -8.0], [-8.0, 7.0]]) / 3, np.array([[8.0, 1.0], [1.0, 2.0]]) / 15)[1]
    return np.eye(2) * math.sqrt(mass / 2), math.sqrt(mass) * np.linalg.inv(v * np.sign(v[1]))


def test_accelerations_and_forces_are_those_of_many_masses():
    amounts, rates = np.array([1e-3, -4e-4, 5e-4, 9e-4]), np.array([0.3, 0.2, -0.4, 0.5])
    free, found = shaken(rods(), amounts, rates)
    q, v = np.zeros(13), np.zeros(13)
    q[9:], v[9:] = amounts, rates
    for k, name in enumerate(LENGTHS):
        q[3 * k + 2], v[3 * k + 2] = found[f"angle:{name}"], found[f"angular_velocity:{name}"]
    q[3:5] = free.place(q, 0, 1.0, 1.0)
    v[3:5] = free.slopes(lambda q: free.place(q, 0, 1.0, 1.0), q) @ v
    q[6:8] = found["slide_position:G"], 0.01
    v[6] = found["slide_velocity:G"]
    assert np.abs(free.closed(q)[:8]).max() < 1e-15
    assert np.abs(free.slopes(free.closed, q) @ v)[:8].max() < 1e-12
    a, force = free.solve(q, v)
    for k, name in enumerate(LENGTHS):
        assert found[f"angular_acceleration:{name}"] == pytest.approx(a[3 * k + 2], rel=1e-7, abs=1e-4)
    size = np.abs(force[:8]).max()
    pushed = {"O": force[:2], "A": -force[2:4], "B": force[4:6]}
    for joint, row in pushed.items():
        for axis, value in zip("xy", row, strict=True):
            assert found[f"reaction_{axis}:{joint}"] == pytest.approx(value, abs=1e-7 * size)
    assert found["drive_torque"] == pytest.approx(-force[8], abs=1e-7 * size)
