"""Starts of curves from the special points of a continuation's dataset."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from typing import Annotated, Any

import numpy as np
import xarray as xr
from pydantic import PlainValidator

from jointplay.analysis.curves.tracing import FROM, Begin
from jointplay.analysis.orbits.branch_points import KINDS
from jointplay.analysis.orbits.orbit_search import Search, search
from jointplay.analysis.orbits.section_map import SectionMap
from jointplay.analysis.orbits.shooting import Orbit
from jointplay.errors import Problem, refuse
from jointplay.mechanism.base import accepts

BESIDE = 1e-6  # of the range: points of a branch on both sides of a grazing
ACCEPTED = "a result of continuation"


def _branches(given: Any) -> Any:
    if given is not None and (not isinstance(given, xr.Dataset) or given.attrs.get("kind") != "continuation"):
        raise refuse(getattr(given, "attrs", {}).get("kind", given), f"{ACCEPTED} is accepted")
    return given


Branches = Annotated[Any, PlainValidator(_branches), accepts(ACCEPTED)]


def labels_fit(
    plane: dict[str, Any], branches: xr.Dataset | None, labels: Sequence[int] | None
) -> Iterator[Problem]:
    """Yield the problems of labels of special points, and of the parameter that their branches are over."""
    if branches is None:
        if labels is not None:
            yield Problem("labels", list(labels), "accepted only with branches, of whose special points")
        return
    if (key := key_of(branches)) not in plane:
        yield Problem("plane", list(plane), f"{key}, the parameter of the branches, has to be one of the two")
    most = branches.sizes["special"] - 1
    for i, label in enumerate(labels or ()):
        if label > most:
            yield Problem(f"labels[{i}]", label, f"the number of a special point, 0 to {most}, is accepted")


def key_of(branches: xr.Dataset) -> str:
    """The key of the parameter that branches are over."""
    return str(branches[branches.attrs["parameter"]].attrs["key"])


def starts_in(
    branches: xr.Dataset,
    labels: Sequence[int] | None,
    kinds: Collection[str],
    at: Callable[[float, np.ndarray, int], SectionMap],
    tolerance: float,
) -> list[tuple[Begin, float]]:
    """Starts of curves of some kinds, without fractions of ranges, and the branches' parameter at each.

    `at`: section map of a value of that parameter, a state and a number of turns.
    """
    found = []
    for label in range(branches.sizes["special"]) if labels is None else labels:
        special = branches.isel(special=label)
        kind = KINDS[int(special["special_kind"])]
        if FROM.get(kind, kind) not in kinds:
            continue
        orbits = [
            (search(at(value, state, turns), Search(0, tolerance)), value)
            for value, state, turns in _candidates(branches, special, kind)
        ]
        orbit, value = min(orbits, key=lambda each: _events(each[0]))
        if not orbit.status:
            event = int(special["special_event_joint"]), int(special["special_event_kind"])
            found.append((Begin(FROM.get(kind, kind), orbit, np.zeros(2), event), value))
    return sorted(found, key=lambda each: each[0].kind == "grazing")


def _events(orbit: Orbit) -> float:
    return np.inf if orbit.status else len(orbit.image.events)


def _candidates(
    branches: xr.Dataset, special: xr.Dataset, kind: str
) -> Iterator[tuple[float, np.ndarray, int]]:
    """Parameter, state and turns of a special point; at a grazing, of the points on both its sides."""
    b, p = int(special["special_branch"]), int(special["special_point"])
    values = branches[branches.attrs["parameter"]].values[b, : int(branches["n_points"][b])]
    turns, span = int(branches["period"].values[b, p]), np.ptp(values)
    if kind != "grazing":
        yield float(special["special_parameter"]), special["special_state"].values, turns
        return
    for i in (p - 1, p, p + 1):
        if 0 <= i < len(values) and abs(values[i] - values[p]) <= BESIDE * span:
            yield float(values[i]), branches["orbit_state"].values[b, i], turns
