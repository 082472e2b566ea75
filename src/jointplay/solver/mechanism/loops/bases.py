"""Bases of chains and slides at the start of a linkage that is cut into chains."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from jointplay.solver.equations.structure import CORNERS
from jointplay.solver.mechanism.loops.ideal import State
from jointplay.solver.mechanism.loops.kinematic_chains import Forest, place_of
from jointplay.solver.mechanism.parts.joints import Joint, Pin
from jointplay.solver.mechanism.records import Mechanism

Motion = np.ndarray  # position and velocity, shape (2, 2)


@dataclass(frozen=True)
class Bases:
    """Bases of chains: floating ones as in the ideal mechanism, sliding ones on their guides.

    Parameters
    ----------
    mechanism : Mechanism
        The linkage.
    forest : Forest
        The same, cut.
    state : State
        Its start.
    """

    mechanism: Mechanism
    forest: Forest
    state: State

    def slide(self, name: str) -> tuple[float, float]:
        """Position of a slider along its guide in the ideal mechanism, m, and its speed, m/s."""
        joint = self.mechanism.joint(name)
        apart = self._ideal(joint.journal) - self._ideal(joint.bearing)
        angle, speed = self.line(joint.bearing)
        d, n = _axes(angle)
        return float(apart[0] @ d), float(apart[1] @ d + apart[0] @ n * speed)

    @cached_property
    def of(self) -> dict[int, Motion]:
        """Position and velocity of the base of each chain."""
        found: dict[int, Motion] = {}
        for name, place in self.forest.places.items():
            if place.chain is None or place.chain in found:
                continue
            if place.parent is None:
                found[place.chain] = self.state.points[name]
                continue
            s, v = self.slide(place.parent.name)
            angle, speed = self.line(place.sides[0])
            d, n = _axes(angle)
            sign = self.forest.base(name).slides[place.parent.name]
            run = np.array([s * d, v * d + s * speed * n])
            found[place.chain] = self._centre(place.sides[0], found) + sign * run
        return found

    def between(self, joint: Joint) -> Motion:
        """A joint's journal relative to its bearing."""
        return self._centre(joint.journal, self.of) - self._centre(joint.bearing, self.of)

    def apart(self, joint: Joint) -> float:
        """Way of a joint's journal, or of a slider's farthest corner, out of its bearing's middle, m."""
        return max(u for u, _ in self.penetrations(joint)) + joint.clearance

    def penetrations(self, joint: Joint) -> list[tuple[float, float]]:
        """Penetration, m, and normal speed, m/s, of each contact of a joint."""
        r, v = self.between(joint)
        if not joint.prismatic:
            rho = math.hypot(*r)
            return [(rho - joint.clearance, r @ v / rho if rho else 0.0)]
        (slider, w_p), (guide, w_q) = self.line(joint.journal), self.line(joint.bearing)
        d, n = _axes(guide)
        found = []
        for front, side in CORNERS.values():
            l, m = _axes(slider)
            p = front * joint.half_length * l + side * joint.half_height * m
            u = side * (n @ (r + p)) - joint.half_height - joint.clearance
            found.append((float(u), float(side * (n @ v + (d @ p) * w_p - (d @ (r + p)) * w_q))))
        return found

    def _centre(self, pin: Pin, bases: Mapping[int, Motion]) -> Motion:
        place = place_of(self.forest.places, pin)
        arm = np.array(place.motion(self.state.angles, self.state.speeds))
        return arm if place.chain is None else arm + bases[place.chain]

    def _ideal(self, pin: Pin) -> Motion:
        if pin.point is not None:
            return np.array([pin.point, (0.0, 0.0)])
        d, n = _axes(self.state.angles[pin.link])
        speed = self.state.speeds[pin.link]
        return self.state.points[pin.link] + pin.at * np.array([d, speed * n])

    def line(self, pin: Pin) -> tuple[float, float]:
        """Direction of a pin's line, rad, and its rate."""
        angles, speeds = self.state.angles, self.state.speeds
        return angles.get(pin.link, 0.0) + pin.direction, speeds.get(pin.link, 0.0)


def _axes(angle: float) -> tuple[np.ndarray, np.ndarray]:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([c, s]), np.array([-s, c])
