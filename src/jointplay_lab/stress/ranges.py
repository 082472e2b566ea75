"""Ranges from which scenes are drawn, even in the logarithm or at an end; angles and speeds at the start.

The links are laid first and the ground's pin at the rocker's end is put where it then has to be, so that a
start at a dead centre, at a change point, or one that no closed loop has, is as good as any other. With the
pins' distances p of the crank, q of the coupler, s of the rocker and g on the ground, the crank of a four-bar
goes round where p + |q - s| < g < q + s - p; at both ends all links come to lie in one line (Grashof's
equality, a change point): there crank and ground line meet at the angles 0 and pi.
"""

from __future__ import annotations

import cmath
import math
from functools import partial

import numpy as np

GEOMETRIES = ("closed", "any", "change_point", "near_change_point", "dead_centre", "near_dead_centre")
INSIDE = (0.05, 0.95)  # of the range of ground lengths in which the crank goes round
REST, NOMINAL = 0.15, 0.55  # shares of starts at rest, and up to the nominal speed
FLAT = 0.05  # relative singular value below which the crank does not determine a speed

STIFFNESS, DAMPING = (1e4, 1e11), (1e-1, 1e5)  # N/m, N s/m; every fourth damping or so is 0
CLEARANCE, GEAR_RATIO, FRICTION = (1e-7, 3e-3), (0.2, 60.0), (0.0, 1.5)  # m, 1, 1
LENGTH, THICKNESS = (0.4, 2.5), (0.3, 3.0)  # of links, relative to the mechanism's own
RADIUS = (1e-3, 5e-2)  # of journals, m
MODULUS, DAMPING_RATIO = (1e9, 3e11), (0.0, 0.1)  # of elastic links: Pa, 1
SPEED = (0.1, 30.0)  # of the crank at the start, relative to the nominal one
DEPTH, FORCE = (1e-3, 3.0), (1e0, 1e6)  # of a start in contact: over the clearance, and at most so many N
NEAR = (1e-9, 1e-2)  # distance from a special place that is near it, relative
TURNING, MASS = (1.0, 300.0), (0.1, 10.0)  # of a catalog's mechanism: rad/s, relative to its own
PUSH, SPRING, TWIST = (0.1, 1e3), (1.0, 1e5), (1e-2, 1e2)  # N, N/m, N m and N m/rad
LEAST_FRICTION = 0.01  # of what has a law of friction beside Coulomb's
Span = tuple[float, float]


def laid(random: np.random.Generator, spans: tuple[float, float, float], geometry: str) -> list[float]:
    """Draw angles of crank, coupler, rocker, rad, whose pins lie `spans` apart along them, m."""
    if geometry == "any":
        return [float(random.uniform(-math.pi, math.pi)) for _ in spans]
    away = sign(random) * logarithmic(random, NEAR) * geometry.startswith("near")
    if geometry.endswith("dead_centre"):
        crank, rocker = (float(random.uniform(-math.pi, math.pi)) for _ in range(2))
        return [crank, rocker + math.pi * (random.random() < 0.5) + away, rocker]
    crank, ground = _round(random, spans, geometry, away)
    return _closed(spans, crank, ground, sign(random))


def _round(random, spans: tuple[float, float, float], geometry: str, away: float) -> tuple[float, float]:
    """Crank angle and ground length of a crank that goes round, or that just does."""
    p, q, s = map(abs, spans)
    ends, angle = (p + abs(q - s), max(q + s - p, 0.1 * s)), float(random.uniform(-math.pi, math.pi))
    share, which, special = random.uniform(*INSIDE), int(random.random() < 0.5), random.random() < 0.5
    if geometry == "closed":
        return angle, ends[0] + share * (ends[1] - ends[0])
    return (math.pi * which if special else angle), ends[which] * (1 + away)


def _closed(spans: tuple[float, float, float], crank: float, ground: float, side: float) -> list[float]:
    """The angles of a closed loop; coupler and rocker in one line where they do not reach."""
    p, q, s = spans
    a = cmath.rect(p, crank)
    gap = ground - a
    d = max(abs(gap), 1e-12 * ground)
    along = min(max((d**2 + q**2 - s**2) / (2 * d), -abs(q)), abs(q))
    joint = a + gap / d * complex(along, side * math.sqrt(max(q**2 - along**2, 0.0)))
    return [crank, cmath.phase((joint - a) / q), cmath.phase((joint - ground) / s)]


def moving(random: np.random.Generator, spans: tuple, angles: list[float], nominal: float) -> list[float]:
    """Draw speeds of crank, coupler, rocker, rad/s: the ideal mechanism's, some at rest, some disturbed."""
    kind, factor = random.random(), sign(random) * logarithmic(random, SPEED)
    disturbed, noise = random.random() < 0.3, random.normal(size=2)
    crank = nominal * (0.0 if kind < REST else 1.0 if kind < NOMINAL else factor)
    across = [1j * cmath.rect(span, angle) for span, angle in zip(spans, angles, strict=True)]
    p, q, s = ([z.real, z.imag] for z in across)
    map_ = np.stack([q, -np.array(s)], -1)
    found = -np.linalg.pinv(map_, rcond=FLAT) @ np.array(p) * crank + disturbed * noise * abs(crank)
    return [crank, *map(float, found)]


def logarithmic(random: np.random.Generator, span: Span, end: int | None = None) -> float:
    """Draw a number even in its logarithm; the lower or upper end of the range where `end` is 0 or 1."""
    drawn = math.exp(random.uniform(*map(math.log, span)))
    return drawn if end is None else span[end]


def even(random: np.random.Generator, span: Span, end: int | None = None) -> float:
    """Draw a number evenly; the lower or upper end of the range where `end` is 0 or 1."""
    drawn = float(random.uniform(*span))
    return drawn if end is None else span[end]


def damping(random: np.random.Generator, end: int | None = None) -> float:
    """Draw a damping: 0, or even in its logarithm."""
    drawn, none = logarithmic(random, DAMPING), random.random() < 0.25
    if end is not None:
        return (0.0, DAMPING[1])[end]
    return 0.0 if none else drawn


def sign(random: np.random.Generator) -> float:
    """Draw 1 or -1."""
    return 1.0 if random.random() < 0.5 else -1.0


# Numbers of laws by their names, where they have them; the last two relative to the coefficient and v_0
OF_LAWS = {
    "restitution": partial(even, span=(0.05, 0.95)),
    "dissipation": partial(logarithmic, span=(1e-3, 1e1)),  # s/m
    "length": partial(logarithmic, span=(5e-3, 5e-2)),  # of bearings, m
    "bearing_modulus": partial(logarithmic, span=MODULUS),
}


OF_FRICTION = {
    "velocity": partial(logarithmic, span=(1e-3, 1e-1)),  # m/s
    "stribeck_velocity": partial(logarithmic, span=(1e-2, 1.0)),  # m/s
    "bristle_stiffness": partial(logarithmic, span=(1e3, 1e6)),  # 1/m
    "bristle_damping": partial(logarithmic, span=(1e-2, 1.0)),  # s/m
    "static_coefficient": partial(even, span=(1.0, 2.0)),
    "full_velocity": partial(even, span=(1.5, 5.0)),
}
