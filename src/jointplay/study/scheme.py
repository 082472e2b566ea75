"""The study that compares the paper's own scheme with the monolithic method."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field

from jointplay.analysis.scheme import scheme_comparison as compared
from jointplay.analysis.scheme.scheme_plan import Plan
from jointplay.analysis.scheme.waveform import elastic_problems
from jointplay.errors import Problem
from jointplay.mechanism.base import NonNegative, Positive, Record, measured
from jointplay.study.kinds import Count, Integrator, Several
from jointplay.study.particular import OneStudy, under_analysis


def _list(default: tuple[Any, ...], accepts: str) -> Any:
    return Field(default, json_schema_extra={"accepts": accepts})


class SchemeAnalysis(Record):
    """Keywords of `scheme_comparison`.

    Parameters
    ----------
    clearance : tuple of float
        Radial clearances of joint B, m; 0: ideal joints.
    start_turn : tuple of int
        Turns after which the compared turn starts.
    windows_per_turn : tuple of int
        Into how many windows the turn is cut, rising; 1 is the paper's scheme.
    passes : int
        At most, over a window.
    tolerance : float
        Change at which two passes agree.
    steps : tuple of float
        Steps of the scheme, s, falling.
    tolerances : tuple of float
        Relative tolerances of the monolithic method that are timed.
    repeats : int
        Timed runs of each.
    """

    clearance: tuple[NonNegative, ...] = _list(compared.CLEARANCES, "a list of clearances in m")
    start_turn: tuple[Count, ...] = _list(compared.START_TURNS, "a list of whole numbers of turns")
    windows_per_turn: tuple[Several, ...] = _list(compared.WINDOWS, "a list of rising whole numbers")
    passes: Several = compared.PASSES
    tolerance: Positive = measured("change at which two passes agree", "1", compared.TOLERANCE)
    steps: tuple[Positive, ...] = _list(compared.STEPS, "a list of falling steps in s")
    tolerances: tuple[Positive, ...] = _list(compared.TOLERANCES, "a list of relative tolerances")
    repeats: Several = compared.REPEATS

    @property
    def length(self) -> str:
        """Say what is compared."""
        clearances = ", ".join(f"{value:g}" for value in self.clearance)
        return f"single turns after {', '.join(map(str, self.start_turn))} turns, clearances {clearances} m"


class SchemeStudy(OneStudy):
    """The paper's own scheme against the monolithic method."""

    kind: Literal["scheme_comparison"]
    integrator: Integrator = Integrator(rtol=compared.RTOL)
    analysis: SchemeAnalysis = SchemeAnalysis()

    def _own_problems(self) -> list[Problem]:
        plan = Plan(**dict(self.analysis) | dict(self.integrator))
        return under_analysis([*elastic_problems(self.mechanism), *plan.problems()])
