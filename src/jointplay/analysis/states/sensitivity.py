"""Sensitivity to the start: neighbours that part from a motion, and exponents over a plane of starts.

`analysis.divergence` follows the neighbours, `analysis.field` the plane; each says how at its head.
"""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields
from inspect import signature
from typing import Any

import numpy as np
import xarray as xr

from jointplay.analysis import request as asked
from jointplay.analysis.checks import refused, whole
from jointplay.analysis.quantities import flags
from jointplay.analysis.states import plane as planes
from jointplay.analysis.states.divergence import Divergence
from jointplay.analysis.states.field import CRASHED, field
from jointplay.analysis.words import STATUS
from jointplay.errors import InputError, Problem
from jointplay.mechanism.records import Mechanism, TestSystem

NEIGHBOURS = 20
DISTANCE = 1e-9
RTOL = 1e-12  # so that the runs' own errors stay far below the distance
COMPARED = ("section", "time")


def sensitivity(
    mechanism: Mechanism | TestSystem,
    *,
    neighbours: int | None = None,
    references: int = 1,
    distance: float = DISTANCE,
    turns: int = 40,
    samples_per_turn: int = 1,
    transient: int = 0,
    compare: str | None = None,
    plane: Mapping[str, Any] | None = None,
    joint: str | None = None,
    rtol: float = RTOL,
    initial: Any = None,
    seed: int = 0,
    max_steps: int | None = None,
    progress: Callable[[float], None] | None = None,
    n_jobs: int | None = None,
) -> xr.Dataset:
    """Follow a bundle of neighbours of a motion, or exponents over a plane of initial states, or both.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        What moves.
    neighbours : int, optional
        How many; 20 if left out, none beside a plane.
    references : int
        States of the motion that have neighbours, `turns` apart: one curve tells of one stretch of the
        motion, many of their mean.
    distance : float
        At the start, in scaled units (see `analysis.divergence`).
    turns : int
        Turns of the crank, or periods of the forcing, that all are followed.
    samples_per_turn : int
        How often states are compared.
    transient : int
        Turns of the motion before its neighbours start; of the bundle only.
    compare : {"section", "time"}, optional
        At equal angle of the crank, or at equal times; the first wherever something turns.
    plane : mapping, optional
        Two coordinates, each with its values: a rising list or ``{"start", "stop", "num"}``. Of a test system
        two states; of a linkage ``crank_angle``, ``crank_speed``, ``journal_x``, ``journal_y`` (over the
        clearance), ``journal_velocity_x``, ``journal_velocity_y`` (m/s), or states.
    joint : str, optional
        Whose journal; the only one with clearance if left out.
    rtol, initial, max_steps, progress
        As in `simulate`; `initial` is the start that the plane goes through.
    seed : int
        Of the neighbours' directions.
    n_jobs : int, optional
        Worker processes for the plane.

    Returns
    -------
    xarray.Dataset
        Of the bundle, over ``reference``, ``neighbour`` and ``turn``: ``distance``, ``neighbour_status``;
        ``mean_log_distance``, ``fitted_log_distance`` (NaN outside the range of the fit); ``growth`` a turn,
        ``growth_rate`` (1/s), each with its ``_standard_error``; ``fit_turns``, ``saturation`` (NaN where the
        distances stay at no level yet). Of the plane, over its coordinates: ``finite_time_exponent`` (1/s),
        ``finite_time_exponent_per_turn`` and ``node_status``. ``status``.

    Raises
    ------
    InputError
        Listing everything that makes no sense; numerical trouble is a status instead.
    """
    own = (references, distance, turns, samples_per_turn, transient, compare, rtol, seed, max_steps)
    bundle = Divergence(_count(neighbours, plane), *own)
    refused(_problems(mechanism, bundle, plane, joint, initial))
    began, variables, coords, states = clock.perf_counter(), {}, {}, []
    if bundle.neighbours:
        share = None if plane is not None else progress
        variables, coords, status = bundle.follow(mechanism, initial, share)
        states.append(status)
    if plane is not None:
        found = field(mechanism, plane, turns, rtol, joint, initial, max_steps, progress, n_jobs)
        variables |= found
        starts = planes.Starts(mechanism, initial, tuple(plane), joint)
        coords |= planes.axis_coordinates(starts, planes.axes(plane))
        states.append(overall(found["node_status"][1]))
    variables |= {
        "status": ((), np.int8(max(states)), {"long_name": "how the run ended"} | flags(STATUS)),
        "wall_time": (
            (),
            clock.perf_counter() - began,
            {"units": "s", "long_name": "wall time of the run"},
        ),
    }
    return xr.Dataset(variables, coords, {"Conventions": "CF-1.11", "kind": "sensitivity"})


def overall(status: np.ndarray) -> int:
    """Status of a whole plane: of a node that crashed, or of all where none ended well; else ok."""
    if np.any(status == CRASHED):
        return CRASHED
    return int(status.min()) if status.size else 0


def wrong(mechanism: Mechanism | TestSystem, **keywords: Any) -> None:
    """Refuse keywords of `sensitivity` that make no sense, before anything is computed.

    Raises
    ------
    InputError
        Listing every problem.
    """
    usual = {name: each.default for name, each in signature(sensitivity).parameters.items()}
    given = usual | keywords
    own = {each.name: given[each.name] for each in fields(Divergence)}
    bundle = Divergence(**own | {"neighbours": _count(given["neighbours"], given["plane"])})
    refused(_problems(mechanism, bundle, given["plane"], given["joint"], given["initial"]))


def counts(least: Mapping[str, int], given: Any) -> Iterator[Problem]:
    """Problems of attributes that should be whole numbers, each with its least."""
    for key, value in least.items():
        yield from whole(key, getattr(given, key), value)


def shared(mechanism: Any, given: Any) -> list[Problem]:
    """Problems of what every analysis takes; turns and transient are counts, and looked at as such."""
    try:
        asked.check(mechanism, 1, None, 0, given.rtol, given.max_steps)
    except InputError as error:
        return error.problems
    return []


def _count(neighbours: Any, plane: Any) -> Any:
    """How many neighbours, where it is left out too."""
    return (NEIGHBOURS if plane is None else 0) if neighbours is None else neighbours


def _problems(mechanism, bundle: Divergence, plane, joint, initial) -> Iterator[Problem]:
    least = {"turns": 1, "transient": 0, "references": 1, "samples_per_turn": 1, "seed": 0}
    least |= {"neighbours": 0 if plane is not None else 1}
    yield from counts(least, bundle)
    yield from shared(mechanism, bundle)
    real = isinstance(bundle.distance, int | float) and not isinstance(bundle.distance, bool)
    if not (real and 0 < bundle.distance < 1):
        yield Problem("distance", bundle.distance, "a number greater than 0 and less than 1 is accepted")
    unforced = isinstance(mechanism, TestSystem) and mechanism.period is None
    known = COMPARED[unforced:]
    if bundle.compare not in (None, *known):
        accepted = f"one of {', '.join(known)} is accepted" + " where nothing turns" * unforced
        yield Problem("compare", bundle.compare, accepted)
    if plane is not None:
        yield from planes.check(mechanism, plane, joint, initial)
    if plane is not None and bundle.neighbours == 0 and bundle.transient:
        yield Problem("transient", bundle.transient, "0 is accepted without neighbours: a node is a start")
