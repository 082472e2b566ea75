"""Attractors over a parameter: coexisting lasting motions, and their probabilities.

At every value starts drawn at random in a region are followed until it is known where they end
(`coexisting.lasting`). Then every motion found is carried to the neighbouring values, until that brings up
nothing new; so one with a basin too narrow for the starts is found where a neighbour has it. Motions at
neighbouring values are given one identity (`coexisting.identity`). Each is described as a point of a sweep.
Reference for seeding, carrying and matching: G. Datseris, K. Luiz Rossi and A. Wagemakers, Chaos 33 (2023)
073151. Fractions: Wilson's interval (`states.basin_uncertainty`).

Validity: what neither a start nor a neighbour leads to is missed: with n starts, a basin of more than 3/n of
the region is found with 95 % (the rule of three). Fractions are of the region, and of no other.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any, Unpack

from pydantic import Field

from jointplay.analysis import rules
from jointplay.analysis.cells import first_bad, growing, handed_out, warm
from jointplay.analysis.coexisting import attractors_dataset, passes, special_points
from jointplay.analysis.coexisting.identity import identities
from jointplay.analysis.coexisting.region import Region, one_parameter, region_fits
from jointplay.analysis.keywords import JointName, Moving, Names, Settling, analysis
from jointplay.analysis.labels import outcome
from jointplay.analysis.period import REPEATS
from jointplay.analysis.states.ends import Observation
from jointplay.analysis.states.start_plane import section_of
from jointplay.analysis.sweeps.attractor import RTOL, Plan
from jointplay.analysis.sweeps.bifurcation import Over, lanes_fit, names, record_fits
from jointplay.analysis.tangents import warm_tangents
from jointplay.analysis.vary import Axis, at_largest, checked_axes, largest
from jointplay.display.errors import InputError
from jointplay.jobs.job import Entry
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.base import Count, Flag, Natural, Positive, unit
from jointplay.solver.mechanism.records import CrankAngle, Mechanism, TestSystem
from jointplay.solver.motion.ensemble_runs import in_lanes
from jointplay.solver.motion.looks import part

if TYPE_CHECKING:
    import xarray as xr

STARTS, TURNS, PATIENCE, LYAPUNOV_TURNS = 1000, 64, 4, 100
TOLERANCE, REACH = 1e-3, 0.2
ROUNDS = 200  # of carrying, at most
SHARES = (0.0, 0.7, 0.8, 1.0)  # of the progress: seeding, carrying, describing


def _start_fits(varied: Mechanism | TestSystem, initial: Any) -> None:
    rules.assembled_at(varied, initial)


@growing
@analysis(
    one_parameter,
    rules.each_alike,
    region_fits,
    record_fits,
    _start_fits,
    lanes_fit,
    varied=at_largest,
    usual={"rtol": RTOL},
)
def attractors(
    mechanism: Moving,
    *,
    over: Over,
    region: Region,
    joint: JointName | None = None,
    starts: Annotated[Natural, Field(le=10**6)] = STARTS,
    seed: Count = 0,
    carry: Flag = True,
    turns: Annotated[Natural, Field(ge=REPEATS)] = TURNS,
    patience: Count = PATIENCE,
    tolerance: Annotated[Positive, unit("tolerance", "1")] = TOLERANCE,
    reach: Annotated[Positive, unit("reach", "1")] = REACH,
    record: Names | None = None,
    exponents: Flag = True,
    lyapunov_turns: Natural = LYAPUNOV_TURNS,
    bifurcations: Flag = False,
    ensemble: Flag | None = None,
    n_jobs: Natural | None = None,
    **motion: Unpack[Settling],
) -> xr.Dataset:
    """Follow coexisting motions over a parameter, with their fractions of the starts.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        What moves.
    over : mapping of str to sequence of float
        One parameter with its values, as in `bifurcation`.
    region : mapping of str to (float, float)
        Coordinates of starts, as those of a plane of `basins`, each with its lowest and highest value.
    joint : str, optional
        Whose journal, as in `basins`.
    starts : int
        Starts at each value, drawn at random in the region.
    seed : int
        Which starts.
    carry : bool
        Whether motions are carried to neighbouring values, which finds those with narrow basins.
    turns, patience, tolerance
        As in `basins`. A start is left earlier where it has reached a motion that is known already, or where
        others show that it is bound for one.
    reach : float
        Largest distance of section points of motions at neighbouring values that are one, in the units of
        `tolerance`.
    record : sequence of str, optional
        Quantities kept at section points, as in `bifurcation`.
    exponents : bool
        Whether the largest exponent of each motion is computed.
    lyapunov_turns : int
        Nominal turns over which it is averaged.
    bifurcations : bool
        Whether periodic motions are followed as orbits, as by `continuation`, for what changes on them.
    ensemble, n_jobs
        As in `basins`.
    initial : optional
        As in `lyapunov`: the start that the region goes through.

    Returns
    -------
    xarray.Dataset
        Over the parameter and ``identity``: ``period`` (0: none; -1: the motion is not there), ``count`` of
        the starts that reach it and their ``fraction`` with the 95 % interval ``fraction_low`` to
        ``fraction_high``, ``carried`` (1: no start reached it), ``watched_turns`` of a motion without period,
        ``section_distance`` from the same at the value before; the recorded quantities over ``point``,
        contacts a turn, exponents and ``end_state`` as in `bifurcation`. Over the parameter: ``started``,
        ``fraction_unsettled`` with its interval, ``fraction_failed``, ``fraction_missed`` (a motion with a
        larger basin is found with 95 %). Over ``change``: where identities begin and end, ``change_kind``,
        ``change_identity``, ``change_other``, and the values ``change_low``, ``change_high`` between which.
        With `bifurcations`, over ``special``: ``special_kind``, ``special_parameter``, ``special_identity``;
        ``change_bifurcation``, the one between the same values; ``branch_status`` of each orbit that was
        followed. ``attractor_status`` and ``trouble`` of each motion, ``value_status``, and ``status``.

    Raises
    ------
    InputError
        If anything asked for makes no sense, listing all of it; numerical trouble is a status instead.
    """
    began, (axis,) = time.perf_counter(), checked_axes(mechanism, over)
    varied = largest(mechanism, over)
    initial, rtol, max_steps = motion["initial"], motion["rtol"], motion["max_steps"]
    ensemble, settled = in_lanes(ensemble, varied, rtol, starts), (motion["transient"], turns)
    observation = Observation(*settled, patience, tolerance, rtol, max_steps, ensemble)
    plan = Plan(
        section=CrankAngle(),
        record=names(record, varied),
        turns=turns,
        transient=0,
        keep=turns,
        exponents=int(exponents),
        lyapunov_turns=lyapunov_turns,
        rtol=rtol,
        max_steps=max_steps,
    )
    changes = [{axis.key: value} for value in axis.values]
    shared = {"mechanism": mechanism, "initial": initial}
    tell = [part(motion["progress"], *pair) for pair in pairwise(SHARES)]
    seeds = {"region": region, "joint": joint, "starts": starts, "seed": seed, "observation": observation}
    cells = [shared | seeds | {"changes": each} for each in changes]
    ready = partial(_warm, mechanism, changes, initial, exponents, ensemble)
    seeded = handed_out(passes.found, cells, tell[0], n_jobs, lasting=axis.name, ready=ready)
    motions, ended = [list(each.get("motions", ())) for each in seeded], list(seeded)
    lands: dict[tuple[int, int, int], int] = {}
    if carry:
        states = [each.get("names", ()) for each in seeded]
        parts = [shared | {"changes": each, "observation": observation} for each in changes]
        ended += _carried(parts, motions, states, lands, tell[1], n_jobs)
    numbers, events, apart = identities(motions, lands, reach)
    places = [(i, n) for i, each in enumerate(motions) for n in range(len(each))]
    cells = [shared | {"changes": changes[i], "motion": motions[i][n], "plan": plan} for i, n in places]
    answers = handed_out(passes.described, cells, tell[2], n_jobs, lasting="motion", ready=ready)
    table = attractors_dataset.Table(axis, motions, numbers, apart, seeded, starts)
    found = table.dataset({(i, numbers[i][n]): a for (i, n), a in zip(places, answers, strict=True)}, plan)
    found = found.assign(table.fractions() | table.changes(events))
    if bifurcations:
        following, branches = _followed(shared, axis, motions, numbers, max_steps, n_jobs)
        found = found.assign(special_points.variables(axis, following, branches, events))
    return found.assign(outcome(first_bad([*ended, *answers]), began))


def _followed(shared, axis: Axis, motions, numbers, max_steps: int | None, n_jobs: int | None):
    """Follow periodic motions as orbits: the stretches followed, and the answers."""
    mechanism, section = shared["mechanism"], passes.section_at(shared["mechanism"], shared["initial"])
    following = special_points.stretches(axis, motions, numbers) if section is not None else []
    more = {"mechanism": mechanism, "parameter": axis.key, "section": section, "max_steps": max_steps}
    cells = [each | more for each in following]
    return following, handed_out(special_points.followed, cells, n_jobs=n_jobs, lasting="branch")


def _warm(mechanism, changes, initial, exponents: bool, ensemble: bool) -> None:
    """Compile the code that the first and the last value need."""
    for change in (changes[0], changes[-1]):
        try:
            here = mechanism.varied(change)
            model = assemble(here, initial, section_of(here))
        except InputError:
            continue  # its cell says so
        warm([model], ensemble)
        if exponents:
            warm_tangents(model)


def _carried(
    parts: list[dict[str, Any]],
    motions: list[list[dict]],
    states: list[Sequence[str]],
    lands: dict[tuple[int, int, int], int],
    progress: Callable[[float], None] | None,
    n_jobs: int | None,
) -> list[Entry]:
    """Carry motions to the neighbouring values until nothing new comes up: the answers.

    What is new is added to `motions`, and to `lands` where (value, motion, other value) ends there.
    """
    fresh, ended = [(i, n) for i, each in enumerate(motions) for n in range(len(each))], []
    for _ in range(ROUNDS):
        into = _neighbours(fresh, states)
        cells = [
            parts[j]
            | {"known": motions[j], "sources": [motions[i][n] | {"names": states[i]} for i, n in sources]}
            for j, sources in into
        ]
        if not cells:
            break
        answers = handed_out(passes.carried, cells, progress, n_jobs, lasting="value")
        fresh, ended = [], ended + answers
        for (j, sources), answer in zip(into, answers, strict=True):
            before = len(motions[j])
            motions[j] = [*motions[j], *answer.get("new", ())]
            fresh += [(j, n) for n in range(before, len(motions[j]))]
            for (i, n), ends in zip(sources, answer.get("lands", ()), strict=False):
                lands[i, n, j] = ends[0]
    return ended


def _neighbours(fresh: list[tuple[int, int]], states: list[Sequence[str]]):
    """Values to which motions are carried, ascending, each with its motions."""
    into: dict[int, list[tuple[int, int]]] = {}
    for i, n in fresh:
        for j in (i - 1, i + 1):
            if 0 <= j < len(states) and states[j]:
                into.setdefault(j, []).append((i, n))
    return sorted(into.items())
