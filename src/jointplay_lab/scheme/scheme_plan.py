"""The keywords of a comparison with the paper's scheme, and the variables of its result."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from operator import gt, lt
from typing import Annotated, Any

from pydantic import AfterValidator

from jointplay.analysis.keywords import Rtol, several
from jointplay.display.errors import InputError, refuse
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.base import Count, Natural, NonNegative, Positive
from jointplay.solver.mechanism.records import Mechanism
from jointplay_lab.paper.fixed_steps import step_bound, too_long

VARIABLES = {  # by their dimensions beside the case: units and long names
    ("windows_per_turn", "pass"): {
        "pass_change": ("1", "relative change from the pass before"),
        "pass_deflection_error": ("1", "largest error of a deflection after a pass, relative to the largest"),
        "pass_angle_error": ("rad", "largest error of a link angle after a pass"),
        "pass_force_error": (
            "1",
            "error of the forces at ideal joints after a pass, root mean square, relative",
        ),
    },
    ("windows_per_turn",): {
        "converged": ("1", "whether the passes agree in every window"),
        "reached": ("1", "part of the turn up to the first window whose passes do not settle at all"),
        "mean_passes": ("1", "passes done, mean of the windows"),
        "contraction": ("1", "median ratio of successive changes"),
    },
    ("step",): {
        "scheme_error": ("1", "largest error of a deflection by the scheme, relative to the largest"),
        "scheme_run_time": ("s", "run time of a turn by the scheme"),
    },
    ("tolerance",): {
        "monolithic_error": ("1", "largest error of a deflection, all unknowns at once, relative"),
        "monolithic_run_time": ("s", "run time of a turn, all unknowns at once"),
    },
    (): {
        "windows_used": (
            "1",
            "windows per turn of the timed runs: the fewest tried, or if they fail those with fewest passes",
        ),
        "order_difference": ("1", "largest difference of a deflection with all inertia terms, relative"),
        "largest_deflection": ("m", "largest deflection of the turn"),
    },
}


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


def _not_empty(values: tuple[Any, ...]) -> tuple[Any, ...]:
    if not values:
        raise refuse(values, "a list of at least one number is accepted")
    return values


_Some, _Rising, _Falling = AfterValidator(_not_empty), _monotonic("rising", lt), _monotonic("falling", gt)
Clearances = Annotated[several(NonNegative, "a list of clearances in m"), _Some]
StartTurns = Annotated[several(Count, "a list of whole numbers of turns"), _Some]
WindowsPerTurn = Annotated[
    several(Natural, "a list of rising whole numbers"), _Some, _monotonic("rising", lt)
]
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
    found = [too_long(f"steps[{i}]", step, least) for i, step in enumerate(plan.steps) if step > least.step]
    if found:
        raise InputError(found)
