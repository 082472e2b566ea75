"""Follow an ensemble: many models of one structure, eight at once, as sweeps and fields of starts need them.

The method is Radau IIA with five stages, each lane of the processor's vectors a motion of its own, with
numbers, mode and step of its own (numerics.ensemble). Reference: Hairer and Wanner, Solving Ordinary
Differential Equations II, section IV.8. Validity: structures that codegen.ensemble knows (rigid links, one to
three joints with clearance), rtol from 1e-8 up; whatever else is asked for is followed one by one.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from jointplay.analysis import guard_tolerances
from jointplay.analysis.pieces import in_pieces, pace
from jointplay.analysis.quantities import COUNTERS
from jointplay.analysis.trajectory import Records, Request, follow
from jointplay.codegen import cache
from jointplay.codegen.ensemble import known
from jointplay.errors import InputError, Problem
from jointplay.mechanism.model import Model
from jointplay.mechanism.records import Mechanism, TestSystem
from jointplay.mechanism.structure import linkage
from jointplay.numerics.codes import Row

RTOL = 1e-8  # sharper is for the method of higher order, one trajectory at a time
LOG_ROWS = 8192
FEWEST = 16  # motions side by side that fill the lanes of two workers
ACCEPTED = (
    "false is accepted, or true for a rigid linkage that a motor or a constant torque turns, with play in "
    "one to three revolute joints, without ideal loops, impacts, bristles, or what varies with time, at an "
    f"rtol of {RTOL:g} or more"
)


def ensemble_fits(mechanism: Mechanism | TestSystem, ensemble: bool | None, rtol: float) -> list[Problem]:
    """Rule: motions of the mechanism can be followed eight at once, where `ensemble` asks for it."""
    fit = not ensemble or (rtol >= RTOL and isinstance(mechanism, Mechanism) and _fits(mechanism))
    return [] if fit else [Problem("ensemble", ensemble, ACCEPTED)]


def in_lanes(ensemble: bool | None, mechanism: Mechanism | TestSystem, rtol: float, count: int) -> bool:
    """Whether `count` motions side by side go in lanes: as asked, or where they can and fill them."""
    if ensemble is not None:
        return ensemble
    return count >= FEWEST and not ensemble_fits(mechanism, True, rtol)


def _fits(mechanism: Mechanism) -> bool:
    """Whether the structure of its equations goes in lanes."""
    try:
        return known(linkage(mechanism))
    except InputError:
        return True  # a mechanism that cannot be assembled says so when it is


def follow_ensemble(models: Sequence[Model], requests: Sequence[Request]) -> list[Records]:
    """Follow the motions of models as requested, eight at once where that can be.

    Motions of one structure share lanes; a motion's numbers are the same to the last bit in any company. What
    eight at once cannot do (`suits`) is followed one by one.

    Returns
    -------
    list of Records
        As analysis.trajectory.follow gives them, in order; of those in lanes, `samples` is the row at the
        end, and the wall time a mean.
    """
    pairs, groups = list(zip(models, requests, strict=True)), {}
    for n, pair in enumerate(pairs):
        groups.setdefault(pair[0].structure if suits(*pair) else None, []).append(n)
    records = {n: follow(*pairs[n]) for n in groups.pop(None, [])}
    for group in groups.values():
        records |= zip(group, _in_lanes([pairs[n] for n in group])[0], strict=True)
    return [records[n] for n in range(len(pairs))]


def suits(model: Model, request: Request) -> bool:
    """Whether this can be followed beside others: a structure that is known, at a moderate rtol."""
    from jointplay.numerics.ensemble.radau import MAX_TURN

    if not known(model.structure):
        return False
    asked = not (len(request.at) or request.steps or request.event >= 0 or request.rates)
    whole = request.log_from <= 0 or not (request.events or request.misses)
    ahead = (request.level - model.state[0]) * request.direction > 0
    section = request.direction == 0 or (ahead and request.period > MAX_TURN)  # one in a step
    if not (asked and section and whole and request.rtol >= RTOL and model.h_max == np.inf):
        return False
    n = len(model.turning)
    return bool(np.all(model.relative[:n] == 0.0) and np.all(model.relative[n:] == 1.0))


@dataclass(frozen=True)
class Tangent:
    """A tangent to be carried along: its start, the scales of the states, and what is tolerated of it.

    Rows are recorded from `begin` s on, a `block` s apart (numerics.tangent).
    """

    start: np.ndarray
    scale: np.ndarray
    begin: float
    block: float
    tolerance: float
    limit: float


@dataclass(frozen=True)
class Carried:
    """A motion with its tangent: records, rows of growth, the closest grazing."""

    records: Records
    rows: np.ndarray
    grazing: float


def carry(models: Sequence[Model], requests: Sequence[Request], tangents: Sequence[Tangent]) -> list[Carried]:
    """Follow motions of one structure, each of which suits, with a tangent beside each."""
    return _in_lanes(list(zip(models, requests, strict=True)), tangents)[1]


def _in_lanes(pairs: list[tuple[Model, Request]], tangents: Sequence[Tangent] = ()) -> tuple[list, list]:
    """Motions of one structure in lanes, and their tangents."""
    from jointplay.numerics.ensemble.layout import LOGGED, PASSED_BY, PAUSE
    from jointplay.numerics.interface import direct

    began, models = time.perf_counter(), [model for model, _ in pairs]
    name = "ensemble.tangent_flow" if tangents else "ensemble.flow"
    flow, f, g, rows, flags = _kernels(models[0], name)
    real = np.array([_real(*pair) for pair in pairs])
    whole = np.array([_whole(request) for _, request in pairs], dtype=np.int64)
    states, numbers = (np.array([getattr(model, name) for model in models]) for name in ("state", "numbers"))
    jobs = flow.jobs(states, numbers, real, whole, len(flags), LOG_ROWS)
    lanes = flow.lanes(rows, numbers.shape[1], models[0].turning.copy(), models[0].memories, flags)
    v, y = _with(tangents, models[0], flow) if tangents else (None, None)
    parts, grown, run, place = [], [], direct(flow.flow), jobs.place

    def call(pause: int) -> int:
        place[PAUSE] = pause
        return run(f, g, lanes, jobs, v, y)

    def take() -> None:
        parts.append(jobs.log[: place[LOGGED]].copy())
        place[LOGGED] = 0
        if y is not None:
            grown.append(y.rows[: y.count[0]].copy())
            y.count[0] = 0

    own = pace(models[0].structure, name, len(tangents) and 1)
    in_pieces(call, lambda: int(place[PASSED_BY]), own, flow.FULL, math.inf, take)
    each, logs = (time.perf_counter() - began) / len(models), _by_motion(parts, len(models))
    records = [_records(jobs, n, log, each) for n, log in enumerate(logs)]
    if y is None:
        return records, []
    found = zip(records, _by_motion(grown, len(models)), y.grazing.tolist(), strict=True)
    return records, [Carried(*one) for one in found]


def _by_motion(parts: list[np.ndarray], count: int) -> list[np.ndarray]:
    """Rows of each motion, whose number is in the first column, without that."""
    rows = np.concatenate(parts)
    rows = rows[np.argsort(rows[:, 0], kind="stable")]
    cuts = np.searchsorted(rows[:, 0], np.arange(count + 1))
    return [rows[cuts[n] : cuts[n + 1], 1:] for n in range(count)]


def _with(tangents: Sequence[Tangent], model: Model, flow) -> tuple:
    """Functions that carry tangents, and these."""
    from jointplay.numerics.ensemble.layout import SIGNATURES, Variations
    from jointplay.numerics.interface import pointers

    size, own = cache.ensemble_tangents(model.structure, len(model.turning))
    gradients = cache.variation_module(model.structure)
    v = pointers(gradients, size, own, kind=Variations, signatures=SIGNATURES)
    starts, scales = (np.array([getattr(each, name) for each in tangents]) for name in ("start", "scale"))
    real = np.array([[each.begin, each.block, each.tolerance, each.limit] for each in tangents])
    return v, flow.tangents(starts, scales, real, LOG_ROWS)


def _kernels(model: Model, loop: str) -> tuple:
    """The loop; functions of a structure at a point, and in lanes; rows of these; flags of its contacts."""
    from jointplay.numerics.ensemble.layout import SIGNATURES, AtPoint, Functions
    from jointplay.numerics.interface import pointers

    cache.prepare(loop)
    structure, turning = model.structure, tuple(bool(turns) for turns in model.turning)
    module, own = cache.ensemble_module(structure), cache.structure_module(structure)
    flags = np.array([*own.CONTACTS.values()], dtype=np.int64)
    f = pointers(own, kind=AtPoint, signatures=SIGNATURES)
    algebra = cache.ensemble_algebra(turning, len(flags))
    g = pointers(module, algebra, kind=Functions, signatures=SIGNATURES)
    return cache.method(loop), f, g, module.ROWS, flags


def _real(model: Model, request: Request) -> list[float]:
    """Numbers of a trajectory, in the order of numerics.ensemble.layout."""
    rest, contacts = guard_tolerances.rest(model, request.rtol), len(model.joints)
    gap, force = guard_tolerances.guards(model, rest, contacts, 0).reshape(contacts, 4)[:, :2].T
    squares = guard_tolerances.clearances_squared(model, contacts)
    times = [float(request.duration), request.rtol, rest, 1e-7 * model.period, 1e-5 * model.period]
    floors = request.rtol * model.absolute[: 2 * len(model.turning)]
    own = np.column_stack([guard_tolerances.cones(model), gap, force, squares])
    return [*times, request.level, request.period, *floors, *own.ravel()]


def _whole(request: Request) -> list[int]:
    """Whole numbers of a trajectory, in the order of numerics.ensemble.layout."""
    cut = [request.direction, request.skip, request.stop_after]
    return [*cut, request.max_steps, int(request.events), int(request.misses)]


def _records(jobs, n: int, log: np.ndarray, seconds: float) -> Records:
    from jointplay.numerics.ensemble.layout import C_STATUS

    kinds = [log[log[:, 0] == tag, 1:] for tag in Row]
    counts = {name: int(jobs.count[n, place]) for place, name in enumerate(COUNTERS)}
    status = int(jobs.count[n, C_STATUS])
    return Records(jobs.final[n : n + 1], *kinds, jobs.start[n], status, seconds, counts, 1)
