"""Curves in the plane of two parameters along which a periodic orbit changes.

The branch of an orbit is followed over the first parameter (orbits.continuation); from its special points,
curves are followed in both parameters by the same pseudo-arclength method (orbits.arclength), with one more
equation each (curves.tracing), through folds of either parameter. Meetings with other curves are located on
them. Validity: between events that appear or vanish the map is smooth; a curve goes on beyond such a change
where it is continuous there, else it ends at it.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import replace
from functools import lru_cache, partial
from itertools import count, islice, product
from typing import Annotated, Any, Literal, Unpack

import numpy as np
from pydantic import Field, PlainValidator

from jointplay.analysis import rules
from jointplay.analysis.curves.tracing import (
    BIFURCATIONS,
    FOLLOWED,
    FROM,
    KINDS,
    Begin,
    Curve,
    Curves,
    starts_of,
    whole,
)
from jointplay.analysis.declared import Outputs
from jointplay.analysis.keywords import Moving, Settling, Small, analysis, several
from jointplay.analysis.labels import Out, along, ended, units, xr
from jointplay.analysis.orbits import orbit_dataset
from jointplay.analysis.orbits.branch import WHY, Branch
from jointplay.analysis.orbits.branch_dataset import (
    annotated,
    coordinate_outs,
    coordinates,
    end_outs,
    ends,
    filled,
    grazed,
    grazed_outs,
    place,
)
from jointplay.analysis.orbits.branch_points import KINDS as SPECIAL
from jointplay.analysis.orbits.continuation import STEP, Explorer
from jointplay.analysis.orbits.family import Family, Point
from jointplay.analysis.orbits.orbit_dataset import Range, Tolerance, branch_fits, section_fits, started
from jointplay.analysis.orbits.periodic_orbit import RTOL
from jointplay.analysis.orbits.section_map import FAILED, SectionMap, changed_event, section_map
from jointplay.analysis.orbits.shooting import ITERATIONS, TOLERANCE, Orbit, Search, at_phase, lost, search
from jointplay.analysis.quantities import EVENTS
from jointplay.analysis.rules import turns_alike, varied
from jointplay.analysis.starts import placed
from jointplay.analysis.vary import Axis, axes
from jointplay.display import codes
from jointplay.display.errors import Problem, refuse
from jointplay.display.number_text import listed, measure, measured
from jointplay.solver.mechanism.base import Count, Natural, Number, accepts, unit
from jointplay.solver.mechanism.parameters import Parameter
from jointplay.solver.mechanism.records import ONCE_A_TURN, Mechanism, Section, TestSystem
from jointplay.solver.motion.trajectory import INTERRUPTED

OTHER_SIDE = 1e-2  # of the branch: how far from a grazing an orbit on its other side may be
ACCEPTED = "a result of continuation"


def _branches(given: Any) -> Any:
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
    known = [FROM.get(SPECIAL[kind], SPECIAL[kind]) for kind in branches["special_kind"].values]
    wrong = [i for i, label in enumerate(labels or ()) if label >= len(known)]
    for i in wrong:
        expected = f"the number of a special point, 0 to {len(known) - 1}, is accepted"
        yield Problem(f"labels[{i}]", labels[i], expected if known else "the branches have no special points")
    chosen = known if labels is None else [known[label] for label in labels if label < len(known)]
    if not wrong and not any(kind in of for kind in chosen):
        expected = f"a special point is needed there from which a curve of {', '.join(of)} can start"
        yield Problem("branches" if labels is None else "labels", list(dict.fromkeys(chosen)), expected)


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
        kind = SPECIAL[int(special["special_kind"])]
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


MAX_POINTS, MAX_CURVES = 200, 8
WHOLE = ("range", "closed", "joined", "origin")  # ends of a branch of which nothing is left
LISTED = 3  # curves, or their meetings, named in a line
BRANCH = 200  # points at least of the branch on which curves start
_PLANE = "a table of two parameters, each with its lowest and highest value,"
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


Ranges = Annotated[dict[str, Range], Field(min_length=2, max_length=2), accepts(_PLANE)]


Labels = several(Count, "a list of numbers of special points,")


Kinds = several(Literal[KINDS], f"a list of {', '.join(KINDS)},")


Grazed = several(Literal[EVENTS], f"a list of {', '.join(EVENTS)},")


def _plane_fits(
    mechanism: Mechanism | TestSystem,
    plane: dict[str, tuple[float, float]],
    start: float | None,
    branches: xr.Dataset | None,
    max_branches: int,
) -> Iterator[Problem]:
    """Yield the problems of both parameters and their ranges."""
    if branches is not None and max_branches > 1:
        yield Problem(
            "max_branches", max_branches, "accepted only without branches, which are then the only ones"
        )
    if branches is not None and start is not None:
        yield Problem("start", start, "accepted only without branches, which have starts of their own")
    for number, (name, values) in enumerate(plane.items()):
        known = values[0] if branches is not None and name == key_of(branches) else None
        for problem in branch_fits(mechanism, name, values, known if number or known is not None else start):
            key = "start" if problem.key == "start" and not number else f"plane.{name}"
            yield Problem(key, problem.given, problem.expected)


def answer(result: xr.Dataset) -> str:
    """The extent of each curve, the reason of its end, and its meetings with others."""
    short = [result.attrs["stopped"]] if "stopped" in result.attrs else []
    if not np.isfinite(result["period"].values).any():
        why = "there is no periodic orbit, or it has no bifurcation on the branch over the first parameter"
        return f"no curve was found: {short[0] if short else why}"
    lines = [_line(result, number) for number in range(min(result.sizes["curve"], LISTED))]
    if more := result.sizes["curve"] - len(lines):
        lines[-1] += f"; {more} more curves"
    return "\n".join([*lines, *_meetings(result), *short])


def _line(result: xr.Dataset, number: int) -> str:
    one, names = result.isel(curve=number), str(result.attrs["parameters"]).split()
    kind = codes.words(one["curve_kind"]).item().replace("_", " ")
    spans = []
    for name in names:
        ends = (of(one[name].values[: int(one["n_points"])]) for of in (np.min, np.max))
        low, high = (measured(end, result[name]) for end in ends)
        long = str(result[name].attrs.get("long_name", name))
        spans.append(f"{long} {low} to {high}")
    first, last = (WHY.get(end, end) for end in codes.words(one["curve_end"]).values)
    reasons = f"both ends: {first}" if first == last else f"first end: {first}; last end: {last}"
    return f"{kind}, {int(one['n_points'])} points: {', '.join(spans)}; {reasons}"


def _meetings(result: xr.Dataset) -> list[str]:
    if not result.sizes["meeting"]:
        return []
    names, parts = str(result.attrs["parameters"]).split(), []
    kinds = [kind.replace("_", " ") for kind in codes.words(result["meeting_kind"]).values]
    for i, kind in enumerate(kinds):
        place = [measured(result[f"meeting_{name}"][i], result[name], 6) for name in names]
        parts.append(f"{kind} at ({', '.join(place)})")
    return [f"meets {listed(parts, LISTED, ', ')}"]


OUTPUTS = Outputs(
    "curve",
    orbit_dataset.COORDS | coordinate_outs("curve"),
    along(orbit_dataset.OUTS, *DIMS)
    | {
        "PARAMETER": Out(
            DIMS, "each parameter, and under PARAMETER_tangent its derivative along the curve", ""
        )
    }
    | end_outs("curve")
    | grazed_outs("curve", "begins beyond a grazing")
    | {
        "curve_kind": Out("curve", "what changes on the curve", flags=FOLLOWED),
        "meeting_curve": Out("meeting", "curve it lies on"),
        "meeting_point": Out("meeting", "its point on the curve"),
        "meeting_PARAMETER": Out("meeting", "each parameter there, and how closely that is enclosed", ""),
    }
    | grazed_outs("meeting", "appears or vanishes there")
    | {"meeting_kind": Out("meeting", "what happens there", flags=MEETINGS)}
    | orbit_dataset.SOUGHT,
    answer,
)


@analysis(
    *(section_fits, "model", turns_alike, _plane_fits, labels_fit),
    usual={"rtol": RTOL},
    outputs=OUTPUTS,
    left_out=rules.TWO_RANGES,
    model=started,
)
def curve(
    mechanism: Moving,
    section: Section = ONCE_A_TURN,
    *,
    plane: Ranges,
    of: Kinds = BIFURCATIONS,
    grazing_events: Grazed = EVENTS,
    branches: Branches = None,
    labels: Labels | None = None,
    start: Number | None = None,
    period: Natural = 1,
    step: Annotated[Small, unit("longest step", "1")] = STEP,
    max_points: Natural = MAX_POINTS,
    max_curves: Natural = MAX_CURVES,
    max_branches: Natural = 1,
    tolerance: Tolerance = TOLERANCE,
    **motion: Unpack[Settling],
) -> xr.Dataset:
    """Follow the changes of a periodic orbit as curves in the plane of two parameters.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        What moves.
    section : CrankAngle or Plane
        As in `periodic_orbit`.
    plane : dict of str to pair of float
        Two parameters, by name or by key path, each with its lowest and highest value; clearance and gear
        ratio or speed, each from half to twice its own, if left out. Over the first one, at the mechanism's
        own value of the second, changes are looked for from which curves start.
    of : sequence of str
        Kinds of curves that are followed: fold, period_doubling, neimark_sacker, symmetry_breaking and
        grazing. Grazing is left out unless it is named; with it the grazings that other curves meet are
        found, too.
    grazing_events : sequence of str
        Events that appear or vanish on curves of grazing; all if left out.
    branches : xarray.Dataset, optional
        What `continuation` returned for one of the two parameters, of this mechanism: curves start from its
        special points. In Python only.
    labels : sequence of int, optional
        Which special points of `branches`, by their numbers along ``special``; all if left out.
    start : float, optional
        Value of the first parameter at which the first orbit is sought; the mechanism's own if left out.
    period, initial, transient, tolerance
        As in `periodic_orbit`, of the first orbit.
    step : float
        Longest step, as a fraction of the parameters' ranges, and of the orbit alike.
    max_points : int
        Largest number of points of a curve. The branch on which curves start has as many at most, or 200 if
        that is more.
    max_curves : int
        Largest number of curves.
    max_branches : int
        Largest number of branches on which curves start: that of the first orbit, then those that leave it.
    progress : callable, optional
        Called with the fraction done, of at most `max_curves` curves of `max_points` points.

    Raises
    ------
    InputError
        If anything asked for makes no sense; numerical trouble is a status instead.
    """
    began, both = time.perf_counter(), axes(mechanism, plane, "plane")
    first, second = plane
    limits, progress = (motion["rtol"], motion["max_steps"]), motion["progress"]

    @lru_cache(maxsize=64)  # Newton's method comes back to the neighbours of a value
    def model_at(values: tuple[float, float]) -> SectionMap:
        there = varied(mechanism, dict(zip(plane, values, strict=True)))
        return section_map(placed(there, None, section), section, period, *limits)

    def maps(values: np.ndarray) -> SectionMap:
        return model_at((float(values[0]), float(values[1])))

    low, high = np.array(list(plane.values())).T
    family = Family(maps, low, high, tolerance)
    own = dict(zip(plane, (Parameter(mechanism, name).value for name in plane), strict=True))
    visited, most = count(1), max(max_points, BRANCH)

    def visit(point: Point) -> None:
        if progress is not None:
            progress(min(1.0, next(visited) / (most * max_branches + max_points * max_curves)))

    def placed_at(name: str, value: float, state: Any, turns: int) -> SectionMap:
        there = placed(varied(mechanism, {name: value}), state, section)
        return section_map(there, section, turns, *limits)

    def fractions(name: str, value: float) -> np.ndarray:
        return family.fraction(np.array(list((own | {name: value}).values())))

    reached, about = [], {"parameters": " ".join(axis.name for axis in both)}
    if branches is None:
        value = own[first] if start is None else start
        requested = placed_at(first, value, motion["initial"], period)
        orbit = search(requested, Search(motion["transient"], tolerance, ITERATIONS))
        line = Family(lambda v: maps(np.array([v, own[second]])), *plane[first], tolerance)
        found = Explorer(line, step, most, max_branches, visit).explore(orbit, line.fraction(value))
        starts = starts_of(found, of, lambda q: fractions(first, line.parameter(q)))
        reached = [end for branch in found for end in branch.ends]
        about |= {} if orbit.status else _stopped(found, line, both[0])
    else:
        key = key_of(branches)
        labelled = starts_in(branches, labels, of, partial(placed_at, key), tolerance)
        starts = [replace(begin, q=fractions(key, value)) for begin, value in labelled]
        requested = placed_at(key, float(sum(plane[key]) / 2), None, period)
        orbit = starts[0].orbit if starts else lost(requested, FAILED)
    kinds = [-1, *map(EVENTS.index, grazing_events)] if "grazing" in of else []  # -1: one that is not told
    starts = [each for each in starts if each.kind != "grazing" or each.event[1] in kinds]
    curves = list(islice(Curves(family, step, max_points, visit, kinds).traced(starts), max_curves))
    values, groups = values_of(curves, family, both, orbit, requested.phase)
    stopped = "interrupted" in (*reached, *(end for each in curves for end in each.branch.ends))
    values |= ended(INTERRUPTED if stopped else orbit.status, began)
    of = units(isinstance(mechanism, Mechanism))
    return annotated(OUTPUTS.dataset(values, of, orbit.map.model, groups=groups, **about), orbit.map.model)


def _stopped(branches: Sequence[Branch], line: Family, axis: Axis) -> dict[str, str]:
    """An attribute on where branches end within the range, if any do: curves may start beyond."""
    ends = [
        f"{measure(float(line.parameter(branch.points[at].q)), axis.units)} ({WHY[branch.ends[at]]})"
        for branch, at in product(branches, (0, -1))
        if branch.ends[at] not in WHOLE
    ]
    text = f"the branch over {axis.long_name}, on which curves start, ended at {' and '.join(ends)}"
    return {"stopped": text} if ends else {}


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
    met, there = _meeting_columns(curves, family, axes)
    return values | met, {"PARAMETER": along, "meeting_PARAMETER": there}


def _row(point: Point, family: Family, axes: Sequence[Axis], phase: float) -> dict[str, Any]:
    """Numbers of a point's orbit, parameters and their derivatives along the curve."""
    orbit = whole(point.orbit)
    values, slopes = family.parameter(point.q), point.tangent[-2:] * (family.high - family.low)
    row = orbit_dataset.orbit_numbers(orbit) | {"orbit_state": at_phase(orbit, phase)[0]}
    for axis, value, slope in zip(axes, values, slopes, strict=True):
        row |= {axis.name: float(value), f"{axis.name}_tangent": float(slope)}
    return row


def _meeting_columns(curves: Sequence[Curve], family: Family, axes: Sequence[Axis]) -> tuple[dict, dict]:
    """Values of meetings, and the variables of the parameters there."""
    found = [(n, special) for n, each in enumerate(curves) for special in each.branch.specials]
    points = [place(curves[n].branch, special) for n, special in found]
    places = np.array([family.parameter(special.q) for _, special in found]).reshape(-1, 2)
    widths, there = np.array([special.width for _, special in found], dtype=float), {}
    for axis, values, span in zip(axes, places.T, family.high - family.low, strict=True):
        name, close = f"meeting_{axis.name}", Out("meeting", "how closely that is enclosed", axis.units)
        there[name] = Out("meeting", f"{axis.long_name} there", axis.units).variable(values)
        there[f"{name}_accuracy"] = close.variable(widths * span)
    kinds = [
        GRAZED.get(curves[n].kind, each.kind) if each.kind == "grazing" else each.kind for n, each in found
    ]
    return {
        "meeting_curve": np.array([n for n, _ in found], dtype=np.int16),
        "meeting_point": np.array(points, dtype=int),
        **grazed("meeting", [special.event for _, special in found]),
        "meeting_kind": np.array([*map(MEETINGS.index, kinds)], dtype=int),
    }, there
