"""The `[vary]` table of a study file: parameters and their values, as lists or ranges."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import (
    AfterValidator,
    BeforeValidator,
    Discriminator,
    Field,
    Tag,
    ValidationInfo,
    field_validator,
)

from jointplay.analysis.vary import axes
from jointplay.errors import InputError, Problem, refuse
from jointplay.mechanism.base import Number, Record, measured
from jointplay.mechanism.records import Mechanism, TestSystem

ROOT = "vary"
ACCEPTED = "a list of numbers, or a table of start, stop, num and scale,"


class Range(Record):
    """Evenly spaced values.

    Parameters
    ----------
    start, stop : float
        First and last value, both included.
    num : int
        How many.
    scale : {'linear', 'log'}
        Even in the values, or in their logarithms.
    """

    start: Number = measured("first value", "1")
    stop: Number = measured("last value", "1")
    num: Annotated[int, Field(strict=True, ge=2, le=100_000)]
    scale: Literal["linear", "log"] = "linear"

    @field_validator("stop")
    @classmethod
    def _goes_somewhere(cls, stop: float, info: ValidationInfo) -> float:
        if stop == info.data.get("start"):
            raise refuse(stop, "a last value other than the first is accepted")
        return stop

    @field_validator("scale")
    @classmethod
    def _has_logarithms(cls, scale: str, info: ValidationInfo) -> str:
        ends = [info.data[key] for key in ("start", "stop") if key in info.data]
        if scale == "log" and any(end <= 0 for end in ends):
            raise refuse(scale, "'linear' is accepted, or start and stop greater than 0")
        return scale

    @property
    def values(self) -> tuple[float, ...]:
        """The values, in order."""
        spaced = np.geomspace if self.scale == "log" else np.linspace
        return tuple(spaced(self.start, self.stop, self.num).tolist())


def _form(given: Any) -> str:
    return "range" if isinstance(given, Mapping | Range) else "list"


def _flat(table: Any, path: str = "") -> Any:
    """A key path may be written as nested tables: joined by dots, down to lists and ranges."""
    if not isinstance(table, Mapping):
        return table
    found: dict[str, Any] = {}
    for key, value in table.items():
        place = f"{path}.{key}" if path else str(key)
        nested = isinstance(value, Mapping) and value and not set(value) & set(Range.model_fields)
        found |= _flat(value, place) if nested else {place: value}
    return found


def _not_empty(values: Any) -> Any:
    if not values:
        raise refuse(values, f"{ACCEPTED.rstrip(',')} is accepted")
    return values


_List = Annotated[tuple[Number, ...], AfterValidator(_not_empty)]
Values = Annotated[Annotated[_List, Tag("list")] | Annotated[Range, Tag("range")], Discriminator(_form)]
Vary = Annotated[dict[str, Values], BeforeValidator(_flat)]


def vary_field() -> Any:
    """Describe a field that holds a `[vary]` table."""
    return Field(json_schema_extra={"accepts": f"a table of parameters, each with {ACCEPTED}"})


def values(vary: Mapping[str, Any]) -> dict[str, tuple[float, ...]]:
    """Values of each parameter."""
    return {key: each.values if isinstance(each, Range) else each for key, each in vary.items()}


def problems(mechanism: Mechanism | TestSystem, vary: Mapping[str, Any]) -> list[Problem]:
    """List parameters that do not exist, and values that they cannot have; of a range the first one."""
    try:
        axes(mechanism, values(vary), ROOT)
    except InputError as error:
        found: dict[str, Problem] = {}
        for problem in error.problems:
            place, _, _ = problem.key.rpartition("[")
            key = place if isinstance(vary.get(place.removeprefix(f"{ROOT}.")), Range) else problem.key
            found.setdefault(key, Problem(key, problem.given, problem.expected))
        return list(found.values())
    return []
