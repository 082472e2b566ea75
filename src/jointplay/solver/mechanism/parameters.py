"""Parameters: numbers of a mechanism that can be others, which all who vary or differentiate them ask.

A parameter is named by a word such as ``clearance``, an alias of key paths (`changes.paths_of`), by a path
itself, as ``joints.B.contact.stiffness``, or by several of either with ``+`` between them, of which the first
has its value and the others change by as much. Those of a system of equations are its own, by their names.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from numbers import Real
from typing import Any

from pydantic.fields import FieldInfo

from jointplay.display.accepted import bounds_of, units_of
from jointplay.display.errors import InputError, Problem, join, unknown
from jointplay.display.number_text import cf_units
from jointplay.solver.equations.friction import FRICTIONS
from jointplay.solver.equations.laws import LAWS
from jointplay.solver.equations.quantity import Quantity
from jointplay.solver.mechanism.base import is_number
from jointplay.solver.mechanism.changes import Changes, paths_of, value_of
from jointplay.solver.mechanism.directions import Directions, along
from jointplay.solver.mechanism.measures import ANY
from jointplay.solver.mechanism.model import Model
from jointplay.solver.mechanism.own.own import CATALOG
from jointplay.solver.mechanism.parts.courses import FORCES
from jointplay.solver.mechanism.paths import below, is_path, part_at, parts_of, steps
from jointplay.solver.mechanism.records import Contact, Friction, Mechanism, TestSystem

NAMED = [name for name, field in Changes.model_fields.items() if "units" in (field.json_schema_extra or ())]
EXAMPLE = "joints.B.contact.stiffness"
INITIAL = "initial."  # before the name of a state at the start, where that is varied like a parameter
# tuples of named records, and what each holds
PARTS = {"joints": "joint", "links": "link", "springs": "spring", "loads": "load", "masses": "point mass"}


@dataclass(frozen=True)
class Parameter:
    """A number of a mechanism that can be another, or several that change by the same amount.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        Whose it is.
    key : str
        Its word or path, or several with ``+`` between them.
    """

    mechanism: Mechanism | TestSystem
    key: str

    @classmethod
    def named(cls, mechanism: Mechanism | TestSystem, key: Any, place: str | None = None) -> Parameter:
        """Find a parameter by its key; `InputError`, whose key is `place`, where there is none."""
        for part in parts_of(key):
            if problem := _problem(mechanism, part, str(key) if place is None else place):
                raise InputError([problem])
        return cls(mechanism, key)

    @classmethod
    def of(cls, mechanism: Mechanism | TestSystem) -> Iterator[Parameter]:
        """Yield all that have a value: of a linkage the ones with words, then by path."""
        keys = [*_own(mechanism)] if isinstance(mechanism, TestSystem) else [*NAMED, *_numbers(mechanism)]
        found = (cls(mechanism, key) for key in keys)
        yield from (each for each in found if is_number(each.value))

    @cached_property
    def paths(self) -> tuple[str, ...]:
        """Paths of its numbers in the mechanism's record; none where a word finds nothing to change."""
        if isinstance(self.mechanism, TestSystem):
            return tuple(f"parameters.{key}" for key in parts_of(self.key))
        each = ((key,) if is_path(key) else paths_of(self.mechanism, key) for key in parts_of(self.key))
        return sum(each, ())

    @cached_property
    def value(self) -> Any:
        """Its present value, SI; None where it has none."""
        first = parts_of(self.key)[0]
        system = isinstance(self.mechanism, TestSystem)
        return self.mechanism.parameters.get(first) if system else value_of(self.mechanism, first)

    @property
    def smooth(self) -> bool:
        """Whether it has a value that can change by little, which a count has not."""
        return is_number(self.value) and not isinstance(self.value, int)

    @property
    def uniform(self) -> bool:
        """Whether all that it stands for has its value, so that setting it changes nothing."""
        linkage = isinstance(self.mechanism, Mechanism)
        return not linkage or self.paths == (self.key,) or self.at(self.value) == self.mechanism

    @cached_property
    def _field(self) -> tuple[FieldInfo | Quantity | None, str, str]:
        """Its declaration, its units, and its noun."""
        first = parts_of(self.key)[0]
        if isinstance(self.mechanism, TestSystem):
            preset = CATALOG.get(self.mechanism.system)
            annotation, _ = preset.fields().get(first, (None, None)) if preset else (None, None)
            field = FieldInfo.from_annotation(annotation) if annotation else None
            return field, self.mechanism.units.get(first, "1"), first.replace("_", " ")
        return _declared(self.mechanism, first)

    @property
    def units(self) -> str:
        """SI units, as ``N/m``; ``1`` of a pure number."""
        return self._field[1]

    @property
    def cf_units(self) -> str:
        """The same units as datasets have them, as ``N m-1``."""
        return cf_units(self.units)

    @property
    def noun(self) -> str:
        """Its noun, as ``contact stiffness of joint B`` or ``mass of the coupler``."""
        return self._field[2]

    @property
    def bounds(self) -> dict[str, float]:
        """Limits by name: ``gt``, ``ge``, ``lt``, ``le``; limits that other numbers set are found by `at`."""
        each = self._field[0]
        if not isinstance(each, Quantity):
            return bounds_of(each) if each else {}
        least = each.above if isinstance(each.above, float) else 0.0
        low = {"gt": least} if each.least is None else {"ge": each.least}
        return low if each.most is None else low | {"le": each.most}

    def at(self, value: float) -> Any:
        """The mechanism with another value; `InputError` where it cannot have that."""
        return self.mechanism.varied({self.key: value})

    def directions(self, assembled: Callable[[Any], Model], **how: Any) -> Directions:
        """Derivatives of the numbers of the equations, start and period that change with it.

        `InputError` where it has none: it can change to one side alone, or changes which equations hold.

        Parameters
        ----------
        assembled : callable
            The model of a mechanism, at its start.
        **how
            As in `along`.
        """
        return along(lambda value: assembled(self.at(value)), float(self.value), self.key, **how)


def declared_units(mechanism: Any, key: Any) -> str:
    """Units of a parameter; any of one that does not exist, or where there is no mechanism to ask."""
    try:
        known = isinstance(mechanism, Mechanism | TestSystem)
        return Parameter.named(mechanism, key).units if known else ANY
    except InputError:
        return ANY


def _own(system: TestSystem) -> list[str]:
    """Parameters of a system of equations that are numbers."""
    return [key for key, value in system.parameters.items() if not isinstance(value, bool)]


def _problem(mechanism: Mechanism | TestSystem, key: Any, place: str) -> Problem | None:
    """The problem of a key that names no number."""
    if isinstance(mechanism, TestSystem):
        known = _own(mechanism)
        return None if key in known else unknown(place, key, key, known, "parameter")
    if not is_path(key):
        loose = [f"joints.{joint.name}.clearance" for joint in mechanism.clearance_joints]
        words = {"clearance": loose} if len(loose) > 1 else {}  # the word alone makes the others ideal
        real = (name for name in NAMED if _is_real(value_of(mechanism, name)))
        known = [key for name in real for key in words.get(name, [name])]
        known.append(f"a path such as {EXAMPLE}")
        return None if key in NAMED else unknown(place, key, key, known, "parameter")
    number, problem = part_at(mechanism, key, place)
    if problem or number is None or _is_real(number):
        return problem
    return Problem(place, key, "the path to a number is accepted")


def _is_real(value: Any) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool)


def _numbers(record: Any, place: str = "") -> Iterator[str]:
    """Paths of all numbers of a record, and of its parts, these by name where they have one."""
    for name, part in below(record).items():
        path = join(place, name)
        if name.startswith("[") and getattr(part, "name", None):
            continue  # it has come by its name
        if is_path(path) and _is_real(part):
            yield path
        yield from _numbers(part, path)


def _declared(mechanism: Mechanism, key: str) -> tuple[FieldInfo | Quantity | None, str, str]:
    """Field or law's quantity, units and noun of a number of a linkage."""
    *path, last = steps(re.sub(r"\[\d+\]$", "", key))
    record, own = mechanism, "1"
    units = mechanism._further_units(dict(mechanism)).get(path[0], {}) if path else {}
    numbers: Mapping[str, Quantity] = {}
    whose = ""
    for above, step in zip(["", *path], path, strict=False):
        record = below(record)[step]
        whose = f" of {_called(PARTS[above], record.name or step)}{whose}" if above in PARTS else whose
        if laws := {Contact: LAWS, Friction: FRICTIONS}.get(type(record)):
            numbers = laws[record.law].numbers
        own = getattr(record, "units", own)
    field = getattr(type(record) if path else Changes, "model_fields", {}).get(last)
    what, about, axis = (getattr(field, "description", None) or last.replace("_", " ")).partition(" about ")
    noun = what + whose + about + axis
    if last in numbers:
        return numbers[last], numbers[last].units, noun
    declared = (field and units_of(field)) or "1"
    return field, units.get(last, own if declared == FORCES else declared), noun


def _called(what: str, name: str) -> str:
    """A part by its name: the coupler, joint B, load press."""
    thing = what in (PARTS["links"], PARTS["masses"]) and re.fullmatch("[a-z]{2,}", name)
    return f"the {name}" if thing else f"{what} {name.strip('[]')}"
