"""Values of curves in two parameters: their points, meetings and ends."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from jointplay.analysis.curves.tracing import FOLLOWED, Curve, whole
from jointplay.analysis.labels import Out
from jointplay.analysis.orbits import orbit_dataset
from jointplay.analysis.orbits.branch_dataset import coordinates, ends, filled, grazed, place
from jointplay.analysis.orbits.branch_points import Special
from jointplay.analysis.orbits.family import Family, Point
from jointplay.analysis.orbits.orbit_search import at_phase
from jointplay.analysis.orbits.shooting import Orbit
from jointplay.analysis.vary import Axis

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


def values_of(
    curves: Sequence[Curve], family: Family, axes: Sequence[Axis], orbit: Orbit, phase: float
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Values of curves, and the variables whose names are those of parameters.

    `orbit` is the one that was found first, `phase` the section's.
    """
    blank = orbit_dataset.missing_numbers(len(orbit.map.free)) | {
        "orbit_state": np.full_like(orbit.state, np.nan)
    }
    blank |= {name: math.nan for axis in axes for name in (axis.name, f"{axis.name}_tangent")}
    table = [[_row(point, family, axes, phase) for point in curve.branch.points] for curve in curves]
    stacked, along = filled(table, blank), {}
    values = {name: stacked[name] for name in orbit_dataset.OUTS}
    for axis in axes:
        slope, text = f"{axis.name}_tangent", f"derivative of the {axis.long_name} along the curve"
        along[axis.name] = (DIMS, stacked[axis.name], axis.attributes)
        along[slope] = Out(DIMS, text, axis.units).variable(stacked[slope])
    values |= orbit_dataset.coordinates(orbit.map) | coordinates(table, "curve")
    values |= ends([curve.branch for curve in curves], "curve")
    values |= grazed("curve", [curve.event for curve in curves])
    values["curve_kind"] = np.array([FOLLOWED.index(curve.kind) for curve in curves], dtype=int)
    met, there = _meetings(curves, family, axes)
    return values | met, {"PARAMETER": along, "meeting_PARAMETER": there}


def _row(point: Point, family: Family, axes: Sequence[Axis], phase: float) -> dict[str, Any]:
    """Numbers of a point's orbit, parameters and their derivatives along the curve."""
    orbit = whole(point.orbit)
    values, slopes = family.parameter(point.q), point.tangent[-2:] * (family.high - family.low)
    row = orbit_dataset.orbit_numbers(orbit) | {"orbit_state": at_phase(orbit, phase)[0]}
    for axis, value, slope in zip(axes, values, slopes, strict=True):
        row |= {axis.name: float(value), f"{axis.name}_tangent": float(slope)}
    return row


def _meetings(curves: Sequence[Curve], family: Family, axes: Sequence[Axis]) -> tuple[dict, dict]:
    """Values of meetings, and the variables of the parameters there."""
    found = [(n, special) for n, each in enumerate(curves) for special in each.branch.specials]
    points = [place(curves[n].branch, special) for n, special in found]
    places = np.array([family.parameter(special.q) for _, special in found]).reshape(-1, 2)
    widths, there = np.array([special.width for _, special in found], dtype=float), {}
    for axis, values, span in zip(axes, places.T, family.high - family.low, strict=True):
        name, close = f"meeting_{axis.name}", Out("meeting", "how closely that is enclosed", axis.units)
        there[name] = Out("meeting", f"{axis.long_name} there", axis.units).variable(values)
        there[f"{name}_accuracy"] = close.variable(widths * span)
    kinds = [MEETINGS.index(_kind(curves[n], special)) for n, special in found]
    return {
        "meeting_curve": np.array([n for n, _ in found], dtype=np.int16),
        "meeting_point": np.array(points, dtype=int),
        **grazed("meeting", [special.event for _, special in found]),
        "meeting_kind": np.array(kinds, dtype=int),
    }, there


def _kind(curve: Curve, special: Special) -> str:
    """Name of a special point of a curve."""
    return GRAZED.get(curve.kind, special.kind) if special.kind == "grazing" else special.kind
