"""Ends of motions: the section points that are left when the transient has decayed.

A start is followed for the transient's turns and then for the turns observed. A motion that shows no period
is followed further, a few times as long, before it counts as having none, so that a slow approach to a
periodic motion does not count as chaos. Points are compared in units in which tolerances mean the same for
all mechanisms: journals' centres over their clearances, links' speeds over the nominal speed; a test system's
states as they are. A system that nothing forces is cut at equal times, its nominal periods.

Sorting ends of motions into attractors.

Ends of the same period are the same if their section points are within a tolerance as sets: no point of one
farther than that from the nearest of the other (Hausdorff distance), in any coordinate. Ends without a period
are compared by histograms: each coordinate's range over all such ends is cut into eight, and an end belongs
to an attractor if its share of time in these overlaps by half or more, in every coordinate, with that of the
ends already found to belong; this is repeated until nothing changes. So coarse a comparison needs few points,
but does not separate attractors that only differ in detail.

Attractors are numbered by period, those without one last, then by their points: the numbers depend neither on
the order of the starts nor on the division of the work.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from jointplay.analysis import rules
from jointplay.analysis.exponents.growth import STATE
from jointplay.analysis.period import period
from jointplay.analysis.quantities import STATUS
from jointplay.analysis.starts import Journals, crank_place, state_names
from jointplay.analysis.states.start_plane import Starts
from jointplay.solver.mechanism.model import Model
from jointplay.solver.mechanism.records import CrankAngle
from jointplay.solver.motion.eligibility import joined_route
from jointplay.solver.motion.ensemble_runs import follow_ensemble
from jointplay.solver.motion.progress import tick
from jointplay.solver.motion.trajectory import Records, Request, follow

STRICTER = 10  # tolerance at which ends are matched over that at which a period is found
POINTS = 128  # kept of an end without a period, over all tries; more only where more turns are observed
BAD, STOPPED = STATUS.index("bad_parameters"), STATUS.index("not_converged")

BINS = 8
SHARED = 0.5


@dataclass(frozen=True)
class Observation:
    """Settings with which motions are followed to their ends.

    Parameters
    ----------
    transient, turns, patience : int
        Turns dropped, turns observed, and how often more are observed where there is no period.
    tolerance : float
        Distance of section points that count as one.
    rtol, max_steps, ensemble
        As in `basins`.
    """

    transient: int
    turns: int
    patience: int
    tolerance: float
    rtol: float
    max_steps: int | None = None
    ensemble: bool = False

    @classmethod
    def of(cls, motion: Mapping[str, Any], ensemble: bool) -> Observation:
        """The settings among the keywords of an analysis (`keywords.Recognising`)."""
        known = ("transient", "turns", "patience", "tolerance", "rtol", "max_steps")
        return cls(*(motion[name] for name in known), ensemble)


def ends(starts: Starts, nodes: np.ndarray, observation: Observation) -> dict[str, Any]:
    """Follow the starts at some nodes to their ends.

    Returns
    -------
    dict
        ``node_status``, ``period`` (0: none) and ``followed``, an entry a node; ``states``, a list of arrays:
        the states at the section, one period of them or the last that were observed; ``status``.
    """
    models = starts.all(nodes)
    status, periods, states, routes = zip(*end_states(starts.model, models, observation), strict=True)
    rows = {"node_status": status, "period": periods, "followed": routes}
    return {"status": 0, "states": list(states)} | {name: np.array(row) for name, row in rows.items()}


def end_states(
    base: Model, starts: list[Model | None], observation: Observation
) -> list[tuple[int, int, np.ndarray, int]]:
    """Status, period and section states of the ends of motions, and their routes (`ROUTES`).

    Parameters
    ----------
    base : Model
        Whose crank angle is that of the section of all motions.
    starts : list of Model or None
        Start of each motion, with its own crank angle.
    observation : Observation
        How the motions are followed.
    """
    nothing = np.zeros((0, len(base.state)))
    result = {n: (BAD, 0, nothing, 0) for n, start in enumerate(starts) if start is None}
    left = {n: (start, nothing, 1) for n, start in enumerate(starts) if start is not None}
    for again in range(1 + observation.patience):
        drop, models = 0 if again else observation.transient, [model for model, *_ in left.values()]
        cuts = section_states(base, models, drop, observation)
        for (n, (_, seen, before)), (states, status, route) in zip([*left.items()], cuts, strict=True):
            repeats = 0 if status else settled_period(features(base, states), observation.tolerance)
            route = joined_route(before, route)
            if status or repeats:
                result[n] = (status, repeats, nothing if status else states[-repeats:], route)
                del left[n]
            else:
                seen = np.concatenate([seen, states])[-max(POINTS, observation.turns) :]
                left[n] = replace(base, state=states[-1]), seen, route
    result |= {n: (0, 0, seen, route) for n, (_, seen, route) in left.items()}
    return [result[n] for n in range(len(starts))]


def settled_period(points: np.ndarray, tolerance: float) -> int:
    """The period of section points within a tolerance, where they have one within a stricter one; else 0."""
    return shortest_period(points, period(points, tolerance / STRICTER), tolerance)


def shortest_period(points: np.ndarray, longest: int, tolerance: float) -> int:
    """The smallest divisor of a period by which its points still repeat within a wider tolerance.

    A motion that spirals in may repeat best after several turns, though all its points are one by now.
    """
    last = points[-longest:]
    for q in range(1, longest):
        if longest % q == 0 and max(np.ptp(last[rest::q], axis=0).max() for rest in range(q)) <= tolerance:
            return q
    return longest


def section_states(
    base: Model, starts: list[Model], drop: int, observation: Observation
) -> list[tuple[np.ndarray, int, int]]:
    """States of each start at the section after `drop` turns (turns, states), status and route (`ROUTES`)."""
    requests = [_request(base, start, drop, observation) for start in starts]
    if observation.ensemble:
        records = follow_ensemble(starts, requests)
    else:
        records = [follow(*pair) for pair in zip(starts, requests, strict=True)]
    return [(*_states(base, each, observation.turns), each.route) for each in records]


def _request(base: Model, start: Model, drop: int, observation: Observation) -> Request:
    turns = drop + observation.turns
    limit = {"rtol": observation.rtol, "max_steps": rules.steps(observation.max_steps)}
    if base.structure.section is None:
        at = base.period * np.arange(drop + 1, turns + 1)
        return Request(at[-1], at=at, **limit)
    fields = rules.section_fields(CrankAngle(angle=math.fmod(base.crank_angle, math.tau)), start, drop)
    return Request(rules.SLACK * turns * base.period, stop_after=turns, **fields, **limit)


def _states(base: Model, records: Records, turns: int) -> tuple[np.ndarray, int]:
    """States at the section, and the status."""
    by_angle = base.structure.section is not None
    rows, first = (records.sections, STATE) if by_angle else (records.samples, 1)
    states = rows[:, first : first + len(base.state)]
    if records.status or len(states) < turns:
        return states, records.status or STOPPED
    return on_section(base, states, crank_place(base)), 0


def on_section(base: Model, states: np.ndarray, crank: int | None) -> np.ndarray:
    """States at the section, angles within half a turn of 0, the crank's (at that place) the section's."""
    states = states.copy()
    for i in np.flatnonzero(base.fold):
        states[..., i] = (states[..., i] + math.pi) % math.tau - math.pi
    if crank is not None:
        states[..., crank] = base.crank_angle
    return states


def padded(motions: Sequence[np.ndarray], coordinates: int) -> np.ndarray:
    """Section points of motions, shape (motions, points, coordinates); NaN past the last of each."""
    whole = np.full((len(motions), max(map(len, motions), default=0), coordinates), np.nan)
    for row, points in zip(whole, motions, strict=True):
        row[: len(points)] = points
    return whole


def features(model: Model, states: np.ndarray) -> np.ndarray:
    """Dimensionless coordinates by which section points are compared, shape (points, coordinates)."""
    if not model.links:
        return states
    names, n_q = state_names(model), len(model.turning)
    speeds = [n_q + i for i in range(n_q) if model.turning[i]]
    result = states[:, speeds] * model.period / math.tau
    if model.joints:
        journals = Journals(model)
        result = np.concatenate([journals.positions(states) / journals.clearances, result], axis=1)
    bent = [i for i in range(n_q) if names[i].startswith("eta_")]
    return np.concatenate([result, states[:, bent] / model.absolute[bent]], axis=1)


@dataclass(frozen=True)
class Attractors:
    """Labels of ends (0: none), and of each attractor its period (0: none) and the index of one end."""

    labels: np.ndarray
    periods: np.ndarray
    shown_by: np.ndarray


def match(periods: np.ndarray, points: list[np.ndarray], tolerance: float) -> Attractors:
    """Sort ends into attractors.

    Parameters
    ----------
    periods : ndarray of int, shape (ends,)
        0: none.
    points : list of ndarray
        Section points of each end, shape (points, coordinates); of a periodic one, one period of them. No
        points: the motion failed and has no attractor.
    tolerance : float
        Largest distance of points that count as one.

    Returns
    -------
    Attractors
    """
    ended = np.array([len(each) > 0 for each in points], dtype=bool)
    groups: list[np.ndarray] = []
    for p in np.unique(periods[ended & (periods > 0)]):
        which = np.flatnonzero(ended & (periods == p))
        groups += [which[group] for group in by_distance(np.array([points[i] for i in which]), tolerance)]
    which = np.flatnonzero(ended & (periods == 0))
    groups += [which[group] for group in by_histograms([points[i] for i in which])]
    order = sorted(groups, key=lambda group: sort_key(periods[group[0]], points[group[0]], tolerance))
    labels = np.zeros(len(points), dtype=np.int32)
    for number, group in enumerate(order, start=1):
        labels[group] = number
    first = np.array([group[0] for group in order], dtype=int)
    return Attractors(labels, periods[first], first)


def sort_key(period: int, points: np.ndarray, tolerance: float) -> tuple:
    """Sort key of an attractor: by period, then by its points, lowest first, to the tolerance."""
    coarse = np.round(points / tolerance) if period else np.round(points.mean(axis=0, keepdims=True), 1)
    return not period, int(period), sorted(map(tuple, coarse.tolist()))


def by_distance(sets: np.ndarray, tolerance: float) -> list[np.ndarray]:
    """Groups of sets of points, shape (sets, points, coordinates), each within the tolerance of its first."""
    left, groups = np.arange(len(sets)), []
    while left.size:
        tick()
        apart = set_distance(sets[left], sets[left[0]])
        groups.append(left[apart <= tolerance])
        left = left[apart > tolerance]
    return groups


def set_distance(sets: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Hausdorff distances, by largest difference in a coordinate, of sets of points from another."""
    apart = np.abs(sets[:, :, None, :] - other[None, None, :, :]).max(axis=-1)
    return np.maximum(apart.min(axis=2).max(axis=1), apart.min(axis=1).max(axis=1))


def by_histograms(clouds: list[np.ndarray]) -> list[np.ndarray]:
    """Groups of clouds of points with similar histograms."""
    if not clouds:
        return []
    shares, left, groups = histograms(clouds), np.arange(len(clouds)), []
    while left.size:
        inside = np.zeros(len(left), dtype=bool)
        inside[0], before = True, 0
        while inside.sum() > before:
            tick()
            before, mean = inside.sum(), shares[left[inside]].mean(axis=0)
            overlap = np.minimum(shares[left], mean).sum(axis=-1).min(axis=-1)
            inside |= overlap >= SHARED
        groups.append(left[inside])
        left = left[~inside]
    return groups


def histograms(clouds: list[np.ndarray]) -> np.ndarray:
    """Fraction of each cloud's points in each bin of each coordinate, shape (clouds, coordinates, bins)."""
    low = np.min([cloud.min(axis=0) for cloud in clouds], axis=0)
    size = np.max([cloud.max(axis=0) for cloud in clouds], axis=0) - low
    size = np.where(size > 0, size, 1.0) / BINS
    result = np.zeros((len(clouds), len(low), BINS))
    for shares, cloud in zip(result, clouds, strict=True):
        for axis, cells in enumerate(np.minimum((cloud - low) / size, BINS - 0.5).astype(int).T):
            shares[axis] = np.bincount(cells, minlength=BINS) / len(cells)
    return result
