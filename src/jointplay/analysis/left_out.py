"""What an analysis does where nobody says: how long it lasts, and what it goes over, as the mechanism has it.

A mechanism alone then runs, from a file as from Python. Ranges are half and twice the present value; planes
and regions of starts are the whole disc of the clearance, or most of it. Where a mechanism has none of these,
as a system of equations, what is needed stays needed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from jointplay.display.errors import InputError
from jointplay.solver.mechanism.base import is_number
from jointplay.solver.mechanism.parameters import Parameter
from jointplay.solver.mechanism.records import Mechanism

REACH = 2.0  # of a parameter, to either side
INSIDE = 0.7  # of the clearance: starts that are not yet in contact
ACROSS = 13  # starts along each side of a plane
DISC = ("eccentricity_ratio_x", "eccentricity_ratio_y")
LENGTHS = ("turns", "duration", "windows", "at")


@dataclass(frozen=True)
class LeftOut:
    """Keywords of an analysis that follow where they are left out.

    Parameters
    ----------
    names : tuple of str
        Which.
    of : callable
        Gives them for the keywords that are given, as far as they follow.
    """

    names: tuple[str, ...]
    of: Callable[[Mapping[str, Any]], dict[str, Any]]

    def completed(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """Keywords, with those that are left out."""
        if all(given.get(name) is not None for name in self.names):
            return dict(given)
        return {**given, **{key: x for key, x in self.of(given).items() if given.get(key) is None}}


NONE = LeftOut((), lambda given: {})


def lasting(transient: float, turns: int) -> LeftOut:
    """So many turns after a transient, where no length is given."""
    own = {"transient": transient, "turns": turns}
    return LeftOut(
        ("turns",), lambda given: {} if any(given.get(key) is not None for key in LENGTHS) else own
    )


def over(number: int) -> LeftOut:
    """So many clearances about the present one."""

    def found(given: Mapping[str, Any]) -> dict[str, Any]:
        pair = _around(given.get("mechanism"), "clearance")
        return {"over": {"clearance": np.geomspace(*pair, number).tolist()}} if pair else {}

    return LeftOut(("over",), found)


def both(*several: LeftOut) -> LeftOut:
    """All of several."""

    def found(given: Mapping[str, Any]) -> dict[str, Any]:
        return {key: value for each in several for key, value in each.of(given).items()}

    return LeftOut(sum((each.names for each in several), ()), found)


def _range(given: Mapping[str, Any]) -> dict[str, Any]:
    pair = _around(given.get("mechanism"), given.get("parameter", "clearance"))
    return {"range": pair} if pair else {}


def _two_ranges(given: Mapping[str, Any]) -> dict[str, Any]:
    pairs = {key: _around(given.get("mechanism"), key) for key in ("clearance", "gear_ratio", "speed")}
    told = {key: pair for key, pair in pairs.items() if pair}
    return {"plane": told} if len(told) == 2 else {}


def _disc(key: str, value: Any) -> LeftOut:
    def found(given: Mapping[str, Any]) -> dict[str, Any]:
        mechanism = given.get("mechanism")
        loose = isinstance(mechanism, Mechanism) and mechanism.clearance_joints
        return {key: dict.fromkeys(DISC, value)} if loose else {}

    return LeftOut((key,), found)


RANGE = LeftOut(("range",), _range)
TWO_RANGES = LeftOut(("plane",), _two_ranges)
WHOLE_DISC = _disc("plane", {"start": -1.0, "stop": 1.0, "num": ACROSS})
INNER_DISC = _disc("region", (-INSIDE, INSIDE))


def _around(mechanism: Any, key: Any) -> tuple[float, float] | None:
    """Half and twice the present value of a parameter; None where it has none above 0."""
    try:
        value = Parameter.named(mechanism, key).value if isinstance(mechanism, Mechanism) else None
    except InputError:
        return None
    return (value / REACH, value * REACH) if is_number(value) and value > 0 else None
