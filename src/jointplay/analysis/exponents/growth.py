"""Growth of a small difference between two motions, turn by turn: divergence measured without Jacobians.

A motion and a neighbour are followed for one turn each; where the crank passes the section's angle (a
forced system: at the same phase) the states are compared, the crank's own angle left out, and the neighbour
is brought back to the first distance along the new difference. The mean logarithm of the growth is the
largest exponent of the section's map, per turn; its standard error comes from batch means. After G.
Benettin, L. Galgani, A. Giorgilli and J.-M. Strelcyn, Meccanica 15 (1980) 9-20. The states are compared at
equal angle and not at equal time, since the time of a turn differs between neighbours of a motor-driven
linkage: a difference along the motion itself neither grows nor shrinks, and would hide the decay of all
others.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any, Unpack

import numpy as np

from jointplay.analysis import rules
from jointplay.analysis.declared import Outputs
from jointplay.analysis.evaluate import RUN
from jointplay.analysis.keywords import HANDED, Moving, Settling, Small, analysis
from jointplay.analysis.labels import Out, xr
from jointplay.analysis.quantities import STATUS
from jointplay.analysis.starts import crank_place, free_states, state_names
from jointplay.display.errors import Problem
from jointplay.solver.mechanism.base import Natural
from jointplay.solver.mechanism.model import SPEED_FLOOR, Model
from jointplay.solver.mechanism.records import CrankAngle, Mechanism, TestSystem
from jointplay.solver.motion.trajectory import Records, Request

RESOLVED = 100  # of rtol: nearer, two runs differ by their own errors as much as by their starts
DISTANCE = 1e-7  # of a radian (or the longest link) and of the nominal speed: small beside any clearance
RTOL = 1e-12  # so that the error of a turn stays far below the distance
ALIGN = 10  # turns in which the difference finds the direction that grows most
BATCHES = 20
TIME, STATE = 2, 3  # columns of a section's row


@dataclass(frozen=True)
class Turn:
    """One turn of a model, as a map of states from section to section.

    Parameters
    ----------
    model : Model
        Assembled with the crank's angle (or the forcing's phase) as its section.
    rtol : float
        Relative tolerance of a step.
    max_steps : int, optional
        Attempted steps after which a turn stops.
    """

    model: Model
    rtol: float = RTOL
    max_steps: int | None = None

    @property
    def crank(self) -> int | None:
        """Index of the crank's angle in the state, as `crank_place`."""
        return crank_place(self.model)

    @property
    def scale(self) -> np.ndarray:
        """Scale of each state: a radian or the longest link, and the nominal speed."""
        n_q, absolute = len(self.model.turning), self.model.absolute
        return np.concatenate([absolute[:n_q], absolute[n_q:] / SPEED_FLOOR])

    def records(self, state: np.ndarray, turns: int, skip: int = 0, events: bool = False) -> Records:
        """Follow a state for whole turns; keep the passages after the first `skip`, and events if wanted."""
        model = replace(self.model, state=state)
        level = model.crank_angle + model.forward * math.tau
        section = {"level": level, "period": math.tau, "direction": model.forward, "skip": skip}
        limits = {"rtol": self.rtol, "max_steps": rules.steps(self.max_steps), "stop_after": turns}
        end = rules.SLACK * turns * model.period
        return rules.to_the_section(model, Request(end, events=events, log_from=0.0, **section, **limits))

    def state_at(self, records: Records) -> np.ndarray:
        """State at the last passage, as a start: the crank's angle turned back."""
        state = records.sections[-1, STATE : STATE + len(self.model.state)].copy()
        if self.crank is not None:
            state[self.crank] = self.model.crank_angle
        return state

    def __call__(self, state: np.ndarray, turns: int = 1) -> tuple[np.ndarray, float, int]:
        """Follow a state for whole turns: the state there, the time it took in s, and the status."""
        records = self.records(state, turns, skip=turns - 1)
        if records.status:
            return np.full_like(state, np.nan), math.nan, records.status
        return self.state_at(records), float(records.sections[-1, TIME]), records.status


def unresolved(distance: float, rtol: float) -> Iterator[Problem]:
    """Yield a problem where a distance is not well above the accuracy of the runs that measure it."""
    if distance < RESOLVED * rtol:
        least = f"at least {RESOLVED} times rtol, {RESOLVED * rtol:.3g}"
        expected = f"{least}, is accepted: nearer motions differ by their own errors"
        yield Problem("distance", distance, expected)


def _turns_at_all(mechanism: Mechanism | TestSystem) -> None:
    rules.quantity(CrankAngle(), mechanism)


GROWTH = {
    "growth": Out(
        (),
        "mean logarithm of the growth of a difference in a turn",
        about="an upper bound where a difference shrinks below the accuracy of the run",
    ),
    "growth_standard_error": Out((), "standard error of the growth", about="by batch means"),
}
CHECK = GROWTH | {
    "growth_difference": Out((), "growth less the section map's exponent, in combined standard errors"),
    "growth_status": Out((), "how the second estimate ended", flags=STATUS),
}
OUTPUTS = Outputs(
    "growth",
    {"turn": Out("turn", "turn")},
    GROWTH
    | {
        "growth_rate": Out((), "growth of a difference", "s-1"),
        "growth_of_turn": Out("turn", "logarithm of the growth in this turn"),
        "status": RUN["status"],
    },
    shown={"growth": "mean ln of the growth of a small difference in a turn"},
)


@analysis(
    unresolved,
    _turns_at_all,
    rules.turns_alike,
    model=rules.on_section,
    usual={"rtol": RTOL},
    outputs=OUTPUTS,
)
def growth(  # noqa: D417 (nobody gives it the model)
    mechanism: Moving,
    *,
    model: Model = HANDED,
    turns: Natural = 200,
    distance: Small = DISTANCE,
    **motion: Unpack[Settling],
) -> xr.Dataset:
    """Measure the growth of a small difference, per turn.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        What moves; a test system must be forced.
    turns : int
        Turns over which the growth is averaged, after those in which the difference finds its direction.
    distance : float
        Distance of the neighbour at the start of each turn, in radians (longest links) and nominal speeds.
    initial : optional
        As in `lyapunov`; the section is where the motion starts.

    Raises
    ------
    InputError
        If anything asked for makes no sense; numerical trouble is a status instead.
    """
    turn = Turn(model, motion["rtol"], motion["max_steps"])
    measured = measure_after(turn, motion["transient"], turns, distance, motion["progress"])
    return OUTPUTS.dataset(_values(*measured))


def measure_after(turn: Turn, transient: int, *measured: Any, **more: Any) -> tuple[np.ndarray, float, int]:
    """Result of `measure` from where the motion is after some turns from its start."""
    state, status = turn.model.state, 0
    if transient:
        state, _, status = turn(state, transient)
    return (np.zeros(0), 0.0, status) if status else measure(turn, state, *measured, **more)


def measure(
    turn: Turn,
    state: np.ndarray,
    turns: int,
    distance: float = DISTANCE,
    progress: Callable[[float], None] | None = None,
) -> tuple[np.ndarray, float, int]:
    """Logarithms of the growth, turn by turn, from a state on the section; fewer if a turn failed.

    Beside them, the duration of those turns, s, and the status.
    """
    scale = turn.scale
    free = np.isin(state_names(turn.model), free_states(turn.model)).astype(float)
    away = free * np.random.default_rng(0).standard_normal(len(state))
    least, logs, duration = turn.rtol / distance, [], 0.0
    for count in range(ALIGN + turns):
        away *= distance / np.linalg.norm(away)
        other, _, failed = turn(state + away * scale)
        state, time, status = turn(state)
        if status or failed:
            return np.array(logs[ALIGN:]), duration, status or failed
        away = free * (other - state) / scale
        logs.append(math.log(max(np.linalg.norm(away) / distance, least)))
        if not np.any(away):  # both ran into the same state: any direction is as good
            away = free.copy()
        duration += time if count >= ALIGN else 0.0
        if progress is not None:
            progress((count + 1) / (ALIGN + turns))
    return np.array(logs[ALIGN:]), duration, 0


def standard_error(values: np.ndarray, batches: int = BATCHES) -> float:
    """Standard error of the mean of a stationary series by batch means; NaN below two values a batch.

    The first values that do not fill a batch are left out.
    """
    length = len(values) // batches
    if length < 2:
        return math.nan
    means = np.reshape(values[len(values) - length * batches :], (batches, length)).mean(axis=1)
    return float(means.std(ddof=1) / math.sqrt(batches))


def averaged(logs: np.ndarray) -> tuple[float, float]:
    """Mean growth a turn, and its standard error; NaN where there is none."""
    return float(logs.mean()) if len(logs) else math.nan, standard_error(logs)


def _values(logs: np.ndarray, duration: float, status: int) -> dict[str, Any]:
    mean, error = averaged(logs)
    rate = mean * len(logs) / duration if duration else math.nan
    found = {"turn": np.arange(len(logs)), "growth": mean, "growth_standard_error": error}
    return found | {"growth_rate": rate, "growth_of_turn": logs, "status": status}


def twin(
    model: Model,
    turns: int,
    transient: int,
    max_steps: int | None,
    progress: Callable[[float], None] | None = None,
) -> dict[str, Any]:
    """Follow a motion and a neighbour for some turns after a transient: growth a turn, error, status."""
    turn = Turn(model, max_steps=max_steps)
    logs, _, status = measure_after(turn, transient, turns, progress=progress)
    return dict(zip(("growth", "error"), averaged(logs), strict=True)) | {"status": status}


def check_values(value: float, error: float, growth: dict[str, Any]) -> dict[str, Any]:
    """Values of `CHECK`: a growth that checks the section map's largest exponent, and their difference."""
    combined = math.hypot(error, growth["error"])
    apart = (growth["growth"] - value) / combined if combined else math.nan
    return dict(zip(CHECK, (growth["growth"], growth["error"], apart, growth["status"]), strict=True))
