"""Every kind of study, by the word that a study file calls it."""

from typing import Annotated

from pydantic import Field

from jointplay.study.kinds import ResponseStudy, SectionStudy, Study
from jointplay.study.paper import ClaimsStudy, ReadingsStudy
from jointplay.study.scheme import SchemeStudy

KINDS: dict[str, type[Study]] = {
    "response": ResponseStudy,
    "section": SectionStudy,
    "readings": ReadingsStudy,
    "claims": ClaimsStudy,
    "scheme_comparison": SchemeStudy,
}
StudyFile = Annotated[
    ResponseStudy | SectionStudy | ReadingsStudy | ClaimsStudy | SchemeStudy, Field(discriminator="kind")
]
