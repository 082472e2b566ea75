"""What every record shares: frozen, no unknown keys, strict finite numbers, errors that list everything."""

from __future__ import annotations

import re
from typing import Annotated, Any, ClassVar, Self, TypeVar

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError

from jointplay.errors import from_pydantic, refuse

GROUND = "ground"  # the name of the fixed frame, where a link's name is asked


class Record(BaseModel):
    """A validated, frozen description; wrong input raises `jointplay.errors.InputError`."""

    model_config = ConfigDict(frozen=True, extra="forbid")
    root: ClassVar[str | None] = None  # how the keys in its errors begin; None: by the name of the class

    def __init__(self, **data: Any) -> None:
        try:
            super().__init__(**data)
        except ValidationError as error:
            raise from_pydantic(error, type(self), self._root()) from None

    @classmethod
    def model_validate(cls, obj: Any, **options: Any) -> Self:
        """Build the record from a mapping of its keys; wrong input raises `InputError`."""
        try:
            return super().model_validate(obj, **options)
        except ValidationError as error:
            raise from_pydantic(error, cls, cls._root()) from None

    @classmethod
    def _root(cls) -> str:
        return re.sub(r"(?<=[a-z])(?=[A-Z])", "_", cls.__name__).lower() if cls.root is None else cls.root


def _not_empty(items: tuple[Any, ...]) -> tuple[Any, ...]:
    if not items:
        raise refuse(items, "a list of at least one is accepted")
    return items


_STRICT = Field(strict=True, allow_inf_nan=False)
Number = Annotated[float, _STRICT]
Positive = Annotated[float, _STRICT, Field(gt=0)]
NonNegative = Annotated[float, _STRICT, Field(ge=0)]
Fraction = Annotated[float, _STRICT, Field(gt=0, le=1)]
Flag = Annotated[bool, Field(strict=True)]
Name = Annotated[str, Field(min_length=1)]
T = TypeVar("T")
# A minimum length in pydantic would count wrong items as absent ones.
Several = Annotated[tuple[T, ...], AfterValidator(_not_empty)]


def measured(noun: str, units: str, default: Any = ..., **more: Any) -> Any:
    """Describe a field that holds a quantity, by the noun and the units that its error messages use."""
    return Field(default, description=noun, json_schema_extra={"units": units}, **more)


def named(noun: str, default: Any = ...) -> Any:
    """Describe a field that holds a name."""
    return Field(default, description=noun, json_schema_extra={"noun": True})
