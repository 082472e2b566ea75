"""Studies that vary parameters: bifurcation diagrams and maps."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, ValidationInfo, field_validator, model_validator

from jointplay.analysis.starts import placed
from jointplay.analysis.sweeps import bifurcation as swept
from jointplay.analysis.sweeps.attractor import RTOL, TOLERANCE
from jointplay.errors import InputError, Problem, join, refuse, unknown
from jointplay.mechanism.base import Positive, Record, measured
from jointplay.mechanism.records import CrankAngle, Mechanism, Section, TestSystem
from jointplay.study import fits
from jointplay.study import vary as varied
from jointplay.study.kinds import Count, EnsembleIntegrator, Initial, Several, Study, _list, _Start

_Direction = Literal["up", "down", "reset"]


def _listed(given: Any) -> Any:
    return [given] if isinstance(given, str) else given


class BifurcationAnalysis(Record):
    """Keywords of `bifurcation`.

    Parameters
    ----------
    turns : int
        Turns looked at, of each point.
    transient : int
        Turns dropped before.
    record : tuple of str, optional
        Names of the quantities to keep at section points.
    initial : Initial or tuple of float, optional
        Start; of a whole state as ``end_state`` of a result.
    starts : tuple, optional
        Several starts, in place of `initial`.
    section : Section
        Where the motion is cut; once a turn at crank angle 0 if left out.
    direction : tuple of {'up', 'down', 'reset'}
        Along the last parameter; one of them may stand without a list.
    exponents : int
        Leading Lyapunov exponents of each point.
    lyapunov_turns : int
        Turns over which they are averaged.
    tolerance : float
        Spread of section points that count as one, as a fraction of the clearance.
    keep : int
        Section points stored of each point.
    """

    turns: Several = swept.TURNS
    transient: Count = swept.TRANSIENT
    record: tuple[str, ...] | None = _list("a list of names of variables")
    initial: _Start | None = _list("a table of crank_angle, crank_speed, or a list of numbers (the state),")
    starts: tuple[_Start, ...] | None = _list("a list of starts, each as initial,")
    section: Section = CrankAngle()
    direction: Annotated[tuple[_Direction, ...], BeforeValidator(_listed)] = ("up",)
    exponents: Count = 0
    lyapunov_turns: Several = swept.LYAPUNOV_TURNS
    tolerance: Positive = measured("tolerance of a period", "1", TOLERANCE)
    keep: Several = swept.KEEP

    @field_validator("direction")
    @classmethod
    def _each_once(cls, direction: tuple[str, ...]) -> tuple[str, ...]:
        if not direction or len(set(direction)) < len(direction):
            raise refuse(direction, "a list of at least one direction, each once, is accepted")
        return direction

    @field_validator("starts")
    @classmethod
    def _instead_of_one(cls, starts: Any, info: ValidationInfo) -> Any:
        if starts is not None and (not starts or info.data.get("initial") is not None):
            raise refuse(starts, "a list of at least one start, and no initial beside it, is accepted")
        return starts

    @property
    def length(self) -> str:
        """Say how long the runs are."""
        return f"{self.turns} turns after {self.transient} dropped turns at each point"


class BifurcationStudy(Study):
    """Motions over one parameter, or two."""

    kind: Literal["bifurcation"]
    integrator: EnsembleIntegrator = EnsembleIntegrator(rtol=RTOL)
    vary: varied.Vary = varied.vary_field()
    analysis: BifurcationAnalysis = BifurcationAnalysis()

    @model_validator(mode="after")
    def _fits_together(self) -> BifurcationStudy:
        problems = []
        if len(self.vary) > 2 or not self.vary:
            problems.append(Problem("vary", list(self.vary), "one parameter or two are accepted"))
        if not problems:
            problems = self._misfits(swept.usual(self.mechanism, varied.values(self.vary)))
        if problems:
            raise InputError(problems)
        return self

    def _misfits(self, model: Mechanism | TestSystem) -> list[Problem]:
        """What does not fit the mechanism with the largest values."""
        there = self.model_copy(update={"mechanism": model})
        checks = (fits._misplaced_section, fits._unknown_words, fits._misplaced_figure)
        found = [problem for check in checks for problem in check(there)]
        how = self.integrator
        unfit = swept.alone(model, how.ensemble, how.rtol, self.analysis.direction)
        found += [replace(problem, key="integrator.ensemble") for problem in unfit]
        found += [p for key, start in self._starts() for p in _impossible(model, key, start)]
        known = [] if fits._unknown_words(there) else [*swept.names(self.analysis.record, model)]
        known += placed(model, None).states if "state_value" in known else ()
        return found + self._figure_problems(known)

    def _starts(self) -> list[tuple[str, Any]]:
        several = self.analysis.starts or ()
        named = [(f"analysis.starts[{i}]", start) for i, start in enumerate(several)]
        return [(key, _plain(start)) for key, start in named or [("analysis.initial", self.analysis.initial)]]

    def _figure_problems(self, known: list[str]) -> list[Problem]:
        """What the figure asks for and the result, which has the quantities `known`, will not have."""
        options, found = self.figure, []
        if options.get("kind") == "parameter_map" and len(self.vary) != 2:
            found.append(Problem("figure.kind", "parameter_map", "accepted only where two parameters vary"))
        for key, accepted in (("direction", self.analysis.direction), ("quantity", known)):
            if key in options and accepted and options[key] not in accepted:
                found.append(unknown(f"figure.{key}", options[key], options[key], accepted, key))
        return found

    def keywords(self) -> dict[str, Any]:
        """Keywords of the analysis function; what was left out stays out."""
        given = {**dict(self.integrator), **dict(self.analysis), "over": varied.values(self.vary)}
        for key in ("initial", "starts"):
            given[key] = _plain(given[key])
        return {key: value for key, value in given.items() if value is not None}


def _plain(start: Any) -> Any:
    """A start, or several, as plain values."""
    if isinstance(start, Initial):
        return start.model_dump(exclude_none=True)
    if isinstance(start, tuple) and any(isinstance(each, Initial | tuple) for each in start):
        return tuple(map(_plain, start))
    return start


def _impossible(model: Mechanism | TestSystem, key: str, start: Any) -> list[Problem]:
    try:
        placed(model, start)
    except InputError as error:
        tails = ((problem, problem.key.removeprefix("initial")) for problem in error.problems)
        return [p if tail == p.key else replace(p, key=join(key, tail)) for p, tail in tails]
    return []
