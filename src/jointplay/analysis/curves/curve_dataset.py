"""Variables of curves in two parameters: their points, meetings and ends."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from jointplay.analysis.curves.tracing import FOLLOWED, Curve, whole
from jointplay.analysis.labels import coded, labelled
from jointplay.analysis.orbits import orbit_dataset
from jointplay.analysis.orbits.branch_dataset import coordinates, ends, filled, grazed, place
from jointplay.analysis.orbits.branch_points import Special
from jointplay.analysis.orbits.family import Family, Point
from jointplay.analysis.orbits.orbit_search import at_phase
from jointplay.analysis.orbits.shooting import Orbit
from jointplay.analysis.vary import Axis
from jointplay.solver.mechanism.model import Model

DIMS = ("curve", "point")
MEETINGS = (
    "cusp",
    "fold_doubling",
    "fold_symmetry_breaking",
    "fold_torus",
    "doubling_torus",
    "resonance_1_1",
    "resonance_1_2",
    "resonance_1_3",
    "resonance_1_4",
    "fold_grazing",
    "doubling_grazing",
    "grazing",
    "torus_grazing",
    "symmetry_breaking_grazing",
)
GRAZED = {  # by the curve on which an event appears or vanishes
    "fold": "fold_grazing",
    "period_doubling": "doubling_grazing",
    "neimark_sacker": "torus_grazing",
    "symmetry_breaking": "symmetry_breaking_grazing",
}


def variables(
    curves: Sequence[Curve], family: Family, axes: Sequence[Axis], orbit: Orbit, phase: float, linkage: bool
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Variables and coordinates of curves; `orbit` is the one that was found first, `phase` the section's."""
    blank = orbit_dataset.missing_numbers(len(orbit.map.free)) | {
        "orbit_state": np.full_like(orbit.state, np.nan)
    }
    blank |= {name: math.nan for axis in axes for name in (axis.name, f"{axis.name}_tangent")}
    table = [[_row(point, family, axes, phase) for point in curve.branch.points] for curve in curves]
    stacked = filled(table, blank)
    result = orbit_dataset.variables(stacked["orbit_state"], stacked, linkage, DIMS)
    for axis in axes:
        along, text = f"{axis.name}_tangent", f"derivative of the {axis.long_name} along the curve"
        result[axis.name] = (DIMS, stacked[axis.name], axis.attributes)
        result |= labelled({along: (stacked[along], axis.units, text)}, DIMS)
    coords = {
        **orbit_dataset.coordinates(orbit.map),
        **coordinates(table, "curve"),
    }
    return result | _curves(curves, orbit.map.model) | _meetings(
        curves, family, axes, orbit.map.model
    ), coords


def _row(point: Point, family: Family, axes: Sequence[Axis], phase: float) -> dict[str, Any]:
    """Numbers of a point's orbit, parameters and their derivatives along the curve."""
    orbit = whole(point.orbit)
    values, slopes = family.parameter(point.q), point.tangent[-2:] * (family.high - family.low)
    row = orbit_dataset.orbit_numbers(orbit) | {"orbit_state": at_phase(orbit, phase)[0]}
    for axis, value, slope in zip(axes, values, slopes, strict=True):
        row |= {axis.name: float(value), f"{axis.name}_tangent": float(slope)}
    return row


def _curves(curves: Sequence[Curve], model: Model) -> dict[str, Any]:
    kinds = [FOLLOWED.index(curve.kind) for curve in curves]
    return {
        **ends([curve.branch for curve in curves], "curve"),
        **grazed("curve", [curve.event for curve in curves], "begins beyond a grazing", model),
        "curve_kind": coded("curve", np.array(kinds, dtype=int), "what changes on the curve", FOLLOWED),
    }


def _meetings(curves: Sequence[Curve], family: Family, axes: Sequence[Axis], model: Model) -> dict[str, Any]:
    found = [(number, special) for number, each in enumerate(curves) for special in each.branch.specials]
    points = [place(curves[number].branch, special) for number, special in found]
    places = np.array([family.parameter(special.q) for _, special in found]).reshape(-1, 2)
    widths = np.array([special.width for _, special in found], dtype=float)
    table = {
        "meeting_curve": (np.array([number for number, _ in found], dtype=np.int16), "1", "curve it lies on"),
        "meeting_point": (np.array(points, dtype=int), "1", "its point on the curve"),
    }
    for axis, values, span in zip(axes, places.T, family.high - family.low, strict=True):
        table[f"meeting_{axis.name}"] = (values, axis.units, f"{axis.long_name} there")
        table[f"meeting_{axis.name}_accuracy"] = (widths * span, axis.units, "how closely that is enclosed")
    kinds = [MEETINGS.index(_kind(curves[number], special)) for number, special in found]
    events = grazed("meeting", [special.event for _, special in found], "appears or vanishes there", model)
    return (
        labelled(table, "meeting")
        | events
        | {"meeting_kind": coded("meeting", np.array(kinds, dtype=int), "what happens there", MEETINGS)}
    )


def _kind(curve: Curve, special: Special) -> str:
    """Name of a special point of a curve."""
    return GRAZED.get(curve.kind, special.kind) if special.kind == "grazing" else special.kind
