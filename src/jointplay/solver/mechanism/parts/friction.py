"""The record of a joint's friction: a law of `equations.friction` by name, and the numbers that it takes.

Numbers given to a law of force, checked and completed by the law's description of each.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Annotated, Any, Self, TypeVar

from pydantic import AfterValidator, ConfigDict, Field, ValidationError, model_validator

from jointplay.display.accepted import article, from_pydantic
from jointplay.display.errors import NOTHING, InputError, Problem, raise_any, strangers, unknown
from jointplay.display.number_text import measure, plain, typed
from jointplay.solver.equations.friction import FRICTIONS
from jointplay.solver.equations.quantity import ForceLaw, Quantity
from jointplay.solver.mechanism.base import NonNegative, Record, is_number, measured
from jointplay.solver.mechanism.measures import in_si

R = TypeVar("R", bound=Record)


def _with_numbers(schema: dict[str, Any]) -> None:
    """Add to the JSON schema the numbers that laws take besides the record's own fields."""
    for law in FRICTIONS.values():
        for name, each in law.numbers.items():
            about = {"type": "number", "units": each.units, "title": name.replace("_", " ").capitalize()}
            schema["properties"].setdefault(name, about)
    schema["additionalProperties"] = False


def law_of(laws: Mapping[str, ForceLaw], kind: str) -> Any:
    """The type of a law's name: refused where there is no such law of its kind; a schema lists them."""

    def known(law: str) -> str:
        raise_any(strangers([("", law)], laws, kind))
        return law

    listed = Field(json_schema_extra=lambda schema: schema.update(enum=[*laws]))
    return Annotated[str, AfterValidator(known), listed]


FrictionLaw = law_of(FRICTIONS, "friction law")


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
    law: FrictionLaw = "coulomb"
    coefficient: NonNegative = measured("friction coefficient", "1")
    viscous: NonNegative = measured("viscous friction", "N s/m", 0.0)

    @model_validator(mode="wrap")
    @classmethod
    def _of_the_law(cls, data: Any, handler: Callable[[Any], Self]) -> Self:
        if not isinstance(data, Mapping):
            return handler(data)
        fields = {name: value for name, value in data.items() if name in cls.model_fields}
        given = {name: value for name, value in data.items() if name not in fields}
        others = dict.fromkeys(cls.model_fields) | fields
        own, problems = checked_numbers(data.get("law", "coulomb"), FRICTIONS, given, others)
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
        return max(self.coefficient, self.numbers.get("static_coefficient", 0.0)) > 0

    @property
    def description(self) -> str:
        """Law and numbers in a few words; of Coulomb's law the coefficient."""
        units = {name: each.units for name, each in FRICTIONS[self.law].numbers.items()}
        texts = [f"{n.replace('_', ' ')} {measure(x, units[n])}" for n, x in self.numbers.items()]
        law = "" if self.law == "coulomb" else f" ({', '.join([self.law, *texts])})"
        return f"{plain(self.coefficient)}{law}"


def made_of(record: type[R], handler: Callable[[Any], R], data: Any, problems: list[Problem]) -> R:
    """The record that pydantic makes of data; refused with its own problems first, and those of its law."""
    try:
        made = handler(data)
    except ValidationError as error:
        keys = {problem.key for problem in problems}  # what the law refuses is missing from the data
        own = from_pydantic(error, record).problems
        problems = [*(problem for problem in own if problem.key not in keys), *problems]
    raise_any(problems)
    return made


def checked_numbers(
    name: Any,
    laws: Mapping[str, ForceLaw],
    given: Mapping[str, Any],
    others: Mapping[str, Any] = {},
    place: Callable[[str], str] = str,
    units: Mapping[str, str] = {},
) -> tuple[dict[str, Any], list[Problem]]:
    """Numbers of a law in SI units, and all that is wrong with them.

    Parameters
    ----------
    name : object
        The law's name. Of an unknown law only names that no law has are wrong, and the numbers stay as given.
    laws : mapping of str to ForceLaw
        The laws of its kind.
    given : mapping of str to object
        What is given, by key of the record; None counts as not given.
    others : mapping of str to object
        What is given of keys of the record that every law has.
    place : callable
        Key of a number in the record, of the law's name for it.
    units : mapping of str to str
        Units of numbers, by key, that differ from the law's.

    Returns
    -------
    values : dict of str to float
        Those of the law that are right, by key, with usual ones where none are given.
    problems : list of Problem
    """
    given = {key: value for key, value in given.items() if value is not None}
    law = laws.get(name) if isinstance(name, str) else None
    own = {place(number): each for number, each in law.numbers.items()} if law else {}
    values, problems = dict(given) if law is None else {}, []
    for key, value in given.items():
        having = [other for other, each in laws.items() if key in map(place, each.numbers)]
        if key not in own and not having:
            problems.append(unknown(key, value, key, (*others, *own)))
        elif key not in own and law:
            known = ", ".join((*others, *own))
            accepted = f"accepted only with law = {' or '.join(map(repr, having))}; {name} has {known}"
            problems.append(Problem(key, value, accepted))
    for key, each in own.items():
        unit, bound = units.get(key, each.units), (others | given).get(each.above)
        try:
            value = in_si(given.get(key, each.usual), unit)
        except InputError as error:
            problems += error.under(key).problems
            continue
        if _within(each, value, bound):
            values[key] = float(value)
        else:
            noun = key.rpartition(".")[2].replace("_", " ")
            accepted = f"{article(noun)} {noun} {bounds(each, unit, bound)}"
            given_here = NOTHING if value is None else value
            problems.append(Problem(key, given_here, f"{accepted} of law {name} is accepted"))
    return values, problems


def _within(each: Quantity, value: Any, bound: Any) -> bool:
    if not is_number(value) or not (value > _lowest(each) if each.least is None else value >= each.least):
        return False
    beyond = is_number(bound) and (value < bound or (value == bound and not each.or_equal))
    return not beyond and (each.most is None or value <= each.most)


def _lowest(each: Quantity) -> float:
    return 0.0 if isinstance(each.above, str) else each.above


def bounds(each: Quantity, unit: str, bound: Any = None) -> str:
    """Accepted values of a number, as ``greater than 0 m/s``; `bound`: the value that it must exceed."""
    unit = "" if unit == "1" else f" {unit}"
    words = [
        f"greater than {typed(_lowest(each))}" if each.least is None else f"of at least {typed(each.least)}"
    ]
    words += [f"at most {typed(each.most)}"] if each.most is not None else []
    text = f"{' and '.join(words)}{unit}"
    if not isinstance(each.above, str):
        return text
    value = f" ({typed(bound)}{unit})" if is_number(bound) else ""
    return f"{text} and {'not below' if each.or_equal else 'above'} the {each.above.replace('_', ' ')}{value}"


FRICTIONLESS = Friction(coefficient=0.0)
