"""Bifurcation diagrams: the motions that a mechanism settles to, over one parameter or two.

At each value the motion is followed until it has settled, and then described. Upward and downward sweeps
start each point from where the motion of its neighbour stands, so that they stay on an attractor as long as
it exists: where they differ, motions coexist. A reset sweep starts each point from the same state. Period by
the spread of section points (analysis.period), contacts from located events, exponents by tangents with
saltation (analysis.lyapunov). Reference: Parker and Chua, Practical Numerical Algorithms for Chaotic Systems
(1989), chapter 8; Thompson and Stewart, Nonlinear Dynamics and Chaos (2002).

Validity: a sweep shows attractors only, those that its starts lead to, and a transient that dies out more
slowly than the turns dropped shows as no period.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import xarray as xr

from jointplay.analysis import ensemble as follows
from jointplay.analysis import request as asked
from jointplay.analysis.checks import refused, together, whole
from jointplay.analysis.starts import placed
from jointplay.analysis.sweeps.attractor import RTOL, TOLERANCE, Plan
from jointplay.analysis.sweeps.grid import LABELLED, Grid
from jointplay.analysis.sweeps.sweep import DIRECTIONS, Sweep
from jointplay.analysis.vary import Axis, axes, changed
from jointplay.analysis.words import recorded
from jointplay.errors import NOTHING, InputError, Problem, refuse
from jointplay.mechanism.records import CrankAngle, Mechanism, Section, TestSystem

USUAL = (
    *("journal_x", "journal_y", "eccentricity_ratio", "contact_angle", "normal_velocity"),
    *("tangential_velocity", "angular_velocity"),
)
ONCE_A_TURN = CrankAngle()
TURNS, TRANSIENT, LYAPUNOV_TURNS, KEEP = 300, 100, 200, 100


def bifurcation(
    mechanism: Mechanism | TestSystem,
    *,
    over: Mapping[str, Sequence[float]],
    section: Section = ONCE_A_TURN,
    record: Sequence[str] | None = None,
    turns: int = TURNS,
    transient: int = TRANSIENT,
    direction: str | Sequence[str] = "up",
    starts: Sequence[Any] | None = None,
    exponents: int = 0,
    lyapunov_turns: int = LYAPUNOV_TURNS,
    tolerance: float = TOLERANCE,
    keep: int = KEEP,
    rtol: float = RTOL,
    initial: Any = None,
    max_steps: int | None = None,
    ensemble: bool = False,
    n_jobs: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Describe the motions that a mechanism settles to, over one parameter or two.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        What moves.
    over : mapping of str to sequence of float
        One parameter or two with their values, in any order: changes of the mechanism (``clearance``,
        ``gear_ratio``, ``friction``, ...), parameters of a test system, or key paths into the record
        (``joints.B.contact.stiffness``, ``links.coupler.mass``). SI units.
    section : Section
        Where the motion is cut; once a turn at crank angle 0 if left out.
    record : sequence of str, optional
        Quantities kept at section points; places and speeds of the journals and speeds of the links if left
        out, of a test system its state.
    turns, transient : int
        Turns of the crank (nominal, where the section is no crank angle) or periods of the forcing that are
        looked at, and those dropped before, at each point.
    direction : {"up", "down", "reset"} or several of them
        Along the last parameter: each point from its neighbour's end, upward or downward; or each from the
        given start.
    starts : sequence, optional
        Several initial states, in place of `initial`.
    exponents : int
        How many leading Lyapunov exponents are computed at each point, from its end on.
    lyapunov_turns : int
        Nominal turns over which they are averaged.
    tolerance : float
        Spread of section points that count as one: of journals, as a fraction of the clearance; of a linkage
        without clearance, in radians (longest links) and nominal speeds; of a test system, in its own units.
    keep : int
        Section points stored of each point: the last ones.
    rtol : float
        Tolerated error of a step. The default, 1e-7, keeps section points of a periodic motion within 1e-5 of
        a clearance of each other, and costs four fifths of 1e-8.
    initial : optional
        As in `simulate`; a whole state vector, as ``end_state``, too.
    max_steps : int, optional
        Attempted steps of each run after which a point fails with status ``step_limit``.
    ensemble : bool
        Follow eight points of a reset sweep at once: of a rigid linkage of three links and a motor with
        clearance in one joint, at an rtol of 1e-8 or more. Two to three times as fast; by another method,
        whose numbers differ within the tolerance, and do not depend on which points run beside each other.
    n_jobs : int, optional
        Worker processes, 2 if left out. Sweeps up and down run one point after another, so that there are as
        many cells as directions, starts and values of the other parameter. The result does not depend on it.
    progress : callable, optional
        Called with the fraction done.

    Returns
    -------
    xarray.Dataset
        Over the varied parameters, each under the last part of its key, ``direction``, and ``start`` where
        there are several: the recorded quantities over ``point`` (stored section points; NaN where there were
        fewer); ``period`` in section points (turns, where the section is a crank angle; 0: none found within
        ``period_tolerance``, -1: not known); ``impacts`` and ``separations`` a turn, ``contact_fraction``,
        ``smallest_impact_speed`` and ``smallest_missed_gap`` (grazing shows as either near 0) over ``joint``,
        of a test system over all its contacts; ``mode_word`` (see `contacts.words`); ``end_state`` over
        ``state``; ``lyapunov_exponent`` and ``lyapunov_standard_error`` (1/s and per turn) over ``exponent``;
        ``cell_status``, ``trouble`` and ``n_steps``, and ``status``, the first that is not ok. A point that
        failed has NaN, its status and a reason; the next one of an up or down sweep then starts from the last
        good end.

    Raises
    ------
    InputError
        If anything asked for makes no sense, listing all of it; numerical trouble is a status instead.
    """
    keywords = {
        "over": over,
        "section": section,
        "record": record,
        "turns": turns,
        "transient": transient,
        "direction": direction,
        "starts": starts,
        "exponents": exponents,
        "tolerance": tolerance,
        "lyapunov_turns": lyapunov_turns,
        "keep": keep,
        "rtol": rtol,
        "initial": initial,
        "ensemble": ensemble,
    }
    sweep = planned(mechanism, **keywords, max_steps=max_steps)
    return assembled(sweep, sweep.run(n_jobs, progress))


def planned(
    mechanism: Mechanism | TestSystem,
    *,
    over: Mapping[str, Sequence[float]],
    section: Section = ONCE_A_TURN,
    record: Sequence[str] | None = None,
    turns: int = TURNS,
    transient: int = TRANSIENT,
    direction: str | Sequence[str] = "up",
    starts: Sequence[Any] | None = None,
    exponents: int = 0,
    lyapunov_turns: int = LYAPUNOV_TURNS,
    tolerance: float = TOLERANCE,
    keep: int = KEEP,
    rtol: float = RTOL,
    initial: Any = None,
    max_steps: int | None = None,
    ensemble: bool = False,
) -> Sweep:
    """Check the keywords of `bifurcation`, and say which motions are to be followed."""
    asked.check(mechanism, turns, None, transient, rtol, max_steps)
    counts = (turns, transient, keep, tolerance, exponents, lyapunov_turns)
    plan = Plan(section, (), *counts, rtol, max_steps, ensemble)
    directions = (direction,) if isinstance(direction, str) else tuple(direction)
    begun = (initial,) if starts is None else tuple(starts)
    wrong = _problems(plan, directions, initial, starts)
    together(lambda: _two(axes(mechanism, over)), lambda: refused(wrong))
    varied = axes(mechanism, over)
    model = usual(mechanism, {axis.key: axis.values for axis in varied})
    places = [partial(_placed, model, begun, i, section) for i in range(len(begun))]
    together(lambda: names(record, model), lambda: refused(alone(model, ensemble, rtol, directions)), *places)
    plan = replace(plan, record=names(record, model), keep=min(keep, turns))
    return Sweep(mechanism, varied, directions, begun, plan)


def _problems(plan: Plan, directions: tuple[Any, ...], initial: Any, starts: Any) -> Iterator[Problem]:
    least = {"turns": 1, "transient": 0, "keep": 1, "exponents": 0, "lyapunov_turns": 1}
    for key, smallest in least.items():
        yield from whole(key, getattr(plan, key), smallest)
    if not (isinstance(plan.tolerance, int | float) and 0 < plan.tolerance < math.inf):
        yield Problem("tolerance", plan.tolerance, "a number greater than 0 is accepted")
    for i, each in enumerate(directions):
        if each not in DIRECTIONS or each in directions[:i]:
            key = f"direction[{i}]" if len(directions) > 1 else "direction"
            yield Problem(key, each, f"one of {', '.join(DIRECTIONS)}, or several, each once, is accepted")
    if not directions or (starts is not None and not len(starts)):
        key = "starts" if directions else "direction"
        yield Problem(key, NOTHING, "a list of at least one is accepted")
    if starts is not None and initial is not None:
        yield Problem("initial", initial, "either starts or initial is accepted, not both")


def alone(model: Mechanism | TestSystem, ensemble: bool, rtol: float, directions: Any) -> list[Problem]:
    """What forbids to follow several points at once, where that is asked for."""
    if ensemble is True and {*directions} != {"reset"}:
        return [Problem("ensemble", True, "true is accepted where the only direction is reset")]
    return follows.refused(model, ensemble, rtol)


def _two(varied: tuple[Axis, ...]) -> None:
    if len(varied) > 2:
        raise refuse([axis.key for axis in varied], "one parameter or two are accepted", "over")


def usual(mechanism: Mechanism | TestSystem, over: Mapping[str, Sequence[float]]) -> Mechanism | TestSystem:
    """Give the mechanism of the largest values, against which keywords are checked; itself if it is none."""
    try:
        return changed(mechanism, {key: max(values) for key, values in over.items()})
    except InputError:
        return mechanism


def names(record: Sequence[str] | None, model: Mechanism | TestSystem) -> tuple[str, ...]:
    """Names of the quantities kept at section points: those asked for, checked, or the usual ones.

    Raises
    ------
    InputError
        Naming every quantity that the mechanism cannot have.
    """
    if record is None and isinstance(model, Mechanism):
        return tuple(name for name in USUAL if name in recorded(None, model))
    return recorded(record, model, integrals=False)


def _placed(model: Mechanism | TestSystem, begun: tuple[Any, ...], i: int, section: Section) -> None:
    """Refuse a start that makes none, in the words of the keyword that it came by."""
    try:
        placed(model, begun[i], section)
    except InputError as error:
        own = "initial" if len(begun) == 1 else f"starts[{i}]"
        tails = ((p, p.key.removeprefix("initial")) for p in error.problems)
        raise InputError(p if tail == p.key else replace(p, key=own + tail) for p, tail in tails) from None


def assembled(sweep: Sweep, answers: Mapping[Any, dict[str, Any]]) -> xr.Dataset:
    """Make the dataset of `bifurcation` of what was found at each point, by its index."""
    grid = Grid(sweep.dims, sweep.shape, sweep.plan.keep, answers)
    variables = grid.variables
    spread = {"units": "1", "long_name": "spread of section points that count as one"}
    variables["period_tolerance"] = ((), float(sweep.plan.tolerance), spread)
    coords = {
        axis.name: (axis.name, np.array(axis.values, dtype=float), axis.attributes) for axis in sweep.axes
    }
    coords["direction"] = ("direction", np.array(sweep.directions), {"long_name": "direction of the sweep"})
    numbered = {
        "start": (len(sweep.starts), "number of the start"),
        "point": (sweep.plan.keep, "section point"),
        "exponent": (sweep.plan.exponents, "number of the exponent"),
    }
    used = {dim for dims, *_ in variables.values() for dim in dims}
    for dim, (n, name) in numbered.items():
        if dim in used:
            numbers = np.arange(n) + (dim == "exponent")
            coords[dim] = (dim, numbers, {"units": "1", "long_name": name})
    for dim, names in grid.labels.items():
        if dim in used:
            coords[dim] = (dim, np.array(names, dtype=str), {"long_name": LABELLED[dim]})
    found = xr.Dataset(variables, coords, {"Conventions": "CF-1.11", "kind": "bifurcation"})
    return found if len(sweep.starts) > 1 else found.isel(start=0, drop=True)
