"""The variables of basins: labels over the plane, shares and points of attractors, the boundary's pairs."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from jointplay.analysis.evaluate import flags
from jointplay.analysis.quantities import STATUS
from jointplay.analysis.states import basin_uncertainty as unsure
from jointplay.analysis.states import start_plane as planes
from jointplay.analysis.states.matching import Attractors
from jointplay.codegen import cache


def plane_variables(dims, labels, status, count: int) -> dict[str, Any]:
    """Labels and statuses over the plane."""
    names = " ".join(["none", *(f"attractor_{i}" for i in range(1, count + 1))])
    flag = {"units": "1", "flag_values": np.arange(count + 1, dtype=np.int32), "flag_meanings": names}
    return {
        "attractor": (dims, labels, {"long_name": "attractor that is reached"} | flag),
        "node_status": (dims, status, {"long_name": "how the node's run ended"} | flags(STATUS)),
    }


def shares(found: Attractors, nodes: int, started: int) -> dict[str, Any]:
    """Shares of the nodes from which a motion started."""
    count = np.bincount(found.labels[:nodes], minlength=len(found.periods) + 1)[1:]
    share = count / started if started else np.full(len(count), np.nan)
    low, high = unsure.wilson(count, started)
    error = np.sqrt(share * (1 - share) / started) if started else np.full(len(count), np.nan)
    rows = {
        "period": (found.periods.astype(np.int32), "period in turns; 0: none found"),
        "count": (count, "nodes that reach the attractor"),
        "fraction": (share, "fraction of the starts that reach the attractor"),
        "fraction_standard_error": (error, "binomial standard error of the fraction"),
        "fraction_low": (low, "lower end of the 95 % interval of the fraction"),
        "fraction_high": (high, "upper end of the 95 % interval of the fraction"),
    }
    told = {
        name: ("number", values, {"units": "1", "long_name": text}) for name, (values, text) in rows.items()
    }
    none = (started - count.sum()) / started if started else math.nan
    told["fraction_none"] = (
        (),
        float(none),
        {"units": "1", "long_name": "fraction of the starts without an attractor"},
    )
    return told


def points(found: Attractors, states: list[np.ndarray], starts) -> dict[str, Any]:
    """Section points of one end of each attractor, as states and in the plane; NaN past the last."""
    shown = [states[i] for i in found.shown_by]
    longest = max(map(len, shown), default=0)
    whole = np.full((len(shown), longest, len(starts.model.state)), np.nan)
    seen = np.full((len(shown), longest, 2), np.nan)
    for i, each in enumerate(shown):
        whole[i, : len(each)], seen[i, : len(each)] = each, starts.seen(each)
    return {
        "section_state": (
            ("number", "point", "state"),
            whole,
            {"units": "1", "long_name": "states at the section (SI)"},
        ),
        "section_plane": (
            ("number", "point", "axis"),
            seen,
            {"units": "1", "long_name": "section points, in the units of the plane's axes"},
        ),
    }


def boundary(rows: list[unsure.Row]) -> dict[str, Any]:
    """Pairs, the exponent, the dimension."""
    slope, error = unsure.exponent(rows)
    told = {
        "pair_distance": ([row.distance for row in rows], "distance of a pair, in lengths of the axes"),
        "pair_count": ([row.pairs for row in rows], "pairs"),
        "uncertain_fraction": ([row.fraction for row in rows], "fraction of pairs with different ends"),
        "uncertain_fraction_standard_error": (
            [row.error for row in rows],
            "standard error of that fraction",
        ),
    }
    found = {
        name: ("pair", np.array(values), {"units": "1", "long_name": text})
        for name, (values, text) in told.items()
    }
    kinds = np.array([row.kind for row in rows], dtype=np.int8)
    found["pair_kind"] = ("pair", kinds, {"long_name": "where the pairs are"} | flags(unsure.PAIRS))
    numbers = {
        "uncertainty_exponent": (slope, "uncertainty exponent of the basins' boundary"),
        "uncertainty_exponent_standard_error": (error, "standard error of the uncertainty exponent"),
        "boundary_dimension": (unsure.DIRECTIONS - slope, "dimension of the boundary in the plane"),
    }
    return found | {name: ((), v, {"units": "1", "long_name": text}) for name, (v, text) in numbers.items()}


def coordinates(axes, found: Attractors, starts) -> dict[str, Any]:
    """Axes of the plane, numbers of the attractors, names of states and axes."""
    coords = planes.axis_coordinates(starts, axes)
    states = np.array(cache.structure_module(starts.model.structure).STATE[1:], dtype=str)
    number = np.arange(1, len(found.periods) + 1)
    return coords | {
        "number": ("number", number, {"units": "1", "long_name": "number of the attractor"}),
        "state": ("state", states, {"long_name": "state"}),
        "axis": ("axis", np.array(list(axes), dtype=str), {"long_name": "axis of the plane"}),
    }
