"""Scenes far outside ordinary use, each drawn by its number from the seed of a series.

A scene is drawn from `numpy.random.SeedSequence(seed, spawn_key=(number,))` alone, so that any of them can be
made by itself, and more can be added. The first `CORNERS` have stiffness, clearance, gear ratio, damping,
friction and thickness of the links at the ends of their ranges, in every combination; the others are random.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from jointplay.display.errors import Problem, strangers, with_keys
from jointplay.solver.mechanism.loops.dyads import FourBar
from jointplay.solver.mechanism.paths import MAIN_JOINT
from jointplay.solver.mechanism.records import GROUND, Mechanism, MotorLine
from jointplay_lab.stress import ranges
from jointplay_lab.stress.others import PRESETS, ROWS, pairs, preset, shallow, with_laws
from jointplay_lab.stress.ranges import GEOMETRIES, laid, moving

CORNERS = 64
VARIANTS: dict[str, dict[str, Any]] = {
    "rigid": {},
    "no_tension": {"tension": False},
    "frictionless": {"friction": 0.0},
    "elastic": {"elastic": ("coupler",)},
    "elastic_no_tension": {"elastic": ("coupler",), "tension": False},
    **{name: {} for name in ROWS},
    "elastic_laws": {"elastic": ("coupler",)},
}
FOUR_BARS = tuple(VARIANTS)[:5]  # with the contact as it is drawn
STARTS = ("centre", "inside", "edge", "deep")


@dataclass(frozen=True)
class Case:
    """A scene: its mechanism and initial state, and the choices by which it was drawn."""

    number: int
    mechanism: Mechanism
    initial: dict[str, Any]
    variant: str
    geometry: str
    start: str

    @property
    def contact_law(self) -> str:
        """Law of contact of the joints with clearance."""
        return self.mechanism.clearance_joints[0].contact.law

    @property
    def friction_law(self) -> str:
        """Law of friction of the joints with clearance, or ``none``."""
        friction = self.mechanism.clearance_joints[0].friction
        return friction.law if friction else "none"


def not_drawable(mechanism: Any) -> list[Problem]:
    """Problems of a mechanism that is no motor-driven four-bar, whose numbers can be drawn."""
    if mechanism is None:
        return []
    if isinstance(mechanism, Mechanism) and isinstance(mechanism.drive, MotorLine):
        loop = FourBar.of(mechanism.joints, mechanism.crank)
        joint = mechanism.joint(loop.joints[2]) if loop else None
        bare = not (mechanism.springs or mechanism.loads)
        drawn = joint and joint.name == MAIN_JOINT and joint.contact and joint.contact.law == "kelvin_voigt"
        if bare and drawn and loop.links[1] == "coupler":
            return []
    expected = (
        "a linkage like catalog.chunmei2002() is accepted: a motor-driven four-bar with kelvin_voigt contact "
        "at B, without springs or loads"
    )
    return [Problem("mechanism", mechanism, expected)]


def unknown_variants(variants: tuple[str, ...]) -> list[Problem]:
    """Problems of names of variants: unknown, or none given."""
    if not variants:
        return [Problem("variants", variants, f"at least one of {', '.join(VARIANTS)} is accepted")]
    return list(strangers(with_keys("variants", variants), VARIANTS, "variant"))


def draw(printed: Mechanism, number: int, seed: int = 0, variants: tuple[str, ...] = FOUR_BARS) -> Case:
    """Draw a scene of a series: a motor-driven four-bar with other numbers, or another mechanism."""
    random = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(number,)))
    ends = [number >> bit & 1 if number < CORNERS else None for bit in range(6)]
    rows = [(variant, laws) for variant in variants for laws in pairs(variant)]
    variant, laws = rows[int(random.random() * len(rows))]
    if variant in PRESETS:
        return Case(number, *preset(random, variant, laws), variant, "closed", "centre")
    geometry, start = (str(random.choice(words)) for words in (GEOMETRIES, STARTS))
    if laws and shallow(laws[0]) and start in ("edge", "deep"):
        start = "inside"
    contact = {"stiffness": ranges.logarithmic(random, ranges.STIFFNESS, ends[0])}
    contact["damping"] = ranges.damping(random, ends[3])
    changes = {"clearance": ranges.logarithmic(random, ranges.CLEARANCE, ends[1])}
    changes["gear_ratio"] = ranges.logarithmic(random, ranges.GEAR_RATIO, ends[2])
    changes["friction"] = ranges.even(random, ranges.FRICTION, ends[4])
    links, lengths = _links(random, printed, ends[5])
    loop = FourBar.of(printed.joints, printed.crank)
    spans = tuple(span * lengths[name] for span, name in zip(loop.spans, loop.links, strict=True))
    angles = laid(random, spans, geometry)
    nominal = printed.drive.nominal_speed * printed.drive.gear_ratio / changes["gear_ratio"]
    speeds = moving(random, spans, angles, nominal)
    r = _journal(random, start, changes["clearance"], contact["stiffness"])
    radius = ranges.logarithmic(random, ranges.RADIUS)
    joints = _joints(printed, lengths, _pivot(printed, loop, spans, angles, r), contact, radius)
    fitted = Mechanism(**dict(printed) | {"links": links, "joints": joints})
    states = {"angle": angles, "angular_velocity": speeds}
    initial = {name: dict(zip(loop.links, values, strict=True)) for name, values in states.items()}
    changed = fitted.replace(**changes | VARIANTS[variant])
    changed = with_laws(random, changed, laws) if laws else changed
    return Case(number, changed, initial, variant, geometry, start)


def _links(random: np.random.Generator, printed: Mechanism, end: int | None) -> tuple[list, dict[str, float]]:
    """Links longer or shorter, thinner or thicker (mass as length × thickness²), and ratios of lengths."""
    links, lengths = [], {}
    for link in (each.total for each in printed.links):
        length = ranges.logarithmic(random, ranges.LENGTH)
        thickness = ranges.logarithmic(random, ranges.THICKNESS, end)
        mass, table = length * thickness**2, link.model_dump()
        table["beam"] |= {"modulus": ranges.logarithmic(random, ranges.MODULUS)}
        table["beam"] |= {"damping_ratio": ranges.even(random, ranges.DAMPING_RATIO)}
        table["beam"] |= {"area": None, "second_moment": None}
        table |= {"length": link.length * length, "centre": link.centre * length}
        table |= {"mass": link.mass * mass, "inertia": link.inertia * mass * length**2}
        lengths[link.name] = length
        links.append(table)
    return links, lengths


def _journal(random: np.random.Generator, start: str, clearance: float, stiffness: float) -> complex:
    """Draw the journal's position in its bearing, m."""
    angle, share = random.uniform(-math.pi, math.pi), random.random()
    depth = ranges.logarithmic(random, ranges.DEPTH) * clearance
    depth = min(depth, ranges.logarithmic(random, ranges.FORCE) / stiffness)
    radius = {"centre": 0.0, "inside": share * clearance, "edge": clearance, "deep": clearance + depth}[start]
    return radius * complex(math.cos(angle), math.sin(angle))


def _pivot(printed: Mechanism, loop: FourBar, spans, angles: list[float], r: complex) -> list[float]:
    """Position of the rocker's ground pin that puts the journal where it was drawn, m."""
    p, q, s = (d * complex(math.cos(a), math.sin(a)) for d, a in zip(spans, angles, strict=True))
    if printed.joint(MAIN_JOINT).journal.link != loop.links[1]:
        r = -r
    sides = [*map(abs, spans), abs(p + q - s - r)]
    if 2 * max(sides) >= sum(sides):  # links in one line, that the clearance alone would let close
        r = -r
    pivot = loop.origin + p + q - s - r
    return [pivot.real, pivot.imag]


def _joints(
    printed: Mechanism, lengths, pivot: list[float], contact: dict[str, float], radius: float
) -> list:
    """The joints at their places on the sized links and on the ground, with the contact drawn."""
    loop, tables = FourBar.of(printed.joints, printed.crank), []
    for joint in printed.joints:
        table = joint.model_dump()
        for pin in (table["journal"], table["bearing"]):
            pin["at"] *= lengths.get(pin["link"], 1.0)
            if joint.name == loop.joints[3] and pin["link"] == GROUND:
                pin["point"] = pivot
        if joint.name == MAIN_JOINT:
            table |= {"contact": table["contact"] | contact, "radius": radius}
        tables.append(table)
    return tables
