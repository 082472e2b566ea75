"""The record of a joint's friction: a law of `equations.friction` by name, and the numbers that it takes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Annotated, Any, Self

from pydantic import ConfigDict, Field, field_validator, model_validator

from jointplay.display.number_text import plain
from jointplay.display.units import measure
from jointplay.solver.equations.friction import FRICTIONS
from jointplay.solver.mechanism.base import NonNegative, Record, measured
from jointplay.solver.mechanism.parts.quantity import checked_numbers, known_law, made_of


def _with_numbers(schema: dict[str, Any]) -> None:
    """Add to the JSON schema the numbers that laws take besides the record's own fields."""
    for law in FRICTIONS.values():
        for name, each in law.numbers.items():
            about = {"type": "number", "units": each.units, "title": name.replace("_", " ").capitalize()}
            schema["properties"].setdefault(name, about)
    schema["additionalProperties"] = False


class Friction(Record):
    """The law of the tangential force in a joint with clearance, one of `equations.friction`.

    Every further number of a law is a key beside these, and an attribute: ``velocity`` (v_0, m/s) of the
    regularised laws; ``full_velocity`` (v_1, m/s) of ``ambrosio``; ``static_coefficient`` (f_s) of
    ``andersson``, ``brown_mcphee`` and ``stribeck``; ``stribeck_velocity`` (v_s, m/s) and ``exponent``
    (delta; 2 if left out) of ``andersson``, ``stribeck`` and ``lugre``; ``bristle_stiffness`` (1/m) and
    ``bristle_damping`` (s/m; 0 if left out) of ``lugre``, both of the coefficient.

    Parameters
    ----------
    law : str
        Name of the law: with true sticking ``coulomb`` (if left out) or ``stribeck``; regularised ``tanh``,
        ``ramp``, ``ambrosio``, ``threlfall``, ``andersson``, ``brown_mcphee``; of bristles ``lugre``.
    coefficient : float
        f, dimensionless; the kinetic coefficient where the law has a static one too.
    viscous : float
        C_t, N s/m.
    """

    model_config = ConfigDict(extra="allow", json_schema_extra=_with_numbers)
    law: Annotated[str, Field(json_schema_extra=lambda schema: schema.update(enum=[*FRICTIONS]))] = "coulomb"
    coefficient: NonNegative = measured("friction coefficient", "1")
    viscous: NonNegative = measured("viscous friction", "N s/m", 0.0)

    @field_validator("law")
    @classmethod
    def _known(cls, law: str) -> str:
        return known_law(law, FRICTIONS, "friction law")

    @model_validator(mode="wrap")
    @classmethod
    def _of_the_law(cls, data: Any, handler: Callable[[Any], Self]) -> Self:
        if not isinstance(data, Mapping):
            return handler(data)
        fields = {name: value for name, value in data.items() if name in cls.model_fields}
        given = {name: value for name, value in data.items() if name not in fields}
        beside = dict.fromkeys(cls.model_fields) | fields
        own, problems = checked_numbers(data.get("law", "coulomb"), FRICTIONS, given, beside)
        return made_of(cls, handler, fields | own, problems)

    @property
    def numbers(self) -> dict[str, float]:
        """Numbers of the law besides coefficient and viscous part, by name."""
        return {name: getattr(self, name) for name in FRICTIONS[self.law].numbers}

    @property
    def parameters(self) -> dict[str, float]:
        """Parameters of the equations, by letter."""
        law = FRICTIONS[self.law]
        values = dict(zip(law.letters, (self.coefficient, *self.numbers.values()), strict=True))
        return {"v": 0.0, "Ct": self.viscous} | values

    @property
    def rubs(self) -> bool:
        """Whether a coefficient is more than 0, so that the law gives any force."""
        static = self.numbers.get("static_coefficient", 0.0)
        return max(self.coefficient, static) > 0

    @property
    def description(self) -> str:
        """Law and numbers in a few words; of Coulomb's law the coefficient."""
        units = {name: each.units for name, each in FRICTIONS[self.law].numbers.items()}
        told = [f"{n.replace('_', ' ')} {measure(x, units[n])}" for n, x in self.numbers.items()]
        law = "" if self.law == "coulomb" else f" ({', '.join([self.law, *told])})"
        return f"{plain(self.coefficient)}{law}"


FRICTIONLESS = Friction(coefficient=0.0)
