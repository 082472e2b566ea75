"""Axes of a sweep: parameters (`mechanism.parameters`) with the values that each is to have."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from numbers import Real
from typing import Any

import numpy as np

from jointplay.analysis.quantities import WORDS
from jointplay.display.errors import InputError, Problem, join, raise_any, refuse
from jointplay.solver.mechanism.base import is_number
from jointplay.solver.mechanism.parameters import Parameter
from jointplay.solver.mechanism.paths import parts_of, steps
from jointplay.solver.mechanism.records import Mechanism, TestSystem

TAKEN = {*WORDS, "direction", "start", "point", "link", "joint", "pin", "state", "exponent", "period"}


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
        """Coordinate of the axis, along itself."""
        return self.name, np.array(self.values, dtype=float), self.attributes


def largest(mechanism: Mechanism | TestSystem, over: Mapping[str, Sequence[float]]) -> Mechanism | TestSystem:
    """The mechanism with the largest values, by which keywords are checked; as given if that cannot be."""
    try:
        return mechanism.varied({key: max(values) for key, values in over.items()})
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
    """Check the parameters to vary, with their values.

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
    raise_any([*problems, *repeated(given, root)])
    return checked_axes(mechanism, given)


def repeated(keys: Iterable[Any], root: str) -> Iterator[Problem]:
    """Yield a problem for each key with a parameter that is in others too, or in it twice."""
    parts = [part for key in keys for part in parts_of(key)]
    twice = (key for key in keys if any(parts.count(part) > 1 for part in parts_of(key)))
    yield from (Problem(join(root, str(key)), key, "each parameter once is accepted") for key in twice)


def checked_axes(mechanism: Mechanism | TestSystem, given: Mapping[str, Sequence[float]]) -> tuple[Axis, ...]:
    """Axes of values that were checked before, and may repeat; parameters as in `axes`."""
    each = (Parameter(mechanism, key) for key in given)
    return tuple(
        Axis(one.key, name, tuple(sorted(given[one.key])), one.cf_units, one.noun)
        for name, one in zip(_names(list(given)), each, strict=True)
    )


def _axis_problems(mechanism: Any, key: Any, values: Any, root: str) -> Iterator[Problem]:
    place = join(root, str(key))
    try:
        parameter = Parameter.named(mechanism, key, place)
    except InputError as error:
        yield from error.problems
        return
    if not isinstance(values, list | tuple | range) or not values:
        yield Problem(place, values, "a list of at least one number is accepted")
    else:
        before: set[Real] = set()
        for i, value in enumerate(values):
            yield from _value_problems(parameter, value, f"{place}[{i}]", before)


def _value_problems(parameter: Parameter, value: Any, place: str, before: set[Real]) -> Iterator[Problem]:
    """Problems of a value; it is added to `before`, the numbers that precede it in its list."""
    if not is_number(value):
        yield Problem(place, value, "a finite number is accepted")
    elif value in before:
        yield Problem(place, value, "a value that is not in the list already is accepted")
    else:
        before.add(value)
        try:
            parameter.at(value)
        except InputError as error:
            yield from (Problem(place, value, each.expected) for each in error.problems)


def _names(keys: Sequence[str]) -> list[str]:
    """Names of dimensions: the last part of each key, where that is not taken; else the whole path."""
    keys = [parts_of(key)[0] for key in keys]  # of several that change alike the first
    whole = ["_".join(step.strip("[]") for step in steps(key)) for key in keys]
    last = [name if key.endswith("]") else steps(key)[-1] for name, key in zip(whole, keys, strict=True)]
    return [
        short if last.count(short) == 1 and short not in TAKEN else name
        for short, name in zip(last, whole, strict=True)
    ]
