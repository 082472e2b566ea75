"""Rigid bodies in a plane, each with three coordinates of its own: a second program to hold results against.

Newton and Euler for every body at its mass centre, q = (x, y, θ) a body. Ideal joints and drives are rows
g(t, q) = 0:

    [M Gᵀ; G 0] [a; λ] = [Q; −bias]        ġ = G v + g_t,   g̈ = G a + bias

solved densely. Joints with clearance are forces at points of touch: with v_n = W_n·v and v_t = W_t·v the
speeds of penetration and of sliding, Q −= F_n W_n + F_t W_t (virtual power). No reduced coordinates, no
closed forms, no code of the package. What
loads, drives and resists is in `multibody_loads`; `multibody_run` assembles and follows motions.

A `Marker` is a point of a body, given along and across the body's line from its origin, with a direction
relative to that line; on the ground, in fixed axes. Units: SI.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import ClassVar

import numpy as np

GROUND = "ground"


@dataclass(frozen=True)
class Body:
    """A rigid body: its mass centre, about which `inertia` is, lies on its line, `centre` from the origin."""

    name: str
    mass: float
    inertia: float
    centre: float = 0.0


@dataclass(frozen=True)
class Marker:
    """A point (along, across) of a body's line from its origin, or of the ground, and a direction there."""

    body: str = GROUND
    at: tuple[float, float] = (0.0, 0.0)
    direction: float = 0.0


@dataclass(frozen=True)
class Play:
    """What a joint's clearance needs: F_n = law(u, v_n), F_t = friction(F_n, v_t), sizes of what touches.

    Without tension the force is the law's where that pushes, and 0 elsewhere.
    """

    clearance: float
    law: Callable[[float, float], float]
    friction: Callable[[float, float], float] | None = None
    tension: bool = True
    radius: float = 0.0
    half_length: float = 0.0
    half_height: float = 0.0
    stored: Callable[[float], float] = lambda u: 0.0  # elastic energy at a penetration


@dataclass(frozen=True)
class Touch:
    """A point of possible touch: penetration, speeds and their rows, directions of force on the bearing."""

    play: Play
    u: float
    v_n: float
    v_t: float
    W_n: np.ndarray
    W_t: np.ndarray
    normal: np.ndarray
    tangent: np.ndarray

    def law(self) -> float:
        """The law's force, whether or not it acts."""
        return self.play.law(self.u, self.v_n)

    def forces(self, closed: bool) -> tuple[float, float]:
        """F_n and F_t."""
        F_n = self.law() if closed else 0.0
        return F_n, self.play.friction(F_n, self.v_t) if closed and self.play.friction else 0.0


class Now:
    """Positions and speeds of all bodies at one instant."""

    def __init__(self, system: System, t: float, y: np.ndarray):
        self.t, self.at, self.n = t, system.at, len(y) // 2
        self.q, self.v, self.centres = y[: self.n], y[self.n :], system.centres

    def point(self, m: Marker) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Position, its rows, velocity and the acceleration that remains where all accelerations are 0."""
        J = np.zeros((2, self.n))
        if m.body == GROUND:
            return np.array(m.at), J, np.zeros(2), np.zeros(2)
        i = self.at[m.body]
        c, s = math.cos(self.q[i + 2]), math.sin(self.q[i + 2])
        along, across = m.at[0] - self.centres[m.body], m.at[1]
        arm = np.array([c * along - s * across, s * along + c * across])
        J[0, i] = J[1, i + 1] = 1.0
        J[:, i + 2] = -arm[1], arm[0]
        return self.q[i : i + 2] + arm, J, J @ self.v, -(self.v[i + 2] ** 2) * arm

    def turn(self, m: Marker) -> tuple[float, np.ndarray, float]:
        """Angle of a marker's direction, its row, angular velocity."""
        J = np.zeros(self.n)
        if m.body == GROUND:
            return m.direction, J, 0.0
        i = self.at[m.body] + 2
        J[i] = 1.0
        return self.q[i] + m.direction, J, self.v[i]

    def between(self, a: Marker, b: Marker) -> tuple[np.ndarray, ...]:
        """What `point` gives, of a relative to b."""
        return tuple(x - y for x, y in zip(self.point(a), self.point(b), strict=True))

    def along(self, a: Marker, b: Marker) -> SimpleNamespace:
        """Slide and rise of a in b's directions d and n, their rows, speeds and accelerations at a = 0."""
        r, J, rate, bias = self.between(a, b)
        angle, J_b, w = self.turn(b)
        d = np.array([math.cos(angle), math.sin(angle)])
        n = np.array([-d[1], d[0]])
        x, y = r @ d, r @ n
        return SimpleNamespace(
            d=d,
            n=n,
            slide=x,
            rise=y,
            slide_row=d @ J + y * J_b,  # d turns towards n, n away from d
            rise_row=n @ J - x * J_b,
            slide_rate=d @ rate + y * w,
            rise_rate=n @ rate - x * w,
            rise_bias=n @ bias - 2 * w * (d @ rate) - w * w * y,
        )


@dataclass(frozen=True)
class Revolute:
    """A journal in a bearing: both points coincide, or, with play, may lie its clearance apart."""

    name: str
    journal: Marker
    bearing: Marker
    play: Play | None = None
    many: ClassVar[int] = 2  # rows

    def rows(self, now: Now) -> tuple[np.ndarray, ...]:
        """g, G, g_t and bias of the ideal joint."""
        r, J, _, bias = now.between(self.journal, self.bearing)
        return r, J, np.zeros(2), bias

    def touches(self, now: Now) -> list[Touch]:
        """The bearing's one point of touch, in the journal's direction; none where that has no direction."""
        r, J, rate, _ = now.between(self.journal, self.bearing)
        rho = math.hypot(*r)
        if rho == 0.0:
            none = np.zeros(now.n)
            return [Touch(self.play, -self.play.clearance, 0.0, 0.0, none, none, np.zeros(2), np.zeros(2))]
        e = r / rho
        t = np.array([-e[1], e[0]])
        (_, J_p, w_p), (_, J_q, w_q) = now.turn(self.journal), now.turn(self.bearing)
        R = self.play.radius
        v_t = t @ rate + w_p * R - w_q * (R + rho)
        W_t = t @ J + R * J_p - (R + rho) * J_q
        return [Touch(self.play, rho - self.play.clearance, e @ rate, v_t, e @ J, W_t, e, t)]

    def on_bearing(self, now: Now, multipliers: np.ndarray) -> np.ndarray:
        """Force x, y on the bearing; no moment."""
        return np.array([*multipliers, 0.0])


@dataclass(frozen=True)
class Prismatic:
    """A slider (journal) on a guide (bearing): no turn, no rise; with play, four corners in two faces."""

    name: str
    journal: Marker
    bearing: Marker
    play: Play | None = None
    many: ClassVar[int] = 2  # rows

    def rows(self, now: Now) -> tuple[np.ndarray, ...]:
        """g, G, g_t and bias of the ideal joint."""
        (turned, J_p, _), (angle, J_q, _) = now.turn(self.journal), now.turn(self.bearing)
        seen = now.along(self.journal, self.bearing)
        g, G = np.array([turned - angle, seen.rise]), np.array([J_p - J_q, seen.rise_row])
        return g, G, np.zeros(2), np.array([0.0, seen.rise_bias])

    def touches(self, now: Now) -> list[Touch]:
        """Corners fore and aft of the upper face, then of the lower."""
        a, b, c = self.play.half_length, self.play.half_height, self.play.clearance
        found = []
        for side, fore in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
            seen = now.along(self._corner(fore * a, side * b), self.bearing)
            u, v_n, W_n = (side * x for x in (seen.rise, seen.rise_rate, seen.rise_row))
            touch = (u - b - c, v_n, seen.slide_rate, W_n, seen.slide_row, side * seen.n, seen.d)
            found.append(Touch(self.play, *touch))
        return found

    def _corner(self, x: float, y: float) -> Marker:
        m = self.journal
        c, s = math.cos(m.direction), math.sin(m.direction)
        return Marker(m.body, (m.at[0] + c * x - s * y, m.at[1] + s * x + c * y))

    def on_bearing(self, now: Now, multipliers: np.ndarray) -> np.ndarray:
        """Force x, y on the guide, acting at the journal's point, and the moment about that point."""
        return np.array([*(multipliers[1] * now.along(self.journal, self.bearing).n), multipliers[0]])


@dataclass(frozen=True)
class Load:
    """Generalised forces of something, and the energy that it stores."""

    forces: Callable[[Now], np.ndarray]
    energy: Callable[[Now], float] = lambda now: 0.0


@dataclass
class System:
    """Bodies, what joins, drives and loads them; gravity in a direction."""

    bodies: Sequence[Body]
    joints: Sequence[Revolute | Prismatic]
    drives: Sequence = ()
    loads: Sequence[Load] = ()
    gravity: float = 9.8
    direction: float = -math.pi / 2
    at: dict = field(init=False)

    def __post_init__(self):
        self.at = {body.name: 3 * i for i, body in enumerate(self.bodies)}
        self.centres = {body.name: body.centre for body in self.bodies}
        self.mass = np.array([x for body in self.bodies for x in (body.mass, body.mass, body.inertia)])
        pull = self.gravity * np.array([math.cos(self.direction), math.sin(self.direction), 0.0])
        self.weight = self.mass * np.tile(pull, len(self.bodies))
        self.ideal = [part for part in (*self.joints, *self.drives) if part.play is None]
        self.loose = [joint for joint in self.joints if joint.play]

    def constraints(self, now: Now, parts: Sequence) -> list[np.ndarray]:
        """g, G, g_t and bias of these joints and drives, taken as ideal."""
        none = np.zeros(0), np.zeros((0, now.n)), np.zeros(0), np.zeros(0)
        return [np.concatenate(rows) for rows in zip(none, *(part.rows(now) for part in parts), strict=True)]

    def touches(self, now: Now) -> list[tuple[str, Touch]]:
        """All points of touch, with the names of their joints."""
        return [(joint.name, touch) for joint in self.loose for touch in joint.touches(now)]

    def solve(self, t: float, y: np.ndarray, closed: Sequence[bool]) -> SimpleNamespace:
        """Accelerations; x, y, moment on bearings of ideal joints; (name, touch, F_n, F_t) of all touches."""
        now = Now(self, t, y)
        Q = self.weight + sum((load.forces(now) for load in self.loads), np.zeros(now.n))
        touched = []
        for (name, touch), shut in zip(self.touches(now), closed, strict=True):
            F_n, F_t = touch.forces(shut)
            Q = Q - F_n * touch.W_n - F_t * touch.W_t
            touched.append((name, touch, F_n, F_t))
        _, G, _, bias = self.constraints(now, self.ideal)
        n, m = now.n, len(bias)
        matrix = np.zeros((n + m, n + m))
        matrix[range(n), range(n)] = self.mass
        matrix[:n, n:], matrix[n:, :n] = G.T, G
        found = np.linalg.solve(matrix, np.concatenate([Q, -bias]))
        reactions, i = {}, n
        for part in self.ideal:
            reactions[part.name] = part.on_bearing(now, found[i : i + part.many])
            i += part.many
        return SimpleNamespace(acceleration=found[:n], reactions=reactions, touches=touched, now=now)

    def energy(self, t: float, y: np.ndarray, closed: Sequence[bool] = ()) -> float:
        """Kinetic, of weight, of loads, and stored in closed touches."""
        now = Now(self, t, y)
        stored = sum(load.energy(now) for load in self.loads)
        for (_, touch), shut in zip(self.touches(now), closed or [False] * 99, strict=False):
            stored += touch.play.stored(touch.u) if shut else 0.0
        return 0.5 * now.v @ (self.mass * now.v) - self.weight @ now.q + stored
