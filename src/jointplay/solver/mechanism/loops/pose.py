"""Where the links of a mechanism are at one moment, and where a place on one of them is."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from jointplay.solver.mechanism.base import GROUND
from jointplay.solver.mechanism.parts.joints import Pin
from jointplay.solver.mechanism.records import Mechanism
from jointplay.solver.mechanism.start import start


class Pose(NamedTuple):
    """Angles of the links, rad, and their origins, shape (2,), m, by name."""

    angles: Mapping[str, float]
    origins: Mapping[str, np.ndarray]

    def along(self, link: str, at: float) -> np.ndarray:
        """The point of a link's line at a distance from its origin, m."""
        angle = self.angles[link]
        return self.origins[link] + at * np.array([np.cos(angle), np.sin(angle)])

    def point(self, pin: Pin) -> np.ndarray:
        """The point of a pin, m."""
        return np.array(pin.point) if pin.link == GROUND else self.along(pin.link, pin.at)

    def direction(self, pin: Pin) -> float:
        """The direction of a pin's line, rad from x."""
        return pin.direction + (0.0 if pin.link == GROUND else self.angles[pin.link])


def start_pose(mechanism: Mechanism, initial: Any = None) -> Pose:
    """Give where the links are at the start; keywords and errors as of `start`."""
    state = start(mechanism, initial)
    return Pose(state.angles, {name: rows[0] for name, rows in state.points.items()})
