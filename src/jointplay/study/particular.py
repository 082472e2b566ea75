"""Studies whose analysis says itself what of it does not fit the mechanism, beside what all kinds check."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import ClassVar

from pydantic import model_validator

from jointplay.errors import InputError, Problem, join
from jointplay.study import fits
from jointplay.study.kinds import EnsembleIntegrator, Study


class ParticularStudy(Study):
    """A study whose analysis has a check of its own, `wrong`, of the mechanism and its keywords."""

    wrong: ClassVar[Callable[..., None]]

    @model_validator(mode="after")
    def _fits_together(self) -> ParticularStudy:
        problems = [*self._usual_problems(), *self._own_problems()]
        if problems:
            raise InputError(problems)
        return self

    def _usual_problems(self) -> list[Problem]:
        return fits.problems(self)

    def _own_problems(self) -> list[Problem]:
        try:
            type(self).wrong(self.mechanism, **self.keywords())
        except InputError as error:
            return under_analysis(error.problems)
        return []


class OneStudy(ParticularStudy):
    """A study that makes all its motions of one mechanism as it is: nothing varies, no section, no record."""

    vary: ClassVar[dict] = {}  # type: ignore[misc]

    def _usual_problems(self) -> list[Problem]:
        return fits.unsuited_figure(self)


def under_analysis(problems: list[Problem]) -> list[Problem]:
    """Problems of an analysis function's keywords, by the places of these in a study."""
    found = []
    for problem in problems:
        table = "integrator" if problem.key in EnsembleIntegrator.model_fields else "analysis"
        own = problem.key.startswith("mechanism")
        found.append(problem if own else replace(problem, key=join(table, problem.key)))
    return found
