"""Values of branches of periodic orbits: points, special points, ends, and derivatives along the branch.

From a point z of the branch with tangent t the motions that start at z + h t and z - h t, each with its own
parameter, are followed as the orbit is; what is evaluated of both gives

    dy/ds = (y(z + h t) - y(z - h t)) / 2h + O(h^2),

one-sided, + O(h), where only one of them has the orbit's events, as beside a grazing. s is the arc on the
section asked for: of the states there over their scales and over the constant c (arclength), and of the
parameter's fraction of its range. Validity: no event passes that section between them, and one of them has
the orbit's events; else there is no derivative (NaN).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from operator import attrgetter
from typing import Any

import numpy as np

from jointplay.analysis.evaluate import Quantities, joint_flags
from jointplay.analysis.labels import Out, xr
from jointplay.analysis.orbits import orbit_dataset, section_map
from jointplay.analysis.orbits.branch import ENDS, WHY, Branch
from jointplay.analysis.orbits.branch_points import KINDS, Special
from jointplay.analysis.orbits.family import Family, Point
from jointplay.analysis.orbits.section_map import SectionMap, same_events
from jointplay.analysis.orbits.shooting import Orbit, at_phase
from jointplay.analysis.quantities import EVENTS
from jointplay.analysis.vary import Axis
from jointplay.display.errors import InputError
from jointplay.solver.mechanism.model import Model

STEPS = (3e-5, 3e-7)  # h; the second where an event is nearer than the first
LEAP = 1e-4  # of a value: a difference on one side alone that is larger is a jump, as of an angle by a turn
NUMBERS = ("period_time", "smallest_impact_speed")  # of an orbit


@dataclass(frozen=True)
class Motion:
    """A motion at the arc length h from a point of a branch, with its rows on the wanted section.

    `sharp`: rows for accelerations, as `branch_dataset.Passages` gives them.
    """

    h: float
    orbit: Orbit
    rows: np.ndarray
    sharp: np.ndarray

    def rolled(self, by: int) -> Motion:
        """The same with another turn first."""
        return Motion(self.h, self.orbit, *(np.roll(each, -by, axis=0) for each in (self.rows, self.sharp)))

    @property
    def state(self) -> np.ndarray:
        """State on the wanted section."""
        return self.rows[0, 1 : 1 + len(self.orbit.state)]

    def quantities(self, names: Sequence[str]) -> dict[str, Any]:
        """Quantities on the wanted section."""
        return Quantities(self.orbit.map.model, self.rows, self.rows[0], self.sharp).variables(names, "turn")

    def number(self, name: str) -> float:
        """One of `NUMBERS`."""
        image = self.orbit.image
        if name == "period_time":
            return image.time
        return section_map.smallest_impact_speed(self.orbit.map.model, image.events)


@dataclass(frozen=True)
class Slopes:
    """Derivatives along the arc: of the fraction of the parameter's range, state, numbers and quantities."""

    q: float
    state: np.ndarray
    numbers: dict[str, float] = field(default_factory=dict)
    quantities: dict[str, Any] = field(default_factory=dict)


def neighbour_motions(family: Family, point: Point, follow: Callable[[Orbit], tuple]) -> list[Motion]:
    """The motions next to a point that have its events: two, one or none."""
    if not np.any(point.tangent):
        return []
    for h in STEPS:
        found = [_neighbour_motion(family, point, each, follow) for each in (-h, h)]
        if any(found):
            return [motion for motion in found if motion]
    return []


def _neighbour_motion(family: Family, point: Point, h: float, follow: Callable) -> Motion | None:
    try:
        section, state = family.placed(point.z + h * point.tangent, point)
    except InputError:  # a little beyond its range a parameter may have no meaning
        return None
    orbit = Orbit(0, section, state, section.image(state, False), 0.0, 0)
    image = orbit.image
    if image.status or not same_events(image.events, point.orbit.image.events):
        return None
    rows, sharp, status = follow(orbit)
    return None if status else Motion(h, orbit, rows, sharp)


def neighbour_slopes(
    own: Motion, sides: Sequence[Motion], point: Point, sense: float, names: Sequence[str]
) -> Slopes:
    """Derivatives at a point whose motion is `own`; `sense` -1: the arc runs the other way."""
    if not sides:
        return Slopes(np.nan, np.full(len(own.orbit.state), np.nan))
    section, motions = own.orbit.map, sorted([own, *sides], key=attrgetter("h"))
    h = motions[-1].h - motions[0].h
    along = section.differ(motions[-1].state, motions[0].state) / h
    length = np.hypot(np.linalg.norm(along) / point.unit, point.tangent[-1])  # of the tangent on this section
    state, span = np.zeros(len(own.state)), sense * length * h
    state[section.free] = along * section.scale[section.free] * sense / length
    numbers = {n: float(_slope(span, [np.array(motion.number(n)) for motion in motions])) for n in NUMBERS}
    tables = [motion.quantities(names) for motion in motions]
    quantities = {
        name: (dims, _slope(span, [table[name][1] for table in tables]), attributes)
        for name, (dims, values, attributes) in tables[0].items()
        if values.dtype.kind == "f"
    }
    return Slopes(point.tangent[-1] / length, state, numbers, quantities)


def _slope(span: float, values: Sequence[np.ndarray]) -> np.ndarray:
    """The derivative by values over a span of the arc; NaN where they jump."""
    change = values[-1] - values[0]
    slope = change / span
    if len(values) < 3:
        return slope
    bend = np.abs(values[0] - 2 * values[1] + values[2])
    jumps = (bend > np.abs(change) / 2) & (bend > LEAP * np.max(np.abs(values), axis=0))
    return np.where(jumps, np.nan, slope)


DIMS = ("branch", "point")
SLOPED = (*NUMBERS, "orbit_state")
JUMP = 10.0  # least distance of neighbours on the section asked for, over their step, after a jump at a wall


class Passages:
    """Passages of the orbits of points, and of motions next to them, through the wanted section.

    With `rates` also rows whose accelerations are resolved (analysis.evaluate). Each orbit is followed once.
    """

    def __init__(self, phase: float, rates: bool, family: Family):
        self.phase, self.rates, self.family = phase, rates, family
        # the point is kept with its rows: its orbit's id is not given to another
        self._of: dict[int, tuple[Point, tuple, list[Motion]]] = {}

    def of(self, point: Point) -> tuple[np.ndarray, np.ndarray, int]:
        """Rows of a point's orbit, rows for accelerations, and the status of the run."""
        return self._all(point)[1]

    def slopes(self, point: Point, own: Motion, turn: int, names: Sequence[str]) -> Slopes:
        """Derivatives along the branch, of orbits whose rows begin with a turn."""
        visited, _, sides = self._all(point)
        sense = float(np.sign(point.tangent @ visited.tangent))
        return neighbour_slopes(own, [side.rolled(turn) for side in sides], point, sense, names)

    def _all(self, point: Point) -> tuple[Point, tuple, list[Motion]]:
        if id(point.orbit) not in self._of:
            rows = self._followed(point.orbit)
            sides = [] if rows[-1] else neighbour_motions(self.family, point, self._followed)
            self._of[id(point.orbit)] = (point, rows, sides)
        return self._of[id(point.orbit)]

    def _followed(self, orbit: Orbit) -> tuple[np.ndarray, np.ndarray, int]:
        section = replace(orbit.map, phase=self.phase)
        state, _ = at_phase(orbit, self.phase)
        rows, status = section.passages(state)
        sharp = section.passages(state, sharp=True)[0] if self.rates and not status else rows
        if status:
            rows = sharp = np.full_like(rows, np.nan, shape=(section.turns, rows.shape[1]))
        # the last passage closes the orbit
        return np.roll(rows, 1, axis=0), np.roll(sharp, 1, axis=0), status


def point_row(
    point: Point, passages: Passages, names: Sequence[str], before: dict[str, Any] | None
) -> dict[str, Any]:
    """Numbers of a point's orbit, its states on the wanted section, and quantities there.

    Of an orbit of several turns that one comes first with which all are nearest to those of the row `before`.
    """
    orbit = point.orbit
    section = replace(orbit.map, phase=passages.phase)
    rows, sharp, status = passages.of(point)
    away = [_apart(section, point, np.roll(rows, -k, axis=0), before) for k in range(len(rows))]
    first = int(np.argmin(away))
    own = Motion(0.0, orbit, rows, sharp).rolled(first)
    rows, slopes = own.rows, passages.slopes(point, own, first, names)
    modes = Quantities(section.model, rows, rows[0]).modes if not status else None
    return orbit_dataset.orbit_numbers(orbit) | {
        "orbit_state": section.state(section.unknowns(own.state)),
        "quantities": {} if status else own.quantities(names) | _named(slopes.quantities),
        "slopes": slopes,
        "modes": modes,
        "section_event": int(before is not None and not np.array_equal(modes, before["modes"])),
        "section_jump": int(bool(section.model.resets) and away[first] > JUMP * _step(point, before)),
        "rows": rows,
        "point": point,
    }


def _named(quantities: dict[str, Any]) -> dict[str, Any]:
    """Variables of derivatives."""
    return {
        f"{name}_tangent": (dims, values, attributes | {"long_name": sloped(attributes["long_name"])})
        for name, (dims, values, attributes) in quantities.items()
    }


def sloped(long_name: str) -> str:
    """Long name of a derivative along the branch."""
    return f"derivative of the {long_name} along the branch"


def _apart(section: SectionMap, point: Point, rows: np.ndarray, before: dict[str, Any] | None) -> float:
    """Largest distance, in units of the arc, of the states of two points on the wanted section."""
    if before is None or len(before["rows"]) != len(rows):
        return 0.0
    end = 1 + len(point.orbit.state)
    pairs = zip(rows[:, 1:end], before["rows"][:, 1:end], strict=True)
    return max(float(np.linalg.norm(section.differ(one, other))) for one, other in pairs) / point.unit


def _step(point: Point, before: dict[str, Any] | None) -> float:
    """Distance of two points along the branch, on a section away from events."""
    if before is None:
        return 1.0
    one, other = point.orbit, before["point"].orbit
    if other.map.phase != one.map.phase:
        other = replace(other, state=at_phase(other, one.map.phase)[0])
    return float(np.linalg.norm(one.map.differ(one.state, other.state)) / point.unit)


def values_of(
    branches: Sequence[Branch], family: Family, axis: Axis, passages: Passages, names: Sequence[str]
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Values of branches, and the variables whose names are those of the parameter and of quantities."""
    table = [_rows(branch, passages, names) for branch in branches]
    size = max(map(len, table))
    blank = orbit_dataset.missing_numbers(len(table[0][0]["lyapunov_exponent"]))
    nothing = np.full_like(table[0][0]["orbit_state"], np.nan)
    blank |= {"orbit_state": nothing, "section_jump": 0, "section_event": 0, axis.name: math.nan}
    blank |= _derivatives(Slopes(math.nan, nothing), family, axis)
    for branch, rows in zip(branches, table, strict=True):
        for point, row in zip(branch.points, rows, strict=True):
            row |= {axis.name: family.parameter(point.q)} | _derivatives(row["slopes"], family, axis)
    stacked = filled(table, blank)
    first, map_ = branches[0].points[0], branches[0].points[0].orbit.map
    values = {name: stacked[name] for name in orbit_dataset.OUTS}
    values |= {f"{name}_tangent": stacked[f"{name}_tangent"] for name in SLOPED}
    values |= {"arc_scale": map_.scale * first.unit} | ends(branches, "branch")
    values["branch_parent"] = np.array([branch.parent for branch in branches], dtype=np.int16)
    values |= _specials(branches, family, passages.phase)
    values |= {name: stacked[name] for name in ("section_jump", "section_event")}
    values |= orbit_dataset.coordinates(map_) | coordinates(table, "branch")
    slope = Out(DIMS, sloped(axis.long_name), axis.units).variable(stacked[f"{axis.name}_tangent"])
    groups = {
        "QUANTITY": _quantities(table, size, [*names, *(f"{name}_tangent" for name in names)]),
        "PARAMETER_tangent": {f"{axis.name}_tangent": slope},
        "PARAMETER": {axis.name: (DIMS, stacked[axis.name], axis.attributes)},
    }
    return values, groups


def _derivatives(slopes: Slopes, family: Family, axis: Axis) -> dict[str, Any]:
    """Derivatives along the arc, by the names of their variables."""
    numbers = {f"{name}_tangent": slopes.numbers.get(name, math.nan) for name in NUMBERS}
    parameter = {f"{axis.name}_tangent": slopes.q * (family.high - family.low)}
    return parameter | {"orbit_state_tangent": slopes.state} | numbers


def _rows(branch: Branch, passages: Passages, names: Sequence[str]) -> list[dict[str, Any]]:
    rows: list[dict[str, Any]] = []
    for point in branch.points:
        rows.append(point_row(point, passages, names, rows[-1] if rows else None))
    return rows


def _quantities(table: list[list[dict[str, Any]]], size: int, names: Sequence[str]) -> dict[str, Any]:
    """Quantities on the section over branch, point and the turns of an orbit; NaN where there is none."""
    result = {}
    turns = max(len(row["rows"]) for rows in table for row in rows)
    cells = [(b, p, row["quantities"]) for b, rows in enumerate(table) for p, row in enumerate(rows)]
    for name in names:
        given = [(b, p, quantities[name]) for b, p, quantities in cells if name in quantities]
        if not given:
            continue
        dims, like, attributes = given[0][2]
        values = np.full((len(table), size, turns, *np.shape(like)[1:]), np.nan)
        for b, p, (_, own, _) in given:
            values[b, p, : len(own)] = own
        result[name] = ((*DIMS, *dims), values, attributes)
    return result


def filled(table: Sequence[Sequence[dict[str, Any]]], blank: dict[str, Any]) -> dict[str, np.ndarray]:
    """Numbers of points over branches and points, by name; `blank` past a branch's last point."""
    size = max(map(len, table), default=0)
    rows = [[*branch, *[blank] * (size - len(branch))] for branch in table]
    shape = len(table), size
    return {
        name: np.array([[row[name] for row in branch] for branch in rows]).reshape(*shape, *np.shape(value))
        for name, value in blank.items()
    }


def coordinates(table: Sequence[Sequence[Any]], of: str) -> dict[str, Any]:
    """Numbers of branches and of their points, and their ends; `of`: the noun for a branch."""
    size = max(map(len, table), default=0)
    return {of: np.arange(len(table)), "point": np.arange(size), "end": np.array(["first", "last"])}


def coordinate_outs(of: str) -> dict[str, Out]:
    """Declarations of these coordinates."""
    return {
        of: Out(of, of),
        "point": Out("point", f"point of the {of}"),
        "end": Out("end", f"end of the {of}"),
    }


def ends(branches: Sequence[Branch], of: str) -> dict[str, Any]:
    """Number of points of each branch, and the reasons of its ends; `of`: the noun for a branch."""
    found = np.reshape([[ENDS.index(end) for end in branch.ends] for branch in branches], (-1, 2))
    return {"n_points": np.array([len(branch.points) for branch in branches], dtype=int), f"{of}_end": found}


def end_outs(of: str) -> dict[str, Out]:
    """Declarations of these counts and ends."""
    end = Out((of, "end"), f"why a {of} ends there", flags=ENDS)
    return {"n_points": Out(of, f"points of the {of}"), f"{of}_end": end}


def grazed(of: str, events: Sequence[tuple[int, int]]) -> dict[str, Any]:
    """Contacts and kinds of the events that appear or vanish at grazings."""
    kinds = [kind if kind >= 0 else len(EVENTS) for _, kind in events]
    joints = np.array([joint for joint, _ in events], dtype=np.int16)
    return {f"{of}_event_joint": joints, f"{of}_event_kind": kinds}


def grazed_outs(of: str, text: str) -> dict[str, Out]:
    """Declarations of these events."""
    return {
        f"{of}_event_joint": Out(of, f"joint of the event that {text}, counted from 0; -1: none"),
        f"{of}_event_kind": Out(of, f"event that {text}", flags=(*EVENTS, "none")),
    }


def annotated(found: xr.Dataset, model: Model) -> xr.Dataset:
    """The dataset, whose ends are explained and whose contacts have a model's names."""
    for name, each in found.data_vars.items():
        if str(name).endswith("_event_joint"):
            each.attrs |= joint_flags(model)
        elif str(name) in ("branch_end", "curve_end"):
            each.attrs["comment"] = "; ".join(f"{end}: {why}" for end, why in WHY.items())
    return found


def place(branch: Branch, special: Special) -> int:
    """Number of a special point among the points of its branch."""
    return next(i for i, point in enumerate(branch.points) if point is special.point)


def _specials(branches: Sequence[Branch], family: Family, phase: float) -> dict[str, Any]:
    """The special points of all branches."""
    found = [(number, special) for number, branch in enumerate(branches) for special in branch.specials]
    numbers, specials = [number for number, _ in found], [special for _, special in found]
    points = [place(branches[number], special) for number, special in found]
    widths = [abs(special.width * (family.high - family.low)) for special in specials]
    states = np.array([at_phase(special.point.orbit, phase)[0] for special in specials])
    parts = np.array([[special.multiplier.real, special.multiplier.imag] for special in specials])
    return {
        "special_branch": np.array(numbers, dtype=np.int16),
        "special_point": np.array(points, dtype=int),
        "special_parameter": np.array([family.parameter(special.q) for special in specials]),
        "special_accuracy": np.array(widths),
        **grazed("special", [special.event for special in specials]),
        "special_state": states.reshape(-1, len(branches[0].points[0].orbit.state)),
        "special_multiplier": parts.reshape(-1, 2),
        "special_kind": [KINDS.index(special.kind) for special in specials],
    }
