"""The combinations of values that a `[vary]` table asks for, and the coordinates that they make."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np

from jointplay.analysis.vary import Axis, checked_axes
from jointplay.mechanism.records import Mechanism, TestSystem
from jointplay.study.vary import together, values

CASE = "case"  # the dimension of combinations that make no grid


@dataclass(frozen=True)
class Points:
    """The combinations of values that a study asks for.

    Parameters
    ----------
    axes : tuple of Axis
        The parameters; their values rise along a grid, and are in the order of the cases else.
    together : bool
        Whether the values go together one by one, along the dimension ``case``.
    """

    axes: tuple[Axis, ...]
    together: bool = False

    @property
    def dims(self) -> tuple[str, ...]:
        """Dimensions of the whole."""
        return (CASE,) if self.together else tuple(axis.name for axis in self.axes)

    @property
    def shape(self) -> tuple[int, ...]:
        """Numbers along them."""
        sizes = tuple(len(axis.values) for axis in self.axes)
        return sizes[:1] if self.together else sizes

    @property
    def changes(self) -> list[dict[str, float]]:
        """What is changed at each point, the last dimension fastest."""
        combined = zip if self.together else product
        keys = [axis.key for axis in self.axes]
        return [dict(zip(keys, each, strict=True)) for each in combined(*(a.values for a in self.axes))]

    @property
    def coordinates(self) -> dict[str, Any]:
        """Coordinates of a dataset."""
        found: dict[str, Any] = {
            axis.name: (CASE if self.together else axis.name, np.array(axis.values), axis.attributes)
            for axis in self.axes
        }
        if self.together:
            found[CASE] = (CASE, np.arange(self.shape[0]), {"units": "1", "long_name": "number of the case"})
        return found


def points(mechanism: Mechanism | TestSystem, vary: Mapping[str, Any]) -> Points:
    """Every combination that a checked `[vary]` table asks for."""
    given = values(vary)
    if not together(vary):
        return Points(checked_axes(mechanism, given))
    rising = checked_axes(mechanism, given)
    ordered = (replace(axis, values=tuple(map(float, given[axis.key]))) for axis in rising)
    return Points(tuple(ordered), together=True)
