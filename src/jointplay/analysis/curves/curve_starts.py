"""Starts of curves from the special points of a continuation's dataset."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from pydantic import PlainValidator

from jointplay.analysis.curves.corners import Begin
from jointplay.analysis.curves.tracing import FROM
from jointplay.analysis.orbits.branch_points import KINDS
from jointplay.analysis.orbits.orbit_events import changed_event
from jointplay.analysis.orbits.orbit_search import Search, search
from jointplay.analysis.orbits.section_map import SectionMap
from jointplay.analysis.orbits.shooting import Orbit
from jointplay.display.errors import Problem, refuse
from jointplay.solver.mechanism.base import accepts

if TYPE_CHECKING:
    import xarray as xr

OTHER_SIDE = 1e-2  # of the branch: how far from a grazing an orbit on its other side may be
ACCEPTED = "a result of continuation"


def _branches(given: Any) -> Any:
    import xarray as xr

    if given is not None and (not isinstance(given, xr.Dataset) or given.attrs.get("kind") != "continuation"):
        raise refuse(getattr(given, "attrs", {}).get("kind", given), f"{ACCEPTED} is accepted")
    return given


Branches = Annotated[Any, PlainValidator(_branches), accepts(ACCEPTED)]


def labels_fit(
    plane: dict[str, Any], branches: xr.Dataset | None, labels: Sequence[int] | None, of: Sequence[str]
) -> Iterator[Problem]:
    """Yield the problems of labels of special points, and of the parameter that their branches are over."""
    if branches is None:
        if labels is not None:
            yield Problem(
                "labels", list(labels), "accepted only with branches, whose special points it numbers"
            )
        return
    if (key := key_of(branches)) not in plane:
        yield Problem("plane", list(plane), f"{key}, the parameter of the branches, has to be one of the two")
    known = [FROM.get(KINDS[kind], KINDS[kind]) for kind in branches["special_kind"].values]
    wrong = [i for i, label in enumerate(labels or ()) if label >= len(known)]
    for i in wrong:
        told = f"the number of a special point, 0 to {len(known) - 1}, is accepted"
        yield Problem(f"labels[{i}]", labels[i], told if known else "the branches have no special points")
    chosen = known if labels is None else [known[label] for label in labels if label < len(known)]
    if not wrong and not any(kind in of for kind in chosen):
        told = f"a special point is needed there from which a curve of {', '.join(of)} can start"
        yield Problem("branches" if labels is None else "labels", list(dict.fromkeys(chosen)), told)


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
        event = int(special["special_event_joint"]), int(special["special_event_kind"])
        orbits = (
            (search(at(value, state, turns), Search(0, tolerance)), value)
            for value, state, turns in _candidates(branches, special, kind)
        )
        if start := _fewer_events((each for each in orbits if not each[0].status), event):
            found.append((Begin(FROM.get(kind, kind), start[0], np.zeros(2), event), start[1]))
    return sorted(found, key=lambda each: each[0].kind == "grazing")


def _fewer_events(
    orbits: Iterator[tuple[Orbit, float]], event: tuple[int, int]
) -> tuple[Orbit, float] | None:
    """The one with fewer events of the first two orbits that differ by an event; without one, the first."""
    known: list[tuple[Orbit, float]] = []
    for orbit, value in orbits:
        for other in known:
            if changed_event(orbit.image.events, other[0].image.events) == event:
                return min((orbit, value), other, key=lambda each: len(each[0].image.events))
        known.append((orbit, value))
    return known[0] if known else None


def _candidates(
    branches: xr.Dataset, special: xr.Dataset, kind: str
) -> Iterator[tuple[float, np.ndarray, int]]:
    """Parameter, state and turns of a special point; at a grazing, of points on both its sides."""
    b, p = int(special["special_branch"]), int(special["special_point"])
    values = branches[branches.attrs["parameter"]].values[b, : int(branches["n_points"][b])]
    turns = int(branches["period"].values[b, p])
    if kind != "grazing":
        yield float(special["special_parameter"]), special["special_state"].values, turns
        return
    away = np.abs(values - values[p])
    for i in sorted(range(max(p - 2, 0), min(p + 3, len(values))), key=lambda i: (away[i], abs(i - p))):
        if away[i] <= OTHER_SIDE * np.ptp(values):
            yield float(values[i]), branches["orbit_state"].values[b, i], turns
