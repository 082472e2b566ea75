"""A region of initial states: coordinates with their lowest and highest values, and starts drawn in it.

Coordinates are those of `analysis.states.start_plane`, as many as are wanted; all others keep the values of
the start that the region goes through. Starts are independent and uniform over the region, so that the number
that reaches an attractor is binomial. Those of a value depend on the seed and on that value alone: a value
more in a sweep changes no other.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, Any

import numpy as np

from jointplay.analysis.states.start_plane import coordinate_problems
from jointplay.analysis.vary import axes
from jointplay.display.errors import Problem
from jointplay.solver.mechanism.base import Written, accepts
from jointplay.solver.mechanism.records import Mechanism, TestSystem

_WORDS = "a table of coordinates, each with its lowest and highest value,"
Ends = Annotated[tuple[Written, Written], accepts("a lowest and a highest value")]
Region = Annotated[dict[str, Ends], accepts(_WORDS)]


def one_parameter(mechanism: Mechanism | TestSystem, over: Any) -> Iterator[Problem]:
    """Yield the problems of the varied parameters: one is accepted."""
    varied = axes(mechanism, over)
    if len(varied) != 1:
        yield Problem("over", [axis.key for axis in varied], "one parameter is accepted")


def region_fits(varied: Any, region: Region, joint: str | None, initial: Any, model: Any = None):
    """Yield the problems of a region of starts for the varied mechanism."""
    yield from coordinate_rules(varied, region, joint, initial, model)


def coordinate_rules(mechanism: Any, region: Region, joint: str | None, initial: Any, model: Any = None):
    """Yield the problems of a region."""
    if not region:
        yield Problem("region", region, f"{_WORDS} is accepted")
    yield from coordinate_problems("region", mechanism, region, joint, initial, model)
    for name, (low, high) in region.items():
        if not low < high:
            yield Problem(f"region.{name}", [low, high], "a lowest and a highest value above it are accepted")


def drawn(region: Mapping[str, Sequence[float]], count: int, seed: int, value: float) -> np.ndarray:
    """Coordinates of starts at a value of the varied parameter, shape (count, coordinates)."""
    bits = np.array([value], dtype=float).view(np.uint32)
    low, high = np.array(list(region.values()), dtype=float).T
    return np.random.default_rng([seed, *bits.tolist()]).uniform(low, high, (count, len(low)))
