"""Parameters that a sweep varies: numbers of a mechanism by name or by key path, and their axes."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from numbers import Real
from typing import Any

import numpy as np

from jointplay.analysis.quantities import WORDS
from jointplay.display.errors import InputError, Problem, join, refuse, unknown
from jointplay.solver.equations.friction import FRICTIONS
from jointplay.solver.equations.laws import LAWS
from jointplay.solver.mechanism.base import is_number
from jointplay.solver.mechanism.changes import Changes
from jointplay.solver.mechanism.parts.courses import FORCES
from jointplay.solver.mechanism.paths import below, is_path, part_at, steps
from jointplay.solver.mechanism.records import Contact, Friction, Mechanism, TestSystem

NUMBERS = [name for name, field in Changes.model_fields.items() if "units" in (field.json_schema_extra or ())]
EXAMPLE = "joints.B.contact.stiffness"
# tuples of named records, and what each holds
PARTS = {"joints": "joint", "links": "link", "springs": "spring", "loads": "load"}
TAKEN = {*WORDS, "direction", "start", "point", "link", "joint", "pin", "state", "exponent", "period"}
_POWERS = str.maketrans("²³⁴", "234")


@dataclass(frozen=True)
class Axis:
    """A varied parameter.

    Parameters
    ----------
    key : str
        Its name or key path.
    name : str
        Its dimension in a dataset.
    values : tuple of float
        Ascending, SI units.
    units, long_name : str
        As in a dataset.
    """

    key: str
    name: str
    values: tuple[float, ...]
    units: str
    long_name: str

    @property
    def attributes(self) -> dict[str, str]:
        """Attributes of its coordinate."""
        return {"units": self.units, "long_name": self.long_name, "key": self.key}

    @property
    def coordinate(self) -> tuple[str, np.ndarray, dict[str, str]]:
        """Its coordinate, along itself."""
        return self.name, np.array(self.values, dtype=float), self.attributes


def changed(mechanism: Mechanism | TestSystem, changes: Mapping[str, Any]) -> Mechanism | TestSystem:
    """Give a changed, validated copy of a mechanism.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        Stays as it is.
    changes : mapping of str to object
        As the record's `replace` takes them, of a linkage by key path too: ``joints.B.contact.stiffness``,
        ``links.coupler.mass``, ``drive.rated_torque``. Only the number named changes: a link that becomes
        longer keeps its mass centre.

    Raises
    ------
    InputError
        Listing every key that does not exist, or what is wrong with the values.
    """
    return mechanism.varied(changes) if changes else mechanism


def largest(mechanism: Mechanism | TestSystem, over: Mapping[str, Sequence[float]]) -> Mechanism | TestSystem:
    """The mechanism with the largest values, by which keywords are checked; as given if that cannot be."""
    try:
        return changed(mechanism, {key: max(values) for key, values in over.items()}) if over else mechanism
    except InputError:
        return mechanism


def at_largest(mechanism: Mechanism | TestSystem, over: Any) -> Mechanism | TestSystem:
    """The mechanism with the largest values, by which the rest is judged; wrong values are refused."""
    try:
        most = {key: [max(values)] for key, values in over.items()}
    except (TypeError, ValueError):
        raise refuse(over, "lists of numbers are accepted", "over") from None
    axes(mechanism, most)
    return largest(mechanism, over)


def axes(mechanism: Mechanism | TestSystem, over: Any, root: str = "over") -> tuple[Axis, ...]:
    """Check what is to be varied.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        What it is varied of.
    over : mapping of str to sequence of float
        Values of each parameter, in any order.
    root : str
        How the keys of errors begin.

    Returns
    -------
    tuple of Axis
        In the order given. Each value by itself makes a mechanism; values together may still not.

    Raises
    ------
    InputError
        Listing every parameter that does not exist and every value that it cannot have.
    """
    if not isinstance(over, Mapping) or not over:
        raise refuse(over, "a table of parameters, each with its list of values, is accepted", root)
    given = {key: values.tolist() if hasattr(values, "tolist") else values for key, values in over.items()}
    problems = [p for key, values in given.items() for p in _axis_problems(mechanism, key, values, root)]
    if problems:
        raise InputError(problems)
    return checked_axes(mechanism, given)


def checked_axes(mechanism: Mechanism | TestSystem, given: Mapping[str, Sequence[float]]) -> tuple[Axis, ...]:
    """Axes of values that were checked before, and may repeat; parameters as in `axes`."""
    return tuple(
        Axis(key, name, tuple(sorted(values)), *_described(mechanism, key))
        for name, (key, values) in zip(_names(list(given)), given.items(), strict=True)
    )


def _is_path(mechanism: Any, key: Any) -> bool:
    return isinstance(mechanism, Mechanism) and is_path(key)


def _axis_problems(mechanism: Any, key: Any, values: Any, root: str) -> Iterator[Problem]:
    place = join(root, str(key))
    if problems := list(_key_problems(mechanism, key, place)):
        yield from problems
    elif not isinstance(values, list | tuple | range) or not values:
        yield Problem(place, values, "a list of at least one number is accepted")
    else:
        before: set[Real] = set()
        for i, value in enumerate(values):
            yield from _value_problems(mechanism, key, value, f"{place}[{i}]", before)


def _value_problems(mechanism: Any, key: str, value: Any, place: str, before: set[Real]) -> Iterator[Problem]:
    """Problems of a value; it is added to `before`, the numbers that precede it in its list."""
    if not is_number(value):
        yield Problem(place, value, "a finite number is accepted")
    elif value in before:
        yield Problem(place, value, "a value that is not in the list already is accepted")
    else:
        before.add(value)
        try:
            changed(mechanism, {key: value})
        except InputError as error:
            yield from (Problem(place, value, each.expected) for each in error.problems)


def _key_problems(mechanism: Any, key: Any, place: str) -> Iterator[Problem]:
    if _is_path(mechanism, key):
        yield from _path_problems(mechanism, key, place)
        return
    known, also = NUMBERS, (f"a path such as {EXAMPLE}",)
    if isinstance(mechanism, TestSystem):
        known, also = [k for k, value in mechanism.parameters.items() if not isinstance(value, bool)], ()
    if key not in known:
        yield unknown(place, key, key, (*known, *also), "parameter")


def _path_problems(mechanism: Mechanism, key: str, place: str) -> Iterator[Problem]:
    """Problem of a key path that leads to no number of the record."""
    number, problem = part_at(mechanism, key, place)
    if problem:
        yield problem
    elif number is not None and (not isinstance(number, Real) or isinstance(number, bool)):
        yield Problem(place, key, "the path to a number is accepted")


def _names(keys: Sequence[str]) -> list[str]:
    """Names of dimensions: the last part of each key, where that is not taken; else the whole path."""
    whole = ["_".join(step.strip("[]") for step in steps(key)) for key in keys]
    last = [name if key.endswith("]") else steps(key)[-1] for name, key in zip(whole, keys, strict=True)]
    return [
        short if last.count(short) == 1 and short not in TAKEN else name
        for short, name in zip(last, whole, strict=True)
    ]


def units_of(mechanism: Any, key: Any) -> str | None:
    """Units of a parameter as its record declares them; None of one that does not exist."""
    known = not any(True for _ in _key_problems(mechanism, key, ""))
    return _declared(mechanism, key)[0] if known else None


def _described(mechanism: Any, key: str) -> tuple[str, str]:
    """Units and long name of a parameter, as in a dataset."""
    units, name = _declared(mechanism, key)
    return cf_units(units), name


def _declared(mechanism: Any, key: str) -> tuple[str, str]:
    """Units and long name of a parameter, from its record's field."""
    if isinstance(mechanism, TestSystem):
        return mechanism.units.get(key, "1"), key.replace("_", " ")
    *path, last = steps(re.sub(r"\[\d+\]$", "", key))
    record, law, own = mechanism, {}, "1"
    for step in path:
        record = below(record)[step]
        if laws := {Contact: LAWS, Friction: FRICTIONS}.get(type(record)):
            law = {name: each.units for name, each in laws[record.law].numbers.items()}
        own = getattr(record, "units", own)
    field = getattr(type(record) if path else Changes, "model_fields", {}).get(last)
    of_part = path and path[0] in PARTS
    whose = f" of {PARTS[path[0]]} {below(getattr(mechanism, path[0]))[path[1]].name}" if of_part else ""
    units = (getattr(field, "json_schema_extra", None) or {}).get("units", "1")
    units = law.get(last, own if units == FORCES else units)
    return units, (getattr(field, "description", None) or last.replace("_", " ")) + whose


def cf_units(units: str) -> str:
    """Units of the records (``N/m``, ``kg m²``) as those of datasets (``N m-1``, ``kg m2``)."""
    above, _, below = units.translate(_POWERS).partition("/")
    lowered = (
        re.sub(r"^(\D+)(\d*)$", r"\1-\2", unit) + "1" * unit.isalpha() for unit in below.strip("()").split()
    )
    return " ".join([above, *lowered])
