"""Studies of chaos: Lyapunov exponents, 0-1 test, power spectrum, correlation dimension."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator, Field

from jointplay.analysis.exponents import lyapunov as exponents
from jointplay.analysis.signals import chaos_test, dimension, spectrum
from jointplay.errors import refuse
from jointplay.mechanism.base import Flag, Number, Positive, measured
from jointplay.mechanism.records import CrankAngle, Section
from jointplay.study.kinds import Analysis, Count, Integrator, Several
from jointplay.study.particular import ParticularStudy

_Quantity = Annotated[str | None, Field(json_schema_extra={"accepts": "the name of a quantity"})]
_Share = Annotated[Number, Field(ge=0, lt=1)]


def _number_or_all(given: Any) -> Any:
    if given == "all" or (isinstance(given, int) and not isinstance(given, bool) and given >= 1):
        return given
    raise refuse(given, 'a whole number greater than 0, or "all", is accepted')


class Motion(Analysis):
    """A stretch of a motion, without section or recorded quantities."""

    record: ClassVar[None] = None  # type: ignore[misc]
    section: ClassVar[None] = None  # type: ignore[misc]


class LyapunovAnalysis(Motion):
    """Keywords of `lyapunov`.

    Parameters
    ----------
    exponents : int or "all"
        How many, the largest first.
    error : float, optional
        Standard error of the largest exponent, 1/s, at which the run stops.
    twin_turns : int
        Turns over which the largest is estimated a second time, by twin trajectories; 0: not.
    saltation : bool
        False leaves the tangents' jumps at events out, as a comparison.
    """

    exponents: Annotated[int | str, BeforeValidator(_number_or_all)] = 1
    error: Positive | None = measured("standard error", "1/s", None)
    twin_turns: Count = 0
    saltation: Flag = True


class SpectrumAnalysis(Motion):
    """Keywords of `spectrum`.

    Parameters
    ----------
    quantity : str, optional
        As ``normal_force`` or ``angle:rocker``.
    samples_per_turn : int
        Evenly spaced samples in a nominal turn.
    segments : int
        Segments whose periodograms are averaged.
    window : str
        A window of SciPy.
    """

    quantity: _Quantity = None
    samples_per_turn: Several = spectrum.SAMPLES_PER_TURN
    segments: Several = spectrum.SEGMENTS
    window: Annotated[str, Field(json_schema_extra={"accepts": "the name of a window"})] = spectrum.WINDOW


class Sampled(Analysis):
    """A number of section points.

    Parameters
    ----------
    section : Section
        Where the motion is cut; once a turn at crank angle 0 if left out.
    """

    duration: ClassVar[None] = None  # type: ignore[misc]
    record: ClassVar[None] = None  # type: ignore[misc]
    section: Section = CrankAngle()

    @property
    def length(self) -> str:
        """Say how long the run is."""
        return f"{self.turns} section points after {self.transient} dropped turns"


class ChaosTestAnalysis(Sampled):
    """Keywords of `chaos_test`.

    Parameters
    ----------
    turns : int
        Section points.
    quantity : str, optional
        As ``normal_force`` or ``angle:rocker``.
    every : int
        Each so many points are kept.
    frequencies, seed : int
        How many random frequencies, and the seed of their drawing.
    tolerance : float
        Spread, relative to the quantity's size in a turn, of samples that count as one.
    """

    turns: Several = chaos_test.TURNS
    quantity: _Quantity = None
    every: Several = 1
    frequencies: Several = chaos_test.FREQUENCIES
    seed: Count = 0
    tolerance: _Share = chaos_test.TOLERANCE


class DimensionAnalysis(Sampled):
    """Keywords of `dimension`.

    Parameters
    ----------
    turns : int
        Section points.
    quantities : tuple of str, optional
        The points' coordinates.
    window : int
        Pairs fewer than so many points apart are left out.
    shares : pair of float
        The range of the correlation sum over which its slope is taken.
    tolerance : float
        Spread, relative to its largest value, of a coordinate that counts as constant.
    """

    turns: Several = dimension.TURNS
    quantities: tuple[str, ...] | None = Field(
        None, json_schema_extra={"accepts": "a list of names of quantities"}
    )
    window: Several = dimension.WINDOW
    shares: tuple[_Share, _Share] = dimension.SHARES
    tolerance: _Share = dimension.TOLERANCE


class LyapunovStudy(ParticularStudy):
    """Lyapunov exponents of a motion."""

    kind: Literal["lyapunov"]
    analysis: LyapunovAnalysis
    wrong = exponents.wrong


class ChaosTestStudy(ParticularStudy):
    """The 0-1 test for chaos on section samples."""

    kind: Literal["chaos_test"]
    integrator: Integrator = Integrator(rtol=chaos_test.RTOL)
    analysis: ChaosTestAnalysis = ChaosTestAnalysis()
    wrong = chaos_test.wrong


class SpectrumStudy(ParticularStudy):
    """Power spectral density of a quantity."""

    kind: Literal["spectrum"]
    analysis: SpectrumAnalysis
    wrong = spectrum.wrong


class DimensionStudy(ParticularStudy):
    """Correlation dimension of section points."""

    kind: Literal["dimension"]
    integrator: Integrator = Integrator(rtol=dimension.RTOL)
    analysis: DimensionAnalysis = DimensionAnalysis()
    wrong = dimension.wrong
