"""The law of the normal force in a joint with clearance, by its name and numbers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, Any

from pydantic import Field, ValidationInfo, field_validator

from jointplay.display.errors import NOTHING, InputError, Problem, refuse, unknown
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
from jointplay.solver.mechanism.measures import in_si


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

    law: Annotated[str, Field(json_schema_extra={"enum": [*LAWS]})] = "kelvin_voigt"
    stiffness: Positive | None = measured("contact stiffness", "N/m", None, validate_default=True)
    damping: NonNegative | None = measured("contact damping", "N s/m", None, validate_default=True)
    parameters: dict[Name, Number] = Field({}, validate_default=True)
    tension: Flag = True

    @classmethod
    def _further_units(cls, data: Mapping[str, Any]) -> Mapping[str, Any]:
        law = LAWS.get(data.get("law")) if isinstance(data.get("law"), str) else None
        if law is None or "exponent" not in law.numbers:
            return {}
        given = data.get("parameters")
        power = given.get("exponent") if isinstance(given, Mapping) else None
        power = law.defaults.get("exponent") if power is None else power
        return {"stiffness": f"N/m^{power:g}"} if is_number(power) else {}

    @field_validator("law")
    @classmethod
    def _known(cls, law: str) -> str:
        if law not in LAWS:
            raise InputError([unknown("", law, law, LAWS, "law")])
        return law

    @field_validator("stiffness", "damping")
    @classmethod
    def _of_a_law_that_has_it(cls, value: float | None, info: ValidationInfo) -> float | None:
        law, name = info.data.get("law"), str(info.field_name)  # none: an unknown law is a problem of its own
        if law and value is None and name in LAWS[law].numbers:
            raise refuse(NOTHING, f"law {law} needs a contact {name} {_BOUND[name]}")
        if law and value is not None and name not in LAWS[law].numbers:
            others = (n for n in LAWS[law].numbers if n not in _BOUND or n != name)
            has = ", ".join(n if n in _BOUND else f"parameters.{n}" for n in others)
            raise refuse(value, f"law {law} has no {name}; it has {has}")
        return value

    @field_validator("parameters", mode="before")
    @classmethod
    def _in_their_units(cls, parameters: Any, info: ValidationInfo) -> Any:
        numbers = LAWS[info.data["law"]].numbers if "law" in info.data else {}
        return in_si(parameters, {name: units for name, (_, units) in numbers.items()})

    @field_validator("parameters")
    @classmethod
    def _of_the_law(cls, parameters: dict[str, float], info: ValidationInfo) -> dict[str, float]:
        problems = [*_problems(info.data["law"], parameters)] if info.data.get("law") else []
        if problems:
            raise InputError(problems)
        return parameters

    @property
    def numbers(self) -> dict[str, float]:
        """Numbers of the law by name, in its order."""
        law = LAWS[self.law]
        own = law.defaults | {"stiffness": self.stiffness, "damping": self.damping} | self.parameters
        return {name: own[name] for name in law.numbers}

    @property
    def coefficients(self) -> dict[str, float]:
        """What the law's equations take, by letter."""
        law = LAWS[self.law]
        return dict(zip(law.letters, law.coefficients(*self.numbers.values()), strict=True))

    @property
    def description(self) -> str:
        """The law and its numbers, in a few words."""
        units = [unit for _, unit in LAWS[self.law].numbers.values()]
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


_BOUND = {"stiffness": "greater than 0 N/m", "damping": "of at least 0 N s/m"}


def _problems(name: str, given: dict[str, float]) -> Iterator[Problem]:
    """What is wrong with the further numbers of a law."""
    law = LAWS[name]
    for key in given:
        if key not in law.further:
            yield unknown(key, given[key], key, law.further)
        elif key in law.limits and not law.limits[key][0](given[key]):
            yield Problem(key, given[key], law.limits[key][1])
    for key in law.further:
        if key not in given and key not in law.defaults:
            yield Problem(key, NOTHING, f"a number is needed here, of the law {name}")
