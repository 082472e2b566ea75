"""The paper's four-bar as bodies of `tests.support.multibody`, and its free coordinates.

Those are the angles of crank, coupler and rocker; then x and y of the origin of each base, the first link of
a part that no ideal joint ties to the ground; then the mass-normalised modes of the links that bend. Of the
closed loop, in which no joint has play, the crank's angle is the only one of the first. A state of them is
values, then rates.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tests.support.multibody import GROUND, Body, Marker, Now, Play, Revolute, System, Touch
from tests.support.multibody_beams import Row
from tests.support.multibody_loads import constant_speed, kelvin_voigt, motor, tanh_friction

LINKS = ("crank", "coupler", "rocker")
ANGLES = 3 * np.arange(3) + 2  # of all coordinates


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

    @property
    def links(self):
        """Length, mass and moment of inertia about the origin of crank, coupler and rocker."""
        sizes = (self.l3, self.m3, self.J_O), (self.l1, self.m1, self.J_A), (self.l2, self.m2, self.J_C)
        return dict(zip(LINKS, sizes, strict=True))


@dataclass(frozen=True)
class Beam:
    """How a link bends: number of Hermite elements, damping ratio xi of every mode, round steel bar."""

    elements: int = 2
    xi: float = 0.01
    modulus: float = 2.1e11
    density: float = 7800.0

    def stiffness(self, length: float, mass: float) -> tuple[float, float]:
        """E I and E A of a link of a length and mass."""
        area = mass / (self.density * length)
        return self.modulus * area**2 / (4 * math.pi), self.modulus * area

    def row(self, length: float, mass: float, order: str = "consistent") -> Row:
        """The particles of such a link."""
        stiffness = self.stiffness(length, mass)
        return Row(length, mass, *stiffness, self.xi, "hermite", self.elements, order=order)


def loop(p: Parameters, angle: float, speed: float) -> tuple[list[float], list[float]]:
    """Angles and speeds (crank, coupler, rocker) of the closed loop, rocker above the line from A to C."""
    ax, ay = p.l3 * math.cos(angle), p.l3 * math.sin(angle)
    dx, dy = p.l4 - ax, -ay
    gap = math.hypot(dx, dy)
    foot = (gap**2 + p.l1**2 - p.l2**2) / (2 * gap)
    height = math.sqrt(p.l1**2 - foot**2)
    bx, by = (foot * dx - height * dy) / gap, (foot * dy + height * dx) / gap  # from A to B
    cx, cy = bx - dx, by - dy  # from C to B
    # velocity of B from both sides: (-speed ay, speed ax) + coupler (-by, bx) = rocker (-cy, cx)
    area = by * cx - bx * cy
    coupler = speed * (ax * cy - ay * cx) / area
    rocker = speed * (ax * by - ay * bx) / area
    return [angle, math.atan2(by, bx), math.atan2(cy, cx)], [speed, coupler, rocker]


class FourBar(System):
    """The mechanism with play at the joints of ``clearance`` (name -> e, m) and bending links (name -> row).

    ``smooth`` is the velocity of friction by tanh; without it, friction is dry.
    """

    def __init__(
        self,
        p: Parameters,
        clearance: Mapping[str, float],
        rows: Mapping[str, Row] | None = None,
        smooth: float | None = None,
    ):
        self.p, self.clearance = p, dict(clearance)
        bodies = [
            Body(name, mass, inertia - mass * length**2 / 4, length / 2, (rows or {}).get(name))
            for name, (length, mass, inertia) in p.links.items()
        ]
        crank, coupler, rocker = map(Marker, LINKS)
        ends = {
            "O": (crank, Marker()),
            "A": (Marker("crank", (p.l3, 0.0)), coupler),
            "B": (Marker("coupler", (p.l1, 0.0)), Marker("rocker", (p.l2, 0.0))),
            "C": (rocker, Marker(GROUND, (p.l4, 0.0))),
        }
        plays = {name: self._play(e, smooth) for name, e in self.clearance.items()}
        joints = [Revolute(name, *pair, plays.get(name)) for name, pair in ends.items()]
        drives = [constant_speed("crank", p.w0)] if p.drive == "speed" else []
        loads = [motor("crank", p.a, p.b)] if p.drive == "motor" else []
        super().__init__(bodies, joints, drives, loads, p.gravity)
        self._tree()
        bent = np.arange(9, self.n)
        bases = [3 * LINKS.index(link) + axis for link in self.bases for axis in (0, 1)]
        self.placed = np.delete(np.arange(9), [*ANGLES, *bases])  # by ideal joints
        self.free = np.r_[ANGLES if self.clearance else ANGLES[:1], bases, bent].astype(int)
        self.half, self.rigid = len(self.free), len(self.free) - len(bent)
        self.modes = np.zeros((len(bent), len(bent)))
        for row, own in self.beams.values():
            self.modes[own.start - 9 : own.stop - 9, own.start - 9 : own.stop - 9] = row.modes * np.sign(
                row.slope(0.0) @ row.modes
            )

    def _play(self, e: float, smooth: float | None) -> Play:
        p, sliding = self.p, {}
        if smooth:
            sliding = {"friction": tanh_friction(p.f, smooth, p.C_t)}
        elif p.f:
            sliding = {"dry": lambda v: p.f, "viscous": p.C_t}
        elif p.C_t:
            sliding = {"friction": lambda F_n, v_t: p.C_t * v_t}
        stored = {"stored": lambda u: 0.5 * p.K * u * u}
        return Play(e, kelvin_voigt(p.K, p.C_n), tension=p.tension, radius=p.R, **sliding, **stored)

    def _tree(self) -> None:
        """The bases, and the order in which other links are placed: the place on each, and where that is."""
        self.steps, self.bases, known = [], [], {GROUND}
        self.ties = [
            joint for joint in self.joints if joint.play is None and (self.clearance or joint.name != "B")
        ]
        while len(known) < 4:
            for joint in self.ties:
                sides = joint.journal, joint.bearing
                new, old = sides if sides[1].body in known else sides[::-1]
                if old.body in known and new.body not in known:
                    self.steps.append((new, old))
                    known.add(new.body)
                    break
            else:
                self.bases.append(next(link for link in LINKS if link not in known))
                known.add(self.bases[-1])

    def start(self) -> np.ndarray:
        """The ideal mechanism at crank angle 0, with every journal centred in its bearing, links straight."""
        origins = {"crank": (0.0, 0.0), "coupler": (self.p.l3, 0.0), "rocker": (self.p.l4, 0.0)}
        moving = {"coupler": (0.0, self.p.w0 * self.p.l3)}
        y = np.zeros((2, self.half))
        angles = np.array(loop(self.p, 0.0, self.p.w0))
        count = 3 if self.clearance else 1
        y[:, :count] = angles[:, :count]
        y[0, count : self.rigid] = [x for link in self.bases for x in origins[link]]
        y[1, count : self.rigid] = [x for link in self.bases for x in moving.get(link, (0.0, 0.0))]
        return y.ravel()

    def full(self, y: np.ndarray) -> np.ndarray:
        """The state of all coordinates."""
        values, rates = np.reshape(np.asarray(y, dtype=float), (2, -1))
        q, v = np.zeros((2, self.n))
        q[self.free], v[self.free] = values, rates
        q[9:], v[9:] = self.modes @ q[9:], self.modes @ v[9:]
        if not self.clearance:
            q[ANGLES], v[ANGLES] = loop(self.p, q[2], v[2])
        for link in self.bases:
            i, s = self.at[link], self.centres[link]
            c, d = math.cos(q[i + 2]), math.sin(q[i + 2])
            q[i : i + 2] += s * c, s * d
            v[i : i + 2] += -s * d * v[i + 2], s * c * v[i + 2]
        g, G, _, _ = self.constraints(Now(self, 0.0, np.r_[q, v]), self.ties)  # linear in what is placed
        q[self.placed] = np.linalg.solve(G[:, self.placed], -g)
        v[self.placed] = np.linalg.solve(G[:, self.placed], -G @ v)
        return np.r_[q, v]

    def reduced(self, y: np.ndarray) -> np.ndarray:
        """The free coordinates' state of one of all."""
        q, v = np.reshape(y, (2, -1)).copy()
        for link in self.bases:
            i, s = self.at[link], self.centres[link]
            c, d = math.cos(q[i + 2]), math.sin(q[i + 2])
            q[i : i + 2] -= s * c, s * d
            v[i : i + 2] -= -s * d * v[i + 2], s * c * v[i + 2]
        q[9:], v[9:] = np.linalg.solve(self.modes, np.stack([q[9:], v[9:]], 1)).T
        return np.r_[q[self.free], v[self.free]]

    def at_modes(self, y: np.ndarray, modes: Mapping[str, str]):
        """`solve` at a state of the free coordinates, with the joints' modes by name."""
        return self.solve(0.0, self.full(y), [modes[joint.name] for joint in self.loose])

    def rate(self, y: np.ndarray, modes: Mapping[str, str]) -> np.ndarray:
        """The rates of the free coordinates' state."""
        solved = self.at_modes(y, modes)
        a, now = solved.acceleration.copy(), solved.now
        for link in self.bases:
            i, s = self.at[link], self.centres[link]
            c, d, w = math.cos(now.q[i + 2]), math.sin(now.q[i + 2]), now.v[i + 2]
            a[i : i + 2] += s * (a[i + 2] * d + w * w * c), -s * (a[i + 2] * c - w * w * d)
        a[9:] = np.linalg.solve(self.modes, a[9:])
        return np.r_[y[self.half :], a[self.free]]

    def touch(self, name: str, y: np.ndarray) -> Touch:
        """A joint's point of touch at a state of the free coordinates."""
        return dict(self.touches(Now(self, 0.0, self.full(y))))[name]

    def deflections(self, y: np.ndarray) -> dict[str, float]:
        """Mid-length deflection of every bending link at a state of all coordinates, m."""
        return {name: row.deflection(y[own]) for name, (row, own) in self.beams.items()}


def by_name(solved) -> tuple[dict[str, np.ndarray | float], dict[str, float]]:
    """Of a solution: what each joint and drive holds (its F_t where one touches), and v_t' of all touches."""
    touching = {name: (touch, F_t) for name, touch, _, F_t in solved.touches}
    slips = {name: float(x.W_t @ solved.acceleration) + x.bias_t for name, (x, _) in touching.items()}
    return solved.reactions | {name: F_t for name, (_, F_t) in touching.items()}, slips


def scattered(system: FourBar, seed: int, sizes: Sequence[float] = (1e-3, 5.0, 3e-3, 6.0)) -> np.ndarray:
    """A state near the start: random changes of such sizes, of coordinates and rates, rigid and bent.

    A closed loop is at any crank angle; an imposed speed is what it is.
    """
    random, rigid, bent = np.random.default_rng(seed), system.rigid, system.half - system.rigid
    size = np.repeat(np.array(sizes)[[0, 2, 1, 3]], [rigid, bent, rigid, bent])
    y = system.start() + size * random.standard_normal(2 * system.half)
    if not system.clearance:
        y[0] = random.uniform(0, 2 * math.pi)
    if system.p.drive == "speed":
        y[system.half] = system.p.w0
    return y
