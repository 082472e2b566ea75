"""The condition of a curve in two parameters, as the pseudo-arclength method takes it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Protocol

import numpy as np

if TYPE_CHECKING:
    from jointplay.analysis.orbits.arclength import Family, Point, Trial


class Condition(Protocol):
    """What holds of the orbits of a curve, beside that they close.

    `sided`: whether it has a meaning on one side of the curve only.
    """

    sided: bool

    def value(self, trial: Trial, like: Point) -> float:
        """The number that is zero on the curve; NaN where it has no meaning. `like`: a point nearby."""

    def gradient(self, family: Family, trial: Trial, like: Point) -> np.ndarray:
        """Its derivatives in the coordinates x/c and the fractions of the ranges; `trial` has directions."""

    def tests(self, one: Point) -> Mapping[str, Callable[[Point], float]]:
        """Functions that change sign where the curve meets another one, beyond a point."""

    def genuine(self, kind: str, point: Point) -> bool:
        """Whether a zero of such a function is what its name says."""
