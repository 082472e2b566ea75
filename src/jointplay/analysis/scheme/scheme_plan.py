"""What a comparison with the paper's scheme is asked for, and the words of its answer."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from jointplay.analysis.paper.fixed_steps import positive, step_bound, too_long
from jointplay.analysis.request import RTOL
from jointplay.analysis.scheme.waveform import elastic_problems
from jointplay.errors import InputError, Problem
from jointplay.mechanism.assemble import assemble

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

    def problems(self) -> Iterator[Problem]:
        """Say what makes no sense by itself."""
        if not _all(lambda value: value == 0 or positive(value), self.clearance):
            yield Problem("clearance", self.clearance, "finite numbers, 0 or more, are accepted, m")
        if not _all(lambda value: _whole(value, 0), self.start_turn):
            yield Problem("start_turn", self.start_turn, "whole numbers, 0 or more, are accepted")
        if not (_all(_whole, self.windows_per_turn) and _rising(self.windows_per_turn)):
            expected = "whole numbers greater than 0, rising, are accepted"
            yield Problem("windows_per_turn", self.windows_per_turn, expected)
        if not (_all(positive, self.steps) and _rising(self.steps[::-1])):
            yield Problem("steps", self.steps, "finite numbers greater than 0, falling, are accepted, s")
        for key, values in (("tolerances", self.tolerances), ("rtol", (self.rtol,))):
            if not _all(lambda value: positive(value) and RTOL[0] <= value <= RTOL[1], values):
                yield Problem(
                    key, values, f"relative tolerances from {RTOL[0]:g} to {RTOL[1]:g} are accepted"
                )
        for key, value in (("passes", self.passes), ("repeats", self.repeats)):
            if not _whole(value):
                yield Problem(key, value, "a whole number greater than 0 is accepted")
        if not positive(self.tolerance):
            yield Problem("tolerance", self.tolerance, "a finite number greater than 0 is accepted")


def _all(accepts: Callable[[Any], bool], values: Sequence[Any]) -> bool:
    return len(values) > 0 and all(map(accepts, values))


def _whole(value: Any, least: int = 1) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and value >= least


def _rising(values: Sequence[float]) -> bool:
    return all(a < b for a, b in pairwise(values))


def check(mechanism: Any, plan: Plan, initial: Any) -> None:
    """Refuse what makes no sense, all at once, before anything is followed.

    Raises
    ------
    InputError
        Listing every problem.
    """
    found = [*elastic_problems(mechanism), *plan.problems()]
    if found:
        raise InputError(found)
    scenes = (assemble(mechanism.replace(clearance=e), initial, relaxed=True) for e in plan.clearance)
    least = min(map(step_bound, scenes), key=lambda bound: bound.step)
    found = [too_long(f"steps[{i}]", step, least) for i, step in enumerate(plan.steps) if step > least.step]
    if found:
        raise InputError(found)
