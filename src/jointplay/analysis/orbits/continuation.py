"""Branches of periodic orbits over a parameter, stable or not, with the points at which they change.

From one orbit (as `periodic_orbit` finds it) its branch is followed both ways by pseudo-arclength
(arclength, branch); folds, branch points, period doublings, Neimark-Sacker bifurcations and grazings are
located on it (branch_points); from period doublings and branch points the branches that leave are followed
too. Validity: within a piece of a branch orbits have the same events; where an impact with a rigid wall
appears at grazing the map has a square-root singularity, and the branch ends there.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import count
from typing import Annotated, Any

import numpy as np
import xarray as xr

from jointplay.analysis.evaluate import dataset, flags
from jointplay.analysis.keywords import Moving, Names, Progress, Rtol, Small, Start, Text, analysis
from jointplay.analysis.looks import Late, Stopped
from jointplay.analysis.orbits import branch_dataset
from jointplay.analysis.orbits.arclength import Family, Point, cached, first
from jointplay.analysis.orbits.branch import Branch, Tracer
from jointplay.analysis.orbits.branch_points import Special, departures
from jointplay.analysis.orbits.orbit_request import ORBIT, Range, Tolerance, branch_fits, present
from jointplay.analysis.orbits.orbit_search import Search, search
from jointplay.analysis.orbits.periodic_orbit import ONCE_A_TURN, RTOL, TRANSIENT
from jointplay.analysis.orbits.section_map import SectionMap, section_map
from jointplay.analysis.orbits.shooting import ITERATIONS, TOLERANCE, Orbit
from jointplay.analysis.quantities import STATUS, recorded
from jointplay.analysis.rates import needed
from jointplay.analysis.starts import placed
from jointplay.analysis.trajectory import INTERRUPTED
from jointplay.analysis.vary import axes, changed
from jointplay.mechanism.base import Count, Flag, Natural, Number, unit
from jointplay.mechanism.records import Mechanism, Section

STEP = 0.02
MAX_POINTS, MAX_BRANCHES = 400, 4


@analysis(*ORBIT, branch_fits)
def continuation(
    mechanism: Moving,
    section: Section = ONCE_A_TURN,
    *,
    parameter: Text = "clearance",
    range: Range,
    start: Number | None = None,
    period: Natural = 1,
    initial: Start | None = None,
    transient: Count = TRANSIENT,
    step: Annotated[Small, unit("longest step", "1")] = STEP,
    max_points: Natural = MAX_POINTS,
    branch_switching: Flag = True,
    max_branches: Natural = MAX_BRANCHES,
    rtol: Rtol = RTOL,
    tolerance: Tolerance = TOLERANCE,
    record: Names | None = None,
    max_steps: Natural | None = None,
    progress: Progress = None,
) -> xr.Dataset:
    """Follow a periodic orbit over a parameter, and the orbits that branch off.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        What moves.
    section : CrankAngle or Plane
        As in `periodic_orbit`.
    parameter : str
        A number by name (``clearance``, ``gear_ratio``, ``gap``, …) or by key path, as in `bifurcation`.
    range : pair of float
        Lowest and highest value.
    start : float, optional
        Value at which the first orbit is looked for; the mechanism's own if left out.
    period, initial, transient, rtol, tolerance, max_steps
        As in `periodic_orbit`, of the first orbit.
    step : float
        Longest step: of the parameter as a fraction of its range, and of the orbit alike.
    max_points : int
        Points of a branch, at most.
    branch_switching : bool
        Whether branches that leave at period doublings and branch points are followed.
    max_branches : int
        Branches, at most.
    record : sequence of str, optional
        Quantities to keep on the section; all if left out.
    progress : callable, optional
        Called with the fraction done, of at most `max_branches` branches of `max_points` points.

    Returns
    -------
    xarray.Dataset
        Over ``branch`` and ``point``: the parameter, all numbers that `periodic_orbit` gives, and quantities
        on the section over ``turn`` of the orbit. Over ``special``: ``special_kind`` (fold, branch_point,
        period_doubling, neimark_sacker, grazing), ``special_parameter`` with its accuracy, branch and point,
        state, multiplier, and at a grazing the event that appears or vanishes. ``branch_end`` says why a
        branch ends. ``status`` is that of the first orbit, or interrupted (`jointplay run` then
        keeps the points that it has).

    Raises
    ------
    InputError
        If anything asked for makes no sense; numerical trouble is a status instead.
    """
    value = present(mechanism, parameter) if start is None else start
    (axis,) = axes(mechanism, {parameter: list(range)}, "range")
    names = recorded(record, mechanism)
    began = time.perf_counter()
    maps = partial(_map, mechanism, parameter, section, period, rtol, max_steps)
    at_start = placed(changed(mechanism, {parameter: value}), initial, section)
    home = section_map(at_start, section, period, rtol, max_steps)
    orbit = search(home, Search(transient, tolerance, ITERATIONS))
    family = Family(cached(maps), float(range[0]), float(range[1]), tolerance)
    most = max_branches if branch_switching else 1
    passages = branch_dataset.Passages(home.phase, needed(names))
    q = family.fraction(value)
    branches = explore(family, orbit, q, step, max_points, most, progress, passages.of)
    linkage = isinstance(mechanism, Mechanism)
    variables, coords = branch_dataset.variables(branches, family, axis, passages, names, linkage)
    stopped = any("interrupted" in branch.ends for branch in branches)
    status = INTERRUPTED if stopped else orbit.status
    variables["status"] = ((), np.int8(status), {"long_name": "how the search ended"} | flags(STATUS))
    seconds = {"units": "s", "long_name": "wall time of the run"}
    variables["wall_time"] = ((), time.perf_counter() - began, seconds)
    return dataset(home.model, variables, coords, "continuation").assign_attrs(parameter=axis.name)


def _map(mechanism, parameter, section, period, rtol, max_steps, value: float) -> SectionMap:
    model = placed(changed(mechanism, {parameter: float(value)}), None, section)
    return section_map(model, section, period, rtol, max_steps)


def explore(
    family: Family,
    orbit: Orbit,
    q: float,
    step: float,
    most: int,
    many: int,
    progress: Callable[[float], None] | None = None,
    taken: Callable[[Point], Any] = lambda point: None,
) -> list[Branch]:
    """The branch of an orbit, followed both ways, and those that leave it and one another.

    Parameters
    ----------
    family : Family
        Of maps.
    orbit : Orbit
        From which to start.
    q : float
        Fraction of the parameter's range at which it is.
    step : float
        Longest step.
    most, many : int
        Points of a branch, and branches, at most.
    progress : callable, optional
        Called with the fraction done.
    taken : callable
        Called with each point.
    """
    done, total = count(1), most * many

    def room(per_side: int) -> Callable[[Point], bool]:
        number = count(1)

        def more(point: Point) -> bool:
            taken(point)
            if progress is not None:
                progress(min(1.0, next(done) / total))
            return next(number) < per_side

        return more

    if orbit.status:
        return [_lone(orbit, q, "not_converged")]
    branches: list[Branch] = []
    try:
        for branch in _found(branches, family, orbit, q, step, most, many, room):
            branches.append(branch)
            if "interrupted" in branch.ends:
                break
    except (Stopped, Late):  # between two branches
        branches = branches or [_lone(orbit, q, "interrupted")]
        branches[-1] = replace(branches[-1], ends=(branches[-1].ends[0], "interrupted"))
    return branches


def _lone(orbit: Orbit, q: float, end: str) -> Branch:
    """A branch of one point, which ends there."""
    return Branch([Point(orbit, q, 1.0, np.zeros(len(orbit.map.free) + 1))], [], (end, end))


def _found(
    branches: Sequence[Branch],
    family: Family,
    orbit: Orbit,
    q: float,
    step: float,
    most: int,
    many: int,
    room,
) -> Iterator[Branch]:
    """The branches, one after another; `branches` are those that have been found."""
    starts = [first(family, orbit, q, upward) for upward in (False, True)]
    back = Tracer(family, step, room(max(most // 2, 2))).follow(starts[0])
    if "interrupted" in back.ends:
        yield back.reversed()
        return
    left = max(most - len(back.points) + 1, 2)
    yield joined(back, Tracer(family, step, room(left)).follow(starts[1]))
    number = 0
    while number < len(branches) < many:
        for special in branches[number].specials:
            if len(branches) < many and _open(branches, number, special, step):
                yield from _leaving(family, special, number, step, room, most)
        number += 1


def joined(back: Branch, forth: Branch) -> Branch:
    """One branch of two halves that start at the same point."""
    turned = back.reversed()
    return Branch(
        turned.points[:-1] + forth.points,
        turned.specials + forth.specials,
        (turned.ends[0], forth.ends[1]),
        forth.parent,
    )


def _open(branches: list[Branch], number: int, special: Special, step: float) -> bool:
    """Whether another branch leaves a special point, and none that has been followed ended there."""
    if special.kind not in ("period_doubling", "branch_point"):
        return False
    back = [each.points[-1].q for each in branches if each.parent == number and each.ends[1] == "joined"]
    return not any(abs(special.q - q) < step for q in back)


def _leaving(family: Family, special: Special, number: int, step: float, room, most: int) -> list[Branch]:
    """The branch that leaves a special point: both its sides, where it has two."""
    sides = []
    for origin, found in departures(family, special, step):
        halves = special.kind == "period_doubling"
        share = most if halves else max(most // 2, 2)
        side = Tracer(family, step, room(share), halves).follow(found)
        sides.append(replace(side, points=[origin, *side.points], parent=number))
        if "interrupted" in side.ends:
            break
    if len(sides) == 2:
        return [joined(*sides)]
    return sides
