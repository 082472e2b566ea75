"""Neighbours of a point of a branch: orbits with other events, the same orbit on another section."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from jointplay.analysis.orbits.arclength import solve
from jointplay.analysis.orbits.family import Family, Point
from jointplay.analysis.orbits.orbit_events import same_events
from jointplay.analysis.orbits.section_map import Image

PROBES = (1e-8, 1e-6, 1e-4)  # distances beyond a failure at which events are compared
SMALL = 1e-4  # steps so small that any turn is accepted


def outside(q: Any) -> np.ndarray:
    """Indices of the parameters that are beyond their ranges."""
    q = np.atleast_1d(q)
    return np.flatnonzero((q < 0.0) | (q > 1.0))


def distance(one: Point, other: Point) -> float:
    """Distance of two points on the same section."""
    return float(np.linalg.norm(one.z - other.z))


def same_orbit_events(one: Point, other: Point) -> bool:
    """Whether the orbits of two points have the same events."""
    return same_events(one.orbit.image.events, other.orbit.image.events)


def image_beyond(family: Family, point: Point) -> tuple[Image, float] | None:
    """The first image with other events of motions a little beyond a point, along its tangent; distance."""
    for distance in PROBES:
        map_there, state = family.placed(point.z + distance * point.tangent, point)
        image = map_there.image(state, False)
        if not image.status and not same_events(image.events, point.orbit.image.events):
            return image, distance
    return None


def half_shift(point: Point) -> np.ndarray:
    """Difference of an orbit's states on the section half its turns apart."""
    section, state = point.orbit.map, point.orbit.state
    return section.differ(section.image(state, False, section.turns // 2).state, state)


def shifted(family: Family, point: Point, angle: float) -> Point:
    """The point on the section `angle` rad on; the same point where that fails."""
    z = point.z + SMALL * point.tangent
    section = point.orbit.map
    there, here = section.moved(point.orbit.state, angle)
    neighbour, state = family.placed(z, point)
    neighbour_there = neighbour.moved(state, angle)[1]
    if here.status or neighbour_there.status:
        return point
    like = replace(point, orbit=replace(point.orbit, map=there, state=here.state), directions=None)
    along = np.append(there.differ(neighbour_there.state, here.state) / point.unit, family.place(z) - point.q)
    along /= np.linalg.norm(along)
    return solve(family, like, like.z, along) or point
