"""Studies of initial states: how neighbours part, exponents over a plane of starts, basins of attraction."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Discriminator, Field, Tag

from jointplay.analysis.states import basins as reached
from jointplay.analysis.states import sensitivity
from jointplay.errors import Problem
from jointplay.mechanism.base import Flag, Name, Number, Positive, Record, measured, named
from jointplay.study.kinds import Analysis, Count, EnsembleIntegrator, Integrator, Several
from jointplay.study.particular import ParticularStudy

_ACCEPTS = "a table of two coordinates, each a rising list of numbers or a table of start, stop and num,"
_Open = Annotated[Number, Field(gt=0, lt=1)]


class Span(Record):
    """Evenly spaced values.

    Parameters
    ----------
    start, stop : float
        First and last.
    num : int
        How many.
    """

    start: Number
    stop: Number
    num: Annotated[int, Field(strict=True, ge=2, le=10**5)]

    def __len__(self) -> int:
        return self.num


def _form(given: Any) -> str:
    return "span" if isinstance(given, Mapping | Span) else "values"


_Axis = Annotated[
    Annotated[Span, Tag("span")] | Annotated[tuple[Number, ...], Tag("values")], Discriminator(_form)
]


class StartsAnalysis(Analysis):
    """What these studies share: no section, no recorded quantities, a length in turns.

    Parameters
    ----------
    plane : dict
        Two coordinates of initial states, each with its values.
    joint : str, optional
        Whose journal is meant; the only one with clearance if left out.
    """

    duration: ClassVar[None] = None  # type: ignore[misc]
    record: ClassVar[None] = None  # type: ignore[misc]
    section: ClassVar[None] = None  # type: ignore[misc]
    plane: dict[str, _Axis] | None = Field(None, json_schema_extra={"accepts": _ACCEPTS})
    joint: Name | None = named("joint name", None)


class SensitivityAnalysis(StartsAnalysis):
    """Keywords of `sensitivity`.

    Parameters
    ----------
    turns : int
        Turns that motion and neighbours are followed.
    neighbours : int, optional
        20 if left out, none beside a plane.
    references : int
        States of the motion that have neighbours.
    distance : float
        Scaled distance of the neighbours at the start.
    samples_per_turn : int
        How often states are compared.
    compare : {"section", "time"}, optional
        At equal crank angle (phase), or at equal times.
    seed : int
        Of the neighbours' directions.
    """

    turns: Several = 40
    neighbours: Count | None = None
    references: Several = 1
    distance: _Open = sensitivity.DISTANCE
    samples_per_turn: Several = 1
    compare: Literal["section", "time"] | None = Field(
        None, json_schema_extra={"accepts": '"section" or "time"'}
    )
    seed: Count = 0


class BasinsAnalysis(StartsAnalysis):
    """Keywords of `basins`.

    Parameters
    ----------
    turns : int
        Turns by which an end is described.
    transient : int
        Turns dropped before.
    patience : int
        How often a motion without a period is followed further.
    tolerance : float
        Distance up to which section points of periodic ends are the same.
    uncertainty : bool
        Whether to estimate the uncertainty exponent of the boundary.
    pairs : int
        Random points for it beside the grid.
    """

    turns: Annotated[int, Field(strict=True, ge=4, le=10**9)] = reached.TURNS
    transient: Count = reached.TRANSIENT
    plane: dict[str, _Axis] = Field(json_schema_extra={"accepts": _ACCEPTS})
    patience: Count = reached.PATIENCE
    tolerance: Positive = measured("tolerance", "1", reached.TOLERANCE)
    uncertainty: Flag = True
    pairs: Annotated[Count, Field(le=10**7)] = 0


class StartsStudy(ParticularStudy):
    """What these studies share: a plane of initial states."""

    def keywords(self) -> dict[str, Any]:
        """Keywords of the analysis function; axes as lists, or as tables of start, stop and num."""
        given = super().keywords()
        if self.analysis.plane is not None:
            axes = self.analysis.plane.items()
            given["plane"] = {name: dict(v) if isinstance(v, Span) else list(v) for name, v in axes}
        return given


class SensitivityStudy(StartsStudy):
    """How neighbours part from a motion, or exponents over a plane of initial states."""

    kind: Literal["sensitivity"]
    integrator: Integrator = Integrator(rtol=sensitivity.RTOL)
    analysis: SensitivityAnalysis = SensitivityAnalysis()
    wrong = sensitivity.wrong

    def _own_problems(self) -> list[Problem]:
        """What the figure draws has to be there too."""
        found, asked = super()._own_problems(), self.figure.get("kind")
        shown = self._bundled or bool(self.figure.get("quantity"))
        there = {"divergence": self._bundled, "field": self.analysis.plane is not None, "sweep": shown}
        if not there.get(asked, True):
            needed = "plane" if asked == "field" else "neighbours"
            found.append(Problem("figure.kind", asked, f"it is accepted where analysis.{needed} is given"))
        return found

    @property
    def _bundled(self) -> bool:
        given = self.analysis.neighbours
        return bool(given) or (given is None and self.analysis.plane is None)


class BasinsStudy(StartsStudy):
    """Which attractor each start of a plane reaches."""

    kind: Literal["basins"]
    integrator: EnsembleIntegrator = EnsembleIntegrator()
    analysis: BasinsAnalysis
    wrong = reached.wrong
