"""Variables of basins of attraction: labels of nodes, fractions and points of attractors, pairs of nodes."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from jointplay.analysis.labels import coded, labelled
from jointplay.analysis.quantities import STATUS
from jointplay.analysis.states.basin_uncertainty import DIRECTIONS, PAIRS, Pairs, uncertainty_exponent, wilson
from jointplay.analysis.states.matching import Attractors
from jointplay.analysis.states.start_plane import Starts

NODE_STATUS = (*STATUS, "saddle")  # the run ended well, on a periodic orbit that attracts nothing
SADDLE = len(STATUS)


def plane_variables(dims, labels: np.ndarray, status: np.ndarray, count: int) -> dict[str, Any]:
    """Labels and statuses of the nodes of a plane with so many attractors."""
    names = " ".join(["none", *(f"attractor_{i}" for i in range(1, count + 1))])
    flag = {"units": "1", "flag_values": np.arange(count + 1, dtype=np.int32), "flag_meanings": names}
    return {
        "attractor": (dims, labels, {"long_name": "attractor that is reached"} | flag),
        "node_status": coded(dims, status, "how the node's run ended", NODE_STATUS),
    }


def fractions(attractors: Attractors, nodes: int, started: int) -> dict[str, Any]:
    """Periods of attractors, and fractions of the starts that reach them: of the nodes that have a start."""
    count = np.bincount(attractors.labels[:nodes], minlength=len(attractors.periods) + 1)[1:]
    fraction = count / started if started else np.full(len(count), np.nan)
    error = np.sqrt(fraction * (1 - fraction) / started) if started else fraction
    low, high = wilson(count, started)
    rows = {
        "period": (attractors.periods.astype(np.int32), "1", "period in turns; 0: none found"),
        "count": (count, "1", "nodes that reach the attractor"),
        "fraction": (fraction, "1", "fraction of the starts that reach the attractor"),
        "fraction_standard_error": (error, "1", "binomial standard error of the fraction"),
        "fraction_low": (low, "1", "lower end of the 95 % interval of the fraction"),
        "fraction_high": (high, "1", "upper end of the 95 % interval of the fraction"),
    }
    none = float((started - count.sum()) / started) if started else math.nan
    without = {"fraction_none": (none, "1", "fraction of the starts without an attractor")}
    return labelled(rows, "number") | labelled(without)


def section_points(attractors: Attractors, states: list[np.ndarray], starts: Starts) -> dict[str, Any]:
    """Section points of one end of each attractor, as states and in the plane; NaN past the last."""
    shown = [states[i] for i in attractors.shown_by]
    longest = max(map(len, shown), default=0)
    points = np.full((len(shown), longest, len(starts.model.state)), np.nan)
    in_plane = np.full((len(shown), longest, 2), np.nan)
    for i, end in enumerate(shown):
        points[i, : len(end)], in_plane[i, : len(end)] = end, starts.projected(end)
    plane = {"section_plane": (in_plane, "1", "section points, in the units of the plane's axes")}
    whole = {"section_state": (points, "1", "states at the section (SI)")}
    return labelled(whole, ("number", "point", "state")) | labelled(plane, ("number", "point", "axis"))


def boundary(rows: list[Pairs]) -> dict[str, Any]:
    """Counts of pairs, the uncertainty exponent, and the dimension of the basins' boundary."""
    slope, error = uncertainty_exponent(rows)
    pairs = {
        "pair_distance": ([row.distance for row in rows], "1", "distance of a pair, in lengths of the axes"),
        "pair_count": ([row.count for row in rows], "1", "pairs"),
        "uncertain_fraction": ([row.fraction for row in rows], "1", "fraction of pairs with different ends"),
        "uncertain_fraction_standard_error": (
            [row.error for row in rows],
            "1",
            "standard error of that fraction",
        ),
    }
    numbers = {
        "uncertainty_exponent": (slope, "1", "uncertainty exponent of the basins' boundary"),
        "uncertainty_exponent_standard_error": (error, "1", "standard error of the uncertainty exponent"),
        "boundary_dimension": (DIRECTIONS - slope, "1", "dimension of the boundary in the plane"),
    }
    kinds = coded("pair", [row.kind for row in rows], "where the pairs are", PAIRS)
    return labelled(pairs, "pair") | {"pair_kind": kinds} | labelled(numbers)


def coordinates(axes, count: int, starts: Starts) -> dict[str, Any]:
    """Axes of the plane, numbers of the attractors, names of states and axes."""
    number = {"number": (np.arange(1, count + 1), "1", "number of the attractor")}
    return {
        **starts.axes(axes),
        **labelled(number, "number"),
        "state": ("state", np.array(starts.states, dtype=str), {"long_name": "state"}),
        "axis": ("axis", np.array(list(axes), dtype=str), {"long_name": "axis of the plane"}),
    }
