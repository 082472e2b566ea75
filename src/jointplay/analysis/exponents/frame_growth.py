"""Growth of a frame of tangents along a motion, recorded block by block, to estimate exponents from.

One motion at a time, or eight motions in the lanes of an ensemble (motion.ensemble_runs), whose method is
another and whose numbers differ within the tolerance.

Exponents of a section's map, from the growth of tangents along the flow.

Where nothing outside keeps the time, the direction of the motion itself, F = dx/dt, is carried along by the
tangent flow and through every event (S F- = F+): it neither grows nor shrinks in the long run, and has the
exponent 0. A section's map has the other exponents, times the length of a turn. The volume of F and j
tangents is |F| times the volume of what these have across F, and this grows as the sum of the section map's
first j exponents, exactly, whichever section is taken. So the frame has F as its first tangent
(method.tangents.tangent), and those after it give the map's exponents.

Validity: a motion that comes to rest has no section, and its exponents are NaN. Reference: Benettin et al.,
Meccanica 15 (1980) 9-20; Pikovsky and Politi, Lyapunov Exponents (2016), chapter 2.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from jointplay.analysis.exponents import batch_means
from jointplay.analysis.labels import Out
from jointplay.analysis.starts import crank_place
from jointplay.analysis.tangents import Bundle, scales, tolerated
from jointplay.solver.codegen import cache
from jointplay.solver.equations.drives import DRIVES
from jointplay.solver.equations.structure import Oscillator
from jointplay.solver.mechanism.model import Model
from jointplay.solver.motion import eligibility
from jointplay.solver.motion.eligibility import LEFT, exclusion, route_of
from jointplay.solver.motion.ensemble_runs import Carried, Vectors, carry, follow_ensemble
from jointplay.solver.motion.progress import Stopped
from jointplay.solver.motion.trajectory import INTERRUPTED, Records, Request, counts

LOOKS = 10  # how often a target error is looked at
SEED = 20
OK = 0
USABLE = (OK, INTERRUPTED)  # ends of a run whose means are those of the time that it reached
SOLVED = 3.0  # tolerance of the tangents' iteration, in units of rtol

STILL = math.log(1e-6)  # fall of the speed at which a motion counts as having come to rest


@dataclass(frozen=True)
class Stretch:
    """A run in which exponents are to be measured.

    Parameters
    ----------
    request : Request
        Length, tolerance and limits, without records.
    count : int
        Exponents.
    begin : float
        Time in s in which tangents find their directions before.
    """

    request: Request
    count: int
    begin: float


@dataclass(frozen=True)
class Stretched:
    """Rows of growing tangents (`batch_means`), their logarithms' columns, and the end of the run.

    `neutral`: the first tangent is the rate of the state itself; `rested`: it was, until the motion came to
    rest. `route`: as of trajectory.Records.
    """

    model: Model
    rows: np.ndarray
    logs: slice
    neutral: bool
    rested: bool
    grazing: float
    status: int
    wall_time: float
    counts: dict[str, int]
    route: int = 0

    @property
    def carried(self) -> slice:
        """Columns of the tangents that are not the motion's own direction."""
        return slice(self.logs.start + self.neutral, self.logs.stop)

    @property
    def turn_period(self) -> float:
        """Mean length of a turn."""
        return turn_period(self.model, self.rows)

    def leading(self, count: int) -> dict[str, Any]:
        """Values of `batch_means.estimates` and `of_the_section`, of so many exponents."""
        turn = self.turn_period
        return batch_means.estimates(*of_the_flow(self, count), turn) | of_the_section(self, turn)


def of_the_section(run: Stretched, turn: float) -> dict[str, np.ndarray]:
    """Values of `OUTS`, the largest first; `turn` is the length of a turn in s."""
    found, model = batch_means.estimates(run.rows, run.carried, turn), run.model
    if run.rested:
        vectors = run.logs.stop - run.logs.start
        none = np.full(min(vectors, len(model.state) - model.followers - 1), np.nan)
        found = dict.fromkeys(found, none)
    turns = (run.rows[-1, 0] - run.rows[0, 0]) / turn if len(run.rows) else math.nan
    return {new: found[old] for new, old in OF_THE_FLOW.items()} | {"exponent_turns": turns}


def of_the_flow(run: Stretched, count: int) -> tuple[np.ndarray, slice]:
    """Rows with the logarithms of the `count` directions that grow fastest, these first; their columns."""
    rows, logs = run.rows, run.logs
    order = np.argsort(-batch_means.growth(rows, logs))[:count]
    columns = (rows[:, : logs.start], rows[:, logs][:, order], rows[:, logs.stop :])
    return np.column_stack(columns), slice(logs.start, logs.start + count)


def grown(
    model: Model,
    stretch: Stretch,
    error: float | None = None,
    saltation: bool = True,
    progress: Callable[[float], None] | None = None,
) -> Stretched:
    """Follow a motion with the tangents that exponents need.

    Where the motion comes to rest, its rate is no direction any more, and it is followed anew without that.
    """
    if error is None and saltation and (run := eligibility.batched_answer(model, stretch)) is not None:
        return run
    timeless = has_no_clock(model)
    for neutral in (True, False) if timeless else (False,):
        bundle = framed(model, stretch.request, stretch.count, saltation, neutral)
        bundle.advance(0.0)
        start = float(bundle.tangents.logs[0])
        rows, ended = follow(bundle, stretch.begin, error, progress)
        if not neutral or moves(start, float(bundle.tangents.logs[0])):
            break
    kept = {"neutral": neutral, "rested": timeless and not neutral, "grazing": bundle.grazing}
    excluded = exclusion(model, stretch.request) or ("" if _alike(model) else "exponents")
    return Stretched(model, rows, bundle.logs, **kept, **ended, route=route_of(excluded))


def _alike(model: Model) -> bool:
    """Whether lanes can carry the tangents: those of an autonomous linkage without memories."""
    return bool(model.links and not model.memories) and has_no_clock(model)


def grown_together(models: Sequence[Model], stretches: Sequence[Stretch]) -> list[Stretched]:
    """Follow motions as `grown` does, eight at once where that can be; the others one by one.

    Motions of one structure share lanes. A motion that comes to rest, that fails there, or whose tangent an
    ensemble cannot follow, is followed anew by itself.
    """
    groups: dict[Any, list[int]] = {}
    for n, (model, one) in enumerate(zip(models, stretches, strict=True)):
        if not exclusion(model, one.request) and _alike(model):
            groups.setdefault((model.structure, one.count), []).append(n)
    found: dict[int, Stretched | None] = {}
    for group in groups.values():
        some, own = [models[n] for n in group], [stretches[n] for n in group]
        carried = carry(some, [one.request for one in own], list(map(_vectors, some, own)))
        found |= zip(group, map(_stretched, some, carried), strict=True)
    alone = {n: grown(*two) for n, two in enumerate(zip(models, stretches, strict=True)) if not found.get(n)}
    alone |= {n: replace(run, route=LEFT) for n, run in alone.items() if n in found}
    return [alone.get(n) or found[n] for n in range(len(models))]


def followed_together(questions: Sequence[tuple[Model, Request | Stretch]]) -> list[Records | Stretched]:
    """Follow motions side by side, motions with tangents in lanes of their own (motion.eligibility)."""
    found: dict[int, Records | Stretched] = {}
    for kind, together in ((Request, follow_ensemble), (Stretch, grown_together)):
        some = [n for n, (_, one) in enumerate(questions) if isinstance(one, kind)]
        if some:
            found |= zip(some, together(*zip(*(questions[n] for n in some), strict=True)), strict=True)
    return [found[n] for n in range(len(questions))]


def _vectors(model: Model, stretch: Stretch) -> Vectors:
    """The tangents that `framed` has besides the motion's own."""
    scale, request = scales(model), stretch.request
    block = (request.duration - stretch.begin) / batch_means.BLOCKS
    limits = SOLVED * request.rtol, tolerated(model.structure, request.rtol)
    return Vectors(frame(1 + stretch.count, scale)[1:], scale, stretch.begin, block, *limits)


def _stretched(model: Model, run: Carried) -> Stretched | None:
    """A motion in lanes as one of `grown`; None where it has to be followed by itself."""
    rows, records = run.rows, run.records
    logs = slice(batch_means.SUMS.stop, rows.shape[1] - len(model.state))
    if records is None or not len(rows) or np.isnan(rows).any() or not moves(*rows[[0, -1], logs.start]):
        return None
    ended = {name: getattr(records, name) for name in ("status", "wall_time", "counts", "route")}
    return Stretched(model, rows, logs, True, False, run.grazing, **ended)


def frame(count: int, scale: np.ndarray, last: int = 0, seed: int = SEED) -> np.ndarray:
    """Reproducible random frame of `count` tangents, orthonormal in scales' units, 0 in `last` states."""
    size = len(scale) - last
    random = np.random.default_rng(seed).normal(size=(size, size))
    return np.pad(np.linalg.qr(random)[0].T[:count], ((0, 0), (0, last))) * scale


def framed(
    model: Model, request: Request, count: int, saltation: bool = True, neutral: bool = False
) -> Bundle:
    """Prepare a run with `count` tangents, and the motion's own before them where that is neutral.

    None has a part in what laws of contact remember at the start, or in modes.
    """
    wanted, tolerance = frame(count + neutral, scales(model), model.followers), SOLVED * request.rtol
    rows = batch_means.BLOCKS // LOOKS
    return Bundle(model, request, wanted, tolerance, saltation, rows=rows, neutral=neutral)


def follow(
    bundle: Bundle, begin: float, error: float | None = None, progress: Callable[[float], None] | None = None
) -> tuple[np.ndarray, dict[str, Any]]:
    """Follow the transient, then blocks until the end, the target error or a failure: rows, and the end."""
    began, status, end = time.perf_counter(), OK, bundle.request.duration

    def go_on(until: float = math.inf) -> int:
        try:
            return bundle.advance(until, tell)
        except Stopped:
            return INTERRUPTED

    def tell() -> None:
        if progress is not None:
            progress(bundle.time / end)

    for until in (begin / 2, begin) if bundle.model.followers else (begin,):
        status = go_on(until) if status == OK else status
        bundle.forget()  # what entries left in tangents, before these find their directions
    kept = bundle.row()
    bundle.record((end - begin) / batch_means.BLOCKS)
    while status == OK:
        status = go_on()
        kept = np.concatenate([kept, bundle.taken()])
        if status != bundle.full:
            break
        status = OK
        if error is not None and batch_means.settled(kept, bundle.carried, error):
            break
    if status in USABLE and bundle.time > kept[-1, 0]:
        kept = np.concatenate([kept, bundle.row()])
    ended = {"status": status, "wall_time": time.perf_counter() - began, "counts": counts(bundle.motion)}
    return kept, ended


def turn_period(model: Model, rows: np.ndarray) -> float:
    """Mean length of a turn: of the crank where its angle is a state, else the nominal period."""
    crank = crank_place(model)
    if crank is None or len(rows) < 2:
        return model.period
    at = rows.shape[1] - len(model.state) + crank
    return 2 * math.pi * float((rows[-1, 0] - rows[0, 0]) / abs(rows[-1, at] - rows[0, at]))


def has_no_clock(model: Model) -> bool:
    """Whether nothing outside keeps the time, so that one exponent of the flow is 0.

    By structure, since rates may not tell: in flight, what is driven by contact alone feels no drive.
    """
    structure = model.structure
    if isinstance(structure, Oscillator):
        return "phase" not in cache.structure_module(structure).OUTPUTS
    drive, loads = DRIVES[structure.drive], structure.loads
    return not (drive.imposed or drive.follows or any(load.course.timed for load in loads))


def moves(start: float, end: float) -> bool:
    """Whether a motion still moves, by ln|F| where it began and at the end."""
    return bool(start > -math.inf and end - start >= STILL)


_NAME = "exponent of the section's map"


OUTS = {
    "section_exponent": Out("multiplier", f"{_NAME}, over the length of a turn", "s-1"),
    "section_standard_error": Out("multiplier", f"standard error of the {_NAME}", "s-1"),
    "section_exponent_per_turn": Out("multiplier", f"{_NAME}, per turn", about="without the flow's zero"),
    "section_standard_error_per_turn": Out("multiplier", f"standard error of the {_NAME}, per turn"),
    "section_batch_correlation": Out("multiplier", f"correlation of a batch mean with the next, {_NAME}"),
}


OF_THE_FLOW = dict(zip(OUTS, batch_means.ESTIMATES, strict=False))  # what is the same of the flow
OUTS |= {"exponent_turns": Out((), "turns over which exponents are means")}


NUMBER = "number of the exponent of the section's map, the largest first"
