"""Studies of the paper as a whole: readings of what it leaves open, and its conclusions graded."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from jointplay.analysis.paper.character import TOLERANCE
from jointplay.analysis.paper.claims import DAMPING_RATIOS
from jointplay.analysis.paper.reading_list import PANELS, READINGS
from jointplay.analysis.paper.readings import misfits, strangers
from jointplay.errors import Problem
from jointplay.mechanism.base import Number, Positive, Record, measured
from jointplay.study.kinds import Count, Several
from jointplay.study.particular import OneStudy, under_analysis

_Ratio = Annotated[Number, Field(ge=0, le=1)]


class PaperAnalysis(Record):
    """Lengths of the motions that are told apart as periodic or chaotic.

    Parameters
    ----------
    turns : int
        Turns looked at.
    transient : int
        Turns dropped before.
    growth_turns : int
        Turns over which the growth of a small difference is averaged.
    """

    turns: Several = 300
    transient: Count = 400
    growth_turns: Several = 200

    @property
    def length(self) -> str:
        """Say how long the runs are."""
        return f"{self.turns} turns after {self.transient} dropped turns"


class ReadingsAnalysis(PaperAnalysis):
    """Keywords of `readings`.

    Parameters
    ----------
    tolerance : float
        Spread of section points that count as one, as a fraction of the clearance.
    panels : tuple of str
        Panels of Figure 12: a, b, c.
    readings : tuple of str
        Names of readings.
    """

    tolerance: Positive = measured("tolerance of a period", "1", TOLERANCE)
    panels: tuple[str, ...] = Field(tuple(PANELS), json_schema_extra={"accepts": "a list of panels: a, b, c"})
    readings: tuple[str, ...] = Field(
        tuple(READINGS), json_schema_extra={"accepts": f"a list of readings: {', '.join(READINGS)}"}
    )


class ClaimsAnalysis(PaperAnalysis):
    """Keywords of `claims`.

    Parameters
    ----------
    damping_ratios : tuple of float
        Structural damping ratios of the elastic coupler, 0 to 1; 0 and 0.01 are always among them.
    """

    damping_ratios: tuple[_Ratio, ...] = Field(
        DAMPING_RATIOS, json_schema_extra={"accepts": "a list of damping ratios, 0 to 1"}
    )


class PaperStudy(OneStudy):
    """What studies of the whole paper share: one mechanism as printed, from which many are made."""

    analysis: PaperAnalysis

    def _own_problems(self) -> list[Problem]:
        return misfits(self.mechanism)


class ReadingsStudy(PaperStudy):
    """Every panel of Figure 12 under every reading of what the paper leaves open."""

    kind: Literal["readings"]
    analysis: ReadingsAnalysis = ReadingsAnalysis()

    def _own_problems(self) -> list[Problem]:
        strange = strangers(self.analysis.panels, self.analysis.readings)
        return super()._own_problems() + under_analysis(strange)


class ClaimsStudy(PaperStudy):
    """The paper's four conclusions, graded."""

    kind: Literal["claims"]
    analysis: ClaimsAnalysis = ClaimsAnalysis()
