"""The half map of a symmetric periodic orbit: half its turns, and the reflection that brings it back.

Where x(t + T/2) = S x(t) with signs S, the orbit is a fixed point of Q = S phi_{T/2}, and its section map is
Q^2. Symmetry is lost where Q has a multiplier -1; that of the section map is then +1, and its fixed points
branch, so that only Q makes a regular problem of it. Validity: an odd number of periods of a forcing, and
equations that S leaves as they are half a period later; both are seen from the orbit, which is Q's fixed
point only then.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace

import numpy as np

from jointplay.analysis.orbits.section_map import Image, SectionMap
from jointplay.analysis.orbits.shooting import Orbit, newton
from jointplay.solver.mechanism.directions import Directions

NEAR = 1e-2  # of the scales: beside a loss of symmetry, an orbit is known to a root of its residual
PLACE = 2  # of an event, in its row


@dataclass(frozen=True)
class HalfMap(SectionMap):
    """Half the turns of a section map, and a reflection.

    Parameters
    ----------
    signs : ndarray of float
        +1 or -1 for each state.
    """

    signs: np.ndarray | None = None

    def image(
        self,
        state: np.ndarray,
        derivative: bool = True,
        turns: int | None = None,
        directions: Directions | None = None,
    ) -> Image:
        """Image of a state under the half map, with the events of the whole orbit."""
        image = self._followed(state, math.pi, self.turns // 2, derivative, directions)
        if image.status:
            return image
        signs = self.signs[self.free, None]
        P = signs * image.derivative if derivative else None
        along = signs * image.along if directions is not None else None
        places = image.events[:, PLACE] / 2
        events = np.concatenate([image.events, image.events])
        events[:, PLACE] = np.concatenate([places, places + 0.5])
        reached = self._wrapped(self.signs * image.state, state)
        return replace(image, state=reached, derivative=P, along=along, events=events)

    def whole(self, orbit: Orbit) -> Orbit:
        """The orbit of the section map that a fixed point of this one is."""
        values = {each.name: getattr(self, each.name) for each in fields(SectionMap)}
        section = SectionMap(**values)
        return replace(orbit, map=section, image=section.image(orbit.state))


def halved(orbit: Orbit, tolerance: float) -> Orbit | None:
    """A symmetric orbit as a fixed point of its half map; None if it is not symmetric."""
    section = orbit.map
    if section.place is not None or section.turns % 2 == 0:
        return None
    half = section._followed(orbit.state, math.pi, section.turns // 2, False)
    if half.status:
        return None
    signs = np.where(np.abs(half.state + orbit.state) < np.abs(half.state - orbit.state), -1.0, 1.0)
    given = {each.name: getattr(section, each.name) for each in fields(SectionMap)}
    found = newton(HalfMap(**given, signs=signs), orbit.state, tolerance)
    same = np.max(np.abs(section.differ(found.state, orbit.state))) < NEAR if not found.status else False
    return found if same else None
