"""Basins of attraction: which attractor each start of a plane reaches.

Every node is followed to its end, ends are sorted into attractors (`analysis.states.ends`), orbits that
attract nothing are left out, and fractions and the boundary's dimension are estimated
(`analysis.states.basin_uncertainty`). Validity: a motion that has not settled after transient and patience is
described as it is then.

Saddles and repellers that a start hits exactly attract nothing. They are told by the multipliers of the
section map over the period: one beyond the unit circle, and neighbours leave. Validity: multipliers within
`BEYOND` of it are not told from those on it. Where the largest is on it to `NEUTRAL`, as without damping,
neighbours neither come nor leave; a warning tells of such orbits.
"""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from functools import partial
from typing import Annotated, Any, Unpack

import numpy as np
from pydantic import Field

from jointplay.analysis import rules
from jointplay.analysis.cells import handed_out, warm
from jointplay.analysis.declared import Outputs
from jointplay.analysis.evaluate import OUTCOME
from jointplay.analysis.keywords import HANDED, Moving, Plane, Recognising, analysis
from jointplay.analysis.labels import PLANE, Out, ended, xr
from jointplay.analysis.orbits.orbit_dataset import largest_multiplier, told_neutral
from jointplay.analysis.quantities import STATUS
from jointplay.analysis.states import start_plane
from jointplay.analysis.states.basin_uncertainty import (
    DIRECTIONS,
    PAIRS,
    Pairs,
    count_pairs,
    fractions,
    grid_pairs,
    interval_outs,
    is_even,
    uncertainty_exponent,
)
from jointplay.analysis.states.ends import BAD, Attractors, Observation, ends, features, match, padded
from jointplay.analysis.states.start_plane import Starts, axis_values, grid
from jointplay.analysis.sweeps import subdivision
from jointplay.analysis.sweeps.subdivision import Point, refined, representatives
from jointplay.display import codes
from jointplay.display.number_text import counted, listed, plain, with_error
from jointplay.solver.mechanism.base import Count, Flag
from jointplay.solver.mechanism.model import Model
from jointplay.solver.motion.eligibility import ROUTES
from jointplay.solver.motion.ensemble_runs import ensemble_fits, in_lanes

BLOCK = 64  # nodes a cell
HALVINGS = 5  # distances of random pairs: a step of the grid, halved once to five times
SEED = 4
NODE_STATUS = (*STATUS, "saddle")  # the run ended well, on a periodic orbit that attracts nothing
SADDLE = len(STATUS)
LISTED = 3  # attractors named in a line
BEYOND = 1e-3  # of 1: a multiplier that differs less may be on the unit circle


def answer(result: xr.Dataset) -> str:
    """The attractors with their shares of the starts, and the dimension of their boundary."""
    if not result.sizes["number"]:
        return "no attractor found"
    order = np.argsort(-result["fraction"].values, kind="stable")
    each = [_attractor(result.isel(number=int(i))) for i in order]
    name, shares = counted(len(each), "attractor"), listed(each, LISTED, ", ")
    lines = [f"{name}, with their shares of the starts: {shares}"]
    none = float(result["fraction_none"])
    if none > 0:
        lines.append(f"{plain(100 * none, 2)} % of the starts reached no attractor{_on_saddles(result)}")
    if "boundary_dimension" not in result:
        return "\n".join(lines)
    boundary = float(result["boundary_dimension"])
    error = float(result["uncertainty_exponent_standard_error"])
    if math.isfinite(boundary):
        lines.append(f"the boundary of the basins has dimension {with_error(boundary, error)} in the plane")
    return "\n".join(lines)


def _on_saddles(result: xr.Dataset) -> str:
    """Remark on the number of nodes that reach periodic orbits that attract nothing."""
    if "node_status" not in result:
        return ""
    count = int(np.sum(codes.words(result["node_status"]).values == "saddle"))
    return f", {count} of them an unstable periodic orbit" if count else ""


def _attractor(one: xr.Dataset) -> str:
    period = int(one["period"])
    percent, error = (100 * float(one[name]) for name in ("fraction", "fraction_standard_error"))
    share = f"({with_error(percent, error)}) %" if error > 0 else f"{plain(percent, 3)} %"
    return f"{f'period {period}' if period else 'no period'} {share}"


OUTPUTS = Outputs(
    "basins",
    {
        "number": Out("number", "number of the attractor"),
        "state": Out("state", "state", ""),
        "axis": Out("axis", "axis of the plane", ""),
    },
    {
        "attractor": Out(PLANE, "attractor that is reached", about="0: none, see ``node_status``"),
        "node_status": Out(
            PLANE,
            "how the node's run ended",
            about="as ``status``, or ``saddle``: on an unstable orbit",
            flags=NODE_STATUS,
        ),
        "followed": Out(PLANE, "how the node's motion was followed", flags=ROUTES),
        "period": Out("number", "period in turns; 0: none found"),
        "count": Out("number", "nodes that reach the attractor"),
        "fraction": Out(
            "number", "fraction of the starts that reach the attractor", at={"number": "largest"}
        ),
        "fraction_standard_error": Out("number", "binomial standard error of the fraction"),
        **interval_outs("number"),
        "fraction_none": Out((), "fraction of the starts without an attractor"),
        "section_state": Out(("number", "point", "state"), "states at the section (SI)"),
        "section_plane": Out(("number", "point", "axis"), "section points, in the units of the plane's axes"),
    }
    | subdivision.OUTS
    | {
        "pair_distance": Out("pair", "distance of a pair, in lengths of the axes"),
        "pair_count": Out("pair", "pairs"),
        "uncertain_fraction": Out("pair", "fraction of pairs with different ends"),
        "uncertain_fraction_standard_error": Out("pair", "standard error of that fraction"),
        "pair_kind": Out("pair", "where the pairs are", flags=PAIRS),
        "uncertainty_exponent": Out((), "uncertainty exponent of the basins' boundary"),
        "uncertainty_exponent_standard_error": Out((), "standard error of the uncertainty exponent"),
        "boundary_dimension": Out((), "dimension of the boundary in the plane"),
    }
    | OUTCOME,
    answer,
    shown={"fraction": "fraction of the starts in the largest basin"},
)


@analysis(
    start_plane.plane_fits,
    "model",
    rules.turns_alike,
    ensemble_fits,
    outputs=OUTPUTS,
    left_out=rules.WHOLE_DISC,
    model=rules.on_section,
)
def basins(  # noqa: D417 (nobody gives it the model)
    mechanism: Moving,
    *,
    model: Model = HANDED,
    plane: Plane,
    uncertainty: Flag = True,
    pairs: Annotated[Count, Field(le=10**7)] = 0,
    refine: Annotated[Count, Field(le=20)] = 0,
    **motion: Unpack[Recognising],
) -> xr.Dataset:
    """Find which attractor each start of a plane reaches.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        What moves.
    plane : mapping
        Two coordinates of the start, each with its values: a rising list, or ``start``, ``stop`` and ``num``.
        Which there are stands in `sensitivity`.
    uncertainty : bool
        Whether to estimate the uncertainty exponent of the basins' boundary.
    pairs : int
        Number of random points, beside the grid, for the uncertainty exponent; each has partners at half a
        step of the grid and below.
    refine : int
        How many times the grid is halved where starts end differently: with 0 every node is followed; with n
        every 2^n-th node along each axis first, and nodes between them only where these end differently. A
        node that was not followed has the end of the nearest one that was.
    initial : optional
        As in `sensitivity`.

    Raises
    ------
    InputError
        Listing everything that makes no sense; numerical trouble is a status instead.
    """
    began, axes = time.perf_counter(), axis_values(plane)
    together = in_lanes(motion["ensemble"], mechanism, motion["rtol"], math.prod(map(len, axes.values())))
    observation, handing = Observation.of(motion, together), (motion["progress"], motion["n_jobs"])
    starts = Starts(mechanism, motion["initial"], tuple(axes), motion["joint"], model)
    warm([model], together)
    nodes = grid(axes)
    extra, distances = random_pairs(axes, pairs if uncertainty else 0)
    values = np.concatenate([nodes, extra.reshape(-1, 2)])
    if refine:
        answers, refinement = _adaptive(starts, axes, refine, extra, observation, *handing)
    else:
        answers, refinement = _ended(starts, values, observation, *handing), {}
    status, periods, followed, states = answers
    points = [features(starts.model, end) if len(end) else end for end in states]
    sorted_ends, on_saddle, said = without_saddles(
        match(periods, points, observation.tolerance), states, starts.model, observation
    )
    attractors, on_saddle = _renumbered(sorted_ends, len(nodes)), on_saddle[: len(nodes)]
    labels, status = attractors.labels[: len(nodes)], status[: len(nodes)]
    shape, count = tuple(map(len, axes.values())), len(attractors.periods)
    table, followed = labels.reshape(shape), np.array(followed[: len(nodes)]).reshape(shape)
    ended_at = np.where(on_saddle, SADDLE, status).reshape(shape)
    found = {"attractor": table, "node_status": ended_at, "followed": followed} | refinement
    found |= _fractions(attractors, len(nodes), int(np.sum(status != BAD)))
    found |= _section_points(attractors, states, starts)
    if uncertainty:
        rows = grid_pairs(table, tuple(is_even(each) for each in axes.values()))
        rows += _random_rows(attractors.labels[len(nodes) :], distances)
        found |= _boundary(rows)
    found |= {"number": np.arange(1, count + 1), "axis": np.array(list(axes), dtype=str)}
    found |= {"state": np.array(starts.states, dtype=str)} | ended(start_plane.plane_status(status), began)
    words = {"attractor": ["none", *(f"attractor_{i}" for i in range(1, count + 1))]}
    return OUTPUTS.dataset(found, plane=starts.axes(axes), words=words, **said)


def _fractions(attractors: Attractors, nodes: int, started: int) -> dict[str, Any]:
    """Periods of attractors, and fractions of the starts that reach them: of the nodes that have a start."""
    count = np.bincount(attractors.labels[:nodes], minlength=len(attractors.periods) + 1)[1:]
    found = fractions(count, started)
    fraction = found["fraction"]
    return found | {
        "period": attractors.periods.astype(np.int32),
        "count": count,
        "fraction_standard_error": np.sqrt(fraction * (1 - fraction) / started) if started else fraction,
        "fraction_none": float((started - count.sum()) / started) if started else math.nan,
    }


def _section_points(attractors: Attractors, states: list[np.ndarray], starts: Starts) -> dict[str, Any]:
    """Section points of one end of each attractor, as states and in the plane; NaN past the last."""
    shown = [states[i] for i in attractors.shown_by]
    in_plane = padded([starts.projected(end) for end in shown], 2)
    return {"section_state": padded(shown, len(starts.model.state)), "section_plane": in_plane}


def _boundary(rows: list[Pairs]) -> dict[str, Any]:
    """Counts of pairs, the uncertainty exponent, and the dimension of the basins' boundary."""
    slope, error = uncertainty_exponent(rows)
    return {
        "pair_distance": np.asarray([row.distance for row in rows]),
        "pair_count": np.asarray([row.count for row in rows]),
        "uncertain_fraction": np.asarray([row.fraction for row in rows]),
        "uncertain_fraction_standard_error": np.asarray([row.error for row in rows]),
        "pair_kind": [row.kind for row in rows],
        "uncertainty_exponent": slope,
        "uncertainty_exponent_standard_error": error,
        "boundary_dimension": DIRECTIONS - slope,
    }


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
    """Ends (`_ended`) of all nodes, then of `extra` starts; also the dataset's variables on the refinement.

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
    place, level = representatives(shape, boxes, computed)
    first, last = parts[0], len(parts[0][0]) - len(more)
    order = [*computed]  # in the order in which they were computed
    at = {np.ravel_multi_index(point, shape): n + len(more) * (n >= last) for n, point in enumerate(order)}
    rows = [at[int(each)] for each in place.flat] + [*range(last, len(first[0]))]
    columns = [np.concatenate([each[n] for each in parts])[rows] for n in range(3)]
    states = [end for each in parts for end in each[3]]
    return (*columns, [states[row] for row in rows]), subdivision.variables(computed, level)


def _alike(tolerance: float, motions: list[tuple[int, int, np.ndarray]]) -> bool:
    """Whether motions end alike: as badly, or on one attractor."""
    if len({motion[:2] for motion in motions}) > 1:
        return False
    ends = [motion[2] for motion in motions if len(motion[2])]
    return not ends or len({*match(np.full(len(ends), motions[0][1]), ends, tolerance).labels}) == 1


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
    direction = np.stack([np.cos(angle), np.sin(angle)], -1)
    partners = inside + direction * distances[None, :, None]
    return low + size * np.concatenate([inside, partners], axis=1), distances


def _random_rows(labels: np.ndarray, distances: np.ndarray) -> list[Pairs]:
    if not labels.size:
        return []
    table, kind = labels.reshape(-1, 1 + len(distances)), PAIRS.index("random")
    return [count_pairs(kind, e, table[:, 0], table[:, i]) for i, e in enumerate(distances, start=1)]


def _renumbered(attractors: Attractors, nodes: int) -> Attractors:
    """The same attractors, numbered so that ones that only random points reach come last."""
    count = len(attractors.periods)
    on_grid = np.isin(np.arange(1, count + 1), attractors.labels[:nodes])
    order = np.argsort(~on_grid, kind="stable")
    number = np.zeros(count + 1, dtype=np.int32)
    number[1 + order] = np.arange(1, count + 1)
    return Attractors(number[attractors.labels], attractors.periods[order], attractors.shown_by[order])


def without_saddles(
    found: Attractors, states: list[np.ndarray], base: Model, observation: Observation
) -> tuple[Attractors, np.ndarray, dict[str, str]]:
    """The attractors that attract, whether each end is an orbit that does not, and what a warning says.

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
    largest = [largest_multiplier(base, int(p), states[i][-1], observation) for p, i in pairs]
    kept = ~(np.array(largest) > 1 + BEYOND)  # of an unknown one it is as it was found
    number = np.append(0, np.where(kept, np.cumsum(kept), 0)).astype(np.int32)
    on_saddle = np.append(False, ~kept)[found.labels]
    attracting = Attractors(number[found.labels], found.periods[kept], found.shown_by[kept])
    return attracting, on_saddle, told_neutral(largest)
