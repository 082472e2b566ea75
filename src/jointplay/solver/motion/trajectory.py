"""Follow a model's motion, by one flow, and return its records.

Compiled loops run in pieces, so that Python can report and stop (motion.progress) between them.

While compiled code runs, no handler of a signal does, and no progress is reported. So each loop is called for
as many attempts at a time as took `PIECE` s so far. A loop that stopped at its limit goes on where it was
left (method.memory), to the last bit as if it had not stopped: no answer depends on the pieces.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from jointplay.solver.codegen import cache
from jointplay.solver.equations.structure import Linkage, Oscillator
from jointplay.solver.mechanism.model import Model
from jointplay.solver.method.codes import COUNTERS, Row, Section, Status
from jointplay.solver.motion.eligibility import batched_answer, exclusion, route_of
from jointplay.solver.motion.guard_tolerances import tolerances
from jointplay.solver.motion.progress import Stopped, tick

INTERRUPTED = int(Status.INTERRUPTED)
LOG_ROWS = 4096
MAX_STEPS = 10**9
RATE_TOLERANCE = 1500.0  # of an acceleration: errors of its speed in a turn; its own error is below 1000
NEWTON = 0.05  # tolerance of the iteration, in units of the tolerated error

PIECE = 0.1  # s
FIRST, LONGER = 64, 8  # attempts of the first piece ever; how much longer a piece may be than the one before


@dataclass(frozen=True)
class Request:
    """Length, tolerance and records of a run; times in s.

    Parameters
    ----------
    duration : float
        End time.
    rtol : float
        Relative tolerance of a step.
    at : ndarray
        Sample times, ascending.
    log_from : float
        Time from which steps and events are kept.
    steps, events, misses : bool
        Whether the integrator's own points are kept, the events, and the closest approaches in flight.
    level, period, direction : float, float, int
        Of the section quantity (a crossing of `level`, which then moves on by `period`); direction 0: no such
        section.
    event, joint : int
        Kind of event and joint that make the section (joint -1: any); event -1: no such section.
    skip, stop_after : int
        Section points not kept; section points after which the run ends (0: never).
    max_steps : int
        Attempted steps after which the run stops.
    rates : bool
        Whether accelerations will be taken from the records, so that steps where they may be wrong are kept.
    """

    duration: float
    rtol: float = 1e-8
    at: np.ndarray = field(default_factory=lambda: np.zeros(0))
    log_from: float = math.inf
    steps: bool = False
    events: bool = False
    misses: bool = False
    level: float = 0.0
    period: float = 0.0
    direction: int = 0
    event: int = -1
    joint: int = -1
    skip: int = 0
    stop_after: int = 0
    max_steps: int = MAX_STEPS
    rates: bool = False


@dataclass(frozen=True)
class Records:
    """Rows of a run: time, positions, speeds, modes, work; after (contact, kind) all but the samples.

    `route` says how the motion was followed, by its place in `eligibility.ROUTES`; `followed` is how many
    events others have brought about, at their times. Misses have the gap that is left in place of a kind.
    `start` and `end` are rows, of the first and the last state. `coarse` holds beginnings of steps where
    accelerations may be wrong (analysis.evaluate), after which guards fired there and the time of the end.
    """

    samples: np.ndarray
    steps: np.ndarray
    events: np.ndarray
    sections: np.ndarray
    misses: np.ndarray
    coarse: np.ndarray
    start: np.ndarray
    end: np.ndarray
    status: int
    wall_time: float
    counts: dict[str, int]
    route: int = 0
    followed: int = 0


def follow(model: Model, request: Request, progress: Callable[[float], None] | None = None) -> Records:
    """Follow the motion of a model from its start; `progress` is called with the fraction done, 0 to 1."""
    from jointplay.solver.method.control import FULL
    from jointplay.solver.method.memory import FOLLOWED, LOGGED, SAMPLES, SECTIONS

    if (records := batched_answer(model, request)) is not None:
        return records
    began = time.perf_counter()
    prepare(model.structure)
    work, motion, options = memory(model, request)
    start, parts, code = row(motion), [], FULL

    def tell() -> None:
        if progress is not None:
            progress(_fraction(motion.s[0], motion.count[SECTIONS], request))

    while code == FULL:
        try:
            code = advance(model.structure, work, motion, options, tell=tell)
        except Stopped:
            code = INTERRUPTED
        parts.append(motion.log[: motion.count[LOGGED]].copy())
        motion.count[LOGGED] = 0
    log = np.concatenate(parts)
    kinds = [log[log[:, 0] == tag, 1:] for tag in Row]
    samples = motion.samples[: motion.count[SAMPLES]]
    went = time.perf_counter() - began, counts(motion), route_of(exclusion(model, request))
    return Records(samples, *kinds, start, row(motion), code, *went, int(motion.count[FOLLOWED]))


def prepare(structure: Linkage | Oscillator, loop: str = "") -> None:
    """Have a loop compiled in a process of its own, and a structure's functions in this one meanwhile.

    `loop` is by default the one of `follow`.
    """
    cache.prepare(loop or _loop(structure))
    functions(structure)


def advance(
    structure, work, motion, options, derivatives=None, tangents=None, tell: Callable[[], None] | None = None
) -> int:
    """Go on with a run, in pieces, until it ends or its log is full; give back which (method.flow).

    The run's arrays and options are those of `memory`; derivatives and tangents are given together, if there
    are any. `tell` is called after each piece.
    """
    from jointplay.solver.method.control import STEP_LIMIT
    from jointplay.solver.method.memory import FAILED, REJECTED, STEPS

    name, vectors = _loop(structure), 0
    if tangents is not None:
        name, vectors = "tangents.tangent_flow", len(tangents.alive)
    if name == "excited_flow":
        derivatives = 1
    compiled, run, count = functions(structure), cache.method(name).flow, motion.count

    def call(limit: int) -> int:
        return run(compiled, work, motion, options._replace(max_steps=limit), derivatives, tangents)

    def made() -> int:
        return int(count[STEPS] + count[REJECTED] + count[FAILED])

    return in_pieces(call, made, pace(structure, name, vectors), STEP_LIMIT, options.max_steps, tell)


def counts(motion) -> dict[str, int]:
    """Counters of a run: steps, evaluations and events."""
    from jointplay.solver.method.memory import EVALUATIONS, EVENTS, FAILED, REJECTED, STEPS

    places = (STEPS, REJECTED, FAILED, EVALUATIONS, EVENTS)
    return {name: int(motion.count[place]) for name, place in zip(COUNTERS, places, strict=True)}


@lru_cache(maxsize=256)
def functions(structure: Linkage | Oscillator) -> tuple:
    """The compiled functions of a structure and of the method's algebra for its size."""
    from jointplay.solver.method import interface

    module = cache.structure_module(structure)
    sizes = module.SIZES
    own = wall_unit(structure)
    if own:
        cache.prepare(own)
    algebra = () if sizes["planned"] else (cache.algebra_module(sizes["positions"], sizes["speeds"]),)
    made = interface.pointers(module, *algebra, interface)
    if not own:
        return made
    at_wall = cache.method(own).at_wall
    return made._replace(at_wall=at_wall)


def memory(model: Model, request: Request):
    """Work arrays, arrays of the trajectory, and options of a run."""
    motion, options = run_of(model, request)
    return scratch(model.structure), motion, options


def scratch(structure: Linkage | Oscillator, more: int = 0):
    """Work arrays of a structure, with so many lane rows `more`."""
    from jointplay.solver.method.memory import work

    sizes = cache.structure_module(structure).SIZES
    n_q, n = sizes["positions"], sizes["speeds"]
    looked, n_s = sizes["contacts"] + sizes["resets"] + sizes["rubs"], 1 + n_q + n + 2 * sizes["angles"]
    return work(n_s, n_q, n, looked, sizes["powers"], sizes["rows"] + more, sizes["jacobian"])


def run_of(model: Model, request: Request, log: np.ndarray | None = None):
    """Arrays of the trajectory and options of a run; `log` may be shared with others."""
    from jointplay.solver.method.memory import COLUMNS, GROWTH, LEVEL, REBOUND_ERROR, H, Options, trajectory

    module = cache.structure_module(model.structure)
    sizes = module.SIZES
    n_q, n, n_contacts = sizes["positions"], sizes["speeds"], sizes["contacts"]
    state, resets = np.concatenate([[0.0], model.state]), (sizes["resets"], sizes["rubs"])
    zero = tolerances(model, request.rtol, n_contacts, *resets)
    motion = trajectory(state, model.numbers, n_q, sizes["angles"], n_contacts, *resets)
    width = 1 + n_q + n + n_contacts + sizes["resets"] + sizes["powers"]
    motion = motion._replace(
        absolute=request.rtol * model.absolute,
        relative=request.rtol * model.relative,
        turning=model.turning.copy(),
        margin=zero.margin,
        clearance_squared=zero.clearance_squared,
        group=_groups(model, sizes["resets"]),
        cone=zero.cone,
        flags=np.array([*module.CONTACTS.values()], dtype=np.int64),
        work=np.zeros(sizes["powers"]),
        sample_times=np.ascontiguousarray(request.at, dtype=float),
        samples=np.zeros((len(request.at), width)),
        log=np.zeros((LOG_ROWS, COLUMNS + width)) if log is None else log,
    )
    motion.real[H] = 1e-5 * model.period
    motion.real[LEVEL] = request.level
    motion.real[GROWTH] = 1.0 / model.period if _excites(model.structure) else 0.0
    motion.real[REBOUND_ERROR] = zero.rebound_error
    options = Options(
        n_q=n_q,
        n=n,
        first=sizes["first"],
        guards=sizes["guards"],
        t_end=float(request.duration),
        h_max=float(model.h_max),
        newton=NEWTON,
        chatter_time=1e-7 * model.period,
        speed_tolerance=zero.speed,
        height_tolerance=zero.height,
        bends=sizes["bends"],
        gap_rounding=zero.gap_rounding,
        max_steps=request.max_steps,
        log_from=float(request.log_from),
        log_steps=int(request.steps),
        log_events=int(request.events),
        log_misses=int(request.misses),
        rate_tolerance=RATE_TOLERANCE / model.period if request.rates and model.links else 0.0,
        section=_section(request),
        direction=request.direction,
        period=float(request.period),
        section_event=request.event,
        section_contact=request.joint,
        skip=request.skip,
        stop_after=request.stop_after,
    )
    return motion, options


def _groups(model: Model, n_resets: int) -> np.ndarray:
    """A number of each rigid wall, the same for the corners of one slider; below 0 without a restitution."""
    if not model.links:
        newton = [k for k, wall in enumerate(model.structure.impacts) if wall.restitution]
        return np.array([k if k in newton else -1 - k for k in range(n_resets)], dtype=np.int64)
    owners = [joint.owner for joint in model.structure.rigid_joints]
    place = {owner: at for at, owner in enumerate(dict.fromkeys(owners))}
    return np.array([place[owner] for owner in owners], dtype=np.int64)


def _loop(structure: Linkage | Oscillator) -> str:
    """The loop that follows a motion of a structure without tangents."""
    return "excited_flow" if _excites(structure) else "flow"


def wall_unit(structure: Linkage | Oscillator) -> str:
    """The unit of the method with a structure's `at_wall`; empty where it has none."""
    walls = cache.structure_module(structure).SIZES["resets"]
    return "walls.wall_flow" if walls else "excited" if _excites(structure) else ""


def _excites(structure: Linkage | Oscillator) -> bool:
    """Whether vibrations are sought that friction excites where it falls with the sliding speed."""
    return any(joint.falls for joint in getattr(structure, "soft_joints", ()))


def _section(request: Request) -> int:
    """Kind of section: a level, an event, or none."""
    if request.direction:
        return int(Section.LEVEL)
    return int(Section.EVENT if request.event >= 0 else Section.NONE)


def row(motion) -> np.ndarray:
    """The state at the base point, as a record's row."""
    return np.concatenate([motion.s[: 1 + len(motion.absolute)], motion.modes, motion.work])


def _fraction(time: float, sections: int, request: Request) -> float:
    by_sections = sections / request.stop_after if request.stop_after else 0.0
    by_time = time / request.duration if math.isfinite(request.duration) else 0.0
    return min(1.0, max(by_sections, by_time))


class Pace:
    """Number of attempts in a piece, learned from the duration of earlier pieces."""

    def __init__(self) -> None:
        self.size = FIRST

    def learn(self, made: int, seconds: float) -> None:
        """Fit the next pieces to one that was whole, or too long."""
        if made >= self.size or seconds > PIECE:
            self.size = max(1, int(min(LONGER * self.size, made * PIECE / max(seconds, 1e-9))))


@lru_cache(maxsize=1024)
def pace(structure: Linkage | Oscillator, loop: str, tangents: int = 0) -> Pace:
    """Pace of a loop with a structure and a number of tangents, shared by all its runs."""
    return Pace()


def in_pieces(
    call: Callable[[int], int],
    made: Callable[[], int],
    pace: Pace,
    unfinished: int,
    most: float,
    tell: Callable[[], None] | None = None,
) -> int:
    """Call a compiled loop until it ends for another reason than the limit of a piece.

    Parameters
    ----------
    call, made : callable
        Runs the loop up to a number of attempts in all and gives back how it ended; attempts made so far.
    pace : Pace
        Of this loop.
    unfinished : int
        What `call` gives back at its limit.
    most : float
        Attempts that were asked for.
    tell : callable, optional
        Called after each piece.
    """
    while True:
        before, began = made(), time.perf_counter()
        limit = min(most, before + pace.size)
        code = call(limit)
        pace.learn(made() - before, time.perf_counter() - began)
        if tell is not None:
            tell()
        tick()
        if code != unfinished or limit == most:
            return int(code)
