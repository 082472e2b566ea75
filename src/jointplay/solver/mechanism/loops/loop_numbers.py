"""Numbers of the equations of slides and ideal loops, and the branch of each loop.

Bases of chains and slides at the start of a linkage that is cut into chains.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from jointplay.display.errors import Problem, raise_any
from jointplay.solver.equations.structure import CORNERS, Linkage
from jointplay.solver.mechanism.loops.dyads import Unknown
from jointplay.solver.mechanism.loops.ideal import State
from jointplay.solver.mechanism.loops.kinematic_chains import Forest, Sum, place_of
from jointplay.solver.mechanism.parts.joints import Joint, Pin
from jointplay.solver.mechanism.records import Mechanism

Motion = np.ndarray  # position and velocity, shape (2, 2)


def loop_numbers(forest: Forest, bases: Bases) -> dict[str, float]:
    """Give the numbers of all slides and closures, with the branches that the start is on.

    Raises
    ------
    InputError
        If a link of a loop has both of its joints at one point.
    """
    values = {}
    for name, link in forest.slides.items():
        values |= _slide(name, link, forest) | forest.base(link).numbers(name, "r")
    for cut, unknowns in forest.cuts:
        for joint in cut:
            closed = forest.closure(joint)
            values |= closed.numbers(joint.name, "r")
            if len(cut) == 1:
                values |= _branch(joint.name, closed, unknowns, forest, bases)
    return values


def guesses(structure: Linkage, bases: Bases) -> np.ndarray:
    """Give the memories of larger groups at the start: cosine and sine of each angle, slides; and scales.

    Returns
    -------
    ndarray, shape (memories, 2)
        Without unit, or in m.
    """
    rows = []
    for unknown in structure.guessed:
        if isinstance(unknown, str):
            angle = bases.state.angles[unknown]
            rows += [(math.cos(angle), 1.0), (math.sin(angle), 1.0)]
        else:
            rows.append((bases.slide(unknown[1])[0], max(link.length for link in bases.mechanism.links)))
    return np.array(rows, dtype=float).reshape(-1, 2)


def _slide(name: str, link: str, forest: Forest) -> dict[str, float]:
    """Directions of guide and slider: from the guide's link, or from +x on the ground."""
    inner, outer = forest.places[link].sides
    turn = inner.direction - outer.direction
    word = "turn_" if inner.point is None else ""
    return {
        f"{word}c_{link}": math.cos(turn),
        f"{word}s_{link}": math.sin(turn),
        f"dc_{name}": math.cos(inner.direction),
        f"ds_{name}": math.sin(inner.direction),
    }


def _branch(
    name: str, vector: Sum, unknowns: tuple[Unknown, ...], forest: Forest, bases: Bases
) -> dict[str, float]:
    """Lengths of a closure's closed form, and the sign of its root: see equations.loops.loop."""
    angles = [k for k in unknowns if isinstance(k, str)]
    slides = [k[1] for k in unknowns if not isinstance(k, str)]
    if not angles:
        return {f"{word}_{name}": 0.0 for word in ("one", "two", "side")}
    own = slides and _turns_with(forest.slides[slides[0]], angles[0], forest)
    accepted = "a link whose two joints in a loop are apart is accepted"
    lost = [k for k in angles if not own and k not in vector.arms]
    raise_any((Problem("mechanism.joints", f"both at one point of {k}", accepted) for k in lost), "mechanism")
    arms = {k: vector.arms.get(k, 0.0) * cmath.rect(1.0, bases.state.angles[k]) for k in vector.arms}
    if len(angles) == 2:
        one, two = (arms[k] for k in angles)
        return _numbers(name, abs(one), abs(two), (two.conjugate() * one).imag)
    along = cmath.rect(1.0, bases.line(bases.mechanism.joint(slides[0]).bearing)[0])
    if not own:
        return _numbers(name, abs(arms[angles[0]]), 0.0, (arms[angles[0]] * along.conjugate()).real)
    turning = sum(arm for k, arm in arms.items() if _turns_with(k, angles[0], forest)) * along.conjugate()
    run = vector.slides[slides[0]] * bases.slide(slides[0])[0]
    return _numbers(name, turning.real, turning.imag, turning.real + run)


def _numbers(name: str, one: float, two: float, side: float) -> dict[str, float]:
    return {f"one_{name}": one, f"two_{name}": two, f"side_{name}": math.copysign(1.0, side)}


def _turns_with(link: str, other: str, forest: Forest) -> bool:
    """Whether a link has the angle of another but for a constant: they are one, or on guides of it."""
    guides: Mapping[str, str] = {sliding: forest.places[sliding].holder for sliding in forest.slides.values()}
    while link != other and link in guides:
        link = guides[link]
    return link == other


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
        return self.state.points[pin.link] + pin.at * np.array([d, self.state.speeds[pin.link] * n])

    def line(self, pin: Pin) -> tuple[float, float]:
        """Direction of a pin's line, rad, and its rate."""
        angles, speeds = self.state.angles, self.state.speeds
        return angles.get(pin.link, 0.0) + pin.direction, speeds.get(pin.link, 0.0)


def _axes(angle: float) -> tuple[np.ndarray, np.ndarray]:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([c, s]), np.array([-s, c])
