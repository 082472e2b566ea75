"""Angles and speeds of the links of a drawn scene at the start.

The links are laid first and the ground's pin at the rocker's end is put where it then has to be, so that a
start at a dead centre, at a change point, or one that no closed loop has, is as good as any other. With the
pins' distances p of the crank, q of the coupler, s of the rocker and g on the ground, the crank of a four-bar
goes round where p + |q - s| < g < q + s - p; at both ends all links come to lie in one line (Grashof's
equality, a change point): there crank and ground line meet at the angles 0 and pi.
"""

from __future__ import annotations

import cmath
import math

import numpy as np

from jointplay_lab.stress.ranges import NEAR, SPEED, logarithmic, sign

GEOMETRIES = ("closed", "any", "change_point", "near_change_point", "dead_centre", "near_dead_centre")
INSIDE = (0.05, 0.95)  # of the range of ground lengths in which the crank goes round
REST, NOMINAL = 0.15, 0.55  # shares of starts at rest, and up to the nominal speed
FLAT = 0.05  # relative singular value below which the crank does not determine a speed


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
