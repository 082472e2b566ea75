"""The study that compares error and run time of the method with its peers."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from jointplay.analysis.precision import work_precision as compared
from jointplay.analysis.precision.plan import PEERS, wrong
from jointplay.mechanism.base import Positive, Record, measured
from jointplay.study.kinds import Count, Integrator, _list, _Start
from jointplay.study.particular import OneStudy


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


class PrecisionStudy(OneStudy):
    """Error against run time and evaluations."""

    kind: Literal["work_precision"]
    integrator: Integrator = Integrator(rtol=compared.RTOL)
    analysis: PrecisionAnalysis = PrecisionAnalysis()
    wrong = wrong
