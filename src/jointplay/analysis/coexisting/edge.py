"""The edge state between two motions: what starts on the boundary of their basins stay on or come to.

A start that leads to one motion and a near one that does not enclose the boundary. Both are followed turn
by turn, and where they have moved apart, halved in again along the line between them; so the pair stays on
the boundary and comes to what attracts there (J. D. Skufca, J. A. Yorke and B. Eckhardt, Phys. Rev. Lett. 96
(2006) 174101). Once the pair comes back to where it was a few turns before, Newton's method on the section
map makes of it a periodic orbit with its multipliers. Validity: an edge state that is not periodic is not
refined; a boundary that is no thin surface, such as one of riddled basins, has none.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from jointplay.analysis.coexisting.lasting import Motions
from jointplay.analysis.orbits.floquet import multipliers
from jointplay.analysis.orbits.orbit_search import Search, shortest, solved
from jointplay.analysis.orbits.section_map import SectionMap
from jointplay.analysis.orbits.shooting import Orbit

CLOSE, APART = 1e-9, 1e-5  # distances, in units of the scales, to which and from which a pair is halved in
PARTS = 8  # into which the line between a pair is cut at once
LONGEST = 12  # period of an edge state, turns
NEAR = 3e-2  # distance of two passages from which Newton's method starts
ITERATIONS = 40


@dataclass
class Boundary:
    """A pair of states at the section on either side of the boundary of a motion's basin."""

    motions: Motions
    own: int
    section: SectionMap
    inside: np.ndarray
    outside: np.ndarray

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

    def _placed(self, state: np.ndarray) -> np.ndarray:
        """A state at the section, angles as those of motions are."""
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
        if (orbit := _refined(boundary.section, seen)) is not None:
            return orbit
    return None


def _refined(section: SectionMap, seen: list[np.ndarray]) -> Orbit | None:
    """A periodic orbit near the last states, if they come back and it leaves in one direction alone."""
    for period in range(1, min(LONGEST, len(seen) - 1) + 1):
        if np.max(np.abs(section.differ(seen[-1], seen[-1 - period]))) > NEAR:
            continue
        settings = Search()
        orbit = solved(replace(section, turns=period), seen[-1], settings)
        if orbit.status:
            continue
        orbit = shortest(orbit, settings)
        if np.sum(np.abs(multipliers(orbit.image.derivative)) > 1) == 1:
            return orbit
    return None
