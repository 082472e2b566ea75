"""Branches of periodic orbits over a parameter, stable or not, with the points at which they change.

From one orbit (as `periodic_orbit` finds it) its branch is followed both ways by pseudo-arclength
(arclength, branch); folds, branch points, period doublings, Neimark-Sacker bifurcations and grazings are
located on it (branch_points); from period doublings and branch points the branches that leave are followed
too. Validity: within a piece of a branch all orbits have the same events; where an impact with a rigid wall
appears at grazing the map has a square-root singularity, and the branch ends there.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import lru_cache
from itertools import count
from typing import Annotated, Any, Unpack

import numpy as np

from jointplay.analysis import rules
from jointplay.analysis.declared import Outputs
from jointplay.analysis.evaluate import needed
from jointplay.analysis.keywords import Moving, Names, Settling, Small, Text, analysis
from jointplay.analysis.labels import Out, along, ended, units, xr
from jointplay.analysis.orbits import branch_dataset, orbit_dataset
from jointplay.analysis.orbits.arclength import first
from jointplay.analysis.orbits.branch import WHY, Branch, Tracer
from jointplay.analysis.orbits.branch_dataset import (
    DIMS,
    annotated,
    coordinate_outs,
    end_outs,
    grazed_outs,
    sloped,
)
from jointplay.analysis.orbits.branch_points import KINDS, Special, departures
from jointplay.analysis.orbits.family import Family, Point
from jointplay.analysis.orbits.orbit_dataset import ORBIT, Range, Tolerance, branch_fits, started
from jointplay.analysis.orbits.periodic_orbit import RTOL
from jointplay.analysis.orbits.section_map import SectionMap, section_map
from jointplay.analysis.orbits.shooting import ITERATIONS, TOLERANCE, Orbit, Search, search
from jointplay.analysis.quantities import recorded
from jointplay.analysis.starts import placed
from jointplay.analysis.vary import axes
from jointplay.display import codes
from jointplay.display.number_text import listed, measured, plain
from jointplay.solver.mechanism.base import Flag, Natural, Number, unit
from jointplay.solver.mechanism.parameters import Parameter
from jointplay.solver.mechanism.records import ONCE_A_TURN, Mechanism, Section
from jointplay.solver.motion.progress import Aborted, Stopped
from jointplay.solver.motion.trajectory import INTERRUPTED

STEP = 0.02
LISTED = 3  # special points named in a line
MAX_POINTS, MAX_BRANCHES = 400, 4


def answer(result: xr.Dataset) -> str:
    """The extent of the branches, the reasons of their ends, and the special points on them."""
    name = str(result.attrs["parameter"]).rpartition(".")[2]
    if not np.isfinite(result["period"].values).any():
        return "no periodic orbit was found to begin with"
    lines = [_branch(result, name, b) for b in range(min(result.sizes["branch"], LISTED - 1))]
    if more := result.sizes["branch"] - len(lines):
        lines[-1] += f"; {more} more branches"
    return "\n".join([*lines, _special(result)])


def _branch(result: xr.Dataset, name: str, b: int) -> str:
    one = result.isel(branch=b)
    values = one[name].values[: int(one["n_points"])]
    ends, stable = codes.words(one["branch_end"]).values, codes.words(one["stable"]).values[: len(values)]
    places = zip(values[[0, -1]], ends, strict=True)
    texts = [f"ended at {measured(v, result[name])}: {WHY.get(end, end)}" for v, end in places]
    if ends[0] == ends[1] == "range":
        low, high = (measured(end, result[name]) for end in (values.min(), values.max()))
        texts = [f"over the whole range, {low} to {high}"]
    share = np.count_nonzero(stable == "stable")
    how = "stable" if share == len(values) else f"stable at {share} of {len(values)} points"
    period = plain(float(np.nanmax(one["period"].values)), 4)
    return f"branch {b + 1}, period {period}, {how}: {' and '.join(texts)}"


def _special(result: xr.Dataset) -> str:
    if not result.sizes["special"]:
        several = result.sizes["branch"] > 1
        return "no bifurcation and no grazing was found on them" if several else "no bifurcation was found"
    kinds, places = codes.words(result["special_kind"]).values, result["special_parameter"]
    bifurcations = np.flatnonzero(kinds != "grazing")
    named = [f"{kinds[i].replace('_', ' ')} at {measured(places[i], places, 6)}" for i in bifurcations]
    parts = [listed(named, LISTED, ", ")] * bool(named)
    if grazings := len(kinds) - len(named):
        parts.append(f"{grazings} grazings (an event appears or vanishes)")
    return ", ".join(parts)


JUMPED = "whether an impact passed the section since the point before"
BENT = "whether the section's modes differ from those at the point before"
SLOPES = {
    name: replace(orbit_dataset.OUTS[name], long_name=sloped(text))
    for name, text in {
        **{name: orbit_dataset.OUTS[name].long_name for name in branch_dataset.NUMBERS},
        "orbit_state": "state on the section",
    }.items()
}
OUTPUTS = Outputs(
    "continuation",
    orbit_dataset.COORDS | coordinate_outs("branch"),
    along(orbit_dataset.OUTS, *DIMS)
    | {
        "QUANTITY": Out((*DIMS, "turn"), "what `record` asks for, and its derivative along the branch", ""),
        "PARAMETER_tangent": Out(DIMS, sloped("parameter"), ""),
    }
    | {f"{name}_tangent": out for name, out in along(SLOPES, *DIMS).items()}
    | {"arc_scale": Out("state", "change of a state over a unit of the arc")}
    | end_outs("branch")
    | {
        "branch_parent": Out("branch", "branch that it leaves; -1: found from the start"),
        "special_branch": Out("special", "branch of a special point"),
        "special_point": Out("special", "its point on the branch"),
        "special_parameter": Out("special", "parameter there", "{units}"),
        "special_accuracy": Out("special", "how closely the parameter is enclosed", "{units}"),
    }
    | grazed_outs("special", "appears or vanishes at a grazing")
    | {
        "special_state": Out(("special", "state"), "state on the section there"),
        "special_multiplier": Out(("special", "part"), "multiplier that makes the change"),
        "special_kind": Out("special", "what changes there", flags=KINDS),
        "section_jump": Out(DIMS, JUMPED, flags=("no", "yes")),
        "section_event": Out(DIMS, BENT, flags=("no", "yes")),
        "PARAMETER": Out(DIMS, "the parameter", ""),
    }
    | orbit_dataset.SOUGHT,
    answer,
)


@analysis(*ORBIT, branch_fits, usual={"rtol": RTOL}, outputs=OUTPUTS, left_out=rules.RANGE, model=started)
def continuation(
    mechanism: Moving,
    section: Section = ONCE_A_TURN,
    *,
    parameter: Text = "clearance",
    range: Range,
    start: Number | None = None,
    period: Natural = 1,
    step: Annotated[Small, unit("longest step", "1")] = STEP,
    max_points: Natural = MAX_POINTS,
    branch_switching: Flag = True,
    max_branches: Natural = MAX_BRANCHES,
    tolerance: Tolerance = TOLERANCE,
    record: Names | None = None,
    **motion: Unpack[Settling],
) -> xr.Dataset:
    """Follow a periodic orbit over a parameter, and the orbits that branch off.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        What moves.
    section : CrankAngle or Plane
        As in `periodic_orbit`.
    parameter : str
        Parameter over which the orbit is followed, by name (``clearance``, ``gear_ratio``, ``gap``, …) or by
        key path, as in `bifurcation`.
    range : pair of float
        Lowest and highest value of the parameter, in SI units; half and twice a linkage's own if left out.
    start : float, optional
        Value of the parameter at which the first orbit is sought; the mechanism's own if left out.
    period, initial, transient, tolerance
        As in `periodic_orbit`, of the first orbit.
    step : float
        Longest step, as a fraction of the parameter's range, and of the orbit alike.
    max_points : int
        Largest number of points of a branch.
    branch_switching : bool
        Whether branches that leave at period doublings and branch points are followed.
    max_branches : int
        Largest number of branches.
    record : sequence of str, optional
        Quantities that are kept on the section; all if left out.
    progress : callable, optional
        Called with the fraction done, of at most `max_branches` branches of `max_points` points.

    Raises
    ------
    InputError
        If anything asked for makes no sense; numerical trouble is a status instead.
    """
    value = Parameter(mechanism, parameter).value if start is None else start
    (axis,) = axes(mechanism, {parameter: list(range)}, "range")
    names, began = recorded(record, mechanism), time.perf_counter()
    limits, progress = (motion["rtol"], motion["max_steps"]), motion["progress"]

    @lru_cache(maxsize=64)  # Newton's method comes back to the neighbours of a value
    def maps(value: float) -> SectionMap:
        model = placed(rules.varied(mechanism, {parameter: float(value)}), None, section)
        return section_map(model, section, period, *limits)

    at_start = placed(rules.varied(mechanism, {parameter: value}), motion["initial"], section)
    requested = section_map(at_start, section, period, *limits)
    orbit = search(requested, Search(motion["transient"], tolerance, ITERATIONS))
    family = Family(maps, float(range[0]), float(range[1]), tolerance)
    passages, visited = branch_dataset.Passages(requested.phase, needed(at_start, names), family), count(1)
    most = max_branches if branch_switching else 1

    def visit(point: Point) -> None:
        passages.of(point)
        if progress is not None:
            progress(min(1.0, next(visited) / (max_points * most)))

    branches = Explorer(family, step, max_points, most, visit).explore(orbit, family.fraction(value))
    values, groups = branch_dataset.values_of(branches, family, axis, passages, names)
    stopped = any("interrupted" in branch.ends for branch in branches)
    values |= ended(INTERRUPTED if stopped else orbit.status, began)
    of = {"units": axis.units} | units(isinstance(mechanism, Mechanism))
    found = OUTPUTS.dataset(values, of, requested.model, groups=groups, parameter=axis.name, **orbit.trouble)
    return annotated(found, requested.model)


@dataclass
class Explorer:
    """The branch of an orbit, traced both ways, and the branches that leave it and one another.

    Parameters
    ----------
    family : Family
        Of maps.
    step : float
        Longest step, as a fraction of the parameter's range, and of the orbit alike.
    max_points, max_branches : int
        Points of a branch, and branches, at most.
    visit : callable
        Called with each point.
    """

    family: Family
    step: float
    max_points: int
    max_branches: int
    visit: Callable[[Point], Any] = lambda point: None
    branches: list[Branch] = field(default_factory=list, init=False)

    def explore(self, orbit: Orbit, q: float) -> list[Branch]:
        """Branches from an orbit at a fraction q of the parameter's range on."""
        if orbit.status:
            return [_lone(orbit, q, "not_converged")]
        try:
            for branch in self._traced(orbit, q):
                self.branches.append(branch)
                if "interrupted" in branch.ends:
                    break
        except (Stopped, Aborted):  # between two branches
            self.branches = self.branches or [_lone(orbit, q, "interrupted")]
            self.branches[-1] = replace(self.branches[-1], ends=(self.branches[-1].ends[0], "interrupted"))
        return self.branches

    def _traced(self, orbit: Orbit, q: float) -> Iterator[Branch]:
        """The branches, one after another."""
        down, up = (first(self.family, orbit, q, sense) for sense in (-1.0, 1.0))
        back = self._follow(down, max(self.max_points // 2, 2))
        if "interrupted" in back.ends:
            yield back.reversed()
            return
        yield joined(back, self._follow(up, max(self.max_points - len(back.points) + 1, 2)))
        number = 0
        while number < len(self.branches) < self.max_branches:
            for special in self.branches[number].specials:
                if len(self.branches) < self.max_branches and self._is_open(number, special):
                    yield from self._switched(number, special)
            number += 1

    def _follow(self, start: Point, most: int, doubled: bool = False) -> Branch:
        return Tracer(self.family, self.step, most, self.visit, doubled).follow(start)

    def _is_open(self, number: int, special: Special) -> bool:
        """Whether another branch leaves a special point, and none that has been traced ended there."""
        if special.kind not in ("period_doubling", "branch_point"):
            return False
        own = [branch for branch in self.branches if branch.parent == number and branch.ends[1] == "joined"]
        return not any(abs(special.q - branch.points[-1].q) < self.step for branch in own)

    def _switched(self, number: int, special: Special) -> Iterator[Branch]:
        """The branch that leaves a special point, of both its sides where it has two."""
        sides, doubled = [], special.kind == "period_doubling"
        for origin, point in departures(self.family, special, self.step):
            side = self._follow(point, self.max_points if doubled else max(self.max_points // 2, 2), doubled)
            if not doubled:  # the other branch's direction there is not known exactly
                origin = replace(origin, tangent=np.full_like(origin.tangent, np.nan))
            sides.append(replace(side, points=[origin, *side.points], parent=number))
            if "interrupted" in side.ends:
                break
        yield from [joined(*sides)] if len(sides) == 2 else sides


def _lone(orbit: Orbit, q: float, end: str) -> Branch:
    """A branch of one point, which ends there."""
    return Branch([Point(orbit, q, 1.0, np.zeros(len(orbit.map.free) + 1))], [], (end, end))


def joined(back: Branch, forth: Branch) -> Branch:
    """One branch of two halves that start at the same point."""
    turned, begin = back.reversed(), forth.points[0]
    at_begin = [
        replace(each, point=begin) if each.point is turned.points[-1] else each for each in turned.specials
    ]
    points, ends = turned.points[:-1] + forth.points, (turned.ends[0], forth.ends[1])
    return replace(forth, points=points, specials=at_begin + forth.specials, ends=ends)
