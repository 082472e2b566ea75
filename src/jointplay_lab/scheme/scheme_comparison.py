"""The paper's scheme against the monolithic answer: error by pass, convergence, run time at equal error.

On the paper's mechanism with an elastic coupler, at gear ratio 3: with ideal joints the passes over a whole
turn converge. With clearance they diverge, about tenfold a pass: as a function of frequency, a pass
multiplies the modes' accelerations by up to 0.9 with ideal joints, but by 21 at the coupler's first frequency
in free flight. Over windows no longer than about the period of that vibration they converge again.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from operator import gt, lt
from typing import Annotated, Any, Unpack

import numpy as np
import xarray as xr
from pydantic import AfterValidator

from jointplay.analysis.declared import Outputs
from jointplay.analysis.evaluate import Quantities
from jointplay.analysis.keywords import Motion, Moving, Rtol, analysis, several
from jointplay.analysis.labels import Out
from jointplay.analysis.quantities import STATUS
from jointplay.analysis.simulate import SAMPLES_PER_TURN
from jointplay.display.errors import raise_any, refuse, with_keys
from jointplay.display.number_text import plain
from jointplay.solver.codegen import cache
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.base import Count, Natural, NonNegative, Positive, not_empty, unit
from jointplay.solver.mechanism.model import Model
from jointplay.solver.mechanism.records import Mechanism
from jointplay.solver.motion.trajectory import MAX_STEPS, Records, Request, follow
from jointplay_lab.paper.fixed_steps import step_bound, too_long
from jointplay_lab.scheme.scheme import Scheme, State
from jointplay_lab.scheme.waveform import Grid, elastic_mechanism

LOST = 0.1  # a window whose last pass changes by more is no answer to go on from
CLEARANCES = (0.0, 2.9e-5, 2.9e-4)
WINDOWS = (1, 12, 48, 144)
STEPS = (2.5e-5, 1e-5, 2.5e-6)
TOLERANCES = (1e-4, 1e-6, 1e-8)
START_TURNS, PASSES, TOLERANCE, REPEATS, RTOL = (0, 20), 30, 1e-4, 3, 1e-10


def answer(dataset: xr.Dataset) -> str:
    """The number of cases in which the scheme's passes settle, and the errors of both methods."""
    settles = dataset["converged"].any("windows_per_turn").values
    errors = (np.nanmin(dataset[name].values) for name in ("scheme_error", "monolithic_error"))
    scheme, ours = (plain(float(error), 2) for error in errors)
    return (
        f"the scheme's passes settle in {np.count_nonzero(settles)} of {settles.size} cases\n"
        f"smallest error of a deflection: {scheme} by the scheme, {ours} with all unknowns at once"
    )


PASS = ("case", "windows_per_turn", "pass")
WINDOW, STEP, SOLVED = (("case", dim) for dim in ("windows_per_turn", "step", "tolerance"))
OUTPUTS = Outputs(
    "scheme_comparison",
    {
        "case": Out("case", "case", ""),
        "clearance": Out("case", "radial clearance of joint B", "m"),
        "start_turn": Out("case", "nominal turns before the compared one"),
        "windows_per_turn": Out("windows_per_turn", "windows that a turn is cut into"),
        "pass": Out("pass", "pass over a window"),
        "step": Out("step", "longest step of the scheme", "s"),
        "tolerance": Out("tolerance", "relative tolerance of the monolithic method"),
    },
    {
        "pass_change": Out(PASS, "relative change from the pass before", about="inf for the first"),
        "pass_deflection_error": Out(
            PASS, "largest error of a deflection after a pass, relative to the largest"
        ),
        "pass_angle_error": Out(PASS, "largest error of a link angle after a pass", "rad"),
        "pass_force_error": Out(
            PASS, "error of the forces at ideal joints after a pass, root mean square, relative"
        ),
        "converged": Out(WINDOW, "whether the passes agree in every window"),
        "reached": Out(WINDOW, "part of the turn up to the first window whose passes do not settle at all"),
        "mean_passes": Out(WINDOW, "passes done, mean of the windows"),
        "contraction": Out(WINDOW, "median ratio of successive changes"),
        "scheme_error": Out(STEP, "largest error of a deflection by the scheme, relative to the largest"),
        "scheme_run_time": Out(STEP, "run time of a turn by the scheme", "s"),
        "monolithic_error": Out(SOLVED, "largest error of a deflection, all unknowns at once, relative"),
        "monolithic_run_time": Out(SOLVED, "run time of a turn, all unknowns at once", "s"),
        "windows_used": Out(
            "case",
            "windows per turn of the timed runs: the fewest tried, or if they fail those with fewest passes",
        ),
        "order_difference": Out(
            "case", "largest difference of a deflection with all inertia terms, relative"
        ),
        "largest_deflection": Out("case", "largest deflection of the turn", "m"),
        "status": Out((), "how the study ended", flags=STATUS),
    },
    answer,
)
COMPARED = ("deflection", "angle", "reaction")
MEASURES = (*COMPARED[:2], "force")


@analysis(elastic_mechanism, "model", usual={"rtol": RTOL}, outputs=OUTPUTS)
def scheme_comparison(
    mechanism: Moving,
    *,
    clearance: Clearances = CLEARANCES,
    start_turn: StartTurns = START_TURNS,
    windows_per_turn: WindowsPerTurn = WINDOWS,
    passes: Natural = PASSES,
    tolerance: Annotated[Positive, unit("change at which two passes agree", "1")] = TOLERANCE,
    steps: Steps = STEPS,
    tolerances: Tolerances = TOLERANCES,
    repeats: Natural = REPEATS,
    **motion: Unpack[Motion],
) -> xr.Dataset:
    """Measure the paper's scheme over single turns of a mechanism with elastic links.

    A window that is done keeps the errors of its last pass, and all are inf from a pass on that grew beyond
    measure. ``status`` is not_converged where no number of windows brings a case to the end of its turn.

    Parameters
    ----------
    mechanism : Mechanism
        With at least one elastic link.
    clearance : sequence of float
        Radial clearances of joint B, m; 0 stands for ideal joints.
    start_turn : sequence of int
        Nominal turns after which the compared turn starts, from the monolithic motion's state there. Each is
        combined with every clearance.
    windows_per_turn : sequence of int
        Numbers of windows into which the turn is cut, rising; each window is relaxed from the end of the one
        before, and 1 is the paper's scheme.
    passes : int
        Largest number of passes over a window.
    tolerance : float
        Change below which two passes agree, as in `waveform`.
    steps : sequence of float
        Time steps of the scheme, s, falling; the passes are looked at with the last.
    tolerances : sequence of float
        Relative tolerances of the monolithic method that are timed.
    repeats : int
        Number of timed runs of each method, the two in turn; the median counts.
    rtol : float
        Relative tolerance of the monolithic answer that is taken as the truth.

    Raises
    ------
    InputError
        If anything asked for makes no sense, or a step is too long.
    """
    lists = clearance, start_turn, windows_per_turn, steps, tolerances
    initial, progress, rtol = motion["initial"], motion["progress"], motion["rtol"]
    plan = Plan(*lists, passes, tolerance, repeats, rtol, motion["max_steps"])
    check_steps(mechanism, plan, initial)
    cases = [(e, turn) for e in plan.clearance for turn in plan.start_turn]
    found = []
    for e, turn in cases:
        found.append(_compared(Case.of(mechanism, e, turn, rtol, initial), plan))
        if progress is not None:
            progress(len(found) / len(cases))
    return _dataset(found, plan)


def _compared(case: Case, plan: Plan) -> dict[str, Any]:
    """Compare both methods on one case."""
    tables = [_passes(case, windows, plan) for windows in plan.windows_per_turn]
    settled = [number for number, table in enumerate(tables) if table["reached"] == 1.0]
    cheapest = min(settled, key=lambda number: number and tables[number]["mean_passes"], default=-1)
    used = plan.windows_per_turn[cheapest]
    found = {name: np.array([table[name] for table in tables]) for name in tables[0]}
    found |= _work(case, used, plan) | _orders(case, plan)
    about = {"case": case.label, "clearance": case.clearance, "start_turn": case.turn}
    return found | about | {"windows_used": used}


def _passes(case: Case, windows: int, plan: Plan) -> dict[str, Any]:
    """Errors and changes by pass, at the finest step."""
    grid = Grid.of(case.relaxed, plan.steps[-1], windows)
    scheme, kept = Scheme(case.relaxed, grid.h), grid.kept
    truth = Truth.of(
        case.monolithic, case.follow(sample_times(case.relaxed, grid, windows), plan.rtol).samples
    )
    table = np.full((windows, plan.passes, 1 + len(MEASURES)), np.inf)
    done = np.zeros(windows, dtype=int)
    for visit in scheme.relax(case.start(scheme), grid.count, windows, plan.passes, plan.tolerance):
        w, p = visit.window, visit.number
        where = slice(w * kept + (w > 0), (w + 1) * kept + 1)
        part = visit.done.thinned(grid.every, first=w == 0)
        own = described(scheme.quantities(part.rows, part.loads), deflection=part.deflection)
        measured = truth.errors(own, where) if visit.done.finite else np.inf
        table[w, p:, 0], table[w, p:, 1:] = visit.change, measured  # a window that is done keeps its last
        done[w] = p + 1
        if visit.last and visit.change > LOST:
            break
    whole = np.concatenate([table[..., :-1].max(axis=0), np.sqrt(table[..., -1:].mean(axis=0))], axis=1)
    names = ("pass_change", *(f"pass_{name}_error" for name in MEASURES))
    return dict(zip(names, whole.T, strict=True)) | {
        "converged": bool(whole[-1, 0] <= plan.tolerance),
        "reached": np.count_nonzero(table[:, -1, 0] <= LOST) / windows,
        "mean_passes": done[done > 0].mean(),
        "contraction": _contraction(table[..., 0], done),
    }


def _contraction(change: np.ndarray, done: np.ndarray) -> float:
    """Median ratio of successive changes; NaN where no window took three passes."""
    ratios = [row[2:n] / row[1 : max(n - 1, 1)] for row, n in zip(change, done, strict=True)]
    ratios = np.concatenate([each[np.isfinite(each)] for each in ratios])
    return float(np.median(ratios)) if len(ratios) else math.nan


def _work(case: Case, windows: int, plan: Plan) -> dict[str, Any]:
    """Error and run time of both methods; each repeat runs all of both, one after another."""
    times = sample_times(case.relaxed, Grid.of(case.relaxed, plan.steps[-1], windows), windows)
    truth = Truth.of(case.monolithic, case.follow(times, plan.rtol).samples)
    scheme, monolithic = [], []
    for _ in range(plan.repeats):
        scheme.append([_by_scheme(case, truth, windows, step, plan) for step in plan.steps])
        monolithic.append([_at_once(case, truth, times, rtol, plan) for rtol in plan.tolerances])
    found = {}
    for name, runs in (("scheme", scheme), ("monolithic", monolithic)):
        error, seconds = np.median(np.array(runs), axis=0).T
        found |= {f"{name}_error": error, f"{name}_run_time": seconds}
    return found


def _by_scheme(case: Case, truth: Truth, windows: int, step: float, plan: Plan) -> tuple[float, float]:
    """Error of the deflection and run time (s) of the scheme."""
    grid, parts = Grid.of(case.relaxed, step, windows), []
    began = time.perf_counter()
    scheme = Scheme(case.relaxed, grid.h)
    for visit in scheme.relax(case.start(scheme), grid.count, windows, plan.passes, plan.tolerance):
        if visit.last:
            parts.append(visit.done.thinned(grid.every, first=not parts).deflection)
        if visit.last and visit.change > LOST:
            break
    seconds, lost = time.perf_counter() - began, visit.change > LOST
    return math.inf if lost else truth.deflection_error(np.concatenate(parts)), seconds


def _at_once(case: Case, truth: Truth, times: np.ndarray, rtol: float, plan: Plan) -> tuple[float, float]:
    """Error of the deflection and run time (s) of the monolithic method."""
    records = case.follow(times, rtol, plan.max_steps)
    if len(records.samples) < len(times):
        return math.inf, records.wall_time
    return truth.deflection_error(_deflection(case.monolithic, records.samples)), records.wall_time


def _deflection(model: Model, rows: np.ndarray) -> np.ndarray:
    return Quantities(model, rows, model.state).variables(["deflection"], "time")["deflection"][1]


def _orders(case: Case, plan: Plan) -> dict[str, Any]:
    """Difference of the deflection with all inertia terms from that with the paper's."""
    times = np.linspace(0.0, case.relaxed.period, SAMPLES_PER_TURN + 1)
    truth = Truth.of(case.monolithic, case.follow(times, plan.rtol).samples)
    rows = follow(case.consistent, Request(times[-1], rtol=plan.rtol, at=times)).samples
    return {
        "order_difference": truth.deflection_error(_deflection(case.consistent, rows)),
        "largest_deflection": truth.scales["deflection"],
    }


def _dataset(found: list[dict[str, Any]], plan: Plan) -> xr.Dataset:
    """Put the cases together."""
    values = {name: np.array([each[name] for each in found]) for name in found[0]}
    settled = np.any(values["reached"] == 1.0, axis=1)
    values["converged"] = values["converged"].astype(np.int8)
    values["status"] = STATUS.index("ok" if settled.all() else "not_converged")
    values |= {"windows_per_turn": list(plan.windows_per_turn), "pass": np.arange(1, plan.passes + 1)}
    values |= {"step": list(plan.steps), "tolerance": list(plan.tolerances)}
    return OUTPUTS.dataset(values, pass_tolerance=plan.tolerance)


@dataclass(frozen=True)
class Plan:
    """The keywords of `scheme_comparison`."""

    clearance: tuple[float, ...]
    start_turn: tuple[int, ...]
    windows_per_turn: tuple[int, ...]
    steps: tuple[float, ...]
    tolerances: tuple[float, ...]
    passes: int
    tolerance: float
    repeats: int
    rtol: float
    max_steps: int | None


def _monotonic(word: str, ordered: Callable[[Any, Any], bool]) -> AfterValidator:
    def validated(values: tuple[Any, ...]) -> tuple[Any, ...]:
        if not all(ordered(a, b) for a, b in pairwise(values)):
            raise refuse(values, f"{word} numbers are accepted")
        return values

    return AfterValidator(validated)


_Some, _Rising, _Falling = AfterValidator(not_empty), _monotonic("rising", lt), _monotonic("falling", gt)
Clearances = Annotated[several(NonNegative, "a list of clearances in m"), _Some]
StartTurns = Annotated[several(Count, "a list of whole numbers of turns"), _Some]
WindowsPerTurn = Annotated[several(Natural, "a list of rising whole numbers"), _Some, _Rising]
Steps = Annotated[several(Positive, "a list of falling steps in s"), _Some, _Falling]
Tolerances = Annotated[several(Rtol, "a list of relative tolerances"), _Some]


def check_steps(mechanism: Mechanism, plan: Plan, initial: Any) -> None:
    """Refuse steps with which the scheme is not stable, before anything is followed.

    Raises
    ------
    InputError
        Listing them.
    """
    models = (assemble(mechanism.replace(clearance=e), initial, relaxed=True) for e in plan.clearance)
    least = min(map(step_bound, models), key=lambda bound: bound.step)
    steps = with_keys("steps", plan.steps)
    raise_any(too_long(key, step, least) for key, step in steps if step > least.step)


@dataclass(frozen=True)
class Case:
    """One turn of a mechanism with the paper's inertia terms, from a state of its own motion.

    Parameters
    ----------
    clearance : float
        Of joint B, m.
    turn : int
        Nominal turns after which the compared one starts.
    monolithic, consistent, relaxed : Model
        All unknowns at once with the paper's terms, and with all terms; the rigid mechanism of the scheme.
    """

    clearance: float
    turn: int
    monolithic: Model
    consistent: Model
    relaxed: Model

    @classmethod
    def of(cls, mechanism: Mechanism, clearance: float, turn: int, rtol: float, initial: Any) -> Case:
        """Follow a mechanism to the start of the turn."""
        paper = mechanism.replace(clearance=clearance, order="paper")
        model = assemble(paper, initial)
        if turn:
            end = turn * model.period
            row = follow(model, Request(end, rtol=rtol, at=np.array([end]))).samples[-1]
            model = replace(model, state=row[1 : 1 + len(model.state)].copy())
        consistent = replace(assemble(paper.replace(order="consistent"), initial), state=model.state)
        return cls(clearance, turn, model, consistent, assemble(paper, initial, relaxed=True))

    @property
    def label(self) -> str:
        """The case in words."""
        play = f"clearance {self.clearance:g} m" if self.clearance else "ideal joints"
        return f"{play}, turn {self.turn + 1}"

    def start(self, scheme: Scheme) -> State:
        """The start of the turn, as the scheme takes it."""
        names = cache.structure_module(self.monolithic.structure).STATE
        values = dict(zip(names, [0.0, *self.monolithic.state], strict=True))
        rigid = [values[name] for name in cache.structure_module(self.relaxed.structure).STATE]
        bent = ([values[f"{word}_{name}"] for name in scheme.modes.names] for word in ("eta", "deta"))
        return State(np.array(rigid), *map(np.array, bent))

    def follow(self, times: np.ndarray, rtol: float, max_steps: int | None = None) -> Records:
        """The monolithic motion at some times of the turn, s."""
        request = Request(float(times[-1]), rtol=rtol, at=times, max_steps=max_steps or MAX_STEPS)
        return follow(self.monolithic, request)


@dataclass(frozen=True)
class Truth:
    """Quantities by name, over times and parts, with the scale by which an error of each counts."""

    values: Mapping[str, np.ndarray]
    scales: Mapping[str, float]

    @classmethod
    def of(cls, model: Model, rows: np.ndarray) -> Truth:
        """Make the truth of the rows of a monolithic run."""
        values = described(Quantities(model, rows, rows[0]))
        force = float(np.sqrt(np.mean(values["reaction"] ** 2)))
        scales = {"deflection": float(np.abs(values["deflection"]).max()), "angle": 1.0, "reaction": force}
        return cls(values, scales)

    def deflection_error(self, found: np.ndarray) -> float:
        """Largest error of a deflection, relative to the largest deflection."""
        return float(np.abs(found - self.values["deflection"]).max() / self.scales["deflection"])

    def errors(self, found: Mapping[str, np.ndarray], where: slice = slice(None)) -> np.ndarray:
        """Largest relative error of a deflection, largest of an angle (rad), mean square of a force."""
        error = {name: (found[name] - self.values[name][where]) / self.scales[name] for name in COMPARED}
        largest = [np.abs(error[name]).max(initial=0.0) for name in COMPARED[:2]]
        return np.array([*largest, np.mean(error["reaction"] ** 2)])


def described(quantities: Quantities, **own: np.ndarray) -> dict[str, np.ndarray]:
    """The compared quantities of some rows; quantities that the rows do not have are given."""
    names = [name for name in COMPARED if name not in own]
    return {name: each[1] for name, each in quantities.variables(names, "time").items()} | own


def sample_times(model: Model, grid: Grid, windows: int) -> np.ndarray:
    """Times of the samples of a turn, s."""
    return np.linspace(0.0, model.period, windows * grid.kept + 1)
