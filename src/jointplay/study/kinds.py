"""What a study says, as validated records.

A new kind of study is one more record with a `kind` and an `analysis` of its own, added to
`jointplay.study.registry`. What all kinds share is in `Study`.
"""

from __future__ import annotations

from collections.abc import Mapping
from inspect import signature
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Discriminator,
    Field,
    Tag,
    ValidationInfo,
    field_validator,
    model_validator,
)

from jointplay import figures
from jointplay.analysis.request import RTOL
from jointplay.analysis.simulate import SAMPLES_PER_TURN
from jointplay.analysis.windows import EXCLUDED, excluded, problem, too_short
from jointplay.errors import NOTHING, InputError, refuse
from jointplay.mechanism.base import Flag, NonNegative, Number, Positive, Record, measured, named
from jointplay.mechanism.records import CrankAngle, Mechanism, Section, TestSystem
from jointplay.study import fits
from jointplay.study import vary as varied
from jointplay.study.entry import MechanismSchema, build_mechanism

Count = Annotated[int, Field(strict=True, ge=0, le=10**9)]
Several = Annotated[int, Field(strict=True, ge=1, le=10**9)]
NAME = r"^\w[\w .+-]*$"


class Integrator(Record):
    """How accurately the motion is followed.

    Parameters
    ----------
    rtol : float
        Relative tolerance of a step.
    max_steps : int, optional
        Steps after which a run stops with the status ``step_limit``.
    """

    rtol: Annotated[Number, Field(ge=RTOL[0], le=RTOL[1])] = 1e-8
    max_steps: Several | None = None


class EnsembleIntegrator(Integrator):
    """How accurately the motions are followed, and whether eight at once.

    Parameters
    ----------
    ensemble : bool
        Eight motions at once: two to three times as fast.
    """

    ensemble: Flag = False


class Initial(Record):
    """Where a linkage starts: the ideal mechanism's position and speeds at a crank angle, or as written out.

    Parameters
    ----------
    crank_angle : float, optional
        rad; 0 if left out.
    crank_speed : float, optional
        rad/s; the drive's no-load speed if left out.
    angle, angular_velocity : dict of str to float, optional
        Of every link, by name, rad and rad/s, instead of the crank's.
    """

    crank_angle: Number | None = measured("crank angle", "rad", None)
    crank_speed: Number | None = measured("crank speed", "rad/s", None)
    angle: dict[str, Number] | None = measured("angle of each link, by name", "rad", None)
    angular_velocity: dict[str, Number] | None = measured(
        "angular velocity of each link, by name", "rad/s", None
    )

    @field_validator("angle", "angular_velocity")
    @classmethod
    def _instead_of_the_crank(cls, given: Any, info: ValidationInfo) -> Any:
        crank = [key for key in ("crank_angle", "crank_speed") if info.data.get(key) is not None]
        if given is not None and crank:
            raise refuse(given, f"either {' and '.join(crank)}, or angle and angular_velocity, are accepted")
        return given


def _list(accepts: str) -> Any:
    return Field(None, json_schema_extra={"accepts": accepts})


def _form(given: Any) -> str:
    return "linkage" if isinstance(given, Mapping | Initial) else "state"


_Start = Annotated[
    Annotated[Initial, Tag("linkage")] | Annotated[tuple[Number, ...], Tag("state")], Discriminator(_form)
]


class Analysis(Record):
    """What every kind of analysis takes.

    Parameters
    ----------
    duration : float, optional
        Length of the run after the transient, s; in place of `turns`.
    turns : int, optional
        Length of the run after the transient, in turns of the crank or periods of the forcing.
    transient : int
        Turns dropped before.
    record : tuple of str, optional
        Names of the variables to keep; all if left out.
    initial : Initial or tuple of float, optional
        Start of a linkage; or the state vector of a test system.
    section : Section, optional
        Where the motion is cut.
    """

    duration: Positive | None = measured("duration", "s", None)
    turns: Annotated[Several | None, Field(validate_default=True)] = None
    transient: Count = 0
    record: tuple[str, ...] | None = _list("a list of names of variables")
    initial: _Start | None = _list("a table of crank_angle, crank_speed, or a list of numbers (the state),")
    section: Section | None = None

    @field_validator("turns")
    @classmethod
    def _one_length(cls, turns: int | None, info: ValidationInfo) -> int | None:
        if "duration" not in info.data:
            return turns
        given = info.data["duration"]
        if turns is None and given is None:
            raise refuse(NOTHING, "the length of the run is needed: turns, or duration in s")
        if turns is not None and given is not None:
            raise refuse(turns, "either turns or duration is accepted, not both")
        return turns

    @property
    def length(self) -> str:
        """Say how long the run is."""
        length = f"{self.turns} turns" if self.turns else f"{self.duration:g} s"
        return f"{length} after {self.transient} dropped turns"


def _ascending(windows: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
    if wrong := problem(windows):
        raise refuse(windows, wrong)
    return windows


class _Windowed(Record):
    """Named before an analysis's own fields, so that they are checked against it."""

    windows: Annotated[tuple[tuple[Number, Number], ...], AfterValidator(_ascending)] | None = _list(
        "a list of [first, last] in turns"
    )


class ResponseAnalysis(Analysis, _Windowed):
    """Keywords of `simulate`.

    Parameters
    ----------
    windows : tuple of pairs of float, optional
        First and last nominal turn, from the start, of each stretch to keep; `turns` may then be left out.
    at : tuple of float, optional
        Times to sample, s.
    steps : bool
        True: sample at the integrator's own steps.
    samples_per_turn : int, optional
        Samples in a turn of the crank; 720 if neither `at` nor `steps` is asked for.
    section : Section, optional
        A section to keep beside the time histories; none if left out.
    """

    at: tuple[NonNegative, ...] | None = _list("a list of times in s")
    steps: Flag = False
    samples_per_turn: Annotated[Several | None, Field(validate_default=True)] = None

    @field_validator("turns")
    @classmethod
    def _one_length(cls, turns: int | None, info: ValidationInfo) -> int | None:
        windows = info.data.get("windows")
        if "windows" in info.data and windows is None:
            return super()._one_length(turns, info)
        if windows and turns is not None and turns < windows[-1][1]:
            raise refuse(turns, too_short(windows))
        return turns

    @field_validator(*EXCLUDED)
    @classmethod
    def _beside_windows(cls, value: Any, info: ValidationInfo) -> Any:
        if value and info.data.get("windows"):
            raise refuse(value, excluded(str(info.field_name)))
        return value

    @field_validator("samples_per_turn")
    @classmethod
    def _one_way_to_sample(cls, samples: int | None, info: ValidationInfo) -> int | None:
        asked = [name for name in ("at", "steps") if info.data.get(name)] + ["samples_per_turn"] * (
            samples is not None
        )
        if len(asked) > 1:
            raise refuse(samples or NOTHING, f"only one of {', '.join(asked)} is accepted")
        return samples if asked else SAMPLES_PER_TURN

    @property
    def length(self) -> str:
        """Say how long the run is."""
        kept = " and ".join(f"{first:g} to {last:g}" for first, last in self.windows or ())
        return f"turns {kept}" if kept else super().length


class SectionAnalysis(Analysis):
    """Keywords of `poincare`.

    Parameters
    ----------
    section : Section
        Where the motion is cut; once a turn at crank angle 0 if left out.
    """

    section: Section = CrankAngle()


def _checked_figure(options: dict[str, Any]) -> dict[str, Any]:
    problems = figures.problems(options)
    if problems:
        raise InputError(problems, "figure")
    return options


class FigureSchema:
    """Marks a field so that its JSON schema lists the kinds of figure and their options."""

    def __get_pydantic_json_schema__(self, *_: Any) -> dict[str, Any]:
        options = [name for draw in figures.KINDS.values() for name in list(signature(draw).parameters)[1:]]
        kind = {"enum": list(figures.KINDS)}
        properties = {"kind": kind} | {name: {} for name in sorted(set(options))}
        return {"type": "object", "properties": properties, "additionalProperties": False}


class Study(Record):
    """What every kind of study says.

    Parameters
    ----------
    kind : str
        Which analysis.
    name : str
        Name of the result and of its figure.
    title : str, optional
        One line for people.
    mechanism : Mechanism or TestSystem
        What is studied.
    vary : dict
        What changes from cell to cell, and its values; one cell if left out.
    integrator : Integrator
        How accurately.
    analysis : Analysis
        For how long, from where, and what to keep.
    figure : dict
        ``kind`` of figure and its options.
    """

    kind: str
    name: Annotated[str, Field(pattern=NAME, max_length=100)] = named(
        "name of letters, digits, spaces and _ . + -"
    )
    title: str | None = None
    mechanism: Annotated[Mechanism | TestSystem, BeforeValidator(build_mechanism), MechanismSchema()]
    vary: varied.Varied = varied.vary_field(default_factory=dict)
    integrator: Integrator = Integrator()
    analysis: Analysis
    figure: Annotated[dict[str, Any], AfterValidator(_checked_figure), FigureSchema()] = Field(
        default_factory=dict, json_schema_extra={"accepts": "a table of kind and its options"}
    )

    @field_validator("integrator", mode="before")
    @classmethod
    def _else_as_usual(cls, given: Any) -> Any:
        """What the table leaves out is as this kind of study has it."""
        usual = dict(cls.model_fields["integrator"].default)
        return usual | dict(given) if isinstance(given, Mapping) else given

    @field_validator("vary", check_fields=False)  # some kinds have none
    @classmethod
    def _can_vary(cls, vary: dict[str, Any], info: ValidationInfo) -> dict[str, Any]:
        wrong = varied.problems(info.data["mechanism"], vary, "") if vary and "mechanism" in info.data else []
        if wrong:
            raise InputError(wrong)
        return vary

    @model_validator(mode="after")
    def _fits_together(self) -> Study:
        problems = fits.problems(self)
        if problems:
            raise InputError(problems)
        return self

    @property
    def has_cells(self) -> bool:
        """Whether it is a sweep, of which each finished cell is kept."""
        return bool(self.vary)

    @property
    def heading(self) -> str:
        """One line: what is computed, of what."""
        return self.title or f"{self.kind} of {self.mechanism.name}"

    def keywords(self) -> dict[str, Any]:
        """Keywords of the analysis function, as records and plain values; what was left out stays out."""
        given = {**dict(self.integrator), **dict(self.analysis)}
        if isinstance(given.get("initial"), Initial):
            given["initial"] = given["initial"].model_dump(exclude_none=True)
        return {key: value for key, value in given.items() if value is not None}

    def summary(self) -> str:
        """Say in a few lines what the study asks for."""
        lines = [
            f"{self.name}: {self.heading}",
            f"kind       {self.kind}, {self.analysis.length}",
            f"tolerance  {self.integrator.rtol:g}",
            f"figure     {self.figure.get('kind', 'as suits the result')}",
            self.mechanism.summary(),
        ]
        if self.vary:
            told = varied.values(self.vary).items()
            spans = (f"{key}, {len(each)} from {min(each):g} to {max(each):g}" for key, each in told)
            lines.insert(1, f"varies     {'; '.join(spans)}")
        return "\n".join(lines)


class ResponseStudy(Study):
    """Time histories of a motion."""

    kind: Literal["response"]
    analysis: ResponseAnalysis


class SectionStudy(Study):
    """A Poincaré section of a motion."""

    kind: Literal["section"]
    analysis: SectionAnalysis
