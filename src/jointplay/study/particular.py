"""Studies whose analysis says itself what of it does not fit the mechanism, beside what all kinds check."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import ClassVar

from pydantic import model_validator

from jointplay.errors import InputError, Problem, join
from jointplay.study import fits
from jointplay.study.kinds import Study


class ParticularStudy(Study):
    """A study whose analysis has a check of its own, `wrong`, of the mechanism and its keywords."""

    wrong: ClassVar[Callable[..., None]]

    @model_validator(mode="after")
    def _fits_together(self) -> ParticularStudy:
        problems = [*fits.problems(self), *self._own_problems()]
        if problems:
            raise InputError(problems)
        return self

    def _own_problems(self) -> list[Problem]:
        try:
            type(self).wrong(self.mechanism, **self.keywords())
        except InputError as error:
            return [replace(problem, key=join("analysis", problem.key)) for problem in error.problems]
        return []
