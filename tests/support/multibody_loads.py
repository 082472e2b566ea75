"""Drives, loads and laws of contact and friction for the bodies of `tests.support.multibody`."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from tests.support.multibody import Load, Marker, Now


def force(marker: Marker, of: Callable[[Now], Sequence[float]]) -> Load:
    """A force x, y (fixed axes) at a marker."""
    return Load(lambda now: np.asarray(of(now)) @ now.point(marker)[1])


def torque(body: str, of: Callable[[Now], float]) -> Load:
    """A torque on a body."""
    return Load(lambda now: of(now) * now.turn(Marker(body))[1])


def motor(body: str, a: float, b: float) -> Load:
    """A torque a − b ω."""
    return torque(body, lambda now: a - b * now.turn(Marker(body))[2])


def spring(p: Marker, q: Marker, k: float, length: float = 0.0, damping: float = 0.0) -> Load:
    """A spring and damper between two points; of length 0, one whose pull is k r + c ṙ."""

    def pulls(now: Now) -> np.ndarray:
        r, J, rate, _ = now.between(p, q)
        if length == 0.0:
            return -(k * r + damping * rate) @ J
        e = r / math.hypot(*r)
        return -(k * (math.hypot(*r) - length) + damping * (e @ rate)) * (e @ J)

    return Load(pulls, lambda now: 0.5 * k * (math.hypot(*now.between(p, q)[0]) - length) ** 2)


def torsion(p: Marker, q: Marker, k: float, angle: float = 0.0, damping: float = 0.0) -> Load:
    """A torsion spring and damper between two directions, free of moment where they differ by an angle."""

    def turns(now: Now) -> np.ndarray:
        (a, J_p, w_p), (b, J_q, w_q) = now.turn(p), now.turn(q)
        return -(k * (a - b - angle) + damping * (w_p - w_q)) * (J_p - J_q)

    return Load(turns, lambda now: 0.5 * k * (now.turn(p)[0] - now.turn(q)[0] - angle) ** 2)


@dataclass(frozen=True)
class Driven:
    """A body's angle as a function of time: `profile(t)` gives α, α̇, α̈."""

    name: str
    body: str
    profile: Callable[[float], tuple[float, float, float]]
    play: ClassVar[None] = None
    many: ClassVar[int] = 1  # rows

    def rows(self, now: Now) -> tuple[np.ndarray, ...]:
        """g, G, g_t and bias."""
        angle, J, _ = now.turn(Marker(self.body))
        alpha, rate, acceleration = self.profile(now.t)
        return np.array([angle - alpha]), J[None], np.array([-rate]), np.array([-acceleration])

    def on_bearing(self, now: Now, multipliers: np.ndarray) -> np.ndarray:
        """Moment on the ground; the drive's torque on the body is its opposite."""
        return np.array([0.0, 0.0, multipliers[0]])


@dataclass(frozen=True)
class Held:
    """A number of a state, and its rate, that a start is to have: `of` gives number and row."""

    name: str
    of: Callable[[Now], tuple[float, np.ndarray]]
    number: float = 0.0
    rate: float = 0.0
    play: ClassVar[None] = None

    def rows(self, now: Now) -> tuple[np.ndarray, ...]:
        """g, G, g_t and no bias: it holds nothing as time goes on."""
        number, J = self.of(now)
        return np.array([number - self.number]), J[None], np.array([-self.rate]), np.zeros(1)


def constant_speed(body: str, speed: float, start: float = 0.0) -> Driven:
    """A body that turns at a constant speed from an angle at t = 0."""
    return Driven("drive", body, lambda t: (start + speed * t, speed, 0.0))


def kelvin_voigt(K: float, C: float) -> Callable[[float, float], float]:
    """F_n = K u + C v_n."""
    return lambda u, v_n: K * u + C * v_n


def tanh_friction(f: float, v_0: float, C_t: float = 0.0) -> Callable[[float, float], float]:
    """F_t = f F_n tanh(v_t/v_0) + C_t v_t."""
    return lambda F_n, v_t: f * F_n * math.tanh(v_t / v_0) + C_t * v_t
