"""Types of the keywords of periodic orbits and their branches, and rules that keywords must fit."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any

from pydantic import AfterValidator, BeforeValidator

from jointplay.analysis.keywords import Small, as_list
from jointplay.analysis.quantities import recorded
from jointplay.analysis.rules import assembled_at, each_alike, turns_alike
from jointplay.analysis.starts import placed
from jointplay.analysis.vary import axes
from jointplay.display.errors import NOTHING, InputError, Problem, refuse, unknown
from jointplay.solver.mechanism.base import Number, accepts, is_number, unit
from jointplay.solver.mechanism.model import Model
from jointplay.solver.mechanism.parameters import Parameter
from jointplay.solver.mechanism.records import CrankAngle, Mechanism, Plane, TestSystem

Tolerance = Annotated[Small, unit("tolerance of the residual", "1")]


def _rising(ends: tuple[float, float]) -> tuple[float, float]:
    if not ends[0] < ends[1]:
        raise refuse(ends, "two numbers, the lower first, are accepted")
    return ends


Range = Annotated[
    tuple[Number, Number], BeforeValidator(as_list), AfterValidator(_rising), accepts("a list of two numbers")
]


def started(mechanism: Mechanism | TestSystem, initial: Any) -> Model:
    """The model that an analysis shares with its rules: the mechanism at a start, or at a whole state."""
    return assembled_at(mechanism, initial, assembled=placed)


def record_fits(mechanism: Mechanism | TestSystem, record: tuple[str, ...] | None) -> None:
    """Refuse quantities that the mechanism does not have, and integrals over time."""
    recorded(record, mechanism, integrals=False)


def section_fits(mechanism: Mechanism | TestSystem, section: Any) -> Iterator[Problem]:
    """Yield the problems of a section for the search of an orbit."""
    if isinstance(section, Plane):
        if not isinstance(mechanism, TestSystem) or mechanism.period is not None:
            expected = "a crank angle (or phase of the forcing) is accepted here: kind = 'crank_angle'"
            yield Problem("section", section.kind, expected)
        elif section.quantity not in (names := sum(mechanism.order, ())):
            yield unknown("section.quantity", section.quantity, section.quantity, names, "state")
    elif not isinstance(section, CrankAngle):
        expected = "a crank angle, or a plane of a state, is accepted"
        yield Problem("section", getattr(section, "kind", section), expected)
    elif isinstance(mechanism, TestSystem) and mechanism.period is None:
        expected = "a plane of a state is accepted for a system that nothing forces: kind = 'plane'"
        yield Problem("section", section.kind, expected)


def branch_fits(
    mechanism: Mechanism | TestSystem, parameter: str, range: Any, start: float | None
) -> Iterator[Problem]:
    """Yield the problems of a branch over a parameter and its range."""
    try:
        axes(mechanism, {parameter: list(range)}, "range")
    except InputError as error:
        yield from error.problems
        return
    own = Parameter(mechanism, parameter).value
    if isinstance(own, int):
        text = f"the range of what can change by little is accepted, and {parameter} is a whole number"
        yield Problem("range", range, text)
        return
    value = own if start is None else start
    if not is_number(value) or not range[0] <= value <= range[1]:
        given = NOTHING if value is None else value
        yield Problem("start", given, f"a number from {range[0]:g} to {range[1]:g} is needed")
    between = range[0] + 0.3183 * (range[1] - range[0])  # what holds at an odd place too holds everywhere
    yield from each_alike(mechanism, {parameter: (*range, between)})


ORBIT = (section_fits, record_fits, "model", turns_alike)
