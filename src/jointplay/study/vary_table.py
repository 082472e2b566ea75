"""The `[vary]` table of a study file: parameters, their values as lists or ranges, and the points of these.

Values of several parameters make a grid. With ``zip = true`` they go together one by one instead; with
``cases`` each combination is written out as a table.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import (
    AfterValidator,
    BeforeValidator,
    Discriminator,
    Field,
    Tag,
    TypeAdapter,
    ValidationInfo,
    field_validator,
)

from jointplay.analysis.vary import Axis, axes, checked_axes
from jointplay.display.errors import InputError, Problem, join, problems_of, raise_any, refuse
from jointplay.solver.mechanism.base import Flag, Number, Record, Written, measured
from jointplay.solver.mechanism.measures import in_si
from jointplay.solver.mechanism.parameters import Parameter, declared_units
from jointplay.solver.mechanism.paths import ends
from jointplay.solver.mechanism.records import Mechanism, TestSystem

ROOT = "vary"
CASE = "case"  # the dimension of combinations that make no grid
ACCEPTED = "a list of numbers, or a table of start, stop, num and scale"
MANY = 1_000_000  # cells of a study
NAMED = 8  # parameters that a message names
TRIED = 500  # values of a range that are checked beforehand; cells report the rest


class Range(Record):
    """Evenly spaced values.

    Parameters
    ----------
    start, stop : float
        First and last value, both included.
    num : int
        Number of values.
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


def _any_form(given: Any) -> str:
    if isinstance(given, list | tuple) and any(isinstance(case, Mapping) for case in given):
        return "cases"
    return "flag" if isinstance(given, bool) else _form(given)


def _flat(table: Any) -> Any:
    """Join the keys of nested tables by dots, down to lists and ranges."""
    if not isinstance(table, Mapping):
        return table
    flat = dict(ends(table, whole=Range.model_fields))
    if isinstance(cases := flat.get("cases"), list | tuple):
        flat["cases"] = [_flat(case) for case in cases]
    return flat


def _not_empty(values: Any) -> Any:
    if not isinstance(values, list | tuple) or not values:
        raise refuse(values, f"{ACCEPTED} is accepted")
    return values


def _checked_forms(table: dict[str, Any]) -> dict[str, Any]:
    """Refuse values whose form does not suit their key: `cases`, `zip` or a parameter."""
    expected = {
        "cases": ("cases", "a list of tables of parameters, and nothing beside it,"),
        "zip": ("flag", "true or false"),
    }
    problems = []
    for key, value in table.items():
        forms, accepted = expected.get(key, ("list range", ACCEPTED))
        if _any_form(value) not in forms.split() or (key == "cases" and len(table) > 1):
            problems.append(Problem(key, value, f"{accepted} is accepted"))
    raise_any(problems)
    return table


def _parameters_alone(table: Any) -> Any:
    """Refuse `cases` and `zip` where an analysis varies each parameter by itself."""
    if words := [key for key in ("cases", "zip") if isinstance(table, Mapping) and key in table]:
        accepted = "the name of a parameter is accepted: this analysis varies each by itself"
        raise InputError([Problem(key, table[key], accepted) for key in words])
    return table


_List = Annotated[tuple[Written, ...], BeforeValidator(_not_empty)]
Values = Annotated[Annotated[_List, Tag("list")] | Annotated[Range, Tag("range")], Discriminator(_form)]
Vary = Annotated[dict[str, Values], BeforeValidator(_parameters_alone), BeforeValidator(_flat)]
_Any = Annotated[
    Annotated[_List, Tag("list")]
    | Annotated[Range, Tag("range")]
    | Annotated[Flag, Tag("flag")]
    | Annotated[tuple[dict[str, Written], ...], Tag("cases")],
    Discriminator(_any_form),
]
Varied = Annotated[dict[str, _Any], BeforeValidator(_flat), AfterValidator(_checked_forms)]


def vary_field(**more: Any) -> Any:
    """Describe a field that holds a `[vary]` table."""
    return Field(json_schema_extra={"accepts": f"a table of parameters, each with {ACCEPTED},"}, **more)


def in_own_units(mechanism: Any, table: Any) -> Any:
    """Bring values written with a unit into that of their parameter; `InputError` where they have another."""
    if not isinstance(table, Mapping):
        return table
    table = _flat(table)
    cases = table["cases"] if isinstance(table.get("cases"), list | tuple) else ()
    keys = {key for case in (table, *cases) if isinstance(case, Mapping) for key in case}
    units = {key: declared_units(mechanism, key) for key in keys - {"cases", "zip"}}
    return in_si(table, units | {"cases": units})


def parsed(table: Any) -> dict[str, Values]:
    """Parse a table of parameters of an analysis that varies them itself."""
    return TypeAdapter(Vary).validate_python(table)


def values(vary: Mapping[str, Any]) -> dict[str, tuple[float, ...]]:
    """Values of each parameter."""
    if "cases" in vary:
        keys = list(dict.fromkeys(key for case in vary["cases"] for key in case))
        return {key: tuple(case[key] for case in vary["cases"] if key in case) for key in keys}
    axes_only = ((key, given) for key, given in vary.items() if key != "zip")
    return {key: given.values if isinstance(given, Range) else given for key, given in axes_only}


def problems(mechanism: Mechanism | TestSystem, vary: Mapping[str, Any], root: str = ROOT) -> list[Problem]:
    """Problems of unknown parameters, and of values that they cannot have; of a range the first one."""
    given = values(vary)
    if together(vary):
        lost = [p for key in given for p in problems_of(Parameter.named, mechanism, key, join(root, key))]
        return lost or _uneven(vary, given, root) or _wrong_cases(mechanism, vary, given, root)
    if (total := math.prod(map(len, given.values()))) > MANY:
        shown = f"{total} combinations" if total < 10**18 else f"combinations of {len(given)} parameters"
        return [Problem(root, shown, f"at most {MANY} combinations are accepted")]
    first: dict[str, Problem] = {}
    for problem in problems_of(axes, mechanism, tried(vary), root):
        place, _, _ = problem.key.rpartition("[")
        ranged = isinstance(vary.get(place.removeprefix(root).removeprefix(".")), Range)
        key = place if ranged else problem.key
        first.setdefault(key, replace(problem, key=key))
    return list(first.values())


def tried(vary: Mapping[str, Any]) -> dict[str, Sequence[float]]:
    """Values of each parameter that are checked beforehand."""
    return {key: [each[i] for i in _sample(vary[key], len(each))] for key, each in values(vary).items()}


def _sample(given: Any, count: int) -> Sequence[int]:
    """Indices of the values that are checked beforehand: of a long range some, from end to end."""
    few = not isinstance(given, Range) or count <= TRIED
    return range(count) if few else np.linspace(0, count - 1, TRIED).astype(int).tolist()


def together(vary: Mapping[str, Any]) -> bool:
    """Whether values go together one by one, and make no grid."""
    return "cases" in vary or bool(vary.get("zip"))


def _uneven(vary: Mapping[str, Any], given: Mapping[str, Sequence[float]], root: str) -> list[Problem]:
    """Problems of lists that cannot go together one by one."""
    if "cases" in vary:
        odd = [i for i, case in enumerate(vary["cases"]) if case.keys() != given.keys() or not case]
        names = ", ".join([*list(given)[:NAMED], *["..."] * (len(given) > NAMED)]) or "the parameters"
        expected = f"each of {names}, as in the other cases, is needed"
        return [Problem(join(root, f"cases[{i}]"), vary["cases"][i], expected) for i in odd]
    sizes = {key: len(each) for key, each in given.items()}
    if len(set(sizes.values())) == 1:
        return []
    return [Problem(join(root, "zip"), sizes, "lists of the same length are accepted, one at least")]


def _wrong_cases(
    mechanism: Mechanism | TestSystem, vary: Mapping[str, Any], given: Mapping[str, Any], root: str
) -> list[Problem]:
    """Problems of values that parameters cannot have, and of repeated combinations."""
    problems, seen = [], set()
    places = {key: set(_sample(vary.get(key), len(each))) for key, each in given.items()}
    for i, combined in enumerate(zip(*given.values(), strict=True)):
        case = dict(zip(given, combined, strict=True))
        if combined in seen:
            place = join(root, f"cases[{i}]" if "cases" in vary else "zip")
            problems.append(Problem(place, case, "a combination that is not there already is accepted"))
        seen.add(combined)
        for key, value in ((key, value) for key, value in case.items() if i in places[key]):
            place = join(root, f"cases[{i}].{key}" if "cases" in vary else f"{key}[{i}]")
            for problem in problems_of(axes, mechanism, {key: (value,)}, root):
                indexed = problem.key.endswith("]")
                problems.append(replace(problem, key=place) if indexed else problem)
    return problems


@dataclass(frozen=True)
class Points:
    """The combinations of values of a study.

    Parameters
    ----------
    axes : tuple of Axis
        The parameters; their values rise along a grid, and are in the order of the cases else.
    together : bool
        Whether the values go together one by one, along the dimension ``case``.
    """

    axes: tuple[Axis, ...]
    together: bool = False

    @property
    def dims(self) -> tuple[str, ...]:
        """Dimensions of the grid."""
        return (CASE,) if self.together else tuple(axis.name for axis in self.axes)

    @property
    def shape(self) -> tuple[int, ...]:
        """Sizes along the dimensions."""
        sizes = tuple(len(axis.values) for axis in self.axes)
        return sizes[:1] if self.together else sizes

    @property
    def changes(self) -> list[dict[str, float]]:
        """Changes of the mechanism at each point, the last dimension fastest."""
        combined = zip if self.together else product
        keys = [axis.key for axis in self.axes]
        return [dict(zip(keys, point, strict=True)) for point in combined(*(a.values for a in self.axes))]

    @property
    def coordinates(self) -> dict[str, Any]:
        """Coordinates of a dataset."""
        coordinates: dict[str, Any] = {
            axis.name: (CASE if self.together else axis.name, np.array(axis.values), axis.attributes)
            for axis in self.axes
        }
        if self.together:
            counted = {"units": "1", "long_name": "number of the case"}
            coordinates[CASE] = (CASE, np.arange(self.shape[0]), counted)
        return coordinates


def points(mechanism: Mechanism | TestSystem, vary: Mapping[str, Any]) -> Points:
    """Every combination of a checked `[vary]` table."""
    given = values(vary)
    rising = checked_axes(mechanism, given)
    if not together(vary):
        return Points(rising)
    ordered = (replace(axis, values=tuple(map(float, given[axis.key]))) for axis in rising)
    return Points(tuple(ordered), together=True)
