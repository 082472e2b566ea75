"""Rigid bodies in a plane, each with three coordinates of its own: a second program to hold results against.

Newton and Euler for every body at its mass centre, q = (x, y, θ) a body. Ideal joints and drives are rows
g(t, q) = 0:

    [M Gᵀ; G 0] [a; λ] = [Q; −bias]        ġ = G v + g_t,   g̈ = G a + bias

solved densely. Joints with clearance are forces at points of touch: with v_n = W_n·v and v_t = W_t·v the
speeds of penetration and of sliding, Q −= F_n W_n + F_t W_t (virtual power). No reduced coordinates, no
closed forms, no code of the package. A body that bends has further coordinates, behind those of all bodies:
`multibody_beams`. What loads and drives is in `multibody_loads`, laws of touch are in `multibody_laws`;
`multibody_run` assembles and follows motions.

A touch has a mode: "free" or "released" (no force), "closed" (both laws), "slip+" and "slip-" (dry friction,
of that sign), "stick" (v_t stays 0 by a force within the cone); of rigid ones "rest" and "rest+", "rest-",
"rest=" (v_n stays 0 by a force that pushes; without friction, slipping, sticking).

A `Marker` is a point of a body, given along and across the body's line from its origin, with a direction
relative to that line; on the ground, in fixed axes. Units: SI.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
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
    beam: object = None  # a row of particles, see `multibody_beams`


@dataclass(frozen=True)
class Marker:
    """A point (along, across) of a body's line from its origin, or of the ground, and a direction there."""

    body: str = GROUND
    at: tuple[float, float] = (0.0, 0.0)
    direction: float = 0.0


@dataclass(frozen=True)
class Play:
    """What a joint's clearance needs: F_n = law(u, v_n), F_t = friction(F_n, v_t), sizes of what touches.

    Without tension the force is the law's where that pushes, and 0 elsewhere. A law that remembers takes the
    speed v_0 with which the touch began, `slowest` at least, too. Friction is that function, or `dry`:
    sliding by mu(|v_t|) F_n, and sticking up to mu(0) F_n; or `bristles`: mu and z' of v_t and their bend z.
    With a `restitution` there is no law: touches are impacts, and rest.
    """

    clearance: float
    law: Callable[..., float] | None
    friction: Callable[[float, float], float] | None = None
    tension: bool = True
    radius: float = 0.0
    half_length: float = 0.0
    half_height: float = 0.0
    stored: Callable[[float], float] = lambda u: 0.0  # elastic energy at a penetration
    slowest: float | None = None
    dry: Callable[[float], float] | None = None
    viscous: float = 0.0
    bristles: Callable[[float, float], tuple[float, float]] | None = None
    restitution: float | None = None


@dataclass(frozen=True)
class Touch:
    """A point of possible touch: penetration, speeds and their rows, directions of force on the bearing.

    Rates of the speeds where all accelerations are 0 are `bias_n` and `bias_t`.
    """

    play: Play
    u: float
    v_n: float
    v_t: float
    W_n: np.ndarray
    W_t: np.ndarray
    normal: np.ndarray
    tangent: np.ndarray
    bias_n: float = 0.0
    bias_t: float = 0.0
    v_0: float | None = None
    z: float = 0.0

    def law(self) -> float:
        """The law's force, whether or not it acts."""
        remembered = () if self.play.slowest is None else (self.v_0,)
        return self.play.law(self.u, self.v_n, *remembered)

    def forces(self, mode: str) -> tuple[float, float]:
        """F_n and F_t, but what a multiplier gives."""
        play = self.play
        if mode in ("free", "released") or mode.startswith("rest"):
            return 0.0, 0.0
        F_n, drag = self.law(), play.viscous * self.v_t
        if mode.startswith("slip"):
            return F_n, SENSE[mode] * play.dry(abs(self.v_t)) * F_n + drag
        if mode == "closed" and play.bristles:
            return F_n, play.bristles(self.v_t, self.z)[0] * F_n + drag
        return F_n, play.friction(F_n, self.v_t) if mode == "closed" and play.friction else 0.0

    def held(self, mode: str) -> list[tuple[np.ndarray, np.ndarray, float]]:
        """Of what stays at rest: (row, direction of its force, bias) for each multiplier."""
        rows = []
        if mode.startswith("rest"):
            slip = SENSE.get(mode, 0.0) * (self.play.dry(0.0) if self.play.dry else 0.0)
            rows.append((self.W_n, self.W_n + slip * self.W_t, self.bias_n))
        if mode in ("stick", "rest="):
            rows.append((self.W_t, self.W_t, self.bias_t))
        return rows


SENSE = {"slip+": 1.0, "slip-": -1.0, "rest+": 1.0, "rest-": -1.0}


class Now:
    """Positions and speeds of all bodies at one instant."""

    def __init__(self, system: System, t: float, y: np.ndarray, memory: Sequence[float] = ()):
        self.t, self.at, self.n = t, system.at, system.n
        self.q, self.v, self.centres = y[: self.n], y[self.n : 2 * self.n], system.centres
        self.beams, self.z, self.memory = system.beams, y[2 * self.n :], memory

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
        bias = np.zeros(2)
        if m.body in self.beams:
            beam, own = self.beams[m.body]
            far = beam.far(m.at[0])  # how the link's end moves along its line
            out, out_rate, e = far @ self.q[own], far @ self.v[own], np.array([c, s])
            arm = arm + out * e
            J[:, own] = np.outer(e, far)
            bias = 2 * self.v[i + 2] * out_rate * np.array([-s, c])
        J[:, i + 2] = -arm[1], arm[0]
        return self.q[i : i + 2] + arm, J, J @ self.v, bias - (self.v[i + 2] ** 2) * arm

    def turn(self, m: Marker) -> tuple[float, np.ndarray, float]:
        """Angle of a marker's direction, its row, angular velocity."""
        J = np.zeros(self.n)
        if m.body == GROUND:
            return m.direction, J, 0.0
        i = self.at[m.body] + 2
        J[i] = 1.0
        return self.q[i] + m.direction, J, self.v[i]

    def surface(self, m: Marker) -> tuple[np.ndarray, float]:
        """Row and angular velocity of the material at a marker: of a bent link, with its end's slope."""
        _, J, w = self.turn(m)
        if m.body in self.beams:
            beam, own = self.beams[m.body]
            slope = beam.slope(m.at[0])
            J[own], w = slope, w + slope @ self.v[own]
        return J, w

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
            slide_bias=d @ bias + 2 * w * (n @ rate) - w * w * x,
        )


@dataclass(frozen=True)
class Joint:
    """Base class of joints: ideal ones have `rows` g, G, g_t and bias, those with play have touches."""

    name: str
    journal: Marker
    bearing: Marker
    play: Play | None = None
    many: ClassVar[int] = 2  # rows


class Revolute(Joint):
    """A journal in a bearing: both points coincide, or, with play, may lie its clearance apart."""

    def rows(self, now: Now) -> tuple[np.ndarray, ...]:
        """g, G, g_t and bias of the ideal joint."""
        r, J, _, bias = now.between(self.journal, self.bearing)
        return r, J, np.zeros(2), bias

    def touches(self, now: Now) -> list[Touch]:
        """The bearing's one point of touch, in the journal's direction; none where that has no direction."""
        r, J, rate, bias = now.between(self.journal, self.bearing)
        rho = math.hypot(*r)
        if rho == 0.0:
            none = np.zeros(now.n)
            return [Touch(self.play, -self.play.clearance, 0.0, 0.0, none, none, np.zeros(2), np.zeros(2))]
        e = r / rho
        t = np.array([-e[1], e[0]])
        (J_p, w_p), (J_q, w_q) = now.surface(self.journal), now.surface(self.bearing)
        R, v_n, across = self.play.radius, e @ rate, t @ rate
        v_t = across + w_p * R - w_q * (R + rho)
        W_t = t @ J + R * J_p - (R + rho) * J_q
        biases = e @ bias + across**2 / rho, t @ bias - v_n * across / rho - w_q * v_n
        return [Touch(self.play, rho - self.play.clearance, v_n, v_t, e @ J, W_t, e, t, *biases)]

    def on_bearing(self, now: Now, multipliers: np.ndarray) -> np.ndarray:
        """Force x, y on the bearing; no moment."""
        return np.array([*multipliers, 0.0])


class Prismatic(Joint):
    """A slider (journal) on a guide (bearing): no turn, no rise; with play, four corners in two faces."""

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
            u, v_n, W_n, bias_n = (
                side * x for x in (seen.rise, seen.rise_rate, seen.rise_row, seen.rise_bias)
            )
            touch = (u - b - c, v_n, seen.slide_rate, W_n, seen.slide_row, side * seen.n, seen.d)
            touch = (*touch, bias_n, seen.slide_bias)
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
    joints: Sequence[Joint]
    drives: Sequence = ()
    loads: Sequence[Load] = ()
    gravity: float = 9.8
    direction: float = -math.pi / 2
    at: dict = field(init=False)

    def __post_init__(self):
        self.at = {body.name: 3 * i for i, body in enumerate(self.bodies)}
        self.centres = {body.name: body.centre for body in self.bodies}
        own = [x for body in self.bodies for x in (body.mass, body.mass, body.inertia)]
        pull = self.gravity * np.array([math.cos(self.direction), math.sin(self.direction), 0.0])
        self.weight, self.beams, n = np.array(own) * np.tile(pull, len(self.bodies)), {}, len(own)
        for body in self.bodies:
            if body.beam:
                self.beams[body.name] = body.beam, slice(n, n + body.beam.size)
                n += body.beam.size
        self.n, bent = n, np.zeros(n - len(own))
        self.mass, self.weight = np.append(own, bent), np.append(self.weight, bent)
        self.ideal = [part for part in (*self.joints, *self.drives) if part.play is None]
        self.loose = [joint for joint in self.joints if joint.play]

    def constraints(self, now: Now, parts: Sequence) -> list[np.ndarray]:
        """g, G, g_t and bias of these joints and drives, taken as ideal."""
        none = np.zeros(0), np.zeros((0, now.n)), np.zeros(0), np.zeros(0)
        return [np.concatenate(rows) for rows in zip(none, *(part.rows(now) for part in parts), strict=True)]

    def touches(self, now: Now) -> list[tuple[str, Touch]]:
        """All points of touch, with the names of their joints, and with what they remember."""
        found = [(joint.name, touch) for joint in self.loose for touch in joint.touches(now)]
        if len(now.memory):
            found = [(n, replace(x, v_0=v_0)) for (n, x), v_0 in zip(found, now.memory, strict=True)]
        if len(now.z):
            found = [(n, replace(x, z=z)) for (n, x), z in zip(found, now.z, strict=True)]
        return found

    def inertia(self, now: Now) -> tuple[np.ndarray, np.ndarray]:
        """Mass matrix; forces of weight, and of bent links' motion, stiffness and damping."""
        M, Q = np.diag(self.mass), self.weight.copy()
        pull = self.gravity * np.array([math.cos(self.direction), math.sin(self.direction)])
        for name, (beam, own) in self.beams.items():
            i = self.at[name]
            where = np.r_[i : i + 3, own]
            more, load = beam.moved(self.centres[name], now.q[where], now.v[where], pull)
            M[np.ix_(where, where)] += more
            Q[where] += load
        return M, Q

    def solve(
        self, t: float, y: np.ndarray, modes: Sequence, memory: Sequence[float] = ()
    ) -> SimpleNamespace:
        """Accelerations; x, y, moment on bearings of ideal joints; (name, touch, F_n, F_t) of all touches.

        A mode may be True or False too, for closed and free.
        """
        now = Now(self, t, y, memory)
        M, Q = self.inertia(now)
        Q = Q + sum((load.forces(now) for load in self.loads), np.zeros(now.n))
        touched, rows, sides, biases = [], [], [], []
        for (name, touch), mode in zip(self.touches(now), modes, strict=True):
            word = mode if isinstance(mode, str) else ("free", "closed")[bool(mode)]
            F_n, F_t = touch.forces(word)
            Q = Q - F_n * touch.W_n - F_t * touch.W_t
            held = touch.held(word)
            touched.append((name, touch, word, F_n, F_t, len(rows)))
            for row, side, bias in held:
                rows, sides, biases = [*rows, row], [*sides, side], [*biases, bias]
        _, G, _, bias = self.constraints(now, self.ideal)
        m, n = len(bias), now.n
        every = np.vstack([G, *rows]) if rows else G
        pushes = np.vstack([G, *sides]) if rows else G
        matrix = np.zeros((n + len(every), n + len(every)))
        matrix[:n, :n], matrix[:n, n:], matrix[n:, :n] = M, pushes.T, every
        right = np.concatenate([Q, -bias, -np.array(biases)])
        try:
            finite = np.isfinite(matrix).all() and np.isfinite(right).all()
            found = np.linalg.solve(matrix, right) if finite else np.full(len(right), np.nan)
        except np.linalg.LinAlgError:  # corners of one face share a force that is one in sum
            found = np.linalg.lstsq(matrix, right, rcond=1e-12)[0]
        reactions, i, held = {}, n, found[n + m :]
        for part in self.ideal:
            reactions[part.name] = part.on_bearing(now, found[i : i + part.many])
            i += part.many
        finished = [(name, touch, *_whole(touch, word, F, held[k:])) for name, touch, word, *F, k in touched]
        return SimpleNamespace(acceleration=found[:n], reactions=reactions, touches=finished, now=now)

    def energies(self, t: float, y: np.ndarray) -> tuple[float, float, float]:
        """Kinetic; of weight and of what loads; of bent links."""
        now, bent = Now(self, t, y), 0.0
        potential = sum(load.energy(now) for load in self.loads) - self.weight @ now.q
        pull = self.gravity * np.array([math.cos(self.direction), math.sin(self.direction)])
        for name, (beam, own) in self.beams.items():
            potential -= pull @ beam.raised(now.q[self.at[name] + 2], now.q[own])
            bent += 0.5 * now.q[own] @ beam.stiffness @ now.q[own]
        return float(0.5 * now.v @ self.inertia(now)[0] @ now.v), float(potential), float(bent)

    def energy(self, t: float, y: np.ndarray, modes: Sequence = ()) -> float:
        """All of them, and what closed touches store."""
        touches = zip(self.touches(Now(self, t, y)), modes or [False] * 99, strict=False)
        shut = [touch for (_, touch), mode in touches if mode and mode not in ("free", "released")]
        return sum(self.energies(t, y)) + sum(touch.play.stored(touch.u) for touch in shut)


def _whole(touch: Touch, mode: str, F: Sequence[float], held: np.ndarray) -> tuple[float, float]:
    """F_n and F_t with what multipliers give."""
    if mode == "stick":
        return F[0], float(held[0])
    if not mode.startswith("rest"):
        return F[0], F[1]
    if mode == "rest=":
        return float(held[0]), float(held[1])
    slip = SENSE.get(mode, 0.0) * (touch.play.dry(0.0) if touch.play.dry else 0.0)
    return float(held[0]), slip * float(held[0])
