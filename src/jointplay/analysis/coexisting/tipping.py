"""Tipping of motions into others: smallest knocks, times to return, basins in finite time, edge states.

The motions are found from starts at random, as in `attractors`. Each is knocked (`coexisting.knocks`) until
it ends elsewhere (`coexisting.smallest`). The boundary that the smallest knock just crosses is followed to
the state that is on it (`coexisting.edge`). Finite-time basin stability is the fraction of the starts that
come within the tolerance of a motion in so many turns; of periodic motions alone. Reference: P. Schultz,
P. J. Menck, J. Heitzig and J. Kurths, New J. Phys. 19 (2017) 023005.

Validity: as of the parts. Of systems that nothing forces, knocks are at section points alone. With a
prescribed speed of the crank, knocks are at the section alone.
"""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, Unpack

import numpy as np
from pydantic import Field

from jointplay.analysis import rules
from jointplay.analysis.cells import first_bad, growing, handed_out, warm
from jointplay.analysis.coexisting import passes, tipping_dataset
from jointplay.analysis.coexisting.edge import Boundary, edge_state
from jointplay.analysis.coexisting.knocks import knocks
from jointplay.analysis.coexisting.lasting import STRETCH, Motions
from jointplay.analysis.coexisting.point_impulses import Impulse, impulses_fit
from jointplay.analysis.coexisting.recognised import Lasting
from jointplay.analysis.coexisting.region import Region, coordinate_rules, drawn
from jointplay.analysis.coexisting.smallest import Knocked, smallest
from jointplay.analysis.keywords import JointName, Moving, Settling, analysis
from jointplay.analysis.labels import outcome
from jointplay.analysis.orbits.section_map import section_map
from jointplay.analysis.period import REPEATS
from jointplay.analysis.starts import crank_place
from jointplay.analysis.states.ends import Observation, features, section_states
from jointplay.analysis.states.start_plane import Starts, section_of
from jointplay.analysis.tangents import warm_tangents
from jointplay.jobs.job import Entry
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.base import Count, Few, Flag, Natural, Positive, accepts, unit
from jointplay.solver.mechanism.records import CrankAngle
from jointplay.solver.motion.ensemble_runs import ensemble_fits, in_lanes
from jointplay.solver.motion.looks import part

if TYPE_CHECKING:
    import xarray as xr

STARTS, PHASES, DIRECTIONS, STEPS, EDGE_TURNS = 200, 8, 8, 16, 60
TURNS, PATIENCE, TOLERANCE = 64, 4, 1e-3
SHARES = (0.5, 0.9, 0.99)  # of the smallest knock, after which the time to return is measured
CLOUD = 4  # section points of a motion without period that are knocked
EDGE_RTOL = 1e-11


@growing
@analysis(coordinate_rules, impulses_fit, rules.start_fits, rules.turns_alike, ensemble_fits)
def tipping(
    mechanism: Moving,
    *,
    region: Region,
    joint: JointName | None = None,
    starts: Annotated[Natural, Field(le=10**6)] = STARTS,
    seed: Count = 0,
    impulses: Annotated[Few[Impulse], accepts("a list of impulses, each a table,")] = (),
    largest: Annotated[Positive, unit("largest knock", "1")] = 1.0,
    steps: Natural = STEPS,
    phases: Natural = PHASES,
    directions: Annotated[Natural, Field(ge=2)] = DIRECTIONS,
    edge: Flag = True,
    edge_turns: Natural = EDGE_TURNS,
    turns: Annotated[Natural, Field(ge=REPEATS)] = TURNS,
    patience: Count = PATIENCE,
    tolerance: Annotated[Positive, unit("tolerance", "1")] = TOLERANCE,
    ensemble: Flag | None = None,
    n_jobs: Natural | None = None,
    **motion: Unpack[Settling],
) -> xr.Dataset:
    """Find the smallest knocks that throw motions into others, and the states between them.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        What moves.
    region, joint, starts, seed
        As in `attractors`: where the motions are sought.
    impulses : sequence of Impulse
        Impulses on points of links that are tried too, each a table of ``name``, ``on`` (a table of ``link``
        and ``at``, m from its origin), ``direction`` (rad; each is tried if left out) and ``fixed``, in what
        the direction is fixed: ``"ground"`` or ``"link"``.
    largest : float
        Largest knock that is tried: of a moment, what changes the link's speed by so many nominal speeds; of
        an impulse on a point, what gives that so many nominal speeds times the mechanism's reach; of a shift
        of the journal, in clearances; of a test system's state, in its own units.
    steps : int
        Even sizes up to it that are tried before the smallest is halved in.
    phases, directions : int
        Even phases of a turn at which, and even directions in which knocks are tried.
    edge : bool
        Whether the edge states are sought.
    edge_turns : int
        Turns for which a boundary is followed.
    turns, patience, tolerance, ensemble, n_jobs
        As in `basins`.
    initial : optional
        As in `lyapunov`: the start that the region goes through.

    Returns
    -------
    xarray.Dataset
        Over ``number``, the motions: ``period``, ``count``, ``fraction`` with its 95 % interval,
        ``section_state`` over ``point`` and ``state``; ``fraction_reached`` over ``within``, turns. Over
        ``number`` and ``knock``: ``knock_size`` (NaN: none up to the largest tips) and ``knock_safe``, up to
        which each knock tried at that place returned, in ``knock_units``; ``knock_phase`` (rad),
        ``knock_direction`` (rad; 0 and pi are the two signs), ``knock_point``; ``knock_reaches``, and
        ``below_reaches`` and ``above_reaches`` at 0.99 and 1.01 of it (-1: not settled), by which it is
        ``knock_confirmed``; ``confirmed_size``, the smallest there that is, up to 1.2 of it (NaN: none);
        ``tipping_share`` of even sizes from it to 1.2 of it (NaN if it is confirmed); ``tried_reaches``
        over ``tried_share``; ``return_turns`` over ``knock_share``. Of each, the ``edge_period`` (0: none
        found) of the state on the boundary that it crosses, ``edge_period_time``, ``edge_state``,
        ``edge_multiplier`` over ``part``, ``edge_residual``.
        ``status``.

    Raises
    ------
    InputError
        If anything asked for makes no sense; numerical trouble is a status instead.
    """
    import xarray as xr

    began = time.perf_counter()
    initial, progress, limits = motion["initial"], motion["progress"], (motion["rtol"], motion["max_steps"])
    ensemble = in_lanes(ensemble, mechanism, motion["rtol"], starts)
    observation = Observation(motion["transient"], turns, patience, tolerance, *limits, ensemble)
    base = assemble(mechanism, initial, section_of(mechanism))
    warm([base], ensemble)
    if edge:
        warm_tangents(base)
    shared = {"mechanism": mechanism, "initial": initial, "observation": observation}
    seeds = {"region": region, "joint": joint, "starts": starts, "seed": seed}
    cells = [shared | seeds | {"changes": {}}]
    (seeded,) = handed_out(passes.found, cells, part(progress, 0.0, 0.3), n_jobs)
    motions = list(seeded.get("motions", ()))
    kinds = knocks(base, mechanism, impulses) if len(motions) > 0 else []
    known = [{key: each[key] for key in ("period", "states", "points")} for each in motions]
    cells = [shared | seeds | {"known": known}] if motions else []
    (times,) = handed_out(reached, cells, part(progress, 0.3, 0.4), n_jobs) or [{}]
    places = [(own, k) for own in range(len(motions)) for k in range(len(kinds))] if len(motions) > 1 else []
    search = {"known": known, "largest": largest, "steps": steps, "phases": phases, "directions": directions}
    search |= {"edge_turns": edge_turns if edge else 0, "impulses": impulses}
    cells = [shared | search | {"own": own, "knock": k} for own, k in places]
    answers = handed_out(knocked, cells, part(progress, 0.4, 1.0), n_jobs)
    table = tipping_dataset.Table(base, motions, seeded, kinds, starts)
    found = dict(zip(places, answers, strict=True))
    variables = table.motions_found(times) | table.knocks_found(found, SHARES) | table.edges_found(found)
    status = first_bad([seeded, times, *answers])
    return xr.Dataset(
        variables | outcome(status, began),
        table.coordinates(SHARES),
        {"Conventions": "CF-1.11", "kind": "tipping"},
    )


def _motions(mechanism, initial, known: Sequence[Mapping[str, Any]], observation: Observation) -> Motions:
    base = assemble(mechanism, initial, section_of(mechanism))
    return Motions(base, observation, [Lasting(**each) for each in known])


def reached(mechanism, initial, observation, known, region, joint, starts: int, seed: int) -> Entry:
    """Numbers of starts that are with each motion after so many turns."""
    place, motions = (
        Starts(mechanism, initial, tuple(region), joint),
        _motions(mechanism, initial, known, observation),
    )
    labels = motions.sort(place.all(drawn(region, starts, seed, 0.0)))
    within = np.arange(STRETCH, observation.transient + 1, STRETCH)
    there = (motions.turns[:, None] >= 0) & (motions.turns[:, None] <= within[None])
    counts = [(there & (labels == n)[:, None]).sum(axis=0) for n in range(len(known))]
    return {"status": 0, "within": within, "counts": np.array(counts)}


def knocked(
    mechanism, initial, observation, known, own: int, knock: int, largest: float, steps: int, phases: int,
    directions: int, edge_turns: int, impulses: Sequence[Impulse],
) -> Entry:  # fmt: skip
    """The smallest knock of a kind that tips a motion, times to return from less, and the edge state."""
    motions = _motions(mechanism, initial, known, observation)
    base, states = motions.base, known[own]["states"]
    points = states if known[own]["period"] else states[:: max(1, len(states) // CLOUD)][:CLOUD]
    forced, angle = section_of(mechanism) is not None, CrankAngle(angle=base.crank_angle)
    turning = forced and not (base.links and crank_place(base) is None)
    clock = base if forced else replace(base, crank_speed=math.tau / base.period)  # its phase is time
    section = section_map(clock, angle, 1, min(observation.rtol, EDGE_RTOL), observation.max_steps)
    cut = None if forced else partial(assemble, mechanism, initial)
    kind = knocks(base, mechanism, impulses)[knock]
    case = Knocked(motions, own, points, section if turning else None, kind)
    sizes = largest * np.arange(1, steps + 1) / steps
    found = smallest(case, phases, directions, sizes)
    if found is None:
        return {"status": 0}
    answer = {
        "status": 0,
        "size": found.high * kind.unit,
        "safe": found.safe * kind.unit,
        "confirmed": found.confirmed * kind.unit,
        "share": found.share,
        "place": list(found.place),
        "ends": list(found.ends),
    }
    answer["returns"] = [returned(case, found.place, share * found.high) for share in SHARES]
    if edge_turns and (orbit := _edge(case, found, section, edge_turns, cut)) is not None:
        answer |= tipping_dataset.edge_entry(orbit, base)
    return answer


def _edge(case: Knocked, found, section, turns: int, cut):
    """The edge state on the boundary that a knock crosses."""
    pair = [case.start(found.place, size) for size in (found.low, found.high)]
    if any(each is None for each in pair):
        return None
    inside, outside = (each.state for each in pair)
    return edge_state(Boundary(case.motions, case.own, section, inside, outside, cut), turns)


def returned(case: Knocked, place, size: float) -> int:
    """Turns after a knock until a motion is with its periodic self again, to stay; -1: not in time."""
    motion, motions, start = case.motions.known[case.own], case.motions, case.start(place, size)
    if start is None or not motion.period:
        return -1
    how = motions.observation
    how = Observation(0, how.transient + how.turns, 0, how.tolerance, how.rtol, how.max_steps)
    ((states, status, _),) = section_states(motions.base, [start], 0, how)
    if status:
        return -1
    apart = np.abs(features(motions.base, states)[:, None, :] - motion.points[None]).max(axis=-1).min(axis=1)
    away = np.flatnonzero(apart > how.tolerance)
    last = int(away[-1]) + 1 if len(away) else 0
    return -1 if last == len(apart) else last + 1
