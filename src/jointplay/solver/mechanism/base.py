"""Base of all records (frozen, no unknown keys, all errors at once), and the types of their fields."""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Mapping
from functools import cache
from typing import Annotated, Any, ClassVar, Literal, Self, TypeVar

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    ValidationError,
    model_validator,
)

from jointplay.display.accepted import Refused, from_pydantic, units_of
from jointplay.display.errors import InputError, refuse
from jointplay.solver.mechanism.measures import in_si

GROUND = "ground"  # name of the fixed frame, where a link is named
Branch = Literal["upper", "lower"]  # of a four-bar: which of the two ways to assemble it
DOWNWARDS = -math.pi / 2  # rad, the usual direction of gravity: along -y


class Record(BaseModel):
    """A validated, frozen description; wrong input raises `jointplay.display.errors.InputError`."""

    model_config = ConfigDict(frozen=True, extra="forbid")
    root: ClassVar[str | None] = None  # how the keys in its errors begin; None: by the name of the class

    def __init__(self, /, *values: Any, **data: Any) -> None:
        if values:
            raise refuse(values, f"keywords are accepted: {', '.join(type(self).model_fields)}", self._root())
        try:
            super().__init__(**plain(data))
        except ValidationError as error:
            raise from_pydantic(error, type(self), self._root()) from None

    @classmethod
    def model_validate(cls, obj: Any, **options: Any) -> Self:
        """Build the record from a mapping of its keys; wrong input raises `InputError`."""
        if isinstance(obj, Mapping) and not options and all(isinstance(key, str) for key in obj):
            return cls(**obj)  # where a class has an __init__, pydantic goes through its validators twice
        try:
            return super().model_validate(plain(obj), **options)
        except ValidationError as error:
            raise from_pydantic(error, cls, cls._root()) from None

    @model_validator(mode="before")
    @classmethod
    def _in_the_fields_units(cls, data: Any) -> Any:
        if not isinstance(data, Mapping) or not any(
            isinstance(each, _MAY_HOLD_TEXT) for each in data.values()
        ):
            return data
        units = _units(cls) | cls._further_units(data)
        return {name: _in_si(value, units.get(name)) for name, value in data.items()}

    @classmethod
    def _further_units(cls, data: Mapping[str, Any]) -> Mapping[str, Any]:
        """Units of fields, as of `in_si`, that depend on the given data, or that are of tables."""
        return {}

    def _stated(self, changed: Mapping[str, Any] = {}) -> dict[str, Any]:
        """Fields to build a changed copy of; those that follow from others are left out, to follow anew."""
        return dict(self)

    def __setattr__(self, name: str, value: Any) -> None:
        raise refuse(value, "a record does not change: replace(), or a new one, gives a changed copy", name)

    def __dir__(self) -> list[str]:
        """Names that the record describes; pydantic's own are left out, but for special ones."""
        return [name for name in super().__dir__() if name[:2] == "__" or name not in dir(BaseModel)]

    @classmethod
    def _root(cls) -> str:
        return re.sub(r"(?<=[a-z])(?=[A-Z])", "_", cls.__name__).lower() if cls.root is None else cls.root


_MAY_HOLD_TEXT = str | list | tuple | Mapping


@cache
def _units(record: type[Record]) -> dict[Any, Any]:
    return {name: units_of(field) for name, field in record.model_fields.items()}


def _in_si(given: Any, units: Any) -> Any:
    try:
        return in_si(given, units)
    except InputError as error:
        return Refused(error)


def hash_of(record: Record) -> int:
    """Hash of a record some of whose fields are tables."""
    return hash(tuple(tuple(each.items()) if isinstance(each, dict) else each for _, each in record))


def plain(given: Any) -> Any:
    """Turn NumPy's numbers and arrays into Python's, in tables and lists too, and keys into texts."""
    if type(given).__module__ == "numpy" and hasattr(given, "tolist"):
        return given.tolist()
    if type(given) is dict:
        return {str(key): plain(value) for key, value in given.items()}
    return type(given)(map(plain, given)) if type(given) in (list, tuple) else given


def is_number(given: Any) -> bool:
    """Whether a value is a finite number that a float can hold, and neither true nor false."""
    most = sys.float_info.max
    return isinstance(given, int | float) and not isinstance(given, bool) and -most <= given <= most


def not_empty(items: tuple[Any, ...]) -> tuple[Any, ...]:
    """Rule: there is at least one."""
    if not items:
        raise refuse(items, "a list of at least one is accepted")
    return items


def _not_too_many(items: Any) -> Any:
    if isinstance(items, list | tuple) and len(items) > MOST:
        raise refuse(f"{len(items)} of them", f"a list of at most {MOST} is accepted")
    return items


_STRICT = Field(strict=True, allow_inf_nan=False)
Number = Annotated[float, _STRICT]
Positive = Annotated[float, _STRICT, Field(gt=0)]
NonNegative = Annotated[float, _STRICT, Field(ge=0)]
Fraction = Annotated[float, _STRICT, Field(gt=0, le=1)]
LONG = 10.0  # m: few linkages have longer links
LONGEST = 1e9  # m; moments of inertia and stiffnesses, with its cube, remain numbers
Length = Annotated[Positive, Field(le=LONGEST)]
Place = Annotated[Number, Field(ge=-LONGEST, le=LONGEST)]  # along a link
FAR = 1000 * math.tau  # rad; beyond, the rounding of an angle nears the tolerances of a run
ANGLE = "an angle in rad, at most 1000 turns (6283 rad) to either side, is accepted: take off whole turns"


def _near(angle: float) -> float:
    if not abs(angle) <= FAR:
        raise refuse(angle, ANGLE)
    return angle


def in_degrees(angle: float) -> str:
    """Ask whether an angle beyond a turn is meant in degrees."""
    meant = f"if degrees are meant, write '{angle:g} deg' or {math.radians(angle):.6g}"
    return f"{angle:g} rad are {angle / math.tau:.3g} turns; {meant}"


def in_millimetres(length: float) -> str:
    """Ask whether a length that is too long is meant in millimetres."""
    return f"; did you mean {length:g} mm = {length / 1000:g} m?"


def _within_a_turn(angle: float) -> float:
    if not abs(angle) <= math.tau * (1 + 1e-9):
        accepted = "an angle of at most a turn, 6.28319 rad, is accepted: take off whole turns"
        raise refuse(angle, f"{accepted}. {in_degrees(angle)}")
    return angle


def _in_equations(name: str) -> str:
    if not f"_{name}".isidentifier():  # names of the equations' symbols end with it
        raise refuse(name, "a name of letters, digits and _ is accepted, without blanks and signs")
    return name


Angle = Annotated[Number, AfterValidator(_near)]
Turn = Annotated[Number, AfterValidator(_within_a_turn)]  # an angle that a person writes
Count = Annotated[int, Field(strict=True, ge=0, le=10**9)]
Natural = Annotated[int, Field(strict=True, ge=1, le=10**9)]
Flag = Annotated[bool, Field(strict=True)]
Name = Annotated[str, Field(min_length=1)]
PartName = Annotated[Name, AfterValidator(_in_equations)]
T = TypeVar("T")
# A minimum length in pydantic would count wrong items as absent ones.
MOST = 1000  # items of a list; many times what a mechanism has, and as many as are soon checked
Few = Annotated[tuple[T, ...], BeforeValidator(_not_too_many)]
Several = Annotated[Few[T], AfterValidator(not_empty)]


def measured(noun: str, units: str, default: Any = ..., accepts: str | None = None, **more: Any) -> Any:
    """Describe a field that holds a quantity, by the noun and the units that its error messages use."""
    extra = {"units": units} if accepts is None else {"units": units, "accepts": accepts}
    return Field(default, description=noun, json_schema_extra=extra, **more)


def unit(noun: str, units: str) -> Any:
    """Mark a type, in `Annotated`, by the noun and units that its error messages use."""
    return Field(description=noun, json_schema_extra={"units": units})


def accepts(words: str, **more: str) -> Any:
    """Mark a type, in `Annotated`, by the words of its error messages; `more` may be its units."""
    return Field(json_schema_extra={"accepts": words, **more})


# of what has the unit of a parameter, which the mechanism decides
Written = Annotated[
    Number, accepts("a finite number, or a text of one with its unit, such as '900 rpm' or '0.1 mm',")
]


def named(noun: str, default: Any = ...) -> Any:
    """Describe a field that holds a name, by the noun that its error messages use."""
    return Field(default, description=noun, json_schema_extra={"noun": True})
