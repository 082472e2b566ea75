"""Derivatives along a branch: of states, numbers and quantities of its orbits.

From a point z of the branch with tangent t the motions that start at z + h t and z - h t, each with its own
parameter, are followed as the orbit is; what is evaluated of both gives

    dy/ds = (y(z + h t) - y(z - h t)) / 2h + O(h^2),

one-sided, + O(h), where only one of them has the orbit's events, as beside a grazing. s is the arc on the
section asked for: of the states there over their scales and over the constant c (arclength), and of the
parameter's fraction of its range. Validity: no event passes that section between them, and one of them has
the orbit's events; else there is no derivative (NaN).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from operator import attrgetter
from typing import Any

import numpy as np

from jointplay.analysis.evaluate import Quantities
from jointplay.analysis.orbits import orbit_events
from jointplay.analysis.orbits.family import Family, Point
from jointplay.analysis.orbits.orbit_events import same_events
from jointplay.analysis.orbits.shooting import Orbit
from jointplay.display.errors import InputError

STEPS = (3e-5, 3e-7)  # h; the second where an event is nearer than the first
JUMP = 1e-4  # of a value: a difference on one side alone that is larger is a jump, as of an angle by a turn
NUMBERS = ("period_time", "smallest_impact_speed")  # of an orbit


@dataclass(frozen=True)
class Motion:
    """A motion at the arc length h from a point of a branch, with its rows on the wanted section.

    `sharp`: rows for accelerations, as `branch_dataset.Passages` gives them.
    """

    h: float
    orbit: Orbit
    rows: np.ndarray
    sharp: np.ndarray

    def rolled(self, by: int) -> Motion:
        """The same with another turn first."""
        return Motion(self.h, self.orbit, *(np.roll(each, -by, axis=0) for each in (self.rows, self.sharp)))

    @property
    def state(self) -> np.ndarray:
        """State on the wanted section."""
        return self.rows[0, 1 : 1 + len(self.orbit.state)]

    def quantities(self, names: Sequence[str]) -> dict[str, Any]:
        """Quantities on the wanted section."""
        return Quantities(self.orbit.map.model, self.rows, self.rows[0], self.sharp).variables(names, "turn")

    def number(self, name: str) -> float:
        """One of `NUMBERS`."""
        image = self.orbit.image
        if name == "period_time":
            return image.time
        return orbit_events.smallest_impact_speed(self.orbit.map.model, image.events)


@dataclass(frozen=True)
class Slopes:
    """Derivatives along the arc: of the fraction of the parameter's range, state, numbers and quantities."""

    q: float
    state: np.ndarray
    numbers: dict[str, float] = field(default_factory=dict)
    quantities: dict[str, Any] = field(default_factory=dict)


def neighbour_motions(family: Family, point: Point, follow: Callable[[Orbit], tuple]) -> list[Motion]:
    """The motions next to a point that have its events: two, one or none."""
    if not np.any(point.tangent):
        return []
    for h in STEPS:
        found = [_neighbour_motion(family, point, each, follow) for each in (-h, h)]
        if any(found):
            return [motion for motion in found if motion]
    return []


def _neighbour_motion(family: Family, point: Point, h: float, follow: Callable) -> Motion | None:
    try:
        section, state = family.placed(point.z + h * point.tangent, point)
    except InputError:  # a little beyond its range a parameter may have no meaning
        return None
    orbit = Orbit(0, section, state, section.image(state, False), 0.0, 0)
    image = orbit.image
    if image.status or not same_events(image.events, point.orbit.image.events):
        return None
    rows, sharp, status = follow(orbit)
    return None if status else Motion(h, orbit, rows, sharp)


def slopes(own: Motion, sides: Sequence[Motion], point: Point, sense: float, names: Sequence[str]) -> Slopes:
    """Derivatives at a point whose motion is `own`; `sense` -1: the arc runs the other way."""
    if not sides:
        return Slopes(np.nan, np.full(len(own.orbit.state), np.nan))
    section, motions = own.orbit.map, sorted([own, *sides], key=attrgetter("h"))
    h = motions[-1].h - motions[0].h
    along = section.differ(motions[-1].state, motions[0].state) / h
    length = np.hypot(np.linalg.norm(along) / point.unit, point.tangent[-1])  # of the tangent on this section
    state, span = np.zeros(len(own.state)), sense * length * h
    state[section.free] = along * section.scale[section.free] * sense / length
    numbers = {n: float(_slope(span, [np.array(motion.number(n)) for motion in motions])) for n in NUMBERS}
    tables = [motion.quantities(names) for motion in motions]
    quantities = {
        name: (dims, _slope(span, [table[name][1] for table in tables]), attributes)
        for name, (dims, values, attributes) in tables[0].items()
        if values.dtype.kind == "f"
    }
    return Slopes(point.tangent[-1] / length, state, numbers, quantities)


def _slope(span: float, values: Sequence[np.ndarray]) -> np.ndarray:
    """The derivative by values over a span of the arc; NaN where they jump."""
    change = values[-1] - values[0]
    slope = change / span
    if len(values) < 3:
        return slope
    bend = np.abs(values[0] - 2 * values[1] + values[2])
    jumps = (bend > np.abs(change) / 2) & (bend > JUMP * np.max(np.abs(values), axis=0))
    return np.where(jumps, np.nan, slope)
