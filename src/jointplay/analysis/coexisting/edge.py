"""The edge state between two motions: the motion that attracts on the boundary of their basins.

A start that leads to one motion and a near one that does not enclose the boundary. Both are followed turn
by turn, and where they have moved apart, halved in again along the line between them; so the pair stays on
the boundary and comes to what attracts there (J. D. Skufca, J. A. Yorke and B. Eckhardt, Phys. Rev. Lett. 96
(2006) 174101). Once the pair comes back to where it was a few turns before, Newton's method on the section
map makes of it a periodic orbit with its multipliers. What nothing forces stays in an equilibrium, or in a
cycle of a period of its own; that is sought on the plane through the pair that it crosses fastest. Validity:
an edge state that is not periodic is not refined; a boundary that is no thin surface, such as one of riddled
basins, has none.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from jointplay.analysis.coexisting.lasting import Motions
from jointplay.analysis.orbits.floquet import multipliers
from jointplay.analysis.orbits.orbit_search import Search, shortest, solved
from jointplay.analysis.orbits.section_map import AT_REST, SectionMap, section_map
from jointplay.analysis.orbits.shooting import Orbit
from jointplay.analysis.starts import state_names
from jointplay.solver.mechanism.model import Model
from jointplay.solver.mechanism.records import Plane

CLOSE, APART = 1e-9, 1e-5  # distances, in units of the scales, to which and from which a pair is halved in
PARTS = 8  # into which the line between a pair is cut at once
LONGEST = 12  # period of an edge state, turns
NEAR = 3e-2  # distance of two passages from which Newton's method starts
ITERATIONS = 40
MOMENT = 1e-3  # phase of a nominal period, rad, in which one sees how states change


@dataclass
class Boundary:
    """A pair of states at the section on either side of the boundary of a motion's basin.

    `cut` makes the model for sections by a state, where nothing forces the motion; else it is None.
    """

    motions: Motions
    own: int
    section: SectionMap
    inside: np.ndarray
    outside: np.ndarray
    cut: Callable[[str], Model] | None = None

    @property
    def width(self) -> float:
        """Largest difference of the two states in a coordinate, in units of its scale."""
        return float(np.max(np.abs(self.section.differ(self.outside, self.inside))))

    def close(self) -> None:
        """Halve the pair in until it is close, or as close as rounding allows."""
        shares = np.arange(1, PARTS) / PARTS
        for _ in range(ITERATIONS):
            if self.width <= CLOSE:
                return
            line = self.inside + shares[:, None] * (self.outside - self.inside)
            own = self.motions.sort([replace(self.motions.base, state=state) for state in line]) == self.own
            first = int(np.argmin(own)) if not own.all() else len(own)
            whole = np.concatenate([self.inside[None], line, self.outside[None]])
            self.inside, self.outside = whole[first], whole[first + 1]

    def turn(self) -> bool:
        """Follow the pair for a turn; false where that fails."""
        ends = [self.section.image(state, False) for state in (self.inside, self.outside)]
        if any(end.status for end in ends):
            return False
        self.inside, self.outside = (self._placed(end.state) for end in ends)
        if self.width > APART:
            self.close()
        return True

    def plane(self, state: np.ndarray) -> SectionMap | None:
        """The section through a state where one coordinate changes fastest; None at rest, or if forced."""
        image = self.section.moved(state, MOMENT)[1] if self.cut else None
        if image is None or image.status:
            return None
        change = self.section.differ(image.state, state)
        fastest = int(np.argmax(np.abs(change)))
        if abs(change[fastest]) <= AT_REST * MOMENT:
            return None
        name, way = state_names(self.section.model)[fastest], "up" if change[fastest] > 0 else "down"
        plane = Plane(quantity=name, value=float(state[fastest]), direction=way)
        return section_map(self.cut(name), plane, 1, self.section.rtol, self.section.max_steps)

    def _placed(self, state: np.ndarray) -> np.ndarray:
        """A state at the section, angles as in the motions."""
        state = state.copy()
        for i in np.flatnonzero(self.motions.base.fold):
            state[i] = (state[i] + np.pi) % (2 * np.pi) - np.pi
        if self.section.place is not None:
            state[self.section.place] = self.motions.base.crank_angle
        return state


def edge_state(boundary: Boundary, turns: int) -> Orbit | None:
    """The periodic orbit to which a boundary leads in some turns; None where it leads to none.

    Only orbits are taken that leave the boundary in one direction alone: with one multiplier beyond 1.
    """
    boundary.close()
    seen = [boundary.inside]
    for _ in range(turns):
        if not boundary.turn():
            return None
        seen.append(boundary.inside)
        if (orbit := _refined(boundary, seen)) is not None:
            return orbit
    return None


def _refined(boundary: Boundary, seen: list[np.ndarray]) -> Orbit | None:
    """A periodic orbit near the last states, if they come back and it leaves in one direction alone."""
    section, last = boundary.section, seen[-1]
    for period in range(1, min(LONGEST, len(seen) - 1) + 1):
        if np.max(np.abs(section.differ(last, seen[-1 - period]))) <= NEAR:
            orbit = _solved(section, last, period)
            if orbit is not None and boundary.plane(orbit.state) is None:
                return orbit
    plane, state = boundary.plane(last), last
    for period in range(1, LONGEST + 1) if plane else ():
        image = plane.image(state, False)
        if image.status:
            break
        state = image.state
        if np.max(np.abs(plane.differ(state, last))) <= NEAR:
            return _solved(plane, state, period)
    return None


def _solved(section: SectionMap, state: np.ndarray, period: int) -> Orbit | None:
    """The periodic orbit that Newton's method comes to, if it leaves in one direction alone."""
    orbit = solved(replace(section, turns=period), state, settings := Search())
    if orbit.status:
        return None
    orbit = shortest(orbit, settings)
    return orbit if np.sum(np.abs(multipliers(orbit.image.derivative)) > 1) == 1 else None
