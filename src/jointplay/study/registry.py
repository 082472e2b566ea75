"""Every kind of study, by the word that a study file calls it."""

from functools import reduce
from operator import or_
from typing import Annotated

from pydantic import Field

from jointplay.study.branches import BranchStudy, OrbitStudy
from jointplay.study.chaos import ChaosTestStudy, DimensionStudy, LyapunovStudy, SpectrumStudy
from jointplay.study.initial_states import BasinsStudy, SensitivityStudy
from jointplay.study.kinds import ResponseStudy, SectionStudy, Study
from jointplay.study.paper import ClaimsStudy, ReadingsStudy
from jointplay.study.precision import PrecisionStudy
from jointplay.study.scheme import SchemeStudy
from jointplay.study.stress import StressStudy
from jointplay.study.sweeps import BifurcationStudy

KINDS: dict[str, type[Study]] = {
    "response": ResponseStudy,
    "section": SectionStudy,
    "readings": ReadingsStudy,
    "claims": ClaimsStudy,
    "scheme_comparison": SchemeStudy,
    "bifurcation": BifurcationStudy,
    "lyapunov": LyapunovStudy,
    "chaos_test": ChaosTestStudy,
    "spectrum": SpectrumStudy,
    "dimension": DimensionStudy,
    "sensitivity": SensitivityStudy,
    "basins": BasinsStudy,
    "periodic_orbit": OrbitStudy,
    "continuation": BranchStudy,
    "stress": StressStudy,
    "work_precision": PrecisionStudy,
}
StudyFile = Annotated[reduce(or_, KINDS.values()), Field(discriminator="kind")]
