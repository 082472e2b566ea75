"""The study that compares error and run time of the method with its peers."""

from __future__ import annotations

from dataclasses import replace
from typing import ClassVar, Literal

from pydantic import Field, model_validator

from jointplay.analysis.checks import together
from jointplay.analysis.precision import work_precision as compared
from jointplay.analysis.precision.plan import PEERS, Plan, check
from jointplay.errors import InputError, join
from jointplay.mechanism.assemble import assemble
from jointplay.mechanism.base import Positive, Record, measured
from jointplay.study import fits
from jointplay.study.kinds import Count, Integrator, Study, _list, _Start


class PrecisionAnalysis(Record):
    """Keywords of `work_precision`.

    Parameters
    ----------
    turns : float
        Nominal turns, or forcing periods, that are followed.
    tolerances : tuple of float
        Relative tolerances that every method runs at, falling.
    peers : tuple of str
        Names of other solvers; those not installed are left out.
    rounds : int
        Timed runs of each at most, after the first.
    budget : float
        CPU time for all runs, s.
    initial : Initial or tuple of float, optional
        Start of a linkage; or the state vector of a test system.
    """

    turns: Positive = measured("length", "turns", 1)
    tolerances: tuple[Positive, ...] = Field(
        compared.TOLERANCES, json_schema_extra={"accepts": "a list of falling relative tolerances"}
    )
    peers: tuple[str, ...] = Field(
        tuple(PEERS), json_schema_extra={"accepts": f"a list of peers: {', '.join(PEERS)}"}
    )
    rounds: Count = compared.ROUNDS
    budget: Positive = measured("CPU time for all runs", "s", compared.BUDGET)
    initial: _Start | None = _list("a table of crank_angle, crank_speed, or a list of numbers (the state),")

    @property
    def length(self) -> str:
        """Say what is compared."""
        return f"{self.turns:g} turns at {len(self.tolerances)} tolerances, beside {', '.join(self.peers)}"


class PrecisionStudy(Study):
    """Error against run time and evaluations."""

    kind: Literal["work_precision"]
    integrator: Integrator = Integrator(rtol=compared.RTOL)
    vary: ClassVar[dict] = {}  # type: ignore[misc]
    analysis: PrecisionAnalysis = PrecisionAnalysis()

    @model_validator(mode="after")
    def _fits_together(self) -> PrecisionStudy:
        asked, found = self.keywords(), fits.unsuited_figure(self)
        initial, plan = asked.pop("initial", None), Plan.of(asked)
        try:
            together(
                lambda: check(self.mechanism, plan, asked["turns"], asked["rtol"], asked.get("max_steps")),
                lambda: assemble(self.mechanism, initial),
            )
        except InputError as error:
            found += [replace(one, key=_place(one.key)) for one in error.problems]
        if found:
            raise InputError(found)
        return self


def _place(key: str) -> str:
    return key if key.startswith("mechanism") else join("analysis", key)
