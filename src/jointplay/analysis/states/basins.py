"""Basins of attraction: which attractor each start of a plane reaches.

Every node is followed to its end (`analysis.states.ends`), ends are sorted into attractors
(`analysis.states.matching`), and the attractors' shares and the boundary's dimension estimated
(`analysis.states.basin_uncertainty`); each says how at its head. Validity: a motion that has not settled
after transient and patience is described as it is then.
"""

from __future__ import annotations

import math
import time as clock
from collections.abc import Mapping
from dataclasses import replace
from typing import Annotated

import numpy as np
import xarray as xr
from pydantic import Field

from jointplay.analysis import ensemble_runs as follows
from jointplay.analysis import rules as asked
from jointplay.analysis.cells import Steps, divided, handed_out, warm
from jointplay.analysis.evaluate import flags
from jointplay.analysis.keywords import JointName, Moving, Plane, Progress, Rtol, Start, analysis
from jointplay.analysis.period import REPEATS
from jointplay.analysis.quantities import STATUS
from jointplay.analysis.states import basin_dataset as words
from jointplay.analysis.states import basin_uncertainty as unsure
from jointplay.analysis.states import start_plane as planes
from jointplay.analysis.states.ends import BAD, Watch, ends, features
from jointplay.analysis.states.matching import Attractors, match
from jointplay.analysis.states.sensitivity import overall
from jointplay.mechanism.base import Count, Flag, Natural, Positive, unit

TURNS, TRANSIENT, PATIENCE = 64, 100, 4
TOLERANCE = 1e-3
BLOCK = 64  # nodes a cell
HALVINGS = 5  # distances of random pairs: a step of the grid, halved so often
SEED = 4


@divided
@analysis(planes.check, asked.start_fits, follows.ensemble_fits)
def basins(
    mechanism: Moving,
    *,
    plane: Plane,
    joint: JointName | None = None,
    turns: Annotated[Natural, Field(ge=REPEATS)] = TURNS,
    transient: Count = TRANSIENT,
    patience: Count = PATIENCE,
    tolerance: Annotated[Positive, unit("tolerance", "1")] = TOLERANCE,
    uncertainty: Flag = True,
    pairs: Annotated[Count, Field(le=10**7)] = 0,
    rtol: Rtol = 1e-8,
    initial: Start | None = None,
    max_steps: Natural | None = None,
    ensemble: Flag = False,
    progress: Progress = None,
    n_jobs: Natural | None = None,
) -> Steps:
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
    transient : int
        Turns dropped before.
    patience : int
        How often a motion without a period is followed for `turns` more, before it counts as having none.
    tolerance : float
        Distance up to which section points of periodic ends are the same: of the clearance, of the nominal
        speed, or in a test system's units. A period is found at a tenth of it.
    uncertainty : bool
        Whether to estimate the uncertainty exponent of the basins' boundary.
    pairs : int
        Random points for it beside the grid, each with partners at half a step of the grid and below.
    rtol, initial, max_steps, progress, n_jobs
        As in `sensitivity`; `initial` is the start that the plane goes through.
    ensemble : bool
        Follow eight motions at once: of a rigid linkage of three links and a motor with clearance in one
        joint, at an rtol of 1e-8 or more. Two to three times as fast; by another method, whose numbers
        differ within the tolerance, and do not depend on which motions run beside each other.

    Returns
    -------
    xarray.Dataset
        Over the plane: ``attractor`` (0: none, see ``node_status``). Over ``number``, the attractors:
        ``period`` (0: none), ``count``, ``fraction`` with ``fraction_standard_error`` and the 95 % interval
        ``fraction_low`` to ``fraction_high``; ``section_state`` over ``point`` and ``state``, and the same
        points in the plane, ``section_plane``. Over ``pair``: ``uncertain_fraction`` with its error,
        ``pair_distance``, ``pair_count``, ``pair_kind``; ``uncertainty_exponent`` and
        ``boundary_dimension``, with errors. ``status``.

    Raises
    ------
    InputError
        Listing everything that makes no sense; numerical trouble is a status instead.
    """
    watch = Watch(transient, turns, patience, tolerance, rtol, max_steps, ensemble)
    began, axes = clock.perf_counter(), planes.axes(plane)
    starts = planes.Starts(mechanism, initial, tuple(axes), joint)
    warm([starts.model], ensemble)
    grid = planes.nodes(axes)
    extra, distances = random_pairs(axes, pairs if uncertainty else 0)
    values = np.concatenate([grid, extra.reshape(-1, 2)])
    cells = planes.cells(mechanism, initial, joint, tuple(axes), values, BLOCK, watch=watch)
    found = yield from handed_out(ends, cells, progress)
    status, periods, states = _joined(found, cells, starts)
    points = [features(starts.model, each) if len(each) else each for each in states]
    found = match(periods, points, tolerance)
    shape, nodes = tuple(map(len, axes.values())), len(grid)
    kept = _renumbered(found, nodes)
    labels = kept.labels[:nodes].reshape(shape)
    variables = words.plane_variables(tuple(axes), labels, status[:nodes].reshape(shape), len(kept.periods))
    started = int(np.sum(status[:nodes] != BAD))
    variables |= words.shares(kept, nodes, started) | words.points(kept, states, starts)
    if uncertainty:
        rows = unsure.of_grid(labels, tuple(unsure.is_even(each) for each in axes.values()))
        rows += _random_rows(kept.labels[nodes:], distances)
        variables |= words.boundary(rows)
    variables["status"] = (
        (),
        np.int8(overall(status[:nodes])),
        {"long_name": "how the run ended"} | flags(STATUS),
    )
    spent = clock.perf_counter() - began
    variables["wall_time"] = ((), spent, {"units": "s", "long_name": "wall time of the run"})
    coords = words.coordinates(axes, kept, starts)
    return xr.Dataset(variables, coords, {"Conventions": "CF-1.11", "kind": "basins"})


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


def _random_rows(labels: np.ndarray, distances: np.ndarray) -> list[unsure.Row]:
    if not labels.size:
        return []
    table, kind = labels.reshape(-1, 1 + len(distances)), unsure.PAIRS.index("random")
    return [unsure.of_pairs(kind, e, table[:, 0], table[:, 1 + i]) for i, e in enumerate(distances)]


def _joined(found: list, cells: list, starts) -> tuple[np.ndarray, np.ndarray, list[np.ndarray]]:
    """Status, period and states of every node; a cell that crashed has none."""
    status, periods, states = [], [], []
    for each, cell in zip(found, cells, strict=True):
        count = len(cell["values"])
        whole = "states" in each
        status.append(each["node_status"] if whole else np.full(count, each["status"]))
        periods.append(each["period"] if whole else np.zeros(count, dtype=int))
        states += each["states"] if whole else [np.zeros((0, len(starts.model.state)))] * count
    return np.concatenate(status).astype(np.int8), np.concatenate(periods), states


def _renumbered(found: Attractors, nodes: int) -> Attractors:
    """Attractors of the grid's nodes alone first, with those that only random points reach after them."""
    on_grid = np.unique(found.labels[:nodes])
    order = [i for i in on_grid if i] + [
        i for i in range(1, len(found.periods) + 1) if i not in set(on_grid.tolist())
    ]
    place = np.zeros(len(order) + 1, dtype=np.int32)
    place[order] = np.arange(1, len(order) + 1)
    index = np.array(order, dtype=int) - 1
    return replace(
        found, labels=place[found.labels], periods=found.periods[index], shown_by=found.shown_by[index]
    )
