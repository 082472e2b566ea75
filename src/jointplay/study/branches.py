"""Studies of periodic orbits: one, or their branches over a parameter."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, model_validator

from jointplay import figures
from jointplay.analysis.orbits import continuation as traced
from jointplay.analysis.orbits import periodic_orbit as found
from jointplay.analysis.orbits.orbit_request import check_branch, check_orbit
from jointplay.analysis.orbits.orbit_words import SAMPLES
from jointplay.analysis.orbits.shooting import ITERATIONS, TOLERANCE
from jointplay.analysis.starts import placed
from jointplay.errors import NOTHING, InputError, Problem, join
from jointplay.mechanism.base import Flag, Number, Positive, Record, measured
from jointplay.mechanism.records import CrankAngle, Section
from jointplay.study import fits
from jointplay.study.kinds import Count, Integrator, Several, Study, _list, _Start

_FORMS = "a table of crank_angle, crank_speed, or a list of numbers (the state),"


class OrbitAnalysis(Record):
    """Keywords of `periodic_orbit`.

    Parameters
    ----------
    section : CrankAngle or Plane
        Where the orbit is looked for: crank angle, phase of the forcing, or a plane of a state.
    period : int
        Turns after which the orbit closes.
    initial : Initial or tuple of float, optional
        Start, or the whole state.
    transient : int
        Turns that are followed first.
    tolerance : float
        Residual at which the search has succeeded, in units of the states' scales.
    max_iterations : int
        Of Newton's method.
    record : tuple of str, optional
        Quantities to sample over the orbit; none if left out.
    samples_per_turn : int
        Of these.
    """

    section: Section = CrankAngle()
    period: Several = 1
    initial: _Start | None = _list(_FORMS)
    transient: Count = found.TRANSIENT
    tolerance: Positive = measured("tolerance of the residual", "1", TOLERANCE)
    max_iterations: Several = ITERATIONS
    record: tuple[str, ...] | None = _list("a list of names of variables")
    samples_per_turn: Several = SAMPLES

    @property
    def length(self) -> str:
        """Say what is looked for."""
        return f"period {self.period}, after {self.transient} dropped turns"


class BranchAnalysis(Record):
    """Keywords of `continuation`.

    Parameters
    ----------
    parameter : str
        What varies: a name, or a key path.
    range : pair of float
        Lowest and highest value.
    start : float, optional
        Value at which the first orbit is looked for; the mechanism's own if left out.
    section, period, initial, transient, tolerance
        As of a periodic orbit.
    step : float
        Longest step, as a fraction of the range.
    max_points : int
        Points of a branch, at most.
    branch_switching : bool
        Whether branches that leave at period doublings and branch points are followed.
    max_branches : int
        Branches, at most.
    record : tuple of str, optional
        Quantities to keep on the section; all if left out.
    """

    parameter: Annotated[str, Field(min_length=1)] = "clearance"
    range: tuple[Number, Number] = Field(json_schema_extra={"accepts": "a list of two numbers"})
    start: Number | None = measured("value to start at", "1", None)
    section: Section = CrankAngle()
    period: Several = 1
    initial: _Start | None = _list(_FORMS)
    transient: Count = found.TRANSIENT
    tolerance: Positive = measured("tolerance of the residual", "1", TOLERANCE)
    step: Positive = measured("longest step", "1", traced.STEP)
    max_points: Several = traced.MAX_POINTS
    branch_switching: Flag = True
    max_branches: Several = traced.MAX_BRANCHES
    record: tuple[str, ...] | None = _list("a list of names of variables")

    @property
    def length(self) -> str:
        """Say what is followed."""
        low, high = self.range
        return f"{self.parameter} from {low:g} to {high:g}, period {self.period}"


class BranchesStudy(Study):
    """What both kinds share."""

    integrator: Integrator = Integrator(rtol=found.RTOL)
    check: ClassVar[Any]

    @model_validator(mode="after")
    def _fits_together(self) -> BranchesStudy:
        given = {**dict(self.integrator), **dict(self.analysis)}
        problems = [*self._wrong(given), *self._misplaced()]
        if problems:
            raise InputError(problems)
        return self

    def _wrong(self, given: dict[str, Any]) -> list[Problem]:
        given.pop("initial")
        try:
            type(self).check(self.mechanism, given.pop("section"), given.pop("record"), **given)
            placed(self.mechanism, self.keywords().get("initial"))
        except InputError as error:
            return [
                problem
                if problem.key.startswith("mechanism")
                else replace(problem, key=join("analysis", problem.key))
                for problem in error.problems
            ]
        return []

    def _misplaced(self) -> list[Problem]:
        suited, asked = figures.SUITED[self.kind], self.figure.get("kind")
        if asked in (None, suited[0], "sweep"):
            return fits.unsuited_figure(self)
        return fits.unsuited_figure(self) or self._lacking()

    def _lacking(self) -> list[Problem]:
        """What the figure draws and the result will not hold."""
        if self.kind != "periodic_orbit":
            return []
        if self.analysis.record is None:
            expected = f"a list of what the figure {self.figure['kind']} draws is needed"
            return [Problem("analysis.record", NOTHING, expected)]
        return figures.lacking(self.figure, self.analysis.record)


class OrbitStudy(BranchesStudy):
    """A periodic orbit with its Floquet multipliers."""

    kind: Literal["periodic_orbit"]
    analysis: OrbitAnalysis = OrbitAnalysis()
    check = check_orbit


class BranchStudy(BranchesStudy):
    """Branches of periodic orbits over a parameter."""

    kind: Literal["continuation"]
    analysis: BranchAnalysis
    check = check_branch
