"""Follow an ensemble: many models of one structure, eight at once, as sweeps and fields of starts need them.

The method is Radau IIA with five stages, each lane of the processor's vectors a motion of its own, with
numbers, mode and step of its own (method.lanes). Reference: Hairer and Wanner, Solving Ordinary
Differential Equations II, section IV.8. Validity: what nothing keeps from lanes (motion.eligibility).
Whatever else is asked for is followed one by one, and so is a motion that lanes cannot finish: a body that
rests on a wall, a loop at its dead centre.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from jointplay.display.errors import InputError, Problem
from jointplay.solver.codegen import cache, outputs
from jointplay.solver.codegen.lanes import EXCLUSIONS
from jointplay.solver.equations.parameters import parameter_names
from jointplay.solver.mechanism.assemble import linkage
from jointplay.solver.mechanism.model import Model
from jointplay.solver.mechanism.records import Mechanism, TestSystem
from jointplay.solver.method.codes import Row, Status
from jointplay.solver.method.lanes import CLOCK, PHASE
from jointplay.solver.motion.eligibility import IN_LANES, LEFT, RTOL, exclusion, structure_exclusion
from jointplay.solver.motion.trajectory import (
    Records,
    Request,
    counts,
    follow,
    in_pieces,
    pace,
    row,
    run_of,
    scratch,
    wall_unit,
)

LOG_ROWS = 8192
AT_EVENTS = ("contacts", "trig", "reset")  # functions of a structure at one point; a wall needs its rate too
FEWEST = 16  # motions side by side that fill the lanes of two workers
LATE = 1e-6  # of a period that a run lasts beyond its last sample


def ensemble_fits(mechanism: Mechanism | TestSystem, ensemble: bool | None, rtol: float) -> list[Problem]:
    """Rule: motions of the mechanism can be followed eight at once, where `ensemble` wants it."""
    if ensemble and (found := _exclusion(mechanism)):
        expected = f"false is accepted: motions side by side cannot have {EXCLUSIONS[found]}"
        return [Problem("ensemble", ensemble, expected)]
    if ensemble and not rtol >= RTOL:
        return [Problem("ensemble", ensemble, f"true is accepted at an rtol of {RTOL:g} or more")]
    return []


def in_lanes(ensemble: bool | None, mechanism: Mechanism | TestSystem, rtol: float, count: int) -> bool:
    """Whether `count` motions side by side go in lanes: by `ensemble`, else where they can and fill them."""
    if ensemble is not None:
        return ensemble
    return count >= FEWEST and not ensemble_fits(mechanism, True, rtol)


def _exclusion(mechanism: Mechanism | TestSystem) -> str:
    """Why the structure of a mechanism cannot be batched; empty where it can, or cannot be assembled."""
    try:
        given = linkage(mechanism) if isinstance(mechanism, Mechanism) else mechanism.structure()
    except InputError:
        return ""
    return structure_exclusion(given)


def follow_ensemble(models: Sequence[Model], requests: Sequence[Request]) -> list[Records]:
    """Follow the motions of models as requested, eight at once where that can be.

    Motions of one structure share lanes; a motion's numbers are the same to the last bit beside any others.
    What eight at once cannot do (`eligibility.exclusion`) is followed one by one.

    Returns
    -------
    list of Records
        As motion.trajectory.follow gives them, in order; of those in lanes, `samples` is the row at the
        end, and the wall time a mean.
    """
    pairs, groups = list(zip(models, requests, strict=True)), {}
    for n, pair in enumerate(pairs):
        groups.setdefault(None if exclusion(*pair) else pair[0].structure, []).append(n)
    records = {n: follow(*pairs[n]) for n in groups.pop(None, [])}
    for group in groups.values():
        records |= zip(group, _in_lanes([pairs[n] for n in group])[0], strict=True)
    return [records[n] for n in range(len(pairs))]


@dataclass(frozen=True)
class Vectors:
    """Tangents to be carried along: their start, rows; the scales of the states, and their tolerance.

    Rows are recorded from `begin` s on, a `block` s apart (method.tangents.tangent).
    """

    start: np.ndarray
    scale: np.ndarray
    begin: float
    block: float
    tolerance: float
    limit: float


@dataclass(frozen=True)
class Carried:
    """A motion with its tangents: records (None: it did not end), rows of growth, the closest grazing."""

    records: Records | None
    rows: np.ndarray
    grazing: float


def carry(models: Sequence[Model], requests: Sequence[Request], tangents: Sequence[Vectors]) -> list[Carried]:
    """Follow motions of one structure, each of which suits, with as many tangents each."""
    return _in_lanes(list(zip(models, requests, strict=True)), tangents)[1]


def _in_lanes(pairs: list[tuple[Model, Request]], given: Sequence[Vectors] = ()) -> tuple[list, list]:
    """Motions of one structure in lanes, and their tangents."""
    from jointplay.solver.method.control import FULL
    from jointplay.solver.method.interface import OPTIONS, TRAJECTORY, WORK, table
    from jointplay.solver.method.lanes import memory
    from jointplay.solver.method.lanes.layout import LOGGED, PASSED_BY, PAUSE

    began, models, form = time.perf_counter(), [model for model, _ in pairs], Form.of(pairs[0][0])
    requested, pairs = pairs, [(model, form.by_sections(model, request)) for model, request in pairs]
    name = "lanes.tangent_flow" if given else "lanes.flow"
    called = ["lanes.attempts", "lanes.lane", name, wall_unit(models[0].structure)]
    misses = any(request.misses for _, request in pairs)
    for each in filter(None, [*called, "lanes.approaches" * misses]):
        cache.prepare(each)
    vectorised, rows = _functions(models[0], form)  # compiled here while others compile the loop
    derivatives = _variations(models[0]) if given else None
    functions = _at_events(models[0])
    run, parts = cache.method(name).flow, _parts(misses)
    work = scratch(models[0].structure, more=1)  # a row for the section
    width = len(row(run_of(*pairs[0])[0]))
    log = memory.shared_log(LOG_ROWS, width)
    runs = [run_of(*pair, log) for pair in pairs]
    kinds = zip((WORK, TRAJECTORY, OPTIONS), ([work], *zip(*runs, strict=True)), strict=True)
    phases = np.array([form.turned(model) for model in models])
    jobs = memory.jobs([table(*each) for each in kinds], phases, np.zeros((len(models), width)), log)
    lanes = memory.lanes(rows, np.array(form.turning), form.crank, models[0].memories, form.sizes)
    tangents, frame = _started(given) if given else (None, None)
    place = jobs.place
    logs = [[log[:0, :-1]] for _ in models]
    grown = [[tangents.rows[:0, :-1]] for _ in models] if tangents else []

    def call(pause: int) -> int:
        place[PAUSE] = pause
        return run(functions, parts, vectorised, lanes, jobs, derivatives, tangents, frame)

    def take() -> None:
        _hand_out(log[: place[LOGGED]], logs)
        place[LOGGED] = 0
        if tangents is not None:
            _hand_out(tangents.rows[: tangents.count[0]], grown)
            tangents.count[0] = 0

    own = pace(models[0].structure, name, len(given[0].start) if given else 0)
    in_pieces(call, lambda: int(place[PASSED_BY]), own, FULL, math.inf, take)
    each, found = (time.perf_counter() - began) / len(models), []
    for n, (model, request) in enumerate(requested):
        if jobs.status[n] != Status.OK:  # it steps aside, or failed: by itself it may go on
            found.append(None if given else replace(follow(model, request), route=LEFT))
        else:
            log_of = np.concatenate(logs[n])
            found.append(_records(runs[n][0], jobs.start[n], log_of, each, len(request.at) > 1))
    if tangents is None:
        return found, []
    carried = zip(found, map(np.concatenate, grown), tangents.grazing.tolist(), strict=True)
    return found, [Carried(*one) for one in carried]


def _hand_out(rows: np.ndarray, to: list[list[np.ndarray]]) -> None:
    """Copy rows to their motions, whose number is in the last column, without that."""
    rows = rows[np.argsort(rows[:, -1], kind="stable")]
    begins = np.flatnonzero(np.diff(rows[:, -1], prepend=-1.0))
    for part in np.split(rows, begins[1:]) if len(rows) else ():
        to[int(part[0, -1])].append(part[:, :-1])


def _variations(model: Model) -> tuple:
    """Functions that carry tangents."""
    from jointplay.solver.method.interface import pointers
    from jointplay.solver.method.lanes.layout import Variations

    size, gradients = cache.ensemble_tangents(len(model.turning)), cache.variation_module(model.structure)
    return pointers(gradients, size, kind=Variations)


def _started(tangents: Sequence[Vectors]) -> tuple:
    """Tangents as the loop carries them, and a frame."""
    from jointplay.solver.method.lanes.tangent import frame
    from jointplay.solver.method.lanes.tangent import tangents as carried

    starts, scales = (np.array([getattr(each, name) for each in tangents]) for name in ("start", "scale"))
    real = np.array([[each.begin, each.block, each.tolerance, each.limit] for each in tangents])
    return carried(starts, scales, real, LOG_ROWS), frame(*starts.shape[1:])


def _functions(model: Model, form: Form) -> tuple:
    """Functions of a structure in lanes; rows of these."""
    from jointplay.solver.method.interface import pointers
    from jointplay.solver.method.lanes.layout import Functions

    module = cache.ensemble_module(model.structure)
    sizes = form.sizes["contacts"], form.sizes["resets"], form.sizes["folds"], form.crank
    return pointers(module, cache.ensemble_algebra(form.turning, *sizes), kind=Functions), module.ROWS


def _at_events(model: Model) -> tuple:
    """Functions of a structure at one point, as many as events need."""
    from jointplay.solver.method.interface import Functions
    from jointplay.solver.method.lanes.memory import nothing

    module, unit = cache.structure_module(model.structure), wall_unit(model.structure)
    needed = AT_EVENTS + ("rate",) * bool(unit)
    found = {name: getattr(module, name) if name in needed else nothing for name in Functions._fields}
    return Functions(**found | {"at_wall": cache.method(unit).at_wall} if unit else found)


def _parts(approaches: bool):
    """The parts of the loop that it calls by address, compiled alone where they are so."""
    from jointplay.solver.method.lanes.layout import Parts
    from jointplay.solver.method.lanes.memory import nothing

    lane = cache.method("lanes.lane")
    own = cache.method("lanes.approaches").approaches if approaches else nothing
    return Parts(lane.enter, lane.event, lane.leave, cache.method("lanes.attempts").special, own)


def _records(motion, start: np.ndarray, log: np.ndarray, seconds: float, sampled: bool) -> Records:
    """Records of a trajectory; its section points are the samples where `sampled`."""
    kinds, end = {tag: log[log[:, 0] == tag, 1:] for tag in Row}, row(motion)
    samples = end[None, :]
    if sampled:
        samples, kinds[Row.SECTION] = kinds[Row.SECTION][:, 2:], kinds[Row.SECTION][:0]
    return Records(samples, *kinds.values(), start, end, int(Status.OK), seconds, counts(motion), IN_LANES)


@dataclass(frozen=True)
class Form:
    """Form of a structure, as lanes need it.

    Parameters
    ----------
    phases : tuple of str
        Angles that turn by themselves, before the positions.
    sizes : dict
        Of its module (codegen.module).
    memories : int
        How many speeds are what laws of contact remember.
    turns : tuple of float
        1 where a position is an angle.
    crank : int
        Place of the angle or phase that sections cut.
    """

    phases: tuple[str, ...]
    sizes: dict[str, int]
    memories: int
    turns: tuple[float, ...]
    crank: int

    @classmethod
    def of(cls, model: Model) -> Form:
        """The form of a model's structure."""
        module, own = cache.ensemble_module(model.structure), cache.structure_module(model.structure)
        turns = tuple(float(turn) for turn in model.turning[: own.SIZES["positions"]])
        phases, crank = tuple(module.PHASES), f"theta_{model.crank}"
        place = len(phases) + own.STATE.index(crank) - 1 if crank in own.STATE else 0
        return cls(phases, own.SIZES, model.memories, turns, place)

    @property
    def unused(self) -> int:
        """Positions on which nothing depends, whose speeds are states of first order."""
        return self.sizes["speeds"] - self.memories - self.sizes["positions"]

    @property
    def turning(self) -> tuple[float, ...]:
        """Kind of bound on the turn of each position in a step."""
        return (PHASE,) * len(self.phases) + self.turns + (0.0,) * self.unused

    def turned(self, model: Model) -> np.ndarray:
        """Phases at the start, then their rates."""
        now, later = self._phases(model)
        return np.concatenate([now, later - now])

    def _phases(self, model: Model) -> np.ndarray:
        """Phases at the times 0 and 1, shape (2, phases)."""
        if model.links:  # of a crank whose speed is imposed, and of loads
            numbers = dict(zip(parameter_names(model.structure), model.numbers, strict=True))
            names = [f"nu_{name.removeprefix('phase_')}" for name in self.phases]
            rates = [numbers.get(name, model.crank_speed) for name in names]
            first = [model.crank_angle if name == model.crank else 0.0 for name in self.phases]
            return first + np.outer([0.0, 1.0], rates)
        own = [name for name in self.phases if name != CLOCK]
        module = cache.structure_module(model.structure)
        given = dict(zip(module.STATE, [np.array([0.0, 1.0]), *model.state], strict=False))
        given |= dict(zip(module.PARAMETERS, model.numbers, strict=True))
        found = outputs.evaluate(module, own, given) if own else {}
        found[CLOCK] = np.array([0.0, math.tau / model.period])
        return np.array([np.broadcast_to(found[name], 2) for name in self.phases]).reshape(-1, 2).T

    def by_sections(self, model: Model, request: Request) -> Request:
        """The request, with samples at even times as section points of the first phase."""
        if len(request.at) < 2:
            return request
        rate = np.diff(self._phases(model)[:, 0])[0]
        first, far = rate * request.at[0], abs(rate) * (request.at[1] - request.at[0])
        end = request.at[-1] + LATE * model.period
        cut = {"at": request.at[:0], "level": first, "period": far, "direction": int(np.sign(rate))}
        return replace(request, duration=end, skip=0, stop_after=len(request.at), **cut)
