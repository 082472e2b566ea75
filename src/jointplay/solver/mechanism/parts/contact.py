"""The law of the normal force in a joint with clearance, by its name and numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Annotated, Any, Self

from pydantic import Field, ValidationError, field_validator, model_validator

from jointplay.display.accepted import from_pydantic
from jointplay.display.errors import InputError, unknown
from jointplay.solver.equations.laws import LAWS
from jointplay.solver.mechanism.base import (
    Flag,
    Name,
    NonNegative,
    Number,
    Positive,
    Record,
    is_number,
    measured,
)
from jointplay.solver.mechanism.parts.quantity import checked_numbers

_BESIDE = ("stiffness", "damping")  # numbers of laws that are fields of their own


def place_of(number: str) -> str:
    """Key of a law's number in the record."""
    return number if number in _BESIDE else f"parameters.{number}"


class Contact(Record):
    """The law of the normal force in a joint with clearance, at a penetration u ≥ 0.

    Parameters
    ----------
    law : str
        Name of the law, one of `jointplay.solver.equations.laws.LAWS`: ``kelvin_voigt`` (F_n = K u + C_n
        du/dt), ``hertz``, ``hunt_crossley``, ``flores`` and others.
    stiffness : float, optional
        K, N/m; of a law with a power of u, N/m^n. Needed by laws that have it, and accepted there alone.
    damping : float, optional
        C_n, N s/m; needed by laws that have it, and accepted there alone.
    parameters : dict of str to float
        The law's further numbers by name, where it has any.
    tension : bool
        True: the force may pull just before separation, as the law reads. False: contact ends where the force
        reaches 0.
    """

    law: Annotated[str, Field(json_schema_extra=lambda schema: schema.update(enum=[*LAWS]))] = "kelvin_voigt"
    stiffness: Positive | None = measured("contact stiffness", "N/m", None)
    damping: NonNegative | None = measured("contact damping", "N s/m", None)
    parameters: dict[Name, Number] = Field({})
    tension: Flag = True

    @field_validator("law")
    @classmethod
    def _known(cls, law: str) -> str:
        if law not in LAWS:
            raise InputError([unknown("", law, law, LAWS, "law")])
        return law

    @model_validator(mode="wrap")
    @classmethod
    def _of_the_law(cls, data: Any, handler: Callable[[Any], Self]) -> Self:
        if not isinstance(data, Mapping) or not isinstance(data.get("parameters", {}), Mapping):
            return handler(data)
        law, further = data.get("law", "kelvin_voigt"), data.get("parameters", {})
        given = {key: data.get(key) for key in _BESIDE} | {place_of(name): x for name, x in further.items()}
        values, problems = checked_numbers(law, LAWS, given, place=place_of, units=_per_power(law, further))
        own = {key: values.get(key) for key in _BESIDE}
        own["parameters"] = {name: values[place_of(name)] for name in further if place_of(name) in values}
        try:
            record = handler({**data, **own})
        except ValidationError as error:
            problems = [*from_pydantic(error, cls).problems, *problems]
        if problems:
            raise InputError(problems)
        return record

    @property
    def numbers(self) -> dict[str, float]:
        """Numbers of the law by name, in its order."""
        own = {"stiffness": self.stiffness, "damping": self.damping} | self.parameters
        return {name: own.get(name, each.usual) for name, each in LAWS[self.law].numbers.items()}

    @property
    def coefficients(self) -> dict[str, float]:
        """Coefficients of the law's equations, by letter."""
        law = LAWS[self.law]
        return dict(zip(law.letters, law.coefficients(*self.numbers.values()), strict=True))

    @property
    def description(self) -> str:
        """The law and its numbers, in a few words."""
        units = [each.units for each in LAWS[self.law].numbers.values()]
        numbers = [*self.numbers.items()]
        if self.law == "kelvin_voigt":
            told = (f"{value:g} {unit}" for (_, value), unit in zip(numbers, units, strict=True))
        else:
            told = (
                f"{name} {value:g}" + (f" {unit}" if unit != "1" else "")
                for (name, value), unit in zip(numbers, units, strict=True)
            )
            told = (self.law.replace("_", " "), *told)
        return ", ".join(told) + ("" if self.tension else ", no tension")

    def __hash__(self) -> int:
        return hash((self.law, *self.numbers.values(), self.tension))


def _per_power(law: Any, further: Mapping[str, Any]) -> dict[str, str]:
    """Units of the stiffness of a law with a power of u, N/m^n."""
    numbers = LAWS[law].numbers if isinstance(law, str) and law in LAWS else {}
    power = further.get("exponent", numbers["exponent"].usual) if "exponent" in numbers else None
    return {"stiffness": f"N/m^{power:g}"} if is_number(power) else {}
