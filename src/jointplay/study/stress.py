"""The study that runs scenes far outside ordinary use, and says which answers it doubts."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from jointplay.analysis.stress import stress as stressed
from jointplay.analysis.stress.scenes import VARIANTS
from jointplay.mechanism.base import Record
from jointplay.study.kinds import Count, Integrator, Several
from jointplay.study.particular import OneStudy


class StressAnalysis(Record):
    """Keywords of `stress`.

    Parameters
    ----------
    scenes, first : int
        How many, and the number of the first; the first 64 of a series are its corners.
    seed : int
        Which series.
    variants : tuple of str
        What parts a scene has; one of them each.
    turns : int
        Nominal turns of each run.
    listed : int
        How many of the slowest and of the worst are listed with their study lines.
    """

    scenes: Several
    first: Count = 0
    seed: Count = 0
    variants: tuple[str, ...] = Field(
        tuple(VARIANTS), json_schema_extra={"accepts": f"a list of variants: {', '.join(VARIANTS)}"}
    )
    turns: Several = stressed.TURNS
    listed: Several = stressed.LISTED

    @property
    def length(self) -> str:
        """Say how many runs there are, and how long they are."""
        return f"{self.scenes} scenes of seed {self.seed} from number {self.first}, {self.turns} turns each"


class StressStudy(OneStudy):
    """Scenes far outside ordinary use, each run at two tolerances."""

    kind: Literal["stress"]
    integrator: Integrator = Integrator(max_steps=stressed.MAX_STEPS)
    analysis: StressAnalysis
    wrong = stressed.wrong
