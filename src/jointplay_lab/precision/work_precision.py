"""Error against run time and evaluations, for the method used here and for other solvers.

All follow the same motion of the same equations, in one process and by turns, with the same modes and events;
each locates events in its own way, and starts anew after them. Measured is CPU time, so that a busy machine
disturbs little; even so, times are to be read as ratios.

The truth, with whose end all runs are compared, is the method's own run at the tightest tolerance. It counts
as confirmed where another method's tightest run meets the same events and comes within `CONFIRMED` of it; how
close it comes is how well the truth is known, and errors below that mean nothing. A run agrees where it meets
the truth's events, in their order, and its error is within `LARGE` times its tolerance: a solver whose
equations were others would not come closer however tight its tolerance.

The result's dimensions are `solver` and `rtol`: of xarray's `sel`, ``method`` and ``tolerance`` are keywords.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from importlib.util import find_spec
from itertools import pairwise
from typing import Annotated, Unpack

import numpy as np
import xarray as xr
from pydantic import AfterValidator

from jointplay.analysis.declared import Outputs
from jointplay.analysis.keywords import HANDED, RTOL, Length, Motion, Moving, Rtol, analysis, several
from jointplay.analysis.labels import Out
from jointplay.analysis.quantities import STATUS
from jointplay.analysis.rules import steps
from jointplay.display.errors import Problem, refuse, unknown
from jointplay.display.number_text import plain
from jointplay.solver.mechanism.base import Count, Positive, unit
from jointplay.solver.mechanism.model import Model
from jointplay.solver.mechanism.records import Mechanism, TestSystem
from jointplay.solver.motion.progress import ticked
from jointplay.solver.motion.trajectory import MAX_STEPS
from jointplay_lab.precision.contenders import Cvode, Dop853, Heyoka, Lsoda, Ours, Outcome, Peer, Radau
from jointplay_lab.precision.generated_code import Equations, units

PEERS: dict[str, type[Peer]] = {peer.name: peer for peer in (Heyoka, Cvode, Lsoda, Radau, Dop853)}


def _falling(tolerances: tuple[float, ...]) -> tuple[float, ...]:
    if not tolerances or any(a <= b for a, b in pairwise(tolerances)):
        raise refuse(tolerances, f"falling relative tolerances from {RTOL[1]:g} to {RTOL[0]:g} are accepted")
    return tolerances


Tolerances = Annotated[
    several(Rtol, f"a list of falling relative tolerances from {RTOL[1]:g} to {RTOL[0]:g}"),
    AfterValidator(_falling),
]
Peers = several(str, f"a list of peers: {', '.join(PEERS)}")


def unknown_peers(peers: tuple[str, ...]) -> Iterator[Problem]:
    """Yield the problems of peers: unknown, or named twice."""
    for i, name in enumerate(peers):
        if name not in PEERS:
            yield unknown(f"peers[{i}]", name, name, PEERS, "peer")
        elif name in peers[:i]:
            yield Problem(f"peers[{i}]", name, "each peer is accepted once")


TOLERANCES = (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12)
ROUNDS, BUDGET, SHARP = 7, 60.0, 1e-13
LEVELS = tuple(10.0**-k for k in range(4, 11))
NEXT = 3.0  # a run at the next tolerance may take so many times as long as the last
SHORT = 0.01  # s: the first run after another method's tells what it left in the processor's caches
FEWEST = 1e-4  # s: least cost of a round, beside the run itself
AGREEMENT = ("same", "other_events", "other_state", "no_end")
CONFIRMED = 1e-6
LARGE = 1e5
LOOSER = 10.0  # tolerance of the run that says how far the truth's own error may reach


def answer(dataset: xr.Dataset) -> str:
    """The fastest solver at each error that two or more reach, and whether the truth is confirmed."""
    lines = []
    for level in dataset["error_level"].values:
        times = dataset["cpu_time_at_error"].sel(error_level=level)
        if np.count_nonzero(np.isfinite(times)) > 1:
            best = int(np.nanargmin(times.values))
            took = f"{plain(1e3 * float(times[best]), 3)} ms per turn"
            lines.append(f"at an error of {plain(float(level), 1)}: {times['solver'].values[best]}, {took}")
    by = dataset.attrs.get("truth_confirmed_by", "none")
    confirmed = f"confirmed by {by}" if int(dataset["truth_confirmed"]) else "not confirmed"
    return "\n".join([*lines[:2], f"the truth is {confirmed}"])


RUN = ("solver", "rtol")
RUNS = {
    "cpu_time": Out(RUN, "CPU time of a turn, median", "s"),
    "cpu_time_spread": Out(RUN, "CPU time of a turn, half the distance of its quartiles", "s"),
    "evaluations": Out(RUN, "evaluations of the right-hand side in a turn"),
    "steps": Out(RUN, "steps in a turn, rejected ones among them if the method tells"),
    "error": Out(RUN, "largest error of a state at the end, in units of 1 rad and the nominal speed"),
    "events": Out(RUN, "events"),
    "timed_runs": Out(RUN, "runs that make the median; 0: the first run alone"),
    "preparation": Out(RUN, "CPU time that the method took to compile", "s"),
    "run_status": Out(RUN, "how the run ended", flags=STATUS),
    "agreement": Out(RUN, "whether it met the truth's events and came near its state", flags=AGREEMENT),
}
OUTPUTS = Outputs(
    "work_precision",
    {
        "solver": Out("solver", "solver", ""),
        "rtol": Out("rtol", "relative tolerance"),
        "error_level": Out("error_level", "error"),
    },
    RUNS
    | {
        "cpu_time_at_error": Out(("solver", "error_level"), "CPU time of a turn at an error reached", "s"),
        "truth_own_difference": Out((), "difference of the truth from its run at ten times the tolerance"),
        "truth_difference": Out((), "difference of the truth from the second method that comes closest"),
        "truth_confirmed": Out((), "whether a second method confirms the truth"),
        "truth_events": Out((), "events of the truth"),
        "status": Out((), "how the run that is the truth ended", flags=STATUS),
    },
    answer,
)


def _linear_contact(mechanism: Mechanism | TestSystem) -> Iterator[Problem]:
    """Rule: contacts have the linear law, the only one for which other solvers are set up."""
    for joint in mechanism.clearance_joints if isinstance(mechanism, Mechanism) else ():
        if joint.contact.law != "kelvin_voigt":
            key = f"mechanism.joints.{joint.name}.contact.law"
            yield Problem(key, joint.contact.law, "'kelvin_voigt' is accepted")


@analysis(unknown_peers, _linear_contact, "model", usual={"rtol": SHARP}, outputs=OUTPUTS)
def work_precision(  # noqa: D417 (nobody gives it the model)
    mechanism: Moving,
    *,
    model: Model = HANDED,
    turns: Length = 1,
    tolerances: Tolerances = TOLERANCES,
    peers: Peers = tuple(PEERS),
    rounds: Count = ROUNDS,
    budget: Annotated[Positive, unit("CPU time for all runs", "s")] = BUDGET,
    **motion: Unpack[Motion],
) -> xr.Dataset:
    """Compare this package's method with other solvers on one motion.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        What moves.
    turns : float
        Number of nominal turns, or of periods of the forcing, that are followed.
    tolerances : sequence of float
        Relative tolerances, falling, at which every method is run.
    peers : sequence of str
        Other solvers that are run: heyoka, CVODE (scikit-sundae), LSODA, Radau, DOP853 (SciPy). Those not
        installed are named in the result and left out.
    rounds : int
        Largest number of timed runs of each method and tolerance, after a first run that is judged.
    budget : float
        CPU time for all runs, s, shared evenly among the methods. What does not fit is not run.
    rtol : float
        Relative tolerance of the run that is taken as the truth.
    max_steps
        As in `simulate`; `max_steps` is of this package's runs.

    Raises
    ------
    InputError
        Listing what makes no sense.
    """
    installed = [name for name in peers if find_spec(PEERS[name].package)]
    limit = steps(motion["max_steps"])
    end = turns * model.period
    truth = Truth.of(model, motion["rtol"], end, limit)
    rows = [
        Row(method.name, tolerance, contender(method, model, tolerance, end, truth, limit))
        for method in (Ours, *(PEERS[name] for name in installed))
        for tolerance in tolerances
    ]
    if truth.outcome.status == "ok":
        measure(rows, truth, rounds, budget, motion["progress"])
    absent = [name for name in peers if name not in installed]
    return dataset(rows, truth, tolerances, turns, motion["rtol"], absent)


def _values(row: Row, turns: float) -> dict[str, float]:
    """Numbers and codes of one method at one tolerance."""
    outcome, ended = row.outcome, 1.0 if row.outcome.status == "ok" else math.nan
    return {
        "cpu_time": row.median / turns,
        "cpu_time_spread": row.spread / turns,
        "evaluations": outcome.evaluations / turns,
        "steps": ended * outcome.steps / turns,
        "error": row.error,
        "events": ended * len(outcome.events),
        "timed_runs": float(len(row.times)),
        "preparation": row.compiling,
        "run_status": STATUS.index(outcome.status),
        "agreement": AGREEMENT.index(row.agreement),
    }


def dataset(
    rows: Sequence[Row],
    truth: Truth,
    tolerances: Sequence[float],
    turns: float,
    rtol: float,
    absent: Sequence[str] = (),
) -> xr.Dataset:
    """Put a comparison together; `absent` are peers that are not installed."""
    methods = list(dict.fromkeys(row.method for row in rows))
    of = {name: [row for row in rows if row.method == name] for name in methods}
    cells = [[_values(row, turns) for row in of[name]] for name in methods]
    values = {name: np.array([[one[name] for one in row] for row in cells]) for name in RUNS}
    levels = [[time_at(of[method], level) / turns for level in LEVELS] for method in methods]
    values |= {"solver": np.array(methods), "rtol": np.array(tolerances), "error_level": np.array(LEVELS)}
    values |= {"cpu_time_at_error": np.array(levels), "status": STATUS.index(truth.outcome.status)}
    by, difference = confirming(of)
    values |= {"truth_own_difference": truth.own_difference, "truth_difference": difference}
    values["truth_confirmed"] = np.int8(difference <= CONFIRMED)
    values["truth_events"] = np.int64(len(truth.outcome.events))
    attributes = {"truth_confirmed_by": by or "none", "not_installed": ", ".join(absent) or "none"}
    return OUTPUTS.dataset(values, turns=turns, truth_tolerance=rtol, **attributes)


def confirming(of: dict[str, list[Row]]) -> tuple[str, float]:
    """The peer whose tightest run comes closest to the truth, and its error; '' and NaN where none agrees."""
    peers = (rows for name, rows in of.items() if name != Ours.name)
    tightest = [[row for row in rows if row.outcome.status == "ok"][-1:] for rows in peers]
    agreeing = [row for (row,) in filter(None, tightest) if row.agreement == "same"]
    best = min(agreeing, key=lambda row: row.error, default=None)
    return (best.method, best.error) if best else ("", math.nan)


@dataclass
class Row:
    """A method at a tolerance: outcome and error of its first run, and the times of all timed runs, s."""

    method: str
    tolerance: float
    contender: Ours | Peer
    outcome: Outcome = field(default_factory=lambda: Outcome("not_run"))
    error: float = math.nan
    agreement: str = "no_end"
    compiling: float = 0.0
    times: list[float] = field(default_factory=list)

    @property
    def median(self) -> float:
        """Median time; of the first run where there was no other."""
        return float(np.median(self.times)) if self.times else self.outcome.seconds

    def timed(self) -> float:
        """Time of one more run, s; a short one is made twice, and the second counts."""
        seconds = self.contender.run().seconds
        return self.contender.run().seconds if seconds < SHORT else seconds

    @property
    def spread(self) -> float:
        """Half the distance of the times' quartiles; NaN of fewer than three."""
        if len(self.times) < 3:
            return math.nan
        low, high = np.percentile(self.times, [25, 75])
        return float(high - low) / 2


def contender(
    method: type[Ours | Peer], model: Model, tolerance: float, end: float, truth: Truth, max_steps: int
) -> Ours | Peer:
    """A method ready to run."""
    if issubclass(method, Ours):
        return method(model, tolerance, end, max_steps)
    unit, events = truth.unit, len(truth.outcome.events)
    return method(Equations(model, tolerance), tolerance, end, unit, events)


def measure(
    rows: Sequence[Row],
    truth: Truth,
    rounds: int,
    budget: float,
    progress: Callable[[float], None] | None = None,
) -> None:
    """Judge every row by the truth, then time all of them in turns, `rounds` times at most.

    The rows of each method go from loose to tight tolerances. The methods share the `budget` of CPU time (s)
    evenly, and have as much for compiling; a run that would not fit is left out, and so are tighter ones.
    """
    share = budget / max(1, len({row.method for row in rows}))
    spent, compiled = (dict.fromkeys((row.method for row in rows), 0.0) for _ in range(2))
    tell = progress or (lambda _: None)
    for place, row in enumerate(ticked(rows)):
        if compiled[row.method] < share:
            _judge(row, rows[:place], truth, spent, share)
        compiled[row.method] += row.compiling
        tell(0.6 * (place + 1) / len(rows))
    for count in range(rounds):
        for row in ticked(sorted(rows, key=lambda row: -row.tolerance)):
            if row.outcome.status == "ok" and spent[row.method] + row.outcome.seconds < share:
                row.times.append(row.timed())
                spent[row.method] += row.times[-1] + FEWEST
        tell(0.6 + 0.4 * (count + 1) / rounds)


def _judge(row: Row, before: Sequence[Row], truth: Truth, spent: dict[str, float], share: float) -> None:
    """Run a row once, unless its method has no time left for it."""
    mine = [one for one in before if one.method == row.method and one.outcome.status == "ok"]
    left, took = share - spent[row.method], mine[-1].outcome.seconds if mine else 0.0
    if not NEXT * took < left:
        return
    row.outcome = row.contender.run(left / 2)
    row.compiling = getattr(row.contender, "compiling", 0.0)
    spent[row.method] += row.outcome.seconds
    row.error, row.agreement = truth.error(row.outcome), truth.agreement(row.outcome, row.tolerance)


def time_at(rows: Sequence[Row], error: float) -> float:
    """CPU time (s) at which a method reaches an error; NaN where it does not.

    Between the runs that no other run of it beats, log over log.
    """
    timed = [row for row in rows if 0 < row.median < math.inf]  # 0: too short to time
    front: list[Row] = []
    for row in sorted((row for row in timed if row.agreement == "same"), key=lambda row: row.median):
        if not front or row.error < front[-1].error:
            front.append(row)
    if not front or front[-1].error > error:
        return math.nan
    errors = [math.log(max(row.error, 1e-300)) for row in reversed(front)]
    times = [math.log(row.median) for row in reversed(front)]
    return math.exp(np.interp(math.log(error), errors, times))


@dataclass(frozen=True)
class Truth:
    """End of a motion: the tightest run, its difference from one at ten times its tolerance, units."""

    outcome: Outcome
    own_difference: float
    unit: np.ndarray

    @classmethod
    def of(cls, model: Model, rtol: float, end: float, max_steps: int = MAX_STEPS) -> Truth:
        """Follow a model up to a time with the tightest tolerance, and once more."""
        tight = Ours(model, rtol, end, max_steps).run()
        truth = cls(tight, math.nan, units(model))
        looser = Ours(model, LOOSER * rtol, end, max_steps).run()
        return cls(tight, truth.error(looser), truth.unit)

    def error(self, outcome: Outcome) -> float:
        """Largest difference of a state at the end, in its unit; NaN where either run did not get there."""
        if outcome.status != "ok" or self.outcome.status != "ok":
            return math.nan
        return float(np.max(np.abs(outcome.state - self.outcome.state) / self.unit))

    def agreement(self, outcome: Outcome, tolerance: float) -> str:
        """Agreement of a run, as a word of `AGREEMENT`."""
        error = self.error(outcome)
        if not math.isfinite(error):
            return "no_end"
        if outcome.events != self.outcome.events:
            return "other_events"
        return "same" if error <= LARGE * tolerance else "other_state"
