"""The ranges from which scenes are drawn, even in the logarithm, or at an end."""

from __future__ import annotations

import math
from functools import partial

import numpy as np

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
