"""What a comparison with the paper's scheme is asked for, and the words of its answer."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated, Any

from pydantic import AfterValidator

from jointplay.analysis.keywords import Rtol, several
from jointplay.errors import InputError, refuse
from jointplay.lab.paper.fixed_steps import step_bound, too_long
from jointplay.mechanism.assemble import assemble
from jointplay.mechanism.base import Count, Natural, NonNegative, Positive
from jointplay.mechanism.records import Mechanism

_PASSED = ("windows_per_turn", "pass")
WORDS = {
    "pass_change": (_PASSED, "1", "relative change from the pass before"),
    "pass_deflection_error": (
        _PASSED,
        "1",
        "largest error of a deflection after a pass, relative to the largest",
    ),
    "pass_angle_error": (_PASSED, "rad", "largest error of a link angle after a pass"),
    "pass_force_error": (
        _PASSED,
        "1",
        "error of the forces at ideal joints after a pass, root mean square, relative",
    ),
    "converged": (_PASSED[:1], "1", "whether the passes agree in every window"),
    "reached": (
        _PASSED[:1],
        "1",
        "part of the turn up to the first window whose passes do not settle at all",
    ),
    "mean_passes": (_PASSED[:1], "1", "passes done, mean of the windows"),
    "contraction": (_PASSED[:1], "1", "median ratio of successive changes"),
    "scheme_error": (("step",), "1", "largest error of a deflection by the scheme, relative to the largest"),
    "scheme_run_time": (("step",), "s", "run time of a turn by the scheme"),
    "monolithic_error": (
        ("tolerance",),
        "1",
        "largest error of a deflection, all unknowns at once, relative",
    ),
    "monolithic_run_time": (("tolerance",), "s", "run time of a turn, all unknowns at once"),
    "windows_used": (
        (),
        "1",
        "windows per turn of the timed runs: the fewest tried, or if they fail those with fewest passes",
    ),
    "order_difference": ((), "1", "largest difference of a deflection with all inertia terms, relative"),
    "largest_deflection": ((), "m", "largest deflection of the turn"),
}


@dataclass(frozen=True)
class Plan:
    """What is compared: the keywords of `scheme_comparison`."""

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


def _rising(values: tuple[Any, ...]) -> tuple[Any, ...]:
    if any(a >= b for a, b in pairwise(values)):
        raise refuse(values, "rising numbers are accepted")
    return values


def _falling(values: tuple[Any, ...]) -> tuple[Any, ...]:
    if any(a <= b for a, b in pairwise(values)):
        raise refuse(values, "falling numbers are accepted")
    return values


def _not_empty(values: tuple[Any, ...]) -> tuple[Any, ...]:
    if not values:
        raise refuse(values, "a list of at least one number is accepted")
    return values


_Some = AfterValidator(_not_empty)
Clearances = Annotated[several(NonNegative, "a list of clearances in m"), _Some]
StartTurns = Annotated[several(Count, "a list of whole numbers of turns"), _Some]
WindowsPerTurn = Annotated[several(Natural, "a list of rising whole numbers"), _Some, AfterValidator(_rising)]
Steps = Annotated[several(Positive, "a list of falling steps in s"), _Some, AfterValidator(_falling)]
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
    found = [too_long(f"steps[{i}]", step, least) for i, step in enumerate(plan.steps) if step > least.step]
    if found:
        raise InputError(found)
