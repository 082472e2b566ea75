"""Basins of attraction: which attractor each start of a plane reaches.

Every node is followed to its end (`analysis.states.ends`), ends are sorted into attractors
(`analysis.states.matching`), orbits that attract nothing are left out, and fractions and the boundary's
dimension are estimated (`analysis.states.basin_uncertainty`). Validity: a motion that has not settled after
transient and patience is described as it is then.

Saddles and repellers that a start hits exactly attract nothing. They are told by the multipliers of the
section map over the period: one beyond the unit circle, and neighbours leave. Validity: multipliers within
`BEYOND` of it are not told from those on it.
"""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING, Annotated, Unpack

import numpy as np
from pydantic import Field

from jointplay.analysis import rules
from jointplay.analysis.cells import handed_out, warm
from jointplay.analysis.keywords import JointName, Moving, Plane, Settling, analysis
from jointplay.analysis.labels import coded, outcome
from jointplay.analysis.orbits.section_map import SectionMap
from jointplay.analysis.period import REPEATS
from jointplay.analysis.starts import crank_place
from jointplay.analysis.states import basin_dataset, start_plane
from jointplay.analysis.states.basin_uncertainty import PAIRS, Pairs, count_pairs, grid_pairs, is_even
from jointplay.analysis.states.ends import BAD, Observation, ends, features
from jointplay.analysis.states.matching import Attractors, match
from jointplay.analysis.states.start_plane import Starts, axis_values, grid
from jointplay.analysis.sweeps import quarters
from jointplay.analysis.sweeps.quarters import Point, refined, standing
from jointplay.solver.mechanism.base import Count, Flag, Natural, Positive, unit
from jointplay.solver.mechanism.model import Model
from jointplay.solver.motion.ensemble_runs import ensemble_fits, in_lanes
from jointplay.solver.motion.ways import WAYS

if TYPE_CHECKING:
    import xarray as xr

TURNS, PATIENCE = 64, 4
TOLERANCE = 1e-3
BLOCK = 64  # nodes a cell
HALVINGS = 5  # distances of random pairs: a step of the grid, halved once to five times
SEED = 4
FOLLOWED = "how the node's motion was followed"
BEYOND = 1e-3  # of 1: a multiplier that differs less may be on the unit circle


@analysis(start_plane.plane_fits, rules.start_fits, rules.turns_alike, ensemble_fits)
def basins(
    mechanism: Moving,
    *,
    plane: Plane,
    joint: JointName | None = None,
    turns: Annotated[Natural, Field(ge=REPEATS)] = TURNS,
    patience: Count = PATIENCE,
    tolerance: Annotated[Positive, unit("tolerance", "1")] = TOLERANCE,
    uncertainty: Flag = True,
    pairs: Annotated[Count, Field(le=10**7)] = 0,
    refine: Annotated[Count, Field(le=20)] = 0,
    ensemble: Flag | None = None,
    n_jobs: Natural | None = None,
    **motion: Unpack[Settling],
) -> xr.Dataset:
    """Find which attractor each start of a plane reaches.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        What moves.
    plane, joint : mapping, str
        Two coordinates with their values, and whose journal, as in `sensitivity`.
    turns : int
        Turns (periods of the forcing) after the transient by which an end is described: periods up to a
        quarter of them are found.
    patience : int
        How often a motion without a period is followed for `turns` more, before it counts as having none.
    tolerance : float
        Distance up to which section points of periodic ends are the same: of the clearance, of the nominal
        speed, or in a test system's units. A period is found at a tenth of it.
    uncertainty : bool
        Whether to estimate the uncertainty exponent of the basins' boundary.
    pairs : int
        Random points for it beside the grid, each with partners at half a step of the grid and below.
    refine : int
        0: every node is followed. n: every 2^n-th node along each axis, and others where these end elsewhere,
        down to neighbouring nodes; the nearest node that was followed stands for each that was not.
    initial, n_jobs
        As in `sensitivity`.
    ensemble : bool, optional
        Whether to follow eight motions at once; if left out, where that can be (see `bifurcation`).

    Returns
    -------
    xarray.Dataset
        Over the plane: ``attractor`` (0: none, see ``node_status``; `saddle` where an orbit is reached that
        attracts nothing); ``followed``, how; with `refine` also
        ``computed`` and ``refinement_level``. Over ``number``, the
        attractors: ``period`` (0: none), ``count``, ``fraction``, ``fraction_standard_error``, 95 % interval
        ``fraction_low`` to ``fraction_high``; ``section_state`` over ``point`` and ``state``, and the same
        points in the plane, ``section_plane``. Over ``pair``: ``uncertain_fraction`` with its error,
        ``pair_distance``, ``pair_count``, ``pair_kind``; ``uncertainty_exponent`` and
        ``boundary_dimension``, with errors. ``status``.

    Raises
    ------
    InputError
        Listing everything that makes no sense; numerical trouble is a status instead.
    """
    import xarray as xr

    began, axes = time.perf_counter(), axis_values(plane)
    together = in_lanes(ensemble, mechanism, motion["rtol"], math.prod(map(len, axes.values())))
    settled = motion["transient"], turns, patience, tolerance
    observation = Observation(*settled, motion["rtol"], motion["max_steps"], together)
    starts, progress = Starts(mechanism, motion["initial"], tuple(axes), joint), motion["progress"]
    warm([starts.model], together)
    nodes = grid(axes)
    extra, distances = random_pairs(axes, pairs if uncertainty else 0)
    values = np.concatenate([nodes, extra.reshape(-1, 2)])
    if refine:
        found, told = _adaptive(starts, axes, refine, extra, observation, progress, n_jobs)
    else:
        found, told = _ended(starts, values, observation, progress, n_jobs), {}
    status, periods, ways, states = found
    points = [features(starts.model, end) if len(end) else end for end in states]
    sorted_ends, on_saddle = without_saddles(
        match(periods, points, tolerance), states, starts.model, observation
    )
    attractors, on_saddle = _renumbered(sorted_ends, len(nodes)), on_saddle[: len(nodes)]
    labels, status = attractors.labels[: len(nodes)], status[: len(nodes)]
    table, count = labels.reshape(*map(len, axes.values())), len(attractors.periods)
    codes = np.where(on_saddle, basin_dataset.SADDLE, status).reshape(table.shape)
    variables = basin_dataset.plane_variables(tuple(axes), table, codes, count)
    variables["followed"] = coded(tuple(axes), ways[: len(nodes)].reshape(table.shape), FOLLOWED, WAYS)
    variables |= basin_dataset.fractions(attractors, len(nodes), int(np.sum(status != BAD)))
    variables |= basin_dataset.section_points(attractors, states, starts)
    variables |= told
    if uncertainty:
        rows = grid_pairs(table, tuple(is_even(each) for each in axes.values()))
        rows += _random_rows(attractors.labels[len(nodes) :], distances)
        variables |= basin_dataset.boundary(rows)
    variables |= outcome(start_plane.plane_status(status), began)
    coords = basin_dataset.coordinates(axes, count, starts)
    return xr.Dataset(variables, coords, {"Conventions": "CF-1.11", "kind": "basins"})


def _ended(starts, values, observation, progress, n_jobs, before: int = 0, possible: int = 0):
    """Status, period, way and section states of the motions from starts in the plane."""
    cells = starts.cells(values, BLOCK, observation=observation)
    answers = handed_out(ends, cells, progress, n_jobs, before=before, possible=possible)
    none = np.zeros((0, len(starts.model.state)))
    answers = start_plane.with_crashed(answers, cells, period=0, followed=0, states=none)
    columns = ("node_status", "period", "followed")
    rows = [np.concatenate([each[name] for each in answers]) for name in columns]
    return *rows, [end for each in answers for end in each["states"]]


def _adaptive(starts, axes, levels: int, extra, observation, progress, n_jobs):
    """As `_ended`, of all nodes and then of `extra` starts; what the dataset says of the map.

    Nodes are followed where others end elsewhere.
    """
    shape, nodes, parts = tuple(map(len, axes.values())), grid(axes), []
    more = extra.reshape(-1, 2)

    def looked(points: list[Point], tell):
        places = np.array([np.ravel_multi_index(point, shape) for point in points])
        values = np.concatenate([nodes[places], more]) if not parts else nodes[places]
        count = sum(-(-len(each[0]) // BLOCK) for each in parts)
        possible = -(-len(nodes) // BLOCK)
        parts.append(_ended(starts, values, observation, tell, n_jobs, count, possible))
        status, periods, _, states = parts[-1]
        seen = [features(starts.model, end) if len(end) else end for end in states]
        return {point: (status[n], periods[n], seen[n]) for n, point in enumerate(points)}

    alike = partial(_alike, observation.tolerance)
    boxes, computed = refined(shape, levels, alike, looked, progress)
    place, level = standing(shape, boxes, computed)
    first, last = parts[0], len(parts[0][0]) - len(more)
    order = [*computed]  # in the order in which they were computed
    at = {np.ravel_multi_index(point, shape): n + len(more) * (n >= last) for n, point in enumerate(order)}
    rows = [at[int(each)] for each in place.flat] + [*range(last, len(first[0]))]
    columns = [np.concatenate([each[n] for each in parts])[rows] for n in range(3)]
    states = [end for each in parts for end in each[3]]
    return (*columns, [states[row] for row in rows]), quarters.told(tuple(axes), computed, level)


def _alike(tolerance: float, looks: list[tuple[int, int, np.ndarray]]) -> bool:
    """Whether motions end alike: as badly, or on one attractor."""
    if len({look[:2] for look in looks}) > 1:
        return False
    ends = [look[2] for look in looks if len(look[2])]
    return not ends or len({*match(np.full(len(ends), looks[0][1]), ends, tolerance).labels}) == 1


def random_pairs(axes: Mapping[str, np.ndarray], count: int) -> tuple[np.ndarray, np.ndarray]:
    """Random points of a plane, each followed by its partners: shape (count, 1 + distances, 2); distances.

    Partners lie in one random direction, at distances (in lengths of the axes) of half a mean step and less.
    """
    first, second = axes.values()
    low, size = np.array([first[0], second[0]]), np.array([np.ptp(first), np.ptp(second)])
    step = np.mean([1 / (len(first) - 1), 1 / (len(second) - 1)])
    distances = step * 0.5 ** np.arange(1, HALVINGS + 1)
    random = np.random.default_rng(SEED)
    inside, angle = random.uniform(size=(count, 1, 2)), random.uniform(0, math.tau, size=(count, 1))
    way = np.stack([np.cos(angle), np.sin(angle)], -1)
    partners = inside + way * distances[None, :, None]
    return low + size * np.concatenate([inside, partners], axis=1), distances


def _random_rows(labels: np.ndarray, distances: np.ndarray) -> list[Pairs]:
    if not labels.size:
        return []
    table, kind = labels.reshape(-1, 1 + len(distances)), PAIRS.index("random")
    return [count_pairs(kind, e, table[:, 0], table[:, i]) for i, e in enumerate(distances, start=1)]


def _renumbered(attractors: Attractors, nodes: int) -> Attractors:
    """The same attractors, those that only random points and no nodes of the grid reach numbered last."""
    count = len(attractors.periods)
    on_grid = np.isin(np.arange(1, count + 1), attractors.labels[:nodes])
    order = np.argsort(~on_grid, kind="stable")
    number = np.zeros(count + 1, dtype=np.int32)
    number[1 + order] = np.arange(1, count + 1)
    return Attractors(number[attractors.labels], attractors.periods[order], attractors.shown_by[order])


def repels(base: Model, period: int, state: np.ndarray, observation: Observation) -> bool:
    """Whether the periodic orbit through a state at the section has a multiplier beyond the unit circle."""
    place = crank_place(base) if base.structure.section is not None else None
    limits = {"rtol": observation.rtol, "max_steps": observation.max_steps}
    image = SectionMap(base, period, base.crank_angle, place, base.forward, **limits).image(state)
    if image.status:  # without a derivative it is as it was found
        return False
    return bool(np.max(np.abs(np.linalg.eigvals(image.derivative)), initial=0.0) > 1 + BEYOND)


def without_saddles(
    found: Attractors, states: list[np.ndarray], base: Model, observation: Observation
) -> tuple[Attractors, np.ndarray]:
    """The attractors that attract, and whether each end is an orbit that does not.

    Parameters
    ----------
    found : Attractors
        Sorted ends.
    states : list of ndarray
        States at the section of each end.
    base : Model
        The model on its section.
    observation : Observation
        How the motions were followed.
    """
    pairs = zip(found.periods, found.shown_by, strict=True)
    kept = np.array([not (p and repels(base, int(p), states[i][-1], observation)) for p, i in pairs], bool)
    number = np.append(0, np.where(kept, np.cumsum(kept), 0)).astype(np.int32)
    on_saddle = np.append(False, ~kept)[found.labels]
    return Attractors(number[found.labels], found.periods[kept], found.shown_by[kept]), on_saddle
