"""Variables of curves in two parameters: their points, meetings and ends."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from jointplay.analysis.curves.tracing import FOLLOWED, Curve, whole
from jointplay.analysis.evaluate import joint_flags
from jointplay.analysis.labels import coded, labelled
from jointplay.analysis.orbits import orbit_dataset
from jointplay.analysis.orbits.branch import ENDS, WHY
from jointplay.analysis.orbits.branch_points import Special
from jointplay.analysis.orbits.family import Family, Point
from jointplay.analysis.orbits.orbit_search import at_phase
from jointplay.analysis.orbits.shooting import Orbit
from jointplay.analysis.quantities import EVENTS
from jointplay.analysis.vary import Axis
from jointplay.mechanism.model import Model

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
    size = max(map(len, table), default=0)
    padded = [rows + [blank] * (size - len(rows)) for rows in table]
    shape = (len(curves), size)
    stacked = {
        name: np.array([[row[name] for row in rows] for rows in padded]).reshape(*shape, *np.shape(value))
        for name, value in blank.items()
    }
    result = orbit_dataset.variables(stacked["orbit_state"], stacked, linkage, DIMS)
    for axis in axes:
        along, text = f"{axis.name}_tangent", f"derivative of the {axis.long_name} along the curve"
        result[axis.name] = (DIMS, stacked[axis.name], axis.attributes)
        result |= labelled({along: (stacked[along], axis.units, text)}, DIMS)
    coords = {
        **orbit_dataset.coordinates(orbit.map),
        **labelled({"curve": (np.arange(len(curves)), "1", "curve")}, "curve"),
        **labelled({"point": (np.arange(size), "1", "point of the curve")}, "point"),
        **labelled({"end": (["first", "last"], "1", "end of the curve")}, "end"),
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
    ends = np.reshape([[ENDS.index(end) for end in curve.branch.ends] for curve in curves], (-1, 2))
    why = coded(("curve", "end"), ends, "why a curve ends there", ENDS)
    why[2]["comment"] = "; ".join(f"{end}: {text}" for end, text in WHY.items())
    kinds = [FOLLOWED.index(curve.kind) for curve in curves]
    counts = np.array([len(curve.branch.points) for curve in curves], dtype=int)
    return {
        **labelled({"n_points": (counts, "1", "points of the curve")}, "curve"),
        **_events("curve", [curve.event for curve in curves], "begins beyond a grazing", model),
        "curve_kind": coded("curve", np.array(kinds, dtype=int), "what changes on the curve", FOLLOWED),
        "curve_end": why,
    }


def _events(of: str, events: Sequence[tuple[int, int]], text: str, model: Model) -> dict[str, Any]:
    """Contacts and kinds of the events of grazings."""
    joints = np.array([joint for joint, _ in events], dtype=np.int16)
    kinds = [kind if kind >= 0 else len(EVENTS) for _, kind in events]
    named = f"joint of the event that {text}, counted from 0; -1: none"
    return {
        f"{of}_event_joint": (of, joints, {"units": "1", "long_name": named} | joint_flags(model)),
        f"{of}_event_kind": coded(of, kinds, f"event that {text}", (*EVENTS, "none")),
    }


def _meetings(curves: Sequence[Curve], family: Family, axes: Sequence[Axis], model: Model) -> dict[str, Any]:
    found = [(number, special) for number, each in enumerate(curves) for special in each.branch.specials]
    points = [_index(curves[number], special) for number, special in found]
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
    events = _events("meeting", [special.event for _, special in found], "appears or vanishes there", model)
    return (
        labelled(table, "meeting")
        | events
        | {"meeting_kind": coded("meeting", np.array(kinds, dtype=int), "what happens there", MEETINGS)}
    )


def _kind(curve: Curve, special: Special) -> str:
    """What a special point of a curve is called."""
    return GRAZED.get(curve.kind, special.kind) if special.kind == "grazing" else special.kind


def _index(curve: Curve, special: Special) -> int:
    return next(i for i, point in enumerate(curve.branch.points) if point is special.point)
