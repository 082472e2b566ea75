"""What is told of branches of periodic orbits, as one labelled dataset."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from jointplay.analysis.evaluate import Quantities, flags
from jointplay.analysis.orbits import orbit_dataset
from jointplay.analysis.orbits.arclength import Family, Point
from jointplay.analysis.orbits.branch import ENDS, Branch
from jointplay.analysis.orbits.branch_points import KINDS, Special
from jointplay.analysis.orbits.orbit_search import at_phase
from jointplay.analysis.orbits.section_map import SectionMap
from jointplay.analysis.orbits.shooting import Orbit
from jointplay.analysis.quantities import EVENTS
from jointplay.analysis.vary import Axis

DIMS = ("branch", "point")
JUMP = 10.0  # times the step: so far apart, states of neighbours on the asked section have jumped at a wall


class Passages:
    """Rows of the turns of points' orbits on the asked section, each followed once, and how that ended.

    With `rates` also rows whose accelerations are right (analysis.rates).
    """

    def __init__(self, phase: float, rates: bool):
        self.phase, self.rates = phase, rates
        # a point that is held keeps its id
        self._of: dict[int, tuple[Point, np.ndarray, np.ndarray, int]] = {}

    def of(self, point: Point) -> tuple[np.ndarray, np.ndarray, int]:
        """The rows, those for accelerations, and the status of a point's."""
        if id(point) not in self._of:
            self._of[id(point)] = (point, *self._followed(point.orbit))
        return self._of[id(point)][1:]

    def _followed(self, orbit: Orbit) -> tuple[np.ndarray, np.ndarray, int]:
        section = replace(orbit.map, phase=self.phase)
        state, _ = at_phase(orbit, self.phase)
        rows, status = section.passages(state)
        sharp = section.passages(state, sharp=True)[0] if self.rates and not status else rows
        if status:
            rows = sharp = np.full_like(rows, np.nan, shape=(section.turns, rows.shape[1]))
        return (
            np.roll(rows, 1, axis=0),
            np.roll(sharp, 1, axis=0),
            status,
        )  # the last passage closes the orbit


def told(
    point: Point, passages: Passages, names: Sequence[str], before: dict[str, Any] | None
) -> dict[str, Any]:
    """What is kept of a point: numbers of the orbit; its states on the asked section, and quantities there.

    Of an orbit of several turns that turn comes first with which all are nearest to the point's `before`.
    """
    orbit = point.orbit
    section, size = replace(orbit.map, phase=passages.phase), len(orbit.state)
    rows, sharp, status = passages.of(point)
    away = [_apart(section, point, np.roll(rows, -k, axis=0), before) for k in range(len(rows))]
    first = int(np.argmin(away))
    rows, sharp = (np.roll(each, -first, axis=0) for each in (rows, sharp))
    found = {} if status else Quantities(section.model, rows, rows[0], sharp).variables(names, "turn")
    return orbit_dataset.described(orbit) | {
        "orbit_state": section.state(section.unknowns(rows[0, 1 : 1 + size])),
        "quantities": found,
        "section_jump": int(bool(section.model.resets) and away[first] > JUMP * _step(point, before)),
        "rows": rows,
        "point": point,
    }


def _apart(section: SectionMap, point: Point, rows: np.ndarray, before: dict[str, Any] | None) -> float:
    """Largest distance, in units of the arc, of the states of two points on the asked section."""
    if before is None or len(before["rows"]) != len(rows):
        return 0.0
    end = 1 + len(point.orbit.state)
    pairs = zip(rows[:, 1:end], before["rows"][:, 1:end], strict=True)
    return max(float(np.linalg.norm(section.differ(one, other))) for one, other in pairs) / point.unit


def _step(point: Point, before: dict[str, Any] | None) -> float:
    """Distance of two points along the branch, on a section that no event is near to."""
    if before is None:
        return 1.0
    one, other = point.orbit, before["point"].orbit
    if other.map.phase != one.map.phase:
        other = replace(other, state=at_phase(other, one.map.phase)[0])
    return float(np.linalg.norm(one.map.differ(one.state, other.state)) / point.unit)


def variables(
    branches: Sequence[Branch],
    family: Family,
    axis: Axis,
    passages: Passages,
    names: Sequence[str],
    linkage: bool,
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Variables and coordinates of branches."""
    size = max(len(branch.points) for branch in branches)
    found = [_along(branch, passages, names) for branch in branches]
    blank = _blank(found[0][0])
    rows = [row + [blank] * (size - len(row)) for row in found]
    stacked = {name: np.array([[each[name] for each in row] for row in rows]) for name in blank}
    variables = orbit_dataset.variables(stacked, DIMS, linkage)
    variables |= orbit_dataset.state(stacked["orbit_state"], DIMS)
    passed = "whether an impact passed the section since the point before"
    jumps = {"long_name": passed} | flags(("no", "yes"))
    variables["section_jump"] = (DIMS, stacked["section_jump"].astype(np.int8), jumps)
    values = _padded([[family.parameter(point.q) for point in branch.points] for branch in branches], size)
    variables[axis.name] = (DIMS, values, axis.attributes)
    variables |= _quantities(found, size, names)
    variables |= _ends(branches) | _specials(branches, family, axis, passages.phase)
    coords = orbit_dataset.coordinates(branches[0].points[0].orbit.map) | {
        "branch": ("branch", np.arange(len(branches)), {"units": "1", "long_name": "branch"}),
        "point": ("point", np.arange(size), {"units": "1", "long_name": "point of the branch"}),
        "end": ("end", np.array(["first", "last"]), {"units": "1", "long_name": "end of the branch"}),
    }
    return variables, coords


def _along(branch: Branch, passages: Passages, names: Sequence[str]) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = []
    for point in branch.points:
        found.append(told(point, passages, names, found[-1] if found else None))
    return found


def _blank(like: dict[str, Any]) -> dict[str, Any]:
    """The numbers of a place in the table where there is no orbit."""
    size = len(like["lyapunov_exponent"])
    lost = {"orbit_state": np.full_like(like["orbit_state"], np.nan), "section_jump": 0}
    return orbit_dataset.lost(size) | lost


def _padded(rows: list[list[float]], size: int) -> np.ndarray:
    return np.array([row + [math.nan] * (size - len(row)) for row in rows])


def _quantities(found: list[list[dict[str, Any]]], size: int, names: Sequence[str]) -> dict[str, Any]:
    """Quantities on the section over branch, point and the turns of an orbit; NaN where there is none."""
    result = {}
    turns = max(len(each["rows"]) for row in found for each in row)
    for name in names:
        like = next((e["quantities"][name] for row in found for e in row if name in e["quantities"]), None)
        if like is None:
            continue
        dims, first, attributes = like
        values = np.full((len(found), size, turns, *np.shape(first)[1:]), np.nan)
        for b, row in enumerate(found):
            for p, each in enumerate(row):
                if name in each["quantities"]:
                    given = each["quantities"][name][1]
                    values[b, p, : len(given)] = given
        result[name] = ((*DIMS, *dims), values, attributes)
    return result


def _ends(branches: Sequence[Branch]) -> dict[str, Any]:
    ends = np.array([[ENDS.index(end) for end in branch.ends] for branch in branches], dtype=np.int8)
    parents = np.array([branch.parent for branch in branches], dtype=np.int16)
    sizes = np.array([len(branch.points) for branch in branches])
    return {
        "branch_end": (("branch", "end"), ends, {"long_name": "why a branch ends there"} | flags(ENDS)),
        "branch_parent": (
            "branch",
            parents,
            {"units": "1", "long_name": "branch that it leaves; -1: found from the start"},
        ),
        "n_points": ("branch", sizes, {"units": "1", "long_name": "points of the branch"}),
    }


def _specials(branches: Sequence[Branch], family: Family, axis: Axis, phase: float) -> dict[str, Any]:
    """The special points of all branches."""
    found = [(number, branch, each) for number, branch in enumerate(branches) for each in branch.specials]
    size = len(branches[0].points[0].orbit.state)
    width = family.high - family.low
    columns = {
        "branch": (np.array([n for n, _, _ in found], dtype=np.int16), "1", "branch of a special point"),
        "point": (np.array([_place(b, s) for _, b, s in found], dtype=int), "1", "its point on the branch"),
        "parameter": (np.array([family.parameter(s.q) for *_, s in found]), axis.units, "parameter there"),
        "accuracy": (
            np.array([abs(s.width * width) for *_, s in found]),
            axis.units,
            "how closely the parameter is enclosed",
        ),
        "event_joint": (
            np.array([s.event[0] for *_, s in found], dtype=np.int16),
            "1",
            "joint of the event that appears or vanishes at a grazing, counted from 0; -1: none",
        ),
    }
    result = {
        f"special_{name}": ("special", values, {"units": unit, "long_name": text})
        for name, (values, unit, text) in columns.items()
    }
    states = np.array([at_phase(s.point.orbit, phase)[0] for *_, s in found]).reshape(-1, size)
    named = {"units": "1", "long_name": "state on the section there"}
    return result | {"special_state": (("special", "state"), states, named)} | _kinds([s for *_, s in found])


def _kinds(found: list[Special]) -> dict[str, Any]:
    """What changes at each special point: its kind, its multiplier, or the event at a grazing."""
    kinds = np.array([KINDS.index(s.kind) for s in found], dtype=np.int8)
    met = np.array([s.event[1] if s.event[1] >= 0 else len(EVENTS) for s in found], dtype=np.int8)
    parts = np.array([[s.multiplier.real, s.multiplier.imag] for s in found]).reshape(-1, 2)
    event = {"long_name": "event that appears or vanishes"} | flags((*EVENTS, "none"))
    critical = {"units": "1", "long_name": "multiplier that makes the change"}
    return {
        "special_kind": ("special", kinds, {"long_name": "what changes there"} | flags(KINDS)),
        "special_event_kind": ("special", met, event),
        "special_multiplier": (("special", "part"), parts, critical),
    }


def _place(branch: Branch, special: Special) -> int:
    return next(i for i, point in enumerate(branch.points) if point is special.point)
