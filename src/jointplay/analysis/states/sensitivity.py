"""Sensitivity to the start: divergence of neighbours, and exponents over a plane of starts.

The methods are described in `analysis.states.divergence` and `analysis.states.field`.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Any, Literal, Unpack

from jointplay.analysis import rules
from jointplay.analysis.exponents.growth import unresolved
from jointplay.analysis.keywords import JointName, Moving, Plane, Settling, Small, analysis
from jointplay.analysis.labels import outcome
from jointplay.analysis.states.divergence import Divergence
from jointplay.analysis.states.field import field
from jointplay.analysis.states.start_plane import Starts, axis_values, plane_fits, plane_status
from jointplay.display.errors import Problem
from jointplay.solver.mechanism.base import Count, Natural, accepts
from jointplay.solver.mechanism.records import Mechanism, TestSystem
from jointplay.solver.motion.looks import part

if TYPE_CHECKING:
    import xarray as xr

NEIGHBOURS = 20
DISTANCE = 1e-9
RTOL = 1e-12  # so that the runs' own errors stay far below the distance


def _something_to_do(neighbours: int | None, plane: Any) -> Iterator[Problem]:
    if not _count(neighbours, plane) and plane is None:
        yield Problem("neighbours", neighbours, "1 or more, or a plane, is accepted")


def _resolved(neighbours: int | None, plane: Any, distance: float, rtol: float) -> Iterator[Problem]:
    if _count(neighbours, plane):
        yield from unresolved(distance, rtol)


def _samples_fit(
    turns: int, samples_per_turn: int, neighbours: int | None, plane: Any, references: int
) -> Iterator[Problem]:
    many = {"neighbours": _count(neighbours, plane), "references": references}
    yield from rules.too_many({"turns": turns, "samples_per_turn": samples_per_turn} | many)


def _compare_fits(mechanism: Mechanism | TestSystem, compare: str | None) -> Iterator[Problem]:
    if compare == "section" and isinstance(mechanism, TestSystem) and mechanism.period is None:
        yield Problem("compare", compare, "one of time is accepted where nothing turns")


def _transient_fits(neighbours: int | None, plane: Any, transient: int) -> Iterator[Problem]:
    if plane is not None and not _count(neighbours, plane) and transient:
        yield Problem("transient", transient, "0 is accepted without neighbours: a node is a start")


@analysis(
    _something_to_do,
    _resolved,
    _samples_fit,
    _compare_fits,
    _transient_fits,
    plane_fits,
    rules.start_fits,
    rules.turns_alike,
    usual={"rtol": RTOL, "transient": 0},
)
def sensitivity(
    mechanism: Moving,
    *,
    neighbours: Count | None = None,
    references: Natural = 1,
    distance: Small = DISTANCE,
    turns: Natural = 40,
    samples_per_turn: Natural = 1,
    compare: Annotated[Literal["section", "time"], accepts('"section" or "time"')] | None = None,
    plane: Plane | None = None,
    joint: JointName | None = None,
    seed: Count = 0,
    n_jobs: Natural | None = None,
    **motion: Unpack[Settling],
) -> xr.Dataset:
    """Follow a bundle of neighbours of a motion, or exponents over a plane of initial states, or both.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        What moves.
    neighbours : int, optional
        How many; 20 if left out, none beside a plane.
    references : int
        States of the motion that have neighbours, `turns` apart: their curves are averaged.
    distance : float
        At the start, in scaled units (see `analysis.states.divergence`).
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
        two states; of a linkage ``crank_angle``, ``crank_speed``, ``journal_x``, ``journal_y`` (m),
        ``eccentricity_ratio_x``, ``eccentricity_ratio_y`` (the same over the clearance),
        ``journal_velocity_x``, ``journal_velocity_y`` (m/s), or states.
    joint : str, optional
        Whose journal; the only one with clearance if left out.
    initial : optional
        As in `lyapunov`: the start that the plane goes through.
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
        ``finite_time_exponent_per_turn`` and ``node_status``. ``status``: not_converged where growth is NaN,
        since distances grew over fewer than three turns beyond the first two.

    Raises
    ------
    InputError
        Listing everything that makes no sense; numerical trouble is a status instead.
    """
    import xarray as xr

    rtol, initial, limit, progress = (motion[key] for key in ("rtol", "initial", "max_steps", "progress"))
    own = (references, distance, turns, samples_per_turn, motion["transient"], compare, rtol, seed, limit)
    bundle = Divergence(_count(neighbours, plane), *own)
    began, variables, coords, statuses = time.perf_counter(), {}, {}, []
    if bundle.neighbours:
        share = 0.5 if plane is not None else 1.0
        variables, coords, status = bundle.follow(mechanism, initial, part(progress, 0.0, share))
        statuses.append(status)
    if plane is not None:
        rest = part(progress, 0.5 if bundle.neighbours else 0.0, 1.0)
        starts, axes = Starts(mechanism, initial, tuple(plane), joint), axis_values(plane)
        variables |= field(starts, axes, turns, rtol, limit, rest, n_jobs)
        coords |= starts.axes(axes)
        statuses.append(plane_status(variables["node_status"][1]))
    variables |= outcome(max(statuses), began)
    return xr.Dataset(variables, coords, {"Conventions": "CF-1.11", "kind": "sensitivity"})


def _count(neighbours: Any, plane: Any) -> Any:
    """Number of neighbours, by default 20, or 0 beside a plane."""
    return (NEIGHBOURS if plane is None else 0) if neighbours is None else neighbours
